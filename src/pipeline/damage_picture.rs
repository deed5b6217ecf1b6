//! Pictures of the damage φ, eq. (7), of Qian et al. (2021): of the end, of chosen steps, and of the
//! latest state while a run goes. All have the colour scale 0 to 1, so that they compare.

use super::plan::Plan;
use crate::fracture::state;
use crate::geometry::chords;
use crate::model::Model;
use crate::output::picture::{Dot, FieldPicture, Square};

/// Damage of the last state; while a run goes, of the latest one.
pub const DAMAGE_PICTURE: &str = "damage.png";

/// The name of a step's picture in the results folder.
pub(super) fn damage_file(step: usize) -> String {
    format!("damage_{step:06}.png")
}

/// The damage where the springs are `intact`, at a step of a fracture run.
pub(super) fn damage_picture(
    plan: &Plan,
    model: &Model,
    step: Option<usize>,
    intact: &[bool],
) -> FieldPicture {
    let damage = state::damage(model, intact);
    let square = |(dot, value): (Dot, f64)| Square {
        centre: dot.centre,
        side: dot.side,
        value,
    };
    let cells = model
        .elements
        .iter()
        .map(|&(_, cell)| &model.mesh.cells[cell]);
    let edges = cells.flat_map(|cell| cell.edges());
    FieldPicture {
        title: match step {
            Some(step) => format!("{}: damage at step {step}", plan.name),
            None => format!("{}: damage", plan.name),
        },
        quantity: "damage".to_owned(),
        range: Some([0.0, 1.0]),
        squares: dots(model).into_iter().zip(damage).map(square).collect(),
        lines: edges.map(|edge| chords(&edge, &model.mesh.nodes)).collect(),
        ..FieldPicture::default()
    }
}

/// Every material point, in the order of the nodes.
pub(super) fn dots(model: &Model) -> Vec<Dot> {
    let dot = |node: usize, side: f64| Dot {
        centre: model.positions[node],
        side,
        region: model.region_of_point(node).expect("a material point"),
    };
    let points = model.points.iter();
    let dots = points.flat_map(|p| p.nodes.clone().map(|n| dot(n, p.micromodulus.spacing)));
    dots.collect()
}
