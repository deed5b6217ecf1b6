//! `view.py` in the results: one Python script that shows them in ParaView, or draws a PNG in `pvpython` or
//! with VTK's Python package alone. Its head holds what it must know of the run; the rest is `view/view.py`.

use super::deformed::visible_exaggeration;
use super::parts::PartKind;
use super::results::Outcome;
use crate::pipeline::read::spec::OutputField;

pub const VIEW_FILE: &str = "view.py";

const SCRIPT: &str = include_str!("view/view.py");

impl Outcome<'_> {
    /// The script's text.
    pub(crate) fn view(&self) -> String {
        let Outcome {
            plan,
            model,
            solved,
            ..
        } = self;
        let kinds = self.parts().kinds();
        let has = |kind: PartKind| python(kinds.contains(&kind));
        let displacements = solved.solution.displacement.iter().copied();
        let exaggeration = visible_exaggeration(plan, model, displacements).unwrap_or(1.0);
        let head = [
            ("NAME", format!("{:?}", plan.name)),
            ("EXAGGERATION", format!("{exaggeration:?}")),
            ("HAS_ELEMENTS", has(PartKind::Elements)),
            ("HAS_POINTS", has(PartKind::Points)),
            ("HAS_BONDS", has(PartKind::Bonds)),
            ("HAS_DAMAGE", python(self.has_damage())),
            (
                "HAS_DISPLACEMENT",
                python(plan.output.fields.contains(&OutputField::Displacement)),
            ),
        ];
        let head: String = head
            .iter()
            .map(|(name, value)| format!("{name} = {value}\n"))
            .collect();
        SCRIPT.replace("# HEAD\n", &head)
    }
}

fn python(truth: bool) -> String {
    if truth { "True" } else { "False" }.to_owned()
}
