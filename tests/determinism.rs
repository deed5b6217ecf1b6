//! The same model gives the same bits, whatever the number of threads and whatever else runs at the
//! same time: bonds, displacements and reactions, in pools of one, two and three. Bits are compared;
//! there is no tolerance.
//!
//! The order of the mesh's nodes and cells may change the order of sums, and so the last bits, but
//! no more: displacements of a renumbered mesh agree to 2e-12 of the largest; 4e-14 to
//! 4e-13 was measured.

mod common;

use common::*;
use peristitch::assembly::Pattern;
use peristitch::boundary::Boundary;
use peristitch::fem::edge::EdgeLoad;
use peristitch::linear_solver::ordering::{Ordering, elimination_order};
use peristitch::material::PlaneState;
use peristitch::mesh::{Cell, CellKind, Edge, Mesh};
use peristitch::model::{Method, Model};
use peristitch::peridynamics::lattice::Placement;
use peristitch::statics::{self, Solution};

/// Cantilever 2 × 1 m: Q8 of 50 mm left of the middle, points 12.5 mm apart right of it.
fn cantilever() -> Mesh {
    let mut mesh = Grid {
        size: [2.0, 1.0],
        count: [40, 20],
        kind: CellKind::Quad8,
    }
    .plain();
    name_cells(&mut mesh, "elements", |x| x[0] < 1.0);
    name_cells(&mut mesh, "points", |x| x[0] > 1.0);
    named(mesh, 2.0)
}

fn named(mut mesh: Mesh, width: f64) -> Mesh {
    name_curve(&mut mesh, "clamp", |x| x[0] < 1e-9);
    name_curve(&mut mesh, "load", |x| x[0] > width - 1e-9);
    mesh
}

fn hybrid(mesh: Mesh) -> Model {
    let method = Method::Peridynamics(paper_lattice(0.0125, Placement::CellCentred));
    let regions = vec![
        region(&mesh, &["elements"], steel(), Method::FiniteElements),
        region(&mesh, &["points"], steel(), method),
    ];
    build(mesh, regions, PlaneState::Stress)
}

/// 120 × 120 points: 28 800 unknowns, supernodes wide enough for faer to share them out.
fn lattice() -> Model {
    let grid = Grid {
        size: [1.0, 1.0],
        count: [4, 4],
        kind: CellKind::Quad4,
    };
    let mut mesh = named(grid.plain(), 1.0);
    name_cells(&mut mesh, "points", |_| true);
    let method = Method::Peridynamics(paper_lattice(1.0 / 120.0, Placement::CellCentred));
    let regions = vec![region(&mesh, &["points"], steel(), method)];
    let model = build(mesh, regions, PlaneState::Stress);
    assert_eq!(model.areas.len(), 120 * 120);
    model
}

fn solve(model: &Model) -> Solution {
    let mut boundary = Boundary::new(model);
    boundary
        .displace(model, "clamp", [Some(0.0), Some(0.0)])
        .expect("a clamp");
    boundary
        .add_traction(model, "load", EdgeLoad::Traction([3e5, -1e6]))
        .expect("a load");
    statics::solve(model, &boundary).expect("a solution")
}

/// What must not depend on the threads.
#[derive(Debug, PartialEq, Eq)]
struct Bits {
    bonds: Vec<u64>,
    displacement: Vec<u64>,
    reaction: Vec<u64>,
}

fn bits_in_a_pool_of(threads: usize, model: fn() -> Model) -> Bits {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool").install(|| {
        assert_eq!(rayon::current_num_threads(), threads);
        let model = model();
        let solution = solve(&model);
        let bits = |v: &[[f64; 2]]| v.iter().flatten().map(|x| x.to_bits()).collect();
        Bits {
            bonds: model
                .interactions
                .stiffness
                .iter()
                .map(|k| k.to_bits())
                .collect(),
            displacement: bits(&solution.displacement),
            reaction: bits(&solution.reaction),
        }
    })
}

fn assert_same_bits(model: fn() -> Model) {
    let [one, two, three] = [1, 2, 3].map(|threads| bits_in_a_pool_of(threads, model));
    for (threads, bits) in [(2, two), (3, three)] {
        let count = |a: &[u64], b: &[u64]| a.iter().zip(b).filter(|(a, b)| a != b).count();
        let differences = [
            count(&one.bonds, &bits.bonds),
            count(&one.displacement, &bits.displacement),
            count(&one.reaction, &bits.reaction),
        ];
        assert_eq!(
            differences, [0; 3],
            "bonds, displacements, reactions with {threads} threads"
        );
    }
}

#[test]
fn the_hybrid_gives_the_same_bits_on_any_number_of_threads() {
    assert_same_bits(|| hybrid(cantilever()));
}

#[test]
fn the_lattice_gives_the_same_bits_on_any_number_of_threads() {
    assert_same_bits(lattice);
}

/// METIS keeps one random state for the whole process.
#[test]
fn solves_at_the_same_time_do_not_disturb_each_other() {
    let model = hybrid(cantilever());
    let pattern = Pattern::new(
        model.node_count(),
        &model.interactions,
        &model.element_stiffness(),
    );
    let order = || elimination_order(Ordering::Metis, &pattern.graph);
    let alone = order();
    assert!(alone.is_ok());
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..8).map(|_| scope.spawn(order)).collect();
        for thread in running {
            assert!(thread.join().expect("no panic") == alone);
        }
    });
}

/// Nodes and cells in another order, names kept.
fn renumbered(mesh: &Mesh) -> Mesh {
    // Multiplication by a number without common factor permutes; so does reversal.
    let count = mesh.nodes.len();
    let factor = (count / 2..)
        .find(|&f| gcd(f, count) == 1)
        .expect("some number is coprime");
    let to = |node: usize| (node * factor + 7) % count;
    let cell_to = |cell: usize| mesh.cells.len() - 1 - cell;
    let mut nodes = vec![[0.0; 2]; count];
    mesh.nodes
        .iter()
        .enumerate()
        .for_each(|(n, &x)| nodes[to(n)] = x);
    let cells = mesh.cells.iter().rev().map(|cell| {
        let nodes: Vec<usize> = cell.nodes().iter().map(|&n| to(n)).collect();
        Cell::new(cell.kind, &nodes)
    });
    let edge = |edge: &Edge| Edge {
        ends: edge.ends.map(to),
        middle: edge.middle.map(to),
    };
    let mut surfaces = mesh.surfaces.clone();
    for surface in surfaces.values_mut() {
        surface.iter_mut().for_each(|cell| *cell = cell_to(*cell));
        surface.sort_unstable();
    }
    let curves = mesh.curves.iter();
    Mesh {
        nodes,
        cells: cells.collect(),
        surfaces,
        curves: curves
            .map(|(name, edges)| (name.clone(), edges.iter().rev().map(edge).collect()))
            .collect(),
        ..Mesh::default()
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[test]
fn renumbering_the_mesh_changes_no_more_than_rounding() {
    let mesh = cantilever();
    let (first, second) = (hybrid(mesh.clone()), hybrid(renumbered(&mesh)));
    let key = |x: &[f64; 2]| x.map(|x| (x * 1e6).round() as i64);
    let at: std::collections::HashMap<_, _> = second
        .positions
        .iter()
        .enumerate()
        .map(|(n, x)| (key(x), n))
        .collect();
    assert_eq!(at.len(), first.node_count());
    let (u, v) = (solve(&first).displacement, solve(&second).displacement);
    let scale = u.iter().flatten().fold(0.0f64, |m, u| m.max(u.abs()));
    let mut moved = 0;
    let mut error = 0.0f64;
    for (n, x) in first.positions.iter().enumerate() {
        let other = at[&key(x)];
        moved += usize::from(other != n);
        for axis in 0..2 {
            error = error.max((u[n][axis] - v[other][axis]).abs() / scale);
        }
    }
    assert!(moved > first.fe_node_count() / 2);
    // Condition number 1e6, refined to a residual of 1e-14.
    assert!(error < 2e-12, "{error:e}");
}
