//! A factor that follows bonds which break, against a whole factorisation of what is left: the same bits of K
//! and of solutions, which every entry of the factors enters. Equal, not near: sums are the same, in the same
//! order.

mod common;

use common::*;
use peristitch::assembly::Pattern;
use peristitch::linear_solver::held::HeldDofs;
use peristitch::linear_solver::ordering::Ordering;
use peristitch::linear_solver::{SolverError, cholesky};
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model};
use peristitch::peridynamics::lattice::Placement;
use std::collections::BTreeSet;

/// 1 × 1 m; Q8 of 50 mm left of x = 0.3 if there are `elements`, and 60 points per metre.
fn model(elements: bool) -> Model {
    let grid = Grid {
        size: [1.0, 1.0],
        count: [20, 20],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "points", |x| !elements || x[0] > 0.3);
    let lattice = paper_lattice(1.0 / 60.0, Placement::CellCentred);
    let points = region(&mesh, &["points"], steel(), Method::Peridynamics(lattice));
    let mut regions = vec![points];
    if elements {
        name_cells(&mut mesh, "elements", |x| x[0] < 0.3);
        let elements = region(&mesh, &["elements"], steel(), Method::FiniteElements);
        regions.insert(0, elements);
    }
    build(mesh, regions, PlaneState::Stress)
}

/// A body that loses bonds.
struct Body {
    model: Model,
    integrity: Vec<f64>,
    held: Vec<bool>,
}

impl Body {
    fn new(model: Model) -> Body {
        let held = (0..2 * model.node_count()).map(|dof| model.positions[dof / 2][0] < 0.03);
        Body {
            held: held.collect(),
            integrity: model.integrity.clone(),
            model,
        }
    }

    fn held(&self) -> HeldDofs<'_> {
        HeldDofs {
            is_held: &self.held,
            diagonal: 1e11,
        }
    }

    /// Breaks the bonds that cross y = 0.5 between two x; returns the nodes that they tied.
    fn tear(&mut self, from: f64, to: f64) -> Vec<u32> {
        let model = &self.model;
        let crosses = |&bond: &usize| {
            let [a, b] = model.interactions.segment(bond, &model.positions);
            let x = 0.5 * (a[0] + b[0]);
            (a[1] - 0.5) * (b[1] - 0.5) < 0.0 && x > from && x < to
        };
        let bonds: Vec<usize> = model.interactions.bonds().filter(crosses).collect();
        assert!(bonds.len() > 20);
        self.lose(&bonds)
    }

    fn lose(&mut self, bonds: &[usize]) -> Vec<u32> {
        bonds.iter().for_each(|&bond| self.integrity[bond] = 0.0);
        let nodes = bonds
            .iter()
            .flat_map(|&bond| self.model.interactions.nodes(bond));
        let nodes: BTreeSet<u32> = nodes.copied().collect();
        nodes.into_iter().collect()
    }
}

fn load(n: usize) -> Vec<f64> {
    (0..n).map(|k| 1e6 * (1.0 + (k * 7 % 13) as f64)).collect()
}

/// A crack that grows in steps of three spacings, from where it was expected to begin and from elsewhere; then
/// a point that is held, and one that a single bond keeps: the hinge shows at the same dof.
#[test]
fn cholesky_has_the_bits_of_a_whole_factorisation() {
    let mut body = Body::new(model(true));
    let Model {
        interactions,
        positions,
        ..
    } = &body.model;
    let (interactions, positions) = (interactions.clone(), positions.clone());
    let elements = body.model.element_stiffness();
    let pattern = Pattern::new(positions.len(), &interactions, &elements);
    let symbolic = || {
        cholesky::Symbolic::<2>::new(pattern.symbolic(), &pattern.graph, Ordering::Metis)
            .expect("an order")
    };
    let [own, other] = [symbolic(), symbolic()];
    let near = |x: f64| -> Vec<u32> {
        let is_near = |&node: &u32| {
            let p = positions[node as usize];
            (p[0] - x).hypot(p[1] - 0.5) < 0.05
        };
        (0..positions.len() as u32).filter(is_near).collect()
    };
    for likely in [near(0.95), near(0.4), Vec::new()] {
        body.integrity = body.model.integrity.clone();
        body.held = Body::new(model(true)).held;
        let integrity = body.integrity.clone();
        let mut k = pattern.assemble_with(&positions, &interactions, |s| integrity[s], &elements);
        let factor = own.factorise_held(&k, body.held(), &likely);
        let mut factor = factor.expect("it is held");
        for step in 0..10 {
            let x = 1.0 - 0.05 * step as f64;
            let mut nodes = body.tear(x - 0.05, x);
            let integrity = |s: usize| body.integrity[s];
            pattern.reassemble(
                &mut k,
                &nodes,
                &positions,
                &interactions,
                integrity,
                &elements,
            );
            let whole = pattern.assemble_with(&positions, &interactions, integrity, &elements);
            assert_eq!(k.val(), whole.val(), "step {step}");
            if step == 5 {
                let node = nodes[nodes.len() / 2];
                nodes.extend(pattern.graph.of(node as usize));
                body.held[2 * node as usize] = true;
            }
            let done = factor.refactorise(&k, body.held(), &nodes);
            done.expect("it is held");
            let flops = factor.flops_above(&nodes);
            // A path to the root is a small part of the tree.
            assert!(flops < 0.5 * own.flops(), "{flops:e} of {:e}", own.flops());
            let again = other.factorise_held(&whole, body.held(), &[]);
            let [mut x, mut expected] = [load(k.ncols()), load(k.ncols())];
            factor.solve_in_place(&mut x);
            again.expect("it is held").solve_in_place(&mut expected);
            assert_eq!(x, expected, "step {step}");
        }
        // All bonds but one of a point at the rim.
        let last = positions.len() - 1;
        let ends_there = |&bond: &usize| interactions.nodes(bond).contains(&(last as u32));
        let bonds: Vec<usize> = body.model.interactions.bonds().filter(ends_there).collect();
        let nodes = body.lose(&bonds[1..]);
        let integrity = |s: usize| body.integrity[s];
        pattern.reassemble(
            &mut k,
            &nodes,
            &positions,
            &interactions,
            integrity,
            &elements,
        );
        let dof = |error: SolverError| match error {
            SolverError::NotPositiveDefinite { dof } => dof,
            error => panic!("{error}"),
        };
        let mut nodes = nodes;
        let mut hinges = 0;
        while let Err(error) = factor.refactorise(&k, body.held(), &nodes) {
            let hinge = dof(error);
            let expected = other.factorise_held(&k, body.held(), &[]);
            assert_eq!(hinge, dof(expected.expect_err("a hinge")));
            body.held[hinge] = true;
            nodes = pattern.graph.of(hinge / 2).to_vec();
            nodes.push(hinge as u32 / 2);
            hinges += 1;
        }
        assert!(hinges > 0);
        let again = other.factorise_held(&k, body.held(), &[]);
        let [mut x, mut expected] = [load(k.ncols()), load(k.ncols())];
        factor.solve_in_place(&mut x);
        again.expect("it is held").solve_in_place(&mut expected);
        assert_eq!(x, expected);
    }
}
