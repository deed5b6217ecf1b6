//! Lattices of bonds and cells at any Poisson's ratio: the energy of a uniform strain in them.
//!
//! An inner point of a square has half of each of its bonds and a quarter of each of the cells around it. Their energy is
//! ½ ε:D:ε A h_t, exactly.

use super::bodies::{build_in, default_lattice, nearest, region};
use super::{Check, Reference, VerificationError};
use crate::coupling::Coupling;
use crate::material::{Material, PlaneState};
use crate::mesh::CellKind;
use crate::mesh::grid::{Grid, name_cells};
use crate::model::{Method, PeridynamicSettings};
use nalgebra::Vector3;

/// Points along a side of the square; the family of the middle one is whole up to m = 6.
const SIDE: f64 = 15.0;

/// Poisson's ratios that are measured.
pub const RATIOS: [f64; 6] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.45];

/// Strains ε_x, ε_y and γ.
const STRAINS: [[f64; 3]; 4] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.7, -0.4, 0.3],
];

/// The largest relative error of the energy of a uniform strain at an inner point. `settings` have the spacing 1 m.
///
/// # Errors
/// Errors of [`crate::model::Model::build`].
pub fn energy_error(
    settings: PeridynamicSettings,
    material: Material,
    plane: PlaneState,
) -> Result<f64, VerificationError> {
    let grid = Grid {
        size: [SIDE; 2],
        count: [1, 1],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "body", |_| true);
    let method = Method::Peridynamics(settings);
    let regions = vec![region(&mesh, &["body"], material, method)];
    let model = build_in(plane, mesh, regions, Coupling::Clip)?;
    let interactions = &model.interactions;
    let middle = nearest(&model.positions, [0.5 * SIDE; 2]) as u32;
    let mut largest = 0.0f64;
    for [xx, yy, gamma] in STRAINS {
        let displace = |[x, y]: &[f64; 2]| [xx * x + 0.5 * gamma * y, 0.5 * gamma * x + yy * y];
        let u: Vec<[f64; 2]> = model.positions.iter().map(displace).collect();
        let own = (0..interactions.len()).filter(|&s| interactions.nodes(s).contains(&middle));
        let energy = own.map(|s| {
            let e = model.stretch(s, &u) * interactions.length(s, &model.positions);
            0.5 * interactions.stiffness[s] * e * e / interactions.nodes(s).len() as f64
        });
        let strain = Vector3::new(xx, yy, gamma);
        let exact = 0.5 * strain.dot(&(material.elasticity(plane) * strain));
        largest = largest.max((energy.sum::<f64>() / exact - 1.0).abs());
    }
    Ok(largest)
}

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let mut checks = Vec::new();
    for (plane, quantity) in [
        (PlaneState::Stress, "moduli at ν = 0 … 0.45, plane stress"),
        (PlaneState::Strain, "moduli at ν = 0 … 0.45, plane strain"),
    ] {
        let mut measured = 0.0f64;
        for poisson in RATIOS {
            let material = Material {
                young: 1.0,
                poisson,
            };
            measured = measured.max(energy_error(default_lattice(1.0), material, plane)?);
        }
        checks.push(Check {
            case: "any Poisson's ratio",
            quantity,
            reference: Reference::Zero { within: 1e-12 },
            source: "exact",
            measured,
        });
    }
    Ok(checks)
}
