//! Strain at material points whose family is cut off by a side of the body, or by a joint of two materials.
//!
//! The displacements there are those of a body that is softer or stiffer than D. Two things are right all the
//! same: the strain along the side, ε_tt, and the traction across it, which is the flux of the forces through the
//! point's square (Lehoucq & Silling 2008; its mean over an area: Hardy 1982).
//!
//! ```text
//! A h_t σ_f = Σ φ k ξ s ℓ n ⊗ n + Σ ℓ R ⊗ d,   ℓ: length of the bond or path within the square
//! ```
//!
//! R is the force that holds a point in equilibrium with its bonds: zero at a free point, else a load, a
//! reaction or the force of trusses. It reaches the point from the nearest side, on a path along the side's
//! outward normal d. So the mean of σ_f over a row of squares is the force across the row. With the side's
//! normal n and the moduli D_l of the endless lattice
//!
//! ```text
//! ε_tt = ε_tt of the family,   (D_l ε) n = σ_f n
//! ```
//!
//! Near a corner the tractions on both sides are known, and ε is that of D_l ε = sym σ_f.

use crate::geometry::nearest_on_segment;
use crate::model::{Model, PointRegion};
use crate::peridynamics::bonds::family_offsets;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, RowVector3, Vector2, Vector3};

/// A point is within the body if its bonds point away from a side by less than this [-]: parts of bonds
/// balance to some hundredths at a clipped interface.
const INSIDE: f64 = 0.02;

/// Sides whose distances differ by less, in spacings, are equally near.
const EQUALLY_NEAR: f64 = 1e-6;

/// Replaces the strains (Voigt order, by material point) of the points beside a side or a joint.
pub(super) fn correct(
    model: &Model,
    displacement: &[[f64; 2]],
    integrity: &[f64],
    strains: &mut [Vector3<f64>],
) {
    let first = model.fe_node_count();
    let directions = side_directions(model);
    let stress = fluxes(model, displacement, integrity, &directions);
    for points in &model.points {
        let moduli = lattice_moduli(points);
        for node in points.nodes.clone() {
            let (directions, stress) = (&directions[node - first], &stress[node - first]);
            if directions.trace() > 0.0 {
                let strain = &mut strains[node - first];
                let factor = model.bond_young_of_point(node) / model.bond_young(points.region);
                *strain = combined(strain, stress, directions, &(factor * moduli));
            }
        }
    }
}

/// Σ k ξ v ⊗ v over the neighbours of every material point; zero away from sides and joints. v: mean direction of
/// a neighbour's bonds in its own material.
fn side_directions(model: &Model) -> Vec<Matrix2<f64>> {
    let inwards = inwards(model);
    let first = model.fe_node_count();
    let mut directions = vec![Matrix2::zeros(); inwards.len()];
    for (bond, pair) in model.interactions.bonds().zip(model.interactions.pairs()) {
        let length = model.interactions.length(bond, &model.positions);
        let weight = model.interactions.stiffness[bond] * length;
        let [i, j] = pair.map(|node| node as usize - first);
        for (own, other) in [(i, j), (j, i)] {
            directions[own] += weight * inwards[other] * inwards[other].transpose();
        }
    }
    directions
}

/// Mean direction of the bonds of every material point in its own material; zero within the body.
fn inwards(model: &Model) -> Vec<Vector2<f64>> {
    let first = model.fe_node_count();
    let mut sums = vec![(Vector2::zeros(), 0.0); model.areas.len()];
    for member in model.families() {
        let [a, b] = (model.interactions).segment(member.interaction, &model.positions);
        let (xi, n) = (model.interactions).axis(member.interaction, &model.positions);
        let x = model.positions[first + member.point];
        let towards = (0..2)
            .map(|k| (0.5 * (a[k] + b[k]) - x[k]) * n[k])
            .sum::<f64>();
        let weight = model.interactions.stiffness[member.interaction] * xi;
        let (sum, total) = &mut sums[member.point];
        *total += weight;
        if !model.is_across_joint(member.interaction) {
            *sum += weight * towards.signum() * Vector2::from(n);
        }
    }
    let mean = |(sum, total): (Vector2<f64>, f64)| {
        let is_beside = sum.norm() > INSIDE * total;
        if is_beside {
            sum / total
        } else {
            Vector2::zeros()
        }
    };
    sums.into_iter().map(mean).collect()
}

/// σ_f of every material point that has side directions [Pa].
fn fluxes(
    model: &Model,
    displacement: &[[f64; 2]],
    integrity: &[f64],
    directions: &[Matrix2<f64>],
) -> Vec<Matrix2<f64>> {
    let first = model.fe_node_count();
    let interactions = &model.interactions;
    let is_beside = |node: usize| node >= first && directions[node - first].trace() > 0.0;
    let mut forces = vec![Vector2::zeros(); directions.len()];
    let mut fluxes = vec![Matrix2::zeros(); directions.len()];
    for interaction in interactions.bonds().chain(interactions.clipped_bonds()) {
        let nodes = interactions.nodes(interaction);
        if !nodes.iter().any(|&node| is_beside(node as usize)) {
            continue;
        }
        let lattice = |&node: &u32| lattice_of(model, node as usize);
        let Some(points) = nodes.iter().find_map(lattice) else {
            continue;
        };
        let stiffness = integrity[interaction] * interactions.stiffness[interaction];
        if stiffness == 0.0 {
            continue;
        }
        let (xi, n) = interactions.axis(interaction, &model.positions);
        let stretch = interactions.stretch(interaction, &model.positions, displacement);
        let force = stiffness * xi * stretch;
        interactions.for_each_term(interaction, &model.positions, |node, w| {
            if let Some(point) = (node as usize).checked_sub(first) {
                forces[point] += force * Vector2::from(w);
            }
        });
        let n = Vector2::from(n);
        let moment = force * xi * n * n.transpose();
        let segment = interactions.segment(interaction, &model.positions);
        for_each_square(points, segment, |node, share| {
            fluxes[node - first] += share * moment;
        });
    }
    for points in &model.points {
        for node in points.nodes.clone().filter(|node| is_beside(*node)) {
            let force: Vector2<f64> = forces[node - first];
            let (distance, d) = nearest_side(points, model.positions[node], force);
            // A whole square counts beyond the side too.
            let length = match model.has_clipped_areas(points) {
                true => distance,
                false => points.micromodulus.reach(),
            };
            let [x, y] = model.positions[node];
            let path = [[x, y], [x + length * d[0], y + length * d[1]]];
            let moment = length * force * d.transpose();
            for_each_square(points, path, |node, share| {
                fluxes[node - first] += share * moment
            });
        }
        let square = points.micromodulus.spacing.powi(2);
        for point in points.nodes.clone().map(|node| node - first) {
            // What a sliver without a point of its own adds lies outside the square.
            fluxes[point] /= model.areas[point].min(square) * model.settings.thickness;
        }
    }
    fluxes
}

/// The lattice of a material point.
fn lattice_of(model: &Model, node: usize) -> Option<&PointRegion> {
    model
        .points
        .iter()
        .find(|points| points.nodes.contains(&node))
}

/// Distance [m] from the nearest side and its outward normal; in a corner, of the side that a force pulls at.
fn nearest_side(points: &PointRegion, x: [f64; 2], force: Vector2<f64>) -> (f64, Vector2<f64>) {
    let same = EQUALLY_NEAR * points.micromodulus.spacing;
    let mut nearest = (f64::INFINITY, Vector2::zeros());
    for side in points.outline.segments() {
        let [a, b] = side;
        let distance = nearest_on_segment(x, side).1;
        let normal = Vector2::new(b[1] - a[1], a[0] - b[0]).normalize();
        let pulls_more = force.dot(&normal).abs() > force.dot(&nearest.1).abs();
        if distance < nearest.0 - same || (distance < nearest.0 + same && pulls_more) {
            nearest = (distance, normal);
        }
    }
    nearest
}

/// D_l [Pa]: ½ Σ c ξ q qᵀ A over a whole family.
fn lattice_moduli(points: &PointRegion) -> Matrix3<f64> {
    let micromodulus = &points.micromodulus;
    let dx = micromodulus.spacing;
    let term = |offset: [i32; 2]| {
        let bond = offset.map(|steps| f64::from(steps) * dx);
        let xi = bond[0].hypot(bond[1]);
        let [x, y] = points.axes.global(bond.map(|x| x / xi));
        let q = Vector3::new(x * x, y * y, x * y);
        0.5 * micromodulus.density(bond) * xi * dx * dx * q * q.transpose()
    };
    family_offsets(micromodulus).into_iter().map(term).sum()
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

/// The strain with the ε_tt of `family` and the traction of `stress` across the side; in a corner, that of `stress`.
/// The side's normal is the main axis of `directions`, and the ratio of its two values tells how much of a corner
/// it is.
fn combined(
    family: &Vector3<f64>,
    stress: &Matrix2<f64>,
    directions: &Matrix2<f64>,
    moduli: &Matrix3<f64>,
) -> Vector3<f64> {
    let axes = directions.symmetric_eigen();
    let main = axes.eigenvalues.imax();
    let corner = (axes.eigenvalues.min() / axes.eigenvalues[main]).max(0.0);
    let n = axes.eigenvectors.column(main);
    let (x, y) = (n[0], n[1]);
    let across = Matrix2x3::new(x, 0.0, y, 0.0, y, x) * moduli;
    let along = RowVector3::new(y * y, x * x, -x * y);
    let side = Matrix3::from_rows(&[across.row(0).into(), across.row(1).into(), along]);
    let traction = stress * n;
    let of_side = Vector3::new(traction[0], traction[1], (along * family)[0]);
    let shear = 0.5 * (stress[(0, 1)] + stress[(1, 0)]);
    let of_corner = Vector3::new(stress[(0, 0)], stress[(1, 1)], shear);
    match (side.lu().solve(&of_side), moduli.lu().solve(&of_corner)) {
        (Some(of_side), Some(of_corner)) => of_side.lerp(&of_corner, corner),
        _ => *family,
    }
}
