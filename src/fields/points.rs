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
//! an interface. A bond carries φ k ξ s, so that σ fades with damage.

use super::{joints, strain_tensor, stress_tensor};
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

impl PointFields {
    pub fn new(model: &Model, displacement: &[[f64; 2]], integrity: &[f64]) -> PointFields {
        let first = model.fe_node_count();
        let mut family = vec![Matrix3::zeros(); model.areas.len()];
        let mut carried = vec![Vector3::zeros(); model.areas.len()];
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
            family[point] += weight * q * q.transpose();
            carried[point] += phi * weight * stretch * q;
        }
        let mut fields = PointFields::default();
        let plane = model.settings.plane;
        let strains = family.iter().zip(&carried).map(|(family, carried)| {
            strain_of_family(family, carried).unwrap_or_else(Vector3::zeros)
        });
        let mut strains: Vec<Vector3<f64>> = strains.collect();
        joints::correct(model, displacement, integrity, &mut strains);
        for (point, strain) in strains.iter().enumerate() {
            let material = model.material_of_point(first + point);
            fields.strain.push(strain_tensor(strain, material, plane));
            fields.stress.push(stress_tensor(strain, material, plane));
        }
        fields
    }
}

/// The strain ε of (Σ k ξ² q qᵀ) ε = Σ k ξ² s q; `None` where the directions are too few.
pub(super) fn strain_of_family(
    family: &Matrix3<f64>,
    carried: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let scale = family.trace() / 3.0;
    let is_flat = family.determinant() <= FLAT * scale.powi(3);
    let inverse = if is_flat { None } else { family.try_inverse() };
    inverse.map(|inverse| inverse * carried)
}
