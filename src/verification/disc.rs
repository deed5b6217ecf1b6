//! The Brazilian disc: diameter D, pressed together by P along y.
//!
//! On the horizontal diameter, with x from the centre (Timoshenko & Goodier):
//!
//! ```text
//! σ_x = 2P/(πDh_t) [(D² − 4x²)/(D² + 4x²)]²,   σ_y = 2P/(πDh_t) [1 − 4D⁴/(D² + 4x²)²]
//! ```
//!
//! so that at the centre σ_x = 2P/(πDh_t) and σ_y = −3σ_x.

use super::bodies::{build, default_lattice, material, region, solve};
use super::{Check, Reference, VerificationError};
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::fields::points::PointFields;
use crate::mesh::grid::name_cells;
use crate::mesh::patchwork::{Patch, on_circle, on_square, patchwork};
use crate::mesh::{CellKind, Mesh};
use crate::model::{Method, Model};
use std::f64::consts::PI;

/// The method of the disc; D, h_t, E and P are 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disc {
    Peridynamics,
    /// A square of material points in the middle.
    Hybrid,
}

const RADIUS: f64 = 0.5;
/// Half-side of the square [D].
const SQUARE: f64 = 0.2;
/// Elements along a side of the square, and from there to the rim.
const AROUND: usize = 16;
const ACROSS: usize = 10;

fn mesh() -> Mesh {
    let core = |[s, t]: [f64; 2]| [s, t].map(|s| SQUARE * (2.0 * s - 1.0));
    let rim = |quarter| {
        move |[s, t]: [f64; 2]| {
            let t = 2.0 * t - 1.0;
            let (inner, outer) = (on_square(SQUARE, t, quarter), on_circle(RADIUS, t, quarter));
            [0, 1].map(|k| (1.0 - s) * inner[k] + s * outer[k])
        }
    };
    let rims = [0, 1, 2, 3].map(rim);
    let mut patches = vec![Patch {
        count: [AROUND, AROUND],
        map: &core,
    }];
    for map in &rims {
        patches.push(Patch {
            count: [ACROSS, AROUND],
            map,
        });
    }
    let mut mesh = patchwork(CellKind::Quad8, 1.0, &patches);
    name_cells(&mut mesh, "core", |[x, y]| x.abs().max(y.abs()) < SQUARE);
    name_cells(&mut mesh, "rim", |[x, y]| x.abs().max(y.abs()) > SQUARE);
    mesh
}

/// σ_x and σ_y over 2P/(πDh_t) at x/D from the centre.
pub fn exact(x: f64) -> [f64; 2] {
    let sum = 1.0 + 4.0 * x * x;
    [((1.0 - 4.0 * x * x) / sum).powi(2), 1.0 - 4.0 / (sum * sum)]
}

/// (x/D, σ_x, σ_y over 2P/(πDh_t)) of the material points beside the horizontal diameter, from left to
/// right, at dx = D/`per_diameter`, an even number.
///
/// # Errors
/// Errors of building and solving.
pub fn profile(disc: Disc, per_diameter: usize) -> Result<Vec<[f64; 3]>, VerificationError> {
    let dx = 1.0 / per_diameter as f64;
    let mesh = mesh();
    let points = Method::Peridynamics(default_lattice(dx));
    let regions = match disc {
        Disc::Peridynamics => vec![region(&mesh, &["core", "rim"], material(1.0), points)],
        Disc::Hybrid => vec![
            region(&mesh, &["core"], material(1.0), points),
            region(&mesh, &["rim"], material(1.0), Method::FiniteElements),
        ],
    };
    let model = build(mesh, regions, Coupling::Clip)?;
    let solution = solve(&model, &pressed(&model))?;
    let fields = PointFields::new(&model, &solution.displacement, &model.integrity);
    let first = model.fe_node_count();
    let points = model.positions[first..].iter().zip(&fields.stress);
    let row = points.filter(|([_, y], _)| (y - 0.5 * dx).abs() < 1e-6 * dx);
    let unit = 2.0 / PI;
    let mut row: Vec<[f64; 3]> = row
        .map(|(x, stress)| [x[0], stress[0] / unit, stress[1] / unit])
        .collect();
    row.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    Ok(row)
}

/// P on the top and on the bottom, shared by the nodes that are nearest; what holds the disc carries
/// nothing.
fn pressed(model: &Model) -> Boundary {
    let mut boundary = Boundary::new(model);
    for sign in [1.0, -1.0] {
        let ends = nearest_all(model, [0.0, sign * RADIUS]);
        for &node in &ends {
            boundary.load[2 * node + 1] -= sign / ends.len() as f64;
        }
    }
    let held = |at| nearest_all(model, at)[0];
    let (left, right) = (held([-RADIUS, 0.0]), held([RADIUS, 0.0]));
    for dof in [2 * left, 2 * left + 1, 2 * right + 1] {
        boundary.prescribed.insert(dof, (0.0, "held".to_owned()));
    }
    boundary
}

/// All nodes at the least distance, ascending; at least one.
fn nearest_all(model: &Model, at: [f64; 2]) -> Vec<usize> {
    let distance = |x: &[f64; 2]| (x[0] - at[0]).hypot(x[1] - at[1]);
    let least = model
        .positions
        .iter()
        .map(distance)
        .fold(f64::INFINITY, f64::min);
    let nodes = 0..model.node_count();
    nodes
        .filter(|&node| distance(&model.positions[node]) < least + 1e-6)
        .collect()
}

/// Stresses at the centre: the mean of the two points nearest to it.
fn centre(disc: Disc) -> Result<[f64; 2], VerificationError> {
    let row = profile(disc, PER_DIAMETER)?;
    let middle = row.len() / 2;
    let mean = |k: usize| 0.5 * (row[middle - 1][k] + row[middle][k]);
    Ok([mean(1), mean(2)])
}

/// Points per diameter of what is checked.
pub const PER_DIAMETER: usize = 100;

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let check = |quantity, value, within, measured| Check {
        case: "Brazilian disc",
        quantity,
        reference: Reference::Value { value, within },
        source: "closed form",
        measured,
    };
    let [x, y] = centre(Disc::Peridynamics)?;
    let [hybrid_x, hybrid_y] = centre(Disc::Hybrid)?;
    Ok(vec![
        check("σ_x πDh_t/2P, centre, PD", 1.0, 0.005, x),
        check("σ_y πDh_t/2P, centre, PD", -3.0, 0.005, y),
        check("σ_x πDh_t/2P, centre, hybrid", 1.0, 0.005, hybrid_x),
        check("σ_y πDh_t/2P, centre, hybrid", -3.0, 0.005, hybrid_y),
    ])
}
