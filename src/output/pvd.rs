//! ParaView's list of files over time (`.pvd`).
//!
//! The list names each part of each step; ParaView offers the times on its time bar and the parts
//! as blocks.

use super::markup::escape;
use super::{WriteError, write_whole};
use std::fmt::Write as _;
use std::path::Path;

/// One part at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Time, step or load factor [any].
    pub time: f64,
    /// Index of the part, the same at all times.
    pub part: usize,
    /// Name of the part.
    pub name: String,
    /// The file relative to the list's folder, with `/` between folders.
    pub file: String,
}

/// Writes the list of `entries`, sorted by time and part, to `path` (`….pvd`).
pub fn write(path: &Path, entries: &[Entry]) -> Result<(), PvdError> {
    Ok(write_whole(path, to_xml(entries)?.as_bytes())?)
}

/// The list's content.
pub fn to_xml(entries: &[Entry]) -> Result<String, PvdError> {
    entries.iter().try_for_each(check)?;
    let mut sorted: Vec<&Entry> = entries.iter().collect();
    sorted.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.part.cmp(&b.part)));

    let mut xml = String::from(concat!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
        "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n",
        "  <Collection>\n",
    ));
    for entry in sorted {
        writeln!(
            xml,
            "    <DataSet timestep=\"{:?}\" part=\"{}\" name=\"{}\" file=\"{}\"/>",
            entry.time,
            entry.part,
            attribute(&entry.name),
            attribute(&entry.file),
        )
        .expect("writing to a string cannot fail");
    }
    xml.push_str("  </Collection>\n</VTKFile>\n");
    Ok(xml)
}

fn check(entry: &Entry) -> Result<(), PvdError> {
    if !entry.time.is_finite() {
        return Err(PvdError::TimeNotFinite {
            time: entry.time,
            file: entry.file.clone(),
        });
    }
    if entry.file.is_empty() || Path::new(&entry.file).is_absolute() {
        return Err(PvdError::FileNotRelative {
            file: entry.file.clone(),
        });
    }
    let not_in_xml = |c: &char| c.is_control() && !matches!(c, '\t' | '\n' | '\r');
    for text in [&entry.name, &entry.file] {
        if let Some(character) = text.chars().find(not_in_xml) {
            return Err(PvdError::ControlCharacter {
                text: text.clone(),
                code: character as u32,
            });
        }
    }
    Ok(())
}

/// `text` as an attribute's value: readers make spaces of line breaks, unless they are written as numbers.
fn attribute(text: &str) -> String {
    let escaped = escape(text);
    escaped
        .replace('\t', "&#9;")
        .replace('\n', "&#10;")
        .replace('\r', "&#13;")
}

/// Why a list was not written.
#[derive(Debug, thiserror::Error)]
pub enum PvdError {
    #[error("the time of `{file}` is {time}")]
    TimeNotFinite { time: f64, file: String },
    #[error("`{file}` must be a path relative to the list")]
    FileNotRelative { file: String },
    #[error("{text:?} holds the control character U+{code:04X}, which XML cannot")]
    ControlCharacter { text: String, code: u32 },
    #[error(transparent)]
    Write(#[from] WriteError),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(time: f64, part: usize, name: &str, file: &str) -> Entry {
        Entry {
            time,
            part,
            name: name.to_owned(),
            file: file.to_owned(),
        }
    }

    #[test]
    fn entries_are_sorted_and_escaped() {
        let entries = [
            entry(1e-300, 1, "points", "a/points_1.vtu"),
            entry(1e-300, 0, "\"<fem> & \n'", "a/fem_1.vtu"),
            entry(0.0, 0, "fem", "a/fem_0.vtu"),
        ];
        let xml = to_xml(&entries).expect("valid");
        let lines: Vec<&str> = xml.lines().map(str::trim).collect();
        assert_eq!(
            lines[3..6],
            [
                r#"<DataSet timestep="0.0" part="0" name="fem" file="a/fem_0.vtu"/>"#,
                r#"<DataSet timestep="1e-300" part="0" name="&quot;&lt;fem&gt; &amp; &#10;&#39;" file="a/fem_1.vtu"/>"#,
                r#"<DataSet timestep="1e-300" part="1" name="points" file="a/points_1.vtu"/>"#,
            ]
        );
    }

    #[test]
    fn what_paraview_could_not_open_is_refused() {
        let absolute = if cfg!(windows) { "C:\\a.vtu" } else { "/a.vtu" };
        let refused = |entry| to_xml(&[entry]).expect_err("must be refused");
        assert!(matches!(
            refused(entry(f64::NAN, 0, "a", "a.vtu")),
            PvdError::TimeNotFinite { .. }
        ));
        assert!(matches!(
            refused(entry(0.0, 0, "a", absolute)),
            PvdError::FileNotRelative { .. }
        ));
        assert!(matches!(
            refused(entry(0.0, 0, "a\u{1}", "a.vtu")),
            PvdError::ControlCharacter { code: 1, .. }
        ));
    }
}
