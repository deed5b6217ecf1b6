//! Pictures of the damage φ, eq. (7), of Qian et al. (2021): of the end, of chosen steps, and of the
//! latest state while a run goes. All have the colour scale 0 to 1, so that they compare.

use super::plan::Plan;
use super::results::ResultsError;
use crate::fracture::state;
use crate::geometry::chords;
use crate::model::Model;
use crate::output::picture::{Dot, FieldPicture, Square};
use std::time::{Duration, Instant};

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

/// How often the picture of a run that goes is drawn again: seldom enough to cost under a hundredth
/// of the run's time.
const LATEST_EVERY: Duration = Duration::from_secs(5);

/// `damage.png` while a run goes: from the first break on, of a state a few seconds old at most. What
/// it shows depends on the clock, so it is no result: it is taken away when the solve stage ends, and
/// the output stage draws the last state.
#[derive(Default)]
pub(super) struct Latest {
    drawn: Option<Instant>,
}

impl Latest {
    /// Draws if bonds have broken and the last picture is old.
    pub(super) fn show(
        &mut self,
        plan: &Plan,
        model: &Model,
        step: usize,
        intact: &[bool],
    ) -> Result<(), ResultsError> {
        let is_new = self
            .drawn
            .is_some_and(|drawn| drawn.elapsed() < LATEST_EVERY);
        if !plan.output.pictures || is_new || *intact == *model.intact {
            return Ok(());
        }
        let picture = damage_picture(plan, model, Some(step), intact).draw()?;
        picture.write(&plan.folder.join(DAMAGE_PICTURE))?;
        self.drawn = Some(Instant::now());
        Ok(())
    }
}
