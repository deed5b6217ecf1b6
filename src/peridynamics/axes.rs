//! The axes of a lattice, which may be turned against x and y.

use crate::geometry::Outline;

/// The lattice's axes, about the origin of x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// Cosine and sine of the angle; `None`: parallel to x and y, where nothing is rounded.
    turn: Option<[f64; 2]>,
}

impl Axes {
    /// Turned counter-clockwise by `angle` [rad].
    pub fn new(angle: f64) -> Axes {
        Axes {
            turn: (angle != 0.0).then(|| [angle.cos(), angle.sin()]),
        }
    }

    /// Coordinates along the lattice's axes.
    pub fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.turn {
            None => [x, y],
            Some([c, s]) => [c * x + s * y, c * y - s * x],
        }
    }

    /// Coordinates along x and y.
    pub fn global(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.turn {
            None => [x, y],
            Some([c, s]) => [c * x - s * y, c * y + s * x],
        }
    }

    /// An outline in the lattice's axes.
    pub fn outline(&self, outline: &Outline) -> Outline {
        let turned = |polygon: &Vec<[f64; 2]>| polygon.iter().map(|&x| self.local(x)).collect();
        Outline {
            loops: outline.loops.iter().map(turned).collect(),
        }
    }
}
