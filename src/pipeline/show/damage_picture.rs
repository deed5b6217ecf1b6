//! Pictures of the damage φ, eq. (7), of Qian et al. (2021), on the deformed shape with the finite elements
//! around: of the end, of chosen steps, and of the latest state while a run goes. All have the colour
//! scale 0 to 1, so that they compare.

use super::deformed::Deformed;
use super::maps::title;
use crate::fields::damage::damage;
use crate::output::picture::FieldPicture;
use crate::pipeline::read::plan::Plan;

/// Damage of the last state; while a run goes, of the latest one.
pub const DAMAGE_PICTURE: &str = "damage.png";

/// Damage at a step of a fracture run. `integrity`: φ of every interaction [-].
pub(crate) fn damage_picture(
    plan: &Plan,
    body: &Deformed,
    step: Option<usize>,
    integrity: &[f64],
) -> FieldPicture {
    let damage = damage(body.model, integrity);
    let (squares, pieces) = body.squares(damage);
    FieldPicture {
        title: title(plan, "damage", step),
        quantity: "damage".to_owned(),
        range: Some([0.0, 1.0]),
        deformation_scale: body.exaggeration,
        squares,
        pieces,
        cells: body.cells(),
        ..FieldPicture::default()
    }
}
