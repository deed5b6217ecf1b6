//! The parts that threads take: their bounds decide the order of sums, and so the bits.

use rayon::prelude::*;
use std::ops::Range;

/// Columns are shared out in this many parts, whatever the number of threads.
pub const PARTS: usize = 8;

/// Parts of `count` columns.
pub fn column_parts(count: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    (0..PARTS)
        .into_par_iter()
        .map(move |part| part_bound(part, count)..part_bound(part + 1, count))
}

pub fn part_bound(part: usize, count: usize) -> usize {
    part * count / PARTS
}
