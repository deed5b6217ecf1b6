//! What a run leaves in `results/NAME/`: VTU parts and their PVD, pictures, `summary.json`.

use super::animation::Reel;
use super::parts::{Parts, has_damage};
use super::workshop::Workshop;
use crate::boundary::Boundary;
use crate::gmsh::{self, Extract};
use crate::model::{Method, Model};
use crate::phases::Phases;
use crate::pipeline::account::costs::Costs;
use crate::pipeline::account::made::Made;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::{Plan, Probe};
use crate::pipeline::record::history::Line;
use crate::pipeline::record::solved::Solved;
use crate::statics::group_reactions;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// All that the results are made of.
pub struct Outcome<'a> {
    pub plan: &'a Plan,
    pub model: &'a Model,
    pub boundary: &'a Boundary,
    pub solved: &'a Solved,
    /// Where the mesh comes from.
    pub extract: &'a Extract,
}

impl Outcome<'_> {
    /// Writes everything but the summary and the report into `folder`, and returns its files and the
    /// pictures that the report moves through.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub(crate) fn write(
        &self,
        folder: &Path,
        phases: &mut Phases,
    ) -> Result<(Vec<Made>, Option<Reel>), RunError> {
        let workshop = Workshop {
            outcome: self,
            folder,
            trace: phases.trace().clone(),
        };
        let mut made = phases.measure("vtu", || workshop.parts())?;
        made.push(workshop.view()?);
        if !self.plan.output.pictures.is_none() {
            made.extend(phases.measure("pictures", || workshop.pictures())?);
        }
        let output = &self.plan.output;
        let is_shown = output.is_animated() || output.is_reported();
        let Some(course) = self.solved.fracture.as_ref().filter(|_| is_shown) else {
            return Ok((made, None));
        };
        let draw = || Reel::new(self.plan, self.model, course);
        let reel = phases.measure("animation", draw)?;
        if output.is_animated() {
            let film = || reel.film(folder, &workshop.trace);
            made.push(phases.measure("animation", film)?);
        }
        Ok((made, Some(reel)))
    }

    pub(crate) fn parts(&self) -> Parts<'_> {
        Parts {
            plan: self.plan,
            model: self.model,
        }
    }

    pub(crate) fn has_damage(&self) -> bool {
        has_damage(self.plan)
    }

    /// `summary.json`.
    pub(crate) fn summary(&self, files: &[String], costs: &Costs) -> Value {
        let model = self.model;
        let [phases, behind, seconds] = costs.times();
        let count = |method: fn(&Method) -> bool| {
            model
                .regions
                .iter()
                .filter(|r| method(&r.method))
                .map(|r| r.cells.len())
                .sum::<usize>()
        };
        json!({
            "name": self.plan.name,
            "pipeline": self.plan.source.path.display().to_string(),
            "outcome": self.ending(),
            "fracture": self.fracture_summary(),
            "versions": self.versions(),
            "parameters": self.parameters(),
            "sizes": {
                "finite_elements": count(|m| *m == Method::FiniteElements),
                "finite_element_nodes": model.fe_node_count(),
                "material_points": model.areas.len(),
                "bonds": model.springs.bonds().len(),
                "trusses": model.springs.trusses().len(),
                "clipped_bonds": model.springs.clipped_bonds().len(),
                "dofs": self.solved.solution.size.dofs,
                "stiffness_entries": self.solved.solution.size.stiffness_entries,
                "method": self.solved.solution.size.backend.describe(),
                "factor_entries": self.solved.solution.size.factor_entries,
            },
            "lattices": model.points.iter().map(|p| self.lattice_summary(p)).collect::<Vec<_>>(),
            "interfaces": model.interfaces.iter().map(|i| json!({
                "finite_elements": model.regions[i.finite_elements].name,
                "peridynamics": model.regions[i.peridynamics].name,
                "edges": i.edges.len(),
                "length_m": i.edges.iter().map(|e| model.edge_length(e)).sum::<f64>(),
            })).collect::<Vec<_>>(),
            "probes": self.plan.probes.iter().map(|p| self.probe(p)).collect::<Vec<_>>(),
            "reactions_n": group_reactions(self.boundary, &self.solved.solution.reaction),
            "residual": self.solved.solution.residual,
            "phases": phases,
            "seconds": seconds,
            "behind": behind,
            "written": costs.written(),
            "memory": costs.memory(self.solved.solution.size),
            "peak_memory_bytes": costs.peak_memory,
            "files": files,
        })
    }

    /// Of this program and of the one that the mesh comes from.
    fn versions(&self) -> BTreeMap<String, &str> {
        let origin = &self.extract.origin;
        BTreeMap::from([
            ("peristitch".to_owned(), env!("CARGO_PKG_VERSION")),
            (origin.program.to_lowercase(), origin.version.as_str()),
        ])
    }

    /// Of the geometry, as it was meshed.
    fn parameters(&self) -> BTreeMap<&String, Value> {
        let plain = |value: &gmsh::Value| match value {
            gmsh::Value::Number(number) => json!(number),
            gmsh::Value::Text(text) => json!(text),
        };
        let values = self.extract.parameters.iter();
        values.map(|(name, value)| (name, plain(value))).collect()
    }

    fn ending(&self) -> &'static str {
        let course = self.solved.fracture.as_ref();
        course.map_or("solved", |course| course.ending.describe())
    }

    /// Onset, peak and end of a fracture run.
    fn fracture_summary(&self) -> Option<Value> {
        let course = self.solved.fracture.as_ref()?;
        let first = course.history.iter().find(|line| line.bonds_broken > 0);
        let peak = course
            .history
            .iter()
            .max_by(|a, b| a.reaction.total_cmp(&b.reaction));
        let point = |line: &Line| {
            json!({
                "step": line.step,
                "load_factor": line.load_factor,
                "grip_displacement_m": line.grip_displacement,
                "reaction_n": line.reaction,
            })
        };
        Some(json!({
            "first_break": first.map(point),
            "peak": peak.map(point),
            "end": course.history.last().map(point),
            "control": self.plan.spec.loading.as_ref().map(|loading| loading.control),
            "stopped_because": course.reason,
            "fragments": course.fragments,
            "phases": self.plan.loading.as_ref().map(|loading| {
                loading.phases.iter().map(|phase| &phase.name).collect::<Vec<_>>()
            }),
            "envelope_peak": envelope_peak(&course.history),
            "bonds_broken": course.history.last().map_or(0, |line| line.bonds_broken_total),
            "crack_length_m": course.history.last().map(|line| line.crack_length),
            "largest_residual": course.history.iter().map(|l| l.residual).fold(0.0, f64::max),
            "frames": course.frames,
            "reference": self.plan.spec.loading.as_ref().map(|loading| loading.reference),
        }))
    }

    fn lattice_summary(&self, points: &crate::model::PointRegion) -> Value {
        let first = self.model.fe_node_count();
        let areas = &self.model.areas[points.nodes.start - first..points.nodes.end - first];
        json!({
            "region": lattice_name(self.model, points),
            "points": points.nodes.len(),
            "spacing_m": points.micromodulus.spacing,
            "horizon_m": points.micromodulus.horizon,
            "points_area_m2": areas.iter().sum::<f64>(),
            "region_area_m2": points.area,
        })
    }

    fn probe(&self, probe: &Probe) -> Value {
        let positions = &self.model.positions;
        let distance =
            |n: usize| (positions[n][0] - probe.at[0]).hypot(positions[n][1] - probe.at[1]);
        let node = (0..positions.len())
            .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
            .expect("a model has nodes");
        let value = self.solved.solution.displacement[node][probe.axis];
        let component = ["x", "y"][probe.axis];
        json!({
            "name": probe.name,
            "component": component,
            "at_m": positions[node],
            "displacement_m": value,
            "reference_m": probe.reference,
            "error": probe.reference.map(|reference| value / reference - 1.0),
        })
    }
}

/// The largest load of the last phase that stood alone on the path: there, a load that only grows would
/// have broken the body.
fn envelope_peak(history: &[Line]) -> Option<Value> {
    let phase = history.last()?.phase;
    let lines = history.iter().filter(|line| line.phase == phase);
    let peak = lines.max_by(|a, b| a.load_factor.total_cmp(&b.load_factor))?;
    Some(json!({
        "step": peak.step,
        "load_factor": peak.load_factor,
        "grip_displacement_m": peak.grip_displacement,
        "reaction_n": peak.reaction,
    }))
}

/// The names of the regions that one lattice covers.
pub(crate) fn lattice_name(model: &Model, points: &crate::model::PointRegion) -> String {
    let members = model.members(points.region);
    let names: Vec<&str> = members.map(|r| model.regions[r].name.as_str()).collect();
    names.join("+")
}
