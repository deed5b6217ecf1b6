//! The factors along an infinite strip of rows, by least squares.

use super::profile::{PARTS, Profile};
use crate::peridynamics::bonds::family_offsets;
use crate::peridynamics::isotropy::lattice_moduli;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::surface::{SurfaceError, mean_factor};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::collections::BTreeMap;

/// An infinite strip of rows: the edge along the first axis, rows counted along the second.
pub(super) struct Strip {
    /// β by row, and by offset along the edge and to a later row (or along the row).
    factors: BTreeMap<(usize, [i32; 2]), f64>,
}

/// Below this share of the largest eigenvalue a combination of the conditions says nothing.
const DEPENDENT: f64 = 1e-10;
/// Largest residual of a unit of stress: sums of some dozens of terms of order one.
const BALANCED: f64 = 1e-9;

impl Strip {
    pub(super) fn new(
        profile: &Profile,
        micromodulus: &Micromodulus,
    ) -> Result<Strip, SurfaceError> {
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

    pub(super) fn factor(&self, row: usize, offset: [i32; 2]) -> Option<f64> {
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
                factors.insert(key, mean_factor(bond, *own, *other));
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

/// Contributions of a bond to a point's forces, per dx and unit of stress, and to its σ_xx, per unit.
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
