//! The parameters of a geometry as `check` lists them: value in use, who sets it, default, range.

use super::meshing::gmsh_error;
use crate::gmsh::{Extract, parameter::Parameter, read_script};
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;

/// One line for each parameter of the geometry, such as
/// `element = 50    set by the pipeline; default 10; from 1 to 100`.
///
/// # Errors
/// A script that has become unreadable.
pub fn parameter_lines(plan: &Plan, extract: &Extract) -> Result<Vec<String>, RunError> {
    let script = read_script(&plan.geometry.file).map_err(|error| gmsh_error(plan, error))?;
    let parameters = script.map(|script| script.parameters).unwrap_or_default();
    let assignment = |name: &String| match extract.parameters.get(name) {
        Some(value) => format!("{name} = {value}"),
        None => format!("{name} = ?"),
    };
    let width = parameters
        .keys()
        .map(|name| assignment(name).chars().count());
    let width = width.max().unwrap_or(0);
    let line = |(name, parameter): (&String, &Parameter)| {
        format!(
            "{:<width$}  {}",
            assignment(name),
            origin(plan, name, parameter)
        )
    };
    Ok(parameters.iter().map(line).collect())
}

fn origin(plan: &Plan, name: &str, parameter: &Parameter) -> String {
    let key = format!("geometry/parameters/{name}");
    let mut parts = match plan.geometry.parameters.contains_key(name) {
        true if plan.source.is_overridden(&key) => vec!["set by --set".to_owned()],
        true => vec!["set by the pipeline".to_owned()],
        false => Vec::new(),
    };
    parts.push(match parts.is_empty() {
        true => "default".to_owned(),
        false => format!("default {}", parameter.default),
    });
    if !parameter.range.is_open() {
        parts.push(parameter.range.to_string());
    }
    parts.join("; ")
}
