//! The files that a pipeline is made from: what `watch` looks at.

use super::files::read_text;
use super::source::Source;
use super::yaml;
use crate::gmsh::GeoScript;
use crate::meshio;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The pipeline file, its geometry, and all that the geometry includes or merges; of a pipeline that
/// cannot be read, or of a geometry that is not there yet, as much as is known.
pub fn sources(pipeline: &Path, overrides: &[String]) -> BTreeSet<PathBuf> {
    let mut files = BTreeSet::from([pipeline.to_owned()]);
    let Some(geometry) = geometry(pipeline, overrides) else {
        return files;
    };
    if geometry
        .extension()
        .is_some_and(|extension| extension == "geo")
        && let Ok(script) = GeoScript::scan(&geometry)
    {
        files.extend(script.files);
    }
    files.extend(meshio::files(&geometry));
    files
}

/// The geometry that the pipeline names, there or not.
fn geometry(pipeline: &Path, overrides: &[String]) -> Option<PathBuf> {
    let overrides = yaml::parse_overrides(overrides).ok()?;
    let source = Source::new(pipeline, read_text(pipeline).ok()?, overrides);
    let spec = yaml::parse(&source).ok()?;
    let folder = pipeline.parent().unwrap_or(Path::new(""));
    Some(folder.join(spec.geometry.file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn includes_count_and_a_broken_pipeline_is_its_own_source() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        let write = |name: &str, text: &str| fs::write(path(name), text).expect("writable");
        let least =
            "name: a\ngeometry: { file: a.geo }\nmaterials: {}\nregions: []\nboundary: []\n";
        write("a.yaml", least);
        let files = |names: &[&str]| names.iter().map(|name| path(name)).collect();
        let found = || sources(&path("a.yaml"), &[]);
        // The geometry is looked for before it is there.
        assert_eq!(found(), files(&["a.geo", "a.yaml"]));
        write("a.geo", "Include \"b.geo\";\n");
        write("b.geo", "x = 1;\n");
        assert_eq!(found(), files(&["a.geo", "a.yaml", "b.geo"]));
        write("a.yaml", "name: [");
        assert_eq!(found(), files(&["a.yaml"]));
    }
}
