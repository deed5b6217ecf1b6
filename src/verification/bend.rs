//! The single-edge notched beam in three-point bending, span S = 4W, crack a = W/2.
//!
//! K_I B W^1.5/(P S) = 2.65 (2.64–2.66 in the literature: Srawley 1976; ASTM E399). Here K_I = √(E G)
//! with G = −½ dΠ/da: at a given load, G = ½ P² dC/da / B, the compliance C by a central difference over
//! crack lengths one spacing longer and shorter.

use super::bodies::{build, default_lattice, material, region, solve};
use super::{Check, Reference, VerificationError};
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::cracks::Cracks;
use crate::mesh::grid::{Grid, name_cells};
use crate::mesh::{CellKind, Edge, Mesh};
use crate::model::Method;

/// W, E, B and P are 1; the beam reaches W/4 beyond its supports.
const SPAN: f64 = 4.0;
const OVERHANG: f64 = 0.25;
/// Half-width of the band of material points in the middle.
const BAND: f64 = 0.5;

/// Half of the beam's length.
const HALF: f64 = 0.5 * SPAN + OVERHANG;
/// Elements per W.
const PER_WIDTH: usize = 16;

fn mesh(a: f64) -> Mesh {
    let grid = Grid {
        size: [2.0 * HALF, 1.0],
        count: [(2.0 * HALF * PER_WIDTH as f64).round() as usize, PER_WIDTH],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "band", |[x, _]| (x - HALF).abs() < BAND);
    name_cells(&mut mesh, "arms", |[x, _]| (x - HALF).abs() > BAND);
    let first = mesh.nodes.len();
    mesh.nodes.extend([[HALF, 0.0], [HALF, a]]);
    let crack = Edge {
        ends: [first, first + 1],
        middle: None,
    };
    mesh.curves.insert("crack".to_owned(), vec![crack]);
    mesh
}

/// Deflection under the unit load with the crack length `a`, relative to the supports.
fn compliance(a: f64, dx: f64) -> Result<f64, VerificationError> {
    let mesh = mesh(a);
    let cracks = Cracks::new(&mesh, &mesh.curves["crack"]);
    let points = Method::Peridynamics(default_lattice(dx));
    let regions = vec![
        region(&mesh, &["arms"], material(1.0), Method::FiniteElements),
        region(&mesh, &["band"], material(1.0), points),
    ];
    let model = build(mesh, regions, Coupling::Clip)?.with_cracks(&cracks);
    let mut boundary = Boundary::new(&model);
    let node = |at: [f64; 2]| super::bodies::nearest(&model.positions, at);
    let supports = [-1.0, 1.0].map(|side| node([HALF + side * 0.5 * SPAN, 0.0]));
    for dof in [2 * supports[0], 2 * supports[0] + 1, 2 * supports[1] + 1] {
        boundary.prescribed.insert(dof, (0.0, "support".to_owned()));
    }
    // The two points of the uppermost row beside the middle.
    let loaded = [-0.5, 0.5].map(|step| node([HALF + step * dx, 1.0]));
    for node in loaded {
        boundary.load[2 * node + 1] -= 0.5;
    }
    let solution = solve(&model, &boundary)?;
    let deflection = loaded.map(|node| -0.5 * solution.displacement[node][1]);
    Ok(deflection.iter().sum())
}

/// K_I B W^1.5/(P S) with dx = W/`per_width`, an even number.
///
/// # Errors
/// Errors of building and solving.
pub fn factor(per_width: usize) -> Result<f64, VerificationError> {
    let dx = 1.0 / per_width as f64;
    let rate = 0.5 * (compliance(0.5 + dx, dx)? - compliance(0.5 - dx, dx)?) / (2.0 * dx);
    Ok(rate.sqrt() / SPAN)
}

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let (coarse, fine) = (factor(80)?, factor(160)?);
    let check = |quantity, reference, measured| Check {
        case: "single-edge bend",
        quantity,
        reference,
        source: "2.64–2.66, Srawley (1976)",
        measured,
    };
    let near = |within| Reference::Value {
        value: 2.65,
        within,
    };
    let literature = Reference::Between {
        low: 2.64,
        high: 2.66,
    };
    // The error is linear in δ.
    let limit = 2.0 * fine - coarse;
    Ok(vec![
        check("K_I B W^1.5/(P S), δ/a = 0.1", near(0.015), coarse),
        check("K_I B W^1.5/(P S), δ/a = 0.05", near(0.008), fine),
        check("the same, δ → 0 (straight line)", literature, limit),
    ])
}
