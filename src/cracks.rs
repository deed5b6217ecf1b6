//! Initial cracks: physical curves that sever the bonds and trusses they meet.
//!
//! One rule decides every case: a bond is severed if it **meets** a crack, touching included, within
//! a millionth of its length. So a bond that ends on a crack or grazes a tip is severed, and a point
//! exactly on a crack loses all its bonds: the crack is then a slot one point wide. The rule knows no
//! side and no orientation, hence mirror images give mirror images.

use crate::geometry::{chords, nearest_on_segment};
use crate::mesh::{Edge, Mesh};

/// Crack faces as straight segments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cracks {
    segments: Vec<[[f64; 2]; 2]>,
}

/// Share of a bond's length within which it touches.
const TOUCH: f64 = 1e-6;

impl Cracks {
    /// The chords of the given edges.
    pub fn new(mesh: &Mesh, edges: &[Edge]) -> Cracks {
        let of_edge = |edge: &Edge| {
            let points = chords(edge, &mesh.nodes);
            points.windows(2).map(|w| [w[0], w[1]]).collect::<Vec<_>>()
        };
        Cracks {
            segments: edges.iter().flat_map(of_edge).collect(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// Whether the bond from `a` to `b` is severed.
    pub fn sever(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        // Never less than the length.
        let length = (b[0] - a[0]).abs() + (b[1] - a[1]).abs();
        let mut close = self.segments.iter();
        close.any(|&segment| {
            near(segment, [a, b], TOUCH * length)
                && meet(segment, [a, b], TOUCH * (b[0] - a[0]).hypot(b[1] - a[1]))
        })
    }
}

type Segment = [[f64; 2]; 2];

/// Whether the bounding boxes come within `reach`.
fn near(p: Segment, q: Segment, reach: f64) -> bool {
    (0..2).all(|axis| {
        let bounds = |s: Segment| (s[0][axis].min(s[1][axis]), s[0][axis].max(s[1][axis]));
        let ((p_low, p_high), (q_low, q_high)) = (bounds(p), bounds(q));
        p_low <= q_high + reach && q_low <= p_high + reach
    })
}

/// Whether two segments cross, or an end of one lies within `reach` of the other.
fn meet(p: Segment, q: Segment, reach: f64) -> bool {
    let ends = p.iter().map(|&x| nearest_on_segment(x, q).1);
    let mut distances = ends.chain(q.iter().map(|&x| nearest_on_segment(x, p).1));
    cross(p, q) || distances.any(|distance| distance <= reach)
}

fn cross(p: Segment, q: Segment) -> bool {
    let side = |[a, b]: Segment, x: [f64; 2]| {
        (b[0] - a[0]) * (x[1] - a[1]) - (b[1] - a[1]) * (x[0] - a[0])
    };
    side(p, q[0]) * side(p, q[1]) < 0.0 && side(q, p[0]) * side(q, p[1]) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crack() -> Cracks {
        Cracks {
            segments: vec![[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [2.0, 1.0]]],
        }
    }

    #[test]
    fn crossing_touching_and_grazing_a_tip_sever() {
        for [a, b] in [
            [[0.5, -0.1], [0.5, 0.1]],
            [[0.5, 0.0], [0.5, 0.1]],
            [[-0.1, -0.1], [0.1, 0.1]],
            [[-0.3, 0.0], [0.2, 0.0]],
            [[1.0, 0.2], [1.4, 0.2]],
        ] {
            assert!(crack().sever(a, b), "{a:?} {b:?}");
            assert!(crack().sever(b, a), "{b:?} {a:?}");
        }
    }

    #[test]
    fn passing_by_does_not() {
        for [a, b] in [
            [[0.5, 0.01], [0.9, 0.02]],
            [[-0.2, -0.1], [-0.01, 0.1]],
            [[2.01, 0.9], [2.01, 1.2]],
        ] {
            assert!(!crack().sever(a, b), "{a:?} {b:?}");
        }
    }
}
