//! The inner loops of solutions, compiled for the processor's vector instructions.
//!
//! Sums are kept in fixed lanes and products are rounded before they are added, so that the bits depend
//! neither on the processor nor on how many right-hand sides go through L together.

use pulp::{Arch, Simd, WithSimd};
use std::array::from_fn;

/// Columns of L that are worked on together; four and two at the end of a block, since nodes have two dofs.
const STRIP: usize = 8;

/// Right-hand sides that are.
const GROUP: usize = 4;

/// Rows that are, but for the last two.
const LANES: usize = 4;

/// A block of L: column by column, own rows first. Width and height are even.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    pub values: &'a [f64],
    pub width: usize,
    pub height: usize,
}

impl<'a> Block<'a> {
    /// Of `C` columns from one on, the rows from another on.
    #[inline(always)]
    fn columns<const C: usize>(&self, begin: usize, row: usize) -> [&'a [f64]; C] {
        from_fn(|j| &self.values[(begin + j) * self.height..][row..self.height])
    }

    /// f ← [L11⁻¹ f_own, f_rows − L21 L11⁻¹ f_own], right-hand side after right-hand side.
    pub fn forward(self, f: &mut [f64]) {
        Arch::new().dispatch(Forward { block: self, f });
    }

    /// f_own ← L11⁻ᵀ (f_own − L21ᵀ f_rows).
    pub fn backward(self, f: &mut [f64]) {
        Arch::new().dispatch(Backward { block: self, f });
    }
}

struct Forward<'a> {
    block: Block<'a>,
    f: &'a mut [f64],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Forward { block, f } = self;
        for begin in (0..block.width).step_by(STRIP) {
            let mut groups = f.chunks_exact_mut(GROUP * block.height);
            for f in &mut groups {
                forward::<GROUP>(block, begin, f);
            }
            for f in groups.into_remainder().chunks_exact_mut(block.height) {
                forward::<1>(block, begin, f);
            }
        }
    }
}

#[inline(always)]
fn forward<const R: usize>(block: Block, begin: usize, f: &mut [f64]) {
    let mut begin = begin;
    if begin + STRIP <= block.width {
        forward_strip::<STRIP, R>(block, begin, f);
        return;
    }
    if begin + 4 <= block.width {
        forward_strip::<4, R>(block, begin, f);
        begin += 4;
    }
    if begin < block.width {
        forward_strip::<2, R>(block, begin, f);
    }
}

#[inline(always)]
fn forward_strip<const C: usize, const R: usize>(block: Block, begin: usize, f: &mut [f64]) {
    let end = begin + C;
    let top: [&[f64]; C] = block.columns(begin, begin);
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
        f[begin..end].copy_from_slice(y);
    }
    let rows = block.height - end;
    let l: [&[f64]; C] = block.columns(begin, end);
    let l: [&[f64]; C] = from_fn(|j| &l[j][..rows]);
    let mut vectors = f.chunks_exact_mut(block.height);
    let f: [&mut [f64]; R] =
        from_fn(|_| &mut vectors.next().expect("there are R of them")[end..][..rows]);
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

/// f ← f − Σ l_j y_j in `N` rows.
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

struct Backward<'a> {
    block: Block<'a>,
    f: &'a mut [f64],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Backward { block, f } = self;
        for begin in (0..block.width).step_by(STRIP).rev() {
            let mut groups = f.chunks_exact_mut(GROUP * block.height);
            for f in &mut groups {
                backward::<2, GROUP>(block, begin, f);
            }
            for f in groups.into_remainder().chunks_exact_mut(block.height) {
                backward::<STRIP, 1>(block, begin, f);
            }
        }
    }
}

/// One strip, `C` columns at a time.
#[inline(always)]
fn backward<const C: usize, const R: usize>(block: Block, begin: usize, f: &mut [f64]) {
    let height = block.height;
    let end = (begin + STRIP).min(block.width);
    let mut j = begin;
    while j < end {
        if j + C <= end {
            subtract::<C, R>(block, j, end, f);
            j += C;
        } else {
            subtract::<2, R>(block, j, end, f);
            j += 2;
        }
    }
    for f in f.chunks_exact_mut(height) {
        for j in (begin..end).rev() {
            let column = &block.values[j * height..][..end];
            let mut sum = f[j];
            for i in j + 1..end {
                sum -= column[i] * f[i];
            }
            f[j] = sum * (1.0 / column[j]);
        }
    }
}

/// f_j ← f_j − Σ l_ij f_i over the rows from `end` on, for `C` columns.
#[inline(always)]
fn subtract<const C: usize, const R: usize>(block: Block, begin: usize, end: usize, f: &mut [f64]) {
    let height = block.height;
    let rows = height - end;
    let l: [&[f64]; C] = block.columns(begin, end);
    let l: [&[f64]; C] = from_fn(|j| &l[j][..rows]);
    let whole = rows / LANES * LANES;
    let mut sums = [[[0.0; LANES]; C]; R];
    for i in (0..whole).step_by(LANES) {
        let l: [[f64; LANES]; C] = from_fn(|j| lanes(&l[j][i..]));
        for r in 0..R {
            let f: [f64; LANES] = lanes(&f[r * height + end + i..]);
            for j in 0..C {
                for lane in 0..LANES {
                    sums[r][j][lane] += l[j][lane] * f[lane];
                }
            }
        }
    }
    for r in 0..R {
        for j in 0..C {
            let mut sum = (sums[r][j][0] + sums[r][j][1]) + (sums[r][j][2] + sums[r][j][3]);
            if whole < rows {
                let f: [f64; 2] = lanes(&f[r * height + end + whole..]);
                sum += l[j][whole] * f[0] + l[j][whole + 1] * f[1];
            }
            f[r * height + begin + j] -= sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every width and every kind of end, against the formula entry by entry (1e-15 of numbers of 1e-2); eleven
    /// right-hand sides have the bits of one at a time.
    #[test]
    fn substitution_is_that_of_the_formula() {
        let columns = 11;
        for width in (2..40).step_by(2) {
            for height in [0, 2, 4, 6, 50, 128].map(|rows| width + rows) {
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
                        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
                    }
                }
            }
        }
    }
}
