//! Moduli and energy release rate of the infinite lattice, from the bonds that the library makes.
//!
//! Under a uniform strain ε the bonds of an inner point i store A_i h_t · ½ ε:C:ε with
//! C = 1/(2 A_i h_t) Σ_j k_ij ξ² n⊗n⊗n⊗n. Along the axis E = C11 − C12²/C11; at 45° the same of the
//! turned tensor, C11' = (C11 + C12 + 2 C66)/2 and C12' = (C11 + C12 − 2 C66)/2.

use super::{Check, Reference, VerificationError};
use crate::geometry::Outline;
use crate::interactions::{self, Interactions};
use crate::material::PlaneState;
use crate::model::PeridynamicSettings;
use crate::peridynamics::bonds::bonds;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::{Lattice, lattice};
use crate::peridynamics::visibility::Visibility;

/// The bonds of a square of `side` × `side` points, h_t = 1 m and E = 1 Pa.
pub struct Square {
    pub lattice: Lattice,
    pub bonds: Interactions,
    pub micromodulus: Micromodulus,
    side: usize,
}

impl Square {
    pub fn new(settings: &PeridynamicSettings, side: usize) -> Square {
        let w = side as f64 * settings.lattice.spacing;
        let outline = Outline {
            loops: vec![vec![[0.0, 0.0], [w, 0.0], [w, w], [0.0, w]]],
        };
        let lattice = lattice(&outline, &[], &settings.lattice);
        let micromodulus = settings.micromodulus(&super::bodies::material(1.0), PlaneState::Stress);
        let spacing = settings.lattice.spacing;
        let visibility = Visibility::new(&outline, spacing, micromodulus.reach());
        let bonds = bonds(&lattice, &micromodulus, 1.0, 0, &visibility);
        Square {
            lattice,
            bonds,
            micromodulus,
            side,
        }
    }

    /// C11, C22, C12, C66 and C16 over E of the bonds that end at the middle point.
    pub fn moduli(&self) -> [f64; 5] {
        let middle = self.side * (self.side / 2) + self.side / 2;
        let area = self.lattice.areas[middle];
        let mut c = [0.0; 5];
        for (&ends, k) in self.bonds.pairs().iter().zip(&self.bonds.stiffness) {
            if ends.contains(&(middle as u32)) {
                let (xi, [x, y]) = interactions::axis(ends, &self.lattice.positions);
                let weight = k * xi * xi / (2.0 * area);
                let both = x * x * y * y;
                let terms = [x.powi(4), y.powi(4), both, both, x.powi(3) * y];
                c.iter_mut()
                    .zip(terms)
                    .for_each(|(c, term)| *c += weight * term);
            }
        }
        c
    }

    /// E_lat/E along the axis and at 45°.
    pub fn young_ratios(&self) -> [f64; 2] {
        let [c11, _, c12, c66, _] = self.moduli();
        let turned = [0.5 * (c11 + c12) + c66, 0.5 * (c11 + c12) - c66];
        [
            c11 - c12 * c12 / c11,
            turned[0] - turned[1] * turned[1] / turned[0],
        ]
    }

    /// The energy at s0 of all bonds across a cut along `direction`, per length, over c0 s0² M3. Bonds
    /// are counted that cross it within eight of the lattice's `period`s [m].
    pub fn energy_release_ratio(&self, direction: [f64; 2], period: f64) -> f64 {
        let dx = self.micromodulus.spacing;
        // A quarter of a cell off the middle, so that no point lies on the cut.
        let middle = 0.5 * self.side as f64 * dx;
        let through = [middle, middle + 0.25 * dx];
        let normal = [-direction[1], direction[0]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let window = 8.0 * period;
        let mut energy = 0.0;
        for (bond, pair) in self.bonds.pairs().iter().enumerate() {
            let [a, b] = pair.map(|node| {
                let x = self.lattice.positions[node as usize];
                [x[0] - through[0], x[1] - through[1]]
            });
            let sides = [a, b].map(|x| dot(x, normal));
            if sides[0] * sides[1] >= 0.0 {
                continue;
            }
            let share = sides[0] / (sides[0] - sides[1]);
            let along = dot(a, direction) + share * (dot(b, direction) - dot(a, direction));
            // Shifted by an odd share of a period: no crossing on the window's ends.
            if (0.0..window).contains(&(along + 0.5 * window - 0.123 * period)) {
                let xi = self.bonds.length(bond, &self.lattice.positions);
                energy += 0.5 * self.bonds.stiffness[bond] * xi * xi;
            }
        }
        let c = &self.micromodulus;
        energy / window / (c.c0 * c.kernel.third_moment() * c.horizon.powi(4))
    }

    /// Moduli along the axis and at 45°.
    pub fn energy_release_ratios(&self) -> [f64; 2] {
        let (dx, half) = (self.micromodulus.spacing, 0.5f64.sqrt());
        [
            self.energy_release_ratio([1.0, 0.0], dx),
            self.energy_release_ratio([half, half], dx / half),
        ]
    }
}

const DX: f64 = 2.5e-3;

/// Half a unit of the third digit behind the point, which the reference has.
const PRINTED: f64 = 0.5e-3;

pub fn measure_moduli() -> Result<Vec<Check>, VerificationError> {
    let raw = super::bodies::paper_lattice(DX);
    let isotropised = PeridynamicSettings {
        isotropised: true,
        ..raw
    };
    let check = |quantity, value: f64, within, source, measured| Check {
        case: "lattice moduli",
        quantity,
        reference: Reference::Value { value, within },
        source,
        measured,
    };
    let [axis, diagonal] = Square::new(&raw, 13).young_ratios();
    let [iso_axis, iso_diagonal] = Square::new(&isotropised, 13).young_ratios();
    Ok(vec![
        check("E_lat/E, raw, 0°", 1.018, PRINTED, SUM, axis),
        check("E_lat/E, raw, 45°", 0.972, PRINTED, SUM, diagonal),
        check("E_lat/E, isotropised, 0°", 1.0, 1e-12, "exact", iso_axis),
        check(
            "E_lat/E, isotropised, 45°",
            1.0,
            1e-12,
            "exact",
            iso_diagonal,
        ),
    ])
}

/// Numbers that another program has computed.
const SUM: &str = "independent sum over the family";

pub fn measure_energy_release() -> Result<Vec<Check>, VerificationError> {
    let raw = super::bodies::paper_lattice(DX);
    let isotropised = PeridynamicSettings {
        isotropised: true,
        ..raw
    };
    // Half a unit of the last digit.
    let check = |quantity, value: f64, measured| Check {
        case: "energy of a cut",
        quantity,
        reference: Reference::Value {
            value,
            within: 0.5e-4,
        },
        source: SUM,
        measured,
    };
    let [axis, diagonal] = Square::new(&raw, 40).energy_release_ratios();
    let [iso_axis, iso_diagonal] = Square::new(&isotropised, 40).energy_release_ratios();
    Ok(vec![
        check("G_lat/G0, raw, 0°", 0.9849, axis),
        check("G_lat/G0, raw, 45°", 0.9947, diagonal),
        check("G_lat/G0, isotropised, 0°", 0.9962, iso_axis),
        check("G_lat/G0, isotropised, 45°", 0.9960, iso_diagonal),
    ])
}
