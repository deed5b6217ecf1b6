//! The sparse Cholesky solver against faer's, on a lattice and on a hybrid cantilever: solutions agree to
//! 1e-10 of the largest displacement (condition 1e5 to 1e7 times rounding; 1e-12 was measured).
//!
//! Eight right-hand sides give the bits of one at a time, and any number of threads the same bits.

mod common;

use common::*;
use faer::Side;
use faer::linalg::solvers::Solve;
use peristitch::assembly::{Lists, LowerMatrix, Pattern, lower_pattern};
use peristitch::linear_solver::SolverError;
use peristitch::linear_solver::cholesky::{Factor, Symbolic};
use peristitch::linear_solver::held::HeldDofs;
use peristitch::linear_solver::ordering::Ordering;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model};
use peristitch::peridynamics::lattice::Placement;
use std::sync::Arc;

const TOLERANCE: f64 = 1e-10;

/// 1 × 1 m; Q8 of 50 mm left of `middle`, points 1/`side` m apart right of it.
fn model(middle: f64, side: usize) -> Model {
    let grid = Grid {
        size: [1.0, 1.0],
        count: [20, 20],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "points", |x| x[0] > middle);
    let lattice = paper_lattice(1.0 / side as f64, Placement::CellCentred);
    let mut regions = vec![region(
        &mesh,
        &["points"],
        steel(),
        Method::Peridynamics(lattice),
    )];
    if middle > 0.0 {
        name_cells(&mut mesh, "elements", |x| x[0] < middle);
        let elements = region(&mesh, &["elements"], steel(), Method::FiniteElements);
        regions.insert(0, elements);
    }
    build(mesh, regions, PlaneState::Stress)
}

/// K with the nodes near x = 0 held.
fn system(model: &Model) -> (Pattern, LowerMatrix) {
    let elements = model.element_stiffness();
    let pattern = Pattern::new(model.node_count(), &model.interactions, &elements);
    let stiffness = pattern.assemble(&model.positions, &model.interactions, &elements);
    let held: Vec<bool> = (0..2 * model.node_count())
        .map(|dof| model.positions[dof / 2][0] < 0.03)
        .collect();
    let matrix = stiffness.hold(&held, stiffness.mean_diagonal());
    (pattern, matrix)
}

fn symbolic(pattern: &Pattern, ordering: Ordering) -> Symbolic<2> {
    Symbolic::<2>::new(pattern.symbolic(), &pattern.graph, ordering).expect("an order")
}

fn loads(n: usize, columns: usize) -> Vec<f64> {
    (0..n * columns)
        .map(|k| 1e6 * (1.0 + ((k % n * 7 + k / n) % 13) as f64))
        .collect()
}

#[test]
fn solutions_are_those_of_faer() {
    for (middle, side) in [(0.0, 40), (0.5, 60)] {
        let (pattern, matrix) = system(&model(middle, side));
        let n = matrix.ncols();
        let b = loads(n, 1);
        let faer = matrix
            .as_ref()
            .sp_cholesky(Side::Lower)
            .expect("positive definite");
        let expected = faer.solve(faer::Col::from_fn(n, |i| b[i]));
        let largest = (0..n).map(|i| expected[i].abs()).fold(0.0, f64::max);
        for ordering in [Ordering::Metis, Ordering::Amd] {
            let factor = symbolic(&pattern, ordering).factorise(&matrix);
            let mut x = b.clone();
            factor.expect("positive definite").solve_in_place(&mut x);
            for i in 0..n {
                let error = (x[i] - expected[i]).abs() / largest;
                assert!(
                    error < TOLERANCE,
                    "dof {i} of {n}, {ordering:?}: {error:.1e}"
                );
            }
        }
    }
}

/// Of a solution that is asked for at some nodes only, these have the bits of the whole one. Others are not all found:
/// or nothing would be saved.
#[test]
fn part_of_a_solution_is_part_of_the_whole_one() {
    let (pattern, matrix) = system(&model(0.5, 120));
    let n = matrix.ncols();
    let factor = symbolic(&pattern, Ordering::Metis).factorise(&matrix);
    let factor = factor.expect("positive definite");
    let whole = {
        let mut x = loads(n, 3);
        factor.solve_in_place(&mut x);
        x
    };
    let nodes = [0, 17, (n / 4) as u32, (n / 2 - 1) as u32];
    let mut part = loads(n, 3);
    factor.solve_at(&nodes, &mut part);
    for (part, whole) in part.chunks_exact(n).zip(whole.chunks_exact(n)) {
        for dof in nodes.iter().flat_map(|&node| [2 * node, 2 * node + 1]) {
            assert_eq!(part[dof as usize], whole[dof as usize], "dof {dof}");
        }
        let missing = part.iter().filter(|x| **x == 0.0).count();
        assert!(2 * missing > n, "{missing} of {n}");
    }
}

/// The second factorisation works in the memory of the first, which is full of its numbers.
#[test]
fn the_bits_depend_neither_on_threads_nor_on_company_nor_on_the_memory() {
    let (pattern, matrix) = system(&model(0.5, 120));
    let n = matrix.ncols();
    let symbolic = symbolic(&pattern, Ordering::Metis);
    let b = loads(n, 11);
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let factor = symbolic.factorise(&matrix).expect("positive definite");
            let mut many = b.clone();
            factor.solve_in_place(&mut many);
            let mut single = b.clone();
            single
                .chunks_exact_mut(n)
                .for_each(|b| factor.solve_in_place(b));
            [many, single]
        })
    };
    let [many, single] = solve(1);
    assert_eq!(many, single);
    for threads in [1, 2, 3] {
        assert_eq!(
            solve(threads),
            [many.clone(), single.clone()],
            "{threads} threads"
        );
    }
}

/// A free body has pivots of rounding size; a dof that pulls away from its place a negative one.
#[test]
fn what_is_not_positive_definite_is_named() {
    let model = model(0.0, 60);
    let (pattern, matrix) = system(&model);
    let symbolic = symbolic(&pattern, Ordering::Metis);
    let free = pattern.assemble(&model.positions, &model.interactions, &[]);
    let error = symbolic.factorise(&free).expect_err("three free motions");
    assert!(
        matches!(error, SolverError::NotPositiveDefinite { .. }),
        "{error}"
    );
    // A held dof stands alone: its pivot is its entry.
    let held = 7;
    let mut negative = matrix.clone();
    let (structure, values) = negative.parts_mut();
    values[structure.col_range(held).start] *= -1.0;
    let error = symbolic
        .factorise(&negative)
        .expect_err("one pivot is negative");
    assert!(
        matches!(error, SolverError::NotPositiveDefinite { dof } if dof == held),
        "{error}"
    );
    symbolic.factorise(&matrix).expect("as before");
}

/// By products of L⁻¹ E, and by whole solutions: sums of the same products in another order.
#[test]
fn compliances_are_those_of_whole_solutions() {
    let (pattern, matrix) = system(&model(0.5, 60));
    let n = matrix.ncols();
    let factor = symbolic(&pattern, Ordering::Metis).factorise(&matrix);
    let factor = factor.expect("positive definite");
    // Near each other and far apart, in no order.
    let columns: Vec<usize> = (20..70).map(|k| (k * 611 + (k % 3) * 17) % n).collect();
    let compliance = factor.unit_loads(&columns, |_| true).square();
    for (j, &column) in columns.iter().enumerate() {
        let mut x = vec![0.0; n];
        x[column] = 1.0;
        factor.solve_in_place(&mut x);
        let largest = x.iter().fold(0.0, |a, b| f64::max(a, b.abs()));
        for (i, &row) in columns.iter().enumerate() {
            let off = (compliance[(i.max(j), i.min(j))] - x[row]).abs();
            assert!(off < 1e-12 * largest, "{row} {column}: {off:e}");
        }
    }
}

/// A square of `side` × `side` nodes, each tied to the eight around it, with `B` unknowns: for one unknown a
/// Laplacian on soft ground, for more with blocks that are not symmetric.
fn square<const B: usize>(side: usize) -> (Lists, LowerMatrix) {
    let near = |&(a, b): &(usize, usize)| {
        let [x, y] = [a % side, a / side].map(|k| k as i64);
        let [u, v] = [b % side, b / side].map(|k| k as i64);
        a != b && (x - u).abs() <= 1 && (y - v).abs() <= 1
    };
    let n = side * side;
    let pairs: Vec<(usize, usize)> = (0..n)
        .flat_map(|a| (0..n).map(move |b| (a, b)))
        .filter(near)
        .collect();
    let graph = Lists::collect(n, || pairs.iter().map(|&(a, b)| (a as u32, b as u32)));
    let pattern = Arc::new(lower_pattern::<B>(&graph));
    // More than the sum of what stands beside it.
    let diagonal = 8.1 * (1..=B).sum::<usize>() as f64;
    let entry = |row: usize, column: usize| {
        let (i, j) = (row % B, column % B);
        match (row / B == column / B, i == j) {
            (true, true) => diagonal,
            (true, false) => 0.1 * (i + j) as f64,
            (false, true) => -1.0,
            (false, false) => 0.3 * (i as f64 - 2.0 * j as f64),
        }
    };
    let columns = (0..B * n).flat_map(|column| {
        let rows = pattern.row_idx()[pattern.col_range(column)].iter();
        rows.map(move |&row| entry(row as usize, column))
    });
    let values: Vec<f64> = columns.collect();
    (graph, LowerMatrix::new(pattern, values))
}

/// One unknown of a node, two, three and four: the solution of faer, with a dof held, and after a change between a
/// few nodes the bits of a whole factorisation.
fn solves_with_unknowns_per_node<const B: usize>() {
    let (graph, mut matrix) = square::<B>(23);
    let n = matrix.ncols();
    let symbolic = |ordering| {
        let pattern = matrix.as_ref().symbolic();
        Symbolic::<B>::new(pattern, &graph, ordering).expect("an order")
    };
    let symbolic = [symbolic(Ordering::Metis), symbolic(Ordering::Amd)];
    let mut is_held = vec![false; n];
    is_held[n / 3] = true;
    let held = HeldDofs {
        is_held: &is_held,
        diagonal: 7.0,
    };
    let expected = |matrix: &LowerMatrix| {
        let held = matrix.hold(&is_held, 7.0);
        let faer = held.as_ref().sp_cholesky(Side::Lower);
        let b = faer::Col::from_fn(n, |i| loads(n, 1)[i]);
        faer.expect("positive definite").solve(b)
    };
    let assert_solved = |factor: &Factor<B>, matrix: &LowerMatrix| {
        let (mut x, expected) = (loads(n, 1), expected(matrix));
        factor.solve_in_place(&mut x);
        let largest = x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (x, e) in x.iter().zip(expected.iter()) {
            assert!(
                (x - e).abs() < 1e-13 * largest,
                "{B} unknowns: {x:e} for {e:e}"
            );
        }
        x
    };
    let [mut factor, _] = symbolic.each_ref().map(|symbolic| {
        let factor = symbolic.factorise_held(&matrix, held, &[]);
        let factor = factor.expect("positive definite");
        assert_solved(&factor, &matrix);
        factor
    });
    // Between a node and its neighbours.
    let node = n / B / 2;
    let (structure, values) = matrix.parts_mut();
    for column in B * node..B * (node + 1) {
        let entries = structure.col_range(column);
        values[entries.start] += 2.0;
        values[entries.end - 1] *= 0.5;
    }
    let mut nodes = graph.of(node).to_vec();
    nodes.push(node as u32);
    let done = factor.refactorise(&matrix, held, &nodes);
    done.expect("positive definite");
    assert!(factor.flops_above(&nodes) < symbolic[0].flops());
    let whole = symbolic[0].factorise_held(&matrix, held, &[]);
    let whole = assert_solved(&whole.expect("positive definite"), &matrix);
    assert_eq!(assert_solved(&factor, &matrix), whole, "{B} unknowns");
}

#[test]
fn a_node_may_have_any_number_of_unknowns() {
    solves_with_unknowns_per_node::<1>();
    solves_with_unknowns_per_node::<2>();
    solves_with_unknowns_per_node::<3>();
    solves_with_unknowns_per_node::<4>();
}
