//! `regions`: models, materials and lattices.

use super::Reader;
use crate::material::{Material, PlaneState};
use crate::model::{Method, PeridynamicSettings, SMALLEST_HORIZON, SettingsError, check_horizon};
use crate::peridynamics::kernel::{Kernel, PartialArea};
use crate::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use crate::peridynamics::surface::SurfaceCorrection;
use crate::pipeline::read::plan::RegionPlan;
use crate::pipeline::read::quantity::{self, Dimension};
use crate::pipeline::read::source::{InputError, choices};
use crate::pipeline::read::spec;
use std::collections::BTreeMap;

impl Reader<'_> {
    pub(crate) fn regions(
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
                spec::RegionModel::Peridynamics => self.peridynamics(index, region)?,
            };
            Ok(RegionPlan {
                groups: region.group.0.clone(),
                material_name: region.material.clone(),
                material,
                strength: self.strength(&region.material, &material, plane)?,
                method,
                angle_by_default: region.angle.is_none(),
            })
        };
        self.spec.regions.iter().enumerate().map(read).collect()
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
            placement: region.points.unwrap_or(Placement::CellCentred),
            cell_area: region.cell_area.unwrap_or(CellArea::Clipped),
            angle: self.lattice_angle(index, region)?,
            origin: self.lattice_origin(index, region)?,
        };
        let settings = PeridynamicSettings {
            lattice,
            horizon_ratio: self.horizon(&key("horizon"), written, spacing)?,
            kernel: region.kernel.unwrap_or(Kernel::Quartic),
            partial_area: region.partial_area.unwrap_or(PartialArea::Full),
            isotropised: !matches!(region.micromodulus, Some(spec::Micromodulus::Raw)),
            surface_correction: region
                .surface_correction
                .unwrap_or(SurfaceCorrection::Force),
        };
        self.check_coupling(index, &settings)?;
        Ok(Method::Peridynamics(settings))
    }

    /// The lattice's angle to the x axis [rad].
    fn lattice_angle(&self, index: usize, region: &spec::Region) -> Result<f64, InputError> {
        let written = region.angle.as_ref();
        written.map_or(Ok(0.0), |a| {
            self.angle(&format!("regions/{index}/angle"), a)
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

    fn check_coupling(
        &self,
        index: usize,
        settings: &PeridynamicSettings,
    ) -> Result<(), InputError> {
        let checked = settings.check_coupling(self.coupling()?);
        checked.map_err(|error| {
            let help = "remove `micromodulus`, or write `micromodulus: isotropised`".to_owned();
            let key = format!("regions/{index}/micromodulus");
            self.source.error(&key, error.to_string(), Some(help))
        })
    }

    /// m = δ/dx from a number of spacings or a length.
    fn horizon(&self, key: &str, written: &spec::Scalar, spacing: f64) -> Result<f64, InputError> {
        let fail = |message: String, help: String| Err(self.source.error(key, message, Some(help)));
        let ratio = match quantity::parse_any(&written.0) {
            Ok((number, None)) => number,
            _ => self.quantity(key, written, Dimension::LENGTH)? / spacing,
        };
        match check_horizon(ratio) {
            Err(SettingsError::HorizonTooLarge { most, .. }) => fail(
                format!(
                    "a horizon of {} is {ratio:.3} spacings, more than {most}",
                    written.0
                ),
                "a number without a unit counts spacings: `horizon: 4`; a length needs a unit"
                    .into(),
            ),
            Err(_) => fail(
                format!(
                    "a horizon of {} is {ratio:.3} spacings, less than {SMALLEST_HORIZON}",
                    written.0
                ),
                "give it in spacings (`horizon: 4`) or as a length; 3 to 5 spacings are usual"
                    .into(),
            ),
            Ok(()) => Ok(ratio),
        }
    }
}
