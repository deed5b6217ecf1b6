//! Every option of a pipeline that changes the numbers changes them as it should: the bar of Table 1 on a
//! coarse lattice, through the binary, against the same sums written out densely here.
//!
//! ```text
//!   1000 × 200 mm, dx = 50 mm, m = 3, clamped on the left, 1.05 MPa on the right
//!   all bonds, on 21 × 5 grid nodes or 20 × 4 cell centres; or columns 9 to 11 of the grid nodes as
//!   points and four-node squares of 50 mm left and right of them
//! ```

mod workplace;

use nalgebra::{DMatrix, DVector};
use peristitch::fem::element;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::CellKind;
use std::f64::consts::PI;
use workplace::Workplace;

const DX: f64 = 0.05;
const M: f64 = 3.0;
const HEIGHT: f64 = 0.2;
const YOUNG: f64 = 100e9;
const TRACTION: f64 = 1.05e6;

/// Word, g(r), c0 δ³/E in plane stress and in plane strain.
type KernelCase = (&'static str, fn(f64) -> f64, f64, f64);

const KERNELS: [KernelCase; 5] = [
    (
        "quartic",
        |r| (1.0 - r * r).max(0.0).powi(2),
        315.0 / 8.0 / PI,
        42.0 / PI,
    ),
    ("constant", |_| 1.0, 9.0 / PI, 9.6 / PI),
    ("linear", |r| (1.0 - r).max(0.0), 36.0 / PI, 38.4 / PI),
    (
        "parabolic",
        |r| (1.0 - r * r).max(0.0),
        22.5 / PI,
        24.0 / PI,
    ),
    ("inverse", |r| 1.0 / r, 6.0 / PI, 6.4 / PI),
];

/// A_FE at a node inside the interface, over dx².
#[derive(Clone, Copy)]
enum NodeArea {
    Lumped,
    HalfEdge,
    Given(f64),
}

#[derive(Clone, Copy)]
struct Case {
    kernel: KernelCase,
    strain: bool,
    hhb: bool,
    grid_nodes: bool,
    clipped: bool,
    isotropised: bool,
    surface: &'static str,
    hybrid: Option<NodeArea>,
}

const PAPER: Case = Case {
    kernel: KERNELS[0],
    strain: false,
    hhb: false,
    grid_nodes: true,
    clipped: false,
    isotropised: false,
    surface: "none",
    hybrid: None,
};

/// An inner point's neighbours and more, in dx.
fn family() -> impl Iterator<Item = [f64; 2]> {
    let steps = -4..=4;
    let all = steps
        .clone()
        .flat_map(move |y| steps.clone().map(move |x| [x, y]));
    all.filter(|bond| *bond != [0, 0])
        .map(|bond| bond.map(f64::from))
}

fn cos_4_phi([x, y]: [f64; 2]) -> f64 {
    (4.0 * y.atan2(x)).cos()
}

impl Case {
    fn poisson(&self) -> f64 {
        if self.strain { 1.0 / 4.0 } else { 1.0 / 3.0 }
    }

    /// Columns and rows.
    fn counts(&self) -> [usize; 2] {
        if self.grid_nodes { [21, 5] } else { [20, 4] }
    }

    /// What a lattice place is: a material point, or the node of an element.
    fn is_point(&self, column: usize) -> bool {
        self.hybrid.is_none() || (9..=11).contains(&column)
    }

    /// Area of a point, or A_FE of a node, over dx².
    fn area(&self, column: usize, row: usize) -> f64 {
        let [columns, rows] = self.counts();
        let end = |k: usize, count: usize| if k == 0 || k + 1 == count { 0.5 } else { 1.0 };
        let edge = end(row, rows);
        match self.hybrid {
            Some(area) if !self.is_point(column) => match area {
                NodeArea::Lumped => 0.5 * edge,
                NodeArea::HalfEdge => edge,
                NodeArea::Given(area) => area,
            },
            _ if self.grid_nodes && self.clipped => edge * end(column, columns),
            _ => 1.0,
        }
    }

    /// c of a bond of so many dx along x and y, without isotropisation [N/m⁵].
    fn raw_density(&self, [x, y]: [f64; 2]) -> f64 {
        let (_, g, stress, strain) = self.kernel;
        let length = x.hypot(y);
        let share = if self.hhb {
            (M + 0.5 - length).clamp(0.0, 1.0)
        } else {
            f64::from(length <= M)
        };
        let c0 = if self.strain { strain } else { stress } * YOUNG / (M * DX).powi(3);
        c0 * g(length / M) * share
    }

    /// a and b of a + b cos 4φ, from C11 = 9E/8 and C12 = 3E/8 (6E/5 and 2E/5) of the sum.
    fn isotropy(&self) -> [f64; 2] {
        if !self.isotropised {
            return [1.0, 0.0];
        }
        let mut sums = DMatrix::zeros(2, 2);
        for bond in family() {
            let length = bond[0].hypot(bond[1]);
            let n = bond.map(|x| x / length);
            let weight = 0.5 * self.raw_density(bond) * length * DX.powi(3);
            for (row, moment) in [n[0].powi(4), (n[0] * n[1]).powi(2)]
                .into_iter()
                .enumerate()
            {
                sums[(row, 0)] += weight * moment;
                sums[(row, 1)] += weight * moment * cos_4_phi(bond);
            }
        }
        let c12 = if self.strain { 0.4 } else { 0.375 } * YOUNG;
        let found = sums.lu().solve(&DVector::from_vec(vec![3.0 * c12, c12]));
        let found = found.expect("two independent equations");
        [found[0], found[1]]
    }

    fn density(&self, bond: [f64; 2]) -> f64 {
        let [a, b] = self.isotropy();
        self.raw_density(bond) * (a + b * cos_4_phi(bond))
    }

    /// What the family of a place has of a whole one, along x and along y: sums over the body, elements
    /// included.
    fn completeness(&self, column: usize, row: usize) -> [f64; 2] {
        let [columns, rows] = self.counts();
        let own = f64::from(self.surface == "volume");
        let (mut sum, mut whole) = ([own * self.body_share(column, row); 2], [own; 2]);
        for bond in family() {
            let length = bond[0].hypot(bond[1]);
            let c = self.density(bond);
            let weight = |axis: usize| {
                let n = bond[axis].abs() / length;
                match self.surface {
                    "volume" if c == 0.0 => 0.0,
                    "volume" if self.hhb => (M + 0.5 - length).clamp(0.0, 1.0),
                    "volume" => f64::from(length <= M),
                    "energy" => c * length * n.powi(4),
                    _ => c * n.powi(3),
                }
            };
            let (x, y) = (column as i64 + bond[0] as i64, row as i64 + bond[1] as i64);
            let inside = (0..columns as i64).contains(&x) && (0..rows as i64).contains(&y);
            let share = if inside {
                self.body_share(x as usize, y as usize)
            } else {
                0.0
            };
            for axis in 0..2 {
                sum[axis] += weight(axis) * share;
                whole[axis] += weight(axis);
            }
        }
        [sum[0] / whole[0], sum[1] / whole[1]]
    }

    /// Area of a place in the body over dx².
    fn body_share(&self, column: usize, row: usize) -> f64 {
        let [columns, rows] = self.counts();
        let end = |k: usize, count: usize| if k == 0 || k + 1 == count { 0.5 } else { 1.0 };
        if self.grid_nodes && self.clipped {
            end(column, columns) * end(row, rows)
        } else {
            1.0
        }
    }

    fn surface_factor(&self, bond: [f64; 2], i: [f64; 2], j: [f64; 2]) -> f64 {
        let length = bond[0].hypot(bond[1]);
        match self.surface {
            "none" => 1.0,
            "volume" => 2.0 / (i[0] + j[0]),
            _ => {
                let g = [0, 1].map(|axis| (1.0 / i[axis] + 1.0 / j[axis]) / 2.0);
                let [x, y] = [0, 1].map(|axis| bond[axis] / length / g[axis]);
                1.0 / x.hypot(y)
            }
        }
    }

    fn interactions(&self, k: &mut DMatrix<f64>) {
        let [columns, rows] = self.counts();
        let place = |n: usize| (n % columns, n / columns);
        let [iso_a, iso_b] = self.isotropy();
        let completeness: Vec<[f64; 2]> = (0..columns * rows)
            .map(|n| self.completeness(place(n).0, place(n).1))
            .collect();
        for a in 0..columns * rows {
            for b in a + 1..columns * rows {
                let ((ia, ja), (ib, jb)) = (place(a), place(b));
                let on_interface = |i: usize| i == 8 || i == 12;
                let joined = match (self.is_point(ia), self.is_point(ib)) {
                    (true, true) => true,
                    (true, false) => on_interface(ib),
                    (false, true) => on_interface(ia),
                    (false, false) => false,
                };
                if !joined {
                    continue;
                }
                let along = [ib as f64 - ia as f64, jb as f64 - ja as f64];
                let length = along[0].hypot(along[1]);
                let areas = self.area(ia, ja) * self.area(ib, jb) * DX.powi(4);
                let c = self.raw_density(along) * (iso_a + iso_b * cos_4_phi(along));
                let mut stiffness = c * areas / (length * DX);
                if self.is_point(ia) && self.is_point(ib) {
                    stiffness *= self.surface_factor(along, completeness[a], completeness[b]);
                }
                for (p, q, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                    for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        let n = along[x] * along[y] / (length * length);
                        k[(2 * p + x, 2 * q + y)] += sign * stiffness * n;
                    }
                }
            }
        }
    }

    fn elements(&self, k: &mut DMatrix<f64>) {
        let material = Material {
            young: YOUNG,
            poisson: self.poisson(),
        };
        let elasticity = material.elasticity(PlaneState::Stress);
        let square = [[0.0, 0.0], [DX, 0.0], [DX, DX], [0.0, DX]];
        let matrix = element::stiffness(CellKind::Quad4, &square, &elasticity, 1.0);
        for i in (0..8).chain(12..20) {
            for j in 0..4 {
                let nodes = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let dof = |d: usize| 2 * (nodes[d / 2].1 * 21 + nodes[d / 2].0) + d % 2;
                for (a, b) in (0..8).flat_map(|a| (0..8).map(move |b| (a, b))) {
                    k[(dof(a), dof(b))] += matrix[(a, b)];
                }
            }
        }
    }

    /// u_x at mid-height of the right end [m].
    fn expected(&self) -> f64 {
        let [columns, rows] = self.counts();
        let mut k = DMatrix::zeros(2 * columns * rows, 2 * columns * rows);
        self.interactions(&mut k);
        if self.hybrid.is_some() {
            self.elements(&mut k);
        }
        let mut load = DVector::zeros(k.nrows());
        let end = |row: usize| match self.hybrid {
            Some(_) if row == 0 || row + 1 == rows => 0.5,
            Some(_) => 1.0,
            None => self.area(columns - 1, row),
        };
        let whole: f64 = (0..rows).map(end).sum();
        for row in 0..rows {
            load[2 * (row * columns + columns - 1)] = TRACTION * HEIGHT * end(row) / whole;
            for dof in [2 * row * columns, 2 * row * columns + 1] {
                k.row_mut(dof).fill(0.0);
                k.column_mut(dof).fill(0.0);
                k[(dof, dof)] = 1.0;
            }
        }
        let u = k.cholesky().expect("positive definite").solve(&load);
        u[2 * ((rows / 2) * columns + columns - 1)]
    }

    fn pipeline(&self) -> String {
        let word = |chosen: bool, words: [&'static str; 2]| words[usize::from(chosen)];
        let area = match self.hybrid {
            Some(NodeArea::HalfEdge) => "half-edge".to_owned(),
            Some(NodeArea::Given(area)) => format!("{} mm^2", area * DX * DX * 1e6),
            _ => "lumped".to_owned(),
        };
        let elements = match self.hybrid {
            Some(_) => {
                "  - { group: left, model: fem, material: solid }\n  \
                 - { group: right, model: fem, material: solid }\n"
            }
            None => "",
        };
        let points = if self.hybrid.is_some() {
            "band"
        } else {
            "[left, band, right]"
        };
        format!(
            "\
name: bar
geometry: {{ file: geo/bar.geo, unit: mm, parameters: {{ element: 50, order: 1 }} }}
plane: {plane}
materials: {{ solid: {{ young: 100 GPa, poisson: {poisson} }} }}
regions:
{elements}  - group: {points}
    model: peridynamics
    material: solid
    spacing: 50 mm
    horizon: 3
    kernel: {kernel}
    points: {placement}
    cell_area: {cell_area}
    partial_area: {partial_area}
    micromodulus: {micromodulus}
    surface_correction: {surface}
coupling: {{ truss: {{ node_area: {area} }} }}
boundary:
  - {{ group: clamp, displacement: {{ x: 0, y: 0 }} }}
  - {{ group: load, traction: {{ x: 1.05 MPa }} }}
probes: {{ tip: {{ at: [1000 mm, 100 mm], component: x }} }}
output: {{ pictures: false }}
",
            plane = word(self.strain, ["stress", "strain"]),
            poisson = word(self.strain, ["1/3", "1/4"]),
            kernel = self.kernel.0,
            placement = word(self.grid_nodes, ["cell-centred", "grid-nodes"]),
            cell_area = word(self.clipped, ["full", "clipped"]),
            partial_area = word(self.hhb, ["full", "hhb"]),
            micromodulus = word(self.isotropised, ["raw", "isotropised"]),
            surface = self.surface,
        )
    }
}

fn tip(place: &Workplace) -> f64 {
    let tip = &place.summary()["probes"][0]["displacement_m"];
    tip.as_f64().expect("a number")
}

/// Runs the cases through the binary and compares; returns the displacements [m].
fn assert_cases(cases: &[Case]) -> Vec<f64> {
    let place = Workplace::new();
    let check = |case: &Case| {
        place.write("bar.yaml", case.pipeline());
        place.run(&[]);
        let (found, expected) = (tip(&place), case.expected());
        // Two factorisations of a matrix whose condition is some 1e4.
        let error = found / expected - 1.0;
        assert!(
            error.abs() < 1e-10,
            "{error:e}: {found:e} for {expected:e} m\n{}",
            case.pipeline()
        );
        found
    };
    cases.iter().map(check).collect()
}

/// No two options give the same displacement: the comparison tells them apart.
fn assert_all_differ(mut displacements: Vec<f64>) {
    displacements.sort_by(f64::total_cmp);
    let apart = |pair: &[f64]| pair[1] / pair[0] - 1.0 > 1e-5;
    assert!(displacements.windows(2).all(apart), "{displacements:?}");
}

#[test]
fn kernels_in_plane_stress_and_plane_strain() {
    let cases = KERNELS.map(|kernel| {
        [false, true].map(|strain| Case {
            kernel,
            strain,
            ..PAPER
        })
    });
    assert_all_differ(assert_cases(&cases.concat()));
}

#[test]
fn partial_areas() {
    let cases = KERNELS.map(|kernel| {
        [false, true].map(|hhb| Case {
            kernel,
            hhb,
            ..PAPER
        })
    });
    assert_all_differ(assert_cases(&cases.concat()));
}

#[test]
fn isotropised_micromoduli() {
    let mut cases = Vec::new();
    for kernel in KERNELS {
        for (strain, hhb) in [(false, false), (true, true)] {
            for isotropised in [false, true] {
                cases.push(Case {
                    kernel,
                    strain,
                    hhb,
                    isotropised,
                    ..PAPER
                });
            }
        }
    }
    assert_all_differ(assert_cases(&cases));
}

#[test]
fn surface_corrections() {
    let hybrid = Some(NodeArea::Lumped);
    for (clipped, hybrid) in [(false, None), (true, None), (false, hybrid)] {
        let cases = ["none", "volume", "energy", "force"].map(|surface| Case {
            clipped,
            hybrid,
            surface,
            isotropised: true,
            ..PAPER
        });
        assert_all_differ(assert_cases(&cases));
    }
}

/// Isotropised and corrected by force, if the pipeline says nothing; least squares differs from it.
#[test]
fn defaults_of_micromodulus_and_surface_correction() {
    let place = Workplace::new();
    let tip_of = |set: &str| {
        place.run(&["--set", &format!("regions.1.{set}")]);
        tip(&place)
    };
    place.run(&[]);
    let default = tip(&place);
    assert_eq!(tip_of("micromodulus=isotropised"), default);
    assert_eq!(tip_of("surface_correction=force"), default);
    for set in [
        "micromodulus=raw",
        "surface_correction=none",
        "surface_correction=least-squares",
    ] {
        assert!((tip_of(set) / default - 1.0).abs() > 1e-4, "{set}");
    }
}

#[test]
fn placements_and_cell_areas() {
    let case = |grid_nodes, clipped| Case {
        grid_nodes,
        clipped,
        ..PAPER
    };
    let found = assert_cases(&[
        case(true, true),
        case(true, false),
        case(false, true),
        case(false, false),
    ]);
    // Loads are shared by nearness or by areas, which round otherwise.
    let same = (found[2] / found[3] - 1.0).abs() < 1e-11;
    assert!(same, "whole cells cannot be clipped: {found:?}");
    assert_all_differ(found[..3].to_vec());
}

#[test]
fn areas_of_interface_nodes() {
    let areas = [NodeArea::Lumped, NodeArea::HalfEdge, NodeArea::Given(0.3)];
    let cases = areas.map(|area| Case {
        hybrid: Some(area),
        ..PAPER
    });
    assert_all_differ(assert_cases(&cases));
}

#[test]
fn the_command_line_sets_what_the_file_would() {
    let place = Workplace::new();
    place.run(&["--set", "coupling.truss.node_area=half-edge"]);
    let set = tip(&place);
    place.edit(
        "bar.yaml",
        "coupling: truss",
        "coupling: { truss: { node_area: half-edge } }",
    );
    let ended = place.run(&[]);
    assert!(
        ended.stages().is_empty(),
        "the same pipeline: {}",
        ended.err
    );
    place.edit("bar.yaml", "half-edge", "lumped");
    place.run(&[]);
    assert!((set / tip(&place) - 1.0).abs() > 1e-4);
}

/// Traction and stiffness are both proportional to h_t.
#[test]
fn the_thickness_scales_the_reactions_alone() {
    let place = Workplace::new();
    let measure = |thickness: &str| {
        place.run(&["--set", &format!("thickness={thickness}")]);
        let reaction = place.summary()["reactions_n"]["clamp"][0].as_f64();
        (tip(&place), reaction.expect("a number"))
    };
    let ((u, metre), (v, centimetre)) = (measure("1 m"), measure("10 mm"));
    // Rounding, times the condition of K.
    assert!((u / v - 1.0).abs() < 1e-11, "{u:e} {v:e}");
    assert!(
        (metre + TRACTION * HEIGHT).abs() < 1e-9 * TRACTION * HEIGHT,
        "{metre}"
    );
    assert!(
        (centimetre / metre - 0.01).abs() < 1e-11,
        "{centimetre} {metre}"
    );
}

/// A negative pressure pulls along the outward normal, here x.
#[test]
fn a_pressure_is_a_traction_against_the_normal() {
    let place = Workplace::new();
    place.run(&[]);
    let pulled = tip(&place);
    place.edit(
        "bar.yaml",
        "traction: { x: 1.05 MPa }",
        "pressure: -1.05 MPa",
    );
    place.run(&[]);
    assert!((tip(&place) / pulled - 1.0).abs() < 1e-12);
}

/// Without lateral strain the bar is a chain: u = σ Σ L_i / E_i.
#[test]
fn elements_of_three_materials_in_a_row() {
    let place = Workplace::new();
    place.write(
        "bar.yaml",
        "\
name: bar
geometry: { file: geo/bar.geo, unit: mm, parameters: { element: 50 } }
materials:
  soft: { young: 50 GPa, poisson: 0 }
  middling: { young: 100 GPa, poisson: 0 }
  stiff: { young: 400 GPa, poisson: 0 }
regions:
  - { group: left, model: fem, material: soft }
  - { group: band, model: fem, material: stiff }
  - { group: right, model: fem, material: middling }
boundary:
  - { group: clamp, displacement: { x: 0, y: 0 } }
  - { group: load, traction: { x: 1.05 MPa } }
probes: { tip: { at: [1000 mm, 100 mm], component: x } }
",
    );
    place.run(&[]);
    let exact = TRACTION * (0.4 / 50e9 + 0.2 / 400e9 + 0.4 / 100e9);
    assert!(
        (tip(&place) / exact - 1.0).abs() < 1e-11,
        "{:e} {exact:e}",
        tip(&place)
    );
}

/// A physical point acts on the material point at it, or on the nearest one.
#[test]
fn a_physical_point_in_a_lattice() {
    for placement in ["grid-nodes", "cell-centred"] {
        let place = Workplace::new();
        let mut pipeline = PAPER.pipeline().replace("grid-nodes", placement);
        pipeline = pipeline.replace(
            "  - { group: load, traction: { x: 1.05 MPa } }",
            "  - { group: tip, displacement: { x: 3 µm } }",
        );
        place.write("bar.yaml", pipeline);
        place.run(&[]);
        let summary = place.summary();
        assert_eq!(tip(&place), 3e-6, "{placement}");
        let force = |group: &str| summary["reactions_n"][group][0].as_f64().expect("a number");
        assert!(force("tip") > 0.0 && (force("clamp") / force("tip") + 1.0).abs() < 1e-9);
    }
}

#[test]
fn groups_without_a_name_go_by_their_number() {
    let place = Workplace::new();
    place.run(&[]);
    let named = tip(&place);
    place.edit(
        "geo/bar.geo",
        "Physical Curve(\"load\")",
        "Physical Curve(77)",
    );
    place.edit(
        "geo/bar.geo",
        "Physical Surface(\"left\")",
        "Physical Surface(78)",
    );
    place.edit("bar.yaml", "group: load", "group: 77");
    place.edit("bar.yaml", "[left, right]", "[78, right]");
    place.run(&[]);
    assert_eq!(tip(&place), named);
}

/// Weight by density, forces on a curve, a point and a surface: what the clamp carries is their sum.
#[test]
fn the_supports_carry_weight_and_forces() {
    let place = Workplace::new();
    place.edit(
        "bar.yaml",
        "poisson: 1/3 }",
        "poisson: 1/3, density: 7800 kg/m^3 }",
    );
    place.edit(
        "bar.yaml",
        "  - { group: load, traction: { x: 1.05 MPa } }",
        "  - { group: top, force: { x: 2 kN, y: -3 kN } }
  - { group: corner, force: { y: 5 kN } }
  - { group: band, body_force: { y: -25 kN/m^3 } }
gravity: { y: -9.81 m/s^2 }",
    );
    place.run(&[]);
    let summary = place.summary();
    let clamp = &summary["reactions_n"]["clamp"];
    let band = 0.2 * 0.2;
    let expected = [-2e3, 0.2 * 7800.0 * 9.81 + 3e3 - 5e3 + 25e3 * band];
    for axis in 0..2 {
        let found = clamp[axis].as_f64().expect("a number");
        // The sum of some hundred forces, with a residual of 1e-14.
        let error = (found - expected[axis]).abs() / 1e4;
        assert!(error < 1e-9, "{clamp} for {expected:?}");
    }
}
