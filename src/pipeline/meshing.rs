//! The geometry to a mesh, with Gmsh's errors at their place in the pipeline.

use super::plan::Plan;
use super::run::{Options, RunError};
use crate::gmsh::{self, Extract, GmshError};

pub(super) fn mesh_geometry(plan: &Plan, options: &Options) -> Result<Extract, RunError> {
    gmsh::mesh(
        &plan.geometry.file,
        &plan.geometry.parameters,
        &options.gmsh,
    )
    .map_err(|error| gmsh_error(plan, error))
}

/// Whose fault is it? The user's errors get their place in the pipeline and exit code 2.
pub(super) fn gmsh_error(plan: &Plan, error: GmshError) -> RunError {
    let (key, help) = match &error {
        GmshError::UnknownParameter { name, .. }
        | GmshError::FixedParameter { name, .. }
        | GmshError::ParameterOfMesh { name, .. }
        | GmshError::ParameterValue { name, .. } => (format!("geometry/parameters/{name}"), None),
        GmshError::Failed { errors, .. } => match blamed_parameter(plan, errors) {
            Some(name) => (format!("geometry/parameters/{name}"), parameters_help(plan)),
            None => ("geometry/file".to_owned(), None),
        },
        GmshError::FileMissing { .. }
        | GmshError::FileKind { .. }
        | GmshError::PathNotText { .. }
        | GmshError::Script(_) => ("geometry/file".to_owned(), None),
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

pub(super) fn to_mesh(plan: &Plan, extract: &Extract) -> Result<crate::mesh::Mesh, RunError> {
    let mesh = extract.to_mesh(plan.geometry.unit_in_metres);
    Ok(mesh.map_err(|error| plan.source.error("geometry/file", error.to_string(), None))?)
}
