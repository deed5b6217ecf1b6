//! How the error of the three couplings falls with dx, and what it does with m:
//!
//! ```text
//! cargo run --release --example manufactured                 # dx = 1/32 and 1/64
//! cargo run --release --example manufactured -- 32 64 128 256
//! ```
//!
//! The unit square, displacements prescribed around it; in its middle an island of material points,
//! 1/2 wide, in Q8 elements as wide as 4 dx. The field crosses the interface and needs no body force. In
//! Muskhelishvili's form, with κ = (3 − ν)/(1 + ν) = 2 in plane stress, any analytic φ gives one; here
//!
//! u + iv = κ φ(z) − z φ'(z)*,   φ = exp z
//!
//! The error is the root of the mean square over all dofs but the prescribed, over that of the field. The
//! micromodulus is isotropised throughout, so that the difference is the coupling's.

use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::CellKind;
use peristitch::mesh::grid::{Grid, centre};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings, Region};
use peristitch::peridynamics::kernel::{Kernel, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics;
use std::error::Error;

pub const COUPLINGS: [(&str, Coupling); 2] = [
    ("truss", Coupling::Truss(NodeArea::Lumped)),
    ("clip", Coupling::Clip),
];

/// The horizons of the study against m, δ/dx.
pub const HORIZONS: [f64; 4] = [2.0, 3.0, 4.0, 6.0];

/// u(x) without body force, for E = 1 up to a factor.
pub fn exact([x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = y.sin_cos();
    [
        x.exp() * (2.0 * cos - x * cos - y * sin),
        x.exp() * (2.0 * sin - y * cos + x * sin),
    ]
}

/// The error with dx = 1/`count` and δ = `ratio` dx, by elements of 4 dx.
pub fn error(coupling: Coupling, count: usize, ratio: f64) -> Result<f64, Box<dyn Error>> {
    let model = model(coupling, count, ratio)?;
    let mut boundary = Boundary::new(&model);
    let is_outer = |x: &[f64; 2]| x.iter().any(|&x| !(1e-9..=1.0 - 1e-9).contains(&x));
    for (node, x) in model.positions.iter().enumerate() {
        if is_outer(x) {
            for (axis, value) in exact(*x).into_iter().enumerate() {
                let entry = (value, "outline".to_owned());
                boundary.prescribed.insert(2 * node + axis, entry);
            }
        }
    }
    let solution = statics::solve(&model, &boundary)?;
    let (mut square, mut scale) = (0.0, 0.0);
    for (u, x) in solution.displacement.iter().zip(&model.positions) {
        if !is_outer(x) {
            let [ex, ey] = exact(*x);
            square += (u[0] - ex).powi(2) + (u[1] - ey).powi(2);
            scale += ex * ex + ey * ey;
        }
    }
    Ok((square / scale).sqrt())
}

fn model(coupling: Coupling, count: usize, ratio: f64) -> Result<Model, Box<dyn Error>> {
    let elements = count / 4;
    let mesh = Grid {
        size: [1.0, 1.0],
        count: [elements; 2],
        kind: CellKind::Quad8,
    }
    .plain();
    let is_inside = |&cell: &usize| centre(&mesh, cell).iter().all(|x| (x - 0.5).abs() < 0.25);
    let (island, frame) = (0..mesh.cells.len()).partition(is_inside);
    let material = Material {
        young: 1.0,
        poisson: PlaneState::Stress.bond_based_poisson(),
    };
    let spacing = 1.0 / count as f64;
    let points = PeridynamicSettings {
        lattice: LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Clipped),
        horizon_ratio: ratio,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: true,
        surface_correction: SurfaceCorrection::None,
    };
    let region = |name: &str, cells, method| Region {
        name: name.to_owned(),
        cells,
        material,
        method,
    };
    let regions = vec![
        region("frame", frame, Method::FiniteElements),
        region("island", island, Method::Peridynamics(points)),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling,
    };
    Ok(Model::build(mesh, regions, settings)?)
}

/// Slope of the straight line through (log x, log y), by least squares.
pub fn slope(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let count = logs.len() as f64;
    let mean = [0, 1].map(|k| logs.iter().map(|p| p[k]).sum::<f64>() / count);
    let product = |a: usize, b: usize| {
        let terms = logs.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b]));
        terms.sum::<f64>()
    };
    product(0, 1) / product(0, 0)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut counts: Vec<usize> = std::env::args()
        .skip(1)
        .map(|given| given.parse())
        .collect::<Result<_, _>>()?;
    if counts.is_empty() {
        counts = vec![32, 64];
    }
    table("δ = 4 dx, 1/dx", &counts, -1.0, |coupling, &count| {
        Ok((count as f64, error(coupling, count, 4.0)?))
    })?;
    table("dx = 1/64, m", &HORIZONS, 1.0, |coupling, &ratio| {
        Ok((ratio, error(coupling, 64, ratio)?))
    })?;
    // At a fixed horizon dx is δ/m.
    let refined = [(32, 2.0), (64, 4.0), (128, 8.0)];
    table(
        "δ = 1/16, m",
        &refined,
        1.0,
        |coupling, &(count, ratio)| Ok((ratio, error(coupling, count, ratio)?)),
    )
}

/// One row per coupling; the slope against `sign` times the logarithm of the abscissa.
fn table<T>(
    what: &str,
    cases: &[T],
    sign: f64,
    measure: impl Fn(Coupling, &T) -> Result<(f64, f64), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    for (name, coupling) in COUPLINGS {
        let mut row = format!("| {name}, {what} |");
        let mut points = Vec::new();
        for case in cases {
            let (x, error) = measure(coupling, case)?;
            row += &format!(" {x}: {error:.3e} |");
            points.push([x, error]);
        }
        println!("{row} slope {:.2} |", sign * slope(&points));
    }
    println!();
    Ok(())
}
