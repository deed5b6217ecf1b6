//! What the clip coupling leaves of a uniform strain: islands of material points within finite elements,
//! displacements of a linear field prescribed around the outside.

mod common;

use common::*;
use nalgebra::DMatrix;
use peristitch::assembly::Pattern;
use peristitch::coupling::Coupling;
use peristitch::material::PlaneState;
use peristitch::mesh::{Cell, CellKind, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::phases::Phases;
use peristitch::statics;
use std::collections::HashMap;

const DX: f64 = 1.0;
const KINDS: [CellKind; 4] = CellKind::ALL;

/// How the lattice lies: angle [degrees], origin [dx].
type Position = (f64, [f64; 2]);
const ALIGNED: Position = (0.0, [0.0, 0.0]);
const SHIFTED: Position = (0.0, [0.3, 0.2]);
const ROTATED: Position = (20.0, [0.3, 0.2]);

fn settings((angle, origin): Position, m: f64) -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings {
            angle: angle.to_radians(),
            origin: Some(origin.map(|x| x * DX)),
            ..LatticeSettings::upright(DX, Placement::CellCentred, CellArea::Clipped)
        },
        horizon_ratio: m,
        isotropised: true,
        ..paper_lattice(DX, Placement::CellCentred)
    }
}

/// Cells named `island` become points, the rest finite elements.
fn model(mut mesh: Mesh, lattice: PeridynamicSettings, plane: PlaneState) -> Model {
    let island = mesh.surfaces["island"].clone();
    let others = (0..mesh.cells.len()).filter(|c| !island.contains(c));
    mesh.surfaces.insert("frame".to_owned(), others.collect());
    let material = peristitch::material::Material {
        young: 100e9,
        poisson: plane.bond_based_poisson(),
    };
    let regions = vec![
        region(&mesh, &["frame"], material, Method::FiniteElements),
        region(&mesh, &["island"], material, Method::Peridynamics(lattice)),
    ];
    let settings = ModelSettings {
        plane,
        thickness: 0.7,
        coupling: Coupling::Clip,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// An island of 6 × 4 elements of 2.5 dx, two elements around it.
fn rectangle(kind: CellKind) -> Mesh {
    framed(kind, |_| [0.0, 0.0], |_| true)
}

/// The same less its upper right quarter.
fn angle(kind: CellKind) -> Mesh {
    framed(kind, |_| [0.0, 0.0], |[x, y]| x < 12.5 || y < 10.0)
}

fn framed(
    kind: CellKind,
    shift: impl Fn([f64; 2]) -> [f64; 2],
    inside: impl Fn([f64; 2]) -> bool,
) -> Mesh {
    let grid = Grid {
        size: [25.0 * DX, 20.0 * DX],
        count: [10, 8],
        kind,
    };
    let plain = grid.plain();
    let mut mesh = grid.mesh(shift);
    let cells = (0..plain.cells.len()).filter(|&c| {
        let [x, y] = centre(&plain, c);
        5.0 < x && x < 20.0 && 5.0 < y && y < 15.0 && inside([x, y])
    });
    mesh.surfaces.insert("island".to_owned(), cells.collect());
    mesh
}

/// A polygon of `sides` sides of `edges` edges each, triangles within, two rings of elements around;
/// nodes off the interface are moved, the same for every run.
fn polygon(kind: CellKind, sides: usize, edges: usize, radius: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let around = sides * edges;
    let corner = |k: usize, r: f64| {
        let phi = 0.37 + std::f64::consts::TAU * (k % sides) as f64 / sides as f64;
        [r * phi.cos() + 0.13, r * phi.sin() - 0.21]
    };
    for ring in 0..3 {
        let r = radius * [1.0, 1.3, 1.7][ring];
        for k in 0..around {
            let (a, b) = (corner(k / edges, r), corner(k / edges + 1, r));
            // Edges of a side are of unequal length, and grow the same way in every ring.
            let s = (k % edges) as f64 / edges as f64;
            let s = s + 0.15 * s * (1.0 - s);
            let wave = if ring == 1 { 0.02 * radius } else { 0.0 };
            let moved = [wave * (3.1 * k as f64).sin(), wave * (1.7 * k as f64).cos()];
            mesh.nodes
                .push([0, 1].map(|c| a[c] + s * (b[c] - a[c]) + moved[c]));
        }
    }
    mesh.nodes.push([0.13 + 0.11 * radius, -0.21]);
    let hub = mesh.nodes.len() - 1;
    let mut middles = HashMap::new();
    let mut add = |mesh: &mut Mesh, kind: CellKind, corners: &[usize]| {
        let mut nodes = corners.to_vec();
        if kind.is_quadratic() {
            for i in 0..corners.len() {
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                let middle = *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    let [p, q] = [mesh.nodes[a], mesh.nodes[b]];
                    mesh.nodes.push([0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]);
                    mesh.nodes.len() - 1
                });
                nodes.push(middle);
            }
        }
        mesh.cells.push(Cell::new(kind, &nodes));
    };
    let triangle = if kind.is_quadratic() {
        CellKind::Tri6
    } else {
        CellKind::Tri3
    };
    for k in 0..around {
        add(&mut mesh, triangle, &[hub, k, (k + 1) % around]);
    }
    mesh.surfaces
        .insert("island".to_owned(), (0..around).collect());
    for ring in 0..2 {
        for k in 0..around {
            let inner = [k, (k + 1) % around].map(|k| ring * around + k);
            let outer = inner.map(|n| n + around);
            let quad = [inner[1], inner[0], outer[0], outer[1]];
            match kind {
                CellKind::Quad4 | CellKind::Quad8 => add(&mut mesh, kind, &quad),
                CellKind::Tri3 | CellKind::Tri6 => {
                    add(&mut mesh, kind, &quad[..3]);
                    add(&mut mesh, kind, &[quad[0], quad[2], quad[3]]);
                }
            }
        }
    }
    mesh
}

const LINEAR: [Field; 3] = [
    |[x, y]| [x + 0.3 * y, -0.2 * x],
    |[x, y]| [0.1 * y, y - 0.4 * x],
    |[x, y]| [0.5 * y, 0.5 * x],
];

/// The largest error of three linear fields.
fn error(model: &Model) -> f64 {
    let errors = LINEAR.iter().map(|field| {
        let boundary = hold_outline(model, field);
        let u = displacements(model, &boundary);
        relative_error(model, &u, field)
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn explore() {
    for (name, mesh) in [
        ("rectangle", rectangle as fn(CellKind) -> Mesh),
        ("angle", angle),
    ] {
        for kind in KINDS {
            for position in [ALIGNED, SHIFTED, ROTATED] {
                let model = model(mesh(kind), settings(position, 4.0), PlaneState::Stress);
                let pairs = model.springs.pairs().len();
                println!(
                    "{name} {kind:?} {position:?} {:.1e} points {} bonds {} clipped {}",
                    error(&model),
                    model.areas.len(),
                    pairs,
                    model.springs.len() - pairs
                );
            }
        }
    }
    for sides in [6, 9, 24] {
        for kind in KINDS {
            let mesh = polygon(kind, sides, 24_usize.div_ceil(sides), 9.0);
            let model = model(mesh, settings(ROTATED, 4.0), PlaneState::Stress);
            println!("{sides} {kind:?} {:.1e}", error(&model));
        }
    }
}
