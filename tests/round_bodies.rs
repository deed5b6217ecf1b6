//! Curved second-order sides against closed forms: a disc under pressure, Lamé's thick-walled cylinder with
//! pressure in its hole, and a circular inclusion in a plate in tension (Goodier 1933, Eshelby 1957), each in
//! finite elements and on material points.

mod common;

use common::*;
use peristitch::boundary::{Boundary, Directions};
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::fem::edge::EdgeLoad;
use peristitch::fields::NodalFields;
use peristitch::fields::points::PointFields;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::patchwork::{Patch, on_circle, on_square, patchwork};
use peristitch::mesh::{CellKind, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::verification::bodies::{default_lattice, solve};

const NU: f64 = 1.0 / 3.0;

/// A map of the unit square, and how many elements it is cut into each way.
type Part<F> = (F, [usize; 2]);
type Map = fn([f64; 2]) -> [f64; 2];

fn rock(young: f64) -> Material {
    Material { young, poisson: NU }
}

fn between(a: [f64; 2], b: [f64; 2], s: f64) -> [f64; 2] {
    [0, 1].map(|k| (1.0 - s) * a[k] + s * b[k])
}

/// A ring between two circles, or from a circle to a square, in four patches.
fn ring(
    count: [usize; 2],
    inner: f64,
    outer: f64,
    square: bool,
) -> Vec<Part<impl Fn([f64; 2]) -> [f64; 2]>> {
    (0..4)
        .map(|quarter| {
            let map = move |[s, t]: [f64; 2]| {
                let t = 2.0 * t - 1.0;
                let out = if square {
                    on_square(outer, t, quarter)
                } else {
                    on_circle(outer, t, quarter)
                };
                between(on_circle(inner, t, quarter), out, s)
            };
            (map, count)
        })
        .collect()
}

/// A square within a circle, and what is between them.
fn core(count: usize, radius: f64) -> Vec<Part<impl Fn([f64; 2]) -> [f64; 2]>> {
    let h = 0.5 * radius;
    (0..5)
        .map(move |part| {
            let map = move |[s, t]: [f64; 2]| {
                if part == 4 {
                    return [h * (2.0 * s - 1.0), h * (2.0 * t - 1.0)];
                }
                let t = 2.0 * t - 1.0;
                between(on_square(h, t, part), on_circle(radius, t, part), s)
            };
            let count = if part == 4 {
                [count, count]
            } else {
                [count / 2, count]
            };
            (map, count)
        })
        .collect()
}

fn mesh_of<F: Fn([f64; 2]) -> [f64; 2], G: Fn([f64; 2]) -> [f64; 2]>(
    kind: CellKind,
    size: f64,
    inner: &[(F, [usize; 2])],
    outer: &[(G, [usize; 2])],
) -> Mesh {
    let mut patches: Vec<Patch> = Vec::new();
    patches.extend(
        inner
            .iter()
            .map(|(map, count)| Patch { count: *count, map }),
    );
    patches.extend(
        outer
            .iter()
            .map(|(map, count)| Patch { count: *count, map }),
    );
    patchwork(kind, size, &patches)
}

fn radius([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Held such that it can do no more than grow: its axes do not turn.
fn free_of_rotation(model: &Model, mesh_points: [&str; 2]) -> Boundary {
    let mut boundary = Boundary::new(model);
    let hold = |b: &mut Boundary, group: &str, components| {
        b.displace(model, group, components).expect("a point");
    };
    hold(&mut boundary, mesh_points[0], [None, Some(0.0)]);
    hold(&mut boundary, mesh_points[1], [Some(0.0), None]);
    boundary
}

/// Uniform stress −p: u = −(1 − ν) p r/E, to rounding on curved sides, for the load is consistent on them.
#[test]
fn a_disc_of_curved_elements_under_pressure_is_uniform() {
    for kind in [CellKind::Quad8, CellKind::Quad4] {
        let none: [Part<Map>; 0] = [];
        let mut mesh = mesh_of(kind, 1.0, &core(4, 1.0), &none);
        name_cells(&mut mesh, "disc", |_| true);
        name_curve(&mut mesh, "rim", |x| radius(x) > 0.999);
        for (name, at) in [
            ("east", [1.0, 0.0]),
            ("west", [-1.0, 0.0]),
            ("north", [0.0, 1.0]),
        ] {
            let node = nearest(&mesh.nodes, at);
            mesh.points.insert(name.to_owned(), vec![node]);
        }
        let disc = region(&mesh, &["disc"], rock(1.0), Method::FiniteElements);
        let model = build(mesh, vec![disc], PlaneState::Stress);
        let mut boundary = free_of_rotation(&model, ["east", "north"]);
        boundary
            .displace(&model, "west", [None, Some(0.0)])
            .expect("a point");
        boundary
            .add_traction(&model, "rim", EdgeLoad::Pressure(1e-3))
            .expect("a load");
        let u = solve(&model, &boundary).expect("a solution").displacement;
        let exact = |x: [f64; 2]| x.map(|x| -1e-3 * (1.0 - NU) * x);
        let error = relative_error(&model, &u, exact);
        // As the patch test: curved sides are no more than quadratic, as the elements are.
        assert!(error < 1e-12, "{kind:?} {error:e}");
    }
}

/// Inner and outer radius of the cylinder [m].
const RADII: [f64; 2] = [1.0, 3.0];

/// Radial displacement under a unit pressure inside, E = 1, plane stress.
fn lame(r: f64) -> f64 {
    let [a, b] = RADII.map(|r| r * r);
    a / (b - a) * ((1.0 - NU) * r + (1.0 + NU) * b / r)
}

fn cylinder() -> Mesh {
    let none: [Part<Map>; 0] = [];
    let mut mesh = mesh_of(
        CellKind::Quad8,
        3.0,
        &ring([12, 12], RADII[0], RADII[1], false),
        &none,
    );
    name_cells(&mut mesh, "wall", |_| true);
    name_curve(&mut mesh, "hole", |x| radius(x) < 1.001);
    name_curve(&mut mesh, "rim", |x| radius(x) > 2.99);
    mesh
}

/// (r, u_r/Lamé − 1) of nodes that are away from the surfaces.
fn radial_errors(method: Method, margin: f64) -> Vec<[f64; 2]> {
    let mesh = cylinder();
    let wall = region(&mesh, &["wall"], rock(1.0), method);
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling: Coupling::Truss(NodeArea::Lumped),
    };
    let model = Model::build(mesh, vec![wall], settings).expect("a sound model");
    let mut boundary = Boundary::new(&model);
    // Nothing turns along the rim, and the mean motion is prevented by symmetric points.
    boundary
        .displace_along(&model, "rim", Directions::Curve, [None, Some(0.0)])
        .expect("a curve");
    boundary
        .add_traction(&model, "hole", EdgeLoad::Pressure(1.0))
        .expect("a load");
    let model = model.with_node_axes(&boundary.node_axes);
    let u = solve(&model, &boundary).expect("a solution").displacement;
    let within = RADII[0] + margin..RADII[1] - margin;
    let nodes = model.positions.iter().zip(&u);
    nodes
        .filter(|(x, _)| within.contains(&radius(**x)))
        .map(|(x, u)| {
            let r = radius(*x);
            [r, (x[0] * u[0] + x[1] * u[1]) / r / lame(r) - 1.0]
        })
        .collect()
}

fn largest(errors: &[[f64; 2]]) -> f64 {
    errors.iter().map(|e| e[1].abs()).fold(0.0, f64::max)
}

/// Rollers along the rim leave Lamé's field alone, since nothing moves along it.
#[test]
fn the_thick_walled_cylinder_of_lame() {
    let elements = radial_errors(Method::FiniteElements, 0.0);
    println!("elements {:e}", largest(&elements));
    assert!(largest(&elements) < 2e-4);
    let mut before = f64::INFINITY;
    for (per_radius, within) in [(10, 0.05), (20, 0.03), (40, 0.02)] {
        let settings = default_lattice(1.0 / f64::from(per_radius));
        let errors = radial_errors(Method::Peridynamics(settings), 0.4);
        for r in [1.4, 1.7, 2.0, 2.5] {
            let near = errors.iter().filter(|e| (e[0] - r).abs() < 0.1);
            let (low, high) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| {
                (l.min(e[1]), h.max(e[1]))
            });
            println!("r = {r}: {low:e} {high:e}");
        }
        let error = largest(&errors);
        println!("points, a = {per_radius} dx: {error:e}");
        assert!(error < within && error < before, "{per_radius} {error:e}");
        before = error;
    }
}

/// A circular inclusion of radius 1 with E₁ in an endless plate with E = 1, both with ν = 1/3, under σ_xx = 1.
struct Inclusion {
    young: f64,
}

impl Inclusion {
    /// Coefficients of φ = ¼ (z + a/z), ψ = −½ (z + b/z − ½ a/z³) outside; φ = α z, ψ = β z inside:
    /// continuity of φ + z φ̄' + ψ̄ and of (κφ − z φ̄' − ψ̄)/2μ on |z| = 1.
    fn coefficients(&self) -> [f64; 4] {
        let kappa = (3.0 - NU) / (1.0 + NU);
        let ratio = self.young;
        let a = 2.0 * (1.0 - ratio) / (ratio * kappa + 1.0);
        let b = (kappa - 1.0) * (1.0 - ratio) / (2.0 * ratio + kappa - 1.0);
        [a, b, 0.25 * (1.0 - b), 0.25 * (a - 2.0)]
    }

    /// σ_xx and σ_yy within, the same everywhere.
    fn stress(&self) -> [f64; 2] {
        let [_, _, alpha, beta] = self.coefficients();
        [2.0 * alpha - beta, 2.0 * alpha + beta]
    }

    /// u outside.
    fn displacement(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let kappa = (3.0 - NU) / (1.0 + NU);
        let mu = 0.5 / (1.0 + NU);
        let [a, b, ..] = self.coefficients();
        let (r, t) = (x.hypot(y), y.atan2(x));
        // Terms r^p e^{iqθ} of 2μ(u + iv).
        let term =
            |c: f64, p: i32, q: f64| [c * r.powi(p) * (q * t).cos(), c * r.powi(p) * (q * t).sin()];
        let terms = [
            term(0.25 * kappa, 1, 1.0),
            term(0.25 * kappa * a, -1, -1.0),
            term(-0.25, 1, 1.0),
            term(0.25 * a, -1, 3.0),
            term(0.5, 1, -1.0),
            term(0.5 * b, -1, 1.0),
            term(-0.25 * a, -3, 3.0),
        ];
        [0, 1].map(|k| terms.iter().map(|t| t[k]).sum::<f64>() / (2.0 * mu))
    }
}

/// A plate of the half-side 4 with the inclusion, and elements around |x| = 3 where the rest is points.
fn plate() -> Mesh {
    let inner = core(8, 1.0);
    let mut outer = Vec::new();
    for (from, to) in [(1.0, 3.0), (3.0, 4.0)] {
        for quarter in 0..4 {
            let map = move |[s, t]: [f64; 2]| {
                let t = 2.0 * t - 1.0;
                let near = if from == 1.0 {
                    on_circle(from, t, quarter)
                } else {
                    on_square(from, t, quarter)
                };
                between(near, on_square(to, t, quarter), s)
            };
            let map: Box<dyn Fn([f64; 2]) -> [f64; 2]> = Box::new(map);
            outer.push((map, [if from == 1.0 { 8 } else { 3 }, 8]));
        }
    }
    let mut mesh = mesh_of(CellKind::Quad8, 4.0, &inner, &outer);
    name_cells(&mut mesh, "inclusion", |x| radius(x) < 1.0);
    let side = |[x, y]: [f64; 2]| x.abs().max(y.abs());
    name_cells(&mut mesh, "matrix", move |x| {
        radius(x) > 1.0 && side(x) < 3.0
    });
    name_cells(&mut mesh, "frame", move |x| side(x) > 3.0);
    mesh
}

/// Mean σ_xx and σ_yy of the nodes or points of the inclusion within r < 0.6.
fn stress_within(inclusion: &Inclusion, method: Method) -> [f64; 2] {
    let mesh = plate();
    let regions = vec![
        region(&mesh, &["inclusion"], rock(inclusion.young), method),
        region(&mesh, &["matrix"], rock(1.0), method),
        region(&mesh, &["frame"], rock(1.0), Method::FiniteElements),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling: Coupling::Clip,
    };
    let model = Model::build(mesh, regions, settings).expect("a sound model");
    let boundary = hold_outline(&model, |x| inclusion.displacement(x));
    let u = solve(&model, &boundary).expect("a solution").displacement;
    let mut inside: Vec<[f64; 2]> = Vec::new();
    if method == Method::FiniteElements {
        let fields = NodalFields::new(&model, &u);
        let positions = fields
            .nodes
            .iter()
            .map(|&node| model.positions[node as usize]);
        inside.extend(
            positions
                .zip(&fields.stress)
                .filter(|(x, _)| radius(*x) < 0.6)
                .map(|(_, s)| [s[0], s[1]]),
        );
    } else {
        let fields = PointFields::new(&model, &u, &model.integrity);
        let positions = model.positions[model.fe_node_count()..].iter();
        inside.extend(
            positions
                .zip(&fields.stress)
                .filter(|(x, _)| radius(**x) < 0.6)
                .map(|(_, s)| [s[0], s[1]]),
        );
    }
    [0, 1].map(|k| inside.iter().map(|s| s[k]).sum::<f64>() / inside.len() as f64)
}

#[test]
fn the_closed_form_of_the_inclusion_is_that_of_a_hole_and_of_a_plate() {
    let hole = Inclusion { young: 0.0 };
    assert_eq!(hole.coefficients()[..2], [2.0, 1.0]);
    assert_eq!(hole.stress(), [0.0, 0.0]);
    let [xx, yy] = Inclusion { young: 1.0 }.stress();
    assert!((xx - 1.0).abs() < 1e-15 && yy.abs() < 1e-15);
    // Nothing but tension far away: u_x = x.
    let [u, _] = Inclusion { young: 5.0 }.displacement([1e6, 0.0]);
    assert!((u / 1e6 - 1.0).abs() < 1e-11);
}

/// The stress within is uniform, as Eshelby's theorem has it.
#[test]
fn a_stiff_and_a_soft_inclusion() {
    for young in [4.0, 0.25] {
        let inclusion = Inclusion { young };
        let exact = inclusion.stress();
        let error = |found: [f64; 2]| [0, 1].map(|k| (found[k] - exact[k]) / exact[0]);
        let elements = error(stress_within(&inclusion, Method::FiniteElements));
        println!("E₁ = {young}: {exact:?}, elements {elements:?}");
        assert!(elements.iter().all(|e| e.abs() < 2e-3), "{elements:?}");
        for (per_radius, within) in [(10.0, 0.03), (20.0, 0.015)] {
            let settings: PeridynamicSettings = default_lattice(1.0 / per_radius);
            let points = error(stress_within(&inclusion, Method::Peridynamics(settings)));
            println!("E₁ = {young}: points, radius {per_radius} dx {points:?}");
            assert!(points.iter().all(|e| e.abs() < within), "{points:?}");
        }
    }
}
