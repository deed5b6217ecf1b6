//! The recipe of a stage: the settings that it depends on, in canonical form, and its inputs' hashes.

use super::meshing::gmsh_error;
use super::run::{MESH_FILE, SOLUTION_FILE};
use crate::gmsh::{self, GeoScript};
use crate::meshio;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::quantity;
use crate::pipeline::read::spec::{self, Geometry, Loading, Spec};
use crate::pipeline::record::folder::hash_of;
use crate::pipeline::record::stamp::{Recipe, Stage};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// The recipe of a stage as of now. `kept` gives the hash of a file that an earlier stage delivers.
pub(crate) fn recipe(
    plan: &Plan,
    stage: Stage,
    kept: &dyn Fn(&str) -> String,
) -> Result<Recipe, RunError> {
    let kept = |name: &str| (name.to_owned(), kept(name));
    let mut settings = settings(&plan.spec, stage);
    let inputs = match stage {
        Stage::Mesh => {
            let (program, version) = match meshio::reads(&plan.geometry.file) {
                true => ("meshio", meshio_version()),
                false => ("gmsh", gmsh_library()),
            };
            settings.insert(program.to_owned(), version);
            geometry_files(plan)?
        }
        Stage::Solve => [kept(MESH_FILE)].into(),
        Stage::Output => [kept(MESH_FILE), kept(SOLUTION_FILE)].into(),
    };
    Ok(Recipe::new(stage, settings, inputs))
}

/// The settings that a stage depends on: key of the pipeline file → canonical value, quantities in SI
/// units.
fn settings(spec: &Spec, stage: Stage) -> BTreeMap<String, String> {
    let mut flat = BTreeMap::new();
    for (first, key, value) in first_readers(spec) {
        // What the solve depends on, its results depend on. Of the mesh's settings only the mesh counts.
        if first == stage || (first, stage) == (Stage::Solve, Stage::Output) {
            flatten(key, &value, &mut flat);
        }
    }
    flat
}

/// Every setting of the pipeline file, and the first stage that depends on it. No pattern here has
/// `..`, so that a new key does not compile before it has a stage, or a reason to have none.
fn first_readers(spec: &Spec) -> Vec<(Stage, &'static str, Value)> {
    use Stage::{Mesh, Output, Solve};
    let Spec {
        name,
        geometry,
        plane,
        thickness,
        materials,
        regions,
        cracks,
        no_fail,
        coupling,
        boundary,
        gravity,
        loading,
        probes,
        output,
        // It says which other runs there are.
        sweep: _,
    } = spec;
    let Geometry {
        // The contents of the files are inputs.
        file: _,
        unit,
        parameters,
        // A geometry that needs it does not mesh without.
        trust: _,
    } = geometry;
    let spec::Output {
        fields,
        every,
        bonds,
        pictures,
        pictures_at,
        formats,
        titles,
        exaggeration,
        percentiles,
        colour_ranges,
        animation,
        report,
    } = output;
    let mut readers = vec![
        (Mesh, "geometry.parameters", json!(parameters)),
        (Solve, "geometry.unit", json!(unit)),
        (Solve, "plane", json!(plane)),
        (Solve, "thickness", json!(thickness)),
        (Solve, "materials", json!(materials)),
        (Solve, "regions", json!(regions)),
        (Solve, "cracks", json!(cracks)),
        (Solve, "no_fail", json!(no_fail)),
        (Solve, "coupling", json!(coupling)),
        (Solve, "boundary", json!(boundary)),
        (Solve, "gravity", json!(gravity)),
        // Both say which steps have a frame.
        (Solve, "output.every", json!(every)),
        (Solve, "output.pictures_at", json!(pictures_at)),
        (Output, "name", json!(name)),
        // A fracture run reads them at every step.
        (
            if loading.is_some() { Solve } else { Output },
            "probes",
            json!(probes),
        ),
        (Output, "output.fields", json!(fields)),
        (Output, "output.bonds", json!(bonds)),
        (Output, "output.pictures", json!(pictures)),
        (Output, "output.formats", json!(formats)),
        (Output, "output.titles", json!(titles)),
        (Output, "output.exaggeration", json!(exaggeration)),
        (Output, "output.percentiles", json!(percentiles)),
        (Output, "output.colour_ranges", json!(colour_ranges)),
        (Output, "output.animation", json!(animation)),
        (Output, "output.report", json!(report)),
    ];
    if let Some(loading) = loading {
        let Loading {
            control,
            steps,
            until,
            most_passes,
            increment,
            by,
            to,
            phases,
            reference,
        } = loading;
        readers.extend([
            (Solve, "loading.control", json!(control)),
            (Solve, "loading.steps", json!(steps)),
            (Solve, "loading.until", json!(until)),
            (Solve, "loading.most_passes", json!(most_passes)),
            (Solve, "loading.increment", json!(increment)),
            (Solve, "loading.by", json!(by)),
            (Solve, "loading.to", json!(to)),
            (Solve, "loading.phases", json!(phases)),
            (Output, "loading.reference", json!(reference)),
        ]);
    }
    readers
}

/// One line for each value below a key.
fn flatten(key: &str, value: &Value, flat: &mut BTreeMap<String, String>) {
    match value {
        // It is not given.
        Value::Null => {}
        Value::Object(map) => {
            for (step, value) in map {
                flatten(&format!("{key}.{step}"), value, flat);
            }
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                flatten(&format!("{key}.{index}"), value, flat);
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use schemars::schema_for;
    use std::collections::BTreeSet;

    /// A pipeline with every key, whether or not all of them may stand together.
    const EVERY_KEY: &str = "
name: plate
geometry: { file: plate.geo, unit: mm, parameters: { element: 5 }, trust: true }
plane: strain
thickness: 10 mm
materials:
  rock: { young: 30 GPa, poisson: 1/4, tensile_strength: 2 MPa, compressive_strength: 20 MPa,
          energy_release_rate: 1 J/m^2, fracture_toughness: 1 MPa m^0.5, density: 2400 kg/m^3 }
regions:
  - { group: [a, b], model: peridynamics, material: rock, spacing: 1 mm, horizon: 4, kernel: linear,
      points: grid-nodes, angle: 20 deg, origin: [0, 1 mm], cell_area: full, partial_area: hhb,
      micromodulus: raw, surface_correction: none }
cracks: [slit]
no_fail: [grip]
coupling: { truss: { node_area: half-edge, breakable: true } }
boundary:
  - { group: top, displacement: { x: 1 mm, y: 2 mm, angle: 3 deg, normal: 4 mm, tangential: 5 mm },
      traction: { x: 1 Pa, y: 2 Pa }, pressure: 3 Pa, force: { x: 1 N }, body_force: { y: 1 N/m^3 }, phase: up }
  - { where: { x: min, y: 3 mm, box: [[0, 1 mm], [2 mm, 3 mm]], near: [4 mm, 5 mm], between: [[0, 6 mm], [7 mm, 0]],
      tolerance: 8 mm } }
gravity: { x: 1 m/s^2, y: -9.81 m/s^2, phase: up }
loading: { control: equilibrium, steps: 9, until: steps, most_passes: 8, increment: 0.1, to: 7, by: cmod,
           phases: [{ name: up, increment: 0.2, to: 6 }], reference: { first_break: 5, separated: 4 } }
probes: { tip: { at: [1 m, 2 m], component: y, reference: 3 mm }, cmod: { between: [[0, 1 m], [0, 2 m]], component: y } }
output: { fields: [stress], every: 2, bonds: true, pictures: [mesh], pictures_at: [3], formats: [svg],
          exaggeration: 100, percentiles: [1, 99], colour_ranges: { stress-yy: [0 MPa, 5 MPa] },
          animation: true, report: false }
sweep: { over: { thickness: { from: 1 mm, to: 2 mm, count: 3, scale: log } }, combine: zipped }
";

    /// The keys of maps in the schema, wherever they stand.
    fn keys(schema: &Value, found: &mut BTreeSet<String>) {
        match schema {
            Value::Object(map) => {
                if let Some(Value::Object(properties)) = map.get("properties") {
                    found.extend(properties.keys().cloned());
                }
                map.values().for_each(|value| keys(value, found));
            }
            Value::Array(list) => list.iter().for_each(|value| keys(value, found)),
            _ => {}
        }
    }

    #[test]
    fn every_key_of_the_pipeline_is_in_the_recipes_of_the_stages_that_depend_on_it() {
        let spec: Spec = serde_yaml::from_str(EVERY_KEY).expect("a pipeline");
        let mut all = BTreeMap::new();
        let written = serde_json::to_value(&spec).expect("a spec is plain data");
        for (key, value) in written.as_object().expect("a map") {
            flatten(key, value, &mut all);
        }
        // A new key of the schema must stand in the pipeline above.
        let mut in_schema = BTreeSet::new();
        keys(&schema_for!(Spec).to_value(), &mut in_schema);
        let steps = all.keys().flat_map(|key| key.split('.'));
        let steps: BTreeSet<String> = steps.map(str::to_owned).collect();
        let absent: Vec<&String> = in_schema.difference(&steps).collect();
        assert_eq!(absent, [""; 0]);

        for key in all.keys() {
            let is_below = |places: &[&str]| {
                let mut places = places.iter();
                places.any(|place| key == place || key.starts_with(&format!("{place}.")))
            };
            let expected: &[Stage] = if is_below(&["geometry.file", "geometry.trust", "sweep"]) {
                &[]
            } else if is_below(&["geometry.parameters"]) {
                &[Stage::Mesh]
            } else if is_below(&["output.every", "output.pictures_at"]) {
                &[Stage::Solve, Stage::Output]
            } else if is_below(&["name", "loading.reference", "output"]) {
                &[Stage::Output]
            } else {
                &[Stage::Solve, Stage::Output]
            };
            let has = |stage: &Stage| settings(&spec, *stage).get(key) == all.get(key);
            let stages: Vec<Stage> = Stage::ALL.into_iter().filter(has).collect();
            assert_eq!(stages, expected, "{key}");
        }
    }
}
