//! Table 1 of Qian et al. (2021): the 1000 × 200 mm bar under 1.05 MPa, E = 100 GPa, ν = 1/3,
//! dx = 2.5 mm, m = 4, elements of 10 mm, clamped on the left; u_x at mid-height of the right edge.

use super::bodies::{TRUSS, build, material, nearest, paper_lattice, region, solve};
use super::{Check, Reference, VerificationError};
use crate::boundary::Boundary;
use crate::fem::edge::EdgeLoad;
use crate::mesh::grid::{Grid, name_cells, name_curve};
use crate::mesh::{CellKind, Mesh};
use crate::model::{Method, PeridynamicSettings, Region};
use crate::peridynamics::lattice::{LatticeSettings, Placement};

const YOUNG: f64 = 100e9;

/// The support of the left end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    Clamp,
    Rollers,
}

/// The method of the bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bar {
    FiniteElements,
    Peridynamics,
    /// Peridynamic from 0.4 m to 0.6 m.
    Hybrid,
}

fn mesh(kind: CellKind) -> Mesh {
    let grid = Grid {
        size: [1.0, 0.2],
        count: [100, 20],
        kind,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "left", |x| x[0] < 0.4);
    name_cells(&mut mesh, "band", |x| x[0] > 0.4 && x[0] < 0.6);
    name_cells(&mut mesh, "right", |x| x[0] > 0.6);
    name_curve(&mut mesh, "end", |x| x[0] < 1e-9);
    name_curve(&mut mesh, "load", |x| x[0] > 1.0 - 1e-9);
    // The grid's first node.
    mesh.points.insert("corner".into(), vec![0]);
    mesh
}

fn regions(mesh: &Mesh, bar: Bar) -> Vec<Region> {
    let paper = paper_lattice(2.5e-3);
    let points = Method::Peridynamics(PeridynamicSettings {
        lattice: LatticeSettings {
            placement: Placement::GridNodes,
            ..paper.lattice
        },
        ..paper
    });
    let all = ["left", "band", "right"];
    let of = |groups: &[&str], method| region(mesh, groups, material(YOUNG), method);
    match bar {
        Bar::FiniteElements => vec![of(&all, Method::FiniteElements)],
        Bar::Peridynamics => vec![of(&all, points)],
        Bar::Hybrid => vec![
            of(&["left", "right"], Method::FiniteElements),
            of(&["band"], points),
        ],
    }
}

/// u_x at mid-height of the right edge [m].
///
/// # Errors
/// Errors of building and solving.
pub fn tip(bar: Bar, kind: CellKind, support: Support) -> Result<f64, VerificationError> {
    let mesh = mesh(kind);
    let regions = regions(&mesh, bar);
    let model = build(mesh, regions, TRUSS)?;
    let mut boundary = Boundary::new(&model);
    match support {
        Support::Clamp => boundary.displace(&model, "end", [Some(0.0); 2])?,
        Support::Rollers => {
            boundary.displace(&model, "end", [Some(0.0), None])?;
            boundary.displace(&model, "corner", [None, Some(0.0)])?;
        }
    }
    boundary.add_traction(&model, "load", EdgeLoad::Traction([1.05e6, 0.0]))?;
    let solution = solve(&model, &boundary)?;
    Ok(solution.displacement[nearest(&model.positions, [1.0, 0.1])][0])
}

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    // The paper prints four digits.
    let paper = |quantity, value: f64, measured| Check {
        case: "Table 1",
        quantity,
        reference: Reference::Value {
            value,
            within: 5e-4,
        },
        source: "Qian et al. (2021)",
        measured,
    };
    let (q4, q8) = (CellKind::Quad4, CellKind::Quad8);
    let clamped = |bar, kind| tip(bar, kind, Support::Clamp);
    Ok(vec![
        paper("u [m], PD", 1.027e-5, clamped(Bar::Peridynamics, q8)?),
        paper("u [m], hybrid, Q4", 1.043e-5, clamped(Bar::Hybrid, q4)?),
        paper("u [m], hybrid, Q8", 1.047e-5, clamped(Bar::Hybrid, q8)?),
        Check {
            case: "Table 1",
            quantity: "u [m], Q8 on rollers",
            reference: Reference::Value {
                value: 1.05e-5,
                within: 1e-9,
            },
            source: "σL/E",
            measured: tip(Bar::FiniteElements, q8, Support::Rollers)?,
        },
    ])
}
