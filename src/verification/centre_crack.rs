//! The plate with a centre crack: stiffness, energy release rate and geometry factor.
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

use super::VerificationError;
use super::bodies::{TRUSS, build, default_lattice, material, paper_lattice, region, solve};
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::cracks::Cracks;
use crate::mesh::{Cell, CellKind, Edge, Mesh};
use crate::model::{Method, PeridynamicSettings, Region};
use std::collections::HashMap;
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

/// The methods by which the plate is modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plate {
    Peridynamics,
    /// Q8 elements above and below a band of material points.
    Hybrid,
}

/// The settings of its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// The paper's: raw micromodulus, no surface correction, trusses.
    Paper,
    /// The defaults of pipelines: isotropised, surfaces corrected by force; the hybrid by clipped bonds.
    Corrected,
}

/// Figures over their references.
#[derive(Clone, Copy, Debug)]
pub struct Ratios {
    pub stiffness: f64,
    pub rate: f64,
    pub factor: f64,
}

/// The plate with δ = `horizon` · a and δ = `ratio` · dx.
///
/// # Errors
/// Errors of building and solving.
pub fn ratios(
    plate: Plate,
    points: Points,
    horizon: f64,
    ratio: f64,
) -> Result<Ratios, VerificationError> {
    let spacing = horizon * CRACK / ratio;
    let (lattice, coupling) = match points {
        Points::Paper => (paper_lattice(spacing), TRUSS),
        Points::Corrected => (default_lattice(spacing), Coupling::Clip),
    };
    let settings = PeridynamicSettings {
        horizon_ratio: ratio,
        ..lattice
    };
    let stiffness = |columns: f64| {
        let a = CRACK + columns * spacing;
        stiffness(plate, settings, coupling, a)
    };
    let middle = stiffness(0.0)?;
    let rate = -0.5 * (stiffness(1.0)? - stiffness(-1.0)?) / (4.0 * spacing);
    // K = √(E G) over the mean stress k u / W.
    let factor = (YOUNG * rate).sqrt() / (middle / SIDE * (PI * CRACK).sqrt());
    Ok(Ratios {
        stiffness: middle / STIFFNESS,
        rate: rate / RATE,
        factor: factor / FACTOR,
    })
}

/// F/u with a crack of half-length `a`.
fn stiffness(
    plate: Plate,
    settings: PeridynamicSettings,
    coupling: Coupling,
    a: f64,
) -> Result<f64, VerificationError> {
    let mesh = mesh(plate, settings.horizon_ratio * settings.lattice.spacing, a);
    let crack = Cracks::new(&mesh, &mesh.curves["crack"]);
    let regions = regions(plate, &mesh, settings);
    let model = build(mesh, regions, coupling)?.with_cracks(&crack);
    let mut boundary = Boundary::new(&model);
    boundary.displace(&model, "bottom", [None, Some(-0.5)])?;
    boundary.displace(&model, "top", [None, Some(0.5)])?;
    // One node holds the plate sideways, without force.
    let first = boundary.prescribed.keys().next();
    let corner = first.expect("the ends are held") / 2;
    boundary
        .prescribed
        .insert(2 * corner, (0.0, "corner".to_owned()));
    let solution = solve(&model, &boundary)?;
    // The work of the supports at u = 1 m is F u.
    let supports = boundary.prescribed.iter();
    let work = supports.map(|(dof, (value, _))| value * solution.reaction[dof / 2][dof % 2]);
    Ok(work.sum())
}

fn regions(plate: Plate, mesh: &Mesh, settings: PeridynamicSettings) -> Vec<Region> {
    let (rock, points) = (material(YOUNG), Method::Peridynamics(settings));
    let mut regions = vec![region(mesh, &["band"], rock, points)];
    if plate == Plate::Hybrid {
        regions.push(region(mesh, &["grips"], rock, Method::FiniteElements));
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
