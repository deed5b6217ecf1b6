//! The splice passes the patch test: an island of material points within finite elements, displacements of
//! exact fields prescribed around the outside.
//!
//! ```text
//!   ┌───────────────┐
//!   │   elements    │  δ = 4 dx or more on every side, h = dx … 4 dx, Q8, Q4, T6, T3
//!   │   ┌·······┐   │
//!   │   · island ·  │  a rectangle, or an L with a re-entrant corner
//!   │   └·······┘   │
//!   └───────────────┘
//! ```
//!
//! max|u − u_exact| / max|u_exact| over all dofs. Linear fields, any kernel and any position of the lattice;
//! quadratic fields without body force, 3u,xx + u,yy + 2v,xy = 0 and 3v,yy + v,xx + 2u,xy = 0, with Q8 and
//! the isotropised micromodulus, whose lattice has exactly the elements' moduli.

mod common;

use common::*;
use nalgebra::DMatrix;
use peristitch::assembly::full::FullPattern;
use peristitch::boundary::Boundary;
use peristitch::coupling::splice::SpliceError;
use peristitch::fem::edge::EdgeLoad;
use peristitch::gmsh::{self, Options};
use peristitch::mesh::Mesh;
use peristitch::model::{ModelError, Region};
use peristitch::phases::Phases;
use peristitch::statics;
use std::path::Path;

use peristitch::coupling::Coupling;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::Placement;

const DX: f64 = 2.5e-3;

/// Strains and a rotation.
const LINEAR: [Field; 4] = [
    |[x, _]| [x, 0.0],
    |[_, y]| [0.0, y],
    |[x, y]| [0.5 * y, 0.5 * x],
    |[x, y]| [-y, x],
];

/// The four independent ones: u = a x² + b xy + c y², v = d x² + e xy + f y² with 6a + 2c + 2e = 0 and
/// 6f + 2d + 2b = 0.
const QUADRATIC: [Field; 4] = [
    |[x, y]| [x * x - 3.0 * y * y, 0.0],
    |[x, y]| [x * x, -3.0 * x * y],
    |[x, y]| [0.0, y * y - 3.0 * x * x],
    |[x, y]| [-3.0 * x * y, y * y],
];

fn splice(mesh: Mesh, lattice: PeridynamicSettings, plane: PlaneState) -> Model {
    try_splice(mesh, lattice, plane).expect("a sound model")
}

fn try_splice(
    mesh: Mesh,
    lattice: PeridynamicSettings,
    plane: PlaneState,
) -> Result<Model, ModelError> {
    let mut material = steel();
    material.poisson = plane.bond_based_poisson();
    let regions: Vec<Region> = vec![
        region(&mesh, &["around"], material, Method::FiniteElements),
        region(&mesh, &["island"], material, Method::Peridynamics(lattice)),
    ];
    let settings = ModelSettings {
        plane,
        thickness: 0.7,
        coupling: Coupling::Splice,
    };
    Model::build(mesh, regions, settings)
}

fn isotropised(placement: Placement) -> PeridynamicSettings {
    PeridynamicSettings {
        isotropised: true,
        ..paper_lattice(DX, placement)
    }
}

/// A mesh of `count` cells of `h` spacings each, of which `inside` (in cells) are the island.
fn island(kind: CellKind, h: f64, count: [usize; 2], inside: impl Fn([f64; 2]) -> bool) -> Mesh {
    let grid = Grid {
        size: count.map(|n| n as f64 * h * DX),
        count,
        kind,
    };
    let mut mesh = grid.plain();
    let in_cells = |x: [f64; 2]| x.map(|x| x / (h * DX));
    name_cells(&mut mesh, "island", |x| inside(in_cells(x)));
    name_cells(&mut mesh, "around", |x| !inside(in_cells(x)));
    mesh
}

fn worst(model: &Model, fields: &[Field]) -> f64 {
    let errors = fields.iter().map(|&field| {
        let u = displacements(model, &hold_outline(model, field));
        relative_error(model, &u, field)
    });
    errors.fold(0.0, f64::max)
}

/// Cells around the island: δ or more of elements.
fn ring(h: f64) -> usize {
    (4.0 / h).ceil() as usize
}

/// An island of `cells` cells, of which the upper right quadrant is taken away for an L.
fn model(kind: CellKind, h: f64, cells: usize, l: bool, lattice: PeridynamicSettings) -> Model {
    let ring = ring(h);
    let (low, high) = (ring as f64, (ring + cells) as f64);
    let middle = low + (cells / 2 + cells % 2) as f64;
    let inside = |[x, y]: [f64; 2]| {
        let within = low < x && x < high && low < y && y < high;
        within && !(l && x > middle && y > middle)
    };
    let mesh = island(kind, h, [2 * ring + cells; 2], inside);
    splice(mesh, lattice, PlaneState::Stress)
}

#[test]
fn linear_fields_in_rectangles_and_l_shapes_of_every_element() {
    for kind in CellKind::ALL {
        for (h, cells) in [(1.0, 12), (2.0, 8), (2.5, 6), (3.0, 5), (4.0, 5)] {
            for l in [false, true] {
                for placement in [Placement::CellCentred, Placement::GridNodes] {
                    let model = model(kind, h, cells, l, paper_lattice(DX, placement));
                    let error = worst(&model, &LINEAR);
                    assert!(
                        error <= 1e-12,
                        "{kind:?} h = {h} L {l} {placement:?}: {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn quadratic_fields_with_the_isotropised_micromodulus_alone() {
    for (h, cells) in [(1.0, 12), (2.0, 8), (2.5, 6), (4.0, 5)] {
        for l in [false, true] {
            for placement in [Placement::CellCentred, Placement::GridNodes] {
                let model = model(CellKind::Quad8, h, cells, l, isotropised(placement));
                let error = worst(&model, &QUADRATIC);
                assert!(error <= 1e-12, "h = {h} L {l} {placement:?}: {error:e}");
            }
        }
    }
    let raw = paper_lattice(DX, Placement::CellCentred);
    let error = worst(&model(CellKind::Quad8, 2.0, 8, false, raw), &QUADRATIC);
    assert_between(error, 1e-3, 1e-2, "the raw micromodulus");
}

/// Islands of 4 × 4 cells, turned by some degrees against the lattice, which is anchored at their box: no
/// row of points is at any special place. The last is as wide as 15.25 dx.
#[test]
fn turned_and_shifted_islands() {
    for kind in CellKind::ALL {
        for (degrees, h) in [(20.0, 4.0), (20.0, 2.7), (45.0, 3.0), (0.0, 3.8125)] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let rings = ring(h);
            let count = 4 + 2 * rings;
            let (low, high) = (rings as f64, rings as f64 + 4.0);
            let inside = |[x, y]: [f64; 2]| low < x && x < high && low < y && y < high;
            let mut mesh = island(kind, h, [count; 2], inside);
            for [x, y] in &mut mesh.nodes {
                (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
            }
            let model = splice(
                mesh,
                isotropised(Placement::CellCentred),
                PlaneState::Strain,
            );
            let linear = worst(&model, &LINEAR);
            assert!(
                linear <= 1e-12,
                "{kind:?}, {degrees}°, h = {h} dx: {linear:e}"
            );
        }
    }
    let (sin, cos) = f64::to_radians(20.0).sin_cos();
    let inside = |[x, y]: [f64; 2]| 2.0 < x && x < 7.0 && 2.0 < y && y < 7.0;
    let mut mesh = island(CellKind::Quad8, 2.7, [9; 2], inside);
    for [x, y] in &mut mesh.nodes {
        (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
    }
    let model = splice(
        mesh,
        isotropised(Placement::CellCentred),
        PlaneState::Stress,
    );
    let quadratic = worst(&model, &QUADRATIC);
    assert!(quadratic <= 1e-12, "{quadratic:e}");
}

/// A lattice turned against the mesh, whose corner lies anywhere.
#[test]
fn turned_and_shifted_lattices() {
    let mut lattice = isotropised(Placement::CellCentred);
    lattice.lattice.angle = f64::to_radians(20.0);
    lattice.lattice.origin = Some([0.3 * DX, 0.2 * DX]);
    for (kind, h, cells) in [
        (CellKind::Quad8, 2.5, 6),
        (CellKind::Quad8, 4.0, 5),
        (CellKind::Quad4, 1.0, 14),
        (CellKind::Tri6, 4.0, 5),
        (CellKind::Tri3, 2.0, 8),
    ] {
        for l in [false, true] {
            let model = model(kind, h, cells, l, lattice);
            let linear = worst(&model, &LINEAR);
            assert!(linear <= 1e-12, "{kind:?}, h = {h} dx, L {l}: {linear:e}");
            if kind == CellKind::Quad8 {
                let quadratic = worst(&model, &QUADRATIC);
                assert!(quadratic <= 1e-12, "h = {h} dx, L {l}: {quadratic:e}");
            }
        }
    }
}

fn meshed(geometry: &str, parameters: &[(&str, f64)]) -> Mesh {
    let options = Options {
        worker: Some(env!("CARGO_BIN_EXE_peristitch").into()),
        ..Options::default()
    };
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/geo")
        .join(geometry);
    let values = parameters
        .iter()
        .map(|&(name, value)| (name.to_owned(), value.into()));
    let extract = gmsh::mesh(&file, &values.collect(), &options).expect("a mesh");
    let mut mesh = extract.to_mesh(1e-3).expect("a mesh of known elements");
    for (from, to) in [("plate", "around"), ("disc", "island")] {
        let cells = mesh.surfaces[from].clone();
        mesh.surfaces.insert(to.to_owned(), cells);
    }
    mesh
}

/// Unstructured meshes around a circle of curved edges, and around a pentagon.
#[test]
fn circular_and_polygonal_islands_in_unstructured_meshes() {
    for (geometry, parameters) in [
        ("disc.geo", vec![]),
        ("pentagon.geo", vec![("order", 2.0), ("quads", 0.0)]),
        ("pentagon.geo", vec![("order", 1.0), ("quads", 0.0)]),
        ("pentagon.geo", vec![("order", 1.0), ("quads", 1.0)]),
    ] {
        let mut lattice = isotropised(Placement::CellCentred);
        lattice.lattice.spacing = 1e-3;
        let model = splice(meshed(geometry, &parameters), lattice, PlaneState::Stress);
        let error = worst(&model, &LINEAR);
        assert!(error <= 1e-11, "{geometry} {parameters:?}: {error:e}");
    }
}

#[test]
fn a_free_body_has_three_zero_singular_values() {
    for (kind, h, cells) in [
        (CellKind::Quad8, 4.0, 3),
        (CellKind::Quad4, 2.0, 5),
        (CellKind::Tri6, 4.0, 3),
    ] {
        let model = model(kind, h, cells, false, isotropised(Placement::CellCentred));
        let equations = model.equations(model.splice.as_ref().expect("an interface"));
        let first_point = model.fe_node_count() as u32;
        let pattern = FullPattern::new(model.node_count(), first_point, &model.springs, &equations);
        let sparse = pattern.assemble(&model.positions, &model.springs, &equations);
        let dense = DMatrix::from_fn(sparse.nrows(), sparse.ncols(), |i, j| {
            sparse.get(i, j).copied().unwrap_or(0.0)
        });
        let asymmetry = (&dense - dense.transpose()).amax() / dense.amax();
        let mut values: Vec<f64> = dense.singular_values().iter().copied().collect();
        values.sort_unstable_by(f64::total_cmp);
        let largest = values[values.len() - 1];
        // Rounding leaves some 1e-16 of the largest; the fourth is that of the softest deformation.
        assert!(
            values[2] < 1e-14 * largest,
            "{kind:?}: {:e}",
            values[2] / largest
        );
        assert!(
            values[3] > 1e-5 * largest,
            "{kind:?}: {:e}",
            values[3] / largest
        );
        assert!(asymmetry > 0.05, "{kind:?}: {asymmetry}");
    }
}

/// |ΣF| / Σ|F| of the reactions around the outside: the forces of the two sides on each other are equal to
/// the order of the scheme only. Zero where the field is exact.
#[test]
fn overall_imbalance() {
    let imbalance = |field: &dyn Fn([f64; 2]) -> [f64; 2]| {
        let model = model(
            CellKind::Quad8,
            4.0,
            5,
            false,
            isotropised(Placement::CellCentred),
        );
        let boundary = hold_outline(&model, field);
        let solution =
            statics::solve(&model, &boundary, &mut Phases::default()).expect("a solution");
        let (mut sum, mut all) = ([0.0; 2], 0.0);
        for [x, y] in solution.reaction {
            sum = [sum[0] + x, sum[1] + y];
            all += x.hypot(y);
        }
        sum[0].hypot(sum[1]) / all
    };
    let size = 28.0 * DX;
    let linear = imbalance(&|[x, _]| [x, 0.0]);
    let quadratic = imbalance(&QUADRATIC[1]);
    // Waves around the outside, twice as long as the body, as long, and half as long, that is 14 dx.
    let wave = |n: f64| {
        move |[x, y]: [f64; 2]| {
            let k = 2.0 * std::f64::consts::PI * n / size;
            [
                (k * x + 0.3).sin() * (k * y).cos(),
                (k * y - 0.7).sin() * (0.5 * k * x).cos(),
            ]
        }
    };
    let waves = [0.5, 1.0, 2.0].map(|n| imbalance(&wave(n)));
    assert!(
        linear < 1e-13 && quadratic < 1e-13,
        "{linear:e} {quadratic:e}"
    );
    // Sums of a fixed lattice: half a unit of the last digit printed.
    for (found, measured) in waves.into_iter().zip([3.12e-4, 4.39e-4, 3.58e-4]) {
        assert_between(found, measured - 5e-7, measured + 5e-7, "waves");
    }
}

/// A bar whose middle is a block of points, all of it on rollers, pressed from above: the supports' and
/// the loads' part on the overlap counts once.
#[test]
fn supports_and_loads_along_both_sides() {
    for kind in [CellKind::Quad4, CellKind::Quad8, CellKind::Tri6] {
        let grid = Grid {
            size: [60.0 * DX, 24.0 * DX],
            count: [15, 6],
            kind,
        };
        let mut mesh = grid.plain();
        let within = |[x, _]: [f64; 2]| 20.0 * DX < x && x < 40.0 * DX;
        name_cells(&mut mesh, "island", within);
        name_cells(&mut mesh, "around", |x| !within(x));
        name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
        name_curve(&mut mesh, "top", |[_, y]| y > 24.0 * DX - 1e-9);
        name_curve(&mut mesh, "left", |[x, _]| x < 1e-9);
        let model = splice(
            mesh,
            isotropised(Placement::CellCentred),
            PlaneState::Stress,
        );
        let mut boundary = Boundary::new(&model);
        boundary
            .displace(&model, "bottom", [None, Some(0.0)])
            .expect("a curve");
        boundary
            .displace(&model, "left", [Some(0.0), None])
            .expect("a curve");
        boundary
            .press(&model, "top", EdgeLoad::Pressure(3e6))
            .expect("a curve");
        let applied: f64 = boundary.load.iter().skip(1).step_by(2).sum();
        let total = -3e6 * 60.0 * DX * 0.7;
        assert!(
            (applied / total - 1.0).abs() < 1e-12,
            "{applied} for {total}"
        );
        let solution =
            statics::solve(&model, &boundary, &mut Phases::default()).expect("a solution");
        let sums = statics::group_reactions(&boundary, &solution.reaction);
        let error = -sums["bottom"][1] / total - 1.0;
        // Points near the free sides miss part of their families, so that the stress is not uniform and the two
        // sides' forces differ: measured −4.0e-3, 2.2e-4, 2.9e-4. Counted twice, the overlap would add 7e-2.
        assert!(error.abs() < 1e-2, "{kind:?}: {error:e}");
    }
}

fn error_of(h: f64, rings: usize, cells: [usize; 2]) -> SpliceError {
    let inside = |[x, y]: [f64; 2]| {
        let r = rings as f64;
        r < x && x < r + cells[0] as f64 && r < y && y < r + cells[1] as f64
    };
    let mesh = island(CellKind::Quad4, h, cells.map(|n| n + 2 * rings), inside);
    match try_splice(
        mesh,
        isotropised(Placement::CellCentred),
        PlaneState::Stress,
    ) {
        Err(ModelError::Splice { source, region }) => {
            assert_eq!(region, "island");
            source
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_cannot_be_spliced_is_told() {
    // 3 dx of elements for bonds of up to 4 dx.
    assert!(matches!(
        error_of(1.0, 3, [12, 12]),
        SpliceError::NarrowRing { .. }
    ));
    // One element between two interfaces, and elements in the middle that are all within 2 dx of one.
    assert!(matches!(
        error_of(8.0, 1, [1, 3]),
        SpliceError::Bridged { .. }
    ));
    assert!(matches!(
        error_of(1.0, 4, [3, 12]),
        SpliceError::Bridged { .. }
    ));
    // Rows of points for one block are too few.
    assert!(matches!(
        error_of(1.5, 3, [12, 2]),
        SpliceError::NoBlock { .. } | SpliceError::Bridged { .. }
    ));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let lattice = isotropised(Placement::CellCentred);
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("a pool").install(|| {
            let model = model(CellKind::Quad8, 2.5, 12, true, lattice);
            let boundary = hold_outline(&model, |[x, y]| [(90.0 * x).sin(), (70.0 * y).cos()]);
            let solution = statics::solve(&model, &boundary, &mut Phases::default());
            let solution = solution.expect("a solution");
            let bits = |list: &[[f64; 2]]| list.iter().flatten().map(|x| x.to_bits()).collect();
            [&solution.displacement, &solution.reaction].map(|list| -> Vec<u64> { bits(list) })
        })
    };
    let one = solve(1);
    assert!(one == solve(2) && one == solve(3));
}
