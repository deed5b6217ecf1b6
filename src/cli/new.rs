//! `peristitch new`: a geometry and a pipeline that run, to begin with.

use crate::pipeline::error::RunError;
use crate::pipeline::read::schema;
use crate::pipeline::read::source::InputError;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

const GEOMETRY: &str = include_str!("new/plate.geo");
const PIPELINE: &str = include_str!("new/plate.yaml");

/// The schema that the pipeline's first line names.
const SCHEMA_FILE: &str = "pipeline.schema.json";

/// Writes `NAME.geo` and `NAME.yaml`, beside them the schema unless it is there, and returns where they are. `path`: the name, with a folder before
/// it or without.
///
/// # Errors
/// A name that cannot be one; a file that is there already, or cannot be written.
fn new(path: &Path) -> Result<[PathBuf; 3], InputError> {
    let name = path.file_name().and_then(|name| name.to_str());
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    let Some(name) = name.filter(|name| name.chars().all(plain)) else {
        let message = format!("`{}` cannot name a pipeline", path.display());
        let help = "use letters, digits, `_` and `-`, such as `my_plate`; no ending";
        return Err(InputError::plain(message, Some(help.to_owned())));
    };
    let files = ["geo", "yaml"].map(|extension| path.with_extension(extension));
    if let Some(there) = files.iter().find(|file| file.exists()) {
        let message = format!("{} is there already", there.display());
        let help = "choose another name; nothing has been written".to_owned();
        return Err(InputError::plain(message, Some(help)));
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))?;
    }
    let [geometry, pipeline] = files;
    write_new(&geometry, &GEOMETRY.replace("NAME", name))?;
    write_new(&pipeline, &PIPELINE.replace("NAME", name))?;
    let schema = path.with_file_name(SCHEMA_FILE);
    if !schema.exists() {
        write_new(&schema, &schema::text())?;
    }
    Ok([geometry, pipeline, schema])
}

/// Never over a file that has appeared in the meantime.
fn write_new(file: &Path, text: &str) -> Result<(), InputError> {
    let made = OpenOptions::new().write(true).create_new(true).open(file);
    made.and_then(|mut made| made.write_all(text.as_bytes()))
        .map_err(|error| cannot_write(file, &error))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> InputError {
    let help = match error.kind() {
        ErrorKind::PermissionDenied => "write into a folder of your own",
        _ => "is there space, and may you write there?",
    };
    let message = format!("cannot write {}: {error}", path.display());
    InputError::plain(message, Some(help.to_owned()))
}

/// `peristitch new`.
pub(super) fn begin(name: &Path) -> Result<(), RunError> {
    let [geometry, pipeline, schema] = new(name)?;
    println!("{}  (the geometry: open it in Gmsh)", geometry.display());
    println!("{}  (what to compute)", pipeline.display());
    println!(
        "{}  (for editors: what a pipeline may hold)",
        schema.display()
    );
    println!("next: peristitch run {}", pipeline.display());
    Ok(())
}
