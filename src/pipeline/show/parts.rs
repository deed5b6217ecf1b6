//! A moment of a run as VTU parts: finite elements, material points, bonds.

use crate::fields::damage::damage;
use crate::fields::points::PointFields;
use crate::fields::{NodalFields, stretches};
use crate::interactions::InteractionKind;
use crate::model::Model;
use crate::output::field::{Field, FieldName};
use crate::output::pvd;
use crate::output::vtu::{Part, PartCell};
use crate::output::write_whole;
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::ResultsError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::spec::OutputField;
use crate::pipeline::record::frames::Frame;
use crate::trace::Trace;
use std::path::Path;

/// Makes the parts.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub plan: &'a Plan,
    pub model: &'a Model,
}

/// The content of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PartKind {
    Elements,
    Points,
    Bonds,
}

impl PartKind {
    /// Its name in ParaView, and in the names of its files.
    fn names(self) -> [&'static str; 2] {
        match self {
            PartKind::Elements => ["finite elements", "elements"],
            PartKind::Points => ["material points", "points"],
            PartKind::Bonds => ["bonds", "bonds"],
        }
    }
}

/// Whether bonds can be broken: by cracks from the start, or by load.
pub(crate) fn has_damage(plan: &Plan) -> bool {
    !plan.cracks.is_empty() || plan.loading.is_some()
}

impl Parts<'_> {
    /// The parts that there are, in ParaView's order.
    pub fn kinds(&self) -> Vec<PartKind> {
        let Parts { plan, model } = self;
        let has_bonds = plan.output.bonds && !model.interactions.is_empty();
        let kinds = [
            (PartKind::Elements, !model.elements.is_empty()),
            (PartKind::Points, !model.areas.is_empty()),
            (PartKind::Bonds, has_bonds),
        ];
        let there = kinds.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(kind, _)| kind).collect()
    }

    /// The name of a part's file; `step` that of a fracture run.
    pub fn file(&self, kind: PartKind, step: Option<usize>) -> String {
        let [_, kind] = kind.names();
        let suffix = step.map_or_else(String::new, |step| format!("_{step:06}"));
        format!("{}_{kind}{suffix}.vtu", self.plan.name)
    }

    /// The lines of the series for one moment.
    pub fn entries(&self, step: Option<usize>) -> impl Iterator<Item = pvd::Entry> {
        let kinds = self.kinds().into_iter().enumerate();
        kinds.map(move |(part, kind)| pvd::Entry {
            time: step.unwrap_or(0) as f64,
            part,
            name: kind.names()[0].to_owned(),
            file: self.file(kind, step),
        })
    }

    /// Writes one part into `folder`.
    pub fn write(
        &self,
        kind: PartKind,
        frame: &Frame,
        step: Option<usize>,
        folder: &Path,
        trace: &Trace,
    ) -> Result<WrittenFile, ResultsError> {
        WrittenFile::measured(self.file(kind, step), trace, |name| {
            let part = match kind {
                PartKind::Elements => self.elements(frame),
                PartKind::Points => self.points(frame),
                PartKind::Bonds => self.bonds(frame),
            };
            let bytes = part.to_bytes()?;
            write_whole(&folder.join(name), &bytes)?;
            Ok([part.raw_bytes(), bytes.len() as u64])
        })
    }

    /// About the memory that the parts of a moment take while they are written [bytes].
    pub fn memory(&self) -> usize {
        let Parts { plan, model } = self;
        // Positions, fields and what is packed of them.
        let bonds = if plan.output.bonds {
            model.interactions.len()
        } else {
            0
        };
        600 * model.node_count() + 100 * bonds
    }

    fn wants(&self, field: OutputField) -> bool {
        self.plan.output.fields.contains(&field)
    }

    /// Finite elements: a point per node, and one more where materials meet.
    fn elements(&self, frame: &Frame) -> Part {
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

    fn points(&self, frame: &Frame) -> Part {
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
        let integrity = frame.integrity.to_vec();
        let PointFields { strain, stress } =
            PointFields::new(model, &frame.displacement, &integrity);
        if self.wants(OutputField::Stress) {
            part.point_data
                .push(Field::symmetric_tensor(FieldName::Stress, stress));
        }
        if self.wants(OutputField::Strain) {
            part.point_data
                .push(Field::symmetric_tensor(FieldName::Strain, strain));
        }
        if has_damage(self.plan) {
            let damage = damage(model, &integrity);
            part.point_data
                .push(Field::scalar(FieldName::Damage, damage));
        }
        part.point_data
            .push(Field::scalar(FieldName::Area, model.areas.clone()));
        part.point_data
            .push(Field::scalar(FieldName::Volume, volumes));
        let regions = (first..model.node_count()).filter_map(|node| model.region_of_point(node));
        let of_regions = self.region_fields(regions);
        // Glyphs and point sprites are coloured by point data, thresholds and extractions ask for cells.
        part.point_data.extend(of_regions.clone());
        part.cell_data.extend(of_regions);
        part
    }

    /// Bonds and trusses with stiffness.
    fn bonds(&self, frame: &Frame) -> Part {
        let model = self.model;
        let stiff: Vec<usize> = (model.interactions.axial())
            .filter(|&s| model.interactions.stiffness[s] != 0.0)
            .collect();
        let mut points = model.positions.clone();
        let mut u = frame.displacement.clone();
        let mut ends: Vec<[usize; 2]> = Vec::with_capacity(stiff.len());
        for &s in &stiff {
            if let Some(pair) = model.interactions.pair(s) {
                ends.push(pair.map(|n| n as usize));
            } else {
                // Interpolated ends are points of their own.
                ends.push([points.len(), points.len() + 1]);
                points.extend(model.interactions.segment(s, &model.positions));
                u.extend(model.interactions.end_displacements(s, &frame.displacement));
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
            .map(|&s| i32::from(model.interactions.kind(s) == InteractionKind::Truss))
            .collect();
        part.cell_data = vec![
            Field::scalar(FieldName::Stretch, of_stiff(&all)),
            Field::scalar(
                FieldName::Stiffness,
                of_stiff(&model.interactions.stiffness),
            ),
            Field::integer(FieldName::Truss, is_truss),
        ];
        if has_damage(self.plan) {
            let integrity = frame.integrity.to_vec();
            let intact = stiff.iter().map(|&s| i32::from(integrity[s] > 0.0));
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
}
