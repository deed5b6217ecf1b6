//! What a child passes up, added to the front of its parent (extend-add; Duff & Reid 1983).

use super::tiles::PANEL;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Some columns of a front, from a row on.
pub struct Part<'a> {
    pub values: &'a mut [f64],
    pub columns: Range<usize>,
    pub first_row: usize,
    /// Rows from there on.
    pub height: usize,
}

/// Which entries of an update count. They are stored column by column in panels of [`PANEL`] of them; those of a
/// lower triangle without the rows above the panel.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Entries {
    All,
    Lower,
}

impl Entries {
    /// How many numbers an update of so many rows has.
    pub fn count(self, rows: usize) -> usize {
        let last = rows / PANEL * PANEL;
        self.before(last, rows) + (rows - last) * (rows - self.first_row(last))
    }

    /// The first row of the panel that a column is in.
    pub fn first_row(self, column: usize) -> usize {
        match self {
            Entries::All => 0,
            Entries::Lower => column / PANEL * PANEL,
        }
    }

    /// How many numbers stand before the panel that begins with a column.
    fn before(self, column: usize, rows: usize) -> usize {
        match self {
            Entries::All => column * rows,
            Entries::Lower => column * (2 * rows + PANEL - column) / 2,
        }
    }

    /// A column of an update from its first row on, of which those above its panel are others' numbers.
    #[inline(always)]
    fn column(self, update: &[f64], column: usize, rows: usize) -> &[f64] {
        let first = self.first_row(column);
        let panel = self.before(column / PANEL * PANEL, rows);
        &update[panel + column % PANEL * (rows - first) - first..][..rows]
    }
}

/// Rows of a child that are next to each other in its parent.
pub struct Runs {
    /// Row of the child, row of the parent's front, length; ascending.
    runs: Vec<[usize; 3]>,
    rows: usize,
    /// Columns of the parent.
    width: usize,
}

impl Runs {
    pub fn new(places: &[u32], width: usize) -> Runs {
        let mut runs: Vec<[usize; 3]> = Vec::new();
        for (row, &place) in places.iter().enumerate() {
            let place = place as usize;
            match runs.last_mut() {
                // Columns and rows of the parent go to different places.
                Some([_, begin, length]) if *begin + *length == place && place != width => {
                    *length += 1;
                }
                _ => runs.push([row, place, 1]),
            }
        }
        Runs {
            runs,
            rows: places.len(),
            width,
        }
    }

    /// How many of the child's rows are the parent's columns.
    pub fn inside(&self) -> usize {
        let after = self.runs.iter().find(|[_, place, _]| *place >= self.width);
        after.map_or(self.rows, |&[row, ..]| row)
    }

    /// Row of the parent's front for each row of the child.
    pub fn places(&self) -> impl Iterator<Item = usize> + '_ {
        let places = |&[_, place, length]: &[usize; 3]| place..place + length;
        self.runs.iter().flat_map(places)
    }

    /// Adds what falls into a part of the parent's front, which begins at its first row or at the first that it
    /// passes on.
    pub fn add(&self, update: &[f64], part: &mut Part, entries: Entries) {
        Arch::new().dispatch(Added {
            runs: self,
            update,
            part,
            entries,
        });
    }
}

struct Added<'a, 'p> {
    runs: &'a Runs,
    update: &'a [f64],
    part: &'a mut Part<'p>,
    entries: Entries,
}

impl WithSimd for Added<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Added {
            runs,
            update,
            part,
            entries,
        } = self;
        let (begin, end) = (part.columns.start, part.columns.end);
        let all = &runs.runs;
        let first = all.partition_point(|&[_, place, length]| place + length <= begin);
        let reached = all[first..].partition_point(|&[_, place, _]| place < end);
        let below = all.partition_point(|&[_, place, _]| place < part.first_row);
        for k in first..first + reached {
            let [row, place, length] = all[k];
            for j in begin.saturating_sub(place)..length.min(end - place) {
                let from = entries.column(update, row + j, runs.rows);
                let to = &mut part.values[(place + j - begin) * part.height..][..part.height];
                let rest = match entries {
                    Entries::All => &all[below..],
                    Entries::Lower => {
                        let own = &from[row + j..row + length];
                        add(&mut to[place + j - part.first_row..], own);
                        &all[k + 1..]
                    }
                };
                for &[row, place, length] in rest {
                    add(&mut to[place - part.first_row..], &from[row..row + length]);
                }
            }
        }
    }
}

/// Most runs are short: four at a time without a longer loop before it.
#[inline(always)]
fn add(to: &mut [f64], from: &[f64]) {
    let to = &mut to[..from.len()];
    let (to, to_rest) = to.as_chunks_mut::<4>();
    let (from, from_rest) = from.as_chunks::<4>();
    for (to, from) in to.iter_mut().zip(from) {
        for lane in 0..4 {
            to[lane] += from[lane];
        }
    }
    let (to, to_rest) = to_rest.as_chunks_mut::<2>();
    let (from, from_rest) = from_rest.as_chunks::<2>();
    if let ([to], [from]) = (to, from) {
        to[0] += from[0];
        to[1] += from[1];
    }
    if let ([to], [from]) = (to_rest, from_rest) {
        *to += from;
    }
}
