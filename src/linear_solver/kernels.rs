//! The inner loops of solutions, compiled for the processor's vector instructions.
//!
//! Sums are kept in fixed lanes and products are rounded before they are added, so that the bits depend
//! neither on the processor nor on how many right-hand sides go through L together.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::array::from_fn;
use std::ops::Range;

/// Columns of L that are worked on together; four and two at the end of a block, since nodes have two dofs.
const STRIP: usize = 8;

/// Right-hand sides that are.
const GROUP: usize = 4;

/// Rows that are, but for the last two.
const LANES: usize = 4;

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

    /// f ← [L11⁻¹ f_own, f_rows − L21 L11⁻¹ f_own], right-hand side after right-hand side.
    pub fn forward(self, f: &mut [f64]) {
        let (block, arch) = (self, Arch::new());
        if !block.is_large() {
            let end = block.height;
            return arch.dispatch(Forward { block, end, f });
        }
        let end = block.width;
        arch.dispatch(Forward { block, end, f });
        let length = part(block.height - block.width, LANES);
        let split = f.chunks_exact_mut(block.height);
        let (own, rows): (Vec<_>, Vec<_>) = split.map(|f| f.split_at_mut(block.width)).unzip();
        let parts = parts(rows, length).into_par_iter().enumerate();
        parts.for_each(|(k, f)| {
            let first = block.width + k * length;
            let y = &own;
            arch.dispatch(Pass { block, first, y, f });
        });
    }

    /// f_own ← L11⁻ᵀ (f_own − L21ᵀ f_rows).
    pub fn backward(self, f: &mut [f64]) {
        let (block, arch) = (self, Arch::new());
        if !block.is_large() {
            let end = block.height;
            return arch.dispatch(Backward { block, end, f });
        }
        let length = part(block.width, STRIP);
        let split = f.chunks_exact_mut(block.height);
        let (own, rows): (Vec<_>, Vec<_>) = split.map(|f| f.split_at_mut(block.width)).unzip();
        let parts = parts(own, length).into_par_iter().enumerate();
        parts.for_each(|(k, f)| {
            let first = k * length;
            let rows = &rows;
            arch.dispatch(Gather {
                block,
                first,
                rows,
                f,
            });
        });
        let end = block.width;
        arch.dispatch(Backward { block, end, f });
    }
}

/// The length of a part of `count`.
fn part(count: usize, unit: usize) -> usize {
    count.div_ceil(PARTS).next_multiple_of(unit)
}

/// Of each vector the first part, the second, and so on.
fn parts(vectors: Vec<&mut [f64]>, length: usize) -> Vec<Vec<&mut [f64]>> {
    let mut parts: Vec<Vec<&mut [f64]>> = Vec::new();
    for vector in vectors {
        for (k, piece) in vector.chunks_mut(length).enumerate() {
            parts.resize_with(parts.len().max(k + 1), Vec::new);
            parts[k].push(piece);
        }
    }
    parts
}

/// f ← L11⁻¹ f_own, and rows up to `end` less what they get from it.
struct Forward<'a> {
    block: Block<'a>,
    end: usize,
    f: &'a mut [f64],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Forward { block, end, f } = self;
        for begin in (0..block.width).step_by(STRIP) {
            let mut groups = f.chunks_exact_mut(GROUP * block.height);
            for f in &mut groups {
                forward::<GROUP>(block, begin, end, f);
            }
            for f in groups.into_remainder().chunks_exact_mut(block.height) {
                forward::<1>(block, begin, end, f);
            }
        }
    }
}

#[inline(always)]
fn forward<const R: usize>(block: Block, begin: usize, end: usize, f: &mut [f64]) {
    let mut begin = begin;
    if begin + STRIP <= block.width {
        forward_strip::<STRIP, R>(block, begin, end, f);
        return;
    }
    if begin + 4 <= block.width {
        forward_strip::<4, R>(block, begin, end, f);
        begin += 4;
    }
    if begin < block.width {
        forward_strip::<2, R>(block, begin, end, f);
    }
}

#[inline(always)]
fn forward_strip<const C: usize, const R: usize>(
    block: Block,
    begin: usize,
    end: usize,
    f: &mut [f64],
) {
    let top: [&[f64]; C] = block.columns(begin, begin..begin + C);
    let inverse: [f64; C] = from_fn(|j| 1.0 / top[j][j]);
    let mut y = [[0.0; C]; R];
    for (y, f) in y.iter_mut().zip(f.chunks_exact_mut(block.height)) {
        for j in 0..C {
            let mut sum = f[begin + j];
            for i in 0..j {
                sum -= top[i][j] * y[i];
            }
            y[j] = sum * inverse[j];
        }
        f[begin..begin + C].copy_from_slice(y);
    }
    let mut vectors = f.chunks_exact_mut(block.height);
    let f = from_fn(|_| &mut vectors.next().expect("there are R of them")[begin + C..end]);
    pass(block.columns(begin, begin + C..end), y, f);
}

/// f ← f − Σ l_j y_j.
#[inline(always)]
fn pass<const C: usize, const R: usize>(l: [&[f64]; C], y: [[f64; C]; R], f: [&mut [f64]; R]) {
    let rows = l[0].len();
    let l: [&[f64]; C] = from_fn(|j| &l[j][..rows]);
    let f = f.map(|f| &mut f[..rows]);
    let whole = rows / LANES * LANES;
    for i in (0..whole).step_by(LANES) {
        let l: [[f64; LANES]; C] = from_fn(|j| lanes(&l[j][i..]));
        for r in 0..R {
            take_off(&mut f[r][i..i + LANES], l, y[r]);
        }
    }
    if whole < rows {
        let l: [[f64; 2]; C] = from_fn(|j| lanes(&l[j][whole..]));
        for r in 0..R {
            take_off(&mut f[r][whole..whole + 2], l, y[r]);
        }
    }
}

/// The same in `N` rows.
#[inline(always)]
fn take_off<const C: usize, const N: usize>(f: &mut [f64], l: [[f64; N]; C], y: [f64; C]) {
    let mut sum = [0.0; N];
    for j in (0..C).step_by(2) {
        for lane in 0..N {
            sum[lane] += l[j][lane] * y[j] + l[j + 1][lane] * y[j + 1];
        }
    }
    for lane in 0..N {
        f[lane] -= sum[lane];
    }
}

#[inline(always)]
fn lanes<const N: usize>(slice: &[f64]) -> [f64; N] {
    slice[..N].try_into().expect("so many were taken")
}

/// f ← f − L y in the rows from `first` on.
struct Pass<'a> {
    block: Block<'a>,
    first: usize,
    y: &'a [&'a mut [f64]],
    f: Vec<&'a mut [f64]>,
}

impl WithSimd for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Pass {
            block,
            first,
            y,
            mut f,
        } = self;
        for begin in (0..block.width).step_by(STRIP) {
            let whole = f.len() / GROUP * GROUP;
            let (groups, rest) = f.split_at_mut(whole);
            for (f, y) in groups.chunks_exact_mut(GROUP).zip(y.chunks_exact(GROUP)) {
                pass_strip::<GROUP>(block, begin, first, y, f);
            }
            for (f, y) in rest.chunks_exact_mut(1).zip(y[whole..].chunks_exact(1)) {
                pass_strip::<1>(block, begin, first, y, f);
            }
        }
    }
}

#[inline(always)]
fn pass_strip<const R: usize>(
    block: Block,
    begin: usize,
    first: usize,
    y: &[&mut [f64]],
    f: &mut [&mut [f64]],
) {
    let mut begin = begin;
    if begin + STRIP <= block.width {
        pass_columns::<STRIP, R>(block, begin, first, y, f);
        return;
    }
    if begin + 4 <= block.width {
        pass_columns::<4, R>(block, begin, first, y, f);
        begin += 4;
    }
    if begin < block.width {
        pass_columns::<2, R>(block, begin, first, y, f);
    }
}

#[inline(always)]
fn pass_columns<const C: usize, const R: usize>(
    block: Block,
    begin: usize,
    first: usize,
    y: &[&mut [f64]],
    f: &mut [&mut [f64]],
) {
    let y: [[f64; C]; R] = from_fn(|r| lanes(&y[r][begin..]));
    let rows = first..first + f[0].len();
    let mut f = f.iter_mut();
    let f = from_fn(|_| &mut **f.next().expect("there are R of them"));
    pass(block.columns(begin, rows), y, f);
}

/// f_own ← L11⁻ᵀ (f_own − L21ᵀ f_rows), with the rows up to `end`.
struct Backward<'a> {
    block: Block<'a>,
    end: usize,
    f: &'a mut [f64],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Backward { block, end, f } = self;
        for begin in (0..block.width).step_by(STRIP).rev() {
            let mut groups = f.chunks_exact_mut(GROUP * block.height);
            for f in &mut groups {
                backward::<2, GROUP>(block, begin, end, f);
            }
            for f in groups.into_remainder().chunks_exact_mut(block.height) {
                backward::<STRIP, 1>(block, begin, end, f);
            }
        }
    }
}

/// One strip, `C` columns at a time.
#[inline(always)]
fn backward<const C: usize, const R: usize>(block: Block, begin: usize, end: usize, f: &mut [f64]) {
    let height = block.height;
    let last = (begin + STRIP).min(block.width);
    let mut j = begin;
    while j < last {
        if j + C <= last {
            subtract::<C, R>(block, j, last..end, f);
            j += C;
        } else {
            subtract::<2, R>(block, j, last..end, f);
            j += 2;
        }
    }
    for f in f.chunks_exact_mut(height) {
        for j in (begin..last).rev() {
            let column = &block.values[j * height..][..last];
            let mut sum = f[j];
            for i in j + 1..last {
                sum -= column[i] * f[i];
            }
            f[j] = sum * (1.0 / column[j]);
        }
    }
}

/// f_j ← f_j − Σ l_ij f_i over some rows, for `C` columns.
#[inline(always)]
fn subtract<const C: usize, const R: usize>(
    block: Block,
    j: usize,
    rows: Range<usize>,
    f: &mut [f64],
) {
    let own: [&[f64]; R] = from_fn(|r| &f[r * block.height..][rows.clone()]);
    let sums: [[f64; C]; R] = products(block.columns(j, rows), own);
    for (f, sums) in f.chunks_exact_mut(block.height).zip(sums) {
        f[j..].iter_mut().zip(sums).for_each(|(f, sum)| *f -= sum);
    }
}

/// Σ l_ij f_i.
#[inline(always)]
fn products<const C: usize, const R: usize>(l: [&[f64]; C], f: [&[f64]; R]) -> [[f64; C]; R] {
    let rows = f[0].len();
    let l: [&[f64]; C] = from_fn(|j| &l[j][..rows]);
    let whole = rows / LANES * LANES;
    let mut sums = [[[0.0; LANES]; C]; R];
    for i in (0..whole).step_by(LANES) {
        let l: [[f64; LANES]; C] = from_fn(|j| lanes(&l[j][i..]));
        for r in 0..R {
            let f: [f64; LANES] = lanes(&f[r][i..]);
            for j in 0..C {
                for lane in 0..LANES {
                    sums[r][j][lane] += l[j][lane] * f[lane];
                }
            }
        }
    }
    let mut all = [[0.0; C]; R];
    for r in 0..R {
        for j in 0..C {
            let mut sum = (sums[r][j][0] + sums[r][j][1]) + (sums[r][j][2] + sums[r][j][3]);
            if whole < rows {
                let f: [f64; 2] = lanes(&f[r][whole..]);
                sum += l[j][whole] * f[0] + l[j][whole + 1] * f[1];
            }
            all[r][j] = sum;
        }
    }
    all
}

/// f ← f − Lᵀ f_rows in the columns from `first` on.
struct Gather<'a> {
    block: Block<'a>,
    first: usize,
    rows: &'a [&'a mut [f64]],
    f: Vec<&'a mut [f64]>,
}

impl WithSimd for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Gather {
            block,
            first,
            rows,
            mut f,
        } = self;
        let whole = f.len() / GROUP * GROUP;
        let (groups, rest) = f.split_at_mut(whole);
        for (f, rows) in groups.chunks_exact_mut(GROUP).zip(rows.chunks_exact(GROUP)) {
            gather::<2, GROUP>(block, first, rows, f);
        }
        for (f, rows) in rest.chunks_exact_mut(1).zip(rows[whole..].chunks_exact(1)) {
            gather::<STRIP, 1>(block, first, rows, f);
        }
    }
}

#[inline(always)]
fn gather<const C: usize, const R: usize>(
    block: Block,
    first: usize,
    rows: &[&mut [f64]],
    f: &mut [&mut [f64]],
) {
    let width = f[0].len();
    let mut j = 0;
    while j < width {
        if j + C <= width {
            gather_columns::<C, R>(block, first, j, rows, f);
            j += C;
        } else {
            gather_columns::<2, R>(block, first, j, rows, f);
            j += 2;
        }
    }
}

#[inline(always)]
fn gather_columns<const C: usize, const R: usize>(
    block: Block,
    first: usize,
    j: usize,
    rows: &[&mut [f64]],
    f: &mut [&mut [f64]],
) {
    let below = block.columns(first + j, block.width..block.height);
    let sums: [[f64; C]; R] = products(below, from_fn(|r| &*rows[r]));
    for (f, sums) in f.iter_mut().zip(sums) {
        f[j..].iter_mut().zip(sums).for_each(|(f, sum)| *f -= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every width and every kind of end, and blocks that are shared out, against the formula entry by entry;
    /// eleven right-hand sides have the bits of one at a time.
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
        let columns = 11;
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
        let loads: Vec<f64> = (0..height * columns).map(load).collect();
        let (mut up, mut down) = (loads.clone(), loads.clone());
        block.forward(&mut up);
        block.backward(&mut down);
        for (k, load) in loads.chunks(height).enumerate() {
            let (mut alone_up, mut alone_down) = (load.to_vec(), load.to_vec());
            block.forward(&mut alone_up);
            block.backward(&mut alone_down);
            assert_eq!(alone_up, up[k * height..][..height]);
            assert_eq!(alone_down, down[k * height..][..height]);
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
