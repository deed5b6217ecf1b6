//! Parameters that the pipeline gives a geometry: checked against its script, and handed to Gmsh.

use std::collections::BTreeMap;
use std::path::Path;

use super::{GeoScript, GmshError, Value};

/// Checks that the script has the parameters and that their values are allowed.
///
/// # Errors
/// The first that does not fit.
pub(super) fn check_parameters(
    file: &Path,
    script: Option<&GeoScript>,
    parameters: &BTreeMap<String, Value>,
) -> Result<(), GmshError> {
    for (name, value) in parameters {
        let Some(script) = script else {
            return Err(GmshError::ParameterOfMesh {
                file: file.to_owned(),
                name: name.clone(),
            });
        };
        check_parameter(file, script, name, value)?;
    }
    Ok(())
}

fn check_parameter(
    file: &Path,
    script: &GeoScript,
    name: &str,
    value: &Value,
) -> Result<(), GmshError> {
    let file = file.to_owned();
    let Some(parameter) = script.parameters.get(name) else {
        let name = name.to_owned();
        if script.fixed.contains(&name) {
            return Err(GmshError::FixedParameter { file, name });
        }
        return Err(GmshError::UnknownParameter {
            file,
            nearest: script.nearest(&name).map(str::to_owned),
            available: script.parameters.keys().cloned().collect(),
            name,
        });
    };
    match parameter.refuses(value) {
        None => Ok(()),
        Some(expected) => Err(GmshError::ParameterValue {
            file,
            name: name.to_owned(),
            expected,
            given: value.to_string(),
        }),
    }
}

/// Gmsh's command line. Only there do values override `DefineConstant`.
pub(super) fn arguments(parameters: &BTreeMap<String, Value>) -> Vec<String> {
    let words = parameters.iter().flat_map(|(name, value)| match value {
        Value::Number(number) => ["-setnumber".to_owned(), name.clone(), number.to_string()],
        Value::Text(text) => ["-setstring".to_owned(), name.clone(), text.clone()],
    });
    words.collect()
}

/// Adds to the values that Gmsh tells (from 4.9 on) those that are known without it.
pub(super) fn add_known_values(
    values: &mut BTreeMap<String, Value>,
    script: &GeoScript,
    given: &BTreeMap<String, Value>,
) {
    for (name, parameter) in &script.parameters {
        let known = given.get(name).cloned().or(parameter.default.value());
        if let Some(value) = known {
            values.entry(name.clone()).or_insert(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_reach_gmsh_without_loss() {
        let parameters = BTreeMap::from([
            ("a".to_owned(), Value::Number(0.1 + 0.2)),
            ("b".to_owned(), Value::from("two words")),
        ]);
        let words = arguments(&parameters);
        assert_eq!(words[..2], ["-setnumber", "a"]);
        assert_eq!(words[2].parse(), Ok(0.1 + 0.2));
        assert_eq!(words[3..], ["-setstring", "b", "two words"]);
    }
}
