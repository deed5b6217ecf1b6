//! The checked pipeline: SI numbers, the numerics' own types, nothing left to interpret but the
//! names of groups, which need the mesh.

use super::files::{default_results, read_text};
use super::quantity::Dimension;
use super::reader::Reader;
use super::source::{InputError, Source};
use super::spec::{self, Spec};
use super::yaml;
use crate::boundary::Directions;
use crate::fem::edge::EdgeLoad;
use crate::fracture::control::{Control, Until};
use crate::fracture::laws::Strength;
use crate::gmsh::Value;
use crate::material::Material;
use crate::mesh::selection::Selection;
use crate::model::{Method, ModelSettings};
use crate::statics::Breaks;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A pipeline that is ready to run.
#[derive(Clone, Debug)]
pub struct Plan {
    pub name: String,
    /// Name that the file gives where `--set name=…` gives another one: that of the study of a run.
    pub study: Option<String>,
    /// `results/NAME`.
    pub folder: PathBuf,
    pub geometry: GeometryPlan,
    pub model: ModelSettings,
    pub regions: Vec<RegionPlan>,
    /// Physical curves.
    pub cracks: Vec<String>,
    /// Physical surfaces.
    pub no_fail: Vec<String>,
    pub trusses_break: bool,
    pub conditions: Vec<Condition>,
    /// `None`: one elastic solve.
    pub loading: Option<Loading>,
    pub probes: Vec<Probe>,
    pub output: spec::Output,
    /// Ends of the colour bar of single maps [m or Pa].
    pub colour_ranges: BTreeMap<spec::PictureKind, [f64; 2]>,
    /// The file as it was written, with the defaults filled in.
    pub spec: Spec,
    pub source: Source,
}

#[derive(Clone, Debug)]
pub struct GeometryPlan {
    pub file: PathBuf,
    pub unit_in_metres: f64,
    pub parameters: BTreeMap<String, Value>,
    /// Whether the `.geo` may run programs and write files.
    pub trust: bool,
}

#[derive(Clone, Debug)]
pub struct RegionPlan {
    pub groups: Vec<String>,
    pub material_name: String,
    pub material: Material,
    /// `None`: its bonds never break.
    pub strength: Option<Strength>,
    pub method: Method,
    /// The pipeline leaves the lattice's angle to the outline.
    pub angle_by_default: bool,
}

/// Growth of the load while bonds break.
#[derive(Clone, Debug)]
pub struct Loading {
    pub control: Control,
    pub until: Until,
    /// At least one.
    pub phases: Vec<PhasePlan>,
    /// Number of the probe that controls the load steps.
    pub by: Option<usize>,
}

/// One phase of the programme.
#[derive(Clone, Debug)]
pub struct PhasePlan {
    /// Empty for the only one.
    pub name: String,
    /// Δλ of a load step [-], or the increment of the probe that controls it [m].
    pub increment: f64,
    /// λ at its end [-].
    pub end: Option<f64>,
}

impl RegionPlan {
    pub fn name(&self) -> String {
        self.groups.join("+")
    }
}

/// Support and loads of one group.
#[derive(Clone, Debug)]
pub struct Condition {
    pub group: String,
    /// `None`: the group is one of the mesh. Otherwise it is made of what is selected.
    pub selection: Option<Selection>,
    /// Place in the pipeline.
    pub key: String,
    pub displacement: Option<Displaced>,
    pub loads: Vec<EdgeLoad>,
    /// In all, on a curve or a point [N].
    pub force: Option<[f64; 2]>,
    /// Per volume, on a surface [N/m³].
    pub body_force: Option<[f64; 2]>,
    /// Index of the phase that applies it; `None`: it is there in all.
    pub phase: Option<usize>,
}

impl Condition {
    fn is_zero(&self) -> bool {
        let is_zero = |vector: [f64; 2]| vector == [0.0; 2];
        let load = |load: &EdgeLoad| match *load {
            EdgeLoad::Traction(traction) => is_zero(traction),
            EdgeLoad::Pressure(pressure) => pressure == 0.0,
        };
        let displaced = self.displacement.iter().flat_map(|d| d.components);
        displaced.flatten().all(|component| component == 0.0)
            && self.loads.iter().all(load)
            && self.force.is_none_or(is_zero)
            && self.body_force.is_none_or(is_zero)
    }
}

/// A prescribed displacement.
#[derive(Clone, Copy, Debug)]
pub struct Displaced {
    pub directions: Directions,
    /// [m].
    pub components: [Option<f64>; 2],
}

/// A displacement to report: u at a point, or u(b) − u(a) of two points.
#[derive(Clone, Debug)]
pub struct Probe {
    pub name: String,
    /// One point, or a and b [m].
    pub points: Vec<[f64; 2]>,
    pub axis: usize,
    /// [m].
    pub reference: Option<f64>,
}

/// The warning about a plan for which [`Plan::loads_nothing`] holds.
pub const NOTHING_LOADS: &str =
    "nothing loads the body: every prescribed displacement and load is 0";

impl Plan {
    /// Whether every prescribed displacement and every load is zero.
    pub fn loads_nothing(&self) -> bool {
        self.conditions.iter().all(Condition::is_zero)
    }

    /// Whether bonds break in a run, and how.
    pub fn breaks(&self) -> Breaks {
        match &self.loading {
            None => Breaks::Never,
            Some(loading) if loading.control == Control::EventDriven => Breaks::EventByEvent {
                most_events: loading.until.steps,
            },
            Some(_) => Breaks::InSteps,
        }
    }

    /// The physical groups of the mesh that the pipeline names; some may come more than once.
    pub fn groups(&self) -> impl Iterator<Item = &str> {
        let regions = self.regions.iter().flat_map(|region| &region.groups);
        let conditions = self.conditions.iter();
        let conditions = conditions
            .filter(|condition| condition.selection.is_none())
            .map(|condition| &condition.group);
        let others = self.cracks.iter().chain(&self.no_fail);
        regions.chain(conditions).chain(others).map(String::as_str)
    }

    /// Reads and checks a pipeline file. `overrides` are `key=value` with keys such as
    /// `regions.1.spacing`; `results` is where `NAME/` goes, by default `results/` beside the
    /// `pipelines/` folder that holds the file, or beside the file.
    ///
    /// # Errors
    /// The first thing that is wrong, with its place.
    pub fn read(
        path: &Path,
        overrides: &[String],
        results: Option<&Path>,
    ) -> Result<Plan, InputError> {
        let text = read_text(path)?;
        let overrides = yaml::parse_overrides(overrides)?;
        let source = Source::new(path, text, overrides);
        let spec = yaml::parse(&source)?;
        let reader = Reader {
            source: &source,
            spec: &spec,
        };
        let materials = reader.materials()?;
        Ok(Plan {
            name: reader.name()?,
            study: yaml::written_name(&source).filter(|name| *name != spec.name),
            folder: results
                .map_or_else(|| default_results(path), Path::to_owned)
                .join(&spec.name),
            geometry: reader.geometry()?,
            model: ModelSettings {
                plane: spec.plane,
                thickness: reader.positive("thickness", &spec.thickness, Dimension::LENGTH)?,
                coupling: reader.coupling()?,
            },
            regions: reader.regions(&materials, spec.plane)?,
            cracks: spec.cracks.iter().map(|name| name.0.clone()).collect(),
            no_fail: spec.no_fail.clone(),
            trusses_break: matches!(&spec.coupling, spec::Coupling::Truss(t) if t.breakable),
            conditions: reader.conditions()?,
            loading: reader.loading()?,
            probes: reader.probes()?,
            output: spec.output.clone(),
            colour_ranges: reader.colour_ranges()?,
            spec,
            source,
        })
    }
}
