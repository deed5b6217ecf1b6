//! Visibility: a bond joins two points only if the straight line between them stays in the body.
//!
//! Two points within δ of each other may have a notch, a hole or a re-entrant corner between them. No
//! material carries a force across, and they have no bond (the visibility criterion of meshfree
//! methods, Belytschko, Lu & Gu 1994; a straight crack face in Silling & Askari 2005). Finite elements
//! are material: a bond may pass through them.
//!
//! A bond that only grazes the outline stays. With ε = 10⁻⁶ dx it *leaves* the closed body if it meets
//! the outline, and so do both of its parallels at the distance ε, which are shorter by 100 ε at either end,
//! lest they leave a sharp corner in which the bond ends.
//! So neither a bond along a straight side, whose mesh is rough by some 10⁻¹⁰, nor one past the tip of
//! a notch, nor one that ends on the outline depends on rounding; and a slit of no width, two sides
//! of the mesh that lie on each other, is seen. Whether two segments meet is decided exactly (Shewchuk
//! 1997). The rule knows no order of the two points, and mirror images give mirror images.

use super::lattice::ON_BOUNDARY;
use crate::geometry::Outline;
use robust::{Coord, orient2d};

type Segment = [[f64; 2]; 2];

/// The outline of a body, sorted such that what lies near a bond is found at once.
#[derive(Clone, Debug)]
pub struct Visibility {
    sides: Vec<Segment>,
    /// ε [m].
    tolerance: f64,
    bins: Bins,
    /// The sides that reach into each row of bins.
    bands: Lists,
}

/// The view from a point.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    visibility: &'a Visibility,
    from: [f64; 2],
    /// Whether the outline is so near that it may hide something.
    is_near: bool,
    is_inside: bool,
}

/// Square bins over the outline's box, with the sides that reach into each.
#[derive(Clone, Debug)]
struct Bins {
    origin: [f64; 2],
    side: f64,
    counts: [usize; 2],
    sides: Lists,
    /// Whether a side reaches into the bin or one of the eight around it.
    near: Vec<bool>,
}

/// Lists one behind the other: the i-th is `items[start[i]..start[i + 1]]`.
#[derive(Clone, Debug)]
struct Lists {
    start: Vec<u32>,
    items: Vec<u32>,
}

/// Parallels are shorter by so many ε at either end: a corner of 1.2° holds the end of one.
const TRIM: f64 = 100.0;

/// Bins are made wider until there are no more of them for each side than this, and for a few sides.
const MOST_BINS: f64 = 64.0;
const FEW_SIDES: f64 = 4096.0;

impl Visibility {
    /// `reach`: no bond is longer [m].
    pub fn new(body: &Outline, spacing: f64, reach: f64) -> Visibility {
        let sides: Vec<Segment> = body.segments().filter(|[a, b]| a != b).collect();
        let tolerance = ON_BOUNDARY * spacing;
        let bins = Bins::new(body, &sides, reach + 2.0 * tolerance);
        let rows = |side: &Segment| {
            let [low, high] = range(*side, 1);
            bins.index(1, low)..=bins.index(1, high)
        };
        let bands = Lists::new(bins.counts[1], &sides, |side, add| rows(side).for_each(add));
        Visibility {
            sides,
            tolerance,
            bins,
            bands,
        }
    }

    /// The visibility in a body in which nothing is hidden, such as a convex one.
    pub fn unlimited() -> Visibility {
        Visibility::new(&Outline::default(), 1.0, 1.0)
    }

    /// The view from a point in the body.
    pub fn from(&self, x: [f64; 2]) -> View<'_> {
        let is_near = self.bins.near[self.bins.at(x)];
        View {
            visibility: self,
            from: x,
            is_near,
            is_inside: !is_near || self.contains(x),
        }
    }

    /// Whether two points in the body see each other.
    pub fn sees(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        self.from(a).sees(b)
    }

    /// A parallel of a bond on its left (`side` = 1) or right (−1).
    fn parallel(&self, [a, b]: Segment, side: f64) -> Segment {
        let along = [b[0] - a[0], b[1] - a[1]];
        let scale = self.tolerance / along[0].hypot(along[1]);
        let t = along.map(|x| x * scale);
        let n = [-t[1] * side, t[0] * side];
        let t = t.map(|t| TRIM * t);
        [
            [a[0] + (n[0] + t[0]), a[1] + (n[1] + t[1])],
            [b[0] + (n[0] - t[0]), b[1] + (n[1] - t[1])],
        ]
    }

    /// Whether a segment meets the outline, touching included.
    fn meets(&self, bond: Segment) -> bool {
        let [x, y] = [range(bond, 0), range(bond, 1)];
        let bins = &self.bins;
        let columns = bins.index(0, x[0])..=bins.index(0, x[1]);
        (bins.index(1, y[0])..=bins.index(1, y[1])).any(|row| {
            columns.clone().any(|column| {
                let near = bins.sides.of(row * bins.counts[0] + column).iter();
                near.map(|&side| self.sides[side as usize])
                    .any(|side| boxes_meet(side, [x, y]) && meet(side, bond))
            })
        })
    }

    /// Whether a point lies inside the outline: how many sides a line from it to the left crosses.
    fn contains(&self, x: [f64; 2]) -> bool {
        let crossed = |&&side: &&u32| {
            let [a, b] = self.sides[side as usize];
            let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            low[1] <= x[1] && x[1] < high[1] && orientation(low, high, x) < 0.0
        };
        let band = self.bands.of(self.bins.index(1, x[1]));
        band.iter().filter(crossed).count() % 2 == 1
    }
}

impl View<'_> {
    /// Whether anything within reach may be hidden.
    pub fn is_near(&self) -> bool {
        self.is_near
    }

    /// Whether the point sees another one in the body, no farther away than the reach.
    pub fn sees(&self, other: [f64; 2]) -> bool {
        let Visibility { tolerance, .. } = *self.visibility;
        let bond = [self.from, other];
        if !self.is_near || (self.is_inside && !self.visibility.meets(bond)) {
            return true;
        }
        let apart = |axis: usize| (other[axis] - self.from[axis]).abs();
        let is_point = (0..2).all(|axis| apart(axis) <= 2.0 * TRIM * tolerance);
        is_point
            || [1.0, -1.0].into_iter().any(|side| {
                let parallel = self.visibility.parallel(bond, side);
                !self.visibility.meets(parallel) && self.visibility.contains(parallel[0])
            })
    }
}

impl Bins {
    fn new(body: &Outline, sides: &[Segment], side: f64) -> Bins {
        let [low, high] = if sides.is_empty() {
            [[0.0; 2]; 2]
        } else {
            body.bounds()
        };
        let extent = [0, 1].map(|axis| high[axis] - low[axis]);
        let most = MOST_BINS * (sides.len() as f64 + FEW_SIDES);
        let side = side.max((extent[0].max(side) * extent[1].max(side) / most).sqrt());
        let counts = extent.map(|extent| (extent / side) as usize + 1);
        let mut bins = Bins {
            origin: low,
            side,
            counts,
            sides: Lists {
                start: vec![0],
                items: Vec::new(),
            },
            near: Vec::new(),
        };
        let lists = Lists::new(counts[0] * counts[1], sides, |&side, add| {
            bins.visit(side, add);
        });
        bins.near = vec![false; counts[0] * counts[1]];
        for bin in (0..bins.near.len()).filter(|&bin| !lists.of(bin).is_empty()) {
            let [x, y] = [bin % counts[0], bin / counts[0]];
            for row in y.saturating_sub(1)..=(y + 1).min(counts[1] - 1) {
                for column in x.saturating_sub(1)..=(x + 1).min(counts[0] - 1) {
                    bins.near[row * counts[0] + column] = true;
                }
            }
        }
        bins.sides = lists;
        bins
    }

    fn index(&self, axis: usize, x: f64) -> usize {
        let index = ((x - self.origin[axis]) / self.side).max(0.0) as usize;
        index.min(self.counts[axis] - 1)
    }

    fn at(&self, [x, y]: [f64; 2]) -> usize {
        self.index(1, y) * self.counts[0] + self.index(0, x)
    }

    /// The bins that a side reaches into, row by row, and one more at either end, lest rounding leaves
    /// one out.
    fn visit(&self, side: Segment, mut visit: impl FnMut(usize)) {
        let [low, high] = range(side, 1);
        let [from, to] = range(side, 0);
        let [a, b] = side;
        for row in self.index(1, low)..=self.index(1, high) {
            let edge = |k: usize| self.origin[1] + k as f64 * self.side;
            let at = |y: f64| {
                let t = (y - a[1]) / (b[1] - a[1]);
                let x = a[0] + t.clamp(0.0, 1.0) * (b[0] - a[0]);
                if x.is_finite() { x } else { a[0] }
            };
            let [p, q] = if a[1] == b[1] {
                [from, to]
            } else {
                [at(edge(row)), at(edge(row + 1))]
            };
            let first = self.index(0, p.min(q)).saturating_sub(1);
            let last = (self.index(0, p.max(q)) + 1).min(self.counts[0] - 1);
            (first..=last).for_each(|column| visit(row * self.counts[0] + column));
        }
    }
}

impl Lists {
    /// `visit` calls what it is given with every list that an item belongs to.
    fn new<T>(count: usize, items: &[T], visit: impl Fn(&T, &mut dyn FnMut(usize))) -> Lists {
        let mut start = vec![0_u32; count + 1];
        for item in items {
            visit(item, &mut |list| start[list + 1] += 1);
        }
        for list in 0..count {
            start[list + 1] += start[list];
        }
        let mut next = start.clone();
        let mut sorted = vec![0; start[count] as usize];
        for (number, item) in items.iter().enumerate() {
            visit(item, &mut |list| {
                sorted[next[list] as usize] = number as u32;
                next[list] += 1;
            });
        }
        Lists {
            start,
            items: sorted,
        }
    }

    fn of(&self, list: usize) -> &[u32] {
        &self.items[self.start[list] as usize..self.start[list + 1] as usize]
    }
}

fn range([a, b]: Segment, axis: usize) -> [f64; 2] {
    [a[axis].min(b[axis]), a[axis].max(b[axis])]
}

fn boxes_meet(side: Segment, ranges: [[f64; 2]; 2]) -> bool {
    (0..2).all(|axis| {
        let ([a, b], [low, high]) = (side, ranges[axis]);
        (a[axis] <= high || b[axis] <= high) && (a[axis] >= low || b[axis] >= low)
    })
}

/// Whether two segments whose boxes meet have a point in common.
fn meet([a, b]: Segment, [p, q]: Segment) -> bool {
    let apart =
        |first: f64, second: f64| (first > 0.0 && second > 0.0) || (first < 0.0 && second < 0.0);
    !apart(orientation(a, b, p), orientation(a, b, q))
        && !apart(orientation(p, q, a), orientation(p, q, b))
}

/// Positive where c lies on the left of ab; its sign is exact.
fn orientation(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of the side 1 from (0, 0) with a notch of the width 2w from above to the middle.
    fn notched(w: f64) -> Outline {
        let tip = if w > 0.0 {
            vec![[0.5 + w, 0.5], [0.5 - w, 0.5]]
        } else {
            vec![[0.5, 0.5]]
        };
        let mut outline = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5 + w, 1.0]];
        outline.extend(tip);
        outline.extend([[0.5 - w, 1.0], [0.0, 1.0]]);
        Outline {
            loops: vec![outline],
        }
    }

    #[test]
    fn a_notch_and_a_slit_hide_what_lies_across() {
        for w in [0.01, 0.0] {
            let view = Visibility::new(&notched(w), 0.1, 0.4);
            let sees = |a, b| {
                assert_eq!(view.sees(a, b), view.sees(b, a));
                view.sees(a, b)
            };
            assert!(!sees([0.45, 0.75], [0.55, 0.75]));
            assert!(!sees([0.35, 0.55], [0.65, 0.55]));
            assert!(!sees([0.45, 0.55], [0.65, 0.45]));
            assert!(sees([0.45, 0.45], [0.55, 0.45]), "under the tip");
            assert!(sees([0.35, 0.75], [0.45, 0.75]), "on one side");
            // Exactly under the tip, and on the sides.
            assert!(sees([0.4, 0.5], [0.7, 0.5]), "past the tip");
            assert!(sees([0.0, 0.2], [0.0, 0.5]), "along a side");
            assert!(!sees([0.4, 1.0], [0.6, 1.0]), "across the mouth");
            assert!(sees([0.5 - w, 0.6], [0.5 - w, 0.9]), "along the notch");
        }
    }

    #[test]
    fn corners_see_along_and_across() {
        let outline = Outline {
            loops: vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]],
        };
        let view = Visibility::new(&outline, 0.1, 0.4);
        for steps in [[1, 0], [1, 1], [2, 2], [3, 1], [1, 3], [0, 2]] {
            let [x, y] = steps.map(|k| 0.1 * f64::from(k));
            for (a, b) in [
                ([0.0, 0.0], [x, y]),
                ([1.0, 0.0], [1.0 - x, y]),
                ([1.0, 1.0], [1.0 - x, 1.0 - y]),
                ([0.0, 1.0], [x, 1.0 - y]),
            ] {
                assert!(view.sees(a, b) && view.sees(b, a), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn what_is_rough_by_rounding_hides_nothing() {
        let rough = |k: usize| 1e-10 * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut side: Vec<[f64; 2]> = (0..=40).map(|k| [0.025 * k as f64, rough(k)]).collect();
        side.extend([[1.0, 1.0], [0.0, 1.0]]);
        let outline = Outline { loops: vec![side] };
        let view = Visibility::new(&outline, 0.1, 0.4);
        for k in 0..=6 {
            for (p, q) in [(4, 0), (3, 1), (1, 3), (0, 4)] {
                let a = [0.1 * f64::from(k), 0.0];
                let b = [a[0] + 0.1 * f64::from(p), 0.1 * f64::from(q)];
                assert!(b[0] > 1.0 + 1e-9 || view.sees(a, b), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_hole_smaller_than_the_horizon_hides_what_is_behind_it() {
        let mut outline = notched(0.01);
        outline.loops[0] = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        outline
            .loops
            .push(vec![[0.5, 0.4], [0.4, 0.5], [0.5, 0.6], [0.6, 0.5]]);
        let view = Visibility::new(&outline, 0.1, 0.4);
        assert!(!view.sees([0.35, 0.5], [0.65, 0.5]));
        assert!(!view.sees([0.5, 0.35], [0.5, 0.65]), "through two corners");
        assert!(view.sees([0.3, 0.6], [0.7, 0.6]), "past a corner");
        assert!(view.sees([0.4, 0.5], [0.5, 0.6]), "along its side");
    }
}
