//! Changes of integrity of any sign and size, against a factorisation of what is left.

use super::*;
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::fracture::bond_laws::BondLaws;
use crate::fracture::functional::Values;
use crate::fracture::laws::StretchLimits;
use crate::fracture::problem::{Control, Resolution, Until};
use crate::fracture::programme::Programme;
use crate::fracture::solutions::Solutions;
use crate::fracture::zone::Zone;
use crate::fracture::zone_response::ZoneResponse;
use crate::material::{Material, PlaneState};
use crate::mesh::CellKind;
use crate::mesh::grid::{Grid, name_cells, name_curve};
use crate::model::{Method, ModelSettings, Region};
use crate::statics::Solver;
use crate::verification::bodies::default_lattice;

/// Two strips of finite elements and 20 × 8 material points between them, which clipped bonds tie to both.
fn model() -> Model {
    let grid = Grid {
        size: [20.0, 20.0],
        count: [10, 10],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "grips", |[_, y]| (y - 10.0).abs() > 4.0);
    name_cells(&mut mesh, "points", |[_, y]| (y - 10.0).abs() < 4.0);
    name_curve(&mut mesh, "top", |[_, y]| y > 20.0 - 1e-9);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    let material = Material {
        young: 1.0,
        poisson: PlaneState::Stress.bond_based_poisson(),
    };
    let region = |name: &str, method| Region {
        name: name.to_owned(),
        cells: mesh.surfaces[name].clone(),
        material,
        method,
    };
    let regions = vec![
        region("grips", Method::FiniteElements),
        region("points", Method::Peridynamics(default_lattice(1.0))),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling: Coupling::Clip,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// A new factorisation with these integrities, and its solution.
fn factorised_anew(
    model: &Model,
    boundary: &Boundary,
    integrity: &[f64],
) -> (Factorised, Solution) {
    let solver = Solver::new(model, boundary).expect("a structure");
    let mechanisms = &mut BTreeSet::new();
    let factorised = solver.factorise_broken(integrity, &[], mechanisms);
    let factorised = factorised.expect("the body is held");
    let solution = solver.solve_with(&factorised, boundary, None, mechanisms);
    (factorised, solution.expect("a solution"))
}

/// The largest difference over the largest of the second ones.
fn difference(found: impl Iterator<Item = f64>, expected: impl Iterator<Item = f64>) -> f64 {
    let (mut differ, mut largest) = (0.0, 0.0);
    for (found, expected) in found.zip(expected) {
        differ = f64::max(differ, (found - expected).abs());
        largest = f64::max(largest, expected.abs());
    }
    differ / largest
}

/// φ of the interactions after each change, which have one of these courses in turn: one goes down, up again and
/// to nothing, one breaks and is mended in part, one comes back whole for a while.
const CHANGES: [[f64; 3]; 4] = [
    [0.4, 0.0, 0.2],
    [0.7, 0.0, 0.9],
    [0.0, 0.0, 1.0],
    [0.0, 0.25, 0.6],
];

#[test]
fn any_course_of_integrity_is_that_of_a_new_factorisation() {
    let model = model();
    let mut boundary = Boundary::new(&model);
    for (group, u) in [("bottom", [0.0, 0.0]), ("top", [0.1, 0.3])] {
        let grip = boundary.displace(&model, group, u.map(Some));
        grip.expect("a grip");
    }
    let programme = Programme::proportional(boundary.clone());
    let problem = Problem {
        model: &model,
        programme: &programme,
        laws: &BondLaws::brittle(
            vec![StretchLimits {
                tension: 1.0,
                compression: 1.0,
            }],
            vec![0; model.interactions.len()],
        ),
        control: Control::EventDriven,
        until: Until {
            steps: 1,
            separated: true,
        },
        resolution: Resolution::Fast,
    };
    let is_near = |interaction: usize, [x, y]: [f64; 2], radius: f64| {
        let ends = model.interactions.segment(interaction, &model.positions);
        ends.iter().all(|p| (p[0] - x).hypot(p[1] - y) < radius)
    };
    let all = 0..model.interactions.len();
    // Bonds in the middle, and clipped ones at the lower interface.
    let near = |s: &usize| is_near(*s, [10.0, 10.0], 2.0) || is_near(*s, [10.0, 6.5], 1.6);
    let changed: Vec<usize> = all.filter(near).collect();
    assert!(
        changed.len() > 30
            && changed
                .iter()
                .any(|s| model.interactions.clipped_bonds().contains(s))
    );
    let mut integrity = model.integrity.clone();
    let (factorised, before) = factorised_anew(&model, &boundary, &integrity);
    let base = Solutions {
        held: None,
        unit: before.clone(),
    };
    let middle = |&n: &usize| {
        let [x, y] = model.positions[n];
        (x - 10.0).hypot(y - 8.0) < 6.0
    };
    let nodes: Vec<usize> = (0..model.node_count()).filter(middle).collect();
    let zone = Zone::new(&problem, &integrity, &nodes);
    let loads = factorised
        .unit_loads(&zone.dofs)
        .expect("Cholesky's factor");
    let own = loads.square();
    let values = Values(Vec::new());
    let mut response = ZoneResponse::new(
        &problem,
        &integrity,
        &zone,
        own.clone(),
        &base,
        Vec::new(),
        values,
    );
    let mut change = LowRankChange::default();
    for (step, courses) in CHANGES.iter().enumerate() {
        let mut losses = Vec::new();
        for (k, &interaction) in changed.iter().enumerate() {
            let next = courses[k % courses.len()];
            losses.push(Loss {
                interaction,
                stiffness: (integrity[interaction] - next)
                    * model.interactions.stiffness[interaction],
            });
            integrity[interaction] = next;
            let place = zone.place(interaction).expect("in the zone");
            let loss = response.change(&problem, &zone, place, next);
            assert_eq!(loss, losses.last().copied());
        }
        let nodes = losses
            .iter()
            .flat_map(|l| model.interactions.nodes(l.interaction));
        let dofs = nodes.flat_map(|&n| [2 * n as usize, 2 * n as usize + 1]);
        change.activate(dofs);
        change.extend(&factorised).expect("Cholesky's factor");
        change.lose(&model, &losses);
        let system = change.factorise(&[]).expect("the body is held");
        let forces = change.forces(&system, &before);
        let added = change.respond(&factorised, &forces);
        let (again, expected) = factorised_anew(&model, &boundary, &integrity);
        let u = || expected.displacement.iter().flatten().copied();
        let found = before.displacement.iter().flatten().zip(added);
        // Rounding times a condition of some hundreds.
        let differ = difference(found.map(|(u, added)| u + added), u());
        assert!(differ < 1e-12, "step {step}: u differs by {differ:e}");
        let between = change.between(&loads);
        let mut moved = between.clone();
        change.reduce(&system, moved.as_mut());
        let compliance = changed_compliance(&own, &between, &moved);
        let expected = again.unit_loads(&zone.dofs).expect("a factor").square();
        let entries = |a: &Mat<f64>| -> Vec<f64> {
            let columns = (0..a.ncols()).flat_map(|j| slice(a.col(j)).to_vec());
            columns.collect()
        };
        let differ = difference(
            entries(&compliance).into_iter(),
            entries(&expected).into_iter(),
        );
        assert!(differ < 1e-12, "step {step}: A differs by {differ:e}");
        let on_zone = zone.dofs.iter().map(|&dof| u().nth(dof).expect("a dof"));
        let differ = difference(response.displacement[1].iter().copied(), on_zone);
        assert!(differ < 1e-12, "step {step}: u on the zone by {differ:e}");
    }
}
