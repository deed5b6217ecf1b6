//! Damage of the material points, Qian et al. (2021), eq. (7), with the integrity φ_ij of every bond in
//! place of the μ_ij that is 0 or 1:
//!
//! ```text
//! φ_i = 1 − Σ φ_ij A_j / Σ A_j
//! ```

use crate::model::Model;

/// Damage of every material point: 0 where its family is whole, 1 where it is gone [-]. `integrity`: φ of
/// every interaction [-].
pub fn damage(model: &Model, integrity: &[f64]) -> Vec<f64> {
    let mut lost = vec![0.0; model.areas.len()];
    let mut whole = vec![0.0; model.areas.len()];
    for member in model.families() {
        let area = model.neighbour_area(&member);
        whole[member.point] += area;
        lost[member.point] += (1.0 - integrity[member.interaction]) * area;
    }
    let points = lost.iter().zip(whole);
    points
        .map(|(lost, whole)| if whole > 0.0 { lost / whole } else { 0.0 })
        .collect()
}
