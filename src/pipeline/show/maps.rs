//! Maps of displacement and stress on the deformed shape.

use super::deformed::Deformed;
use crate::fields::NodalFields;
use crate::fields::points::PointFields;
use crate::fields::stress::{largest_principal, von_mises};
use crate::model::Model;
use crate::output::picture::FieldPicture;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::spec::PictureKind;
use crate::pipeline::record::frames::Frame;

/// The component or invariant of σ that a stress map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Measure {
    Xx,
    Yy,
    Xy,
    /// The largest principal stress, that out of the plane included.
    Principal,
    VonMises,
}

impl Measure {
    /// The measure of the stress xx, yy, zz, xy [Pa].
    fn of(self, stress: [f64; 4]) -> f64 {
        let [xx, yy, _, xy] = stress;
        match self {
            Measure::Xx => xx,
            Measure::Yy => yy,
            Measure::Xy => xy,
            Measure::Principal => largest_principal(stress),
            Measure::VonMises => von_mises(stress),
        }
    }

    /// The picture of this stress, as the pipeline names it.
    fn kind(self) -> PictureKind {
        match self {
            Measure::Xx => PictureKind::StressXx,
            Measure::Yy => PictureKind::StressYy,
            Measure::Xy => PictureKind::StressXy,
            Measure::Principal => PictureKind::PrincipalStress,
            Measure::VonMises => PictureKind::VonMises,
        }
    }

    /// The name of its picture.
    pub fn stem(self) -> &'static str {
        match self {
            Measure::Xx => "stress_xx",
            Measure::Yy => "stress_yy",
            Measure::Xy => "stress_xy",
            Measure::Principal => "principal_stress",
            Measure::VonMises => "von_mises",
        }
    }

    /// Caption in a report.
    pub fn describe(self) -> &'static str {
        match self {
            Measure::Xx => "Stress σ_xx",
            Measure::Yy => "Stress σ_yy",
            Measure::Xy => "Stress σ_xy",
            Measure::Principal => "Largest principal stress",
            Measure::VonMises => "Von Mises stress",
        }
    }

    /// In words, and as a symbol.
    fn names(self) -> [&'static str; 2] {
        match self {
            Measure::Xx => ["stress σ_xx", "σ_xx"],
            Measure::Yy => ["stress σ_yy", "σ_yy"],
            Measure::Xy => ["stress σ_xy", "σ_xy"],
            Measure::Principal => ["largest principal stress", "σ_1"],
            Measure::VonMises => ["von Mises stress", "σ_vM"],
        }
    }
}

/// u_x or u_y.
pub(crate) fn displacement_map(
    plan: &Plan,
    model: &Model,
    axis: usize,
    step: Option<usize>,
    displacement: &[[f64; 2]],
) -> FieldPicture {
    let body = Deformed::new(plan, model, displacement);
    let nodes: Vec<Vec<u32>> = (0..model.elements.len())
        .map(|element| model.element_nodes(element))
        .collect();
    let symbol = format!("u_{}", ['x', 'y'][axis]);
    let points = &displacement[model.fe_node_count()..];
    let (squares, pieces) = body.squares(points.iter().map(|u| u[axis]));
    let kind = [PictureKind::DisplacementX, PictureKind::DisplacementY][axis];
    FieldPicture {
        title: title(plan, &format!("displacement {symbol}"), step),
        quantity: symbol,
        unit: "m".to_owned(),
        is_signed: true,
        deformation_scale: body.exaggeration,
        facets: body.facets(|element, node| displacement[nodes[element][node] as usize][axis]),
        squares,
        pieces,
        range: plan.colour_ranges.get(&kind).copied(),
        percentiles: plan.output.percentiles,
        lines: body.interfaces(),
        ..FieldPicture::default()
    }
}

/// σ at the elements' nodes, averaged where elements of one material meet, and at the material points.
pub(crate) fn stress_map(
    plan: &Plan,
    model: &Model,
    measure: Measure,
    step: Option<usize>,
    frame: &Frame,
) -> FieldPicture {
    let body = Deformed::new(plan, model, &frame.displacement);
    let nodal = NodalFields::new(model, &frame.displacement);
    let points = PointFields::new(model, &frame.displacement, &frame.integrity.to_vec());
    let [words, symbol] = measure.names();
    let stresses = points.stress.iter();
    let (squares, pieces) = body.squares(stresses.map(|&stress| measure.of(stress)));
    FieldPicture {
        title: title(plan, words, step),
        quantity: symbol.to_owned(),
        unit: "Pa".to_owned(),
        is_signed: true,
        deformation_scale: body.exaggeration,
        facets: body
            .facets(|element, node| measure.of(nodal.stress[nodal.element_copies[element][node]])),
        squares,
        pieces,
        range: plan.colour_ranges.get(&measure.kind()).copied(),
        percentiles: plan.output.percentiles,
        lines: body.interfaces(),
        ..FieldPicture::default()
    }
}

/// The pipeline's name, what is shown, and when.
pub(crate) fn title(plan: &Plan, what: &str, step: Option<usize>) -> String {
    match step {
        Some(step) => titled(plan, &format!("{what} at step {step}")),
        None => titled(plan, what),
    }
}

/// The title of a picture; empty where the pipeline wants none.
pub(crate) fn titled(plan: &Plan, what: &str) -> String {
    match (&plan.study, plan.output.titles) {
        (_, false) => String::new(),
        (Some(study), true) => format!("{study}, {}: {what}", plan.name),
        (None, true) => format!("{}: {what}", plan.name),
    }
}
