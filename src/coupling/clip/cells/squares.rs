//! The boundary integrals of the squares that the interface meets.

use super::integral::{Integral, Place};
use super::overlay::{ON_INTERFACE, ON_LINE, Overlay, Vertex, beside};
use super::{Part, Point, Site};
use crate::peridynamics::cells::CORNERS;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

impl Overlay<'_> {
    /// The boundary integrals of the squares that the interface meets.
    pub fn integrals(&mut self) -> Result<BTreeMap<Site, Part>, Point> {
        let mut edges: BTreeMap<(Site, usize), Vec<[Place; 2]>> = BTreeMap::new();
        for square in self.near.clone() {
            for (corner, axis) in [([0, 0], 0), ([0, 0], 1), ([0, 1], 0), ([1, 0], 1)] {
                let key = (beside(square, corner), axis);
                if let Entry::Vacant(place) = edges.entry(key) {
                    place.insert(self.edge(key.0, key.1)?);
                }
            }
        }
        let mut found: BTreeMap<Site, Part> = BTreeMap::new();
        let is_on = |square: &Site| {
            let mut corners = CORNERS
                .iter()
                .map(|&corner| &self.vertices[&beside(*square, corner)]);
            corners.any(|vertex| matches!(vertex, Vertex::OnInterface(_)))
        };
        let mut meeting: BTreeSet<Site> = self.near.iter().copied().filter(is_on).collect();
        let mut along_sides: Vec<(Site, usize, [f64; 2])> = Vec::new();
        for number in 0..self.sides.len() {
            if self.sides[number].is_free() && self.cuts[number].is_empty() {
                continue;
            }
            self.cuts[number].sort_by(|p, q| p.0.total_cmp(&q.0));
            let inner = self.cuts[number].iter().map(|cut| cut.0);
            let mut cuts: Vec<f64> = std::iter::once(0.0).chain(inner).chain([1.0]).collect();
            let scale = self.sides[number].tangent(0.5);
            let least = ON_LINE * self.dx / scale[0].hypot(scale[1]);
            cuts.dedup_by(|next, last| *next - *last < least);
            if let Some(last) = cuts.last_mut() {
                *last = 1.0;
            }
            for span in cuts.windows(2) {
                let side = &self.sides[number];
                let t = 0.5 * (span[0] + span[1]);
                let [x, y] = side.tangent(t);
                let nudge = ON_INTERFACE * self.dx / x.hypot(y);
                let at = side.position(t);
                let Some(square) = self.square_of([at[0] - nudge * y, at[1] + nudge * x]) else {
                    continue;
                };
                if !side.is_free() {
                    meeting.insert(square);
                }
                along_sides.push((square, number, [span[0], span[1]]));
            }
        }
        for &square in &meeting {
            let mut integral = Integral::default();
            let mut common = Vec::new();
            let around = [
                ([0, 0], 0, 1.0, [0, -1]),
                ([1, 0], 1, 1.0, [1, 0]),
                ([0, 1], 0, -1.0, [0, 1]),
                ([0, 0], 1, -1.0, [-1, 0]),
            ];
            for (corner, axis, sign, neighbour) in around {
                let mut length = 0.0;
                for [p, q] in &edges[&(beside(square, corner), axis)] {
                    integral.add_line([p, q], sign);
                    length += (q.at[0] - p.at[0]).hypot(q.at[1] - p.at[1]);
                }
                if length > 0.0 {
                    common.push((beside(square, neighbour), length));
                }
            }
            let points = CORNERS.map(|corner| self.point(beside(square, corner)));
            let nodes: Vec<u32> = points.iter().flatten().map(|place| place.u[0].0).collect();
            let nodes = match nodes.is_empty() {
                true => vec![self.parts.first_node],
                false => nodes,
            };
            found.insert(
                square,
                Part {
                    integral,
                    squares: vec![square],
                    common,
                    shares: nodes.into_iter().map(|node| (node, 1.0)).collect(),
                    is_whole: false,
                },
            );
        }
        for (square, number, span) in along_sides {
            if let Some(part) = found.get_mut(&square) {
                self.add_side(number, span, &mut part.integral)?;
            }
        }
        found.retain(|_, part| !part.integral.g.is_empty());
        Ok(found)
    }

    /// Adds a piece of a side.
    fn add_side(
        &self,
        number: usize,
        span: [f64; 2],
        integral: &mut Integral,
    ) -> Result<(), Point> {
        let side = &self.sides[number];
        if side.is_free() {
            let place = |t: f64| {
                let cut = self.cuts[number]
                    .iter()
                    .find(|cut| (cut.0 - t).abs() < ON_LINE);
                let at = side.position(t);
                let own = cut.and_then(|cut| cut.1.clone());
                own.or_else(|| self.node_at(at))
                    .or_else(|| self.interpolated(at))
                    .ok_or(at)
            };
            integral.add_line([&place(span[0])?, &place(span[1])?], 1.0);
            return Ok(());
        }
        for (t, weight) in side.gauss(span) {
            let [x, y] = side.tangent(t);
            integral.add([weight * y, -weight * x], &self.trace(number, t));
        }
        Ok(())
    }

    /// The end of the interface at a position.
    fn node_at(&self, x: Point) -> Option<Place> {
        let interface = self.sides.iter().filter(|side| !side.is_free());
        let mut ends = interface.flat_map(|side| side.ends.into_iter().zip(&side.nodes));
        let (at, &node) = ends.find(|(at, _)| *at == x)?;
        Some(Place {
            at,
            u: vec![(node, 1.0)],
        })
    }
}
