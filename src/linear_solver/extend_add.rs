//! Extend-add: the update of a child is added to the front of its parent (Duff & Reid 1983).

use super::policy::PANEL;
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

// Updates are lower triangles, stored column by column in panels of [`PANEL`] of them without the rows above the
// panel.

/// How many numbers an update of so many rows has.
pub fn update_entries(rows: usize) -> usize {
    let last = rows / PANEL * PANEL;
    entries_before(last, rows) + (rows - last) * (rows - last)
}

/// The first row of the panel that a column is in.
pub fn first_row(column: usize) -> usize {
    column / PANEL * PANEL
}

/// How many numbers stand before the panel that begins with a column.
fn entries_before(column: usize, rows: usize) -> usize {
    column * (2 * rows + PANEL - column) / 2
}

/// A column of an update from its first row on, of which those above its panel are others' numbers.
#[inline(always)]
fn update_column(update: &[f64], column: usize, rows: usize) -> &[f64] {
    let first = first_row(column);
    &update[entries_before(first, rows) + column % PANEL * (rows - first) - first..][..rows]
}

/// Rows of a child that are next to each other in its parent.
pub struct Runs {
    /// Row of the child, row of the parent's front, length; ascending.
    runs: Vec<[usize; 3]>,
    rows: usize,
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
        }
    }

    /// Adds what falls into a part of the parent's front, which begins at its first row or at the first that it
    /// passes on.
    pub fn add(&self, update: &[f64], part: &mut Part) {
        Arch::new().dispatch(Added {
            runs: self,
            update,
            part,
        });
    }
}

struct Added<'a, 'p> {
    runs: &'a Runs,
    update: &'a [f64],
    part: &'a mut Part<'p>,
}

impl WithSimd for Added<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Added { runs, update, part } = self;
        let (begin, end) = (part.columns.start, part.columns.end);
        let all = &runs.runs;
        let first = all.partition_point(|&[_, place, length]| place + length <= begin);
        let reached = all[first..].partition_point(|&[_, place, _]| place < end);
        for k in first..first + reached {
            let [row, place, length] = all[k];
            for j in begin.saturating_sub(place)..length.min(end - place) {
                let from = update_column(update, row + j, runs.rows);
                let to = &mut part.values[(place + j - begin) * part.height..][..part.height];
                add(
                    &mut to[place + j - part.first_row..],
                    &from[row + j..row + length],
                );
                for &[row, place, length] in &all[k + 1..] {
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
