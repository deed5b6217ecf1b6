//! Bonds break under the clip: a notched plate separates under every control, mirror-symmetric, its energies
//! balance; cracks beside and across the interface sever clipped bonds by their segments.

mod common;

use common::gripped_plate::*;
use common::*;
use peristitch::coupling::Coupling;
use peristitch::fields::damage::damage;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Ending, Problem, Record, Resolution, Until};
use peristitch::fracture::laws::StretchLimits;
use peristitch::fracture::programme::Programme;
use peristitch::fracture::response::Response;
use peristitch::fracture::state::State;
use peristitch::material::PlaneState;
use peristitch::model::{Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::bonds::family_offsets;
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics::StaticsError;

const THICKNESS: f64 = 0.7;
/// The interfaces lie here and at 0.08 m [m].
const INTERFACE: f64 = 0.02;
/// Prescribed on either grip per unit of the load factor [m]. With five times as much, one pass per step also
/// breaks bonds beside the interface, and no other control does.
const STEP: f64 = 1e-8;

struct Plate {
    model: Model,
    programme: Programme,
    laws: BondLaws,
}

impl Plate {
    fn new(cracks: &[Segment]) -> Plate {
        let settings = PeridynamicSettings {
            lattice: LatticeSettings::upright(DX, Placement::CellCentred, CellArea::Clipped),
            isotropised: true,
            surface_correction: SurfaceCorrection::Force,
            ..lattice_of_the_plate()
        };
        let (mesh, regions, cracks) = parts_of_the_plate(cracks, settings);
        let settings = ModelSettings {
            plane: PlaneState::Stress,
            thickness: THICKNESS,
            coupling: Coupling::Clip,
        };
        let model = Model::build(mesh, regions, settings).expect("a sound model");
        let model = model.with_cracks(&cracks);
        let law = brittle(&model);
        // As the pipeline has it: what clipping leaves between two sides of elements never breaks, and a
        // part of a bond takes the energy of the whole.
        let of_interaction = |s: usize| match model.regions_of_interaction(s) {
            Some(_) => law.part(model.length_share(s)).limits,
            None => StretchLimits::NONE,
        };
        let laws = BondLaws::brittle(
            (0..model.interactions.len()).map(of_interaction).collect(),
            (0..model.interactions.len() as u32).collect(),
        );
        let programme = Programme::proportional(pulled_apart(&model, STEP));
        Plate {
            model,
            programme,
            laws,
        }
    }

    fn run(&self, control: Control) -> (Ending, State, Vec<Record>) {
        let problem = Problem {
            model: &self.model,
            programme: &self.programme,
            laws: &self.laws,
            control,
            resolution: Resolution::Fast,
            until: Until {
                steps: 2000,
                separated: true,
            },
        };
        let mut records = Vec::new();
        let observe = |_: &State, record: Record, _: &Response| {
            records.push(record);
            Ok::<(), StaticsError>(())
        };
        let mut state = State::new(&self.model, &self.programme);
        let ending = control::run(&problem, &mut state, observe);
        (ending.expect("no error"), state, records)
    }

    /// Ends of the broken interactions in units of dx/10000, and those of their mirror images above and below,
    /// each sorted. The offset keeps positions away from where rounding decides.
    fn broken(&self, state: &State) -> [Vec<[[i64; 2]; 2]>; 2] {
        let (interactions, positions) = (&self.model.interactions, &self.model.positions);
        let key = |s: usize, mirrored: bool| {
            let mut ends = interactions.segment(s, positions).map(|[x, y]| {
                let y = if mirrored { 0.1 - y } else { y };
                [x, y].map(|c| (1e4 * c / DX + 0.137).round() as i64)
            });
            ends.sort_unstable();
            ends
        };
        [false, true].map(|mirrored| {
            let broken = (0..interactions.len()).filter(|&s| state.integrity[s] == 0.0);
            let mut keys: Vec<_> = broken.map(|s| key(s, mirrored)).collect();
            keys.sort_unstable();
            keys
        })
    }

    /// The largest damage of points within δ of an interface.
    fn damage_beside_the_interface(&self, integrity: &[f64]) -> f64 {
        let points = &self.model.positions[self.model.fe_node_count()..];
        let all = points.iter().zip(damage(&self.model, integrity));
        let beside = all.filter(|(x, _)| (x[1] - 0.05).abs() > 0.03 - 3.0 * DX);
        beside.map(|(_, damage)| damage).fold(0.0, f64::max)
    }

    /// Interactions that meet a segment, by the two parameters of the point where the lines cross.
    fn crossing(&self, [p, q]: Segment) -> usize {
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let from_to = |a: [f64; 2], b: [f64; 2]| [b[0] - a[0], b[1] - a[1]];
        let meets = |&s: &usize| {
            let [a, b] = self.model.interactions.segment(s, &self.model.positions);
            let (own, other, between) = (from_to(a, b), from_to(p, q), from_to(a, p));
            let area = cross(own, other);
            let parameters = [cross(between, other) / area, cross(between, own) / area];
            area != 0.0 && parameters.iter().all(|t| (0.0..=1.0).contains(t))
        };
        (0..self.model.interactions.len()).filter(meets).count()
    }

    fn severed(&self) -> impl Iterator<Item = usize> {
        (0..self.model.interactions.len()).filter(|&s| self.model.integrity[s] == 0.0)
    }

    /// Σ k ξ of what a crack severs [N]; the forces across it under a stretch of one are its components.
    fn severed_force(&self) -> f64 {
        let Model {
            interactions,
            positions,
            ..
        } = &self.model;
        let force = |s: usize| interactions.stiffness[s] * interactions.length(s, positions);
        self.severed().map(force).sum()
    }

    /// Σ ½ k ξ² / (c0 M3 h_t) of what a crack severs [m], as `crack_length_m` is.
    fn crack_length(&self) -> f64 {
        let Model {
            interactions,
            positions,
            ..
        } = &self.model;
        let micromodulus = &self.model.points[0].micromodulus;
        let rate = micromodulus.c0 * micromodulus.third_moment() * THICKNESS;
        // A part of a clipped bond takes the energy of the whole.
        let whole = |s: usize| {
            interactions.length(s, positions).powi(2) / self.model.length_share(s).min(1.0)
        };
        let energy = |s: usize| 0.5 * interactions.stiffness[s] * whole(s);
        self.severed().map(energy).sum::<f64>() / rate
    }
}

/// Σ k ξ over the bonds that a crack of `columns` dx along x severs in an endless lattice [N]: of each
/// family (a, b) dx, b > 0, there are b in each column.
fn force_across(plate: &Plate, columns: f64) -> f64 {
    let micromodulus = &plate.model.points[0].micromodulus;
    let families = family_offsets(micromodulus).into_iter();
    let of_family = families.filter(|[_, b]| *b > 0).map(|family| {
        let bond = family.map(|steps| f64::from(steps) * DX);
        let stiffness = micromodulus.axial_stiffness(bond, [DX * DX; 2], THICKNESS);
        f64::from(family[1]) * stiffness * bond[0].hypot(bond[1])
    });
    columns * of_family.sum::<f64>()
}

#[test]
fn a_notched_plate_separates_under_every_control() {
    let plate = Plate::new(&[[[0.0, 0.05], [0.05, 0.05]]]);
    for control in [
        Control::OnePass,
        Control::Equilibrium { most_passes: 500 },
        Control::EventDriven,
    ] {
        let (ending, state, records) = plate.run(control);
        let residual = records.iter().map(|r| r.residual).fold(0.0, f64::max);
        let [broken, mirrored] = plate.broken(&state);
        let energy = state.energy;
        let balance = (energy.external - energy.elastic - energy.dissipated) / energy.external;
        let beside = plate.damage_beside_the_interface(&state.integrity);
        assert_eq!(ending, Ending::Separated, "{control:?}");
        assert_eq!(broken, mirrored, "{control:?}");
        assert!(residual < 1e-12, "{control:?}: {residual:e}");
        assert!(balance.abs() < 1e-10, "{control:?}: {balance:e}");
        assert_eq!(beside, 0.0, "{control:?}");
    }
}

/// Twenty columns long, its tips on no lattice line, and a whole number of elements, so that the parts of
/// strips along it repeat.
fn level_crack(y: f64) -> Segment {
    let start = 0.025 + 0.137 * DX;
    [[start, y], [start + 20.0 * DX, y]]
}

/// A crack in the elements severs nothing, though bonds of the continued lattice would cross it. Of an endless
/// lattice's bonds it severs all, in force and in energy, but between the interface and the first row of points:
/// (dx from the interface, interactions, of them clipped, force, length).
#[test]
fn a_crack_beside_the_interface_severs_by_the_segments() {
    for y in [INTERFACE - 0.01 * DX, INTERFACE - DX] {
        assert_eq!(Plate::new(&[level_crack(y)]).severed().count(), 0, "{y}");
    }
    let nine_tenths = 0.991_12;
    for (rows, interactions, clipped, force, length) in [
        // Sites beside their points and the points themselves are not in one row, and it passes between them.
        (0.4, 302, 302, nine_tenths, 0.9938),
        (1.0, 322, 102, 1.0, 1.0013),
        (2.0, 340, 0, 1.0, 1.0013),
        (3.0, 360, 0, 1.0, 1.0013),
        (12.0, 360, 0, 1.0, 1.0013),
    ] {
        let crack = level_crack(INTERFACE + rows * DX);
        let plate = Plate::new(&[crack]);
        let pairs = plate.model.interactions.pairs().len();
        let found = plate.severed().count();
        assert_eq!(found, plate.crossing(crack), "{rows}");
        assert_eq!(found, interactions, "{rows}");
        assert_eq!(
            plate.severed().filter(|&s| s >= pairs).count(),
            clipped,
            "{rows}"
        );
        let found = plate.severed_force() / force_across(&plate, 20.0);
        let tolerance = if force == 1.0 { 1e-13 } else { 1e-5 };
        assert!((found - force).abs() < tolerance, "{rows}: {found}");
        // 1.0013: the lattice's own energy release rate along its axis over the mean of 0° and 45°.
        let found = plate.crack_length() / (20.0 * DX);
        assert!((found - length).abs() < 1e-4, "{rows}: {found}");
    }
}

/// A crack that runs from the elements across the interface into the lattice, or through it: it severs what its
/// part in the lattice meets, and reads that part's length to 0.15 dx at each interface.
#[test]
fn a_crack_across_the_interface_reads_its_length_in_the_lattice() {
    for x in [0.0513, 0.0522, 0.0537, 0.0549, 0.0561, 0.0588] {
        for (bottom, top, crossings) in [(0.01, 0.05 + 0.137 * DX, 1.0), (-0.01, 0.11, 2.0)] {
            let crack = [[x, bottom], [x, top]];
            let plate = Plate::new(&[crack]);
            assert_eq!(plate.severed().count(), plate.crossing(crack), "{crack:?}");
            let inside = f64::min(top, 0.08) - INTERFACE;
            let force = plate.severed_force() / force_across(&plate, inside / DX);
            // Lines are cut as a whole: some more or fewer at each end.
            assert_between(force, 0.985, 1.005, &format!("{crack:?}"));
            let missing = (inside - plate.crack_length()) / (crossings * DX);
            assert_between(missing, -0.05, 0.15, &format!("{crack:?}"));
        }
    }
}

/// Clipped bonds count in the damage of a point in the first row as their neighbours would. m = 3: 28
/// neighbours, 11 of them above; the one at δ below has no stiffness, and clipping leaves it out.
#[test]
fn clipped_bonds_count_as_damage() {
    for (y, expected) in [
        (INTERFACE + DX, 11.0 / 27.0),
        (INTERFACE + 0.01 * DX, 10.0 / 27.0),
    ] {
        let plate = Plate::new(&[[[0.0, y], [0.1, y]]]);
        let at = [20.5 * DX, INTERFACE + 0.5 * DX];
        let below = nearest(&plate.model.positions, at);
        let damage = damage(&plate.model, &plate.model.integrity);
        let found = damage[below - plate.model.fe_node_count()];
        assert!((found - expected).abs() < 1e-12, "{}", found * 27.0);
    }
}
