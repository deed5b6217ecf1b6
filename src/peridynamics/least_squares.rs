//! Micromoduli near straight free edges by least squares, after Prakash (2019).
//!
//! Along a free edge with the tangent t the stress is σ = t⊗t times a number, and nothing else. A
//! family is balanced if under the strain ε_t of that stress its forces cancel and its part of the
//! stress is σ:
//!
//! ```text
//! Σ_j β_ij k_ij ξ (n·ε_t·n) n = 0,    ½ Σ_j β_ij k_ij ξ² (n·ε_t·n) (n·t)² = A_i h_t
//! ```
//!
//! ε_t is that of the lattice's own moduli, so that the interior is balanced anyway. The β are the factors
//! λ of the force method with the least change, Σ (β_ij − λ_ij)², that balance every point whose family
//! is cut off by one straight edge, or by parallel ones. Only bonds between two points with a cut-off
//! family change, and β = 1 between such a point and a whole one: whole families stay balanced. A strip
//! in tension is then exact.
//!
//! Where a family meets a corner or a curve no uniform stress but zero leaves the surface free, and there
//! is nothing to balance: those points keep the factors of the force method.

use super::bonds::family_offsets;
use super::isotropy::lattice_moduli;
use super::kernel::Micromodulus;
use super::lattice::Sites;
use super::surface::SurfaceError;
use crate::geometry::{Outline, nearest_on_segment};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// β by pair of sites, the lower index first.
pub type PairFactors = BTreeMap<[u32; 2], f64>;

/// The factors of the bonds that a straight edge changes.
///
/// `completeness`: what each site has of a whole family; `base`: the force method's factor of a pair.
/// Sites nearer than δ to the border of the grid are ignored, those nearer than 2δ not balanced.
///
/// # Errors
/// No factors balance the families, or only negative ones.
pub fn factors(
    sites: &Sites,
    completeness: &[[f64; 2]],
    base: &(dyn Fn(usize, usize) -> f64 + Sync),
    body: &Outline,
    micromodulus: &Micromodulus,
) -> Result<PairFactors, SurfaceError> {
    let edge = StraightEdge::new(sites, completeness, body, micromodulus);
    let mut fixed = PairFactors::new();
    let mut free = PairFactors::new();
    for (&site, _) in &edge.tangents {
        for offset in &edge.stiff {
            let Some(other) = edge.neighbour(site as usize, *offset) else {
                continue;
            };
            let pair = [site.min(other as u32), site.max(other as u32)];
            if edge.is_cut[other] {
                free.insert(pair, base(pair[0] as usize, pair[1] as usize));
            } else {
                fixed.insert(pair, 1.0);
            }
        }
    }
    let change = edge.balance(&free, micromodulus)?;
    for (factor, change) in free.values_mut().zip(change) {
        *factor += change;
    }
    let least = free.values().copied().fold(f64::INFINITY, f64::min);
    if least <= 0.0 {
        return Err(SurfaceError::NotPositive { factor: least });
    }
    free.append(&mut fixed);
    Ok(free)
}

struct StraightEdge<'a> {
    sites: &'a Sites,
    /// Whether a site's family is cut off.
    is_cut: Vec<bool>,
    /// t of the sites that are to be balanced.
    tangents: BTreeMap<u32, [f64; 2]>,
    /// Offsets whose bonds have stiffness.
    stiff: Vec<[i32; 2]>,
}

/// Directions within this angle are parallel.
const PARALLEL: f64 = 1e-6;

/// What remains of a unit of stress; the sums have some dozens of terms of order one.
const BALANCED: f64 = 1e-9;
const GOAL: f64 = 1e-13;
const MOST_ITERATIONS: usize = 20_000;

impl<'a> StraightEdge<'a> {
    fn new(
        sites: &'a Sites,
        completeness: &[[f64; 2]],
        body: &Outline,
        micromodulus: &Micromodulus,
    ) -> StraightEdge<'a> {
        let dx = micromodulus.spacing;
        let reach = (micromodulus.reach() / dx) as usize;
        let [columns, rows] = sites.counts();
        let depth = |site: usize| {
            let (column, row) = (site % columns, site / columns);
            let across = column.min(columns - 1 - column);
            across.min(row.min(rows - 1 - row))
        };
        let is_cut: Vec<bool> = (0..columns * rows)
            .map(|site| {
                sites.shares[site] > 0.0 && depth(site) >= reach && completeness[site] != [1.0; 2]
            })
            .collect();
        let segments: Vec<_> = body.segments().collect();
        let tangents = (0..columns * rows)
            .into_par_iter()
            .filter(|&site| is_cut[site] && depth(site) >= 2 * reach)
            .filter_map(|site| {
                let tangent = tangent(sites.position(site), &segments, micromodulus.reach());
                tangent.map(|t| (site as u32, t))
            })
            .collect();
        let stiff = |offset: &[i32; 2]| {
            micromodulus.density(offset.map(|steps| f64::from(steps) * dx)) > 0.0
        };
        let mut offsets = family_offsets(micromodulus);
        offsets.retain(stiff);
        StraightEdge {
            sites,
            is_cut,
            tangents,
            stiff: offsets,
        }
    }

    /// The site at an offset, if the body has one there.
    fn neighbour(&self, site: usize, [p, q]: [i32; 2]) -> Option<usize> {
        let [columns, rows] = self.sites.counts();
        let x = (site % columns) as i64 + i64::from(p);
        let y = (site / columns) as i64 + i64::from(q);
        let inside = x >= 0 && y >= 0 && x < columns as i64 && y < rows as i64;
        let other = || y as usize * columns + x as usize;
        inside.then(other).filter(|&k| self.sites.shares[k] > 0.0)
    }

    /// The least change of the free factors that balances every family.
    fn balance(
        &self,
        free: &PairFactors,
        micromodulus: &Micromodulus,
    ) -> Result<Vec<f64>, SurfaceError> {
        let pairs: Vec<[u32; 2]> = free.keys().copied().collect();
        let base: Vec<f64> = free.values().copied().collect();
        let mut constraints = Constraints::default();
        for (&site, &tangent) in &self.tangents {
            let strain = strain_of_tension(tangent, lattice_moduli(micromodulus));
            let mut rows = [const { Vec::new() }; 3];
            let mut missing = [0.0, 0.0, 1.0];
            for offset in &self.stiff {
                let Some(other) = self.neighbour(site as usize, *offset) else {
                    continue;
                };
                let share = self.sites.shares[other];
                let terms = terms(*offset, share, strain, tangent, micromodulus);
                let pair = [site.min(other as u32), site.max(other as u32)];
                match pairs.binary_search(&pair) {
                    Ok(k) => {
                        for (row, term) in rows.iter_mut().zip(terms) {
                            row.push((k as u32, term));
                        }
                        (0..3).for_each(|r| missing[r] -= base[k] * terms[r]);
                    }
                    Err(_) => (0..3).for_each(|r| missing[r] -= terms[r]),
                }
            }
            for (row, missing) in rows.into_iter().zip(missing) {
                constraints.rows.push(row);
                constraints.missing.push(missing);
            }
        }
        constraints.least_solution(pairs.len())
    }
}

/// The direction of the edges within `reach` of a position, if they are all parallel.
fn tangent(
    position: [f64; 2],
    segments: &[[[f64; 2]; 2]],
    reach: f64,
) -> Option<[f64; 2]> {
    let mut found: Option<[f64; 2]> = None;
    for &segment in segments {
        let [a, b] = segment;
        let far = (0..2).any(|axis| {
            let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            position[axis] < low - reach || position[axis] > high + reach
        });
        if far || nearest_on_segment(position, segment).1 > reach {
            continue;
        }
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let t = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        match found {
            Some(first) if (first[0] * t[1] - first[1] * t[0]).abs() > PARALLEL => return None,
            Some(_) => {}
            None => found = Some(t),
        }
    }
    found
}

/// ε_xx, ε_yy and γ_xy under the stress t⊗t of a unit, for C11 and C12 = C66 [1/Pa].
fn strain_of_tension([x, y]: [f64; 2], [c11, c12]: [f64; 2]) -> [f64; 3] {
    let determinant = c11 * c11 - c12 * c12;
    [
        (c11 * x * x - c12 * y * y) / determinant,
        (c11 * y * y - c12 * x * x) / determinant,
        x * y / c12,
    ]
}

/// What a bond adds to a point's forces, per dx and unit of stress, and to its stress, per unit.
fn terms(
    offset: [i32; 2],
    share: f64,
    [xx, yy, gamma]: [f64; 3],
    tangent: [f64; 2],
    micromodulus: &Micromodulus,
) -> [f64; 3] {
    let dx = micromodulus.spacing;
    let bond = offset.map(|steps| f64::from(steps) * dx);
    let xi = bond[0].hypot(bond[1]);
    let n = bond.map(|x| x / xi);
    let stretch = xx * n[0] * n[0] + yy * n[1] * n[1] + gamma * n[0] * n[1];
    let force = micromodulus.density(bond) * dx * dx * share * stretch;
    let along = n[0] * tangent[0] + n[1] * tangent[1];
    [
        force * n[0] * dx,
        force * n[1] * dx,
        0.5 * force * xi * along * along,
    ]
}

/// Rows C and what they lack: C x = `missing`.
#[derive(Default)]
struct Constraints {
    rows: Vec<Vec<(u32, f64)>>,
    missing: Vec<f64>,
}

impl Constraints {
    /// The x of least norm, x = Cᵀ μ with C Cᵀ μ = `missing`. C has dependent rows; conjugate gradients
    /// do not mind as long as `missing` obeys the same dependence.
    fn least_solution(&self, unknowns: usize) -> Result<Vec<f64>, SurfaceError> {
        let count = self.rows.len();
        let scale: Vec<f64> = self
            .rows
            .iter()
            .map(|row| row.iter().map(|(_, c)| c * c).sum::<f64>())
            .map(|square| if square > 0.0 { 1.0 / square } else { 0.0 })
            .collect();
        let mut x = vec![0.0; unknowns];
        let mut residual = self.missing.clone();
        let mut direction = vec![0.0; count];
        let mut last = 0.0;
        for _ in 0..MOST_ITERATIONS {
            if largest(&residual) <= GOAL {
                break;
            }
            let preconditioned: Vec<f64> =
                residual.iter().zip(&scale).map(|(r, s)| r * s).collect();
            let now = dot(&residual, &preconditioned);
            let beta = if last > 0.0 { now / last } else { 0.0 };
            for (d, p) in direction.iter_mut().zip(&preconditioned) {
                *d = p + beta * *d;
            }
            let step = self.transposed(&direction, unknowns);
            let alpha = now / dot(&step, &step);
            if !alpha.is_finite() {
                break;
            }
            x.iter_mut().zip(&step).for_each(|(x, s)| *x += alpha * s);
            let moved = self.product(&step);
            residual
                .iter_mut()
                .zip(moved)
                .for_each(|(r, m)| *r -= alpha * m);
            last = now;
        }
        let reached = self.product(&x);
        let error = self.missing.iter().zip(reached).map(|(m, r)| m - r);
        let residual = largest(&error.collect::<Vec<_>>());
        if residual <= BALANCED {
            Ok(x)
        } else {
            Err(SurfaceError::Unbalanced { residual })
        }
    }

    fn product(&self, x: &[f64]) -> Vec<f64> {
        let row = |row: &Vec<(u32, f64)>| row.iter().map(|&(k, c)| c * x[k as usize]).sum();
        self.rows.iter().map(row).collect()
    }

    fn transposed(&self, mu: &[f64], unknowns: usize) -> Vec<f64> {
        let mut x = vec![0.0; unknowns];
        for (row, mu) in self.rows.iter().zip(mu) {
            row.iter().for_each(|&(k, c)| x[k as usize] += c * mu);
        }
        x
    }
}

fn largest(values: &[f64]) -> f64 {
    // Not `f64::max`, which would lose a NaN.
    values
        .iter()
        .fold(0.0, |most, v| if v.abs() <= most { most } else { v.abs() })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
