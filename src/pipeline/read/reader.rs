//! The pipeline as written → the plan's numbers; each error carries the key that it concerns.

mod conditions;
mod loading;
mod output;
mod positions;
mod probes;
mod regions;
mod strength;

use super::files::similar_file;
use super::plan::GeometryPlan;
use super::quantity::{self, Dimension};
use super::source::{InputError, Source};
use super::spec::{self, Spec};
use crate::coupling::Coupling;
use crate::coupling::truss::NodeArea;
use crate::gmsh::Value;
use crate::material::{Material, MaterialError};
use crate::meshio::MESHES;
use std::collections::BTreeMap;
use std::path::Path;

/// Turns the spec into numbers; every error carries its key.
pub(crate) struct Reader<'a> {
    pub source: &'a Source,
    pub spec: &'a Spec,
}

impl Reader<'_> {
    pub(crate) fn name(&self) -> Result<String, InputError> {
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

    pub(crate) fn positive(
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

    pub(crate) fn geometry(&self) -> Result<GeometryPlan, InputError> {
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
        // `mm`, or `25.4 mm`.
        let unit = match geometry
            .unit
            .trim_start()
            .starts_with(|c: char| c.is_ascii_digit())
        {
            true => spec::Scalar(geometry.unit.clone()),
            false => spec::Scalar(format!("1 {}", geometry.unit)),
        };
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

    pub(crate) fn materials(&self) -> Result<BTreeMap<String, Material>, InputError> {
        let material = |(name, written): (&String, &spec::Material)| {
            let key = |field| format!("materials/{name}/{field}");
            let young = self.positive(&key("young"), &written.young, Dimension::PRESSURE)?;
            let poisson = self.quantity(&key("poisson"), &written.poisson, Dimension::NUMBER)?;
            let material = Material { young, poisson };
            if let Err(MaterialError::PoissonOutOfRange { .. }) = material.check() {
                let message = format!(
                    "Poisson's ratio `{}` is not between -1 and 1/2",
                    written.poisson.0
                );
                return Err(self.source.error(&key("poisson"), message, None));
            }
            Ok((name.clone(), material))
        };
        self.spec.materials.iter().map(material).collect()
    }

    pub(crate) fn coupling(&self) -> Result<Coupling, InputError> {
        match &self.spec.coupling {
            spec::Coupling::Truss(truss) => self.node_area(&truss.node_area).map(Coupling::Truss),
            spec::Coupling::Clip => Ok(Coupling::Clip),
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

    /// An angle [rad].
    fn angle(&self, key: &str, written: &spec::Scalar) -> Result<f64, InputError> {
        quantity::parse_angle(&written.0).map_err(|error| {
            let help = error.help();
            self.source.error(key, error.to_string(), Some(help))
        })
    }
}

/// A `.geo` parameter is a number where it reads as one.
fn parameter(written: &spec::Scalar) -> Value {
    match written.0.parse() {
        Ok(number) => Value::Number(number),
        Err(_) => Value::Text(written.0.clone()),
    }
}
