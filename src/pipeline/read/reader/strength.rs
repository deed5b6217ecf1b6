//! Failure of a material: its strengths, or its energy release rate.

use super::Reader;
use crate::fracture::laws::Strength;
use crate::material::{Material, PlaneState};
use crate::pipeline::read::quantity::Dimension;
use crate::pipeline::read::source::{InputError, quoted};
use crate::pipeline::read::spec;

impl Reader<'_> {
    /// Strength of the bonds of the material `name`; `None`: they never break.
    pub(super) fn strength(
        &self,
        name: &str,
        material: &Material,
        plane: PlaneState,
    ) -> Result<Option<Strength>, InputError> {
        let written = &self.spec.materials[name];
        let key = |field: &str| format!("materials/{name}/{field}");
        let read = |field: &str, value: &Option<spec::Scalar>, dimension| {
            let read = |v| self.positive(&key(field), v, dimension);
            value.as_ref().map(read).transpose()
        };
        let pressure = Dimension::PRESSURE;
        let tensile = read("tensile_strength", &written.tensile_strength, pressure)?;
        let compressive = read(
            "compressive_strength",
            &written.compressive_strength,
            pressure,
        )?;
        let rate = read(
            "energy_release_rate",
            &written.energy_release_rate,
            Dimension::ENERGY_PER_AREA,
        )?;
        let toughness = read(
            "fracture_toughness",
            &written.fracture_toughness,
            Dimension::FRACTURE_TOUGHNESS,
        )?;
        let given = [
            ("tensile_strength", tensile.is_some()),
            ("energy_release_rate", rate.is_some()),
            ("fracture_toughness", toughness.is_some()),
        ];
        let given: Vec<&str> = given
            .iter()
            .filter(|(_, is)| *is)
            .map(|(k, _)| *k)
            .collect();
        if let [_, .., last] = given.as_slice() {
            let message = "a material breaks by its strength, by its energy release rate or by its \
                           fracture toughness";
            let help = format!("remove one of {}", quoted(&given));
            return Err(self.source.error(&key(last), message, Some(help)));
        }
        if compressive.is_some() && tensile.is_none() {
            let message = "a compressive strength needs a tensile strength beside it";
            let help = Some("add `tensile_strength`".to_owned());
            let key = key("compressive_strength");
            return Err(self.source.error(&key, message, help));
        }
        let from_toughness = |k: f64| k * k / material.plane_modulus(plane);
        let stress = tensile.map(|tensile| Strength::Stress {
            tensile,
            compressive,
        });
        let rate = rate.or(toughness.map(from_toughness));
        Ok(stress.or(rate.map(Strength::EnergyReleaseRate)))
    }
}
