//! The files that a script names.

use std::path::{Path, PathBuf};

use super::script_text::Text;

/// A file that a script names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    pub path: PathBuf,
    /// The script that names the file.
    pub file: PathBuf,
    /// Line in the script, counted from 1.
    pub line: usize,
}

/// The files that a script names in the commands that read files.
pub(super) fn named_files(file: &Path, text: &Text) -> Vec<NamedFile> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut files = Vec::new();
    for command in [
        "Include",
        "Merge",
        "MergeWithBoundingBox",
        "ShapeFromFile",
        "FileName",
    ] {
        for at in text.words(command) {
            let length = text.code[at.end..].find(';');
            let end = length.map_or(text.code.len(), |length| at.end + length);
            let named = |name: &&str| NamedFile {
                path: folder.join(name),
                file: file.to_owned(),
                line: text.line(at.start),
            };
            files.extend(text.strings(at.end..end).iter().map(named));
        }
    }
    files
}

/// The options file that Gmsh reads unasked: `x.geo.opt` for `x.geo`.
pub(super) fn options_file(file: &Path) -> Option<PathBuf> {
    let mut options = file.as_os_str().to_owned();
    options.push(".opt");
    Some(PathBuf::from(options)).filter(|options| options.is_file())
}

/// Extensions of the files that Gmsh reads as data. It takes every other merged file for a script.
const DATA: [&str; 24] = [
    "brep", "step", "stp", "iges", "igs", "xao", "msh", "mesh", "stl", "obj", "off", "ply2", "vtk",
    "unv", "bdf", "nas", "med", "mmed", "rmed", "cgns", "png", "jpg", "jpeg", "bmp",
];

pub(super) fn is_script(file: &Path) -> bool {
    let extension = file.extension().and_then(|extension| extension.to_str());
    let extension = extension.map(str::to_ascii_lowercase);
    extension.is_none_or(|extension| !DATA.contains(&extension.as_str()))
}
