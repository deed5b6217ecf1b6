//! A crack in an infinite plate under tension and under shear: K_I and K_II.
//!
//! The exact displacements around a crack |x| < a (Muskhelishvili 1953, §120) are prescribed on the outside of a
//! square, so that the size of the plate is no error. With the remote stresses σ_yy = σ and σ_xy = τ, σ_xx = 0,
//! μ the shear modulus, κ = (3 − ν)/(1 + ν) in plane stress, and s = (σ − iτ)/2, c = σ/4:
//!
//! ```text
//! 2μ (u + iv) = κ φ(z) − ω(z̄) − (z − z̄) φ'(z)̄,   φ = s √(z² − a²) − c z,   ω = s √(z² − a²) + c z
//! K_I = σ √(πa),   K_II = τ √(πa),   G = K²/E
//! ```
//!
//! G is measured at fixed displacements, as the change of the energy W when both tips move by one spacing:
//! G = −dW/d(2a).

use super::bodies::{build, default_lattice, hold, material, outer_nodes, region, solve};
use super::{Check, Reference, VerificationError};
use crate::coupling::Coupling;
use crate::cracks::Cracks;
use crate::mesh::grid::{Grid, centre, name_cells};
use crate::mesh::{Cell, CellKind, Edge, Mesh};
use crate::model::Method;
use nalgebra::Complex;
use std::collections::HashMap;
use std::f64::consts::PI;

/// a, E and the remote stress are 1.
const NU: f64 = 1.0 / 3.0;

/// The remote stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// σ_yy.
    Opening,
    /// σ_xy.
    Shear,
}

/// How the crack is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crack {
    /// The crack is an initial crack: bonds are severed, and the surface correction does not know of it.
    Severed,
    /// The crack is a slit of the mesh, whose faces are free sides.
    Slit,
}

/// u(x) [m].
pub fn displacement(mode: Mode, [x, y]: [f64; 2]) -> [f64; 2] {
    let (s, c) = match mode {
        Mode::Opening => (Complex::new(0.5, 0.0), 0.25),
        Mode::Shear => (Complex::new(0.0, -0.5), 0.0),
    };
    let root = |z: Complex<f64>| (z - 1.0).sqrt() * (z + 1.0).sqrt();
    let z = Complex::new(x, y);
    let phi = s * root(z) - z * c;
    let slope = s * z / root(z) - c;
    let omega = s * root(z.conj()) + z.conj() * c;
    let mu = 1.0 / (2.0 * (1.0 + NU));
    let kappa = (3.0 - NU) / (1.0 + NU);
    let u = (phi * kappa - omega - (z - z.conj()) * slope.conj()) / (2.0 * mu);
    [u.re, u.im]
}

/// Half-sides of the square of points and of the plate, in a; elements along the plate.
const POINTS: f64 = 2.4;
const PLATE: f64 = 3.2;
const ELEMENTS: usize = 32;

/// Coordinates that differ by less are the same.
const SAME: f64 = 1e-9;

/// K over the exact one, at δ = `horizon` · a.
///
/// # Errors
/// Errors of building and solving.
pub fn ratio(mode: Mode, crack: Crack, horizon: f64) -> Result<f64, VerificationError> {
    let spacing = horizon / 4.0;
    let [longer, shorter] =
        [1.0, -1.0].map(|step| energy(mode, crack, spacing, 1.0 + step * spacing));
    let rate = (shorter? - longer?) / (4.0 * spacing);
    Ok((rate / PI).sqrt())
}

/// W with a crack of half-length `a` [J].
fn energy(mode: Mode, crack: Crack, spacing: f64, a: f64) -> Result<f64, VerificationError> {
    let mesh = mesh(crack, a);
    let cracks = Cracks::new(&mesh, mesh.curves.get("crack").map_or(&[], Vec::as_slice));
    let points = Method::Peridynamics(default_lattice(spacing));
    let regions = vec![
        region(&mesh, &["points"], material(1.0), points),
        region(&mesh, &["frame"], material(1.0), Method::FiniteElements),
    ];
    let model = build(mesh, regions, Coupling::Clip)?.with_cracks(&cracks);
    let outside = outer_nodes(&model).into_iter();
    let outside = outside.filter(|&node| model.positions[node].iter().any(|x| x.abs() > POINTS));
    let boundary = hold(&model, outside, |x| displacement(mode, x));
    let reaction = solve(&model, &boundary)?.reaction;
    let held = boundary.prescribed.iter();
    let work = held.map(|(dof, (value, _))| value * reaction[dof / 2][dof % 2]);
    Ok(0.5 * work.sum::<f64>())
}

/// The plate about the middle of a crack of half-length `a`, whose tips are nodes.
fn mesh(crack: Crack, a: f64) -> Mesh {
    let grid = Grid {
        size: [2.0 * PLATE; 2],
        count: [ELEMENTS; 2],
        kind: CellKind::Quad8,
    };
    let is_tip =
        |[x, y]: [f64; 2]| ((x - PLATE).abs() - 1.0).abs() < SAME && (y - PLATE).abs() < SAME;
    let mut mesh = grid.mesh(|x| match is_tip(x) {
        true => [(a - 1.0) * (x[0] - PLATE).signum(), 0.0],
        false => [0.0; 2],
    });
    for x in &mut mesh.nodes {
        *x = x.map(|x| x - PLATE);
    }
    let is_inside = |[x, y]: [f64; 2]| x.abs().max(y.abs()) < POINTS;
    name_cells(&mut mesh, "points", is_inside);
    name_cells(&mut mesh, "frame", |x| !is_inside(x));
    match crack {
        Crack::Severed => {
            let ends = [mesh.nodes.len(), mesh.nodes.len() + 1];
            mesh.nodes.extend([[-a, 0.0], [a, 0.0]]);
            let curve = vec![Edge { ends, middle: None }];
            mesh.curves.insert("crack".to_owned(), curve);
        }
        Crack::Slit => open(&mut mesh, a),
    }
    mesh
}

/// Gives the cells above the crack nodes of their own.
fn open(mesh: &mut Mesh, a: f64) {
    let is_open = |[x, y]: [f64; 2]| y.abs() < SAME && x.abs() < a - SAME;
    let mut upper = HashMap::new();
    for node in 0..mesh.nodes.len() {
        if is_open(mesh.nodes[node]) {
            upper.insert(node, mesh.nodes.len());
            mesh.nodes.push(mesh.nodes[node]);
        }
    }
    for cell in 0..mesh.cells.len() {
        if centre(mesh, cell)[1] > 0.0 {
            let nodes = mesh.cells[cell].nodes();
            let own: Vec<usize> = nodes.iter().map(|n| *upper.get(n).unwrap_or(n)).collect();
            mesh.cells[cell] = Cell::new(CellKind::Quad8, &own);
        }
    }
}

/// δ/a = 0.2.
pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let check = |quantity, within, mode, crack| {
        Ok(Check {
            case: "crack in an infinite plate",
            quantity,
            reference: Reference::Value { value: 1.0, within },
            source: "Muskhelishvili (1953)",
            measured: ratio(mode, crack, 0.2)?,
        })
    };
    let checks = [
        check(
            "K_I, severed, δ/a = 0.2",
            0.01,
            Mode::Opening,
            Crack::Severed,
        ),
        check(
            "K_II, severed, δ/a = 0.2",
            0.04,
            Mode::Shear,
            Crack::Severed,
        ),
        check("K_I, slit, δ/a = 0.2", 0.005, Mode::Opening, Crack::Slit),
        check("K_II, slit, δ/a = 0.2", 0.01, Mode::Shear, Crack::Slit),
    ];
    checks.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::PlaneState;

    /// The remote stress far away, and no traction on the faces, by differences of the displacements.
    #[test]
    fn the_displacements_are_those_of_the_stresses() {
        let h = 1e-5;
        let stress = |mode: Mode, [x, y]: [f64; 2]| {
            let d = |axis: usize, k: usize| {
                let mut ends = [[x, y]; 2];
                ends[0][k] -= h;
                ends[1][k] += h;
                let [low, high] = ends.map(|x| displacement(mode, x)[axis]);
                (high - low) / (2.0 * h)
            };
            let strain = nalgebra::Vector3::new(d(0, 0), d(1, 1), d(0, 1) + d(1, 0));
            material(1.0).elasticity(PlaneState::Stress) * strain
        };
        for (mode, remote) in [
            (Mode::Opening, [0.0, 1.0, 0.0]),
            (Mode::Shear, [0.0, 0.0, 1.0]),
        ] {
            let far = stress(mode, [300.0, 400.0]);
            // The crack's own field falls with the square of the distance; differences of displacements of 500.
            let error = (far - nalgebra::Vector3::from(remote)).amax();
            assert!(error < 1e-4, "{mode:?}: {far}");
            for x in [-0.7, 0.0, 0.4] {
                let face = stress(mode, [x, 2e-5]);
                // The stress grows from zero at the face, at less than 10/a here.
                assert!(
                    face[1].abs().max(face[2].abs()) < 2e-4,
                    "{mode:?} {x}: {face}"
                );
            }
            // Beside the crack's tip, K/√(2πr) at r = 1e-3 a with the next term, 3r/4a, of the closed form.
            let ahead = stress(mode, [1.001, 0.0]);
            let exact = 1.001 / (1.001_f64.powi(2) - 1.0).sqrt();
            let found = ahead[if mode == Mode::Opening { 1 } else { 2 }];
            assert!(
                (found / exact - 1.0).abs() < 1e-4,
                "{mode:?}: {found} {exact}"
            );
        }
    }
}
