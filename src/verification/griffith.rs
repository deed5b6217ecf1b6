//! A long crack in a clamped strip, grown by the event-driven control.
//!
//! ```text
//!   ┌──────────────────┐  clamped, moved up by u/2
//!   │     elements     │
//!   ├··················┤
//!   │──────── points   │  the crack from the left end, along the middle
//!   ├··················┤
//!   │     elements     │
//!   └──────────────────┘  clamped, moved down by u/2
//! ```
//!
//! Far ahead of the tip the strip of height H is stretched with ε_x = 0, far behind it there is nothing:
//! whatever the tip is like, each step forward releases W H with W = ½ E/(1 − ν²) (u/H)² (Rivlin &
//! Thomas 1953). So the crack grows, however long it is, at
//!
//! u = √(2 G0 H (1 − ν²)/E)
//!
//! On a lattice the tip is held between two columns of points, and the opening goes up and down as the
//! crack grows, each tooth between 0.97 and 1.17 of that: the middle of the teeth is measured. It is
//! above 1, since bonds do not break all at their limit at once: what the earlier ones let go stretches
//! on, and the energy of a column is Σ ½ k e e' with the elongation e' after the break, more than
//! Σ ½ k e².

use super::bodies::{build, default_lattice, material, region};
use super::{Check, Reference, VerificationError};
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::cracks::Cracks;
use crate::fracture::bond_laws::{BondLaws, Breakable};
use crate::fracture::control::{self, Control, Problem, Record, Resolution, Until};
use crate::fracture::laws::Strength;
use crate::fracture::programme::Programme;
use crate::fracture::response::Response;
use crate::fracture::state::State;
use crate::mesh::grid::{Grid, name_cells, name_curve};
use crate::mesh::{CellKind, Edge};
use crate::model::{Method, Model};

/// Lengths in spacings; dx, E and G0 are 1.
const LENGTH: usize = 192;
const HEIGHT: usize = 40;
const BAND: usize = 24;
const CRACK: usize = 72;
/// Columns that the crack is to grow by.
const GROWTH: usize = 8;

/// The opening per unit of the load factor: the one at which the crack should grow.
fn opening() -> f64 {
    let nu: f64 = 1.0 / 3.0;
    (2.0 * HEIGHT as f64 * (1.0 - nu * nu)).sqrt()
}

fn strip() -> Result<Model, VerificationError> {
    let (w, h) = (LENGTH as f64, HEIGHT as f64);
    let grid = Grid {
        size: [w, h],
        count: [LENGTH / 4, HEIGHT / 4],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    let off = |y: f64| (y - 0.5 * h).abs() - 0.5 * BAND as f64;
    name_cells(&mut mesh, "band", |[_, y]| off(y) < 0.0);
    name_cells(&mut mesh, "grips", |[_, y]| off(y) > 0.0);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    name_curve(&mut mesh, "top", |[_, y]| y > h - 1e-9);
    let first = mesh.nodes.len();
    mesh.nodes.extend([[0.0, 0.5 * h], [CRACK as f64, 0.5 * h]]);
    let crack = Edge {
        ends: [first, first + 1],
        middle: None,
    };
    let cracks = Cracks::new(&mesh, &[crack]);
    let regions = vec![
        region(&mesh, &["grips"], material(1.0), Method::FiniteElements),
        region(
            &mesh,
            &["band"],
            material(1.0),
            Method::Peridynamics(default_lattice(1.0)),
        ),
    ];
    Ok(build(mesh, regions, Coupling::Clip)?.with_cracks(&cracks))
}

/// The result of the growth.
#[derive(Clone, Debug)]
pub struct Growth {
    /// (crack length in spacings, opening over Griffith's, energy that broken bonds took over G0 dx h_t)
    /// of every event.
    pub path: Vec<[f64; 3]>,
    /// Bonds that broke without their mirror image, and all that broke.
    pub unmirrored: usize,
    /// Interactions that broke, in their order.
    pub broken: Vec<u32>,
    /// Bonds that broke and do not cross the crack's line.
    pub off_line: usize,
    /// Largest |external work − elastic − dissipated energy| over the external work.
    pub imbalance: f64,
}

impl Growth {
    /// The middle between the ends of each tooth: of each column that the tip passes.
    pub fn teeth(&self) -> Vec<f64> {
        let columns = CRACK..CRACK + GROWTH;
        let tooth = |column: usize| {
            let within = self
                .path
                .iter()
                .filter(|[a, ..]| (a + 1e-9) as usize == column);
            let ends = within.fold([f64::INFINITY, 0.0], |[low, high], &[_, u, _]| {
                [f64::min(low, u), f64::max(high, u)]
            });
            0.5 * (ends[0] + ends[1])
        };
        // The first is not whole: the initial tip is sharper than a grown one.
        columns
            .skip(1)
            .map(tooth)
            .filter(|mean| mean.is_finite())
            .collect()
    }

    /// Energy of broken bonds per area of new crack over G0: the slope of the straight line through all
    /// events behind the first column.
    pub fn energy_per_area(&self) -> f64 {
        let within = || self.path.iter().filter(|[a, ..]| *a > (CRACK + 1) as f64);
        let count = within().count() as f64;
        let mean = |k: usize| within().map(|event| event[k]).sum::<f64>() / count;
        let (a, energy) = (mean(0), mean(2));
        let [mixed, squared] = within().fold([0.0; 2], |[mixed, squared], event| {
            let off = event[0] - a;
            [mixed + off * (event[2] - energy), squared + off * off]
        });
        mixed / squared
    }
}

/// Grows the crack.
///
/// # Errors
/// Errors of building and solving.
pub fn grow(resolution: Resolution) -> Result<Growth, VerificationError> {
    let model = strip()?;
    let mut boundary = Boundary::new(&model);
    for (group, sign) in [("top", 0.5), ("bottom", -0.5)] {
        boundary.displace(&model, group, [Some(0.0), Some(sign * opening())])?;
    }
    let programme = Programme::proportional(boundary);
    let micromodulus = &model.points[0].micromodulus;
    let strengths = vec![Some(Strength::EnergyReleaseRate(1.0)); model.regions.len()];
    let laws = BondLaws::of_model(
        &model,
        &Breakable {
            strengths: &strengths,
            unbreakable: &vec![false; model.node_count()],
            trusses: false,
        },
    );
    let critical = laws.first_limits(0).tension;
    // The energy of one column of the cut.
    let column = micromodulus.c0 * micromodulus.third_moment() * critical.powi(2);
    let energy_at_limit = |interaction: usize| {
        let e = critical * model.interactions.length(interaction, &model.positions);
        0.5 * model.interactions.stiffness[interaction] * e * e / column
    };
    let problem = Problem {
        model: &model,
        programme: &programme,
        laws: &laws,
        control: Control::EventDriven,
        until: Until {
            steps: 12 * GROWTH,
            separated: true,
        },
        resolution,
    };
    let mut state = State::new(&model, &programme);
    let (mut path, mut imbalance) = (Vec::new(), 0.0f64);
    let observe = |state: &State, _: Record, _: &Response| {
        let gone = model
            .interactions
            .bonds()
            .filter(|&s| model.integrity[s] > state.integrity[s]);
        // The bonds of this event have broken at its load.
        let now: f64 = (state.fresh_changes().iter())
            .map(|change| energy_at_limit(change.interaction as usize))
            .sum();
        let length = CRACK as f64 + gone.map(energy_at_limit).sum::<f64>() - now;
        let energy = state.energy;
        path.push([length, state.load.factor, energy.dissipated]);
        let rest = energy.external - energy.elastic - energy.dissipated;
        imbalance = imbalance.max((rest / energy.external).abs());
        Ok::<(), VerificationError>(())
    };
    control::run(&problem, &mut state, observe)?;
    let gone: Vec<usize> = model
        .interactions
        .bonds()
        .filter(|&s| model.integrity[s] > state.integrity[s])
        .collect();
    if gone.is_empty() {
        return Err(VerificationError::NothingBroken);
    }
    let is_off_line = |interaction: &&usize| {
        let [a, b] = model.interactions.segment(**interaction, &model.positions);
        (a[1] - 0.5 * HEIGHT as f64) * (b[1] - 0.5 * HEIGHT as f64) >= 0.0
    };
    Ok(Growth {
        path,
        unmirrored: unmirrored(&model, &gone),
        broken: state.broken(),
        off_line: gone.iter().filter(is_off_line).count(),
        imbalance,
    })
}

/// Number of broken bonds whose mirror image is whole.
fn unmirrored(model: &Model, gone: &[usize]) -> usize {
    let key = |interaction: usize, turn: bool| {
        let ends = model.interactions.segment(interaction, &model.positions);
        let ends = ends.map(|[x, y]| {
            let y = if turn { HEIGHT as f64 - y } else { y };
            [x, y].map(|x| (2.0 * x).round() as i64)
        });
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    };
    let own: std::collections::BTreeSet<_> = gone.iter().map(|&s| key(s, false)).collect();
    let alone = gone.iter().filter(|&&s| !own.contains(&key(s, true)));
    alone.count()
}

pub fn measure() -> Result<Vec<Check>, VerificationError> {
    let growth = grow(Resolution::Fast)?;
    let reference = grow(Resolution::Reference)?;
    let order = growth.broken.iter().zip(&reference.broken);
    let differing = order.filter(|(fast, slow)| fast != slow).count();
    let differing = differing + growth.broken.len().abs_diff(reference.broken.len());
    let loads = growth.path.iter().zip(&reference.path);
    let apart = loads.map(|(fast, slow)| (fast[1] / slow[1] - 1.0).abs());
    let apart = apart.fold(0.0, f64::max);
    let teeth = growth.teeth();
    let mean = teeth.iter().sum::<f64>() / teeth.len() as f64;
    Ok(vec![
        Check {
            case: "Griffith, clamped strip",
            quantity: "mean opening over √(2G0H(1−ν²)/E)",
            reference: Reference::Value {
                value: 1.0,
                within: 0.1,
            },
            source: "Rivlin & Thomas (1953)",
            measured: mean,
        },
        Check {
            case: "Griffith, clamped strip",
            quantity: "energy per area over G0",
            reference: Reference::Between {
                low: 1.0,
                high: 1.25,
            },
            source: "no less than the cut's; lattice trapping",
            measured: growth.energy_per_area(),
        },
        Check {
            case: "Griffith, clamped strip",
            quantity: "imbalance of energy",
            reference: Reference::Zero { within: 1e-10 },
            source: "exact",
            measured: growth.imbalance,
        },
        Check {
            case: "Griffith, clamped strip",
            quantity: "bonds broken off the crack's line",
            reference: Reference::Zero { within: 0.0 },
            source: "symmetry",
            measured: growth.off_line as f64,
        },
        Check {
            case: "solver equivalence",
            quantity: "bonds broken in another order than refactorised",
            reference: Reference::Zero { within: 0.0 },
            source: "exact",
            measured: differing as f64,
        },
        Check {
            case: "solver equivalence",
            quantity: "largest difference of λ, relative",
            reference: Reference::Zero { within: 1e-9 },
            source: "exact",
            measured: apart,
        },
        Check {
            case: "mirror symmetry",
            quantity: "bonds broken on one side only",
            reference: Reference::Zero { within: 0.0 },
            source: "exact",
            measured: growth.unmirrored as f64,
        },
    ])
}
