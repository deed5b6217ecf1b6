//! Commands of a script that do more than draw: they run programs and write files.
//!
//! A `.geo` is code. These commands are found in the text, before Gmsh sees it, so that the message has
//! file and line; what the text does not show, `sandbox.rs` forbids while Gmsh runs. A `Save` is the last
//! line of very many scripts and changes no mesh: it is passed over, with a note.

use super::script_text::Text;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A command of a script and its place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScriptCommand {
    pub file: PathBuf,
    /// Counted from 1.
    pub line: usize,
    /// The effect of the command, such as `SystemCall runs a program`.
    pub what: String,
}

/// Commands and fields that are never part of a drawing.
const UNSAFE: [(&str, &str); 6] = [
    ("SystemCall", "runs a program"),
    ("NonBlockingSystemCall", "runs a program"),
    ("OnelabRun", "runs a program"),
    ("ExternalProcess", "runs a program"),
    ("Print", "writes a file"),
    ("UnsplitWindow", "works on Gmsh's window"),
];

/// Commands whose files are read along, so that their names must be in the text.
const READING: [&str; 4] = ["Include", "Merge", "MergeWithBoundingBox", "ShapeFromFile"];

/// The unsafe commands of one file, in order.
pub(super) fn unsafe_commands(file: &Path, text: &Text) -> Vec<ScriptCommand> {
    let mut found: Vec<(usize, String)> = Vec::new();
    for (word, what) in UNSAFE {
        let commands = text.words(word).filter(|at| is_command(text, at));
        found.extend(commands.map(|at| (at.start, format!("{word} {what}"))));
    }
    for at in text.words("Printf") {
        let behind = text.bracketed(at.end).map(|inside| inside.end + 1);
        let rest = behind.and_then(|end| text.code.get(end..)).unwrap_or("");
        if rest.trim_start().starts_with('>') {
            found.push((at.start, "Printf with > writes a file".to_owned()));
        }
    }
    for word in READING {
        for at in text.words(word).filter(|at| is_command(text, at)) {
            if !names_its_file(text, &at) {
                let what = format!(
                    "{word} computes the name of its file, so that nobody can tell which it reads"
                );
                found.push((at.start, what));
            }
        }
    }
    let views = save_commands(text).filter(|at| is_save_of_a_view(text, at));
    found.extend(views.map(|at| (at.start, "Save View writes a file".to_owned())));
    found.sort();
    let command = |(at, what)| ScriptCommand {
        file: file.to_owned(),
        line: text.line(at),
        what,
    };
    found.into_iter().map(command).collect()
}

/// The `Save` commands of one file that write the model or its mesh, in order.
pub(super) fn saves(file: &Path, text: &Text) -> Vec<ScriptCommand> {
    let command = |at: Range<usize>| ScriptCommand {
        file: file.to_owned(),
        line: text.line(at.start),
        what: "`Save` is passed over: a geometry writes no files here".to_owned(),
    };
    let commands = save_commands(text).filter(|at| !is_save_of_a_view(text, at));
    commands.map(command).collect()
}

fn save_commands(text: &Text) -> impl Iterator<Item = Range<usize>> {
    text.words("Save").filter(|at| is_command(text, at))
}

/// `Save View[0] "x.pos"`: Gmsh's log does not announce what it writes here, so that its failure
/// could not be told from others.
fn is_save_of_a_view(text: &Text, at: &Range<usize>) -> bool {
    text.code[at.end..].trim_start().starts_with("View")
}

/// Excludes the category of an option, `Print.Background = 1`, and its name, `Mesh.Save`.
fn is_command(text: &Text, at: &Range<usize>) -> bool {
    let before = text.code[..at.start].trim_end();
    let behind = text.code[at.end..].trim_start();
    !before.ends_with('.') && !behind.starts_with(['.', '='])
}

/// Returns whether one string and nothing else stands between the command and its semicolon.
fn names_its_file(text: &Text, at: &Range<usize>) -> bool {
    let rest = &text.code[at.end..];
    let end = rest.find(';').unwrap_or(rest.len());
    let argument = rest[..end].trim().trim_matches(['(', ')', '[', ']']).trim();
    let mut characters = argument.chars();
    let quote = characters.next();
    matches!(quote, Some('"' | '\'')) && {
        // The contents of strings are blank here: two quotes and blanks between them.
        let inside = characters.as_str().trim_end_matches(['"', '\'']);
        inside.trim().is_empty() && argument.len() >= 2 && argument.ends_with(['"', '\''])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(script: &str) -> Vec<(usize, String)> {
        let commands = unsafe_commands(Path::new("a.geo"), &Text::new(script));
        commands
            .into_iter()
            .map(|command| (command.line, command.what))
            .collect()
    }

    #[test]
    fn commands_that_do_more_than_draw_are_found_with_their_line() {
        let script = "\
Point(1) = {0, 0, 0};
SystemCall \"touch /tmp/x\";
NonBlockingSystemCall StrCat(\"touch \", \"/tmp/y\"); OnelabRun(\"x\", \"y\");
Field[1] = ExternalProcess;
/* Save View[0] \"a.pos\"; */ Save View[0] \"b.pos\";
Print Sprintf(\"%g.png\", 1);
Printf(\"%g\", 1) >> \"out.txt\";
Printf(\"%g > %g\", 1, 2);
";
        let expected = [
            (2, "SystemCall runs a program"),
            (3, "NonBlockingSystemCall runs a program"),
            (3, "OnelabRun runs a program"),
            (4, "ExternalProcess runs a program"),
            (5, "Save View writes a file"),
            (6, "Print writes a file"),
            (7, "Printf with > writes a file"),
        ];
        assert_eq!(
            found(script),
            expected.map(|(line, what)| (line, what.to_owned()))
        );
    }

    #[test]
    fn saves_of_the_mesh_are_found_with_their_line() {
        let script = "Mesh 2;\nSave \"a.msh\"; Save Sprintf(\"%g.vtk\", 1);\n// Save \"b.msh\";\n\
                      Save View[0] \"c.pos\"; Mesh.Save = 1;\n";
        let found = saves(Path::new("a.geo"), &Text::new(script));
        let lines: Vec<usize> = found.iter().map(|save| save.line).collect();
        assert_eq!(lines, [2, 2]);
    }

    #[test]
    fn drawing_is_safe() {
        let script = "\
// SystemCall \"x\";
Print.Background = 1; Mesh.SaveAll = 1; Mesh . Save = 1;
a = \"SystemCall\"; SystemCalls = 2; Save_it = 3;
Include \"b.geo\"; Merge 'part.step'; Merge(\"c.msh\");
Physical Surface(\"Save\") = {1};
";
        assert_eq!(found(script), []);
    }

    #[test]
    fn a_file_whose_name_is_computed_cannot_be_read_along() {
        for script in [
            "Include Str(\"a\", \".geo\");",
            "Merge StrCat(\"a\", \"b\");",
            "Include name;",
            "Merge \"a\" \"b\";",
            "Include Sprintf(\"%g.geo\", 1)",
        ] {
            let found = found(script);
            assert_eq!(found.len(), 1, "{script}");
            assert!(
                found[0].1.contains("computes the name of its file"),
                "{found:?}"
            );
        }
    }
}
