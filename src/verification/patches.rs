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

use super::bodies::{build, hold_outline, material, paper_lattice, region, relative_error, solve};
use super::{Check, Reference, VerificationError};
use crate::mesh::CellKind;
use crate::mesh::grid::{Grid, name_cells};
use crate::model::{Method, Model, PeridynamicSettings};

const DX: f64 = 2.5e-3;

/// A displacement field u(x) [m].
type Field = fn([f64; 2]) -> [f64; 2];

const UNIT_STRAINS: [Field; 3] = [
    |[x, _]| [x, 0.0],
    |[_, y]| [0.0, y],
    |[x, y]| [0.5 * y, 0.5 * x],
];

fn island(kind: CellKind, settings: PeridynamicSettings) -> Result<Model, VerificationError> {
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
    let points = Method::Peridynamics(settings);
    let regions = vec![
        region(&mesh, &["around"], material(1.0), Method::FiniteElements),
        region(&mesh, &["island"], material(1.0), points),
    ];
    build(mesh, regions, 1.0)
}

/// The largest max|u − u_exact| / max|u_exact| of the three uniform strains.
fn linear_error(model: &Model) -> Result<f64, VerificationError> {
    let mut largest = 0.0f64;
    for field in UNIT_STRAINS {
        let solution = solve(model, &hold_outline(model, field))?;
        largest = largest.max(relative_error(model, &solution.displacement, field));
    }
    Ok(largest)
}

pub fn measure_linear() -> Result<Vec<Check>, VerificationError> {
    let mut checks = Vec::new();
    for (kind, quantity, reference) in [
        (CellKind::Quad4, "error, truss, Q4", [0.02, 0.11]),
        (CellKind::Quad8, "error, truss, Q8", [0.012, 0.061]),
    ] {
        let [low, high] = reference;
        checks.push(Check {
            case: "linear patch",
            quantity,
            reference: Reference::Between { low, high },
            source: "independent program; no weight of trusses is exact",
            measured: linear_error(&island(kind, paper_lattice(DX))?)?,
        });
    }
    Ok(checks)
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
    Ok(vec![Check {
        case: "overall equilibrium",
        quantity: "|ΣF|/Σ|F|, truss, Q8",
        reference: Reference::Zero { within: 1e-13 },
        source: "exact",
        measured: imbalance(&island(CellKind::Quad8, paper_lattice(DX))?)?,
    }])
}
