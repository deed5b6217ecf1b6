//! An infinite strip in tension and in bending, with each of the surface corrections.
//!
//! ```text
//!   H/dx rows on cell centres, free at the top and at the bottom
//!   tension: bond elongation ε n_x ξ_x + n_y (v_j − v_i), against ½ E H ε²
//!   bending: bond elongation κ n_x ξ_x (y_i + y_j)/2 + n_y (v_j − v_i), against ½ E H³/12 κ²
//! ```
//!
//! The energy of one column is minimised over the rows' deflections v.

use super::{Check, Reference, VerificationError};
use crate::geometry::Outline;
use crate::interactions::Interactions;
use crate::material::PlaneState;
use crate::peridynamics::bonds::bonds;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::{CellArea, Lattice, LatticeSettings, Placement, lattice};
use crate::peridynamics::surface::{Surface, SurfaceCorrection};
use crate::peridynamics::visibility::Visibility;
use nalgebra::{DMatrix, DVector};

/// Long enough that the middle column does not see the ends.
const COLUMNS: usize = 80;

/// The bonds of a region in a body, corrected; h_t = 1 m, nodes count from 0.
pub fn corrected(
    correction: SurfaceCorrection,
    [region, body]: [&Outline; 2],
    micromodulus: &Micromodulus,
) -> Result<(Lattice, Interactions), VerificationError> {
    let spacing = micromodulus.spacing;
    let cells = LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Clipped);
    let points = lattice(region, &[], &cells);
    let visibility = Visibility::new(body, spacing, micromodulus.reach());
    let mut bonds = bonds(&points, micromodulus, 1.0, 0, &visibility);
    let surface = Surface::new(correction, region, body, &cells, micromodulus, &visibility)?;
    surface.correct(&mut bonds, &points.positions, 0);
    Ok((points, bonds))
}

/// Energy of a strip's column over its reference, in tension and in bending; `young` is E [Pa].
pub fn energy_ratios(
    correction: SurfaceCorrection,
    rows: usize,
    micromodulus: &Micromodulus,
    young: f64,
) -> Result<[f64; 2], VerificationError> {
    let dx = micromodulus.spacing;
    let (width, height) = (COLUMNS as f64 * dx, rows as f64 * dx);
    let strip = Outline {
        loops: vec![vec![
            [0.0, 0.0],
            [width, 0.0],
            [width, height],
            [0.0, height],
        ]],
    };
    let (points, bonds) = corrected(correction, [&strip, &strip], micromodulus)?;
    let y = |node: u32| points.positions[node as usize][1] - 0.5 * height;
    let tension = |_: [u32; 2]| 1.0;
    let bending = |[i, j]: [u32; 2]| 0.5 * (y(i) + y(j));
    let exact = [height, height.powi(3) / 12.0].map(|area| 0.5 * young * area * dx);
    Ok([
        column_energy(&points, &bonds, rows, tension) / exact[0],
        column_energy(&points, &bonds, rows, bending) / exact[1],
    ])
}

/// The least energy of a column [J], `strain` being that of a bond along the strip.
fn column_energy(
    points: &Lattice,
    bonds: &Interactions,
    rows: usize,
    strain: impl Fn([u32; 2]) -> f64,
) -> f64 {
    // Half of each bond belongs to the column of either end; the middle column stands for all.
    let is_middle = |node: &&u32| **node as usize % COLUMNS == COLUMNS / 2;
    let mut k = DMatrix::zeros(rows, rows);
    let mut f = DVector::zeros(rows);
    let mut energy = 0.0;
    for (bond, &ends) in bonds.pairs().iter().enumerate() {
        let share = 0.5 * ends.iter().filter(is_middle).count() as f64;
        if share == 0.0 {
            continue;
        }
        let stiffness = share * bonds.stiffness[bond];
        let (xi, n) = bonds.axis(bond, &points.positions);
        let elongation = strain(ends) * n[0] * n[0] * xi;
        let [i, j] = ends.map(|node| node as usize / COLUMNS);
        energy += 0.5 * stiffness * elongation * elongation;
        for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
            k[(a, b)] += sign * stiffness * n[1] * n[1];
        }
        f[j] -= stiffness * n[1] * elongation;
        f[i] += stiffness * n[1] * elongation;
    }
    // The strip as a whole may move: one row is held.
    k.row_mut(0).fill(0.0);
    k.column_mut(0).fill(0.0);
    k[(0, 0)] = 1.0;
    f[0] = 0.0;
    let v = k.cholesky().map(|k| k.solve(&f));
    // Without a deflection there is none to gain from; NaN shows that the column is a mechanism.
    energy - 0.5 * v.map_or(f64::NAN, |v| v.dot(&f))
}

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let micromodulus = super::bodies::default_lattice(2.5e-3)
        .micromodulus(&super::bodies::material(1.0), PlaneState::Stress);
    let mut checks = Vec::new();
    let table = [
        (
            SurfaceCorrection::None,
            20,
            [
                "uncorrected, tension, H = 20 dx",
                "uncorrected, bending, H = 20 dx",
            ],
            [0.9675, 0.9069],
        ),
        (
            SurfaceCorrection::Force,
            20,
            ["force, tension, H = 20 dx", "force, bending, H = 20 dx"],
            [1.0097, 1.0092],
        ),
        (
            SurfaceCorrection::Force,
            80,
            ["force, tension, H = 80 dx", "force, bending, H = 80 dx"],
            [1.0024, 1.0059],
        ),
    ];
    for (correction, rows, quantities, printed) in table {
        let measured = energy_ratios(correction, rows, &micromodulus, 1.0)?;
        for mode in 0..2 {
            checks.push(Check {
                case: "strip",
                quantity: quantities[mode],
                // Half a unit of the last digit.
                reference: Reference::Value {
                    value: printed[mode],
                    within: 0.5e-4 / printed[mode],
                },
                source: "independent program; EH, EH³/12 are 1",
                measured: measured[mode],
            });
        }
    }
    let [tension, bending] =
        energy_ratios(SurfaceCorrection::LeastSquares, 20, &micromodulus, 1.0)?;
    let exact = |quantity, within, source, measured| Check {
        case: "strip",
        quantity,
        reference: Reference::Value { value: 1.0, within },
        source,
        measured,
    };
    checks.push(exact(
        "least squares, tension, H = 20 dx",
        1e-9,
        "EH",
        tension,
    ));
    checks.push(exact(
        "least squares, bending, H = 20 dx",
        0.01,
        "EH³/12",
        bending,
    ));
    Ok(checks)
}
