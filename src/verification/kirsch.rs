//! A plate with a hole in its peridynamic region: Kirsch's exact displacements around a square within
//! the infinite plate, so that the size of the plate is no error.
//!
//! Tension σ along x, hole of radius a, μ the shear modulus, κ = (3 − ν)/(1 + ν) in plane stress:
//!
//! ```text
//! u = σa/8μ [ (r/a)(κ + 1) cos θ + (2a/r)((1 + κ) cos θ + cos 3θ) − (2a³/r³) cos 3θ ]
//! v = σa/8μ [ (r/a)(κ − 3) sin θ + (2a/r)((1 − κ) sin θ + sin 3θ) − (2a³/r³) sin 3θ ]
//! ```
//!
//! On the ligament x = 0, with r = y: σ_θ = σ_xx = (σ/2)(2 + a²/r² + 3a⁴/r⁴).

use super::bodies::{build, default_lattice, hold_outline, material, region, solve};
use super::{Check, Reference, VerificationError};
use crate::coupling::Coupling;
use crate::fields::points::PointFields;
use crate::mesh::grid::name_cells;
use crate::mesh::patchwork::{Patch, on_circle, on_square, patchwork};
use crate::mesh::{CellKind, Mesh};
use crate::model::{Method, Model};

/// a, E and σ are 1.
const NU: f64 = 1.0 / 3.0;

/// u(x) [m].
pub fn displacement([x, y]: [f64; 2]) -> [f64; 2] {
    let (r, theta) = (x.hypot(y), y.atan2(x));
    let mu = 1.0 / (2.0 * (1.0 + NU));
    let kappa = (3.0 - NU) / (1.0 + NU);
    let (inner, cube) = (2.0 / r, 2.0 / r.powi(3));
    let (s, c) = theta.sin_cos();
    let (s3, c3) = (3.0 * theta).sin_cos();
    let u = r * (kappa + 1.0) * c + inner * ((1.0 + kappa) * c + c3) - cube * c3;
    let v = r * (kappa - 3.0) * s + inner * ((1.0 - kappa) * s + s3) - cube * s3;
    [u, v].map(|u| u / (8.0 * mu))
}

/// σ_θ/σ on the ligament at r/a.
pub fn ligament(r: f64) -> f64 {
    0.5 * (2.0 + r.powi(-2) + 3.0 * r.powi(-4))
}

/// Half-sides of the interface and of the plate, in radii.
const INTERFACE: f64 = 3.0;
const PLATE: f64 = 4.0;
/// Elements along each side of the rings.
const AROUND: usize = 12;

/// The ring around the hole and the ring of elements around that.
fn mesh() -> Mesh {
    let between = |inner: [f64; 2], outer: [f64; 2], s: f64| {
        [0, 1].map(|k| (1.0 - s) * inner[k] + s * outer[k])
    };
    let ring = |quarter| {
        move |[s, t]: [f64; 2]| {
            let t = 2.0 * t - 1.0;
            between(
                on_circle(1.0, t, quarter),
                on_square(INTERFACE, t, quarter),
                s,
            )
        }
    };
    let frame = |quarter| {
        move |[s, t]: [f64; 2]| {
            let t = 2.0 * t - 1.0;
            let [inner, outer] = [INTERFACE, PLATE].map(|h| on_square(h, t, quarter));
            between(inner, outer, s)
        }
    };
    let rings = [0, 1, 2, 3].map(ring);
    let frames = [0, 1, 2, 3].map(frame);
    let mut patches: Vec<Patch> = Vec::new();
    for map in &rings {
        patches.push(Patch {
            count: [6, AROUND],
            map,
        });
    }
    for map in &frames {
        patches.push(Patch {
            count: [3, AROUND],
            map,
        });
    }
    let mut mesh = patchwork(CellKind::Quad8, PLATE, &patches);
    name_cells(&mut mesh, "points", |[x, y]| {
        x.abs().max(y.abs()) < INTERFACE
    });
    name_cells(&mut mesh, "frame", |[x, y]| {
        x.abs().max(y.abs()) > INTERFACE
    });
    mesh
}

/// σ_θ/σ along the ligament.
#[derive(Clone, Debug)]
pub struct Profile {
    /// δ/a.
    pub horizon: f64,
    /// (r/a, σ_θ/σ), outwards.
    pub points: Vec<[f64; 2]>,
}

impl Profile {
    /// Stresses of the column of points beside x = 0 at dx = a/`per_radius`.
    ///
    /// # Errors
    /// Errors of building and solving.
    pub fn new(per_radius: usize) -> Result<Profile, VerificationError> {
        let dx = 1.0 / per_radius as f64;
        let mesh = mesh();
        let settings = default_lattice(dx);
        let regions = vec![
            region(
                &mesh,
                &["points"],
                material(1.0),
                Method::Peridynamics(settings),
            ),
            region(&mesh, &["frame"], material(1.0), Method::FiniteElements),
        ];
        let model = build(mesh, regions, Coupling::Clip)?;
        let solution = solve(&model, &hold_outline(&model, displacement))?;
        let fields = PointFields::new(&model, &solution.displacement, &model.integrity);
        let points = points_above(&model, &fields, dx);
        Ok(Profile {
            horizon: settings.horizon_ratio * dx,
            points,
        })
    }

    /// σ_θ over the exact one, by r/a, at a horizon or more from the hole and from the interface.
    fn ratios(&self) -> impl Iterator<Item = [f64; 2]> {
        let (from, to) = (1.0 + self.horizon, INTERFACE - self.horizon);
        let within = self
            .points
            .iter()
            .filter(move |p| (from..to).contains(&p[0]));
        within.map(|&[r, stress]| [r, stress / ligament(r)])
    }
}

/// The column at x = dx/2 above the hole: r = |x| and σ_xx.
fn points_above(model: &Model, fields: &PointFields, dx: f64) -> Vec<[f64; 2]> {
    let first = model.fe_node_count();
    let points = model.positions[first..].iter().zip(&fields.stress);
    let column = points.filter(|([x, y], _)| *y > 0.0 && (x - 0.5 * dx).abs() < 1e-6 * dx);
    let mut column: Vec<[f64; 2]> = column.map(|(x, s)| [x[0].hypot(x[1]), s[0]]).collect();
    column.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    column
}

/// Points per radius.
const FINE: usize = 20;

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let profile = Profile::new(FINE)?;
    let deviation = |[_, ratio]: [f64; 2]| (ratio - 1.0).abs();
    let largest = profile.ratios().map(deviation).fold(0.0, f64::max);
    let first = profile.ratios().next();
    const CLOSED_FORM: &str = "Kirsch (1898)";
    Ok(vec![
        Check {
            case: "plate with a hole",
            quantity: "σ_θ over exact at a + δ",
            reference: Reference::Value {
                value: 1.0,
                within: 0.01,
            },
            source: CLOSED_FORM,
            measured: first.map_or(f64::NAN, |[_, ratio]| ratio),
        },
        Check {
            case: "plate with a hole",
            quantity: "largest error of σ_θ beyond δ",
            reference: Reference::Zero { within: 0.01 },
            source: CLOSED_FORM,
            measured: largest,
        },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::grid::centre;

    /// The rings' cells all belong to one region or the other.
    #[test]
    fn the_mesh_is_whole() {
        let mesh = mesh();
        let named = mesh.surfaces.values().map(Vec::len).sum::<usize>();
        assert_eq!(named, mesh.cells.len());
        assert!(
            (0..mesh.cells.len()).all(|c| centre(&mesh, c)[0].hypot(centre(&mesh, c)[1]) > 1.0)
        );
    }

    /// Zero traction at the hole and 3σ on its side, by differences of the displacements.
    #[test]
    fn the_displacements_are_those_of_the_stresses() {
        let h = 1e-5;
        let strain = |[x, y]: [f64; 2]| {
            let d = |axis: usize, k: usize| {
                let mut ends = [[x, y]; 2];
                ends[0][k] -= h;
                ends[1][k] += h;
                (displacement(ends[1])[axis] - displacement(ends[0])[axis]) / (2.0 * h)
            };
            nalgebra::Vector3::new(d(0, 0), d(1, 1), d(0, 1) + d(1, 0))
        };
        let elasticity = material(1.0).elasticity(crate::material::PlaneState::Stress);
        for r in [1.0, 1.3, 2.5] {
            let stress = elasticity * strain([0.0, r]);
            // Central differences: h² and rounding over h.
            assert!((stress[0] - ligament(r)).abs() < 1e-8, "{r}: {stress}");
        }
        let at_hole = elasticity * strain([0.0, 1.0]);
        assert!(
            at_hole[1].abs() < 1e-8 && at_hole[2].abs() < 1e-8,
            "{at_hole}"
        );
        let side = elasticity * strain([1.0, 0.0]);
        assert!(
            (side[1] + 1.0).abs() < 1e-8 && side[0].abs() < 1e-8,
            "{side}"
        );
    }
}
