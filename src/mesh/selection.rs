//! Edges and nodes of a mesh by their position.

use super::{Edge, Mesh};
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap};
use thiserror::Error;

/// Distance within which a coordinate counts as the one sought, relative to the body's larger side.
const TOLERANCE: f64 = 1e-6;

/// A coordinate of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// The smallest one of the body.
    Lowest,
    /// The largest one of the body.
    Highest,
    /// \[m\].
    At(f64),
}

/// A place in the body; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// All points at which x, y or both have a value.
    Coordinates([Option<Coordinate>; 2]),
    /// The rectangle between two opposite corners.
    Rectangle([[f64; 2]; 2]),
    /// The node nearest to a point.
    Near([f64; 2]),
    /// The outline between two of its nodes, the shorter way round.
    Between([[f64; 2]; 2]),
}

/// Selects edges or nodes of a mesh by their position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selection {
    pub place: Place,
    /// Distance within which a coordinate counts as the one sought \[m\]; by default a millionth of the
    /// body's larger side.
    pub tolerance: Option<f64>,
}

/// The selected parts of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selected {
    Edges(Vec<Edge>),
    /// Ascending.
    Nodes(Vec<usize>),
}

/// Nothing is selected; lengths in metres.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SelectionError {
    #[error("no node of the body lies there")]
    Empty {
        /// Lower left and upper right corner of the body.
        bounds: [[f64; 2]; 2],
    },
    #[error("no node of the outline lies at that end")]
    NoEnd {
        end: [f64; 2],
        /// The nearest nodes of the outline.
        nearest: Vec<[f64; 2]>,
    },
    #[error("no outline leads from one end to the other")]
    Apart,
}

impl Selection {
    /// The edges of the outline of `cells` at the place; where there are none, inner edges; where there are
    /// none either, nodes.
    ///
    /// # Errors
    /// Nothing lies at the place.
    pub fn select(&self, mesh: &Mesh, cells: &[usize]) -> Result<Selected, SelectionError> {
        let body = Body::new(mesh, cells);
        let tolerance = self.tolerance.unwrap_or(TOLERANCE * body.size());
        match self.place {
            Place::Near(point) => body.nearest(point, tolerance),
            Place::Between(ends) => body.between(ends, tolerance),
            Place::Coordinates(wanted) => {
                let [low, high] = body.bounds;
                let at = [0, 1].map(|axis| {
                    wanted[axis].map(|coordinate| match coordinate {
                        Coordinate::Lowest => low[axis],
                        Coordinate::Highest => high[axis],
                        Coordinate::At(value) => value,
                    })
                });
                body.all(&|x: [f64; 2]| {
                    (0..2).all(|k| at[k].is_none_or(|at| (x[k] - at).abs() <= tolerance))
                })
            }
            Place::Rectangle([a, b]) => body.all(&|x: [f64; 2]| {
                (0..2).all(|k| {
                    let (low, high) = (a[k].min(b[k]), a[k].max(b[k]));
                    low - tolerance <= x[k] && x[k] <= high + tolerance
                })
            }),
        }
    }
}

/// The part of a mesh in which is selected.
struct Body<'a> {
    mesh: &'a Mesh,
    cells: &'a [usize],
    outline: Vec<Edge>,
    nodes: BTreeSet<usize>,
    bounds: [[f64; 2]; 2],
}

impl Body<'_> {
    fn new<'a>(mesh: &'a Mesh, cells: &'a [usize]) -> Body<'a> {
        let of_cells = cells.iter().flat_map(|&cell| mesh.cells[cell].nodes());
        let nodes: BTreeSet<usize> = of_cells.copied().collect();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for position in nodes.iter().map(|&node| mesh.nodes[node]) {
            for axis in 0..2 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        Body {
            mesh,
            cells,
            outline: mesh.outline(cells),
            nodes,
            bounds: [low, high],
        }
    }

    fn size(&self) -> f64 {
        let [low, high] = self.bounds;
        (high[0] - low[0]).max(high[1] - low[1])
    }

    fn position(&self, node: usize) -> [f64; 2] {
        self.mesh.nodes[node]
    }

    fn empty(&self) -> SelectionError {
        SelectionError::Empty {
            bounds: self.bounds,
        }
    }

    fn all(&self, is_there: &dyn Fn([f64; 2]) -> bool) -> Result<Selected, SelectionError> {
        let holds = |edge: &Edge| edge.nodes().all(|node| is_there(self.position(node)));
        let outer: Vec<Edge> = self.outline.iter().copied().filter(holds).collect();
        if !outer.is_empty() {
            return Ok(Selected::Edges(outer));
        }
        let mut seen = BTreeSet::new();
        let edges = self
            .cells
            .iter()
            .flat_map(|&cell| self.mesh.cells[cell].edges());
        let inner: Vec<Edge> = edges
            .filter(|edge| holds(edge) && seen.insert(edge.key()))
            .collect();
        if !inner.is_empty() {
            return Ok(Selected::Edges(inner));
        }
        let nodes = self.nodes.iter().copied();
        let nodes: Vec<usize> = nodes
            .filter(|&node| is_there(self.position(node)))
            .collect();
        match nodes.is_empty() {
            true => Err(self.empty()),
            false => Ok(Selected::Nodes(nodes)),
        }
    }

    fn nearest(&self, point: [f64; 2], tolerance: f64) -> Result<Selected, SelectionError> {
        let [low, high] = self.bounds;
        let is_off = |k: usize| point[k] < low[k] - tolerance || point[k] > high[k] + tolerance;
        let nearest = by_distance(self, point, self.nodes.iter().copied());
        match nearest.first() {
            Some(&node) if !is_off(0) && !is_off(1) => Ok(Selected::Nodes(vec![node])),
            _ => Err(self.empty()),
        }
    }

    /// The shortest way along the outline, by Dijkstra's algorithm.
    fn between(&self, ends: [[f64; 2]; 2], tolerance: f64) -> Result<Selected, SelectionError> {
        let corners: BTreeSet<usize> = self.outline.iter().flat_map(|edge| edge.ends).collect();
        let mut at = [0; 2];
        for (end, node) in ends.into_iter().zip(&mut at) {
            let nearest = by_distance(self, end, corners.iter().copied());
            match nearest.first() {
                Some(&found) if distance(self.position(found), end) <= tolerance => *node = found,
                _ => {
                    let nearest = nearest.iter().take(2).map(|&node| self.position(node));
                    return Err(SelectionError::NoEnd {
                        end,
                        nearest: nearest.collect(),
                    });
                }
            }
        }
        let mut neighbours: HashMap<usize, Vec<usize>> = HashMap::new();
        for (index, edge) in self.outline.iter().enumerate() {
            for end in edge.ends {
                neighbours.entry(end).or_default().push(index);
            }
        }
        let mut reached: HashMap<usize, Option<usize>> = HashMap::new();
        let mut front = BinaryHeap::from([(Reverse(Length(0.0)), at[0], None)]);
        while let Some((Reverse(Length(length)), node, edge)) = front.pop() {
            if reached.contains_key(&node) {
                continue;
            }
            reached.insert(node, edge);
            for &index in neighbours.get(&node).into_iter().flatten() {
                let [a, b] = self.outline[index].ends;
                let other = if a == node { b } else { a };
                let step = distance(self.position(a), self.position(b));
                front.push((Reverse(Length(length + step)), other, Some(index)));
            }
        }
        let mut edges = Vec::new();
        let mut node = at[1];
        while node != at[0] {
            let edge = reached.get(&node).copied().flatten();
            let index = edge.ok_or(SelectionError::Apart)?;
            let [a, b] = self.outline[index].ends;
            node = if a == node { b } else { a };
            edges.push(self.outline[index]);
        }
        match edges.is_empty() {
            true => Ok(Selected::Nodes(vec![at[0]])),
            false => Ok(Selected::Edges(edges)),
        }
    }
}

/// Nodes by their distance to a point, the nearest first.
fn by_distance(body: &Body, point: [f64; 2], nodes: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut nodes: Vec<usize> = nodes.collect();
    let away = |&node: &usize| Length(distance(body.position(node), point));
    nodes.sort_by_key(away);
    nodes
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// A length with a total order.
#[derive(Clone, Copy, PartialEq)]
struct Length(f64);

impl Eq for Length {}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Length) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Length {
    fn cmp(&self, other: &Length) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;
    use crate::mesh::grid::Grid;

    /// 4 × 2 unit squares.
    fn select(place: Place) -> Result<Selected, SelectionError> {
        let grid = Grid {
            size: [4.0, 2.0],
            count: [4, 2],
            kind: CellKind::Quad8,
        };
        let mesh = grid.mesh(|_| [0.0, 0.0]);
        let cells: Vec<usize> = (0..mesh.cells.len()).collect();
        Selection {
            place,
            tolerance: None,
        }
        .select(&mesh, &cells)
    }

    fn edge_count(place: Place) -> usize {
        match select(place) {
            Ok(Selected::Edges(edges)) => edges.len(),
            other => panic!("no edges: {other:?}"),
        }
    }

    fn nodes(place: Place) -> Vec<usize> {
        match select(place) {
            Ok(Selected::Nodes(nodes)) => nodes,
            other => panic!("no nodes: {other:?}"),
        }
    }

    #[test]
    fn sides_lines_and_corners() {
        use Coordinate::{At, Highest, Lowest};
        assert_eq!(edge_count(Place::Coordinates([Some(Lowest), None])), 2);
        assert_eq!(edge_count(Place::Coordinates([None, Some(Highest)])), 4);
        assert_eq!(edge_count(Place::Coordinates([Some(At(1.0)), None])), 2);
        assert_eq!(
            nodes(Place::Coordinates([Some(Highest), Some(Lowest)])),
            [4]
        );
        let off = select(Place::Coordinates([Some(At(7.0)), None]));
        let bounds = [[0.0, 0.0], [4.0, 2.0]];
        assert_eq!(off, Err(SelectionError::Empty { bounds }));
    }

    #[test]
    fn boxes_points_and_stretches_of_the_outline() {
        assert_eq!(edge_count(Place::Rectangle([[0.0, 2.0], [2.5, 1.9]])), 2);
        assert_eq!(edge_count(Place::Rectangle([[-1.0, 0.0], [0.1, 1.1]])), 1);
        assert_eq!(nodes(Place::Near([2.1, 0.05])), [2]);
        assert!(select(Place::Near([2200.0, 0.3])).is_err());
        // Round the corner at the lower left: 1 to the left, 2 up.
        assert_eq!(edge_count(Place::Between([[1.0, 0.0], [0.0, 2.0]])), 3);
        let Err(SelectionError::NoEnd { nearest, .. }) =
            select(Place::Between([[0.0, 0.0], [0.4, 0.0]]))
        else {
            panic!("an end between nodes");
        };
        assert_eq!(nearest, [[0.0, 0.0], [1.0, 0.0]]);
    }
}
