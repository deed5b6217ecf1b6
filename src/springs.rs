//! Axial springs: what a bond and a truss have in common, K = k n⊗n,
//! Qian et al. (2021), eqs. (19) and (20).

/// Springs between pairs of nodes, with the axial stiffness of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Springs {
    /// The two nodes, in one numbering of finite-element nodes and material points.
    pub ends: Vec<[u32; 2]>,
    /// k [N/m].
    pub stiffness: Vec<f64>,
}

impl Springs {
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The same springs, those that are not intact without stiffness.
    pub fn with(&self, intact: &[bool]) -> Springs {
        let stiffness = self.stiffness.iter().zip(intact);
        Springs {
            ends: self.ends.clone(),
            stiffness: stiffness
                .map(|(&k, &intact)| if intact { k } else { 0.0 })
                .collect(),
        }
    }

    pub fn push(&mut self, ends: [u32; 2], stiffness: f64) {
        self.ends.push(ends);
        self.stiffness.push(stiffness);
    }

    pub fn append(&mut self, mut other: Springs) {
        self.ends.append(&mut other.ends);
        self.stiffness.append(&mut other.stiffness);
    }
}

/// Length ξ [m] and direction n of a spring.
pub fn axis(ends: [u32; 2], positions: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let [a, b] = ends.map(|i| positions[i as usize]);
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy);
    (length, [dx / length, dy / length])
}

/// Stretch s = n·(u_b − u_a)/ξ for small displacements [-].
pub fn stretch(ends: [u32; 2], positions: &[[f64; 2]], displacement: &[[f64; 2]]) -> f64 {
    let (length, n) = axis(ends, positions);
    let [ua, ub] = ends.map(|i| displacement[i as usize]);
    (n[0] * (ub[0] - ua[0]) + n[1] * (ub[1] - ua[1])) / length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretch_under_uniform_strain_is_n_epsilon_n() {
        let positions = [[0.1, 0.2], [0.4, 0.6]];
        let (xx, yy, xy) = (1e-3, -2e-3, 0.5e-3);
        let u = positions.map(|[x, y]| [xx * x + xy * y, xy * x + yy * y]);
        let (length, n) = axis([0, 1], &positions);
        let expected = xx * n[0] * n[0] + yy * n[1] * n[1] + 2.0 * xy * n[0] * n[1];
        assert!((length - 0.5).abs() < 1e-16);
        // Differences of displacements of 1e-3 over a length of 0.5.
        assert!((stretch([0, 1], &positions, &u) - expected).abs() < 1e-17);
    }
}
