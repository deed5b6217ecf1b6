//! The damage beside a straight crack, eq. (7), and the plate with a centre crack.

use super::bodies::{TRUSS, build, material, nearest, paper_lattice, region};
use super::centre_crack::{Plate, Points, ratios};
use super::{Check, Reference, VerificationError};
use crate::cracks::Cracks;
use crate::fields::damage::damage;
use crate::mesh::grid::{Grid, name_cells};
use crate::mesh::{CellKind, Edge};
use crate::model::Method;

/// φ of a point in the row beside a crack through 40 × 20 points: 20 of 48 neighbours lie behind it.
pub fn measure_damage() -> Result<Vec<Check>, VerificationError> {
    let grid = Grid {
        size: [40.0, 20.0],
        count: [4, 4],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "points", |_| true);
    let first = mesh.nodes.len();
    mesh.nodes.extend([[0.0, 10.0], [40.0, 10.0]]);
    let crack = Edge {
        ends: [first, first + 1],
        middle: None,
    };
    let cracks = Cracks::new(&mesh, &[crack]);
    let points = Method::Peridynamics(paper_lattice(1.0));
    let regions = vec![region(&mesh, &["points"], material(1.0), points)];
    let model = build(mesh, regions, TRUSS)?.with_cracks(&cracks);
    let beside = nearest(&model.positions, [20.5, 9.5]);
    Ok(vec![Check {
        case: "damage beside a crack",
        quantity: "φ",
        reference: Reference::Value {
            value: 20.0 / 48.0,
            within: 1e-12,
        },
        source: "20 of 48 neighbours",
        measured: damage(&model, &model.integrity)[beside],
    }])
}

/// δ/a = 0.4 and 0.2.
pub fn measure_centre_crack() -> Result<Vec<Check>, VerificationError> {
    let mut checks = Vec::new();
    let check = |quantity, within, source, measured| Check {
        case: "centre crack",
        quantity,
        reference: Reference::Value { value: 1.0, within },
        source,
        measured,
    };
    let coarse = ratios(Plate::Peridynamics, Points::Corrected, 0.4, 4.0)?;
    let fine = ratios(Plate::Peridynamics, Points::Corrected, 0.2, 4.0)?;
    let hybrid = ratios(Plate::Hybrid, Points::Corrected, 0.2, 4.0)?;
    const FEM: &str = "finite elements";
    const HANDBOOK: &str = "geometry factor 1.016";
    checks.push(check("k, PD, δ/a = 0.4", 0.01, FEM, coarse.stiffness));
    checks.push(check("K_I, PD, δ/a = 0.4", 0.03, HANDBOOK, coarse.factor));
    checks.push(check("k, PD, δ/a = 0.2", 0.005, FEM, fine.stiffness));
    checks.push(check("K_I, PD, δ/a = 0.2", 0.02, HANDBOOK, fine.factor));
    let limit = 2.0 * fine.factor - coarse.factor;
    checks.push(check(
        "K_I, PD, δ → 0 (straight line)",
        0.01,
        HANDBOOK,
        limit,
    ));
    checks.push(check("k, hybrid, δ/a = 0.2", 0.005, FEM, hybrid.stiffness));
    checks.push(check(
        "K_I, hybrid, δ/a = 0.2",
        0.025,
        HANDBOOK,
        hybrid.factor,
    ));
    Ok(checks)
}
