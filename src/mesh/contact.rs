//! Parts of a body that lie on each other, or side by side without being joined.
//!
//! Two surfaces that are drawn beside each other are two bodies unless they share the nodes of their
//! common line: no force passes there. Only the outline has to be looked at: the edges with a cell on one
//! side. Where two stretches of it run along each other in opposite directions, the cells beside them
//! touch. The two faces of a crack touch as well; they belong to one connected part and their nodes lie
//! in the same places, which tells them from parts that were never joined.
//!
//! Edges are taken as chords: a quadratic one as two.

use super::Mesh;
use super::chords::{Chord, Outline, distance, ring};
use super::conformity::{Misfit, MisfitKind};
use std::collections::{BTreeMap, HashMap};

/// Distance within which two parts count as touching, relative to the shorter chord.
pub(super) const GAP: f64 = 1e-3;
/// Distance within which the faces of a crack coincide, relative to the shorter chord: rounding.
const COINCIDENT: f64 = 1e-6;

/// A line along which two parts touch and do not share their nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// A cell of each part.
    pub cells: [usize; 2],
    /// The middle of the first chord of the line \[m\].
    pub at: [f64; 2],
    /// Length of the line \[m\].
    pub length: f64,
}

/// Checks that the `cells` do not lie on each other. Returns the lines along which they touch without
/// being joined, one for each two connected parts; the faces of cracks are not among them.
///
/// # Errors
/// Two cells of which one covers a part of the other, or has a node within an edge of it.
pub fn contacts(mesh: &Mesh, cells: &[usize]) -> Result<Vec<Contact>, Misfit> {
    let outline = Outline::new(mesh, cells);
    if let Some(misfit) = outline.covered_node(cells) {
        return Err(misfit);
    }
    let mut touching: BTreeMap<[u32; 2], Contact> = BTreeMap::new();
    let mut shared_ends: HashMap<usize, [Option<usize>; 2]> = HashMap::new();
    for [i, j] in outline.near_pairs() {
        let (a, b) = (&outline.chords[i], &outline.chords[j]);
        if outline.cross(a, b) {
            return Err(outline.misfit(MisfitKind::Overlap, a, b));
        }
        let is_one_part = a.part == b.part;
        let tolerance = if is_one_part { COINCIDENT } else { GAP };
        let [p, q] = a.ends;
        let common_length = |b| outline.common_length(a.ends, b, tolerance);
        if common_length([b.ends[1], b.ends[0]]).is_some() {
            return Err(outline.misfit(MisfitKind::Overlap, a, b));
        }
        let Some(length) = common_length(b.ends) else {
            continue;
        };
        if b.ends == [q, p] {
            // The chords are one, and the edges that they belong to are not.
            return Err(outline.misfit(MisfitKind::MiddleNode, a, b));
        }
        if is_one_part && outline.coincide(a, b) {
            continue;
        }
        for (chord, other, index) in [(a, b, i), (b, a, j)] {
            let shared = shared_ends.entry(index).or_default();
            for (end, shared) in chord.ends.iter().zip(shared) {
                if other.ends.contains(end) {
                    *shared = Some(other.cell);
                }
            }
        }
        let key = [a.part.min(b.part), a.part.max(b.part)];
        let contact = touching.entry(key).or_insert(Contact {
            cells: [a.cell, b.cell],
            at: outline.middle(a),
            length: 0.0,
        });
        contact.length += length;
    }
    let mut hanging: Vec<(usize, usize)> = shared_ends
        .into_iter()
        .filter_map(|(chord, shared)| Some((chord, shared[0].and(shared[1])?)))
        .collect();
    hanging.sort_unstable();
    match hanging.first() {
        Some(&(chord, other)) => Err(Misfit {
            kind: MisfitKind::HangingNode,
            cells: [outline.chords[chord].cell, other],
            at: outline.middle(&outline.chords[chord]),
        }),
        None => Ok(touching.into_values().collect()),
    }
}

impl Outline<'_> {
    fn misfit(&self, kind: MisfitKind, a: &Chord, b: &Chord) -> Misfit {
        Misfit {
            kind,
            cells: [a.cell, b.cell],
            at: self.middle(a),
        }
    }

    /// A node of the outline that lies within a cell, farther from its sides than a gap.
    fn covered_node(&self, cells: &[usize]) -> Option<Misfit> {
        let squares = self.beginnings();
        for &cell in cells {
            let ring = ring(&self.mesh.cells[cell]);
            let corners: Vec<[f64; 2]> = ring.iter().map(|&node| self.position(node)).collect();
            let near = self.chords_from(&squares, &corners);
            let mut covered = near
                .iter()
                .map(|&index| &self.chords[index])
                .filter(|chord| {
                    let node = chord.ends[0];
                    !ring.contains(&node) && is_deep_inside(self.position(node), &corners)
                });
            if let Some(chord) = covered.next() {
                return Some(Misfit {
                    kind: MisfitKind::Overlap,
                    cells: [cell, chord.cell],
                    at: self.position(chord.ends[0]),
                });
            }
        }
        None
    }

    /// Returns whether two chords cross, farther from the ends of both than a gap.
    fn cross(&self, a: &Chord, b: &Chord) -> bool {
        let [p, q] = a.ends.map(|end| self.position(end));
        let [r, s] = b.ends.map(|end| self.position(end));
        let u = [q[0] - p[0], q[1] - p[1]];
        let v = [s[0] - r[0], s[1] - r[1]];
        let w = [r[0] - p[0], r[1] - p[1]];
        let determinant = cross(u, v);
        if determinant.abs() <= GAP * u[0].hypot(u[1]) * v[0].hypot(v[1]) {
            return false;
        }
        let inner = GAP..1.0 - GAP;
        inner.contains(&(cross(w, v) / determinant)) && inner.contains(&(cross(w, u) / determinant))
    }

    /// The length over which two chords run along each other in opposite directions, none farther from
    /// the other there than `tolerance` times the shorter one.
    fn common_length(&self, a: [usize; 2], b: [usize; 2], tolerance: f64) -> Option<f64> {
        let [p, q] = a.map(|end| self.position(end));
        let [r, s] = b.map(|end| self.position(end));
        let length = distance(p, q);
        let shorter = length.min(distance(r, s));
        if shorter == 0.0 {
            return None;
        }
        let along = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
        // Place along the first chord, and distance from it.
        let seen = |x: [f64; 2]| {
            let d = [x[0] - p[0], x[1] - p[1]];
            [d[0] * along[0] + d[1] * along[1], cross(along, d)]
        };
        let [[t_r, d_r], [t_s, d_s]] = [seen(r), seen(s)];
        let (low, high) = (t_s.max(0.0), t_r.min(length));
        if high - low <= tolerance.max(COINCIDENT) * shorter {
            return None;
        }
        let distance_at = |t: f64| d_s + (d_r - d_s) * (t - t_s) / (t_r - t_s);
        let gap = distance_at(low).abs().max(distance_at(high).abs());
        (gap <= tolerance * shorter).then_some(high - low)
    }

    /// Returns whether the ends of two chords lie in the same places.
    fn coincide(&self, a: &Chord, b: &Chord) -> bool {
        let tolerance = COINCIDENT * self.length(a).min(self.length(b));
        let [[p, q], [r, s]] = [a, b].map(|chord| chord.ends.map(|end| self.position(end)));
        distance(p, s) <= tolerance && distance(q, r) <= tolerance
    }
}

fn is_deep_inside(p: [f64; 2], corners: &[[f64; 2]]) -> bool {
    let mut is_inside = false;
    for (k, &a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        if (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        {
            is_inside = !is_inside;
        }
    }
    let is_far = |(k, &a): (usize, &[f64; 2])| {
        let b = corners[(k + 1) % corners.len()];
        let length = distance(a, b);
        let d = [b[0] - a[0], b[1] - a[1]];
        let t = ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (length * length);
        let t = t.clamp(0.0, 1.0);
        distance(p, [a[0] + t * d[0], a[1] + t * d[1]]) > GAP * length
    };
    is_inside && corners.iter().enumerate().all(is_far)
}

fn cross(u: [f64; 2], v: [f64; 2]) -> f64 {
    u[0] * v[1] - u[1] * v[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cell, CellKind};

    /// Rectangles of nx × ny squares on [x, x + w] × [y, y + h]; none shares a node with another.
    fn rectangles(list: &[([f64; 2], [f64; 2], [usize; 2])]) -> Mesh {
        let mut mesh = Mesh::default();
        for &([x, y], [w, h], [nx, ny]) in list {
            let first = mesh.nodes.len();
            for j in 0..=ny {
                for i in 0..=nx {
                    let at = [x + w * i as f64 / nx as f64, y + h * j as f64 / ny as f64];
                    mesh.nodes.push(at);
                }
            }
            for j in 0..ny {
                for i in 0..nx {
                    let a = first + j * (nx + 1) + i;
                    let corners = [a, a + 1, a + nx + 2, a + nx + 1];
                    mesh.cells.push(Cell::new(CellKind::Quad4, &corners));
                }
            }
        }
        mesh
    }

    fn found(mesh: &Mesh) -> Result<Vec<Contact>, MisfitKind> {
        let cells: Vec<usize> = (0..mesh.cells.len()).collect();
        contacts(mesh, &cells).map_err(|misfit| misfit.kind)
    }

    /// Node `old` of a cell becomes node `new`.
    fn rejoin(mesh: &mut Mesh, cell: usize, old: usize, new: usize) {
        let Cell { kind, .. } = mesh.cells[cell];
        let nodes: Vec<usize> = mesh.cells[cell]
            .nodes()
            .iter()
            .map(|&node| if node == old { new } else { node })
            .collect();
        mesh.cells[cell] = Cell::new(kind, &nodes);
    }

    #[test]
    fn one_body_touches_nothing() {
        let mesh = rectangles(&[([0.0, 0.0], [2.0, 1.0], [8, 4])]);
        assert_eq!(found(&mesh), Ok(vec![]));
        let apart = rectangles(&[
            ([0.0, 0.0], [1.0, 1.0], [4, 4]),
            ([1.01, 0.0], [1.0, 1.0], [4, 4]),
        ]);
        assert_eq!(found(&apart), Ok(vec![]));
    }

    #[test]
    fn parts_side_by_side_touch_whatever_their_subdivision() {
        // The last stands 1e-4 away and reaches over half of the side.
        for (second, length) in [
            (([1.0, 0.0], [1.0, 1.0], [4, 4]), 1.0),
            (([1.0, 0.0], [1.0, 1.0], [4, 7]), 1.0),
            (([1.0001, 0.5], [1.0, 1.0], [3, 3]), 0.5),
        ] {
            let mesh = rectangles(&[([0.0, 0.0], [1.0, 1.0], [4, 4]), second]);
            let contacts = found(&mesh).unwrap();
            assert_eq!(contacts.len(), 1, "{second:?}");
            let Contact {
                cells,
                at,
                length: l,
            } = contacts[0];
            assert!((l - length).abs() < 1e-9, "{l}");
            assert!(cells[0] < 16 && cells[1] >= 16);
            assert_eq!(at[0], 1.0);
        }
    }

    #[test]
    fn parts_on_each_other_overlap() {
        for second in [
            ([0.3, 0.3], [0.2, 0.2], [2, 2]),
            ([0.9, 0.0], [1.0, 1.0], [4, 4]),
            ([0.0, 0.0], [1.0, 1.0], [4, 4]),
            // A cross without a node of one in the other.
            ([-1.0, 0.4], [3.0, 0.2], [1, 1]),
        ] {
            let mesh = rectangles(&[([0.0, 0.0], [1.0, 1.0], [4, 4]), second]);
            assert_eq!(found(&mesh), Err(MisfitKind::Overlap), "{second:?}");
        }
    }

    #[test]
    fn the_faces_of_a_crack_do_not_count() {
        // Two rectangles joined at the two lowest nodes of their common side: an edge crack.
        let mut mesh = rectangles(&[
            ([0.0, 0.0], [1.0, 1.0], [4, 4]),
            ([1.0, 0.0], [1.0, 1.0], [4, 4]),
        ]);
        rejoin(&mut mesh, 16, 25, 4);
        rejoin(&mut mesh, 16, 30, 9);
        rejoin(&mut mesh, 20, 30, 9);
        assert_eq!(found(&mesh), Ok(vec![]));
    }

    #[test]
    fn a_hanging_node_is_found() {
        // Two cells beside one, joined at the ends of their common side.
        let mut mesh = rectangles(&[
            ([0.0, 0.0], [1.0, 1.0], [1, 1]),
            ([1.0, 0.0], [1.0, 1.0], [1, 2]),
        ]);
        rejoin(&mut mesh, 1, 4, 1);
        rejoin(&mut mesh, 2, 8, 3);
        assert_eq!(found(&mesh), Err(MisfitKind::HangingNode));
    }

    #[test]
    fn two_linear_cells_beside_a_quadratic_one_are_found() {
        let mut mesh = rectangles(&[
            ([0.0, 0.0], [1.0, 1.0], [1, 1]),
            ([1.0, 0.0], [1.0, 1.0], [1, 2]),
        ]);
        mesh.nodes.extend([[0.5, 0.0], [0.5, 1.0], [0.0, 0.5]]);
        mesh.cells[0] = Cell::new(CellKind::Quad8, &[0, 1, 3, 2, 10, 6, 11, 12]);
        rejoin(&mut mesh, 1, 4, 1);
        rejoin(&mut mesh, 2, 8, 3);
        assert_eq!(found(&mesh), Err(MisfitKind::MiddleNode));
    }
}
