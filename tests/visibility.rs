//! Lattices in polygons of any shape, with holes and cracks: no bond leaves the body or crosses a crack,
//! none that stays inside is missing, and the areas of the points sum to the polygon's.
//!
//! What is asked is asked of a predicate of its own, in exact rational arithmetic of integers: all
//! corners and points are multiples of 2⁻²⁰, so that orientations are exact in 128 bits.

mod common;

use common::{Grid, name_cells, paper_lattice, region, steel};
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::cracks::Cracks;
use peristitch::geometry::{Outline, nearest_on_segment};
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::{CellKind, Edge, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::bonds::{bonds, family_offsets};
use peristitch::peridynamics::kernel::{Kernel, Micromodulus, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, Lattice, LatticeSettings, Placement, lattice};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::peridynamics::visibility::Visibility;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Coordinates are multiples of this.
const UNIT: f64 = 1.0 / 1_048_576.0;
const SPACING: f64 = 1.0 / 16.0;

type Point = [i128; 2];

fn snapped(x: f64) -> f64 {
    (x / UNIT).round() * UNIT
}

fn exact([x, y]: [f64; 2]) -> Point {
    [x, y].map(|x| {
        let units = x / UNIT;
        assert_eq!(units, units.round(), "{x} is a multiple of the unit");
        units as i128
    })
}

fn side(a: Point, b: Point, c: Point) -> i128 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).signum()
}

/// Whether two segments cross in the inside of both.
fn cross([a, b]: [Point; 2], [p, q]: [Point; 2]) -> bool {
    side(a, b, p) * side(a, b, q) < 0 && side(p, q, a) * side(p, q, b) < 0
}

fn on_segment([a, b]: [Point; 2], c: Point) -> bool {
    let within = |axis: usize| {
        let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
        low <= c[axis] && c[axis] <= high
    };
    side(a, b, c) == 0 && within(0) && within(1)
}

/// Whether two segments have a point in common.
fn meet(p: [Point; 2], q: [Point; 2]) -> bool {
    cross(p, q) || q.iter().any(|&x| on_segment(p, x)) || p.iter().any(|&x| on_segment(q, x))
}

struct Sides(Vec<[Point; 2]>);

impl Sides {
    fn of(outline: &Outline) -> Sides {
        Sides(outline.segments().map(|s| s.map(exact)).collect())
    }

    fn crossed(&self, bond: [[f64; 2]; 2]) -> bool {
        let bond = bond.map(exact);
        self.0.iter().any(|&side| cross(side, bond))
    }

    fn met(&self, bond: [[f64; 2]; 2]) -> bool {
        let bond = bond.map(exact);
        self.0.iter().any(|&side| meet(side, bond))
    }
}

fn micromodulus(m: f64) -> Micromodulus {
    let material = Material {
        young: 1.0,
        poisson: 1.0 / 3.0,
    };
    let plane = PlaneState::Stress;
    Micromodulus::new(
        Kernel::Constant,
        PartialArea::Full,
        &material,
        plane,
        m * SPACING,
        SPACING,
    )
}

/// A star-shaped polygon about (0, 0), counter-clockwise.
fn star(radii: &[f64], scale: f64) -> Vec<[f64; 2]> {
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / radii.len() as f64;
    let corner = |(k, r): (usize, &f64)| [r * angle(k).cos(), r * angle(k).sin()];
    let corners = radii.iter().enumerate().map(corner);
    corners.map(|c| c.map(|x| snapped(scale * x))).collect()
}

/// A comb: teeth of random widths and lengths on a bar, with slots between that may be narrower than dx.
fn comb(teeth: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let (mut x, mut upper) = (0.0, Vec::new());
    for &[tooth, slot, depth] in teeth {
        upper.extend([[x, 0.3 + depth], [x + tooth, 0.3 + depth]]);
        x += tooth;
        upper.extend([[x, 0.3], [x + slot, 0.3]]);
        x += slot;
    }
    let mut polygon = vec![[0.0, 0.0], [x, 0.0]];
    polygon.extend(upper.into_iter().rev());
    polygon.dedup();
    polygon.into_iter().map(|p| p.map(snapped)).collect()
}

/// The lattice's own points are no multiples of the unit where its box is not: anchored at the origin they are.
fn points_in(outline: &Outline) -> Lattice {
    let settings = LatticeSettings {
        origin: Some([0.0; 2]),
        ..LatticeSettings::upright(SPACING, Placement::CellCentred, CellArea::Clipped)
    };
    lattice(outline, &[], &settings)
}

/// Bonds are where they can be: none crosses the outline, and none is missing that does not meet it.
fn check(outline: &Outline, m: f64) -> Result<(), TestCaseError> {
    let points = points_in(outline);
    let sum: f64 = points.areas.iter().sum();
    // Some hundred cells of rounding errors of 1e-16; and a cell of which less than 1e-9 lacks counts as whole, so
    // that rough meshes give even areas: with sides on multiples of the unit that is a corner, one for each side.
    let nicks = 1e-9 * SPACING * SPACING * outline.segments().count() as f64;
    prop_assert!(
        (sum - outline.area()).abs() < 1e-12 * outline.area() + nicks,
        "{} {}",
        sum,
        outline.area()
    );
    prop_assert!(points.areas.iter().all(|&area| area > 0.0));
    let c = micromodulus(m);
    let view = Visibility::new(outline, SPACING, c.reach());
    let bonds = bonds(&points, &c, 1.0, 0, &view);
    let sides = Sides::of(outline);
    let found: BTreeSet<[u32; 2]> = bonds.pairs().iter().copied().collect();
    prop_assert_eq!(found.len(), bonds.pairs().len());
    for (i, &a) in points.positions.iter().enumerate() {
        for (j, &b) in points.positions.iter().enumerate().skip(i + 1) {
            if (b[0] - a[0]).hypot(b[1] - a[1]) > c.reach() {
                continue;
            }
            let is_bond = found.contains(&[i as u32, j as u32]);
            // One that passes a corner so near only grazes it, or ends there.
            let corners = || outline.loops.iter().flatten();
            let grazes = || corners().any(|&c| nearest_on_segment(c, [a, b]).1 < 2e-4 * SPACING);
            let crosses = is_bond && sides.crossed([a, b]) && !grazes();
            prop_assert!(!crosses, "{:?} {:?} crosses", a, b);
            prop_assert!(is_bond || sides.met([a, b]), "{:?} {:?} is missing", a, b);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn stars_with_holes(
        radii in prop::collection::vec(0.15..1.0f64, 3..14),
        hole in prop::collection::vec(0.02..0.1f64, 3..7),
        at in [-0.05..0.05f64, -0.05..0.05f64],
        holed in any::<bool>(),
        m in 2.0..4.5f64,
    ) {
        let mut outline = Outline { loops: vec![star(&radii, 1.0)] };
        if holed {
            let mut hole = star(&hole, 0.5);
            hole.reverse();
            hole.iter_mut().for_each(|x| *x = [snapped(x[0] + at[0]), snapped(x[1] + at[1])]);
            // The least radius of a star's side may be below that of its corners.
            let touches = Sides::of(&Outline { loops: vec![hole.clone()] });
            prop_assume!(outline.segments().all(|side| !touches.met(side)));
            prop_assume!(hole.iter().all(|&x| outline.contains(x)));
            outline.loops.push(hole);
        }
        check(&outline, m)?;
    }

    #[test]
    fn combs_with_slots_narrower_than_the_horizon(
        teeth in prop::collection::vec([0.01..0.3f64, 0.002..0.2f64, 0.05..0.6f64], 2..6),
        turned in any::<bool>(),
        m in 2.0..4.5f64,
    ) {
        let mut polygon = comb(&teeth);
        if turned {
            polygon.iter_mut().for_each(|x| *x = [-x[1], x[0]]);
        }
        check(&Outline { loops: vec![polygon] }, m)?;
    }

    /// A bond that a crack leaves intact does not touch it; one that it severs comes within a millionth of
    /// its length.
    #[test]
    fn cracks_sever_what_they_meet(
        corners in prop::collection::vec([-0.7..0.7f64, -0.7..0.7f64], 2..5),
        m in 2.0..4.5f64,
    ) {
        let corners: Vec<[f64; 2]> = corners.into_iter().map(|c| c.map(snapped)).collect();
        prop_assume!(corners.windows(2).all(|w| w[0] != w[1]));
        let edges: Vec<Edge> =
            (1..corners.len()).map(|k| Edge { ends: [k - 1, k], middle: None }).collect();
        let mesh = Mesh { nodes: corners.clone(), ..Mesh::default() };
        let cracks = Cracks::new(&mesh, &edges);
        let square = Outline { loops: vec![vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]] };
        let points = points_in(&square);
        let bonds = bonds(&points, &micromodulus(m), 1.0, 0, &Visibility::unlimited());
        let crack = Sides(corners.windows(2).map(|w| [exact(w[0]), exact(w[1])]).collect());
        for pair in bonds.pairs() {
            let [a, b] = pair.map(|i| points.positions[i as usize]);
            let severed = cracks.sever(a, b);
            prop_assert!(severed || !crack.met([a, b]), "{:?} {:?} meets the crack", a, b);
            prop_assert!(!severed || crack.met([a, b]) || is_within(&corners, [a, b], 1e-6 * 4.5 * SPACING));
        }
    }
}

fn is_within(crack: &[[f64; 2]], [a, b]: [[f64; 2]; 2], reach: f64) -> bool {
    let near = |p: [f64; 2], [a, b]: [[f64; 2]; 2]| nearest_on_segment(p, [a, b]).1 <= reach;
    crack.windows(2).any(|w| {
        let side = [w[0], w[1]];
        near(a, side) || near(b, side) || near(side[0], [a, b]) || near(side[1], [a, b])
    })
}

/// The families of points on either side of a slit of no width are cut off there.
#[test]
fn a_slit_of_no_width_parts_the_body() {
    let outline = Outline {
        loops: vec![vec![
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [0.0, 1.0],
            [0.0, 0.5],
            [1.0, 0.5],
            [0.0, 0.5],
        ]],
    };
    let points = points_in(&outline);
    let c = micromodulus(4.0);
    let view = Visibility::new(&outline, SPACING, c.reach());
    let bonds = bonds(&points, &c, 1.0, 0, &view);
    let family = |x: [f64; 2]| {
        let at = points.positions.iter().position(|&p| p == x);
        let at = at.expect("a point is there") as u32;
        bonds
            .pairs()
            .iter()
            .filter(|pair| pair.contains(&at))
            .count()
    };
    let offsets = family_offsets(&c);
    // Above the slit only what lies level with the point or above it.
    let upper = offsets.iter().filter(|[_, q]| *q >= 0).count();
    assert_eq!(family([0.5 + 0.5 * SPACING, 0.5 + 0.5 * SPACING]), upper);
    assert_eq!(
        family([1.5 + 0.5 * SPACING, 0.5 + 0.5 * SPACING]),
        offsets.len()
    );
    assert_eq!(upper, 28);
}

/// A notch narrower than δ beside an interface: no interaction with stiffness goes across, whatever ties the two
/// sides, and the points' damage does not count what was never there.
#[test]
fn no_coupling_reaches_across_a_notch() {
    for (name, coupling) in [
        ("truss", Coupling::Truss(NodeArea::Lumped)),
        ("clip", Coupling::Clip),
    ] {
        for correction in [SurfaceCorrection::Force, SurfaceCorrection::LeastSquares] {
            let grid = Grid {
                size: [2.0, 1.0],
                count: [40, 20],
                kind: CellKind::Quad4,
            };
            let mut mesh = grid.plain();
            let left = 1.1;
            let is_notch = |[x, y]: [f64; 2]| x > left && x < left + 0.05 && y > 0.5;
            let middle = left + 0.025;
            name_cells(&mut mesh, "elements", |x| x[0] < 1.0);
            name_cells(&mut mesh, "points", |x| x[0] > 1.0 && !is_notch(x));
            let settings = PeridynamicSettings {
                lattice: LatticeSettings::upright(0.04, Placement::CellCentred, CellArea::Clipped),
                isotropised: true,
                surface_correction: correction,
                ..paper_lattice(0.04, Placement::CellCentred)
            };
            let regions = vec![
                region(&mesh, &["elements"], steel(), Method::FiniteElements),
                region(&mesh, &["points"], steel(), Method::Peridynamics(settings)),
            ];
            let whole = ModelSettings {
                plane: PlaneState::Stress,
                thickness: 1.0,
                coupling,
            };
            let model = Model::build(mesh, regions, whole).expect("a sound model");
            let mut beside = 0;
            for interaction in 0..model.interactions.len() {
                let [a, b] = model.interactions.segment(interaction, &model.positions);
                let [from, to] = if a[0] < b[0] { [a, b] } else { [b, a] };
                if model.interactions.stiffness[interaction] == 0.0
                    || from[0] > middle
                    || to[0] < middle
                {
                    continue;
                }
                let y = from[1] + (middle - from[0]) / (to[0] - from[0]) * (to[1] - from[1]);
                assert!(y < 0.5 + 1e-6, "{name} {from:?} {to:?}");
                beside += 1;
            }
            assert!(beside > 100, "{name} {beside}");
            let damage = peristitch::fields::damage::damage(&model, &model.integrity);
            assert!(damage.iter().all(|d| d.abs() < 1e-12), "{name}");
        }
    }
}
