//! The numbers of a run for `summary.json`.

use super::results::{Outcome, lattice_name};
use crate::geometry::edge_length;
use crate::gmsh;
use crate::model::{Method, PointRegion};
use crate::pipeline::account::costs::Costs;
use crate::pipeline::account::summary::{
    DrivenBy, Event, FractureSummary, InterfaceSummary, LatticeSummary, ProbeSummary, Sizes,
    Summary,
};
use crate::pipeline::read::plan::Probe;
use crate::pipeline::record::events;
use crate::pipeline::record::history::HistoryLine;
use crate::pipeline::record::solved::FractureRun;
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
        let history = &course.history;
        let event = |line: Option<&HistoryLine>| Some(self.event(course, line?));
        let loading = self.plan.loading.as_ref();
        let names = loading.map(|loading| loading.phases.iter().map(|phase| phase.name.clone()));
        let written = self.plan.spec.loading.as_ref();
        Some(FractureSummary {
            driven_by: match events::is_driven_by_forces(history) {
                true => DrivenBy::Forces,
                false => DrivenBy::Displacements,
            },
            first_break: self.first_break(course),
            peak: event(events::peak(history)),
            end: event(history.last()),
            force_left: course.force_left,
            control: written.map(|loading| loading.control),
            stopped_because: course.reason.clone(),
            fragments: course.fragments.clone(),
            phases: names.map(Iterator::collect),
            envelope_peak: event(events::largest_load_factor(history)),
            bonds_broken: history.last().map_or(0, |line| line.bonds_broken_total),
            crack_length_m: history.last().map(|line| line.crack_length),
            largest_residual: history.iter().map(|line| line.residual).fold(0.0, f64::max),
            frames: course.frames.clone(),
            reference: written.map(|loading| loading.reference),
        })
    }

    fn event(&self, course: &FractureRun, line: &HistoryLine) -> Event {
        let by_forces = events::is_driven_by_forces(&course.history);
        let factor = line.load_share * line.load_factor;
        Event {
            step: line.step,
            load_factor: line.load_factor,
            grip_displacement_m: line.grip_displacement,
            reaction_n: line.reaction,
            load_n: by_forces
                .then(|| factor * self.unit_load())
                .filter(|_| line.phase == 0),
            at_m: None,
        }
    }

    /// Sum of the amounts of the nodal forces at λ = 1 in the first phase [N].
    pub(crate) fn unit_load(&self) -> f64 {
        let (forces, _) = self.boundary.load.as_chunks::<2>();
        forces.iter().map(|[x, y]| x.hypot(*y)).sum()
    }

    /// The first break with the reaction under which it happened, and the middle of the bond.
    fn first_break(&self, course: &FractureRun) -> Option<Event> {
        let line = events::first_break(&course.history)?;
        let at = course.first_broken.map(|bond| {
            let model = self.model;
            let [a, b] = model.interactions.segment(bond as usize, &model.positions);
            [0, 1].map(|axis| (a[axis] + b[axis]) / 2.0)
        });
        Some(Event {
            reaction_n: line.breaking_reaction,
            at_m: at,
            ..self.event(course, line)
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
