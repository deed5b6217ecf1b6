//! What a child passes up, added to the front of its parent (extend-add; Duff & Reid 1983).

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

/// Which entries of a child's update count.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Entries {
    All,
    Lower,
}

/// Rows of a child that are next to each other in its parent.
pub struct Runs {
    /// Row of the child, row of the parent's front, length; ascending.
    runs: Vec<[usize; 3]>,
    rows: usize,
    /// Columns of the parent.
    width: usize,
    /// Nothing but the lower triangle of the update is stored.
    packed: bool,
}

impl Runs {
    pub fn new(places: &[u32], width: usize, packed: bool) -> Runs {
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
            packed,
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
    /// passes on; of the update column by column.
    pub fn add(&self, update: &[f64], part: &mut Part, entries: Entries) {
        Arch::new().dispatch(Added {
            runs: self,
            update,
            part,
            entries,
        });
    }

    /// A column of the update, from its first row on, stored or not.
    #[inline(always)]
    fn column<'u>(&self, update: &'u [f64], column: usize) -> &'u [f64] {
        let missing = match self.packed {
            true => column * (column + 1) / 2,
            false => 0,
        };
        &update[column * self.rows - missing..][..self.rows]
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
                let from = runs.column(update, row + j);
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
