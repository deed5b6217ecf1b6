//! The pipeline as written → the plan's numbers; each error carries the key that it concerns.

use super::files::similar_file;
use super::plan::{Condition, Displaced, GeometryPlan, Loading, PhasePlan, Probe, RegionPlan};
use super::quantity::{self, Dimension};
use super::source::{InputError, Source, choices, quoted};
use super::spec::{self, Spec};
use crate::boundary::Directions;
use crate::coupling::Coupling;
use crate::coupling::truss::NodeArea;
use crate::fem::edge::EdgeLoad;
use crate::fracture::control::{Control, Until};
use crate::fracture::failure::Strength;
use crate::gmsh::Value;
use crate::material::{Material, PlaneState};
use crate::meshio::MESHES;
use crate::model::{Method, PeridynamicSettings};
use crate::peridynamics::kernel::{Kernel, PartialArea};
use crate::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use crate::peridynamics::surface::SurfaceCorrection;
use std::collections::BTreeMap;
use std::path::Path;

/// Poisson's ratio may differ by this much from 1/3 or 1/4, so that 0.3333333 is accepted.
const POISSON_TOLERANCE: f64 = 1e-6;

/// Horizons of fewer spacings hold too few bonds for an isotropic material.
const SMALLEST_HORIZON: f64 = 2.0;
/// Larger families than these 1 250 neighbours are a slip of the pen.
const LARGEST_HORIZON: f64 = 20.0;

/// Turns the spec into numbers; every error carries its key.
pub(super) struct Reader<'a> {
    pub source: &'a Source,
    pub spec: &'a Spec,
}

impl Reader<'_> {
    pub(super) fn name(&self) -> Result<String, InputError> {
        let name = &self.spec.name;
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
        if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) {
            let message = format!("`{name}` cannot name a folder of results");
            let help = "use letters, digits, `_`, `-` and `.`, such as `plate_mode_i`".to_owned();
            return Err(self.source.error("name", message, Some(help)));
        }
        Ok(name.clone())
    }

    fn quantity(
        &self,
        key: &str,
        value: &spec::Scalar,
        expected: Dimension,
    ) -> Result<f64, InputError> {
        quantity::parse(&value.0, expected).map_err(|error| {
            self.source
                .error(key, error.to_string(), Some(error.help()))
        })
    }

    pub(super) fn positive(
        &self,
        key: &str,
        value: &spec::Scalar,
        expected: Dimension,
    ) -> Result<f64, InputError> {
        let number = self.quantity(key, value, expected)?;
        if number > 0.0 {
            return Ok(number);
        }
        let help = Some(format!(
            "write {} greater than zero, such as `{}`",
            expected.name(),
            expected.example()
        ));
        Err(self
            .source
            .error(key, format!("`{}` is not positive", value.0), help))
    }

    pub(super) fn geometry(&self) -> Result<GeometryPlan, InputError> {
        let geometry = &self.spec.geometry;
        let folder = self.source.path.parent().unwrap_or(Path::new(""));
        let file = folder.join(&geometry.file);
        if !file.is_file() {
            let what = if file.is_dir() {
                "is a folder"
            } else {
                "does not exist"
            };
            let message = format!("the geometry file {} {what}", file.display());
            let nearby = if file.is_dir() { file.join("x") } else { file };
            let mut help = "the path is relative to the pipeline file".to_owned();
            let kinds = [&["geo", "msh"][..], &MESHES].concat();
            if let Some(similar) = similar_file(&nearby, &kinds) {
                help.push_str(&format!("; {similar}"));
            }
            return Err(self.source.error("geometry/file", message, Some(help)));
        }
        let unit = spec::Scalar(format!("1 {}", geometry.unit));
        Ok(GeometryPlan {
            file,
            unit_in_metres: self.positive("geometry/unit", &unit, Dimension::LENGTH)?,
            parameters: geometry
                .parameters
                .iter()
                .map(|(k, v)| (k.clone(), parameter(v)))
                .collect(),
            trust: geometry.trust,
        })
    }

    pub(super) fn materials(&self) -> Result<BTreeMap<String, Material>, InputError> {
        let material = |(name, written): (&String, &spec::Material)| {
            let key = |field| format!("materials/{name}/{field}");
            let young = self.positive(&key("young"), &written.young, Dimension::PRESSURE)?;
            let poisson = self.quantity(&key("poisson"), &written.poisson, Dimension::NUMBER)?;
            if !(-1.0 < poisson && poisson < 0.5) {
                let message = format!(
                    "Poisson's ratio `{}` is not between -1 and 1/2",
                    written.poisson.0
                );
                return Err(self.source.error(&key("poisson"), message, None));
            }
            Ok((name.clone(), Material { young, poisson }))
        };
        self.spec.materials.iter().map(material).collect()
    }

    /// What breaks the bonds of a material: its strengths, or its energy release rate.
    fn strength(&self, name: &str) -> Result<Option<Strength>, InputError> {
        let written = &self.spec.materials[name];
        let key = |field: &str| format!("materials/{name}/{field}");
        let read = |field: &str, value: &Option<spec::Scalar>, dimension| {
            let value = value.as_ref();
            value
                .map(|v| self.positive(&key(field), v, dimension))
                .transpose()
        };
        let tensile = read(
            "tensile_strength",
            &written.tensile_strength,
            Dimension::PRESSURE,
        )?;
        let compressive = read(
            "compressive_strength",
            &written.compressive_strength,
            Dimension::PRESSURE,
        )?;
        let rate = read(
            "energy_release_rate",
            &written.energy_release_rate,
            Dimension::ENERGY_PER_AREA,
        )?;
        match (tensile, compressive, rate) {
            (None, None, None) => Ok(None),
            (Some(tensile), compressive, None) => Ok(Some(Strength::Stress {
                tensile,
                compressive,
            })),
            (None, None, Some(rate)) => Ok(Some(Strength::EnergyReleaseRate(rate))),
            (None, Some(_), _) => {
                let message = "a compressive strength needs a tensile strength beside it";
                let help = Some("add `tensile_strength`".to_owned());
                Err(self
                    .source
                    .error(&key("compressive_strength"), message, help))
            }
            (Some(_), _, Some(_)) => {
                let message = "a material breaks by its strength or by its energy release rate";
                let help =
                    Some("remove one of `tensile_strength` and `energy_release_rate`".to_owned());
                Err(self
                    .source
                    .error(&key("energy_release_rate"), message, help))
            }
        }
    }

    pub(super) fn loading(&self) -> Result<Option<Loading>, InputError> {
        let Some(written) = &self.spec.loading else {
            return Ok(None);
        };
        let counts = [
            ("loading/steps", written.steps),
            ("loading/most_passes", written.most_passes),
            ("output/every", self.spec.output.every),
        ];
        if let Some((key, _)) = counts.iter().find(|(_, count)| *count == 0) {
            let help = Some("write a whole number from 1 on".to_owned());
            return Err(self.source.error(key, "this must not be zero", help));
        }
        let breakable = |region: &spec::Region| {
            let material = self.spec.materials.get(&region.material);
            region.model == spec::RegionModel::Peridynamics
                && material.is_some_and(|m| {
                    m.tensile_strength.is_some() || m.energy_release_rate.is_some()
                })
        };
        if !self.spec.regions.iter().any(breakable) {
            let message = "no bond can break: no peridynamic region has a strength";
            let help = "give its material a `tensile_strength` or an `energy_release_rate`, or \
                        remove `loading` for one elastic solve";
            return Err(self.source.error("loading", message, Some(help.to_owned())));
        }
        Ok(Some(Loading {
            phases: self.phases(written)?,
            control: match written.control {
                spec::Control::OnePass => Control::OnePass,
                spec::Control::Equilibrium => Control::Equilibrium {
                    most_passes: written.most_passes,
                },
                spec::Control::EventDriven => Control::EventDriven,
            },
            until: Until {
                steps: written.steps,
                separated: written.until == spec::Until::Separated,
            },
        }))
    }

    fn phases(&self, loading: &spec::Loading) -> Result<Vec<PhasePlan>, InputError> {
        let number = |key: &str, written: &Option<spec::Scalar>| {
            let read = |written| self.positive(key, written, Dimension::NUMBER);
            written.as_ref().map(read).transpose()
        };
        if loading.phases.is_empty() {
            return Ok(vec![PhasePlan {
                name: String::new(),
                increment: number("loading/increment", &loading.increment)?.unwrap_or(1.0),
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

    fn phase_of(
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

    fn phase_named(&self, key: &str, name: &str) -> Result<usize, InputError> {
        let names = self.phase_names();
        let unknown = || {
            let message = format!("there is no phase `{name}` in `loading.phases`");
            let help = choices(name, names.iter().copied());
            self.source.error(key, message, Some(help))
        };
        let found = names.iter().position(|n| *n == name);
        found.ok_or_else(unknown)
    }

    pub(super) fn coupling(&self) -> Result<Coupling, InputError> {
        match &self.spec.coupling {
            spec::Coupling::Truss(truss) => self.node_area(&truss.node_area).map(Coupling::Truss),
            spec::Coupling::Clip => Ok(Coupling::Clip),
            spec::Coupling::Splice => Ok(Coupling::Splice),
        }
    }

    fn node_area(&self, written: &spec::Scalar) -> Result<NodeArea, InputError> {
        match written.0.as_str() {
            "lumped" => Ok(NodeArea::Lumped),
            "half-edge" => Ok(NodeArea::HalfEdge),
            text if !text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                let message = format!("`{text}` is no way to find an interface node's area");
                let help = "write `lumped`, `half-edge` or an area such as `12.5 mm^2`".to_owned();
                Err(self
                    .source
                    .error("coupling/truss/node_area", message, Some(help)))
            }
            _ => self
                .positive("coupling/truss/node_area", written, Dimension::AREA)
                .map(NodeArea::Given),
        }
    }

    pub(super) fn regions(
        &self,
        materials: &BTreeMap<String, Material>,
        plane: PlaneState,
    ) -> Result<Vec<RegionPlan>, InputError> {
        if self.spec.regions.is_empty() {
            let help =
                Some("name a physical surface and its model: `fem` or `peridynamics`".to_owned());
            return Err(self.source.error("regions", "there is no region", help));
        }
        let read = |(index, region): (usize, &spec::Region)| {
            let key = |field: &str| format!("regions/{index}/{field}");
            let material = *materials.get(&region.material).ok_or_else(|| {
                let message = format!("material `{}` is not defined", region.material);
                let help = choices(&region.material, materials.keys().map(String::as_str));
                self.source.error(&key("material"), message, Some(help))
            })?;
            let method = match region.model {
                spec::RegionModel::Fem => self.finite_elements(index, region)?,
                spec::RegionModel::Peridynamics => {
                    self.check_poisson(region, &material, plane)?;
                    self.peridynamics(index, region)?
                }
            };
            Ok(RegionPlan {
                groups: region.group.0.clone(),
                material_name: region.material.clone(),
                material,
                strength: self.strength(&region.material)?,
                method,
                angle_by_default: region.angle.is_none(),
            })
        };
        self.spec.regions.iter().enumerate().map(read).collect()
    }

    fn check_poisson(
        &self,
        region: &spec::Region,
        material: &Material,
        plane: PlaneState,
    ) -> Result<(), InputError> {
        let needed = plane.bond_based_poisson();
        if (material.poisson - needed).abs() <= POISSON_TOLERANCE {
            return Ok(());
        }
        let (state, fraction) = match plane {
            PlaneState::Stress => ("stress", "1/3"),
            PlaneState::Strain => ("strain", "1/4"),
        };
        let message = format!(
            "material `{}` has ν = {}, but bonds in plane {state} can only have ν = {fraction}",
            region.material, self.spec.materials[&region.material].poisson.0
        );
        let help = format!(
            "bonds are central forces: set `poisson: {fraction}` in `{}`, or give this region \
             `model: fem`",
            region.material
        );
        let place = format!("materials/{}/poisson", region.material);
        Err(self.source.error(&place, message, Some(help)))
    }

    fn finite_elements(&self, index: usize, region: &spec::Region) -> Result<Method, InputError> {
        let lattice_keys = [
            ("spacing", region.spacing.is_some()),
            ("horizon", region.horizon.is_some()),
            ("kernel", region.kernel.is_some()),
            ("points", region.points.is_some()),
            ("angle", region.angle.is_some()),
            ("origin", region.origin.is_some()),
            ("cell_area", region.cell_area.is_some()),
            ("partial_area", region.partial_area.is_some()),
            ("micromodulus", region.micromodulus.is_some()),
            ("surface_correction", region.surface_correction.is_some()),
        ];
        match lattice_keys.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(self.source.error(
                &format!("regions/{index}/{name}"),
                format!("`{name}` belongs to peridynamic regions, and this one is `model: fem`"),
                Some(format!("remove `{name}`, or write `model: peridynamics`")),
            )),
            None => Ok(Method::FiniteElements),
        }
    }

    fn peridynamics(&self, index: usize, region: &spec::Region) -> Result<Method, InputError> {
        let key = |field: &str| format!("regions/{index}/{field}");
        let missing = |field: &str, example: &str| {
            let message = format!("a peridynamic region needs a `{field}`");
            self.source.error(
                &format!("regions/{index}"),
                message,
                Some(format!("add `{example}`")),
            )
        };
        let spacing = region
            .spacing
            .as_ref()
            .ok_or_else(|| missing("spacing", "spacing: 0.5 mm"))?;
        let spacing = self.positive(&key("spacing"), spacing, Dimension::LENGTH)?;
        let written = region
            .horizon
            .as_ref()
            .ok_or_else(|| missing("horizon", "horizon: 4"))?;
        let lattice = LatticeSettings {
            spacing,
            placement: region.points.map_or(Placement::CellCentred, placement),
            cell_area: region.cell_area.map_or(CellArea::Clipped, cell_area),
            angle: self.lattice_angle(index, region)?,
            origin: self.lattice_origin(index, region)?,
        };
        self.check_clip(index, region)?;
        Ok(Method::Peridynamics(PeridynamicSettings {
            lattice,
            horizon_ratio: self.horizon(&key("horizon"), written, spacing)?,
            kernel: region.kernel.map_or(Kernel::Quartic, kernel),
            partial_area: region.partial_area.map_or(PartialArea::Full, partial_area),
            isotropised: !matches!(region.micromodulus, Some(spec::Micromodulus::Raw)),
            surface_correction: region
                .surface_correction
                .map_or(SurfaceCorrection::Force, surface_correction),
        }))
    }

    /// The lattice's angle to the x axis [rad].
    fn lattice_angle(&self, index: usize, region: &spec::Region) -> Result<f64, InputError> {
        let written = region.angle.as_ref();
        written.map_or(Ok(0.0), |a| {
            self.angle(&format!("regions/{index}/angle"), a)
        })
    }

    /// An angle [rad].
    fn angle(&self, key: &str, written: &spec::Scalar) -> Result<f64, InputError> {
        let text = written.0.trim();
        let degrees = text.strip_suffix("deg").or(text.strip_suffix('°'));
        let number = degrees.or(text.strip_suffix("rad")).unwrap_or(text);
        let value: f64 = match number.trim().parse() {
            Ok(value) if f64::is_finite(value) => value,
            _ => {
                let help = "write degrees, `20 deg`, or radians, `0.35`";
                let message = format!("`{text}` is not an angle");
                return Err(self.source.error(key, message, Some(help.to_owned())));
            }
        };
        Ok(if degrees.is_some() {
            value.to_radians()
        } else {
            value
        })
    }

    fn lattice_origin(
        &self,
        index: usize,
        region: &spec::Region,
    ) -> Result<Option<[f64; 2]>, InputError> {
        let Some([x, y]) = &region.origin else {
            return Ok(None);
        };
        let at = |k: usize, written| {
            let key = format!("regions/{index}/origin/{k}");
            self.quantity(&key, written, Dimension::LENGTH)
        };
        Ok(Some([at(0, x)?, at(1, y)?]))
    }

    /// Clipped bonds and finite elements must have one elasticity.
    fn check_clip(&self, index: usize, region: &spec::Region) -> Result<(), InputError> {
        let is_clip = matches!(self.spec.coupling, spec::Coupling::Clip);
        if !is_clip || !matches!(region.micromodulus, Some(spec::Micromodulus::Raw)) {
            return Ok(());
        }
        let message = "the clip needs a lattice with the finite elements' moduli, and a raw \
                       micromodulus has others: 0.6 % of a uniform strain would be wrong beside the \
                       interface"
            .to_owned();
        let help = "remove `micromodulus`, or write `micromodulus: isotropised`".to_owned();
        let key = format!("regions/{index}/micromodulus");
        Err(self.source.error(&key, message, Some(help)))
    }

    /// m = δ/dx from a number of spacings or a length.
    fn horizon(&self, key: &str, written: &spec::Scalar, spacing: f64) -> Result<f64, InputError> {
        let fail = |message: String, help: String| Err(self.source.error(key, message, Some(help)));
        let ratio = match quantity::parse_any(&written.0) {
            Ok((number, None)) => number,
            _ => self.quantity(key, written, Dimension::LENGTH)? / spacing,
        };
        if ratio < SMALLEST_HORIZON * (1.0 - 1e-9) {
            return fail(
                format!(
                    "a horizon of {} is {ratio:.3} spacings, less than {SMALLEST_HORIZON}",
                    written.0
                ),
                "give it in spacings (`horizon: 4`) or as a length; 3 to 5 spacings are usual"
                    .into(),
            );
        }
        if ratio > LARGEST_HORIZON {
            return fail(
                format!(
                    "a horizon of {} is {ratio:.3} spacings, more than {LARGEST_HORIZON}",
                    written.0
                ),
                "a number without a unit counts spacings: `horizon: 4`; a length needs a unit"
                    .into(),
            );
        }
        Ok(ratio)
    }

    pub(super) fn conditions(&self) -> Result<Vec<Condition>, InputError> {
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
            let message = format!("nothing happens at `{}`", written.group);
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
        let place = format!("at `{}`", written.group);
        self.check_in_phase(&entry, &place, phase, moves || is_loaded)?;
        Ok(Condition {
            group: written.group.clone(),
            key: entry,
            displacement,
            loads,
            force,
            body_force,
            phase,
        })
    }

    /// Where there are phases, what is no support belongs to one.
    fn check_in_phase(
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

    pub(super) fn probes(&self) -> Result<Vec<Probe>, InputError> {
        let read = |(name, probe): (&String, &spec::Probe)| {
            let key = |field: &str| format!("probes/{name}/{field}");
            let at =
                |k: usize| self.quantity(&key(&format!("at/{k}")), &probe.at[k], Dimension::LENGTH);
            let reference = probe.reference.as_ref();
            Ok(Probe {
                name: name.clone(),
                at: [at(0)?, at(1)?],
                axis: match probe.component {
                    spec::Component::X => 0,
                    spec::Component::Y => 1,
                },
                reference: reference
                    .map(|value| self.quantity(&key("reference"), value, Dimension::LENGTH))
                    .transpose()?,
            })
        };
        self.spec.probes.iter().map(read).collect()
    }
}

fn kernel(written: spec::Kernel) -> Kernel {
    match written {
        spec::Kernel::Quartic => Kernel::Quartic,
        spec::Kernel::Constant => Kernel::Constant,
        spec::Kernel::Linear => Kernel::Linear,
        spec::Kernel::Parabolic => Kernel::Parabolic,
        spec::Kernel::Inverse => Kernel::Inverse,
    }
}

fn placement(written: spec::Points) -> Placement {
    match written {
        spec::Points::CellCentred => Placement::CellCentred,
        spec::Points::GridNodes => Placement::GridNodes,
    }
}

fn cell_area(written: spec::CellArea) -> CellArea {
    match written {
        spec::CellArea::Full => CellArea::Full,
        spec::CellArea::Clipped => CellArea::Clipped,
    }
}

fn partial_area(written: spec::PartialArea) -> PartialArea {
    match written {
        spec::PartialArea::Full => PartialArea::Full,
        spec::PartialArea::Hhb => PartialArea::Hhb,
    }
}

fn surface_correction(written: spec::SurfaceCorrection) -> SurfaceCorrection {
    match written {
        spec::SurfaceCorrection::None => SurfaceCorrection::None,
        spec::SurfaceCorrection::Volume => SurfaceCorrection::Volume,
        spec::SurfaceCorrection::Energy => SurfaceCorrection::Energy,
        spec::SurfaceCorrection::Force => SurfaceCorrection::Force,
        spec::SurfaceCorrection::LeastSquares => SurfaceCorrection::LeastSquares,
    }
}

/// A `.geo` parameter is a number where it reads as one.
fn parameter(written: &spec::Scalar) -> Value {
    match written.0.parse() {
        Ok(number) => Value::Number(number),
        Err(_) => Value::Text(written.0.clone()),
    }
}
