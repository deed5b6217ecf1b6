//! A light reading of a `.geo` file, without running it: which parameters it offers and which
//! files it depends upon.
//!
//! A parameter is a variable of `DefineConstant[...]`, or one that the script tests with
//! `Exists(...)`: those Gmsh lets the command line override (`-setnumber`, `-setstring`), under the
//! variable's name, whatever its `Name "..."` attribute. Variables of `DefineNumber[...]` and
//! `DefineString[...]` are not overridden (4.8: never; 4.15: only under the attribute's name).
//!
//! Two traps that Gmsh passes over in silence (4.8 and 4.15) are found here: of a last line without
//! an end-of-line only the first statement is run, and what follows an `Include` on its line is run
//! before the included file.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::guard::{ScriptCommand, saves, unsafe_commands};
use super::parameter::{Default, Parameter, Range as Allowed};
use super::script_files::{NamedFile, is_script, named_files, options_file};
use super::script_text::{Text, leading_blanks};

/// A file of the script could not be read.
#[derive(Debug, Error)]
#[error("cannot read {}: {source}", .file.display())]
pub struct ScriptError {
    pub file: PathBuf,
    pub source: io::Error,
}

/// The parameters, files and commands of a `.geo` file and of all files that it includes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeoScript {
    pub parameters: BTreeMap<String, Parameter>,
    /// Variables of `DefineNumber` and `DefineString`, which cannot be set.
    pub fixed: BTreeSet<String>,
    /// The script and every existing file that it includes, merges or reads, sorted.
    pub files: Vec<PathBuf>,
    /// Lines that Gmsh runs otherwise than they read.
    pub warnings: Vec<String>,
    /// Commands that run programs, write files or read files under computed names.
    pub unsafe_commands: Vec<ScriptCommand>,
    /// The `Save` commands, which are passed over.
    pub saves: Vec<ScriptCommand>,
    /// Files that the script names and that do not exist.
    pub absent: Vec<NamedFile>,
    /// Whether it makes a geometry of a merged mesh: `CreateGeometry`.
    pub creates_geometry: bool,
    /// Whether it makes a mesh: `Mesh 2`.
    pub meshes: bool,
}

impl GeoScript {
    /// Reads `file` and what it includes. Included files are sought beside the including one.
    pub fn scan(file: &Path) -> Result<GeoScript, ScriptError> {
        let mut script = GeoScript::default();
        let mut seen = BTreeSet::new();
        let mut pending = vec![file.to_owned()];
        while let Some(file) = pending.pop() {
            let identity = file.canonicalize().unwrap_or_else(|_| file.clone());
            if !seen.insert(identity) {
                continue;
            }
            if is_script(&file) {
                let text = std::fs::read(&file).map_err(|source| ScriptError {
                    file: file.clone(),
                    source,
                })?;
                let text = Text::new(&String::from_utf8_lossy(&text));
                script.add_parameters(&file, &text);
                script.add_warnings(&file, &text);
                script.creates_geometry |= text.words("CreateGeometry").next().is_some();
                script.meshes |= text.words("Mesh").any(|at| {
                    let behind = text.code[at.end..].trim_start();
                    behind.starts_with(|c: char| c.is_ascii_digit())
                });
                script.unsafe_commands.extend(unsafe_commands(&file, &text));
                script.saves.extend(saves(&file, &text));
                let (there, absent): (Vec<NamedFile>, Vec<NamedFile>) = named_files(&file, &text)
                    .into_iter()
                    .partition(|named| named.path.is_file());
                pending.extend(there.into_iter().map(|named| named.path));
                pending.extend(options_file(&file));
                script.absent.extend(absent);
            }
            script.files.push(file);
        }
        script.files.sort();
        Ok(script)
    }

    /// The parameter whose name is most like `name`, if any is like it at all.
    pub fn nearest(&self, name: &str) -> Option<&str> {
        let close = |known: &&String| strsim::jaro_winkler(name, known) > 0.75;
        let likeness = |known: &&String| strsim::jaro_winkler(name, known);
        self.parameters
            .keys()
            .filter(close)
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
            .map(String::as_str)
    }

    fn add_parameters(&mut self, file: &Path, text: &Text) {
        for at in text.words("DefineConstant") {
            let Some(body) = text.bracketed(at.end) else {
                continue;
            };
            for item in text.split(body, b',') {
                self.add_parameter(file, text, item);
            }
        }
        for at in text.words("Exists") {
            if let Some(body) = text.bracketed(at.end) {
                let name = text.code[body].trim();
                let (default, range) = (Default::Absent, Allowed::default());
                self.define(name, default, range, None, file, text.line(at.start));
            }
        }
        for word in ["DefineNumber", "DefineString"] {
            let starts = text.words(word).map(|at| at.start);
            self.fixed.extend(starts.filter_map(|at| text.assigned(at)));
        }
    }

    fn add_warnings(&mut self, file: &Path, text: &Text) {
        let mut warn = |at: usize, what: &str| {
            let (file, line) = (file.display(), text.line(at));
            self.warnings.push(format!("{file}:{line}: {what}"));
        };
        let last = text.code.rfind('\n').map_or(0, |newline| newline + 1);
        if text.code[last..].matches(';').count() > 1 {
            warn(
                last,
                "the file does not end with an end-of-line, so Gmsh runs only the first \
                 statement of its last line; add one",
            );
        }
        for at in text.words("Include") {
            let rest = text.code[at.end..].lines().next().unwrap_or_default();
            let behind = rest.split_once(';').map_or("", |(_, behind)| behind.trim());
            if !behind.is_empty() {
                warn(
                    at.start,
                    "Gmsh runs what follows an Include on the same line before the included \
                     file; put it on a line of its own",
                );
            }
        }
    }

    /// Adds `name = value`, `name = {value, attributes}` or a bare `name`.
    fn add_parameter(&mut self, file: &Path, text: &Text, item: Range<usize>) {
        let line = text.line(item.start + leading_blanks(&text.code[item.clone()]));
        let equals = text.code[item.clone()].find('=').map(|at| item.start + at);
        let Some(equals) = equals else {
            let (default, range) = (Default::Absent, Allowed::default());
            return self.define(text.code[item].trim(), default, range, None, file, line);
        };
        let name = text.code[item.start..equals].trim();
        let mut value = equals + 1..item.end;
        let mut range = Allowed::default();
        let mut unit = None;
        if let Some(inner) = text.bracketed(value.start) {
            let mut pieces = text.split(inner, b',');
            value = pieces.next().unwrap_or(0..0);
            for attribute in pieces {
                unit = unit.or_else(|| text.unit_in_name(attribute.clone()));
                text.add_attribute(attribute, &mut range);
            }
        }
        self.define(name, text.default(value), range, unit, file, line);
    }

    fn define(
        &mut self,
        name: &str,
        default: Default,
        range: Allowed,
        unit: Option<String>,
        file: &Path,
        line: usize,
    ) {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if name.is_empty() || !name.chars().all(is_name) {
            return;
        }
        let parameter = Parameter {
            default,
            range,
            unit,
            file: file.to_owned(),
            line,
        };
        let known = self.parameters.get(name);
        if known.is_none_or(|known| known.default == Default::Absent) {
            self.parameters.insert(name.to_owned(), parameter);
        }
    }
}

#[cfg(test)]
mod tests;
