//! Moduli of the infinite lattice, from the bonds that the library makes.
//!
//! Under a uniform strain ε the bonds of an inner point i store A_i h_t · ½ ε:C:ε with
//! C = 1/(2 A_i h_t) Σ_j k_ij ξ² n⊗n⊗n⊗n. Along the axis E = C11 − C12²/C11; at 45° the same of the
//! turned tensor, C11' = (C11 + C12 + 2 C66)/2 and C12' = (C11 + C12 − 2 C66)/2.
//!
//! | E_lat/E along the axis / at 45° | full area | Hu, Ha & Bobaru |
//! |---|---|---|
//! | quartic, m = 3 | 1.039 / .927 | 1.037 / .921 |
//! | quartic, m = 4 | 1.018 / .972 | 1.017 / .967 |
//! | constant (PMB), m = 3 | 1.064 / 1.017 | 1.045 / .995 |
//! | constant (PMB), m = 4 | .986 / .938 | 1.019 / 1.007 |
//!
//! Isotropised micromoduli make every figure of such a table 1.000: C11 and C12 are the material's.
//!
//! The table is a sum of 28 to 68 terms, printed to a thousandth: half of that is the tolerance.

mod common;

use common::assert_between;
use peristitch::geometry::Outline;
use peristitch::interactions::{self, Interactions};
use peristitch::material::{Material, PlaneState};
use peristitch::peridynamics::bonds::bonds;
use peristitch::peridynamics::kernel::{Kernel, Micromodulus, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, Lattice, LatticeSettings, Placement, lattice};
use peristitch::peridynamics::visibility::Visibility;

const DX: f64 = 2.5e-3;
const THICKNESS: f64 = 0.3;
const YOUNG: f64 = 30e9;

/// Half a unit of the last printed digit.
const PRINTED: f64 = 0.5e-3;

fn rectangle(columns: f64, rows: f64) -> Outline {
    let (w, h) = (columns * DX, rows * DX);
    Outline {
        loops: vec![vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]],
    }
}

fn points(outline: &Outline, cell_area: CellArea) -> Lattice {
    let settings = LatticeSettings::upright(DX, Placement::CellCentred, cell_area);
    lattice(outline, &[], &settings)
}

fn micromodulus(
    kernel: Kernel,
    partial_area: PartialArea,
    m: f64,
    plane: PlaneState,
) -> Micromodulus {
    let material = Material {
        young: YOUNG,
        poisson: plane.bond_based_poisson(),
    };
    Micromodulus::new(kernel, partial_area, &material, plane, m * DX, DX)
}

/// C11, C22, C12, C66 and C16 over E of the bonds that end at `point`.
fn moduli(lattice: &Lattice, bonds: &Interactions, point: u32) -> [f64; 5] {
    let mut c = [0.0; 5];
    for (&ends, k) in bonds.pairs().iter().zip(&bonds.stiffness) {
        if ends.contains(&point) {
            let (xi, [x, y]) = interactions::axis(ends, &lattice.positions);
            let weight = k * xi * xi / (2.0 * lattice.areas[point as usize] * THICKNESS * YOUNG);
            let terms = [
                x.powi(4),
                y.powi(4),
                x * x * y * y,
                x * x * y * y,
                x.powi(3) * y,
            ];
            c.iter_mut()
                .zip(terms)
                .for_each(|(c, term)| *c += weight * term);
        }
    }
    c
}

/// E_lat/E along the axis and at 45°, of the middle point of 13 × 13.
fn young_ratios(kernel: Kernel, partial_area: PartialArea, m: f64) -> [f64; 2] {
    let lattice = points(&rectangle(13.0, 13.0), CellArea::Full);
    let modulus = micromodulus(kernel, partial_area, m, PlaneState::Stress);
    let bonds = bonds(&lattice, &modulus, THICKNESS, 0, &Visibility::unlimited());
    let [c11, c22, c12, c66, c16] = moduli(&lattice, &bonds, 84);
    // The lattice has the square's symmetry: a missing bond would break it.
    assert!(
        (c11 - c22).abs() < 1e-14 && c16.abs() < 1e-14,
        "{c11} {c22} {c16:e}"
    );
    let turned = [0.5 * (c11 + c12) + c66, 0.5 * (c11 + c12) - c66];
    [
        c11 - c12 * c12 / c11,
        turned[0] - turned[1] * turned[1] / turned[0],
    ]
}

#[test]
fn young_moduli_of_the_lattice_are_those_of_the_table() {
    let table = [
        (Kernel::Quartic, 3.0, PartialArea::Full, [1.039, 0.927]),
        (Kernel::Quartic, 3.0, PartialArea::Hhb, [1.037, 0.921]),
        (Kernel::Quartic, 4.0, PartialArea::Full, [1.018, 0.972]),
        (Kernel::Quartic, 4.0, PartialArea::Hhb, [1.017, 0.967]),
        (Kernel::Constant, 3.0, PartialArea::Full, [1.064, 1.017]),
        (Kernel::Constant, 3.0, PartialArea::Hhb, [1.045, 0.995]),
        (Kernel::Constant, 4.0, PartialArea::Full, [0.986, 0.938]),
        (Kernel::Constant, 4.0, PartialArea::Hhb, [1.019, 1.007]),
    ];
    let mut wrong = Vec::new();
    for (kernel, m, partial_area, printed) in table {
        let ratios = young_ratios(kernel, partial_area, m);
        for (ratio, printed) in ratios.into_iter().zip(printed) {
            if (ratio - printed).abs() > PRINTED {
                wrong.push(format!(
                    "{kernel:?} m = {m} {partial_area:?}: {ratio:.5} for {printed}"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// C11 = 9E/8 and C12 = 3E/8 in plane stress, 6E/5 and 2E/5 in plane strain.
#[test]
fn isotropised_micromoduli_give_the_lattice_the_moduli_of_the_material() {
    // Even in both directions, so that no point lies in the middle; this one has 11 on every side.
    let lattice = points(&rectangle(24.0, 24.0), CellArea::Clipped);
    let middle = 11 * 24 + 11;
    for kernel in Kernel::ALL {
        for m in [2.0, 2.24, 2.5, 3.0, 3.015, 3.7, 4.0, 5.0, 6.6] {
            for partial_area in [PartialArea::Full, PartialArea::Hhb] {
                for (plane, c12_expected) in
                    [(PlaneState::Stress, 0.375), (PlaneState::Strain, 0.4)]
                {
                    let modulus = micromodulus(kernel, partial_area, m, plane).isotropised();
                    let bonds = bonds(&lattice, &modulus, THICKNESS, 0, &Visibility::unlimited());
                    let [c11, c22, c12, c66, c16] = moduli(&lattice, &bonds, middle);
                    let errors = [
                        c11 / (3.0 * c12_expected) - 1.0,
                        c22 / (3.0 * c12_expected) - 1.0,
                        c12 / c12_expected - 1.0,
                        c66 / c12_expected - 1.0,
                        c16,
                    ];
                    // Sums of up to 150 terms, and two equations solved.
                    assert!(
                        errors.iter().all(|error| error.abs() < 1e-13),
                        "{kernel:?}, m = {m}, {partial_area:?}, {plane:?}: {errors:?}"
                    );
                }
            }
        }
    }
}

/// The quartic kernel's error falls as 1/m³, that of the cusp at ξ = 0: 1.18 to 1.21 on the axis and
/// −1.80 to −1.99 at 45° times 1/m³ for m = 4, 5, 6.
#[test]
fn the_quartic_kernel_converges_with_the_cube_of_m() {
    let errors = [4.0, 5.0, 6.0].map(|m| {
        young_ratios(Kernel::Quartic, PartialArea::Full, m).map(|ratio| (ratio - 1.0) * m.powi(3))
    });
    for [axis, diagonal] in errors {
        assert_between(axis, 1.17, 1.22, "axis");
        assert_between(diagonal, -2.0, -1.79, "diagonal");
    }
}

#[test]
fn areas_sum_to_the_area_of_the_region() {
    // 12.4 × 7.7 squares with a corner cut off and a triangular hole.
    let polygon = [[0.0, 0.0], [12.4, 0.0], [12.4, 5.1], [9.2, 7.7], [0.0, 7.7]];
    let hole = [[3.3, 2.1], [4.2, 4.9], [6.7, 4.4]];
    let scaled = |points: &[[f64; 2]]| points.iter().map(|p| p.map(|x| x * DX)).collect();
    let outline = Outline {
        loops: vec![scaled(&polygon), scaled(&hole)],
    };
    let exact = 12.4 * 7.7 - 0.5 * 3.2 * 2.6 - 0.5 * (3.4 * 2.8 - 0.9 * 2.3);
    let sum: f64 = points(&outline, CellArea::Clipped).areas.iter().sum();
    // A hundred cells with rounding errors of 1e-16 of the region's area.
    assert!((sum / (exact * DX * DX) - 1.0).abs() < 1e-13, "{sum:e}");
}

/// Energy density ½ Σ_j ½ k (ξ s)² / (A_i h_t) of every point farther than δ from the boundary, with s
/// from displacements; against ½ ε:C:ε of the table's moduli.
#[test]
fn inner_points_store_the_energy_of_the_lattice_s_moduli() {
    for plane in [PlaneState::Stress, PlaneState::Strain] {
        let lattice = points(&rectangle(16.0, 12.0), CellArea::Clipped);
        let modulus = micromodulus(Kernel::Quartic, PartialArea::Full, 4.0, plane);
        let bonds = bonds(&lattice, &modulus, THICKNESS, 0, &Visibility::unlimited());
        let [c11, _, c12, c66, _] = moduli(&lattice, &bonds, 5 * 16 + 7);
        let [xx, yy, xy] = [1e-3, -0.4e-3, 0.3e-3];
        let density = 0.5
            * YOUNG
            * (c11 * (xx * xx + yy * yy) + 2.0 * c12 * xx * yy + c66 * (2.0 * xy) * (2.0 * xy));
        let u: Vec<[f64; 2]> = lattice
            .positions
            .iter()
            .map(|[x, y]| [xx * x + xy * y, xy * x + yy * y])
            .collect();
        let mut energy = vec![0.0; u.len()];
        for (s, k) in bonds.stiffness.iter().enumerate() {
            let elongation =
                bonds.length(s, &lattice.positions) * bonds.stretch(s, &lattice.positions, &u);
            bonds
                .nodes(s)
                .iter()
                .for_each(|&i| energy[i as usize] += 0.25 * k * elongation * elongation);
        }
        let inner =
            (0..u.len()).filter(|i| (4..12).contains(&(i % 16)) && (4..8).contains(&(i / 16)));
        for i in inner {
            let ratio = energy[i] / (lattice.areas[i] * THICKNESS) / density;
            // Stretches are differences of displacements ten times as large.
            assert!(
                (ratio - 1.0).abs() < 1e-13,
                "{plane:?} point {i}: {:e}",
                ratio - 1.0
            );
        }
        // Of the continuum's energy, what this lattice stores of this strain: 1.01379.
        let elasticity = Material {
            young: 1.0,
            poisson: plane.bond_based_poisson(),
        }
        .elasticity(plane);
        let strain = nalgebra::Vector3::new(xx, yy, 2.0 * xy);
        let ratio = density / (0.5 * YOUNG * strain.dot(&(elasticity * strain)));
        assert!((ratio - 1.013795).abs() < 1e-6, "{plane:?} {ratio}");
    }
}
