//! The sites of the endless lattice that hold a material point.

/// The material point at each site of the endless lattice that holds one.
#[derive(Clone, Debug, PartialEq)]
pub struct PointIndex {
    /// The site (0, 0), along the lattice's axes [m].
    pub first: [f64; 2],
    /// dx [m].
    pub spacing: f64,
    /// Sites of the box along both axes; there are no points outside.
    pub counts: [i64; 2],
    /// The point at each site of the box, row by row.
    points: Vec<Option<u32>>,
}

impl PointIndex {
    /// `kept`: whether there is a point at each site of the box, row by row.
    pub fn new(first: [f64; 2], spacing: f64, counts: [usize; 2], kept: &[bool]) -> PointIndex {
        let mut next = 0;
        let numbered = kept.iter().map(|&kept| {
            kept.then(|| {
                next += 1;
                next - 1
            })
        });
        PointIndex {
            first,
            spacing,
            counts: counts.map(|count| count as i64),
            points: numbered.collect(),
        }
    }

    /// The material point at the site (i, j).
    pub fn point(&self, [i, j]: [i64; 2]) -> Option<u32> {
        let [columns, rows] = self.counts;
        let inside = (0..columns).contains(&i) && (0..rows).contains(&j);
        inside
            .then(|| self.points[(j * columns + i) as usize])
            .flatten()
    }

    /// Column and row of a position along the lattice's axes, fractions included.
    pub fn coordinates(&self, position: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (position[axis] - self.first[axis]) / self.spacing)
    }

    /// Position of the site (i, j) along the lattice's axes [m].
    pub fn position(&self, [i, j]: [i64; 2]) -> [f64; 2] {
        [
            self.first[0] + i as f64 * self.spacing,
            self.first[1] + j as f64 * self.spacing,
        ]
    }
}
