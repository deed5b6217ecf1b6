//! What a stage is made from: the settings that it reads, in canonical form, and its inputs' hashes.

use super::meshing::gmsh_error;
use super::run::{MESH_FILE, SOLUTION_FILE};
use crate::gmsh::{self, GeoScript};
use crate::meshio;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::quantity;
use crate::pipeline::read::spec::Spec;
use crate::pipeline::record::folder::hash_of;
use crate::pipeline::record::stamp::{Recipe, Stage};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// What a stage would be made from now. `kept`: the hash of a file that an earlier stage delivers.
pub(crate) fn recipe(
    plan: &Plan,
    stage: Stage,
    kept: &dyn Fn(&str) -> String,
) -> Result<Recipe, RunError> {
    let kept = |name: &str| (name.to_owned(), kept(name));
    let physics = [
        "geometry",
        "plane",
        "thickness",
        "materials",
        "regions",
        "cracks",
        "no_fail",
        "coupling",
        "boundary",
        "gravity",
        "loading.control",
        "loading.steps",
        "loading.until",
        "loading.most_passes",
        "loading.increment",
        "loading.to",
        "loading.phases",
        "output.every",
        "output.pictures_at",
    ];
    let (settings, inputs) = match stage {
        Stage::Mesh => {
            let mut settings = settings(&plan.spec, &["geometry.parameters"]);
            let (program, version) = match meshio::reads(&plan.geometry.file) {
                true => ("meshio", meshio_version()),
                false => ("gmsh", gmsh_library()),
            };
            settings.insert(program.to_owned(), version);
            (settings, geometry_files(plan)?)
        }
        Stage::Solve => {
            let mut settings = settings(&plan.spec, &physics);
            settings.retain(|key, _| !key.starts_with("geometry.") || key == "geometry.unit");
            (settings, [kept(MESH_FILE)].into())
        }
        Stage::Output => {
            let mut settings = settings(&plan.spec, &physics);
            settings.retain(|key, _| !key.starts_with("geometry.") || key == "geometry.unit");
            settings.extend(self::settings(
                &plan.spec,
                &["name", "probes", "loading.reference", "output"],
            ));
            (settings, [kept(MESH_FILE), kept(SOLUTION_FILE)].into())
        }
    };
    Ok(Recipe::new(stage, settings, inputs))
}

/// The parts of the pipeline file below `prefixes`, one line per value, quantities in SI units.
fn settings(spec: &Spec, prefixes: &[&str]) -> BTreeMap<String, String> {
    let mut flat = BTreeMap::new();
    let value = serde_json::to_value(spec).expect("a spec is plain data");
    flatten("", &value, &mut flat);
    let below = |key: &str| {
        prefixes
            .iter()
            .any(|p| key == *p || key.starts_with(&format!("{p}.")))
    };
    flat.retain(|key, _| below(key));
    flat
}

fn flatten(key: &str, value: &Value, flat: &mut BTreeMap<String, String>) {
    let join = |step: &str| {
        if key.is_empty() {
            step.to_owned()
        } else {
            format!("{key}.{step}")
        }
    };
    match value {
        Value::Object(map) => map
            .iter()
            .for_each(|(step, v)| flatten(&join(step), v, flat)),
        Value::Array(list) => {
            list.iter()
                .enumerate()
                .for_each(|(k, v)| flatten(&join(&k.to_string()), v, flat));
        }
        Value::String(text) => {
            flat.insert(key.to_owned(), canonical(text));
        }
        other => {
            flat.insert(key.to_owned(), other.to_string());
        }
    }
}

/// `2.5 mm` and `0.0025 m` are the same quantity.
fn canonical(text: &str) -> String {
    match quantity::parse_any(text) {
        Ok((number, Some(dimension))) => format!("{number:?} {}", dimension.symbol()),
        Ok((number, None)) => format!("{number:?}"),
        Err(_) => text.to_owned(),
    }
}

/// The file name of the library that would mesh, which carries its version.
fn gmsh_library() -> String {
    let search = gmsh::library::Places::of_this_process().search();
    let name = search.found.first().and_then(|path| path.file_name());
    name.map_or_else(
        || "none".to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// The version of meshio that would read.
fn meshio_version() -> String {
    let found = meshio::python::find();
    found.map_or_else(|_| "none".to_owned(), |python| python.version)
}

/// The geometry and all that it includes, with their hashes.
fn geometry_files(plan: &Plan) -> Result<BTreeMap<String, String>, RunError> {
    let file = &plan.geometry.file;
    let is_script = file.extension().is_some_and(|extension| extension == "geo");
    let files = if is_script {
        GeoScript::scan(file)
            .map_err(|error| gmsh_error(plan, error.into()))?
            .files
    } else {
        meshio::files(file)
    };
    // Relative names: from where the run is started must not matter.
    let folder = file.parent().unwrap_or(Path::new(""));
    let name = |file: &Path| {
        file.strip_prefix(folder)
            .unwrap_or(file)
            .display()
            .to_string()
    };
    files
        .iter()
        .map(|file| Ok((name(file), hash_of(file)?)))
        .collect()
}
