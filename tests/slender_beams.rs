//! Slender beams under forces: the largest ratio of ‖K‖ ‖u‖ to ‖f‖ that users meet, so that rounding leaves
//! residuals of 10⁻⁷ ‖f‖ although every solve is right to the last digit that K allows.

use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::material::Material;
use peristitch::mesh::CellKind;
use peristitch::mesh::grid::{Grid, name_cells};
use peristitch::model::{Method, Model};
use peristitch::verification::bodies::{build, region, solve};

const YOUNG: f64 = 30e9;
const POISSON: f64 = 0.2;

/// A beam of eight-node squares, 1 m high with four elements across.
fn beam(length: f64) -> Model {
    let mut mesh = Grid {
        size: [length, 1.0],
        count: [(4.0 * length) as usize, 4],
        kind: CellKind::Quad8,
    }
    .plain();
    name_cells(&mut mesh, "beam", |_| true);
    let material = Material {
        young: YOUNG,
        poisson: POISSON,
    };
    let regions = vec![region(&mesh, &["beam"], material, Method::FiniteElements)];
    build(mesh, regions, Coupling::Clip).expect("a sound model")
}

/// The nodes of one end from below, with the shares of a quadratic edge's consistent load.
fn end(model: &Model, x: f64) -> Vec<(usize, f64, f64)> {
    let on_end = |&n: &usize| (model.positions[n][0] - x).abs() < 1e-9;
    let mut nodes: Vec<usize> = (0..model.node_count()).filter(on_end).collect();
    nodes.sort_by(|&a, &b| model.positions[a][1].total_cmp(&model.positions[b][1]));
    let last = nodes.len() - 1;
    let share = |k: usize| match k {
        k if k % 2 == 1 => 4.0 / 6.0 * 0.25,
        k if k == 0 || k == last => 1.0 / 6.0 * 0.25,
        _ => 2.0 / 6.0 * 0.25,
    };
    let of = |(k, &n): (usize, &usize)| (n, model.positions[n][1], share(k));
    nodes.iter().enumerate().map(of).collect()
}

fn prescribe(boundary: &mut Boundary, dof: usize) {
    boundary.prescribed.insert(dof, (0.0, "held".to_owned()));
}

/// Pure bending, whose displacements are quadratic: eight-node rectangles have them exactly, so that what is left
/// is rounding alone.
#[test]
fn pure_bending_is_exact_to_rounding_at_any_slenderness() {
    for (length, most) in [(10.0, 1e-10), (40.0, 3e-8), (100.0, 1e-6)] {
        let model = beam(length);
        let mut boundary = Boundary::new(&model);
        for (node, y, _) in end(&model, 0.0) {
            prescribe(&mut boundary, 2 * node);
            if (y - 0.5).abs() < 1e-9 {
                prescribe(&mut boundary, 2 * node + 1);
            }
        }
        // σ_x = −κ E (y − ½): a linear traction on a quadratic edge is s_a t_a at its nodes.
        let curvature = 1e-4 / length;
        for (node, y, share) in end(&model, length) {
            boundary.load[2 * node] = -curvature * YOUNG * (y - 0.5) * share;
        }
        let solution = solve(&model, &boundary).expect("a right solve is accepted");
        let tip = 0.5 * curvature * length * length;
        let exact = |[x, y]: [f64; 2]| {
            let y = y - 0.5;
            [
                -curvature * x * y,
                0.5 * curvature * (x * x + POISSON * y * y),
            ]
        };
        let pairs = model.positions.iter().zip(&solution.displacement);
        let error = pairs
            .flat_map(|(&x, u)| [0, 1].map(|axis| (u[axis] - exact(x)[axis]).abs()))
            .fold(0.0, f64::max)
            / tip;
        println!(
            "L/h = {length}: error {error:.1e}, backward error {:.1e}",
            solution.residual
        );
        // Measured 2e-11 at 10, growing as the condition number does, with (L/h)⁴; six times that is allowed.
        assert!(error < most, "L/h = {length}: {error:e}");
        // Of a backward stable solve: some units of rounding at most, in practice far less.
        assert!(
            solution.residual < 1e-15,
            "L/h = {length}: {:e}",
            solution.residual
        );
    }
}

/// The cantilevers that were refused for residuals of 2e-8 and 3.7e-7 of their end force.
#[test]
fn cantilevers_under_an_end_force_are_solved() {
    for (length, within) in [(40.0, 2e-3), (100.0, 1e-3)] {
        let model = beam(length);
        let mut boundary = Boundary::new(&model);
        for (node, _, _) in end(&model, 0.0) {
            prescribe(&mut boundary, 2 * node);
            prescribe(&mut boundary, 2 * node + 1);
        }
        let mut tips = Vec::new();
        for (node, _, share) in end(&model, length) {
            boundary.load[2 * node + 1] = -1e3 * share;
            tips.push(node);
        }
        let solution = solve(&model, &boundary).expect("a right solve is accepted");
        // Timoshenko's beam; a clamp across the whole height adds a share of the order h/L of a percent.
        let shear = YOUNG / (2.0 * (1.0 + POISSON));
        let expected = 1e3 * length.powi(3) * 4.0 / YOUNG + 1.2 * 1e3 * length / shear;
        let tip = -solution.displacement[tips[tips.len() / 2]][1];
        let error = tip / expected - 1.0;
        println!("L/h = {length}: tip {tip:.6e} m, {error:.1e} off Timoshenko's");
        assert!(error.abs() < within, "L/h = {length}: {error:e}");
        let reaction: f64 = solution.reaction.iter().map(|r| r[1]).sum();
        // Reactions sum forces of the size ‖K‖ ‖u‖, 10⁶ times the load and more, each rounded.
        assert!(
            (reaction / 1e3 - 1.0).abs() < 1e-6,
            "L/h = {length}: {reaction:e}"
        );
    }
}
