//! What reads input of each kind: `tests/hostile.rs` feeds it mutations, `fuzz/` what coverage leads to.

use peristitch::gmsh::geo_script::GeoScript;
use peristitch::meshio::container::{self, Outcome};
use peristitch::meshio::convert;
use peristitch::pipeline::read::plan::Plan;
use peristitch::pipeline::read::quantity::{self, Dimension};
use peristitch::pipeline::read::source::InputError;
use peristitch::pipeline::record::stored::Kind;
use peristitch::pipeline::study::sweep::Study;
use std::path::Path;
use tempfile::TempDir;

/// Whether an input is taken, or why not.
pub type Read = Box<dyn Fn(&[u8]) -> Result<(), String>>;

pub const STORED: [(&str, Kind); 6] = [
    ("mesh.bin", Kind::Mesh),
    ("solution.bin", Kind::Solution),
    ("frame", Kind::Frame),
    ("manifest", Kind::Manifest),
    ("checkpoint", Kind::Checkpoint),
    ("journal", Kind::Journal),
];

/// The reader of a kind of input. `geo` is the folder of the geometries that pipelines name.
pub fn reader(name: &str, geo: &Path) -> Option<Read> {
    Some(match name {
        "pipeline" => in_file("hostile.yaml", geo, |path| {
            // As the command line shows it: with file and line, or with the file's name.
            let told = |error: InputError| {
                let place = error.place().map(|(file, line)| format!("{file}:{line}: "));
                place.unwrap_or_default() + &error.to_string()
            };
            Plan::read(path, &[], None).map(drop).map_err(told)
        }),
        "sweep" => in_file("hostile.yaml", geo, |path| {
            Study::read(path, &[], None)
                .map(drop)
                .map_err(|error| error.to_string())
        }),
        "geometry" => in_file("hostile.geo", geo, |path| {
            GeoScript::scan(path)
                .map(drop)
                .map_err(|error| error.to_string())
        }),
        "quantity" => Box::new(|bytes| {
            let text = String::from_utf8_lossy(bytes);
            let _ = quantity::parse(&text, Dimension::LENGTH);
            quantity::parse_any(&text)
                .map(drop)
                .map_err(|error| error.to_string())
        }),
        "meshio" => Box::new(|bytes| match container::read(bytes)? {
            Outcome::Failed { .. } => Err("failed".to_owned()),
            Outcome::Mesh(container) => {
                let extract = convert::extract(&container, false).map_err(|e| e.to_string())?;
                extract.to_mesh(1.0).map(drop).map_err(|e| e.to_string())
            }
        }),
        _ => {
            let (_, kind) = STORED.iter().find(|(stored, _)| *stored == name)?;
            Box::new(|bytes| match kind.reads(bytes) {
                true => Ok(()),
                false => Err("damaged".to_owned()),
            })
        }
    })
}

/// A file in a folder that lives as long as the reader.
fn in_file(name: &str, geo: &Path, read: impl Fn(&Path) -> Result<(), String> + 'static) -> Read {
    let folder: TempDir = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(folder.path().join("geo")).expect("a new folder");
    for (from, to) in [("cantilever", "bar"), ("plate_mode_i", "plate")] {
        let from = geo.join(format!("{from}.geo"));
        std::fs::copy(from, folder.path().join(format!("geo/{to}.geo"))).expect("a geometry");
    }
    let path = folder.path().join(name);
    Box::new(move |bytes| {
        let _alive = &folder;
        std::fs::write(&path, bytes).expect("writable");
        read(&path)
    })
}
