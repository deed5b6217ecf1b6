//! The way up the elimination tree: f ← L⁻¹ f of a block.

use super::{Block, LANES, STRIP, lanes, strips};
use pulp::{Simd, WithSimd};
use std::array::from_fn;

/// f ← L11⁻¹ f_own, and the rows of `f` that follow less what they get from it.
pub struct Forward<'a, const K: usize> {
    pub block: Block<'a>,
    pub f: &'a mut [[f64; K]],
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
                2 => forward_strip::<2, K>(block, begin, f),
                _ => forward_strip::<1, K>(block, begin, f),
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
    let pairs = rows / 2 * 2;
    if whole < pairs {
        let l: [[f64; 2]; C] = from_fn(|j| lanes(&l[j][whole..]));
        take_off(&mut f[whole..pairs], l, y);
    }
    if pairs < rows {
        let l: [[f64; 1]; C] = from_fn(|j| lanes(&l[j][pairs..]));
        take_off(&mut f[pairs..], l, y);
    }
}

/// f ← f − Σ l_j y_j in `N` rows.
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
                sum[lane][k] += match j + 1 < C {
                    true => l[j][lane] * y[j][k] + l[j + 1][lane] * y[j + 1][k],
                    false => l[j][lane] * y[j][k],
                };
            }
        }
    }
    for lane in 0..N {
        for k in 0..K {
            f[lane][k] -= sum[lane][k];
        }
    }
}

/// f ← f − L y in the rows from `first` on.
pub struct Pass<'a, const K: usize> {
    pub block: Block<'a>,
    pub first: usize,
    pub y: &'a [[f64; K]],
    pub f: &'a mut [[f64; K]],
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
                2 => pass::<2, K>(block.columns(begin, rows), lanes(y), f),
                _ => pass::<1, K>(block.columns(begin, rows), lanes(y), f),
            }
        }
    }
}
