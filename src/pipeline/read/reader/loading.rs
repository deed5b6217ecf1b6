//! `loading`, and which of its phases an entry of the pipeline belongs to.

use super::Reader;
use crate::fracture::control::{Control, Until};
use crate::pipeline::read::plan::{Loading, PhasePlan};
use crate::pipeline::read::quantity::Dimension;
use crate::pipeline::read::source::{InputError, choices, quoted};
use crate::pipeline::read::spec;

impl Reader<'_> {
    pub(crate) fn loading(&self) -> Result<Option<Loading>, InputError> {
        let Some(written) = &self.spec.loading else {
            return Ok(None);
        };
        let counts = [
            ("loading/steps", written.steps),
            ("loading/most_passes", Some(written.most_passes)),
            ("output/every", Some(self.spec.output.every)),
        ];
        if let Some((key, _)) = counts.iter().find(|(_, count)| *count == Some(0)) {
            let help = Some("write a whole number from 1 on".to_owned());
            return Err(self.source.error(key, "this must not be zero", help));
        }
        let breakable = |region: &spec::Region| {
            let material = self.spec.materials.get(&region.material);
            region.model == spec::RegionModel::Peridynamics
                && material.is_some_and(spec::Material::has_strength)
        };
        if !self.spec.regions.iter().any(breakable) {
            let message = "no bond can break: no peridynamic region has a strength";
            let help = "give its material a `tensile_strength`, an `energy_release_rate` or a \
                        `fracture_toughness`, or remove `loading` for one elastic solve";
            return Err(self.source.error("loading", message, Some(help.to_owned())));
        }
        if written.until == spec::Until::Steps && written.steps.is_none() {
            let help = "add `steps:`, the number of load steps or events".to_owned();
            let message = "`until: steps` needs a number of steps";
            return Err(self.source.error("loading/until", message, Some(help)));
        }
        Ok(Some(Loading {
            by: self.control_probe(written)?,
            phases: self.phases(written)?,
            control: match written.control {
                spec::Control::OnePass => Control::OnePass,
                spec::Control::Equilibrium => Control::Equilibrium {
                    most_passes: written.most_passes,
                },
                spec::Control::EventDriven => Control::EventDriven,
            },
            until: Until {
                steps: written.steps.unwrap_or(Until::NO_LIMIT),
                separated: written.until == spec::Until::Separated,
            },
        }))
    }

    /// The number of the probe whose displacement the load steps prescribe.
    fn control_probe(&self, loading: &spec::Loading) -> Result<Option<usize>, InputError> {
        let Some(name) = &loading.by else {
            return Ok(None);
        };
        let mut names = self.spec.probes.keys();
        let Some(probe) = names.position(|probe| probe == name) else {
            let message = format!("there is no probe `{name}`");
            let help = choices(name, self.spec.probes.keys().map(String::as_str));
            return Err(self.source.error("loading/by", message, Some(help)));
        };
        let (message, help) = if loading.control == spec::Control::EventDriven {
            (
                "`event-driven` has no load steps that a probe could control",
                "take `control: equilibrium`; or leave `by` out: event-driven runs follow the opening both ways \
                 by themselves, and `history.csv` has a column for the probe",
            )
        } else if !loading.phases.is_empty() {
            (
                "a probe controls one phase only",
                "leave `phases` out, or `by`",
            )
        } else if loading.to.is_some() {
            (
                "`to` is a load factor, and the load follows the probe here",
                "write `steps:` in place of `to:`",
            )
        } else if loading.increment.is_none() {
            (
                "`by` needs an increment of the probe's displacement",
                "add `increment:`, a length such as 1 µm",
            )
        } else {
            return Ok(Some(probe));
        };
        Err(self
            .source
            .error("loading/by", message, Some(help.to_owned())))
    }

    fn phases(&self, loading: &spec::Loading) -> Result<Vec<PhasePlan>, InputError> {
        let number = |key: &str, written: &Option<spec::Scalar>| {
            let read = |written| self.positive(key, written, Dimension::NUMBER);
            written.as_ref().map(read).transpose()
        };
        if loading.phases.is_empty() {
            let increment = match (&loading.increment, &loading.by) {
                (Some(opening), Some(_)) => {
                    Some(self.positive("loading/increment", opening, Dimension::LENGTH)?)
                }
                (increment, _) => number("loading/increment", increment)?,
            };
            return Ok(vec![PhasePlan {
                name: String::new(),
                increment: increment.unwrap_or(1.0),
                end: number("loading/to", &loading.to)?,
            }]);
        }
        for (key, given) in [("increment", &loading.increment), ("to", &loading.to)] {
            if given.is_some() {
                let message = format!("`{key}` belongs to a phase here");
                let help =
                    format!("write it into an entry of `phases`: `- {{ name: …, {key}: … }}`");
                return Err(self
                    .source
                    .error(&format!("loading/{key}"), message, Some(help)));
            }
        }
        let read = |(index, phase): (usize, &spec::Phase)| {
            let key = |field: &str| format!("loading/phases/{index}/{field}");
            self.check_phase(index, phase)?;
            Ok(PhasePlan {
                name: phase.name.clone(),
                increment: number(&key("increment"), &phase.increment)?.unwrap_or(1.0),
                end: number(&key("to"), &phase.to)?,
            })
        };
        loading.phases.iter().enumerate().map(read).collect()
    }

    fn check_phase(&self, index: usize, phase: &spec::Phase) -> Result<(), InputError> {
        let names = self.phase_names();
        let is_last = index + 1 == names.len();
        let of_phase = |b: &&spec::Boundary| b.phase.as_ref() == Some(&phase.name);
        let (message, help) = if names[..index].contains(&phase.name.as_str()) {
            (
                "two phases have this name".to_owned(),
                "give each a name of its own".to_owned(),
            )
        } else if phase.to.is_none() && !is_last {
            (
                format!("the phase `{}` has no end", phase.name),
                "add `to:`, the load factor at which the next phase begins".to_owned(),
            )
        } else if self.spec.boundary.iter().filter(of_phase).count() == 0 {
            (
                format!("nothing happens in the phase `{}`", phase.name),
                format!(
                    "give an entry of `boundary` the line `phase: {}`",
                    phase.name
                ),
            )
        } else {
            return Ok(());
        };
        let key = format!("loading/phases/{index}/name");
        Err(self.source.error(&key, message, Some(help)))
    }

    fn phase_names(&self) -> Vec<&str> {
        let phases = self.spec.loading.iter().flat_map(|l| &l.phases);
        phases.map(|phase| phase.name.as_str()).collect()
    }

    pub(super) fn phase_of(
        &self,
        index: usize,
        written: &spec::Boundary,
    ) -> Result<Option<usize>, InputError> {
        let Some(name) = &written.phase else {
            return Ok(None);
        };
        let key = format!("boundary/{index}/phase");
        self.phase_named(&key, name).map(Some)
    }

    pub(super) fn phase_named(&self, key: &str, name: &str) -> Result<usize, InputError> {
        let names = self.phase_names();
        let unknown = || {
            let message = format!("there is no phase `{name}` in `loading.phases`");
            let help = choices(name, names.iter().copied());
            self.source.error(key, message, Some(help))
        };
        let found = names.iter().position(|n| *n == name);
        found.ok_or_else(unknown)
    }

    /// Checks that a load belongs to a phase if the loading has any.
    pub(super) fn check_in_phase(
        &self,
        key: &str,
        place: &str,
        phase: Option<usize>,
        acts: bool,
    ) -> Result<(), InputError> {
        let names = self.phase_names();
        if names.is_empty() || phase.is_some() || !acts {
            return Ok(());
        }
        let message = format!("what happens {place} belongs to no phase");
        let help = format!(
            "add `phase:` and one of {}; without it only supports, `{{ x: 0, y: 0 }}`, may stand",
            quoted(&names)
        );
        Err(self.source.error(key, message, Some(help)))
    }
}
