//! The lattice's squares beside an interface, and where their edges meet it.

use super::integral::Place;
use super::{Point, Site};
use crate::coupling::Parts;
use crate::coupling::clip::side::{Frame, Side};
use crate::coupling::clip::{sides, stencil};
use crate::peridynamics::cells::CORNERS;
use std::collections::{BTreeMap, BTreeSet};

/// Sites without a point within this distance of Γ are moved to it [dx]: more than the clip's clearance, which is
/// measured from chords.
const NEAR: f64 = 0.3;

/// Distance from Γ below which a piece of an edge runs along it, and from an end on Γ below which a crossing is that end
/// [dx].
pub const ON_INTERFACE: f64 = 1e-7;

/// Sides whose height over an edge is less than this run along it [dx].
pub const ON_LINE: f64 = 1e-9;

/// A corner of the lattice's squares.
#[derive(Clone)]
pub enum Vertex {
    Point(Place),
    OnInterface(Place),
    Outside(Point),
}

impl Vertex {
    pub fn at(&self) -> Point {
        match self {
            Vertex::Point(place) | Vertex::OnInterface(place) => place.at,
            Vertex::Outside(at) => *at,
        }
    }

    pub fn place(&self) -> Option<Place> {
        match self {
            Vertex::Point(place) | Vertex::OnInterface(place) => Some(place.clone()),
            Vertex::Outside(_) => None,
        }
    }
}

/// A lattice, its squares beside the interface, and what is known of their boundaries.
pub struct Overlay<'a> {
    pub parts: &'a Parts<'a>,
    pub sides: Vec<Side>,
    pub dx: f64,
    /// Values of t on each side at which it is cut, and the place there on a free side.
    pub cuts: Vec<Vec<(f64, Option<Place>)>>,
    /// Squares that may meet the interface.
    pub near: BTreeSet<Site>,
    /// Sides that may meet each of them.
    sides_at: BTreeMap<Site, Vec<usize>>,
    pub vertices: BTreeMap<Site, Vertex>,
}

pub fn beside([i, j]: Site, [p, q]: Site) -> Site {
    [i + p, j + q]
}

impl<'a> Overlay<'a> {
    pub fn new(parts: &'a Parts<'a>) -> Overlay<'a> {
        let sides = sides(parts);
        let index = &parts.lattice.index;
        let range = |side: &Side| {
            let points = side.ends.iter().chain(&side.middle);
            let local: Vec<Point> = points.map(|&x| index.coordinates(x)).collect();
            // A parabola stays within half of its control polygon's height beyond its three points.
            let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
                local.iter().map(|x| x[axis]).fold(from, pick)
            };
            [0, 1].map(|axis| {
                let low = bound(axis, f64::min, f64::INFINITY);
                let high = bound(axis, f64::max, f64::NEG_INFINITY);
                let rest = 1.0 + 0.25 * (high - low) * f64::from(u8::from(side.middle.is_some()));
                (low - rest).floor() as i64..=(high + rest).floor() as i64
            })
        };
        let squares = |side: &Side| {
            let [columns, rows] = range(side);
            rows.flat_map(move |j| columns.clone().map(move |i| [i, j]))
        };
        let interface = sides.iter().filter(|side| !side.is_free());
        let near: BTreeSet<Site> = interface.flat_map(squares).collect();
        let mut sides_at: BTreeMap<Site, Vec<usize>> = BTreeMap::new();
        for (number, side) in sides.iter().enumerate() {
            for square in squares(side).filter(|square| near.contains(square)) {
                sides_at.entry(square).or_default().push(number);
            }
        }
        let mut overlay = Overlay {
            parts,
            dx: index.spacing,
            cuts: vec![Vec::new(); sides.len()],
            sides,
            near,
            sides_at,
            vertices: BTreeMap::new(),
        };
        let sites: BTreeSet<Site> = (overlay.near.iter())
            .flat_map(|&square| CORNERS.map(|corner| beside(square, corner)))
            .collect();
        for site in sites {
            let vertex = overlay.vertex(site);
            overlay.vertices.insert(site, vertex);
        }
        overlay
    }

    pub fn point(&self, site: Site) -> Option<Place> {
        let index = &self.parts.lattice.index;
        let point = index.point(site)?;
        Some(Place {
            at: index.position(site),
            u: vec![(self.parts.first_node + point, 1.0)],
        })
    }

    fn vertex(&mut self, site: Site) -> Vertex {
        if let Some(place) = self.point(site) {
            return Vertex::Point(place);
        }
        let at = self.parts.lattice.index.position(site);
        let around = CORNERS.map(|[p, q]| beside(site, [-p, -q]));
        let sides: BTreeSet<usize> = around
            .iter()
            .flat_map(|square| self.sides_at.get(square).into_iter().flatten().copied())
            .collect();
        let feet = sides.into_iter().filter(|&s| !self.sides[s].is_free());
        let feet = feet.map(|s| (s, self.sides[s].foot(at)));
        let nearest = feet.min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        match nearest {
            Some((side, (t, distance))) if distance <= NEAR * self.dx => {
                self.cuts[side].push((t, None));
                Vertex::OnInterface(self.trace(side, t))
            }
            _ => Vertex::Outside(at),
        }
    }

    /// The elements' trace on a side of the interface.
    pub fn trace(&self, side: usize, t: f64) -> Place {
        let side = &self.sides[side];
        let shape = side.shape(t);
        Place {
            at: side.position(t),
            u: side.nodes.iter().copied().zip(shape).collect(),
        }
    }

    /// Whether a position lies in the region, of the sides' true curves.
    fn is_inside(&self, x: Point) -> bool {
        let frame = Frame { n: [1.0, 0.0] };
        let mut count = 0;
        for (number, side) in self.sides.iter().enumerate() {
            let [low, high] = side.bounds(1);
            if x[1] < low || x[1] > high {
                continue;
            }
            for arc in side.arcs(number, &frame, 0.0) {
                let [low, high] = arc.range;
                let crosses = low <= x[1] && x[1] < high;
                if crosses && side.along_at(&arc, &frame, x[1]) > x[0] {
                    count += 1;
                }
            }
        }
        count % 2 == 1
    }

    fn distance_to_interface(&self, x: Point, sides: &[usize]) -> f64 {
        let own = sides.iter().filter(|&&s| !self.sides[s].is_free());
        own.map(|&s| self.sides[s].foot(x).1)
            .fold(f64::INFINITY, f64::min)
    }

    /// The pieces inside the region of the edge from a site along an axis.
    pub fn edge(&mut self, site: Site, axis: usize) -> Result<Vec<[Place; 2]>, Point> {
        let step = [[1, 0], [0, 1]][axis];
        let next = beside(site, step);
        let ends = [site, next].map(|site| self.vertices[&site].clone());
        let [a, b] = [ends[0].at(), ends[1].at()];
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0].hypot(along[1]);
        if length <= ON_INTERFACE * self.dx {
            return Ok(Vec::new());
        }
        let frame = Frame {
            n: along.map(|x| x / length),
        };
        let (across, start) = (frame.across(a), frame.along(a));
        let squares = [site, beside(site, [-step[1], -step[0]])];
        let sides: BTreeSet<usize> = squares
            .iter()
            .flat_map(|square| self.sides_at.get(square).into_iter().flatten().copied())
            .collect();
        let sides: Vec<usize> = sides.into_iter().collect();
        let mut crossings: Vec<(f64, usize, f64)> = Vec::new();
        for &number in &sides {
            let side = &self.sides[number];
            for arc in side.arcs(number, &frame, ON_LINE * self.dx) {
                let [low, high] = arc.range;
                if low <= across && across < high {
                    let t = side.place(&arc, &frame, across);
                    let at = frame.along(side.position(t)) - start;
                    if self.is_crossing(&ends, [at, length], arc.enters) {
                        crossings.push((at.clamp(0.0, length), number, t));
                    }
                }
            }
        }
        // Ends of sides on the edge: between two of them it may run along the interface.
        let mut has_ends = false;
        for &number in sides.iter().filter(|&&s| !self.sides[s].is_free()) {
            for (t, end) in [0.0, 1.0].into_iter().zip(self.sides[number].ends) {
                let at = frame.along(end) - start;
                let is_on = (frame.across(end) - across).abs() < ON_INTERFACE * self.dx;
                if is_on && at > ON_INTERFACE * self.dx && at < length - ON_INTERFACE * self.dx {
                    crossings.push((at, number, t));
                    has_ends = true;
                }
            }
        }
        crossings.sort_by(|p, q| p.0.total_cmp(&q.0));
        let mut marks = vec![(0.0, ends[0].place())];
        for &(at, number, t) in &crossings {
            let place = match self.sides[number].is_free() {
                false => self.trace(number, t),
                true => self.beyond([site, next], at / length).ok_or(a)?,
            };
            let own = self.sides[number].is_free().then(|| place.clone());
            self.cuts[number].push((t, own));
            marks.push((at, Some(place)));
        }
        marks.push((length, ends[1].place()));
        let place = |at: f64| [0, 1].map(|k| a[k] + at * frame.n[k]);
        let count = marks.len() - 1;
        let inside = |k: usize| match (&ends[0], &ends[1]) {
            (Vertex::Point(_), _) if !has_ends => k.is_multiple_of(2),
            (_, Vertex::Point(_)) if !has_ends => (count - 1 - k).is_multiple_of(2),
            _ => {
                let at = place(0.5 * (marks[k].0 + marks[k + 1].0));
                marks[k + 1].0 - marks[k].0 > ON_INTERFACE * self.dx
                    && self.is_inside(at)
                    && self.distance_to_interface(at, &sides) > ON_INTERFACE * self.dx
            }
        };
        let kept = (0..count).filter(|&k| inside(k));
        kept.map(|k| match (&marks[k].1, &marks[k + 1].1) {
            (Some(p), Some(q)) => Ok([p.clone(), q.clone()]),
            _ => Err(place(marks[k].0)),
        })
        .collect()
    }

    /// Whether a line from one end to the other meets a side between them at a distance `at` from the first. A
    /// point may lie on a free side: there the line has left the region, or has entered it before.
    fn is_crossing(&self, ends: &[Vertex; 2], [at, length]: [f64; 2], enters: bool) -> bool {
        let is_at = |end: &Vertex, distance: f64| match end {
            Vertex::Outside(_) => false,
            _ => distance.abs() <= ON_INTERFACE * self.dx,
        };
        let is_point = |end: &Vertex| matches!(end, Vertex::Point(_));
        if is_at(&ends[0], at) {
            return is_point(&ends[0]) && !enters;
        }
        if is_at(&ends[1], length - at) {
            return is_point(&ends[1]) && enters;
        }
        at > 0.0 && at < length
    }

    /// The place where an edge meets a free side, a share of its length from the first end. Beyond its last point u
    /// goes on as between the last two.
    fn beyond(&self, sites: [Site; 2], share: f64) -> Option<Place> {
        let [first, last] = sites;
        let step = [last[0] - first[0], last[1] - first[1]];
        let [a, b] = sites.map(|site| &self.vertices[&site]);
        let at = [0, 1].map(|k| a.at()[k] + share * (b.at()[k] - a.at()[k]));
        let (from, to, share) = match (a, b) {
            (Vertex::Point(p), Vertex::Outside(_)) => (
                p.clone(),
                self.point(beside(first, step.map(|s| -s))),
                -share,
            ),
            (Vertex::Outside(_), Vertex::Point(p)) => {
                (p.clone(), self.point(beside(last, step)), share - 1.0)
            }
            _ => match a.place() {
                Some(from) => (from, b.place(), share),
                None => return self.interpolated(at),
            },
        };
        let Some(to) = to else {
            return self.interpolated(at);
        };
        let scaled = |place: Place, share: f64| {
            let shares = place.u.into_iter();
            shares.map(move |(node, own)| (node, share * own))
        };
        let u = scaled(from, 1.0 - share).chain(scaled(to, share)).collect();
        Some(Place { at, u })
    }

    /// u at a position from the points nearby.
    pub fn interpolated(&self, at: Point) -> Option<Place> {
        let index = &self.parts.lattice.index;
        let mut u = stencil::value(index, self.parts.visibility, at)?;
        u.iter_mut()
            .for_each(|(node, _)| *node += self.parts.first_node);
        Some(Place { at, u })
    }

    /// The square near a position that holds it best.
    pub fn square_of(&self, x: Point) -> Option<Site> {
        let home = (self.parts.lattice.index.coordinates(x)).map(|x| x.floor() as i64);
        let around = (-1..=1).flat_map(|q| (-1..=1).map(move |p| [p, q]));
        let depth = |square: Site| {
            let ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|corner| beside(square, corner));
            let at = ring.map(|site| self.vertices.get(&site).map(Vertex::at));
            let depths = (0..4).map(|k| {
                let (Some(a), Some(b)) = (at[k], at[(k + 1) % 4]) else {
                    return f64::NEG_INFINITY;
                };
                let along = [b[0] - a[0], b[1] - a[1]];
                let length = along[0].hypot(along[1]);
                let cross = along[0] * (x[1] - a[1]) - along[1] * (x[0] - a[0]);
                match length > ON_INTERFACE * self.dx {
                    true => cross / length,
                    false => f64::INFINITY,
                }
            });
            depths.fold(f64::INFINITY, f64::min)
        };
        let candidates = around.map(|step| beside(home, step));
        let candidates = candidates.filter(|square| self.near.contains(square));
        let best = candidates.map(|square| (depth(square), square));
        let best = best.max_by(|p, q| p.0.total_cmp(&q.0));
        best.filter(|(depth, _)| *depth > -ON_INTERFACE * self.dx)
            .map(|(_, square)| square)
    }
}
