//! `boundary` and `gravity`: supports and loads.

use super::Reader;
use crate::boundary::Directions;
use crate::fem::edge::EdgeLoad;
use crate::pipeline::read::plan::{Condition, Displaced};
use crate::pipeline::read::quantity::Dimension;
use crate::pipeline::read::source::InputError;
use crate::pipeline::read::spec;

impl Reader<'_> {
    pub(crate) fn conditions(&self) -> Result<Vec<Condition>, InputError> {
        let written = self.spec.boundary.iter().enumerate();
        let mut conditions: Vec<Condition> = written
            .map(|(index, written)| self.condition(index, written))
            .collect::<Result<_, _>>()?;
        conditions.extend(self.gravity()?);
        if conditions.iter().all(|c| c.displacement.is_none()) {
            let message = "no displacement is prescribed: nothing holds the body";
            let help = "add a support, such as `- { group: clamp, displacement: { x: 0, y: 0 } }`";
            return Err(self
                .source
                .error("boundary", message, Some(help.to_owned())));
        }
        Ok(conditions)
    }

    /// The weight of every region whose material has a density.
    fn gravity(&self) -> Result<Vec<Condition>, InputError> {
        let Some(written) = &self.spec.gravity else {
            return Ok(Vec::new());
        };
        let components = spec::Components {
            x: written.x.clone(),
            y: written.y.clone(),
        };
        let gravity = self.components("gravity", &components, Dimension::ACCELERATION)?;
        let phase = match &written.phase {
            Some(name) => Some(self.phase_named("gravity/phase", name)?),
            None => None,
        };
        self.check_in_phase("gravity", "under `gravity`", phase, true)?;
        let mut conditions = Vec::new();
        for region in &self.spec.regions {
            let Some(material) = self.spec.materials.get(&region.material) else {
                continue;
            };
            let Some(density) = &material.density else {
                continue;
            };
            let key = format!("materials/{}/density", region.material);
            let density = self.positive(&key, density, Dimension::DENSITY)?;
            let weight = gravity.map(|g| density * g.unwrap_or(0.0));
            conditions.extend(region.group.0.iter().map(|group| Condition {
                group: group.clone(),
                selection: None,
                key: "gravity".to_owned(),
                displacement: None,
                loads: Vec::new(),
                force: None,
                body_force: Some(weight),
                phase,
            }));
        }
        if conditions.is_empty() {
            let message = "`gravity` acts on nothing: no region's material has a `density`";
            let help = "add one, such as `density: 2400 kg/m^3`, to a material".to_owned();
            return Err(self.source.error("gravity", message, Some(help)));
        }
        Ok(conditions)
    }

    fn condition(&self, index: usize, written: &spec::Boundary) -> Result<Condition, InputError> {
        let (group, selection) = self.place(index, written)?;
        let displacement = written.displacement.as_ref();
        let displacement = displacement
            .map(|written| self.displacement(index, written))
            .transpose()?;
        let key = |field: &str| format!("boundary/{index}/{field}");
        let total = |field: &str, written: &Option<spec::Components>, dimension| {
            let read = |c| self.components(&key(field), c, dimension);
            let components = written.as_ref().map(read).transpose()?;
            Ok::<_, InputError>(components.map(|c| c.map(|f| f.unwrap_or(0.0))))
        };
        let force = total("force", &written.force, Dimension::FORCE)?;
        let per_volume = Dimension::FORCE_PER_VOLUME;
        let body_force = total("body_force", &written.body_force, per_volume)?;
        if body_force.is_some() && selection.is_some() {
            let message = "a `body_force` acts on surfaces, and `where` selects edges and nodes";
            let help = "name the surface: `group: NAME`".to_owned();
            return Err(self.source.error(&key("where"), message, Some(help)));
        }
        let mut loads = Vec::new();
        if let Some(components) = &written.traction {
            let traction = self.components(&key("traction"), components, Dimension::PRESSURE)?;
            loads.push(EdgeLoad::Traction(traction.map(|t| t.unwrap_or(0.0))));
        }
        if let Some(pressure) = &written.pressure {
            let key = format!("boundary/{index}/pressure");
            let pressure = self.quantity(&key, pressure, Dimension::PRESSURE)?;
            loads.push(EdgeLoad::Pressure(pressure));
        }
        let is_loaded = !loads.is_empty() || force.is_some() || body_force.is_some();
        if displacement.is_none() && !is_loaded {
            let message = format!("nothing happens at `{group}`");
            let help = "give a `displacement`, a `traction`, a `pressure`, a `force` or, on a \
                        surface, a `body_force`"
                .to_owned();
            return Err(self
                .source
                .error(&format!("boundary/{index}"), message, Some(help)));
        }
        let phase = self.phase_of(index, written)?;
        let components = displacement.iter().flat_map(|d| d.components).flatten();
        let moves = components.into_iter().any(|u| u != 0.0);
        let entry = format!("boundary/{index}");
        let place = format!("at `{group}`");
        self.check_in_phase(&entry, &place, phase, moves || is_loaded)?;
        Ok(Condition {
            group,
            selection,
            key: entry,
            displacement,
            loads,
            force,
            body_force,
            phase,
        })
    }

    fn displacement(
        &self,
        index: usize,
        written: &spec::Displacement,
    ) -> Result<Displaced, InputError> {
        let key = format!("boundary/{index}/displacement");
        let on_curve = written.normal.is_some() || written.tangential.is_some();
        if on_curve && (written.x.is_some() || written.y.is_some() || written.angle.is_some()) {
            let message = "a displacement is along `x` and `y`, or along `normal` and `tangential`";
            let help = "give two entries for the group, or turn x and y by an `angle`".to_owned();
            return Err(self.source.error(&key, message, Some(help)));
        }
        if on_curve {
            let read = |field: &str, value: &Option<spec::Scalar>| {
                let read = |v| self.quantity(&format!("{key}/{field}"), v, Dimension::LENGTH);
                value.as_ref().map(read).transpose()
            };
            return Ok(Displaced {
                directions: Directions::Curve,
                components: [
                    read("normal", &written.normal)?,
                    read("tangential", &written.tangential)?,
                ],
            });
        }
        let angle = written.angle.as_ref();
        let angle = angle.map(|a| self.angle(&format!("{key}/angle"), a));
        let components = spec::Components {
            x: written.x.clone(),
            y: written.y.clone(),
        };
        Ok(Displaced {
            directions: Directions::Turned(angle.transpose()?.unwrap_or(0.0)),
            components: self.components(&key, &components, Dimension::LENGTH)?,
        })
    }

    /// The x and y at a key, at least one of which must be given.
    fn components(
        &self,
        key: &str,
        written: &spec::Components,
        dimension: Dimension,
    ) -> Result<[Option<f64>; 2], InputError> {
        let one = |axis: &str, value: &Option<spec::Scalar>| {
            let read = |value| self.quantity(&format!("{key}/{axis}"), value, dimension);
            value.as_ref().map(read).transpose()
        };
        let components = [one("x", &written.x)?, one("y", &written.y)?];
        if components == [None, None] {
            let field = key.rsplit('/').next().unwrap_or(key);
            let help = format!("give `x`, `y` or both: `{field}: {{ x: 0 }}`");
            let message = format!("this {field} has no component");
            return Err(self.source.error(key, message, Some(help)));
        }
        Ok(components)
    }
}
