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
//! λ of the force method with the least change, Σ (β_ij − λ_ij)², that balance every row of points along
//! the edge. Only bonds between two cut-off families change, and β = 1 between such a family and a whole
//! one: whole families stay balanced. A strip in tension is then exact.
//!
//! An edge along one of the lattice's axes looks the same from every point of a row, so the β are found
//! once, for an infinite strip with the rows' areas. A point has them if its family meets no other
//! edge. All other points keep the factors of the force method. Where a family meets a corner or a curve,
//! no uniform stress but zero leaves the surface free, and there is nothing to balance. Oblique edges
//! leave steps in the lattice, and the factors that balance those can be negative: −3.78 at 1°, −0.11 at
//! 10°, from 0.30 on at 20° and more (quartic kernel, m = 4).

use super::bonds::family_offsets;
use super::isotropy::lattice_moduli;
use super::kernel::Micromodulus;
use super::lattice::Sites;
use super::surface::SurfaceError;
use super::visibility::Visibility;
use crate::geometry::{Outline, nearest_on_segment};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The factors along all straight edges of a body.
#[derive(Default)]
pub struct EdgeFactors {
    strips: Vec<Strip>,
    places: BTreeMap<u32, Place>,
}

/// Where a site is in a strip.
#[derive(Clone, Copy, PartialEq)]
struct Place {
    strip: usize,
    row: usize,
    frame: Frame,
}

/// How a strip lies on the lattice.
#[derive(Clone, Copy, PartialEq)]
struct Frame {
    /// The axis along the edge.
    tangent: usize,
    /// The sign of the other axis from row to row.
    inward: i32,
}

/// Directions within this angle are parallel.
const PARALLEL: f64 = 1e-6;

impl EdgeFactors {
    /// `is_cut`: whether a site's family is cut off.
    ///
    /// # Errors
    /// No factors balance the families, or only negative ones.
    pub fn new(
        sites: &Sites,
        is_cut: &(dyn Fn(usize) -> bool + Sync),
        (body, visibility): (&Outline, &Visibility),
        micromodulus: &Micromodulus,
    ) -> Result<EdgeFactors, SurfaceError> {
        let segments: Vec<_> = body.segments().collect();
        let reach = (micromodulus.reach() / micromodulus.spacing) as usize;
        let [columns, rows] = sites.counts();
        let offsets = family_offsets(micromodulus);
        let place = |site: usize| {
            let tangent = tangent(sites.position(site), &segments, micromodulus.reach())?;
            let profile = profile(sites, site, tangent, 3 * reach, visibility)?;
            let offsets = &offsets;
            is_strip(sites, site, &profile, offsets, visibility).then_some((site, profile))
        };
        let found: Vec<(usize, Profile)> = (0..columns * rows)
            .into_par_iter()
            .filter(|&site| is_cut(site))
            .filter_map(place)
            .collect();
        let mut factors = EdgeFactors::default();
        let mut known: BTreeMap<(Vec<i64>, bool), usize> = BTreeMap::new();
        for (site, profile) in found {
            let key = (profile.shares.clone(), profile.open);
            let strip = match known.get(&key) {
                Some(&strip) => strip,
                None => {
                    let strip = Strip::new(&profile, micromodulus)?;
                    factors.strips.push(strip);
                    known.insert(key, factors.strips.len() - 1);
                    factors.strips.len() - 1
                }
            };
            let Profile { row, frame, .. } = profile;
            factors
                .places
                .insert(site as u32, Place { strip, row, frame });
        }
        Ok(factors)
    }

    /// β of the bond from one site to another at `offset`, where the edge says something of it.
    pub fn factor(
        &self,
        [i, j]: [usize; 2],
        offset: [i32; 2],
        is_cut: impl Fn(usize) -> bool,
    ) -> Option<f64> {
        match [i, j].map(|site| self.places.get(&(site as u32))) {
            [Some(a), Some(b)] if a.strip == b.strip && a.frame == b.frame => {
                let along = offset[a.frame.tangent];
                let inward = offset[1 - a.frame.tangent] * a.frame.inward;
                self.strips[a.strip].factor(a.row, [along, inward])
            }
            [Some(_), None] if !is_cut(j) => Some(1.0),
            [None, Some(_)] if !is_cut(i) => Some(1.0),
            _ => None,
        }
    }
}

/// The axis along the edges within `reach` of a position, if they are all along one.
fn tangent(position: [f64; 2], segments: &[[[f64; 2]; 2]], reach: f64) -> Option<usize> {
    let mut found = None;
    for &segment in segments {
        let [a, b] = segment;
        let far = (0..2).any(|axis| {
            let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            position[axis] < low - reach || position[axis] > high + reach
        });
        if far || nearest_on_segment(position, segment).1 > reach {
            continue;
        }
        let (along, across) = ((b[0] - a[0]).abs(), (b[1] - a[1]).abs());
        let axis = usize::from(across > along);
        let is_straight = along.min(across) <= PARALLEL * along.max(across);
        if !is_straight || found.is_some_and(|other| other != axis) {
            return None;
        }
        found = Some(axis);
    }
    found
}

/// The rows across an edge, and which of them a site is in.
struct Profile {
    /// Area of a point over dx², in units of 1/[`PARTS`], from the edge inward.
    shares: Vec<i64>,
    /// Whether the body goes on behind the last row.
    open: bool,
    row: usize,
    frame: Frame,
}

/// Areas are alike to so many parts of dx²: they carry rounding errors.
const PARTS: f64 = 1e9;

/// Whether a site's family is what the rows say: all that they hold, and no more. Not so beside the tip of
/// a slit.
fn is_strip(
    sites: &Sites,
    site: usize,
    profile: &Profile,
    offsets: &[[i32; 2]],
    visibility: &Visibility,
) -> bool {
    let [columns, rows] = sites.counts();
    let at = [site % columns, site / columns].map(|k| k as i64);
    let view = visibility.from(sites.position(site));
    let Frame { tangent, inward } = profile.frame;
    offsets.iter().all(|offset| {
        let [x, y] = [0, 1].map(|axis| at[axis] + i64::from(offset[axis]));
        let is_on = x >= 0 && y >= 0 && x < columns as i64 && y < rows as i64;
        let other = y as usize * columns + x as usize;
        let found = is_on && sites.shares[other] > 0.0 && view.sees(sites.position(other));
        let row = profile.row as i64 + i64::from(offset[1 - tangent] * inward);
        let expected = row >= 0 && (profile.open || row < profile.shares.len() as i64);
        found == expected
    })
}

/// `depth`: so many rows tell all, since cut-off families at two edges farther apart share no bond.
fn profile(
    sites: &Sites,
    site: usize,
    tangent: usize,
    depth: usize,
    visibility: &Visibility,
) -> Option<Profile> {
    let [columns, rows] = sites.counts();
    let at = [site % columns, site / columns];
    let normal = 1 - tangent;
    let count = [columns, rows][normal];
    let share = |k: usize| {
        let mut at = at;
        at[normal] = k;
        sites.shares[at[1] * columns + at[0]]
    };
    // First and one past the last row of the body around the site, as far as `depth`.
    let low = at[normal].saturating_sub(depth);
    let high = (at[normal] + depth).min(count - 1);
    let position = |k: usize| {
        let mut at = at;
        at[normal] = k;
        sites.position(at[1] * columns + at[0])
    };
    let goes_on = |k: usize, next: usize| visibility.sees(position(k), position(next));
    let is_next = |k: usize, before: usize| share(k) > 0.0 && (k == before || goes_on(before, k));
    let from = (low..=at[normal]).rev();
    let from = from.take_while(|&k| is_next(k, (k + 1).min(at[normal])));
    let from = from.last()?;
    let to = (at[normal]..=high).take_while(|&k| is_next(k, k.saturating_sub(1).max(at[normal])));
    let to = to.last()?;
    let (ends_low, ends_high) = (from > low, to < high);
    let quantised = |k: usize| (share(k) * PARTS).round() as i64;
    let upward: Vec<i64> = (from..=to).map(quantised).collect();
    let downward: Vec<i64> = upward.iter().rev().copied().collect();
    let (below, above) = (at[normal] - from, to - at[normal]);
    let is_thin = ends_low && ends_high && upward.len() <= depth;
    let starts_low = match (ends_low, ends_high) {
        _ if is_thin => upward <= downward,
        (true, true) => below <= above,
        (true, false) => true,
        (false, true) => false,
        (false, false) => return None,
    };
    let (mut shares, row, inward) = if starts_low {
        (upward, below, 1)
    } else {
        (downward, above, -1)
    };
    shares.truncate(depth);
    (row < shares.len()).then_some(Profile {
        shares,
        open: !is_thin,
        row,
        frame: Frame { tangent, inward },
    })
}

/// An infinite strip of rows: the edge along the first axis, rows counted along the second.
struct Strip {
    /// β by row, and by offset along the edge and to a later row (or along the row).
    factors: BTreeMap<(usize, [i32; 2]), f64>,
}

/// Below this share of the largest eigenvalue a combination of the conditions says nothing.
const DEPENDENT: f64 = 1e-10;
/// What may remain of a unit of stress: sums of some dozens of terms of order one.
const BALANCED: f64 = 1e-9;

impl Strip {
    fn new(profile: &Profile, micromodulus: &Micromodulus) -> Result<Strip, SurfaceError> {
        let rows = Rows::new(profile, micromodulus);
        let mut factors = rows.force_factors();
        let unknowns: BTreeMap<(usize, [i32; 2]), usize> = factors
            .keys()
            .enumerate()
            .map(|(k, &key)| (key, k))
            .collect();
        let cut: Vec<usize> = (0..rows.shares.len()).filter(|&r| rows.is_cut(r)).collect();
        let mut conditions = DMatrix::zeros(3 * cut.len(), unknowns.len());
        let mut missing = DVector::zeros(3 * cut.len());
        let strain = strain_of_tension(micromodulus);
        for (k, &row) in cut.iter().enumerate() {
            missing[3 * k + 2] = 1.0;
            for &offset in &rows.stiff {
                let share = rows.share(row as i32 + offset[1]);
                let terms = terms(offset, share, strain, micromodulus);
                let key = first_end(row, offset);
                let factor = factors.get(&key).copied().unwrap_or(1.0);
                for (r, term) in terms.into_iter().enumerate() {
                    missing[3 * k + r] -= factor * term;
                    if let Some(&unknown) = unknowns.get(&key) {
                        conditions[(3 * k + r, unknown)] += term;
                    }
                }
            }
        }
        let change = least_solution(&conditions, &missing)?;
        for (factor, change) in factors.values_mut().zip(change.iter()) {
            *factor += change;
        }
        let least = factors.values().copied().fold(f64::INFINITY, f64::min);
        if least <= 0.0 {
            return Err(SurfaceError::NotPositive { factor: least });
        }
        Ok(Strip { factors })
    }

    fn factor(&self, row: usize, offset: [i32; 2]) -> Option<f64> {
        self.factors.get(&first_end(row, offset)).copied()
    }
}

/// A bond's row and offset, seen from its end in the earlier row; along a row, from its left end.
fn first_end(row: usize, [p, q]: [i32; 2]) -> (usize, [i32; 2]) {
    if q > 0 || (q == 0 && p > 0) {
        (row, [p, q])
    } else {
        ((row as i32 + q).max(0) as usize, [-p, -q])
    }
}

/// The x of least norm with C x = b, whose rows may depend on each other: x = Cᵀ (C Cᵀ)⁺ b.
fn least_solution(c: &DMatrix<f64>, b: &DVector<f64>) -> Result<DVector<f64>, SurfaceError> {
    let eigen = SymmetricEigen::new(c * c.transpose());
    let largest = eigen.eigenvalues.max();
    let mut coordinates = eigen.eigenvectors.transpose() * b;
    for (coordinate, &value) in coordinates.iter_mut().zip(eigen.eigenvalues.iter()) {
        *coordinate = if value > DEPENDENT * largest {
            *coordinate / value
        } else {
            0.0
        };
    }
    let x = c.transpose() * (eigen.eigenvectors * coordinates);
    let residual = (c * &x - b).amax();
    if residual <= BALANCED {
        Ok(x)
    } else {
        Err(SurfaceError::Unbalanced { residual })
    }
}

/// The rows of a strip, and what their families have.
struct Rows<'a> {
    shares: Vec<f64>,
    open: bool,
    /// Offsets whose bonds have stiffness.
    stiff: Vec<[i32; 2]>,
    micromodulus: &'a Micromodulus,
}

impl Rows<'_> {
    fn new<'a>(profile: &Profile, micromodulus: &'a Micromodulus) -> Rows<'a> {
        let mut stiff = family_offsets(micromodulus);
        stiff.retain(|&offset| micromodulus.density(bond(offset, micromodulus)) > 0.0);
        Rows {
            shares: profile.shares.iter().map(|&s| s as f64 / PARTS).collect(),
            open: profile.open,
            stiff,
            micromodulus,
        }
    }

    /// Area of a row's points over dx² [-].
    fn share(&self, row: i32) -> f64 {
        match self.shares.get(row as usize) {
            Some(&share) if row >= 0 => share,
            _ => f64::from(u8::from(self.open && row >= 0)),
        }
    }

    fn is_cut(&self, row: usize) -> bool {
        let misses = |&[_, q]: &[i32; 2]| self.share(row as i32 + q) != 1.0;
        self.stiff.iter().any(misses)
    }

    /// S_i/S∞ of the force method along the edge and across it [-].
    fn completeness(&self, row: usize) -> [f64; 2] {
        let (mut sum, mut whole) = ([0.0; 2], [0.0; 2]);
        for &offset in &self.stiff {
            let bond = bond(offset, self.micromodulus);
            let c = self.micromodulus.density(bond);
            let xi = bond[0].hypot(bond[1]);
            for axis in 0..2 {
                let weight = c * (bond[axis] / xi).abs().powi(3);
                sum[axis] += weight * self.share(row as i32 + offset[1]);
                whole[axis] += weight;
            }
        }
        [0, 1].map(|axis| sum[axis] / whole[axis])
    }

    /// λ of the force method between all rows whose families are cut off.
    fn force_factors(&self) -> BTreeMap<(usize, [i32; 2]), f64> {
        let of_row = |row| self.is_cut(row).then(|| self.completeness(row));
        let completeness: Vec<_> = (0..self.shares.len()).map(of_row).collect();
        let mut factors = BTreeMap::new();
        for (row, own) in completeness.iter().enumerate() {
            for &offset in &self.stiff {
                let other = completeness.get((row as i32 + offset[1]) as usize);
                let key = first_end(row, offset);
                let (Some(own), Some(Some(other)), true) = (own, other, key == (row, offset))
                else {
                    continue;
                };
                let bond = bond(offset, self.micromodulus);
                factors.insert(key, super::surface::mean_factor(bond, *own, *other));
            }
        }
        factors
    }
}

fn bond(offset: [i32; 2], micromodulus: &Micromodulus) -> [f64; 2] {
    offset.map(|steps| f64::from(steps) * micromodulus.spacing)
}

/// ε_xx and ε_yy under the stress σ_xx of a unit [1/Pa].
fn strain_of_tension(micromodulus: &Micromodulus) -> [f64; 2] {
    let [c11, c12] = lattice_moduli(micromodulus);
    let determinant = c11 * c11 - c12 * c12;
    [c11 / determinant, -c12 / determinant]
}

/// What a bond adds to a point's forces, per dx and unit of stress, and to its σ_xx, per unit.
fn terms(
    offset: [i32; 2],
    share: f64,
    [xx, yy]: [f64; 2],
    micromodulus: &Micromodulus,
) -> [f64; 3] {
    let dx = micromodulus.spacing;
    let bond = bond(offset, micromodulus);
    let xi = bond[0].hypot(bond[1]);
    let n = bond.map(|x| x / xi);
    let stretch = xx * n[0] * n[0] + yy * n[1] * n[1];
    let force = micromodulus.density(bond) * dx * dx * share * stretch;
    [
        force * n[0] * dx,
        force * n[1] * dx,
        0.5 * force * xi * n[0] * n[0],
    ]
}
