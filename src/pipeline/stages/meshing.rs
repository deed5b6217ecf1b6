//! The geometry to a mesh, by Gmsh or meshio, with their errors at their place in the pipeline.

use super::run::Options;
use super::validate::check_names;
use crate::gmsh::{self, Extract, ExtractError, GmshError, WHOLE};
use crate::mesh::Mesh;
use crate::meshio::{self, MeshioError};
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;

pub(crate) fn mesh_geometry(plan: &Plan, options: &Options) -> Result<Extract, RunError> {
    if meshio::reads(&plan.geometry.file) {
        return foreign_mesh(plan, options);
    }
    let gmsh = gmsh::Options {
        trust: plan.geometry.trust,
        groups: plan.groups().map(str::to_owned).collect(),
        ..options.gmsh.clone()
    };
    gmsh::mesh(&plan.geometry.file, &plan.geometry.parameters, &gmsh)
        .map_err(|error| missing_group(plan, &error).unwrap_or_else(|| gmsh_error(plan, error)))
}

/// The error for a group that the pipeline names and the geometry lacks.
fn missing_group(plan: &Plan, error: &GmshError) -> Option<RunError> {
    let GmshError::GroupMissing {
        available,
        surfaces,
        ..
    } = error
    else {
        return None;
    };
    if available.iter().all(|(dimension, _)| *dimension != 2) {
        let error = ExtractError::no_physical_surface(*surfaces, available);
        return Some(extract_error(plan, &error).into());
    }
    let checked = check_names(plan, &with_names(plan, available));
    checked.err().map(RunError::from)
}

/// A mesh of which nothing but the names of its groups is known.
fn with_names(plan: &Plan, groups: &[(u8, String)]) -> Mesh {
    let mut mesh = Mesh::default();
    let conditions = plan.conditions.iter();
    for place in conditions.filter(|condition| condition.selection.is_some()) {
        mesh.curves.insert(place.group.clone(), Vec::new());
    }
    for (dimension, name) in groups {
        match dimension {
            0 => drop(mesh.points.insert(name.clone(), Vec::new())),
            1 => drop(mesh.curves.insert(name.clone(), Vec::new())),
            2 => drop(mesh.surfaces.insert(name.clone(), Vec::new())),
            _ => {}
        }
    }
    mesh
}

fn foreign_mesh(plan: &Plan, options: &Options) -> Result<Extract, RunError> {
    if let Some(name) = plan.geometry.parameters.keys().next() {
        let error = GmshError::ParameterOfMesh {
            file: plan.geometry.file.clone(),
            name: name.clone(),
        };
        return Err(gmsh_error(plan, error));
    }
    let meshio = meshio::Options {
        whole: plan.groups().any(|group| group == WHOLE),
        ..options.meshio.clone()
    };
    meshio::mesh(&plan.geometry.file, &meshio).map_err(|error| match error {
        MeshioError::Unreadable { .. }
        | MeshioError::Unsupported { .. }
        | MeshioError::Convert { .. } => {
            let message = error.to_string();
            plan.source.error("geometry/file", message, None).into()
        }
        failure => RunError::Meshio(Box::new(failure)),
    })
}

/// Gives the user's errors their place in the pipeline and exit code 2; others stay Gmsh's.
pub(crate) fn gmsh_error(plan: &Plan, error: GmshError) -> RunError {
    let (key, help) = match &error {
        GmshError::UnknownParameter { name, .. }
        | GmshError::FixedParameter { name, .. }
        | GmshError::ParameterOfMesh { name, .. }
        | GmshError::ParameterValue { name, .. } => (format!("geometry/parameters/{name}"), None),
        GmshError::Failed { errors, .. } => match blamed_parameter(plan, errors) {
            Some(name) => (format!("geometry/parameters/{name}"), parameters_help(plan)),
            None => ("geometry/file".to_owned(), script_help(errors)),
        },
        GmshError::UnsafeCommand(_) => {
            let help = "remove it; if you know where the file comes from, let it: `--trust-geometry`, or \
                        `trust: true` under `geometry`";
            ("geometry/file".to_owned(), Some(help.to_owned()))
        }
        GmshError::FileKind { .. } => ("geometry/file".to_owned(), foreign_help()),
        GmshError::FileMissing { .. } | GmshError::PathNotText { .. } | GmshError::Script(_) => {
            ("geometry/file".to_owned(), None)
        }
        _ => return RunError::Gmsh(Box::new(error)),
    };
    plan.source.error(&key, error.to_string(), help).into()
}

/// The parameter of the pipeline that the script's own `Error(...)` names, if it names one.
fn blamed_parameter<'a>(plan: &'a Plan, errors: &[gmsh::Message]) -> Option<&'a String> {
    let error = errors.first().filter(|error| error.line.is_none())?;
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut words = error.text.split(|c| !is_word(c));
    words.find_map(|word| plan.geometry.parameters.keys().find(|name| *name == word))
}

/// The help for the first of Gmsh's errors.
fn script_help(errors: &[gmsh::Message]) -> Option<String> {
    let first = errors.first()?;
    if first.text.starts_with("Unable to open") {
        return Some("files are sought beside the one that names them".to_owned());
    }
    let line = first.line?;
    first.text.starts_with("syntax error").then(|| {
        let before = line.saturating_sub(1).max(1);
        format!(
            "look at the lines {before} and {line} for a semicolon, a bracket or a quote that lacks"
        )
    })
}

fn foreign_help() -> Option<String> {
    let list = meshio::MESHES.join(", .");
    Some(format!("meshes of other programs, read by meshio: .{list}"))
}

fn parameters_help(plan: &Plan) -> Option<String> {
    let value = |value: &gmsh::Value| match value {
        gmsh::Value::Number(number) => number.to_string(),
        gmsh::Value::Text(text) => text.clone(),
    };
    let given = plan.geometry.parameters.iter();
    let list: Vec<String> = given
        .map(|(name, v)| format!("{name} = {}", value(v)))
        .collect();
    (!list.is_empty()).then(|| format!("the pipeline sets {}", list.join(", ")))
}

pub(crate) fn to_mesh(plan: &Plan, extract: &Extract) -> Result<crate::mesh::Mesh, RunError> {
    let is_named = |group: &str| plan.groups().any(|named| named == group);
    let mesh = extract.to_mesh_of(plan.geometry.unit_in_metres, &is_named);
    Ok(mesh.map_err(|error| extract_error(plan, &error))?)
}

fn extract_error(plan: &Plan, error: &ExtractError) -> InputError {
    let help = match error {
        ExtractError::NoPhysicalSurface { .. } => cad_help(plan),
        _ => None,
    };
    plan.source.error("geometry/file", error.to_string(), help)
}

/// A CAD file cannot name groups.
fn cad_help(plan: &Plan) -> Option<String> {
    let file = &plan.geometry.file;
    let extension = file.extension()?.to_str()?.to_ascii_lowercase();
    let is_cad = ["step", "stp", "brep"].contains(&extension.as_str());
    let name = file.file_name()?.to_str()?;
    is_cad.then(|| {
        format!(
            "write a .geo beside it, and give that as the file: SetFactory(\"OpenCASCADE\"); Merge \
             \"{name}\"; Physical Surface(\"plate\") = {{1}};"
        )
    })
}
