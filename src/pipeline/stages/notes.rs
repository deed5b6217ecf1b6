//! Notes on a model that are no errors: `check` and every run print the same.

use super::half_models;
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::geometry::Outline;
use crate::material::PlaneState;
use crate::model::{Method, Model, PointRegion};
use crate::pipeline::read::plan::{Plan, Probe};
use crate::pipeline::show::results::lattice_name;
use crate::support;
use std::f64::consts::PI;

/// All notes on a model, in their order.
pub fn notes(plan: &Plan, model: &Model, boundary: &Boundary) -> Vec<String> {
    let mut notes = Vec::new();
    notes.extend(cut_off(model, boundary));
    notes.extend(poisson(model));
    for points in &model.points {
        notes.extend(area(model, points));
        notes.extend(narrow(model, points));
        notes.extend(thin_members(model, points));
        notes.extend(coarse_outline(model, points));
    }
    notes.extend(half_models::notes(plan, model));
    notes.extend(
        plan.probes
            .iter()
            .filter_map(|probe| far_probe(model, probe)),
    );
    notes
}

/// Points that initial cracks leave without bonds.
fn cut_off(model: &Model, boundary: &Boundary) -> Option<String> {
    let loose = support::loose_parts(model, boundary, &model.integrity);
    let fragments = loose.iter().filter(|part| !part.touches_support);
    let lost: usize = fragments.map(|part| part.nodes.len()).sum();
    (lost > 0).then(|| {
        format!(
            "the cracks cut {lost} material points off; they do not move. A crack that lies on a row of points \
             is a slot two rows wide: move it, or the lattice's `origin`, by half a spacing"
        )
    })
}

/// Poisson's ratios outside these have cells whose error is known to be larger; the second in plane strain alone.
const MEASURED_POISSON: [f64; 2] = [0.0, 0.45];

/// Peridynamic regions with an unusual Poisson's ratio.
fn poisson(model: &Model) -> Option<String> {
    let [least, most] = MEASURED_POISSON;
    let is_unusual = |poisson: f64| {
        poisson < least || (poisson > most && model.settings.plane == PlaneState::Strain)
    };
    let regions = model.regions.iter();
    let mut points = regions.filter(|region| matches!(region.method, Method::Peridynamics(_)));
    let region = points.find(|region| is_unusual(region.material.poisson))?;
    Some(format!(
        "the region `{}` has ν = {}: its elasticity is exact, but free surfaces and cracks are off by more than \
         for 0 to {most}; look at docs/method.md",
        region.name, region.material.poisson
    ))
}

/// A lattice whose areas are off by more than this is worth a word: the paper's full cells on grid
/// nodes are.
const AREA_WARNING: f64 = 1e-6;

fn area(model: &Model, points: &PointRegion) -> Option<String> {
    // Where cells go on behind the interface, their areas need not sum to the region's.
    if !matches!(model.settings.coupling, Coupling::Truss(_)) {
        return None;
    }
    let first = model.fe_node_count();
    let areas = &model.areas[points.nodes.start - first..points.nodes.end - first];
    let share = areas.iter().sum::<f64>() / points.area;
    ((share - 1.0).abs() > AREA_WARNING).then(|| {
        format!(
            "the material points of `{}` stand for {:.2} % of its area",
            lattice_name(model, points),
            100.0 * share
        )
    })
}

/// Under two horizons no point has a whole family, and the correction of free surfaces is all that there is.
fn narrow(model: &Model, points: &PointRegion) -> Option<String> {
    let Method::Peridynamics(settings) = model.regions[points.region].method else {
        return None;
    };
    let [low, high] = settings.lattice.axes().outline(&points.outline).bounds();
    let width = [0, 1].map(|axis| (high[axis] - low[axis]) / settings.lattice.spacing);
    let width = width[0].min(width[1]);
    (width < 2.0 * settings.horizon_ratio * (1.0 - AREA_WARNING)).then(|| {
        format!(
            "the region `{}` is {width:.1} spacings wide, under 2 horizons, which are {} spacings: \
             choose a smaller `spacing`, or make it wider",
            lattice_name(model, points),
            2.0 * settings.horizon_ratio
        )
    })
}

/// The points of a region may stand for an area that differs by this share from its own.
const COUNTED_AREA: f64 = 0.25;

/// Regions of a joint lattice that it does not resolve. The mean width of a region is 2 A/P, with its
/// area A and perimeter P: the thickness of a layer or a ring, the radius of a disc.
fn thin_members(model: &Model, points: &PointRegion) -> Vec<String> {
    let members: Vec<usize> = model.members(points.region).collect();
    if members.len() < 2 {
        return Vec::new();
    }
    let spacing = points.micromodulus.spacing;
    let note = |&member: &usize| {
        let region = &model.regions[member];
        let outline = Outline::of_cells(&model.mesh, &region.cells);
        let length = |[a, b]: [[f64; 2]; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
        let perimeter: f64 = outline.segments().map(length).sum();
        let width = 2.0 * outline.area() / (perimeter * spacing);
        let is_own = |&node: &usize| model.region_of_point(node) == Some(member);
        let count = points.nodes.clone().filter(is_own).count();
        let share = count as f64 * spacing * spacing / outline.area();
        let is_thin = width < 1.0 && (share - 1.0).abs() > COUNTED_AREA;
        let held = match count {
            0 => "holds no material point".to_owned(),
            _ => format!(
                "holds {count} material points, {:.0} % of its area",
                100.0 * share
            ),
        };
        (is_thin || count == 0).then(|| {
            format!(
                "the region `{}` {held}, and is {width:.1} spacings wide in the mean: choose a smaller \
                 `spacing`, or make it wider",
                region.name
            )
        })
    };
    members.iter().filter_map(note).collect()
}

/// Sides that turn by angles within these are taken for chords of a curve [rad].
const TURNS: [f64; 2] = [PI / 180.0, 5.0 * PI / 12.0];

/// An outline of chords that stray from the curve that they stand for. A chord of length L between turns by
/// θ and θ' belongs to an arc of some (θ + θ')/2, and strays from it by L (θ + θ')/16.
fn coarse_outline(model: &Model, points: &PointRegion) -> Option<String> {
    let spacing = points.micromodulus.spacing;
    let mut most = [0.0; 3];
    for polygon in &points.outline.loops {
        let count = polygon.len();
        let side = |i: usize| {
            let [a, b] = [polygon[i % count], polygon[(i + 1) % count]];
            [b[0] - a[0], b[1] - a[1]]
        };
        let turn = |i: usize| {
            let [[ax, ay], [bx, by]] = [side(i + count - 1), side(i)];
            (ax * by - ay * bx).atan2(ax * bx + ay * by)
        };
        let arc = |i: usize| {
            let [first, second] = [turn(i), turn(i + 1)];
            let is_turn = |t: f64| (TURNS[0]..TURNS[1]).contains(&t.abs());
            (is_turn(first) && is_turn(second) && first * second > 0.0)
                .then(|| 0.5 * (first + second).abs())
        };
        for i in 0..count {
            // One such side alone may be a chamfer.
            let (Some(angle), Some(_)) = (arc(i), arc(i + 1).or(arc(i + count - 1))) else {
                continue;
            };
            let length = side(i)[0].hypot(side(i)[1]);
            let stray = length * angle / 8.0;
            if stray > most[0] {
                most = [stray, length, angle];
            }
        }
    }
    let [stray, length, angle] = most;
    (stray > 0.5 * spacing).then(|| {
        format!(
            "the outline of `{}` has straight sides of {:.3} mm that turn by {:.0} deg: if it is meant to be curved, \
             it strays from the curve by {:.3} mm, {:.1} spacings; mesh it with finer elements, or with \
             `Mesh.ElementOrder = 2`",
            lattice_name(model, points),
            1e3 * length,
            angle.to_degrees(),
            1e3 * stray,
            stray / spacing
        )
    })
}

/// A probe whose nodes are farther from its points than nodes are from each other.
fn far_probe(model: &Model, probe: &Probe) -> Option<String> {
    let nodes = probe.points.iter().map(|&at| model.nearest_node(at));
    let (node, distance) = nodes.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let [x, y] = model.positions[node].map(|x| 1e3 * x);
    (distance > spacing_at(model, node) * (1.0 + AREA_WARNING)).then(|| {
        format!(
            "the probe `{}` reads the node at ({x:.4}, {y:.4}) mm, {:.4} mm from its point: no node is nearer",
            probe.name,
            1e3 * distance
        )
    })
}

/// The distance between nodes at a node [m]: the spacing of its lattice, or the longest one within its elements.
fn spacing_at(model: &Model, node: usize) -> f64 {
    let lattice = model
        .points
        .iter()
        .find(|points| points.nodes.contains(&node));
    if let Some(points) = lattice {
        return points.micromodulus.spacing;
    }
    let [x, y] = model.positions[node];
    let nodes = (0..model.elements.len()).map(|element| model.element_nodes(element));
    let around = nodes
        .filter(|nodes| nodes.contains(&(node as u32)))
        .flatten();
    let distance = |n: u32| {
        let [a, b] = model.positions[n as usize];
        (a - x).hypot(b - y)
    };
    around.map(distance).fold(0.0, f64::max)
}
