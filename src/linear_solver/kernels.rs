//! The inner loops of solutions, compiled for the processor's vector instructions.
//!
//! A vector holds the numbers of `K` right-hand sides row by row: [f64; K]. One by itself fills the processor's
//! lanes with rows, eight fill them with right-hand sides. Sums are kept in fixed lanes and products are rounded
//! before they are added, so that the bits depend neither on the processor nor on `K`.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::array::from_fn;
use std::ops::Range;

/// Columns of L that are worked on together; four and two at the end of a block, since nodes have two dofs.
const STRIP: usize = 8;

/// Rows that are, but for the last two.
const LANES: usize = 4;

/// On the way down, of several right-hand sides: columns and right-hand sides that are worked on together. Their
/// sums, in [`LANES`], fill half of the sixteen registers.
const FEW: usize = 2;
const HALF: usize = 4;

/// A block with more entries below its own rows is shared out to the threads, in so many parts. The sum of a row
/// up, and of a column down, is the same in any part.
const LARGE: usize = 50_000;
const PARTS: usize = 4;

/// A block of L: column by column, own rows first. Width and height are even.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    pub values: &'a [f64],
    pub width: usize,
    pub height: usize,
}

impl<'a> Block<'a> {
    /// Of `C` columns from one on, some rows.
    #[inline(always)]
    fn columns<const C: usize>(&self, begin: usize, rows: Range<usize>) -> [&'a [f64]; C] {
        from_fn(|j| &self.values[(begin + j) * self.height..][rows.clone()])
    }

    fn is_large(&self) -> bool {
        self.width * (self.height - self.width) > LARGE
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
    count.div_ceil(PARTS).next_multiple_of(unit)
}

/// The columns from `begin` to `end`, `most` at a time while there are as many, then four, then two.
#[inline(always)]
fn strips(begin: usize, end: usize, most: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut begin = begin;
    std::iter::from_fn(move || {
        let left = end - begin;
        let width = [most, 4, 2].into_iter().find(|&w| w <= left && w <= most)?;
        begin += width;
        Some((begin - width, width))
    })
}

/// f ← L11⁻¹ f_own, and the rows of `f` that follow less what they get from it.
struct Forward<'a, const K: usize> {
    block: Block<'a>,
    f: &'a mut [[f64; K]],
}

impl<const K: usize> WithSimd for Forward<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Forward { block, f } = self;
        for (begin, width) in strips(0, block.width, STRIP) {
            match width {
                STRIP => forward_strip::<STRIP, K>(block, begin, f),
                4 => forward_strip::<4, K>(block, begin, f),
                _ => forward_strip::<2, K>(block, begin, f),
            }
        }
    }
}

#[inline(always)]
fn forward_strip<const C: usize, const K: usize>(block: Block, begin: usize, f: &mut [[f64; K]]) {
    let top: [&[f64]; C] = block.columns(begin, begin..begin + C);
    let mut y = [[0.0; K]; C];
    for j in 0..C {
        let mut sum = f[begin + j];
        for i in 0..j {
            for k in 0..K {
                sum[k] -= top[i][j] * y[i][k];
            }
        }
        let inverse = 1.0 / top[j][j];
        y[j] = sum.map(|sum| sum * inverse);
    }
    f[begin..begin + C].copy_from_slice(&y);
    let below = begin + C..f.len();
    pass(block.columns(begin, below.clone()), y, &mut f[below]);
}

/// f ← f − Σ l_j y_j.
#[inline(always)]
fn pass<const C: usize, const K: usize>(l: [&[f64]; C], y: [[f64; K]; C], f: &mut [[f64; K]]) {
    let rows = f.len();
    let l: [&[f64]; C] = from_fn(|j| &l[j][..rows]);
    let whole = rows / LANES * LANES;
    for i in (0..whole).step_by(LANES) {
        let l: [[f64; LANES]; C] = from_fn(|j| lanes(&l[j][i..]));
        take_off(&mut f[i..i + LANES], l, y);
    }
    if whole < rows {
        let l: [[f64; 2]; C] = from_fn(|j| lanes(&l[j][whole..]));
        take_off(&mut f[whole..whole + 2], l, y);
    }
}

/// The same in `N` rows.
#[inline(always)]
fn take_off<const C: usize, const N: usize, const K: usize>(
    f: &mut [[f64; K]],
    l: [[f64; N]; C],
    y: [[f64; K]; C],
) {
    let mut sum = [[0.0; K]; N];
    for j in (0..C).step_by(2) {
        for lane in 0..N {
            for k in 0..K {
                sum[lane][k] += l[j][lane] * y[j][k] + l[j + 1][lane] * y[j + 1][k];
            }
        }
    }
    for lane in 0..N {
        for k in 0..K {
            f[lane][k] -= sum[lane][k];
        }
    }
}

#[inline(always)]
fn lanes<T: Copy, const N: usize>(slice: &[T]) -> [T; N] {
    slice[..N].try_into().expect("so many were taken")
}

/// f ← f − L y in the rows from `first` on.
struct Pass<'a, const K: usize> {
    block: Block<'a>,
    first: usize,
    y: &'a [[f64; K]],
    f: &'a mut [[f64; K]],
}

impl<const K: usize> WithSimd for Pass<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Pass { block, first, y, f } = self;
        let rows = first..first + f.len();
        for (begin, width) in strips(0, block.width, STRIP) {
            let (rows, y) = (rows.clone(), &y[begin..]);
            match width {
                STRIP => pass::<STRIP, K>(block.columns(begin, rows), lanes(y), f),
                4 => pass::<4, K>(block.columns(begin, rows), lanes(y), f),
                _ => pass::<2, K>(block.columns(begin, rows), lanes(y), f),
            }
        }
    }
}

/// f_own ← L11⁻ᵀ (f_own − L21ᵀ f_rows), with the rows of `f`.
struct Backward<'a, const K: usize> {
    block: Block<'a>,
    f: &'a mut [[f64; K]],
}

impl<const K: usize> WithSimd for Backward<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Backward { block, f } = self;
        for begin in (0..block.width).step_by(STRIP).rev() {
            let end = (begin + STRIP).min(block.width);
            let (own, rows) = f.split_at_mut(end);
            subtract(block, begin, end, rows, &mut own[begin..]);
            for j in (begin..end).rev() {
                let column = &block.values[j * block.height..][..end];
                let mut sum = own[j];
                for i in j + 1..end {
                    for k in 0..K {
                        sum[k] -= column[i] * own[i][k];
                    }
                }
                let inverse = 1.0 / column[j];
                own[j] = sum.map(|sum| sum * inverse);
            }
        }
    }
}

/// f_j ← f_j − Σ l_ij f_i for the columns from `begin` on, over `rows` that stand from `first` on.
#[inline(always)]
fn subtract<const K: usize>(
    block: Block,
    begin: usize,
    first: usize,
    rows: &[[f64; K]],
    f: &mut [[f64; K]],
) {
    let most = if K == 1 { STRIP } else { FEW };
    let below = first..first + rows.len();
    for (j, width) in strips(0, f.len(), most) {
        let (below, f) = (below.clone(), &mut f[j..]);
        match width {
            STRIP => take_sums::<STRIP, K>(block.columns(begin + j, below), rows, f),
            4 => take_sums::<4, K>(block.columns(begin + j, below), rows, f),
            _ => take_sums::<2, K>(block.columns(begin + j, below), rows, f),
        }
    }
}

/// f_j ← f_j − Σ l_ij f_i.
#[inline(always)]
fn take_sums<const C: usize, const K: usize>(
    l: [&[f64]; C],
    rows: &[[f64; K]],
    f: &mut [[f64; K]],
) {
    if K == 1 {
        return take_some_sums::<C, K, 1>(l, rows, 0, f);
    }
    for first in (0..K).step_by(HALF) {
        take_some_sums::<C, K, HALF>(l, rows, first, f);
    }
}

/// The same for `N` right-hand sides from `first` on.
#[inline(always)]
fn take_some_sums<const C: usize, const K: usize, const N: usize>(
    l: [&[f64]; C],
    rows: &[[f64; K]],
    first: usize,
    f: &mut [[f64; K]],
) {
    let count = rows.len();
    let l: [&[f64]; C] = from_fn(|j| &l[j][..count]);
    let whole = count / LANES * LANES;
    let mut sums = [[[0.0; N]; LANES]; C];
    for i in (0..whole).step_by(LANES) {
        let l: [[f64; LANES]; C] = from_fn(|j| lanes(&l[j][i..]));
        let f: [[f64; N]; LANES] = from_fn(|lane| lanes(&rows[i + lane][first..]));
        for j in 0..C {
            for lane in 0..LANES {
                for k in 0..N {
                    sums[j][lane][k] += l[j][lane] * f[lane][k];
                }
            }
        }
    }
    for (j, [a, b, c, d]) in sums.into_iter().enumerate() {
        let mut sum: [f64; N] = [0.0; N];
        for k in 0..N {
            sum[k] = (a[k] + b[k]) + (c[k] + d[k]);
        }
        if whole < count {
            let [p, q]: [[f64; N]; 2] = from_fn(|row| lanes(&rows[whole + row][first..]));
            for k in 0..N {
                sum[k] += l[j][whole] * p[k] + l[j][whole + 1] * q[k];
            }
        }
        for k in 0..N {
            f[j][first + k] -= sum[k];
        }
    }
}

/// f ← f − Lᵀ f_rows in the columns from `first` on.
struct Gather<'a, const K: usize> {
    block: Block<'a>,
    first: usize,
    rows: &'a [[f64; K]],
    f: &'a mut [[f64; K]],
}

impl<const K: usize> WithSimd for Gather<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Gather {
            block,
            first,
            rows,
            f,
        } = self;
        subtract(block, first, block.width, rows, f);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every width and every kind of end, and blocks that are shared out, against the formula entry by entry;
    /// eight right-hand sides have the bits of one at a time.
    #[test]
    fn substitution_is_that_of_the_formula() {
        for width in (2..40).step_by(2) {
            for rows in [0, 2, 4, 6, 50, 128] {
                compare(width, width + rows);
            }
        }
        for [width, rows] in [[202, 250], [214, 254], [64, 1000]] {
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
