//! One lattice line's strip, cut where its crossings with the region's outline change.

use super::side::{Arc, Average, Frame, Side};

/// A place at which a chain of bonds enters or leaves the region.
#[derive(Clone, Debug)]
pub enum Crossing {
    /// Through the interface: the finite elements there, averaged over the sub-strip.
    Interface(Average),
    /// Through a free side, at this mean of ℓ [m].
    Free(f64),
}

impl Crossing {
    /// Mean of ℓ [m].
    pub fn along(&self) -> f64 {
        match self {
            Crossing::Interface(average) => average.along,
            Crossing::Free(along) => *along,
        }
    }
}

/// A stretch of the line within the region.
#[derive(Clone, Debug)]
pub struct Interval {
    pub ends: [Crossing; 2],
    /// Ranges of ℓ in which it passes through the empty outside all the same, by two free sides [m].
    pub gaps: Vec<[f64; 2]>,
}

/// A part of the strip whose lines all cross the same sides.
#[derive(Clone, Debug)]
pub struct SubStrip {
    /// φ, its share of the strip's width [-].
    pub share: f64,
    /// Distance from the lattice line to its own middle [m].
    pub offset: f64,
    /// Its middle, mean of η [m].
    pub across: f64,
    pub intervals: Vec<Interval>,
}

/// The outline in the directions of one family.
pub struct Outlook<'a> {
    pub frame: Frame,
    pub sides: &'a [Side],
    pub arcs: Vec<Arc>,
    /// η of free sides that run along the lines [m].
    pub edges: Vec<f64>,
    /// Values of η that differ by less are one [m].
    pub tolerance: f64,
    /// The longest piece of interface, along the lines, that one part of a strip crosses [m].
    pub longest: f64,
}

/// A part of the strip between two cuts, with the arcs that it crosses in the order of ℓ.
struct Piece {
    range: [f64; 2],
    arcs: Vec<usize>,
    /// Pairs of positions in `arcs`: where intervals begin and end.
    intervals: Vec<[usize; 2]>,
}

impl Outlook<'_> {
    /// The parts of the strip of `width` about `centre` that hold some of the region; `arcs` are
    /// those that reach into it.
    pub fn sub_strips(&self, centre: f64, width: f64, arcs: &[usize]) -> Vec<SubStrip> {
        let whole = [centre - 0.5 * width, centre + 0.5 * width];
        let pieces: Vec<Piece> = self
            .cuts(whole, arcs)
            .windows(2)
            .map(|cut| self.piece([cut[0], cut[1]], arcs))
            .collect();
        let body = self.without_void(whole, &pieces);
        let width = body[1] - body[0];
        let line = if body == whole {
            centre
        } else {
            0.5 * (body[0] + body[1])
        };
        let mut joined: Vec<&[Piece]> = Vec::new();
        let mut first = 0;
        for next in 1..=pieces.len() {
            let goes_on = |next: usize| {
                self.continues(&pieces[next - 1], &pieces[next])
                    && !self.is_long(&pieces[first], &pieces[next])
            };
            if next == pieces.len() || !goes_on(next) {
                joined.push(&pieces[first..next]);
                first = next;
            }
        }
        joined.retain(|pieces| !pieces[0].intervals.is_empty());
        let sub_strip = |pieces: &[Piece]| {
            let [low, high] = [pieces[0].range[0], pieces[pieces.len() - 1].range[1]];
            let across = 0.5 * (low + high);
            let offset = across - line;
            SubStrip {
                share: (high - low) / width,
                offset: if offset.abs() > self.tolerance {
                    offset
                } else {
                    0.0
                },
                across,
                intervals: self.intervals(pieces),
            }
        };
        joined.into_iter().map(sub_strip).collect()
    }

    /// η of the strip's borders and of all ends of arcs between them, ascending.
    fn cuts(&self, [low, high]: [f64; 2], arcs: &[usize]) -> Vec<f64> {
        let inside = |eta: &f64| *eta > low + self.tolerance && *eta < high - self.tolerance;
        let ends = arcs.iter().flat_map(|&a| self.arcs[a].range);
        let along = arcs.iter().flat_map(|&a| self.divisions(a, [low, high]));
        let mut inner: Vec<f64> = ends.chain(along).filter(inside).collect();
        inner.sort_unstable_by(f64::total_cmp);
        inner.dedup_by(|next, last| *next - *last <= self.tolerance);
        let mut cuts = vec![low];
        cuts.append(&mut inner);
        cuts.push(high);
        cuts
    }

    /// Values of η at which an arc that runs nearly along the lines is cut [m].
    fn divisions(&self, arc: usize, [low, high]: [f64; 2]) -> Vec<f64> {
        let Arc { range, is_free, .. } = self.arcs[arc];
        let (low, high) = (low.max(range[0]), high.min(range[1]));
        if is_free || low >= high {
            return Vec::new();
        }
        let extent = (self.along_at(arc, high) - self.along_at(arc, low)).abs();
        let parts = (extent / self.longest).ceil() as usize;
        (1..parts)
            .map(|k| low + (high - low) * k as f64 / parts as f64)
            .collect()
    }

    fn piece(&self, range: [f64; 2], arcs: &[usize]) -> Piece {
        let middle = 0.5 * (range[0] + range[1]);
        let crosses = |&a: &usize| {
            let [low, high] = self.arcs[a].range;
            low < middle && middle < high
        };
        let mut crossed: Vec<(f64, usize)> = arcs
            .iter()
            .copied()
            .filter(crosses)
            .map(|a| (self.along_at(a, middle), a))
            .collect();
        crossed.sort_by(|p, q| p.0.total_cmp(&q.0));
        let arcs: Vec<usize> = crossed.into_iter().map(|(_, a)| a).collect();
        let mut intervals: Vec<[usize; 2]> = Vec::new();
        let mut entered = None;
        for (place, &a) in arcs.iter().enumerate() {
            if self.arcs[a].enters {
                entered = entered.or(Some(place));
            } else if let Some(start) = entered.take() {
                match intervals.last_mut() {
                    // What lies between two free sides is for the chain to tell.
                    Some(last) if self.is_free(&arcs, last[1]) && self.is_free(&arcs, start) => {
                        last[1] = place;
                    }
                    _ => intervals.push([start, place]),
                }
            }
        }
        Piece {
            range,
            arcs,
            intervals,
        }
    }

    fn is_free(&self, arcs: &[usize], place: usize) -> bool {
        self.arcs[arcs[place]].is_free
    }

    fn along_at(&self, arc: usize, across: f64) -> f64 {
        let arc = &self.arcs[arc];
        self.sides[arc.side].along_at(arc, &self.frame, across)
    }

    /// Whether the lines of two neighbouring pieces cross one interface, and both or neither a free
    /// side.
    fn continues(&self, piece: &Piece, next: &Piece) -> bool {
        let cut = piece.range[1];
        let same_end = |p: usize, q: usize| match [p, q].map(|a| self.arcs[a].is_free) {
            [true, true] => true,
            [false, false] => {
                let jump = self.along_at(p, cut) - self.along_at(q, cut);
                jump.abs() <= 1e3 * self.tolerance
            }
            _ => false,
        };
        piece.intervals.len() == next.intervals.len()
            && piece
                .intervals
                .iter()
                .zip(&next.intervals)
                .all(|(p, q)| (0..2).all(|end| same_end(piece.arcs[p[end]], next.arcs[q[end]])))
    }

    /// Whether the lines cross too long a piece of interface from the one piece through the other.
    fn is_long(&self, first: &Piece, last: &Piece) -> bool {
        first.intervals.iter().zip(&last.intervals).any(|(p, q)| {
            (0..2).any(|end| {
                let (p, q) = (first.arcs[p[end]], last.arcs[q[end]]);
                let extent = self.along_at(p, first.range[0]) - self.along_at(q, last.range[1]);
                !self.arcs[p].is_free && extent.abs() > self.longest
            })
        })
    }

    /// The strip without what lies beyond a free side that runs along it: lattice points on such a
    /// side, or less than dx/2 from it, stand for the rest alone.
    fn without_void(&self, whole: [f64; 2], pieces: &[Piece]) -> [f64; 2] {
        let [mut low, mut high] = whole;
        let is_edge = |eta: f64| {
            let near = |edge: &f64| (edge - eta).abs() <= 2.0 * self.tolerance;
            self.edges.iter().any(near)
        };
        let filled = |piece: &&Piece| !piece.intervals.is_empty();
        if let Some(first) = pieces.iter().find(filled).map(|p| p.range[0])
            && is_edge(first)
        {
            low = first;
        }
        if let Some(last) = pieces.iter().rev().find(filled).map(|p| p.range[1])
            && is_edge(last)
        {
            high = last;
        }
        [low, high]
    }

    /// The intervals of joined pieces, averaged over their widths.
    fn intervals(&self, pieces: &[Piece]) -> Vec<Interval> {
        let total: f64 = pieces.iter().map(|p| p.range[1] - p.range[0]).sum();
        let mean = |which: &dyn Fn(&Piece) -> usize| {
            let mut sum = Average::default();
            let mut is_free = false;
            for piece in pieces {
                let share = (piece.range[1] - piece.range[0]) / total;
                let arc = &self.arcs[which(piece)];
                let part = self.sides[arc.side].average(arc, &self.frame, piece.range);
                sum.along += share * part.along;
                sum.shares
                    .extend(part.shares.iter().map(|&(node, n)| (node, share * n)));
                is_free = arc.is_free;
            }
            if is_free {
                Crossing::Free(sum.along)
            } else {
                Crossing::Interface(sum)
            }
        };
        let gaps = |interval: [usize; 2]| {
            let piece = &pieces[0];
            let middle = 0.5 * (piece.range[0] + piece.range[1]);
            let inner = &piece.arcs[interval[0] + 1..interval[1]];
            let along = |a: usize| self.along_at(a, middle);
            inner
                .chunks_exact(2)
                .map(|pair| [along(pair[0]), along(pair[1])])
                .collect()
        };
        (0..pieces[0].intervals.len())
            .map(|i| Interval {
                ends: [0, 1].map(|end| mean(&|piece| piece.arcs[piece.intervals[i][end]])),
                gaps: gaps(pieces[0].intervals[i]),
            })
            .collect()
    }
}
