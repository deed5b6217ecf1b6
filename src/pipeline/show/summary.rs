//! The numbers of a run for `summary.json`.

use super::results::{Outcome, lattice_name};
use crate::fracture::envelope::peak;
use crate::geometry::edge_length;
use crate::gmsh;
use crate::model::{Method, PointRegion};
use crate::pipeline::account::costs::Costs;
use crate::pipeline::account::summary::{
    Event, FractureSummary, InterfaceSummary, LatticeSummary, ProbeSummary, Sizes, Summary,
};
use crate::pipeline::read::plan::Probe;
use crate::pipeline::record::history::HistoryLine;
use crate::statics::group_reactions;
use serde_json::{Value, json};
use std::collections::BTreeMap;

impl Outcome<'_> {
    pub(crate) fn summary(&self, files: Vec<String>, costs: &Costs) -> Summary {
        let solution = &self.solved.solution;
        let course = self.solved.fracture.as_ref();
        let outcome = course.map_or("solved", |course| course.ending.describe());
        Summary {
            name: self.plan.name.clone(),
            study: self.plan.study.clone(),
            pipeline: self.plan.source.path.display().to_string(),
            outcome: outcome.to_owned(),
            fracture: self.fracture_summary(),
            versions: self.versions(),
            parameters: self.parameters(),
            sizes: self.sizes(),
            lattices: self.lattices(),
            interfaces: self.interfaces(),
            probes: self.plan.probes.iter().map(|p| self.probe(p)).collect(),
            reactions_n: group_reactions(self.boundary, &solution.reaction),
            warnings: Vec::new(),
            residual: solution.residual,
            costs: costs.summary(solution.size),
            files,
        }
    }

    fn versions(&self) -> BTreeMap<String, String> {
        let origin = &self.extract.origin;
        let own = env!("CARGO_PKG_VERSION").to_owned();
        BTreeMap::from([
            ("peristitch".to_owned(), own),
            (origin.program.to_lowercase(), origin.version.clone()),
        ])
    }

    fn parameters(&self) -> BTreeMap<String, Value> {
        let plain = |value: &gmsh::Value| match value {
            gmsh::Value::Number(number) => json!(number),
            gmsh::Value::Text(text) => json!(text),
        };
        let values = self.extract.parameters.iter();
        values
            .map(|(name, value)| (name.clone(), plain(value)))
            .collect()
    }

    fn sizes(&self) -> Sizes {
        let model = self.model;
        let size = self.solved.solution.size;
        let fem = model.regions.iter();
        let fem = fem.filter(|region| region.method == Method::FiniteElements);
        Sizes {
            finite_elements: fem.map(|region| region.cells.len()).sum(),
            finite_element_nodes: model.fe_node_count(),
            material_points: model.areas.len(),
            bonds: model.interactions.bonds().len(),
            trusses: model.interactions.trusses().len(),
            clipped_bonds: model.interactions.clipped_bonds().len(),
            dofs: size.dofs,
            stiffness_entries: size.stiffness_entries,
            method: size.backend.describe().to_owned(),
            factor_entries: size.factor_entries,
        }
    }

    fn lattices(&self) -> Vec<LatticeSummary> {
        let model = self.model;
        let first = model.fe_node_count();
        let lattice = |points: &PointRegion| {
            let areas = &model.areas[points.nodes.start - first..points.nodes.end - first];
            LatticeSummary {
                region: lattice_name(model, points),
                points: points.nodes.len(),
                spacing_m: points.micromodulus.spacing,
                horizon_m: points.micromodulus.horizon,
                points_area_m2: areas.iter().sum(),
                region_area_m2: points.area,
            }
        };
        model.points.iter().map(lattice).collect()
    }

    fn interfaces(&self) -> Vec<InterfaceSummary> {
        let model = self.model;
        let interfaces = model.topology.interfaces.iter();
        let summaries = interfaces.map(|interface| InterfaceSummary {
            finite_elements: model.regions[interface.finite_elements].name.clone(),
            peridynamics: model.regions[interface.peridynamics].name.clone(),
            edges: interface.edges.len(),
            length_m: interface
                .edges
                .iter()
                .map(|e| edge_length(e, &model.mesh.nodes))
                .sum(),
        });
        summaries.collect()
    }

    fn fracture_summary(&self) -> Option<FractureSummary> {
        let course = self.solved.fracture.as_ref()?;
        let lines = || course.history.iter();
        let peak = lines().max_by(|a, b| a.reaction.total_cmp(&b.reaction));
        let loading = self.plan.loading.as_ref();
        let names = loading.map(|loading| loading.phases.iter().map(|phase| phase.name.clone()));
        let written = self.plan.spec.loading.as_ref();
        Some(FractureSummary {
            first_break: lines().find(|line| line.bonds_broken > 0).map(Event::from),
            peak: peak.map(Event::from),
            end: course.history.last().map(Event::from),
            control: written.map(|loading| loading.control),
            stopped_because: course.reason.clone(),
            fragments: course.fragments.clone(),
            phases: names.map(Iterator::collect),
            envelope_peak: envelope_peak(&course.history),
            bonds_broken: course
                .history
                .last()
                .map_or(0, |line| line.bonds_broken_total),
            crack_length_m: course.history.last().map(|line| line.crack_length),
            largest_residual: lines().map(|line| line.residual).fold(0.0, f64::max),
            frames: course.frames.clone(),
            reference: written.map(|loading| loading.reference),
        })
    }

    fn probe(&self, probe: &Probe) -> ProbeSummary {
        let nodes: Vec<(usize, f64)> = (probe.points.iter())
            .map(|&at| self.model.nearest_node(at))
            .collect();
        let displacement = |k: usize| self.solved.solution.displacement[nodes[k].0][probe.axis];
        let value = match nodes.len() {
            1 => displacement(0),
            _ => displacement(1) - displacement(0),
        };
        let position = |&(node, _): &(usize, f64)| self.model.positions[node];
        ProbeSummary {
            name: probe.name.clone(),
            component: ["x", "y"][probe.axis].to_owned(),
            at_m: position(&nodes[0]),
            to_m: nodes.get(1).map(position),
            distance_m: nodes
                .iter()
                .map(|(_, distance)| *distance)
                .fold(0.0, f64::max),
            displacement_m: value,
            reference_m: probe.reference,
            error: probe.reference.map(|reference| value / reference - 1.0),
        }
    }
}

impl From<&HistoryLine> for Event {
    fn from(line: &HistoryLine) -> Event {
        Event {
            step: line.step,
            load_factor: line.load_factor,
            grip_displacement_m: line.grip_displacement,
            reaction_n: line.reaction,
        }
    }
}

/// The largest load of the last phase that stood alone on the path: there, a load that only grows would
/// have broken the body.
fn envelope_peak(history: &[HistoryLine]) -> Option<Event> {
    let phase = history.last()?.phase;
    let lines: Vec<&HistoryLine> = history.iter().filter(|line| line.phase == phase).collect();
    let factors: Vec<f64> = lines.iter().map(|line| line.load_factor).collect();
    let peak = lines[peak(&factors)?];
    Some(Event::from(peak))
}
