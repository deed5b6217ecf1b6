//! Strain at material points beside a joint of two materials.
//!
//! A bond across a joint stretches as the mean of its two sides, so that the strain of a family with such
//! bonds is that of neither. Two things do not jump at the joint: the strain along it, ε_tt, which the
//! family has right, and the traction across it, which is the flux of the bonds' forces through the
//! point's square (Lehoucq & Silling 2008; its mean over an area: Hardy 1982),
//!
//! ```text
//! σ_f = 1/(A_i h_t) Σ k ξ s ℓ n⊗n,   ℓ: length of the bond within the square
//! ```
//!
//! The mean of σ_f over a row of squares is the force across the row, whatever the materials. With
//! q = (n_x², n_y², n_x n_y) and k* the stiffness of the bond if all of it were the point's material,
//!
//! ```text
//! (Σ k* ξ ℓ q qᵀ) ε_f = Σ φ k ξ s ℓ q
//! ```
//!
//! makes it a strain that is exact at a free side too. From both, along the joint's tangent t and normal n,
//!
//! ```text
//! ε_tt,   ε_nn = ε_f,nn + (D12/D11) (ε_f,tt − ε_tt),   γ_nt = γ_f,nt
//! ```

use super::points::strain_of_family;
use crate::model::{Model, PointRegion};
use nalgebra::{Matrix3, Vector3};

/// A material point with bonds across a joint.
struct JointPoint {
    /// Node of the point.
    node: usize,
    /// Unit vector towards the other material.
    normal: [f64; 2],
    /// Σ k* ξ ℓ q qᵀ [N m].
    family: Matrix3<f64>,
    /// Σ φ k ξ s ℓ q [N m].
    carried: Vector3<f64>,
}

/// Below this share of the sum of their lengths, the bonds to the other material surround a point, and the
/// joint has no normal there.
const SURROUNDED: f64 = 1e-3;

/// Replaces the strains (Voigt order, by material point) of the points that have bonds across a joint.
pub(super) fn correct(
    model: &Model,
    displacement: &[[f64; 2]],
    integrity: &[f64],
    strains: &mut [Vector3<f64>],
) {
    let mixed = model.points.iter().filter(|points| {
        let young = |region: usize| model.bond_young(region);
        let mut members = model.members(points.region);
        members.any(|region| young(region) != young(points.region))
    });
    let mixed: Vec<&PointRegion> = mixed.collect();
    if mixed.is_empty() {
        return;
    }
    let first = model.fe_node_count();
    let mut joint_points = joint_points(model);
    let mut place_of = vec![None; model.areas.len()];
    for (place, point) in joint_points.iter().enumerate() {
        place_of[point.node - first] = Some(place);
    }
    for interaction in model
        .interactions
        .bonds()
        .chain(model.interactions.clipped_bonds())
    {
        let mut nodes = model.interactions.nodes(interaction).iter();
        let lattice = nodes.find_map(|&node| {
            let is_in = |points: &&&PointRegion| points.nodes.contains(&(node as usize));
            mixed.iter().find(is_in)
        });
        let (Some(points), Some(young)) = (lattice, model.mean_young(interaction)) else {
            continue;
        };
        let (xi, [nx, ny]) = model.interactions.axis(interaction, &model.positions);
        let q = Vector3::new(nx * nx, ny * ny, nx * ny);
        let weight = model.interactions.stiffness[interaction] * xi * xi;
        let phi = integrity[interaction];
        let stretch = match phi > 0.0 {
            true => (model.interactions).stretch(interaction, &model.positions, displacement),
            false => 0.0,
        };
        let segment = model.interactions.segment(interaction, &model.positions);
        for_each_square(points, segment, |node, share| {
            if let Some(place) = place_of[node - first] {
                let point = &mut joint_points[place];
                let own = model.bond_young_of_point(node) / young;
                point.family += own * weight * share * q * q.transpose();
                point.carried += phi * weight * share * stretch * q;
            }
        });
    }
    for point in &joint_points {
        if let Some(flux) = strain_of_family(&point.family, &point.carried) {
            let strain = &mut strains[point.node - first];
            let elasticity = model
                .material_of_point(point.node)
                .elasticity(model.settings.plane);
            let ratio = elasticity[(0, 1)] / elasticity[(0, 0)];
            *strain = combined(strain, &flux, point.normal, ratio);
        }
    }
}

/// The points with bonds to another material, ascending.
fn joint_points(model: &Model) -> Vec<JointPoint> {
    let first = model.fe_node_count();
    // Sum of the vectors to neighbours of another material, and of their lengths, by k.
    let mut sums = vec![([0.0; 2], 0.0); model.areas.len()];
    for (bond, pair) in model.interactions.bonds().zip(model.interactions.pairs()) {
        let ends = pair.map(|node| node as usize);
        let [a, b] = ends.map(|node| model.bond_young_of_point(node));
        if a == b {
            continue;
        }
        let (xi, n) = model.interactions.axis(bond, &model.positions);
        let weight = model.interactions.stiffness[bond] * xi;
        for (node, sign) in ends.into_iter().zip([1.0, -1.0]) {
            let (vector, length) = &mut sums[node - first];
            (0..2).for_each(|axis| vector[axis] += sign * weight * n[axis]);
            *length += weight;
        }
    }
    let point = |(point, (vector, sum)): (usize, ([f64; 2], f64))| {
        let length = vector[0].hypot(vector[1]);
        (length > SURROUNDED * sum).then(|| JointPoint {
            node: first + point,
            normal: vector.map(|x| x / length),
            family: Matrix3::zeros(),
            carried: Vector3::zeros(),
        })
    };
    sums.into_iter().enumerate().filter_map(point).collect()
}

/// Calls `visit` with the node of every point whose square a segment [m] crosses, and the share of the
/// segment's length within it.
fn for_each_square(
    points: &PointRegion,
    segment: [[f64; 2]; 2],
    mut visit: impl FnMut(usize, f64),
) {
    let index = &points.index;
    let [a, b] = segment.map(|x| index.coordinates(points.axes.local(x)));
    let mut cuts = vec![0.0, 1.0];
    for axis in 0..2 {
        let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
        let (from, to) = ((low - 0.5).ceil() as i64, (high - 0.5).floor() as i64);
        let cut = |k: i64| (k as f64 + 0.5 - a[axis]) / (b[axis] - a[axis]);
        cuts.extend((from..=to).map(cut).filter(|t| (0.0..=1.0).contains(t)));
    }
    cuts.sort_unstable_by(f64::total_cmp);
    for piece in cuts.windows(2) {
        let middle = 0.5 * (piece[0] + piece[1]);
        let site = [0, 1].map(|k| (a[k] + middle * (b[k] - a[k])).round() as i64);
        if let Some(point) = index.point(site) {
            visit(points.nodes.start + point as usize, piece[1] - piece[0]);
        }
    }
}

/// The strain with ε_tt of `family` and the traction of `flux`; `ratio`: D12/D11.
fn combined(
    family: &Vector3<f64>,
    flux: &Vector3<f64>,
    [x, y]: [f64; 2],
    ratio: f64,
) -> Vector3<f64> {
    // ε_nn, ε_tt and γ_nt with t = (−y, x), and back.
    let (xx, yy, xy) = (x * x, y * y, x * y);
    let turn = |e: &Vector3<f64>| {
        [
            xx * e[0] + yy * e[1] + xy * e[2],
            yy * e[0] + xx * e[1] - xy * e[2],
            2.0 * xy * (e[1] - e[0]) + (xx - yy) * e[2],
        ]
    };
    let [_, along, _] = turn(family);
    let [across, flux_along, shear] = turn(flux);
    let across = across + ratio * (flux_along - along);
    Vector3::new(
        xx * across + yy * along - xy * shear,
        yy * across + xx * along + xy * shear,
        2.0 * xy * (across - along) + (xx - yy) * shear,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_strains_are_left_as_they_are() {
        let strain = Vector3::new(3e-4, -1e-4, 2e-4);
        for angle in [0.0, 0.3, 1.2, 2.9, -0.7] {
            let (y, x) = f64::sin_cos(angle);
            let found = combined(&strain, &strain, [x, y], 1.0 / 3.0);
            // Products of sines and cosines, each rounded.
            assert!((found - strain).amax() < 1e-18, "{angle}: {found}");
        }
    }

    #[test]
    fn the_strain_along_the_joint_is_the_familys_and_the_traction_the_fluxs() {
        let (family, flux) = (Vector3::new(1.0, 2.0, 4.0), Vector3::new(3.0, 5.0, 7.0));
        let ratio = 0.25;
        let found = combined(&family, &flux, [1.0, 0.0], ratio);
        assert_eq!(found, Vector3::new(3.75, 2.0, 7.0));
        // σ_nn is D11 (ε_nn + ratio ε_tt).
        assert_eq!(found[0] + ratio * found[1], flux[0] + ratio * flux[1]);
        let found = combined(&family, &flux, [0.0, 1.0], ratio);
        assert_eq!(found, Vector3::new(1.0, 5.5, 7.0));
    }
}
