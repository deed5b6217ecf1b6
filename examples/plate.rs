//! A plate in a few lines of Rust, without a file: a bar of 1000 × 200 mm, finite elements on both sides of a
//! band of material points, held on the left and pulled on the right.
//!
//! ```text
//! cargo run --release --example plate
//! ```

use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::fem::edge::EdgeLoad;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::CellKind;
use peristitch::mesh::grid::{Grid, name_cells, name_curve};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings, Region};
use peristitch::peridynamics::kernel::{Kernel, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics;
use std::error::Error;

const YOUNG: f64 = 100e9;
const TRACTION: f64 = 1.05e6;

/// u_x of the right end [m], and what σL/E makes it.
pub fn elongation() -> Result<[f64; 2], Box<dyn Error>> {
    // The mesh, and the names of its parts. A mesher's, or a loop of one's own, does as well.
    let grid = Grid {
        size: [1.0, 0.2],
        count: [20, 4],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "sides", |[x, _]| !(0.4..0.6).contains(&x));
    name_cells(&mut mesh, "band", |[x, _]| (0.4..0.6).contains(&x));
    name_curve(&mut mesh, "left", |[x, _]| x < 1e-9);
    name_curve(&mut mesh, "right", |[x, _]| x > 1.0 - 1e-9);

    // What each part is.
    let material = Material {
        young: YOUNG,
        poisson: PlaneState::Stress.bond_based_poisson(),
    };
    let lattice = PeridynamicSettings {
        lattice: LatticeSettings::upright(0.005, Placement::CellCentred, CellArea::Clipped),
        horizon_ratio: 4.0,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
    };
    let region = |name: &str, method: Method| Region {
        name: name.to_owned(),
        cells: mesh.surfaces[name].clone(),
        material,
        method,
    };
    let regions = vec![
        region("sides", Method::FiniteElements),
        region("band", Method::Peridynamics(lattice)),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling: Coupling::Clip,
    };
    let model = Model::build(mesh, regions, settings)?;

    // Supports and loads; the solve; the answer.
    let mut boundary = Boundary::new(&model);
    boundary.displace(&model, "left", [Some(0.0), None])?;
    let corner = nearest(&model, [0.0, 0.0]);
    boundary
        .prescribed
        .insert(2 * corner + 1, (0.0, "corner".to_owned()));
    boundary.add_traction(&model, "right", EdgeLoad::Traction([TRACTION, 0.0]))?;
    let solution = statics::solve(&model, &boundary)?;
    let tip = nearest(&model, [1.0, 0.1]);
    Ok([solution.displacement[tip][0], TRACTION * 1.0 / YOUNG])
}

fn nearest(model: &Model, [x, y]: [f64; 2]) -> usize {
    let distance = |node: &usize| {
        let [a, b] = model.positions[*node];
        (a - x).hypot(b - y)
    };
    let nodes = 0..model.positions.len();
    let nearest = nodes.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.expect("a model has nodes")
}

fn main() -> Result<(), Box<dyn Error>> {
    let [elongation, exact] = elongation()?;
    println!("elongation {elongation:.4e} m, σL/E = {exact:.4e} m");
    Ok(())
}
