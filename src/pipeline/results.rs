//! What a run leaves in `results/NAME/`: VTU parts and their PVD, pictures, `summary.json`.

use super::fracture::{Frame, read_frame};
use super::history::Line;
use super::plan::{Plan, Probe};
use super::run::RunError;
use super::solved::Solved;
use super::spec::OutputField;
use crate::boundary::Boundary;
use crate::fields::points::PointFields;
use crate::fields::{NodalFields, stretches};
use crate::fracture::state;
use crate::model::{Method, Model};
use crate::output::field::{Field, FieldName};
use crate::output::picture::PictureError;
use crate::output::pvd::{self, PvdError};
use crate::output::vtu::{Part, PartCell, VtuError};
use crate::phases::Phases;
use crate::statics::group_reactions;
use serde_json::{Value, json};
use std::path::Path;
use thiserror::Error;

#[derive(Debug, Error)]
pub enum ResultsError {
    #[error(transparent)]
    Vtu(#[from] VtuError),
    #[error(transparent)]
    Pvd(#[from] PvdError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Write(#[from] crate::output::WriteError),
}

/// All that the results are made of.
pub struct Outcome<'a> {
    pub plan: &'a Plan,
    pub model: &'a Model,
    pub boundary: &'a Boundary,
    pub solved: &'a Solved,
    pub gmsh_version: &'a str,
}

impl Outcome<'_> {
    /// Writes everything but the summary into `folder` and returns the files' names.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub fn write(&self, folder: &Path, phases: &mut Phases) -> Result<Vec<String>, RunError> {
        let mut files = phases.measure("vtu", || self.write_parts(folder))?;
        if self.plan.output.pictures {
            files.extend(phases.measure("pictures", || self.write_pictures(folder))?);
        }
        Ok(files)
    }

    /// One set of parts, or one for each frame of a fracture run.
    fn write_parts(&self, folder: &Path) -> Result<Vec<String>, RunError> {
        let mut files = Vec::new();
        let mut entries = Vec::new();
        match &self.solved.fracture {
            None => {
                let frame = Frame {
                    step: 0,
                    load_factor: 1.0,
                    displacement: self.solved.solution.displacement.clone(),
                    intact: self.model.intact.clone(),
                };
                self.write_frame(&frame, "", folder, &mut files, &mut entries)?;
            }
            Some(course) => {
                for &step in &course.frames {
                    let frame = read_frame(&self.plan.folder, step)?;
                    let suffix = format!("_{step:06}");
                    self.write_frame(&frame, &suffix, folder, &mut files, &mut entries)?;
                }
            }
        }
        let series = format!("{}.pvd", self.plan.name);
        pvd::write(&folder.join(&series), &entries).map_err(ResultsError::from)?;
        files.push(series);
        Ok(files)
    }

    fn write_frame(
        &self,
        frame: &Frame,
        suffix: &str,
        folder: &Path,
        files: &mut Vec<String>,
        entries: &mut Vec<pvd::Entry>,
    ) -> Result<(), ResultsError> {
        let mut parts = Vec::new();
        if !self.model.elements.is_empty() {
            parts.push(("finite elements", "elements", self.element_part(frame)));
        }
        if !self.model.areas.is_empty() {
            parts.push(("material points", "points", self.point_part(frame)));
        }
        if self.plan.output.bonds && !self.model.springs.is_empty() {
            parts.push(("bonds", "bonds", self.bond_part(frame)));
        }
        for (index, (title, kind, part)) in parts.into_iter().enumerate() {
            let file = format!("{}_{kind}{suffix}.vtu", self.plan.name);
            part.write(&folder.join(&file))?;
            entries.push(pvd::Entry {
                time: frame.step as f64,
                part: index,
                name: title.to_owned(),
                file: file.clone(),
            });
            files.push(file);
        }
        Ok(())
    }

    /// Whether bonds can be broken: by cracks from the start, or by load.
    pub(super) fn has_damage(&self) -> bool {
        !self.plan.cracks.is_empty() || self.plan.loading.is_some()
    }

    fn wants(&self, field: OutputField) -> bool {
        self.plan.output.fields.contains(&field)
    }

    /// Finite elements: a point per node, and one more where materials meet.
    fn element_part(&self, frame: &Frame) -> Part {
        let model = self.model;
        let nodal = NodalFields::new(model, &frame.displacement);
        let at = |values: &[[f64; 2]]| nodal.nodes.iter().map(|&n| values[n as usize]).collect();
        let mut part = Part::new(at(&model.positions));
        for (element, copies) in nodal.element_copies.iter().enumerate() {
            part.push_cell(PartCell::Surface(model.cell(element).kind), copies);
        }
        if self.wants(OutputField::Displacement) {
            part.point_data.push(Field::vector(
                FieldName::Displacement,
                at(&frame.displacement),
            ));
        }
        let (stress, strain) = (nodal.stress, nodal.strain);
        if self.wants(OutputField::Stress) {
            part.point_data
                .push(Field::symmetric_tensor(FieldName::Stress, stress));
        }
        if self.wants(OutputField::Strain) {
            part.point_data
                .push(Field::symmetric_tensor(FieldName::Strain, strain));
        }
        let region = |&(region, _): &(usize, usize)| region;
        part.cell_data
            .extend(self.region_fields(model.elements.iter().map(region)));
        part
    }

    fn point_part(&self, frame: &Frame) -> Part {
        let model = self.model;
        let first = model.fe_node_count();
        let mut part = Part::of_vertices(model.positions[first..].to_vec());
        if self.wants(OutputField::Displacement) {
            let u = frame.displacement[first..].to_vec();
            part.point_data
                .push(Field::vector(FieldName::Displacement, u));
        }
        let volumes = model
            .areas
            .iter()
            .map(|a| a * model.settings.thickness)
            .collect();
        let PointFields { strain, stress } =
            PointFields::new(model, &frame.displacement, &frame.intact);
        if self.wants(OutputField::Stress) {
            part.point_data
                .push(Field::symmetric_tensor(FieldName::Stress, stress));
        }
        if self.wants(OutputField::Strain) {
            part.point_data
                .push(Field::symmetric_tensor(FieldName::Strain, strain));
        }
        if self.has_damage() {
            let damage = state::damage(model, &frame.intact);
            part.point_data
                .push(Field::scalar(FieldName::Damage, damage));
        }
        part.point_data
            .push(Field::scalar(FieldName::Area, model.areas.clone()));
        part.point_data
            .push(Field::scalar(FieldName::Volume, volumes));
        let regions = (first..model.node_count()).filter_map(|node| model.region_of_point(node));
        part.cell_data.extend(self.region_fields(regions));
        part
    }

    /// Bonds and trusses with stiffness.
    fn bond_part(&self, frame: &Frame) -> Part {
        let model = self.model;
        let stiff: Vec<usize> = (0..model.springs.len())
            .filter(|&s| model.springs.stiffness[s] != 0.0)
            .collect();
        let mut points = model.positions.clone();
        let mut u = frame.displacement.clone();
        let mut ends: Vec<[usize; 2]> = Vec::with_capacity(stiff.len());
        for &s in &stiff {
            if let Some(pair) = model.springs.pairs().get(s) {
                ends.push(pair.map(|n| n as usize));
            } else {
                // Interpolated ends are points of their own.
                ends.push([points.len(), points.len() + 1]);
                points.extend(model.springs.segment(s, &model.positions));
                u.extend(model.springs.end_displacements(s, &frame.displacement));
            }
        }
        let mut part = Part::of_lines(points, &ends);
        if self.wants(OutputField::Displacement) {
            part.point_data
                .push(Field::vector(FieldName::Displacement, u));
        }
        let all = stretches(model, &frame.displacement);
        let of_stiff = |values: &[f64]| stiff.iter().map(|&s| values[s]).collect();
        let is_truss = stiff
            .iter()
            .map(|&s| i32::from(model.is_truss(s)))
            .collect();
        part.cell_data = vec![
            Field::scalar(FieldName::Stretch, of_stiff(&all)),
            Field::scalar(FieldName::Stiffness, of_stiff(&model.springs.stiffness)),
            Field::integer(FieldName::Truss, is_truss),
        ];
        if self.has_damage() {
            let intact = stiff.iter().map(|&s| i32::from(frame.intact[s]));
            let intact = Field::integer(FieldName::Intact, intact.collect());
            part.cell_data.push(intact);
        }
        part
    }

    fn region_fields(&self, regions: impl Iterator<Item = usize>) -> [Field; 2] {
        let regions: Vec<usize> = regions.collect();
        let names: Vec<&String> = self.plan.spec.materials.keys().collect();
        let material = |&region: &usize| {
            let name = &self.plan.regions[region].material_name;
            names
                .iter()
                .position(|n| *n == name)
                .map_or(-1, |index| index as i32)
        };
        let materials = regions.iter().map(material).collect();
        [
            Field::integer(
                FieldName::Region,
                regions.iter().map(|&r| r as i32).collect(),
            ),
            Field::integer(FieldName::Material, materials),
        ]
    }

    /// `summary.json`.
    pub fn summary(&self, files: &[String], phases: &Phases, peak_memory: Option<u64>) -> Value {
        let model = self.model;
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
            "versions": { "peristitch": env!("CARGO_PKG_VERSION"), "gmsh": self.gmsh_version },
            "sizes": {
                "finite_elements": count(|m| *m == Method::FiniteElements),
                "finite_element_nodes": model.fe_node_count() - model.inner_nodes().len(),
                "material_points": model.areas.len(),
                "bonds": model.bond_count,
                "trusses": model.springs.pairs().len() - model.bond_count,
                "clipped_bonds": if model.splice.is_some() { 0 } else { model.springs.len() - model.springs.pairs().len() },
                "ghost_bonds": model.splice.as_ref().map_or(0, |s| s.ghosts.len()),
                "overlap_elements": model.splice.as_ref().map_or(0, |s| s.overlap.len()),
                "dofs": self.solved.solution.size.dofs,
                "stiffness_entries": self.solved.solution.size.stiffness_entries,
                "method": self.solved.solution.size.method.describe(),
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
            "phases": phases.list.iter().map(|phase| json!({
                "phase": phase.name,
                "count": phase.count,
                "seconds": phase.time.as_secs_f64(),
                "share": phase.time.as_secs_f64() / phases.total().as_secs_f64(),
            })).collect::<Vec<_>>(),
            "seconds": phases.total().as_secs_f64(),
            "peak_memory_bytes": peak_memory,
            "files": files,
        })
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
        let inner = self.model.inner_nodes();
        let node = (0..positions.len())
            .filter(|node| !inner.contains(node))
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
pub(super) fn lattice_name(model: &Model, points: &crate::model::PointRegion) -> String {
    let members = model.members(points.region);
    let names: Vec<&str> = members.map(|r| model.regions[r].name.as_str()).collect();
    names.join("+")
}
