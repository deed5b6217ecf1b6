//! Patch tests: an island of 12 × 8 material points within finite elements, displacements prescribed
//! around the outside; and the balance of all forces on it.
//!
//! ```text
//!   28 dx × 24 dx, the origin at the lower left corner
//!   ┌───────────────┐
//!   │   elements    │  8 dx = 2 δ on every side, h = 4 dx
//!   │   ┌·······┐   │
//!   │   · 12 × 8 ·  │  points on cell centres, dx/2 from the interface; m = 4, quartic kernel
//!   │   └·······┘   │
//!   └───────────────┘
//! ```

use super::bodies::{
    TRUSS, build, default_lattice, hold_outline, material, paper_lattice, region, relative_error,
    solve,
};
use super::{Check, Reference, VerificationError};
use crate::coupling::Coupling;
use crate::material::Material;
use crate::mesh::CellKind;
use crate::mesh::grid::{Grid, name_cells};
use crate::model::{Method, Model};

const DX: f64 = 2.5e-3;

/// A displacement field u(x) [m].
type Field = fn([f64; 2]) -> [f64; 2];

const UNIT_STRAINS: [Field; 3] = [
    |[x, _]| [x, 0.0],
    |[_, y]| [0.0, y],
    |[x, y]| [0.5 * y, 0.5 * x],
];

/// The four independent quadratic fields without body force: 3u,xx + u,yy + 2v,xy = 0 and
/// 3v,yy + v,xx + 2u,xy = 0.
const QUADRATIC: [Field; 4] = [
    |[x, y]| [x * x - 3.0 * y * y, 0.0],
    |[x, y]| [x * x, -3.0 * x * y],
    |[x, y]| [0.0, y * y - 3.0 * x * x],
    |[x, y]| [-3.0 * x * y, y * y],
];

/// The paper's points with trusses; isotropised ones with the couplings that are exact.
fn island(kind: CellKind, coupling: Coupling) -> Result<Model, VerificationError> {
    island_of(material(1.0), kind, coupling)
}

fn island_of(
    material: Material,
    kind: CellKind,
    coupling: Coupling,
) -> Result<Model, VerificationError> {
    let grid = Grid {
        size: [28.0 * DX, 24.0 * DX],
        count: [7, 6],
        kind,
    };
    let mut mesh = grid.plain();
    let within =
        |[x, y]: [f64; 2]| (8.0 * DX..20.0 * DX).contains(&x) && (8.0 * DX..16.0 * DX).contains(&y);
    name_cells(&mut mesh, "island", within);
    name_cells(&mut mesh, "around", |x| !within(x));
    let settings = match coupling {
        Coupling::Truss(_) => paper_lattice(DX),
        _ => default_lattice(DX),
    };
    let points = Method::Peridynamics(settings);
    let regions = vec![
        region(&mesh, &["around"], material, Method::FiniteElements),
        region(&mesh, &["island"], material, points),
    ];
    build(mesh, regions, coupling)
}

/// The largest max|u − u_exact| / max|u_exact| of the fields.
fn error(model: &Model, fields: &[Field]) -> Result<f64, VerificationError> {
    let mut largest = 0.0f64;
    for field in fields {
        let solution = solve(model, &hold_outline(model, field))?;
        largest = largest.max(relative_error(model, &solution.displacement, field));
    }
    Ok(largest)
}

const EXACT: Reference = Reference::Zero { within: 1e-12 };

pub fn measure_linear() -> Result<Vec<Check>, VerificationError> {
    let (q4, q8) = (CellKind::Quad4, CellKind::Quad8);
    let known = |low, high| Reference::Between { low, high };
    let study = "independent study: no weight is exact";
    let mut checks = Vec::new();
    for (kind, coupling, quantity, reference, source) in [
        (q4, TRUSS, "error, truss, Q4", known(0.02, 0.11), study),
        (q8, TRUSS, "error, truss, Q8", known(0.012, 0.061), study),
        (q4, Coupling::Clip, "error, clip, Q4", EXACT, "exact"),
        (q8, Coupling::Clip, "error, clip, Q8", EXACT, "exact"),
    ] {
        checks.push(Check {
            case: "linear patch",
            quantity,
            reference,
            source,
            measured: error(&island(kind, coupling)?, &UNIT_STRAINS)?,
        });
    }
    for (poisson, quantity) in [
        (0.2, "error, clip, Q8, ν = 0.2"),
        (0.4, "error, clip, Q8, ν = 0.4"),
    ] {
        let young = 1.0;
        let material = Material { young, poisson };
        checks.push(Check {
            case: "linear patch",
            quantity,
            reference: EXACT,
            source: "exact",
            measured: error(&island_of(material, q8, Coupling::Clip)?, &UNIT_STRAINS)?,
        });
    }
    Ok(checks)
}

pub fn measure_quadratic() -> Result<Vec<Check>, VerificationError> {
    let q8 = CellKind::Quad8;
    let clip = Reference::Between {
        low: 1e-4,
        high: 1e-2,
    };
    Ok(vec![Check {
        case: "quadratic patch",
        quantity: "error, clip, Q8",
        reference: clip,
        source: "independent study: linear only",
        measured: error(&island(q8, Coupling::Clip)?, &QUADRATIC)?,
    }])
}

/// |Σ F| over Σ |F| of the forces that hold a strongly varying field.
fn imbalance(model: &Model) -> Result<f64, VerificationError> {
    let wave = |[x, y]: [f64; 2]| {
        let (x, y) = (x / DX, y / DX);
        [(0.4 * x - 0.3 * y).sin(), (0.2 * x).cos() * (0.5 * y).sin()]
    };
    let solution = solve(model, &hold_outline(model, wave))?;
    let (mut sum, mut size) = ([0.0; 2], 0.0);
    for force in &solution.reaction {
        (0..2).for_each(|axis| sum[axis] += force[axis]);
        size += force[0].hypot(force[1]);
    }
    Ok(sum[0].hypot(sum[1]) / size)
}

pub fn measure_balance() -> Result<Vec<Check>, VerificationError> {
    let exact = Reference::Zero { within: 1e-13 };
    let mut checks = Vec::new();
    for (coupling, quantity, reference, source) in [
        (TRUSS, "|ΣF|/Σ|F|, truss, Q8", exact, "exact"),
        (Coupling::Clip, "|ΣF|/Σ|F|, clip, Q8", exact, "exact"),
    ] {
        checks.push(Check {
            case: "overall equilibrium",
            quantity,
            reference,
            source,
            measured: imbalance(&island(CellKind::Quad8, coupling)?)?,
        });
    }
    Ok(checks)
}
