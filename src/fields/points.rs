//! Strain and stress at the material points, from what their bonds carry.
//!
//! Bonds in a uniform strain ε have the stretch s = q·ε with q = (n_x², n_y², n_x n_y), ε in Voigt
//! order, and carry the stress Σ k ξ² s q / (2 A_i h_t). With the same sum over the whole family on
//! the other side,
//!
//! ```text
//! (Σ_family k ξ² q qᵀ) ε = Σ_family φ k ξ² s q,   σ = D ε
//! ```
//!
//! a uniform strain comes back exactly, from whatever family: also where it is cut by a free surface or
//! an interface. A bond carries φ k ξ s, so that σ fades with damage. The bonds across a joint of two materials
//! stretch as the mean of its sides, and count only where the others are too few. Beside sides and joints
//! `tractions.rs` replaces the strain.

use super::{strain_tensor, stress_tensor, tractions};
use crate::model::{FamilyMember, Model};
use nalgebra::{Matrix3, Vector3};

/// Strain and stress of every material point; zero where a family has bonds in fewer than three
/// directions.
#[derive(Clone, Debug, Default)]
pub struct PointFields {
    /// xx, yy, zz, xy [-]; xy is γ/2.
    pub strain: Vec<[f64; 4]>,
    /// xx, yy, zz, xy [Pa].
    pub stress: Vec<[f64; 4]>,
}

/// Determinant of the family's sum over the cube of its third of a trace, below which its directions are
/// too few: a half disc has some 0.3, two directions zero.
const FLAT: f64 = 1e-6;

/// Σ k ξ² q qᵀ and Σ φ k ξ² s q [N m].
type Sums = (Matrix3<f64>, Vector3<f64>);

impl PointFields {
    pub fn new(model: &Model, displacement: &[[f64; 2]], integrity: &[f64]) -> PointFields {
        let first = model.fe_node_count();
        let mut own = vec![(Matrix3::zeros(), Vector3::zeros()); model.areas.len()];
        let mut across = own.clone();
        for FamilyMember {
            interaction, point, ..
        } in model.families()
        {
            let (xi, [nx, ny]) = model.interactions.axis(interaction, &model.positions);
            let q = Vector3::new(nx * nx, ny * ny, nx * ny);
            let weight = model.interactions.stiffness[interaction] * xi * xi;
            let phi = integrity[interaction];
            let stretch = match phi > 0.0 {
                true => (model.interactions).stretch(interaction, &model.positions, displacement),
                false => 0.0,
            };
            let is_across = model.is_across_joint(interaction);
            let (family, carried) = &mut (if is_across { &mut across } else { &mut own })[point];
            *family += weight * q * q.transpose();
            *carried += phi * weight * stretch * q;
        }
        let strain = |(own, across): (&Sums, &Sums)| {
            let of_own = strain_of_family(&own.0, &own.1);
            let of_all = || strain_of_family(&(own.0 + across.0), &(own.1 + across.1));
            of_own.or_else(of_all).unwrap_or_else(Vector3::zeros)
        };
        let mut strains: Vec<Vector3<f64>> = own.iter().zip(&across).map(strain).collect();
        tractions::correct(model, displacement, integrity, &mut strains);
        let mut fields = PointFields::default();
        let plane = model.settings.plane;
        for (point, strain) in strains.iter().enumerate() {
            let material = model.material_of_point(first + point);
            fields.strain.push(strain_tensor(strain, material, plane));
            fields.stress.push(stress_tensor(strain, material, plane));
        }
        fields
    }
}

/// The strain ε of (Σ k ξ² q qᵀ) ε = Σ k ξ² s q; `None` where the directions are too few.
fn strain_of_family(family: &Matrix3<f64>, carried: &Vector3<f64>) -> Option<Vector3<f64>> {
    let scale = family.trace() / 3.0;
    let is_flat = family.determinant() <= FLAT * scale.powi(3);
    let inverse = if is_flat { None } else { family.try_inverse() };
    inverse.map(|inverse| inverse * carried)
}
