//! A plan and a mesh to the discretisation; what does not fit is told at its key in the pipeline.

mod errors;

use super::{joints, positions, probes};
use crate::boundary::{Boundary, BoundaryError};
use crate::cracks::Cracks;
use crate::fracture::bond_laws::{BondLaws, Breakable};
use crate::fracture::laws::Strength;
use crate::fracture::programme::{LoadPhase, Programme};
use crate::geometry::Outline;
use crate::mesh::Mesh;
use crate::model::{self, Model, Region};
use crate::pipeline::read::plan::{Condition, Displaced, Plan};
use crate::pipeline::read::source::{InputError, choices, quoted};
use crate::support::{self, NotHeld};
use errors::{boundary_error, model_error};

/// Builds the model and its boundary conditions and checks that the body is held.
///
/// # Errors
/// The first thing that does not fit.
pub fn discretise(plan: &Plan, mut mesh: Mesh) -> Result<(Model, Boundary), InputError> {
    let mut regions = regions(plan, &mesh)?;
    positions::add_groups(plan, &mut mesh, &regions)?;
    check_groups(plan, &mesh)?;
    let cracks = cracks(plan, &mesh)?;
    check_no_fail(plan, &mesh)?;
    joints::check(plan, &mesh, &regions)?;
    let by_default: Vec<bool> = plan.regions.iter().map(|r| r.angle_by_default).collect();
    model::turn_lattices(&mesh, &mut regions, &by_default);
    let model = Model::build(mesh, regions, plan.model).map_err(|e| model_error(plan, &e))?;
    let model = model.with_cracks(&cracks);
    let boundary = programme(plan, &model)?.phases.swap_remove(0).boundary;
    let model = model.with_node_axes(&boundary.node_axes);
    support::check(&model, &boundary).map_err(|error| not_held(plan, &model, &error))?;
    probes::check(plan, &model)?;
    Ok((model, boundary))
}

/// Supports and loads of the body.
///
/// # Errors
/// A condition that does not fit the mesh, or another condition.
pub fn programme(plan: &Plan, model: &Model) -> Result<Programme, InputError> {
    let Some(loading) = &plan.loading else {
        return Ok(Programme::proportional(boundary(plan, model, 0)?));
    };
    let phase = |(index, phase): (usize, &crate::pipeline::read::plan::PhasePlan)| {
        Ok(LoadPhase {
            name: phase.name.clone(),
            boundary: boundary(plan, model, index)?,
            increment: phase.increment,
            end: phase.end,
        })
    };
    let phases: Result<Vec<LoadPhase>, InputError> =
        loading.phases.iter().enumerate().map(phase).collect();
    let probes = plan
        .probes
        .iter()
        .map(|probe| probes::functional(model, probe));
    let programme = Programme::new(phases?).with_probes(probes);
    Ok(programme.controlled_by(loading.by))
}

/// The conditions of one phase; what the other phases move is held.
fn boundary(plan: &Plan, model: &Model, phase: usize) -> Result<Boundary, InputError> {
    let mut boundary = Boundary::new(model);
    let fail = |index: usize, error: BoundaryError| boundary_error(plan, index, &error);
    let conditions = || plan.conditions.iter().enumerate();
    let is_own = |condition: &Condition| condition.phase.is_none_or(|p| p == phase);
    for (index, condition) in conditions().filter(|(_, c)| is_own(c)) {
        apply(&mut boundary, model, condition).map_err(|e| fail(index, e))?;
    }
    for (index, condition) in conditions().filter(|(_, c)| !is_own(c)) {
        let Some(Displaced {
            directions,
            components,
        }) = condition.displacement
        else {
            continue;
        };
        let components = components.map(|u| u.is_some());
        let held = boundary.hold_along(model, &condition.group, directions, components);
        held.map_err(|e| fail(index, e))?;
    }
    Ok(boundary)
}

fn not_held(plan: &Plan, model: &Model, error: &NotHeld) -> InputError {
    if let Some(unjoined) = joints::unjoined(plan, model).into_iter().next() {
        return plan
            .source
            .error("boundary", error.to_string(), Some(unjoined));
    }
    let holding = plan
        .conditions
        .iter()
        .filter(|condition| condition.displacement.is_some());
    let help = format!(
        "prescribe a displacement that prevents it. Displacements are prescribed on {}; groups of \
         the mesh: {}",
        quoted(
            &holding
                .map(|condition| condition.group.as_str())
                .collect::<Vec<_>>()
        ),
        quoted(&boundary_groups(&model.mesh).collect::<Vec<_>>())
    );
    plan.source.error("boundary", error.to_string(), Some(help))
}

fn apply(
    boundary: &mut Boundary,
    model: &Model,
    condition: &Condition,
) -> Result<(), BoundaryError> {
    let group = &condition.group;
    if let Some(displaced) = condition.displacement {
        boundary.displace_along(model, group, displaced.directions, displaced.components)?;
    }
    for &load in &condition.loads {
        boundary.add_traction(model, group, load)?;
    }
    if let Some(force) = condition.force {
        boundary.add_force(model, group, force)?;
    }
    if let Some(density) = condition.body_force {
        boundary.add_body_force(model, group, density)?;
    }
    Ok(())
}

/// Checks that the groups that the pipeline names are in a mesh, of which the names are enough.
///
/// # Errors
/// The first group that is not.
pub(super) fn check_names(plan: &Plan, mesh: &Mesh) -> Result<(), InputError> {
    regions(plan, mesh)?;
    check_groups(plan, mesh)?;
    cracks(plan, mesh)?;
    check_no_fail(plan, mesh)
}

fn regions(plan: &Plan, mesh: &Mesh) -> Result<Vec<Region>, InputError> {
    let region = |(index, planned): (usize, &crate::pipeline::read::plan::RegionPlan)| {
        let mut cells = Vec::new();
        for (k, group) in planned.groups.iter().enumerate() {
            match mesh.surfaces.get(group) {
                Some(of_group) => cells.extend(of_group),
                None => return Err(unknown_surface(plan, mesh, [index, k])),
            }
        }
        cells.sort_unstable();
        cells.dedup();
        Ok(Region {
            name: planned.name(),
            cells,
            material: planned.material,
            method: planned.method,
        })
    };
    plan.regions.iter().enumerate().map(region).collect()
}

/// `at`: the region, and the group within it.
fn unknown_surface(plan: &Plan, mesh: &Mesh, at: [usize; 2]) -> InputError {
    let [index, k] = at;
    let group = &plan.regions[index].groups[k];
    let file = plan.geometry.file.display();
    let message = if mesh.curves.contains_key(group) || mesh.points.contains_key(group) {
        format!("group `{group}` of {file} is no surface, and a region is made of surfaces")
    } else {
        format!("there is no physical surface `{group}` with elements in {file}")
    };
    let help = group_help("Surface", group, mesh.surfaces.keys().map(String::as_str));
    plan.source
        .error(&format!("regions/{index}/group/{k}"), message, Some(help))
}

/// The groups that there are; a number may be meant for one of the geometry's plain entities.
fn group_help<'a>(kind: &str, given: &str, valid: impl IntoIterator<Item = &'a str>) -> String {
    let choices = choices(given, valid);
    match given.parse::<u64>() {
        Ok(number) => format!(
            "a number names a physical group without a name, not a plain {}: add \
             `Physical {kind}(\"NAME\") = {{{number}}};` to the geometry and write NAME; {choices}",
            kind.to_lowercase()
        ),
        Err(_) => choices,
    }
}

fn boundary_groups(mesh: &Mesh) -> impl Iterator<Item = &str> {
    mesh.curves
        .keys()
        .chain(mesh.points.keys())
        .map(String::as_str)
}

fn check_groups(plan: &Plan, mesh: &Mesh) -> Result<(), InputError> {
    for condition in &plan.conditions {
        let group = &condition.group;
        let on_surface = condition.body_force.is_some();
        let acts_else = condition.displacement.is_some()
            || !condition.loads.is_empty()
            || condition.force.is_some();
        if on_surface && !mesh.surfaces.contains_key(group) {
            let file = plan.geometry.file.display();
            let message = format!("there is no physical surface `{group}` in {file}");
            let help = group_help("Surface", group, mesh.surfaces.keys().map(String::as_str));
            let key = format!("{}/group", condition.key);
            return Err(plan.source.error(&key, message, Some(help)));
        }
        if (acts_else || !on_surface) && !boundary_groups(mesh).any(|name| name == group) {
            let file = plan.geometry.file.display();
            let message = if mesh.surfaces.contains_key(group) {
                format!(
                    "group `{group}` of {file} is a surface, and `boundary` acts on curves and points; \
                     only a `body_force` acts on surfaces"
                )
            } else {
                format!("there is no physical curve or point `{group}` in {file}")
            };
            let help = format!(
                "{}; or select by position: `where: {{ x: min }}` in place of `group`",
                group_help("Curve", group, boundary_groups(mesh))
            );
            return Err(plan.source.error(
                &format!("{}/group", condition.key),
                message,
                Some(help),
            ));
        }
    }
    Ok(())
}

fn cracks(plan: &Plan, mesh: &Mesh) -> Result<Cracks, InputError> {
    let mut edges = Vec::new();
    for (index, name) in plan.cracks.iter().enumerate() {
        let Some(curve) = mesh.curves.get(name) else {
            let file = plan.geometry.file.display();
            let message = format!("there is no physical curve `{name}` in {file}");
            let help = group_help("Curve", name, mesh.curves.keys().map(String::as_str));
            return Err(plan
                .source
                .error(&format!("cracks/{index}"), message, Some(help)));
        };
        edges.extend_from_slice(curve);
    }
    Ok(Cracks::new(mesh, &edges))
}

/// The law of every interaction. Bonds with an end in a `no_fail` surface never break, nor do trusses
/// unless the pipeline says so.
pub fn laws(plan: &Plan, model: &Model) -> BondLaws {
    let strengths: Vec<Option<Strength>> = plan.regions.iter().map(|r| r.strength).collect();
    let breakable = Breakable {
        strengths: &strengths,
        unbreakable: &unbreakable_points(plan, model),
        trusses: plan.trusses_break,
    };
    BondLaws::of_model(model, &breakable)
}

fn check_no_fail(plan: &Plan, mesh: &Mesh) -> Result<(), InputError> {
    let is_unknown = |name: &String| !mesh.surfaces.contains_key(name);
    let Some(index) = plan.no_fail.iter().position(is_unknown) else {
        return Ok(());
    };
    let name = &plan.no_fail[index];
    let file = plan.geometry.file.display();
    let message = format!("there is no physical surface `{name}` in {file}");
    let help = choices(name, mesh.surfaces.keys().map(String::as_str));
    let key = format!("no_fail/{index}");
    Err(plan.source.error(&key, message, Some(help)))
}

fn unbreakable_points(plan: &Plan, model: &Model) -> Vec<bool> {
    let mut unbreakable = vec![false; model.node_count()];
    for name in &plan.no_fail {
        let cells = model.mesh.surfaces.get(name);
        let outline = Outline::of_cells(&model.mesh, cells.map_or(&[], Vec::as_slice));
        let points = unbreakable.iter_mut().zip(&model.positions);
        for (unbreakable, &position) in points.skip(model.fe_node_count()) {
            *unbreakable |= outline.contains(position);
        }
    }
    unbreakable
}
