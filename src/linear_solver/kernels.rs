//! The inner loops of solutions, compiled for the processor's vector instructions.
//!
//! A vector holds the numbers of `K` right-hand sides row by row: [f64; K]. One by itself fills the processor's
//! lanes with rows, eight fill them with right-hand sides. Sums are kept in fixed lanes and products are rounded
//! before they are added, so that the bits depend neither on the processor nor on `K`.

mod backward;
mod forward;

use super::policy::{BLOCK_PARTS, LARGE_BLOCK};
use backward::{Backward, Gather};
use forward::{Forward, Pass};
use pulp::Arch;
use rayon::prelude::*;
use std::array::from_fn;
use std::ops::Range;

/// Columns of L that are worked on together; four, two and one at the end of a block.
const STRIP: usize = 8;

/// Rows that are worked on together; two and one at the end of a block.
const LANES: usize = 4;

/// A block of L: column by column, own rows first.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    pub values: &'a [f64],
    pub width: usize,
    pub height: usize,
}

impl<'a> Block<'a> {
    /// Some rows of `C` columns from one on.
    #[inline(always)]
    fn columns<const C: usize>(&self, begin: usize, rows: Range<usize>) -> [&'a [f64]; C] {
        from_fn(|j| &self.values[(begin + j) * self.height..][rows.clone()])
    }

    /// Whether it is shared out to the threads: the sum of a row up, and of a column down, is the same in any part.
    fn is_large(&self) -> bool {
        self.width * (self.height - self.width) > LARGE_BLOCK
    }

    /// f ← [L11⁻¹ f_own, f_rows − L21 L11⁻¹ f_own].
    pub fn forward<const K: usize>(self, f: &mut [[f64; K]]) {
        let (block, arch) = (self, Arch::new());
        if !block.is_large() {
            return arch.dispatch(Forward { block, f });
        }
        let (own, rows) = f.split_at_mut(block.width);
        arch.dispatch(Forward { block, f: own });
        let length = part(rows.len(), LANES);
        let parts = rows.par_chunks_mut(length).enumerate();
        parts.for_each(|(k, f)| {
            let (y, first) = (&*own, block.width + k * length);
            arch.dispatch(Pass { block, first, y, f });
        });
    }

    /// f_own ← L11⁻ᵀ (f_own − L21ᵀ f_rows).
    pub fn backward<const K: usize>(self, f: &mut [[f64; K]]) {
        let (block, arch) = (self, Arch::new());
        if !block.is_large() {
            return arch.dispatch(Backward { block, f });
        }
        let (own, rows) = f.split_at_mut(block.width);
        let length = part(own.len(), STRIP);
        let parts = own.par_chunks_mut(length).enumerate();
        parts.for_each(|(k, f)| {
            let (rows, first) = (&*rows, k * length);
            arch.dispatch(Gather {
                block,
                first,
                rows,
                f,
            });
        });
        arch.dispatch(Backward { block, f: own });
    }
}

/// The length of a part of `count`.
fn part(count: usize, unit: usize) -> usize {
    count.div_ceil(BLOCK_PARTS).next_multiple_of(unit)
}

/// The columns from `begin` to `end`, `most` at a time while there are as many, then four, two and one.
#[inline(always)]
fn strips(begin: usize, end: usize, most: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut begin = begin;
    std::iter::from_fn(move || {
        let left = end - begin;
        let width = [most, 4, 2, 1]
            .into_iter()
            .find(|&w| w <= left && w <= most)?;
        begin += width;
        Some((begin - width, width))
    })
}

/// The first `N` of a slice.
#[inline(always)]
fn lanes<T: Copy, const N: usize>(slice: &[T]) -> [T; N] {
    slice[..N].try_into().expect("so many were taken")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every width and every kind of end, and blocks that are shared out, against the formula entry by entry;
    /// eight right-hand sides have the bits of one at a time.
    #[test]
    fn substitution_is_that_of_the_formula() {
        for width in 1..40 {
            for rows in [0, 1, 2, 3, 4, 6, 7, 50, 128] {
                compare(width, width + rows);
            }
        }
        for [width, rows] in [[202, 250], [213, 255], [64, 1000]] {
            compare(width, width + rows);
        }
    }

    fn compare(width: usize, height: usize) {
        // Sums of as many products of 1e-4, and numbers of 1e-2 at most.
        let rounding = 1e-16 * (10.0 + height as f64 * 0.1);
        let entry = |k: usize| 0.01 * ((k * 7 % 13) as f64 - 6.0) / 6.0;
        let mut values: Vec<f64> = (0..width * height).map(entry).collect();
        for j in 0..width {
            values[j * height + j] = 1.5 + 0.1 * j as f64;
        }
        let block = Block {
            values: &values,
            width,
            height,
        };
        let load = |k: usize| 1e-3 * ((k * 5 % 17) as f64 - 3.0);
        let loads: Vec<f64> = (0..height * 8).map(load).collect();
        let side_by_side = |i| from_fn(|k| loads[k * height + i]);
        let mut up: Vec<[f64; 8]> = (0..height).map(side_by_side).collect();
        let mut down = up.clone();
        block.forward(&mut up);
        block.backward(&mut down);
        for (k, load) in loads.chunks(height).enumerate() {
            let (mut alone_up, mut alone_down) = (load.to_vec(), load.to_vec());
            block.forward::<1>(alone_up.as_chunks_mut().0);
            block.backward::<1>(alone_down.as_chunks_mut().0);
            assert!(alone_up.iter().eq(up.iter().map(|f| &f[k])));
            assert!(alone_down.iter().eq(down.iter().map(|f| &f[k])));
            let (mut x, mut y) = (load.to_vec(), load.to_vec());
            for j in 0..width {
                let l = &values[j * height..][..height];
                x[j] /= l[j];
                for i in j + 1..height {
                    x[i] -= l[i] * x[j];
                }
            }
            for j in (0..width).rev() {
                let l = &values[j * height..][..height];
                for i in j + 1..height {
                    y[j] -= l[i] * y[i];
                }
                y[j] /= l[j];
            }
            let expected = x.iter().chain(&y);
            let found = alone_up.iter().chain(&alone_down);
            for (found, expected) in found.zip(expected) {
                assert!((found - expected).abs() < rounding, "{found} {expected}");
            }
        }
    }
}
