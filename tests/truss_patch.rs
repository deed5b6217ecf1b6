//! What the truss coupling of the paper leaves of a uniform strain: an island of 12 × 8 material points
//! within finite elements, displacements of the unit strain fields prescribed around the outside.
//!
//! ```text
//!   28 dx × 24 dx, the origin at the lower left corner
//!   ┌───────────────┐
//!   │   elements    │  8 dx = 2 δ on every side
//!   │   ┌·······┐   │
//!   │   · 12 × 8 ·  │  points on cell centres, dx/2 from the interface; m = 4, quartic kernel
//!   │   └·······┘   │
//!   └───────────────┘
//! ```
//!
//! max|u − u_exact| / max|u_exact| over all dofs, in percent, for ε_xx, ε_yy and γ_xy = 1 (u = y/2,
//! v = x/2); A_FE by lumping / by half an edge times dx:
//!
//! | | ε_xx | ε_yy | γ_xy |
//! |---|---|---|---|
//! | Q4, h = 4 dx | 8.20 / 8.66 | 8.57 / 8.91 | 2.84 / 3.27 |
//! | Q8, h = 4 dx | 5.25 / 5.21 | 5.47 / 5.41 | 2.65 / 2.21 |
//! | Q4, h = 2 dx | 4.51 / 4.88 | 4.66 / 5.03 | 1.69 / 1.54 |
//! | Q8, h = 2 dx | 4.67 / 4.14 | 5.97 / 4.27 | 2.94 / 0.95 |
//!
//! An earlier study of the method gave 2–11 % for Q4 and 1.2–6.1 % for Q8 and did not say h, the ring
//! or the origin. With h = 4 dx both readings of A_FE lie within these ranges for all three strains, with
//! h = 2 dx all but the shear of Q4, and of Q8 by edges. From the body's centre the largest displacement is half as large
//! and every figure doubles. No weight makes the coupling exact: a node's trusses fill half a disc, and
//! half a disc in tension carries the stress ratio 1/2, not 1/3.
//!
//! The figures are sums of a fixed lattice: half a unit of the last digit is the tolerance. Elements in
//! the island leave 3e-15 at most: what is measured is the coupling, not the surroundings.

mod common;

use common::*;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings};
use peristitch::peridynamics::lattice::Placement;
use std::collections::BTreeMap;

const DX: f64 = 2.5e-3;

const UNIT_STRAINS: [Field; 3] = [
    |[x, _]| [x, 0.0],
    |[_, y]| [0.0, y],
    |[x, y]| [0.5 * y, 0.5 * x],
];

/// `h`: the elements' size in spacings.
fn errors(kind: CellKind, h: usize, node_area: NodeArea, island: Method) -> [f64; 3] {
    let mut mesh = Grid {
        size: [28.0 * DX, 24.0 * DX],
        count: [28 / h, 24 / h],
        kind,
    }
    .plain();
    let within =
        |[x, y]: [f64; 2]| (8.0 * DX..20.0 * DX).contains(&x) && (8.0 * DX..16.0 * DX).contains(&y);
    name_cells(&mut mesh, "island", within);
    name_cells(&mut mesh, "around", |x| !within(x));
    let regions = vec![
        region(&mesh, &["around"], steel(), Method::FiniteElements),
        region(&mesh, &["island"], steel(), island),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 0.7,
        coupling: Coupling::Truss(node_area),
    };
    let model = Model::build(mesh, regions, settings).expect("a sound model");
    let points = if island == Method::FiniteElements {
        0
    } else {
        12 * 8
    };
    assert_eq!(model.areas.len(), points);
    UNIT_STRAINS.map(|field| {
        let u = displacements(&model, &hold_outline(&model, field));
        relative_error(&model, &u, field)
    })
}

fn assert_errors(kind: CellKind, h: usize, node_area: NodeArea, percent: [f64; 3]) {
    let island = Method::Peridynamics(paper_lattice(DX, Placement::CellCentred));
    let measured = errors(kind, h, node_area, island).map(|error| 100.0 * error);
    for (measured, printed) in measured.into_iter().zip(percent) {
        assert!(
            (measured - printed).abs() <= 0.005,
            "{kind:?}, h = {h} dx, {node_area:?}: {measured:.4} % for {printed} %"
        );
    }
}

#[test]
fn elements_in_the_island_are_exact() {
    for kind in CellKind::ALL {
        for error in errors(kind, 4, NodeArea::Lumped, Method::FiniteElements) {
            assert!(error <= 2e-14, "{kind:?}: {error:e}");
        }
    }
}

#[test]
fn four_node_elements_of_four_spacings() {
    assert_errors(CellKind::Quad4, 4, NodeArea::Lumped, [8.20, 8.57, 2.84]);
    assert_errors(CellKind::Quad4, 4, NodeArea::HalfEdge, [8.66, 8.91, 3.27]);
}

#[test]
fn eight_node_elements_of_four_spacings() {
    assert_errors(CellKind::Quad8, 4, NodeArea::Lumped, [5.25, 5.47, 2.65]);
    assert_errors(CellKind::Quad8, 4, NodeArea::HalfEdge, [5.21, 5.41, 2.21]);
}

#[test]
fn four_node_elements_of_two_spacings() {
    assert_errors(CellKind::Quad4, 2, NodeArea::Lumped, [4.51, 4.66, 1.69]);
    assert_errors(CellKind::Quad4, 2, NodeArea::HalfEdge, [4.88, 5.03, 1.54]);
}

#[test]
fn eight_node_elements_of_two_spacings() {
    assert_errors(CellKind::Quad8, 2, NodeArea::Lumped, [4.67, 5.97, 2.94]);
    assert_errors(CellKind::Quad8, 2, NodeArea::HalfEdge, [4.14, 4.27, 0.95]);
}

/// The areas A_FE of `half-edge` sum to the interface's length times dx, on linear and on quadratic edges. A truss
/// has k = c(ξ) A_FE A_j h_t / ξ, so that each node's area is found from its trusses.
#[test]
fn areas_by_half_edges_sum_to_the_interface_times_the_spacing() {
    for kind in CellKind::ALL {
        let mut mesh = Grid {
            size: [28.0 * DX, 24.0 * DX],
            count: [7, 6],
            kind,
        }
        .plain();
        let within = |[x, y]: [f64; 2]| {
            (8.0 * DX..20.0 * DX).contains(&x) && (8.0 * DX..16.0 * DX).contains(&y)
        };
        name_cells(&mut mesh, "island", within);
        name_cells(&mut mesh, "around", |x| !within(x));
        let lattice = paper_lattice(DX, Placement::CellCentred);
        let regions = vec![
            region(&mesh, &["around"], steel(), Method::FiniteElements),
            region(&mesh, &["island"], steel(), Method::Peridynamics(lattice)),
        ];
        let settings = ModelSettings {
            plane: PlaneState::Stress,
            thickness: 0.7,
            coupling: Coupling::Truss(NodeArea::HalfEdge),
        };
        let model = Model::build(mesh, regions, settings).expect("a sound model");
        let micromodulus = &model.points[0].micromodulus;
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for truss in model.interactions.trusses() {
            let [a, b] = model.interactions.segment(truss, &model.positions);
            let along = [b[0] - a[0], b[1] - a[1]];
            let unit = micromodulus.axial_stiffness(along, [1.0, DX * DX], 0.7);
            if unit > 0.0 {
                let area = model.interactions.stiffness[truss] / unit;
                areas.insert(model.interactions.nodes(truss)[0], area);
            }
        }
        let sum: f64 = areas.values().sum();
        // The interface is 40 dx long; sums of some twenty quotients.
        assert!(
            (sum / (40.0 * DX * DX) - 1.0).abs() < 1e-12,
            "{kind:?}: {sum}"
        );
    }
}
