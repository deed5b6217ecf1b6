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
mod tests {
    use super::*;
    use crate::gmsh::Value;
    use std::fs;

    fn scan(text: &str) -> GeoScript {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("model.geo");
        fs::write(&file, text).unwrap();
        GeoScript::scan(&file).unwrap()
    }

    fn names(script: &GeoScript) -> Vec<&str> {
        script.parameters.keys().map(String::as_str).collect()
    }

    #[test]
    fn a_name_may_end_with_a_unit() {
        let script = scan(
            "DefineConstant[ a = {25, Name \"Geometry/Crack length [mm]\", Min 1},\n\
             b = {2, Name \"Geometry/Teeth [of the saw] and gaps\"}, c = {1, Label \"mass [kg]\"} ];",
        );
        let unit = |name: &str| script.parameters[name].unit.as_deref();
        assert_eq!(["a", "b", "c"].map(unit), [Some("mm"), None, None]);
    }

    #[test]
    fn constants_and_their_defaults() {
        let script = scan(
            r#"
            DefineConstant[ a = 1.5e-3, b = {2, Min 0, Max 10, Name "Parameters/b, with comma"} ];
            DefineConstant [
              c = "text",
              d = {"in } attributes", Choices{"x", "y"}, Name "d"}, // e = 5
              f,
              g = 2*a,
              /* h = 7, */ i = {-3}
            ];"#,
        );
        let default = |name: &str| script.parameters[name].default.clone();
        assert_eq!(names(&script), ["a", "b", "c", "d", "f", "g", "i"]);
        assert_eq!(default("a"), Default::Number(1.5e-3));
        assert_eq!(default("b"), Default::Number(2.0));
        assert_eq!(default("c"), Default::Text("text".into()));
        assert_eq!(default("d"), Default::Text("in } attributes".into()));
        assert_eq!(default("f"), Default::Absent);
        assert_eq!(default("g"), Default::Expression("2*a".into()));
        assert_eq!(default("i"), Default::Number(-3.0));
        assert_eq!(script.parameters["a"].line, 2);
        assert_eq!(script.parameters["d"].line, 5);
    }

    #[test]
    fn attributes_bind_where_they_are_plain() {
        let script = scan(
            r#"DefineConstant[
              a = {2, Min 0.5, Max 1e1, Step 1, Name "P/Min 3, Max 4"},
              b = {1, Choices {0="no, never", 1="yes"}, Min -1},
              c = {"x", Choices{"x", "y z"}, Name "c"}, d = {1, Max 2*a}, e = {1, Choices{1, 2*a}}
            ];"#,
        );
        let range = |name: &str| script.parameters[name].range.clone();
        assert_eq!(
            (range("a").lowest, range("a").highest),
            (Some(0.5), Some(10.0))
        );
        let labelled = |value: f64, label: &str| (Value::Number(value), label.to_owned());
        assert_eq!(
            range("b").choices,
            [labelled(0.0, "no, never"), labelled(1.0, "yes")]
        );
        assert_eq!(range("b").lowest, Some(-1.0));
        let texts = ["x", "y z"].map(|text| (Value::from(text), String::new()));
        assert_eq!(range("c").choices, texts);
        assert!(range("d").is_open() && range("e").is_open());
    }

    #[test]
    fn comments_and_strings_define_nothing() {
        let script = scan(
            "// DefineConstant[ a = 1 ];\n/* DefineConstant[ b = 1 ]; */\n\
             Printf(\"DefineConstant[ c = 1 ]; // é\"); MyDefineConstant[ d = 1 ];\n\
             DefineConstant[ e = 1 ];",
        );
        assert_eq!(names(&script), ["e"]);
        assert_eq!(script.parameters["e"].line, 4);
    }

    #[test]
    fn tested_variables_are_parameters_and_defined_numbers_are_not() {
        let script = scan(
            "If(!Exists(q)) q = 9; EndIf\nh = DefineNumber[ 3, Name \"Parameters/h\" ];\n\
             s = DefineString[ \"x\", Name \"Parameters/s\" ];",
        );
        assert_eq!(names(&script), ["q"]);
        assert_eq!(script.parameters["q"].default, Default::Absent);
        assert_eq!(
            script.fixed,
            BTreeSet::from(["h".to_owned(), "s".to_owned()])
        );
    }

    #[test]
    fn unfinished_scripts_do_not_panic() {
        let whole = "DefineConstant[ a = {1, Name \"x\\\"\", Min 1, Choices{1=\"é\", 2}}, b = 'y' ]; /* é */ Merge \"z\"; // e";
        for (end, _) in whole.char_indices() {
            scan(&whole[..end]);
        }
        scan("DefineConstant[ = ]; DefineConstant[]; DefineConstant[ a = {} ]; Exists() ]]]");
    }

    #[test]
    fn included_files_are_followed_and_cycles_end() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, text).unwrap();
            path
        };
        let main = write(
            "main.geo",
            "Include \"parts/common.geo\"; Merge StrCat(CurrentDirectory, \"shape.step\");\n\
             // Include \"unused.geo\";\nMerge \"absent.geo\"; Field[1].FileName = \"size.pos\";\n\
             Save \"out.msh\";",
        );
        let common = write(
            "parts/common.geo",
            "DefineConstant[ depth = 4 ]; Include \"../main.geo\"; Include \"more.geo\";",
        );
        let more = write("parts/more.geo", "DefineConstant[ more = 1 ];");
        let shape = write("shape.step", "DefineConstant[ no = 1 ];");
        let size = write("size.pos", "");
        let options = write("main.geo.opt", "Mesh.ElementOrder = 2;");
        write("unused.geo", "DefineConstant[ unused = 1 ];");
        write("out.msh", "");
        let script = GeoScript::scan(&main).unwrap();
        assert_eq!(names(&script), ["depth", "more"]);
        assert_eq!(script.parameters["depth"].file, common);
        let found: BTreeSet<PathBuf> = script
            .files
            .iter()
            .map(|file| file.canonicalize().unwrap())
            .collect();
        let expected = [main, common, more, shape, size, options];
        let expected: BTreeSet<PathBuf> = expected
            .iter()
            .map(|file| file.canonicalize().unwrap())
            .collect();
        assert_eq!(found, expected);
        assert_eq!(script.files.len(), 6);
    }

    #[test]
    fn nearest_parameter_is_suggested() {
        let script = scan("DefineConstant[ element = 10, band_start = 400, band_end = 600 ];");
        assert_eq!(script.nearest("elment"), Some("element"));
        assert_eq!(script.nearest("band_strat"), Some("band_start"));
        assert_eq!(script.nearest("xyz"), None);
    }

    #[test]
    fn a_script_that_meshes_is_told_from_one_that_sets_options() {
        assert!(scan("Mesh 2;\n").meshes);
        let script = scan("Mesh.ElementOrder = 2; // Mesh 2;\nCreateGeometry;\n");
        assert!(!script.meshes && script.creates_geometry);
    }

    #[test]
    fn silent_traps_are_warned_of() {
        let warnings = |text: &str| scan(text).warnings;
        let lost = warnings("a = 1;\nb = 2; c = 3;");
        assert_eq!(lost.len(), 1);
        assert!(
            lost[0].contains("model.geo:2: the file does not end"),
            "{lost:?}"
        );
        let early = warnings("a = 1;\n Include \"x.geo\"; b = 2;\n");
        assert_eq!(early.len(), 1);
        assert!(
            early[0].contains("model.geo:2: Gmsh runs what follows"),
            "{early:?}"
        );
        for harmless in [
            "a = 1;\nb = 2; c = 3;\n",
            "a = 1;\nb = 2; // c = 3;",
            "Include \"x\"; // y\n",
        ] {
            assert_eq!(warnings(harmless), [""; 0]);
        }
    }

    #[test]
    fn missing_file_is_named() {
        let error = GeoScript::scan(Path::new("nowhere/x.geo")).unwrap_err();
        assert!(error.to_string().contains("nowhere/x.geo"));
    }
}
