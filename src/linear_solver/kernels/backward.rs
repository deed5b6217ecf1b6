//! The way down the elimination tree: f ← L⁻ᵀ f of a block.

use super::{Block, LANES, STRIP, lanes, strips};
use pulp::{Simd, WithSimd};
use std::array::from_fn;

/// Columns, and right-hand sides where there are several, that are worked on together: their sums, in
/// [`LANES`], fill half of the sixteen registers.
const FEW: usize = 2;
const HALF: usize = 4;

/// f_own ← L11⁻ᵀ (f_own − L21ᵀ f_rows), with the rows of `f`.
pub struct Backward<'a, const K: usize> {
    pub block: Block<'a>,
    pub f: &'a mut [[f64; K]],
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
            2 => take_sums::<2, K>(block.columns(begin + j, below), rows, f),
            _ => take_sums::<1, K>(block.columns(begin + j, below), rows, f),
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

/// f_j ← f_j − Σ l_ij f_i of `N` right-hand sides from `first` on.
#[inline(always)]
fn take_some_sums<const C: usize, const K: usize, const N: usize>(
    l: [&[f64]; C],
    rows: &[[f64; K]],
    first: usize,
    f: &mut [[f64; K]],
) {
    let count = rows.len();
    let l: [&[f64]; C] = from_fn(|j| &l[j][..count]);
    let (whole, pairs) = (count / LANES * LANES, count / 2 * 2);
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
        if whole < pairs {
            let [p, q]: [[f64; N]; 2] = from_fn(|row| lanes(&rows[whole + row][first..]));
            for k in 0..N {
                sum[k] += l[j][whole] * p[k] + l[j][whole + 1] * q[k];
            }
        }
        if pairs < count {
            let p: [f64; N] = lanes(&rows[pairs][first..]);
            for k in 0..N {
                sum[k] += l[j][pairs] * p[k];
            }
        }
        for k in 0..N {
            f[j][first + k] -= sum[k];
        }
    }
}

/// f ← f − Lᵀ f_rows in the columns from `first` on.
pub struct Gather<'a, const K: usize> {
    pub block: Block<'a>,
    pub first: usize,
    pub rows: &'a [[f64; K]],
    pub f: &'a mut [[f64; K]],
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
