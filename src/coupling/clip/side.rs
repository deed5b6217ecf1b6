//! Sides of a peridynamic region's outline, and their averages over a strip.
//!
//! An average over the strip's width is (1/w) ∫ f dη along the side. Position and shape functions are
//! polynomials in the side's own coordinate t ∈ [0, 1], straight or curved, and three Gauss points
//! integrate them exactly.

/// The directions of a family of bonds: along n, and across it, counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub n: [f64; 2],
}

impl Frame {
    /// n⊥.
    pub fn perpendicular(&self) -> [f64; 2] {
        [-self.n[1], self.n[0]]
    }

    /// ℓ = n·x [m].
    pub fn along(&self, x: [f64; 2]) -> f64 {
        self.n[0] * x[0] + self.n[1] * x[1]
    }

    /// η = n⊥·x [m].
    pub fn across(&self, x: [f64; 2]) -> f64 {
        self.n[0] * x[1] - self.n[1] * x[0]
    }

    /// The point with the coordinates ℓ and η [m].
    pub fn point(&self, along: f64, across: f64) -> [f64; 2] {
        let p = self.perpendicular();
        [0, 1].map(|k| self.n[k] * along + p[k] * across)
    }
}

/// A side of the outline, along the lattice's axes; the region lies on its left.
#[derive(Clone, Debug)]
pub struct Side {
    pub ends: [[f64; 2]; 2],
    pub middle: Option<[f64; 2]>,
    /// The finite-element nodes at the ends and the middle; empty on a free side.
    pub nodes: Vec<u32>,
}

/// A piece of a side along which η changes in one sense.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    pub side: usize,
    /// The piece of t.
    span: [f64; 2],
    /// The least and the largest η [m].
    pub range: [f64; 2],
    /// Whether a line in the direction n enters the region here.
    pub enters: bool,
    pub is_free: bool,
}

/// The average of a side over a strip.
#[derive(Clone, Debug, Default)]
pub struct Average {
    /// The mean of ℓ [m].
    pub along: f64,
    /// The mean of N_a by node.
    pub shares: Vec<(u32, f64)>,
}

/// Abscissae on [0, 1] and weights.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

impl Side {
    pub fn is_free(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Shape functions of the ends and the middle.
    pub fn shape(&self, t: f64) -> [f64; 3] {
        match self.middle {
            None => [1.0 - t, t, 0.0],
            Some(_) => [
                (1.0 - t) * (1.0 - 2.0 * t),
                t * (2.0 * t - 1.0),
                4.0 * t * (1.0 - t),
            ],
        }
    }

    pub fn position(&self, t: f64) -> [f64; 2] {
        let n = self.shape(t);
        let middle = self.middle.unwrap_or_default();
        [0, 1].map(|k| n[0] * self.ends[0][k] + n[1] * self.ends[1][k] + n[2] * middle[k])
    }

    /// dx/dt [m].
    pub fn tangent(&self, t: f64) -> [f64; 2] {
        let [a, b] = self.ends;
        let Some(middle) = self.middle else {
            return [0, 1].map(|k| b[k] - a[k]);
        };
        let slopes = [4.0 * t - 3.0, 4.0 * t - 1.0, 4.0 - 8.0 * t];
        [0, 1].map(|k| slopes[0] * a[k] + slopes[1] * b[k] + slopes[2] * middle[k])
    }

    /// Gauss points of a piece in t, with their weights.
    pub fn gauss(&self, [from, to]: [f64; 2]) -> [(f64, f64); 3] {
        GAUSS.map(|(abscissa, weight)| (from + abscissa * (to - from), weight * (to - from)))
    }

    /// The least and the largest coordinate along an axis that the side may reach [m].
    pub fn bounds(&self, axis: usize) -> [f64; 2] {
        let points = || self.ends.iter().chain(&self.middle).map(|x| x[axis]);
        let (low, high) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        // A parabola through three points leaves their range by less than its width.
        let rest = if self.middle.is_some() {
            high - low
        } else {
            0.0
        };
        [low - rest, high + rest]
    }

    /// The parameter of the place nearest to a position, and its distance [m].
    pub fn foot(&self, x: [f64; 2]) -> (f64, f64) {
        let distance = |t: f64| {
            let at = self.position(t);
            (at[0] - x[0]).hypot(at[1] - x[1])
        };
        let steps = if self.middle.is_some() { 8 } else { 1 };
        let start = (0..=steps).map(|k| f64::from(k) / f64::from(steps));
        let mut t = start
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap_or(0.0);
        for _ in 0..20 {
            let (at, slope) = (self.position(t), self.tangent(t));
            let along = slope[0] * (x[0] - at[0]) + slope[1] * (x[1] - at[1]);
            let next = (t + along / (slope[0] * slope[0] + slope[1] * slope[1])).clamp(0.0, 1.0);
            if next == t {
                break;
            }
            t = next;
        }
        (t, distance(t))
    }

    /// η(t) = c + b t + a t².
    fn polynomial(&self, frame: &Frame) -> [f64; 3] {
        let [first, last] = self.ends.map(|x| frame.across(x));
        match self.middle.map(|x| frame.across(x)) {
            None => [first, last - first, 0.0],
            Some(middle) => [
                first,
                4.0 * middle - 3.0 * first - last,
                2.0 * (first + last) - 4.0 * middle,
            ],
        }
    }

    /// The pieces of the side, number `side` of the outline. Those that stay within `least` [m] of one
    /// η are left out: lines do not cross them.
    pub fn arcs(&self, side: usize, frame: &Frame, least: f64) -> Vec<Arc> {
        let [_, b, a] = self.polynomial(frame);
        let turn = -b / (2.0 * a);
        let mut cuts = vec![0.0, 1.0];
        if turn > 0.0 && turn < 1.0 {
            cuts.insert(1, turn);
        }
        let eta = |t: f64| frame.across(self.position(t));
        let arcs = cuts.windows(2).map(|span| {
            let [from, to] = [eta(span[0]), eta(span[1])];
            Arc {
                side,
                span: [span[0], span[1]],
                range: [from.min(to), from.max(to)],
                enters: to < from,
                is_free: self.is_free(),
            }
        });
        arcs.filter(|arc| arc.range[1] - arc.range[0] > least)
            .collect()
    }

    /// The parameter t of the arc at η.
    pub fn place(&self, arc: &Arc, frame: &Frame, across: f64) -> f64 {
        let [c, b, a] = self.polynomial(frame);
        let c = c - across;
        let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
        let q = -0.5 * (b + root.copysign(b));
        let [low, high] = arc.span;
        let outside = |t: f64| (low - t).max(t - high).max(0.0);
        let candidates = [c / q, q / a].into_iter().filter(|t| t.is_finite());
        let nearest = candidates.min_by(|s, t| outside(*s).total_cmp(&outside(*t)));
        nearest.unwrap_or(low).clamp(low, high)
    }

    /// ℓ of the arc at η [m].
    pub fn along_at(&self, arc: &Arc, frame: &Frame, across: f64) -> f64 {
        frame.along(self.position(self.place(arc, frame, across)))
    }

    /// The arc's average over a strip that it crosses.
    pub fn average(&self, arc: &Arc, frame: &Frame, strip: [f64; 2]) -> Average {
        let [_, b, a] = self.polynomial(frame);
        let [from, to] = strip.map(|across| self.place(arc, frame, across));
        let mut total = 0.0;
        let mut along = 0.0;
        let mut sums = [0.0; 3];
        for (abscissa, weight) in GAUSS {
            let t = from + abscissa * (to - from);
            let weight = weight * (b + 2.0 * a * t).abs();
            total += weight;
            along += weight * frame.along(self.position(t));
            for (sum, n) in sums.iter_mut().zip(self.shape(t)) {
                *sum += weight * n;
            }
        }
        Average {
            along: along / total,
            shares: self
                .nodes
                .iter()
                .zip(sums)
                .map(|(&node, sum)| (node, sum / total))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola that bulges beyond its chord, so that η turns on it in many directions.
    fn curved() -> Side {
        Side {
            ends: [[0.0, 0.0], [2.0, 0.5]],
            middle: Some([1.1, -0.4]),
            nodes: vec![3, 4, 5],
        }
    }

    #[test]
    fn averages_are_those_of_fine_sums() {
        let mut turned = 0;
        for side in [
            curved(),
            Side {
                middle: None,
                nodes: vec![3, 4],
                ..curved()
            },
        ] {
            for k in 0..12 {
                let (s, c) = (0.1 + f64::from(k) * 0.5).sin_cos();
                let frame = Frame { n: [c, s] };
                let arcs = side.arcs(0, &frame, 1e-12);
                turned += arcs.len() - 1;
                for arc in arcs {
                    let [low, high] = arc.range;
                    let strip = [low + 0.2 * (high - low), low + 0.7 * (high - low)];
                    let found = side.average(&arc, &frame, strip);
                    let steps = 4000;
                    let mut along = 0.0;
                    let mut middle = 0.0;
                    for i in 0..steps {
                        let share = (f64::from(i) + 0.5) / f64::from(steps);
                        let eta = strip[0] + share * (strip[1] - strip[0]);
                        let t = side.place(&arc, &frame, eta);
                        assert!((frame.across(side.position(t)) - eta).abs() < 1e-14);
                        along += side.along_at(&arc, &frame, eta) / f64::from(steps);
                        middle += side.shape(t)[1] / f64::from(steps);
                    }
                    // The midpoint rule's own error; η'' / η'² is of order one in the strips.
                    assert!((found.along - along).abs() < 1e-6, "{k}");
                    assert!((found.shares[1].1 - middle).abs() < 1e-6, "{k}");
                    let sum: f64 = found.shares.iter().map(|(_, n)| n).sum();
                    assert!((sum - 1.0).abs() < 1e-15);
                }
            }
        }
        assert!(turned > 2, "some directions touch the curve: {turned}");
    }
}
