//! The outline of a body in straight pieces, found by their place.
//!
//! A quadratic edge is two pieces, its chords. They are kept in squares as wide as the mean chord.

use super::contact::GAP;
use super::{Cell, Edge, Mesh};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// A straight piece of the outline, with its cell on the left.
pub(super) struct Chord {
    pub ends: [usize; 2],
    pub cell: usize,
    /// The connected part that it belongs to.
    pub part: u32,
}

/// The outline of some cells.
pub(super) struct Outline<'a> {
    pub mesh: &'a Mesh,
    pub chords: Vec<Chord>,
    /// Width of the squares in which neighbours are sought: the mean length of the chords \[m\].
    width: f64,
}

impl Outline<'_> {
    pub fn new<'a>(mesh: &'a Mesh, cells: &[usize]) -> Outline<'a> {
        let part = parts(mesh, cells);
        let mut edges: Vec<(Edge, usize)> = cells
            .iter()
            .flat_map(|&cell| mesh.cells[cell].edges().map(move |edge| (edge, cell)))
            .collect();
        edges.par_sort_unstable_by_key(|(edge, cell)| (edge.key(), *cell));
        let mut chords = Vec::new();
        for alike in edges.chunk_by(|(a, _), (b, _)| a.key() == b.key()) {
            let [(edge, cell)] = *alike else { continue };
            let nodes: Vec<usize> = [edge.ends[0]]
                .into_iter()
                .chain(edge.middle)
                .chain([edge.ends[1]])
                .collect();
            chords.extend(nodes.windows(2).map(|ends| Chord {
                ends: [ends[0], ends[1]],
                cell,
                part: part[ends[0]],
            }));
        }
        let mut outline = Outline {
            mesh,
            chords,
            width: 1.0,
        };
        let total: f64 = outline
            .chords
            .iter()
            .map(|chord| outline.length(chord))
            .sum();
        if total > 0.0 {
            outline.width = total / outline.chords.len() as f64;
        }
        outline
    }

    pub fn position(&self, node: usize) -> [f64; 2] {
        self.mesh.nodes[node]
    }

    pub fn length(&self, chord: &Chord) -> f64 {
        let [p, q] = chord.ends.map(|end| self.position(end));
        distance(p, q)
    }

    pub fn middle(&self, chord: &Chord) -> [f64; 2] {
        let [p, q] = chord.ends.map(|end| self.position(end));
        [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
    }

    fn square(&self, [x, y]: [f64; 2]) -> [i64; 2] {
        [x, y].map(|x| (x / self.width).floor() as i64)
    }

    /// Pairs of chords with a common square, each once and ascending.
    pub fn near_pairs(&self) -> Vec<[usize; 2]> {
        let mut squares: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
        for (index, chord) in self.chords.iter().enumerate() {
            let [p, q] = chord.ends.map(|end| self.position(end));
            let pieces = (distance(p, q) / self.width).ceil().max(1.0);
            let at = |t: f64| [0, 1].map(|axis| p[axis] + t * (q[axis] - p[axis]));
            for piece in 0..pieces as usize {
                let ends = [piece as f64 / pieces, (piece + 1) as f64 / pieces].map(at);
                let [[x0, y0], [x1, y1]] = self.box_around(&ends);
                for square in (x0..=x1).flat_map(|x| (y0..=y1).map(move |y| [x, y])) {
                    let members = squares.entry(square).or_default();
                    if members.last() != Some(&index) {
                        members.push(index);
                    }
                }
            }
        }
        let pairs_of = |members: Vec<usize>| {
            let mut pairs = Vec::new();
            for (k, &i) in members.iter().enumerate() {
                pairs.extend(members[k + 1..].iter().map(|&j| [i.min(j), i.max(j)]));
            }
            pairs
        };
        let mut pairs: Vec<[usize; 2]> = squares.into_values().flat_map(pairs_of).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// The first and the last square of the box around some points, which is wider by the largest gap.
    fn box_around(&self, points: &[[f64; 2]]) -> [[i64; 2]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis] - GAP * self.width);
                high[axis] = high[axis].max(point[axis] + GAP * self.width);
            }
        }
        [self.square(low), self.square(high)]
    }

    /// The chords by the square in which they begin.
    pub fn beginnings(&self) -> BTreeMap<[i64; 2], Vec<usize>> {
        let mut squares: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        for (index, chord) in self.chords.iter().enumerate() {
            let square = self.square(self.position(chord.ends[0]));
            squares.entry(square).or_default().push(index);
        }
        squares
    }

    /// The chords in those of some squares that lie around a cell; a cell may be far larger than a square.
    pub fn chords_from(
        &self,
        squares: &BTreeMap<[i64; 2], Vec<usize>>,
        corners: &[[f64; 2]],
    ) -> Vec<usize> {
        let [[x0, y0], [x1, y1]] = self.box_around(corners);
        let columns = (x1 - x0 + 1) as usize;
        let within = |x: i64| squares.range([x, y0]..=[x, y1]);
        let found: Vec<&Vec<usize>> = if columns <= squares.len() {
            (x0..=x1)
                .flat_map(within)
                .map(|(_, chords)| chords)
                .collect()
        } else {
            let is_near = |[x, y]: [i64; 2]| x0 <= x && x <= x1 && y0 <= y && y <= y1;
            let all = squares.iter().filter(|(square, _)| is_near(**square));
            all.map(|(_, chords)| chords).collect()
        };
        found.into_iter().flatten().copied().collect()
    }
}

/// The corners of a cell, the middle nodes between them.
pub(super) fn ring(cell: &Cell) -> Vec<usize> {
    let side = |edge: Edge| [Some(edge.ends[0]), edge.middle];
    cell.edges().flat_map(side).flatten().collect()
}

pub(super) fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
    (q[0] - p[0]).hypot(q[1] - p[1])
}

/// For each node the number of the part that `cells` connect it to: its lowest node.
fn parts(mesh: &Mesh, cells: &[usize]) -> Vec<u32> {
    fn root(parent: &mut [u32], mut node: u32) -> u32 {
        while parent[node as usize] != node {
            parent[node as usize] = parent[parent[node as usize] as usize];
            node = parent[node as usize];
        }
        node
    }
    let mut parent: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    for &cell in cells {
        for pair in mesh.cells[cell].nodes().windows(2) {
            let a = root(&mut parent, pair[0] as u32);
            let b = root(&mut parent, pair[1] as u32);
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..mesh.nodes.len() as u32)
        .map(|node| root(&mut parent, node))
        .collect()
}
