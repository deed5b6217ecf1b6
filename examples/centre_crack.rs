//! The plate with a centre crack, by peridynamics alone and by the hybrid, as the horizon shrinks:
//!
//! ```text
//! cargo run --release --example centre_crack                          # δ/a = 0.4 and 0.2
//! cargo run --release --example centre_crack -- 0.4 0.2 0.1   # 400² points: some minutes, 3 GB
//! ```
//!
//! 50 × 50 mm, 2a = 10 mm, E = 30 GPa, ν = 1/3, plane stress; the ends move apart by u, free sideways.
//! Per metre of thickness, from finite elements and the geometry factor of the literature: stiffness
//! k = F/u = 2.8213e10 N/m, G/u² = 1.7210e11 J/m⁴ for each tip, K_I = Y σ̄ √(πa) with Y = 1.016 and
//! σ̄ = F/W. At a fixed opening
//!
//! G = −½ u² dk/d(2a),
//!
//! here by central difference: both tips are moved by one spacing, outwards and inwards. A crack lies
//! between two rows of points and ends between two columns; its length is that of the curve, since the
//! bonds that cross it have the energy of just that length (10.008 mm for 10 mm, by `crack_length_m`).

use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::cracks::Cracks;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::{Cell, CellKind, Edge, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings, Region};
use peristitch::peridynamics::kernel::{Kernel, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::phases::Phases;
use peristitch::statics;
use std::collections::HashMap;
use std::error::Error;
use std::f64::consts::PI;

/// W = H and a [m], E [Pa].
const SIDE: f64 = 0.05;
const CRACK: f64 = 0.005;
const YOUNG: f64 = 30e9;
/// Height of the hybrid's band [m], that of `pipelines/plate_mode_i.yaml`.
const BAND: f64 = 0.018;

/// F/u, and G/u² of each tip, per thickness [N/m², J/m⁵ m].
pub const STIFFNESS: f64 = 2.8213e10;
pub const RATE: f64 = 1.7210e11;
pub const FACTOR: f64 = 1.016;

/// What stands for the plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plate {
    Peridynamics,
    /// Q8 elements above and below a band of material points, tied by trusses.
    Hybrid,
}

/// Figures over their references.
#[derive(Clone, Copy, Debug)]
pub struct Ratios {
    pub stiffness: f64,
    pub rate: f64,
    pub factor: f64,
}

/// The plate with δ = `horizon` · a and δ = `ratio` · dx.
pub fn ratios(plate: Plate, horizon: f64, ratio: f64) -> Result<Ratios, Box<dyn Error>> {
    let spacing = horizon * CRACK / ratio;
    let [short, middle, long] = [-1.0, 0.0, 1.0]
        .map(|columns| stiffness(plate, [spacing, ratio], CRACK + columns * spacing));
    let middle = middle?;
    let rate = -0.5 * (long? - short?) / (4.0 * spacing);
    // K = √(E G) over the mean stress k u / W.
    let factor = (YOUNG * rate).sqrt() / (middle / SIDE * (PI * CRACK).sqrt());
    Ok(Ratios {
        stiffness: middle / STIFFNESS,
        rate: rate / RATE,
        factor: factor / FACTOR,
    })
}

/// F/u with a crack of half-length `a`.
fn stiffness(plate: Plate, [spacing, ratio]: [f64; 2], a: f64) -> Result<f64, Box<dyn Error>> {
    let mesh = mesh(plate, ratio * spacing, a);
    let crack = Cracks::new(&mesh, &mesh.curves["crack"]);
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling: Coupling::Truss(NodeArea::Lumped),
    };
    let regions = regions(plate, &mesh, [spacing, ratio]);
    let model = Model::build(mesh, regions, settings)?.with_cracks(&crack);
    let mut boundary = Boundary::new(&model);
    boundary.displace(&model, "bottom", [None, Some(-0.5)])?;
    boundary.displace(&model, "top", [None, Some(0.5)])?;
    // One node holds the plate sideways, without force.
    let corner = boundary.prescribed.keys().next().ok_or("nothing is held")? / 2;
    boundary
        .prescribed
        .insert(2 * corner, (0.0, "corner".to_owned()));
    let solution = statics::solve(&model, &boundary, &mut Phases::default())?;
    // The work of the supports at u = 1 m is F u.
    let supports = boundary.prescribed.iter();
    let work = supports.map(|(dof, (value, _))| value * solution.reaction[dof / 2][dof % 2]);
    Ok(work.sum())
}

fn regions(plate: Plate, mesh: &Mesh, [spacing, horizon_ratio]: [f64; 2]) -> Vec<Region> {
    let material = Material {
        young: YOUNG,
        poisson: PlaneState::Stress.bond_based_poisson(),
    };
    let points = Method::Peridynamics(PeridynamicSettings {
        lattice: LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Full),
        horizon_ratio,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: false,
        surface_correction: SurfaceCorrection::None,
    });
    let region = |name: &str, method| Region {
        name: name.to_owned(),
        cells: mesh.surfaces[name].clone(),
        material,
        method,
    };
    let mut regions = vec![region("band", points)];
    if plate == Plate::Hybrid {
        regions.push(region("grips", Method::FiniteElements));
    }
    regions
}

/// Squares of Q8 elements with the side δ, as in that pipeline; the curves `bottom`, `top` and `crack`, the surfaces `band` and `grips`.
fn mesh(plate: Plate, horizon: f64, a: f64) -> Mesh {
    let count = (SIDE / horizon).round() as usize;
    let h = SIDE / count as f64;
    let mut mesh = Mesh::default();
    let mut nodes: HashMap<[usize; 2], usize> = HashMap::new();
    // Half steps: corners at even, mid-sides at odd places.
    let mut node = |mesh: &mut Mesh, place: [usize; 2]| {
        *nodes.entry(place).or_insert_with(|| {
            mesh.nodes.push(place.map(|k| 0.5 * h * k as f64));
            mesh.nodes.len() - 1
        })
    };
    const PLACES: [[usize; 2]; 8] = [
        [0, 0],
        [2, 0],
        [2, 2],
        [0, 2],
        [1, 0],
        [2, 1],
        [1, 2],
        [0, 1],
    ];
    let [mut band, mut grips] = [Vec::new(), Vec::new()];
    for row in 0..count {
        for column in 0..count {
            let ends = PLACES.map(|[i, j]| node(&mut mesh, [2 * column + i, 2 * row + j]));
            let off = ((row as f64 + 0.5) * h - 0.5 * SIDE).abs();
            let is_band = plate == Plate::Peridynamics || off < 0.5 * BAND;
            let list = if is_band { &mut band } else { &mut grips };
            list.push(mesh.cells.len());
            mesh.cells.push(Cell::new(CellKind::Quad8, &ends));
        }
    }
    let sides = |side: usize, row: usize| {
        let cells = &mesh.cells[row * count..(row + 1) * count];
        let edges = cells.iter().filter_map(|cell| cell.edges().nth(side));
        edges.collect::<Vec<Edge>>()
    };
    let (bottom, top) = (sides(0, 0), sides(2, count - 1));
    let tips = [-a, a].map(|x| {
        mesh.nodes.push([0.5 * SIDE + x, 0.5 * SIDE]);
        mesh.nodes.len() - 1
    });
    let crack = vec![Edge {
        ends: tips,
        middle: None,
    }];
    mesh.curves = [("bottom", bottom), ("top", top), ("crack", crack)]
        .map(|(name, edges)| (name.to_owned(), edges))
        .into();
    mesh.surfaces = [("band", band), ("grips", grips)]
        .map(|(name, cells)| (name.to_owned(), cells))
        .into();
    mesh
}

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let ratio = match given.first().and_then(|a| a.strip_prefix("m=")) {
        Some(ratio) => ratio.parse()?,
        None => 4.0,
    };
    let mut horizons: Vec<f64> = given.iter().filter_map(|a| a.parse().ok()).collect();
    if horizons.is_empty() {
        horizons = vec![0.4, 0.2];
    }
    for plate in [Plate::Peridynamics, Plate::Hybrid] {
        println!("| {plate:?}, δ = {ratio} dx, δ/a | k | G | Y |\n| --- | --- | --- | --- |");
        for &horizon in &horizons {
            let Ratios {
                stiffness,
                rate,
                factor,
            } = ratios(plate, horizon, ratio)?;
            println!("| {horizon} | {stiffness:.4} | {rate:.4} | {factor:.4} |");
        }
        println!();
    }
    Ok(())
}
