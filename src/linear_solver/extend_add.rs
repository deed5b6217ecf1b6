//! What a child passes up, added to the front of its parent (extend-add; Duff & Reid 1983).

use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Rows of a child that are next to each other in its parent.
pub struct Runs {
    /// Row of the child, row of the parent's front, length; ascending.
    runs: Vec<[usize; 3]>,
    rows: usize,
    /// Columns of the parent.
    width: usize,
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

    /// Adds the part of a lower triangle that falls into the parent's columns.
    pub fn add_columns(&self, update: &[f64], block: &mut [f64], height: usize) {
        self.add(update, block, height, 0..self.width, true);
    }

    /// Adds the part of a lower triangle that the parent passes on.
    pub fn add_rest(&self, update: &[f64], passed: &mut [f64], rows: usize) {
        self.add(update, passed, rows, self.width..usize::MAX, true);
    }

    /// As [`Runs::add_columns`], all rows.
    pub fn add_full_columns(&self, update: &[f64], block: &mut [f64], height: usize) {
        self.add(update, block, height, 0..self.width, false);
    }

    /// As [`Runs::add_rest`], all rows.
    pub fn add_full_rest(&self, update: &[f64], passed: &mut [f64], rows: usize) {
        self.add(update, passed, rows, self.width..usize::MAX, false);
    }

    fn add(
        &self,
        update: &[f64],
        front: &mut [f64],
        height: usize,
        columns: Range<usize>,
        lower: bool,
    ) {
        Added {
            runs: &self.runs,
            update,
            rows: self.rows,
            front,
            height,
            first: columns.start,
            end: columns.end,
            lower,
            packed: self.packed,
        }
        .add();
    }
}

/// Adds rows of an update that are next to each other to where they are next to each other in a front.
struct Added<'a> {
    /// Row in the update, row in the front, length; ascending.
    pub runs: &'a [[usize; 3]],
    /// Column by column.
    pub update: &'a [f64],
    pub rows: usize,
    /// Columns of the front from `first` on, its rows from `first` on.
    pub front: &'a mut [f64],
    pub height: usize,
    pub first: usize,
    pub end: usize,
    /// The lower triangle only.
    pub lower: bool,
    /// Nothing else is stored of the update.
    pub packed: bool,
}

impl Added<'_> {
    pub fn add(self) {
        Arch::new().dispatch(self);
    }
}

impl WithSimd for Added<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (first, height) = (self.first, self.height);
        for (k, &[row, place, length]) in self.runs.iter().enumerate() {
            if place < first || place >= self.end {
                continue;
            }
            for j in 0..length {
                let column = row + j;
                let missing = if self.packed {
                    column * (column + 1) / 2
                } else {
                    0
                };
                let from = &self.update[column * self.rows - missing..][..self.rows];
                let to = &mut self.front[(place - first + j) * height..][..height];
                let runs = if self.lower {
                    let own = &from[row + j..row + length];
                    add(&mut to[place - first + j..], own);
                    &self.runs[k + 1..]
                } else {
                    self.runs
                };
                for &[row, place, length] in runs {
                    if place >= first {
                        add(&mut to[place - first..], &from[row..row + length]);
                    }
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
