//! The splice passes the patch test: an island of material points within finite elements, displacements of
//! exact fields prescribed around the outside.
//!
//! ```text
//!   ┌───────────────┐
//!   │   elements    │  δ = 4 dx or more on every side, h = dx … 4 dx, Q8, Q4, T6, T3
//!   │   ┌·······┐   │
//!   │   · island ·  │  a rectangle, or an L with a re-entrant corner
//!   │   └·······┘   │
//!   └───────────────┘
//! ```
//!
//! max|u − u_exact| / max|u_exact| over all dofs. Linear fields, any kernel and any position of the lattice;
//! quadratic fields without body force, 3u,xx + u,yy + 2v,xy = 0 and 3v,yy + v,xx + 2u,xy = 0, with Q8 and
//! the isotropised micromodulus, whose lattice has exactly the elements' moduli.

mod common;

use common::*;


use peristitch::coupling::Coupling;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::Placement;

const DX: f64 = 2.5e-3;

/// Strains and a rotation.
const LINEAR: [Field; 4] = [
    |[x, _]| [x, 0.0],
    |[_, y]| [0.0, y],
    |[x, y]| [0.5 * y, 0.5 * x],
    |[x, y]| [-y, x],
];

/// The four independent ones: u = a x² + b xy + c y², v = d x² + e xy + f y² with 6a + 2c + 2e = 0 and
/// 6f + 2d + 2b = 0.
const QUADRATIC: [Field; 4] = [
    |[x, y]| [x * x - 3.0 * y * y, 0.0],
    |[x, y]| [x * x, -3.0 * x * y],
    |[x, y]| [0.0, y * y - 3.0 * x * x],
    |[x, y]| [-3.0 * x * y, y * y],
];

fn splice(mesh: peristitch::mesh::Mesh, lattice: PeridynamicSettings, plane: PlaneState) -> Model {
    let mut material = steel();
    material.poisson = plane.bond_based_poisson();
    let regions = vec![
        region(&mesh, &["around"], material, Method::FiniteElements),
        region(&mesh, &["island"], material, Method::Peridynamics(lattice)),
    ];
    let settings = ModelSettings {
        plane,
        thickness: 0.7,
        coupling: Coupling::Splice,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

fn isotropised(placement: Placement) -> PeridynamicSettings {
    PeridynamicSettings {
        isotropised: true,
        ..paper_lattice(DX, placement)
    }
}

/// A mesh of `count` cells of `h` spacings each, of which `inside` (in cells) are the island.
fn island(
    kind: CellKind,
    h: f64,
    count: [usize; 2],
    inside: impl Fn([f64; 2]) -> bool,
) -> peristitch::mesh::Mesh {
    let grid = Grid {
        size: count.map(|n| n as f64 * h * DX),
        count,
        kind,
    };
    let mut mesh = grid.plain();
    let in_cells = |x: [f64; 2]| x.map(|x| x / (h * DX));
    name_cells(&mut mesh, "island", |x| inside(in_cells(x)));
    name_cells(&mut mesh, "around", |x| !inside(in_cells(x)));
    mesh
}

fn worst(model: &Model, fields: &[Field]) -> f64 {
    let errors = fields.iter().map(|&field| {
        let u = displacements(model, &hold_outline(model, field));
        relative_error(model, &u, field)
    });
    errors.fold(0.0, f64::max)
}

/// Cells around the island: δ or more of elements.
fn ring(h: f64) -> usize {
    (4.0 / h).ceil() as usize
}

/// An island of `cells` cells, of which the upper right quadrant is taken away for an L.
fn model(kind: CellKind, h: f64, cells: usize, l: bool, lattice: PeridynamicSettings) -> Model {
    let ring = ring(h);
    let (low, high) = (ring as f64, (ring + cells) as f64);
    let middle = low + (cells / 2 + cells % 2) as f64;
    let inside = |[x, y]: [f64; 2]| {
        let within = low < x && x < high && low < y && y < high;
        within && !(l && x > middle && y > middle)
    };
    let mesh = island(kind, h, [2 * ring + cells; 2], inside);
    splice(mesh, lattice, PlaneState::Stress)
}

#[test]
fn linear_fields_in_rectangles_and_l_shapes_of_every_element() {
    for kind in CellKind::ALL {
        for (h, cells) in [(1.0, 12), (2.0, 8), (2.5, 6), (3.0, 5), (4.0, 5)] {
            for l in [false, true] {
                for placement in [Placement::CellCentred, Placement::GridNodes] {
                    let model = model(kind, h, cells, l, paper_lattice(DX, placement));
                    let error = worst(&model, &LINEAR);
                    println!("{kind:?} h = {h} dx, L {l}, {placement:?}: {error:.1e}");
                    assert!(error <= 1e-12, "{kind:?} h = {h} L {l} {placement:?}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn quadratic_fields_with_the_isotropised_micromodulus_alone() {
    for (h, cells) in [(1.0, 12), (2.0, 8), (2.5, 6), (4.0, 5)] {
        for l in [false, true] {
            for placement in [Placement::CellCentred, Placement::GridNodes] {
                let model = model(CellKind::Quad8, h, cells, l, isotropised(placement));
                let error = worst(&model, &QUADRATIC);
                println!("h = {h} dx, L {l}, {placement:?}: {error:.1e}");
                assert!(error <= 1e-12, "h = {h} L {l} {placement:?}: {error:e}");
            }
        }
    }
    let raw = paper_lattice(DX, Placement::CellCentred);
    let error = worst(&model(CellKind::Quad8, 2.0, 8, false, raw), &QUADRATIC);
    println!("raw: {error:.2e}");
    assert_between(error, 1e-3, 1e-2, "the raw micromodulus");
}
