//! The JSON schema of a pipeline file: editors complete and check with it.

use super::spec::Spec;
use schemars::schema_for;

/// The schema, as `docs/pipeline.schema.json` holds it.
pub fn text() -> String {
    let mut schema = schema_for!(Spec);
    schema.insert("title".to_owned(), "peristitch pipeline".into());
    serde_json::to_string_pretty(&schema).expect("a schema is plain data") + "\n"
}
