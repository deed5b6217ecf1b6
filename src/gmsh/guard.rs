//! What a script could do besides drawing: run programs and write files.
//!
//! A `.geo` is code. These commands are found in the text, before Gmsh sees it, so that the message has
//! file and line; what the text does not show, `sandbox.rs` forbids while Gmsh runs.

use super::geo_script::Text;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A place where a script does more than draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deed {
    pub file: PathBuf,
    /// Counted from 1.
    pub line: usize,
    /// `SystemCall runs a program`.
    pub what: String,
}

/// Commands and fields that are never part of a drawing.
const DEEDS: [(&str, &str); 7] = [
    ("SystemCall", "runs a program"),
    ("NonBlockingSystemCall", "runs a program"),
    ("OnelabRun", "runs a program"),
    ("ExternalProcess", "runs a program"),
    ("Save", "writes a file"),
    ("Print", "writes a file"),
    ("UnsplitWindow", "works on Gmsh's window"),
];

/// Commands whose files are read along, so that their names must be in the text.
const READING: [&str; 4] = ["Include", "Merge", "MergeWithBoundingBox", "ShapeFromFile"];

/// All of them in one file, in order.
pub(super) fn deeds(file: &Path, text: &Text) -> Vec<Deed> {
    let mut found: Vec<(usize, String)> = Vec::new();
    for (word, what) in DEEDS {
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
    found.sort();
    let deed = |(at, what)| Deed {
        file: file.to_owned(),
        line: text.line(at),
        what,
    };
    found.into_iter().map(deed).collect()
}

/// Not an option's category, `Print.Background = 1`, nor its name, `Mesh.Save`.
fn is_command(text: &Text, at: &Range<usize>) -> bool {
    let before = text.code[..at.start].trim_end();
    let behind = text.code[at.end..].trim_start();
    !before.ends_with('.') && !behind.starts_with(['.', '='])
}

/// Whether one string and nothing else stands between the command and its semicolon.
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

    fn told(script: &str) -> Vec<(usize, String)> {
        let deeds = deeds(Path::new("a.geo"), &Text::new(script));
        deeds
            .into_iter()
            .map(|deed| (deed.line, deed.what))
            .collect()
    }

    #[test]
    fn commands_that_do_more_than_draw_are_found_with_their_line() {
        let script = "\
Point(1) = {0, 0, 0};
SystemCall \"touch /tmp/x\";
NonBlockingSystemCall StrCat(\"touch \", \"/tmp/y\"); OnelabRun(\"x\", \"y\");
Field[1] = ExternalProcess;
/* Save \"a.msh\"; */ Save \"b.msh\";
Print Sprintf(\"%g.png\", 1);
Printf(\"%g\", 1) >> \"out.txt\";
Printf(\"%g > %g\", 1, 2);
";
        let expected = [
            (2, "SystemCall runs a program"),
            (3, "NonBlockingSystemCall runs a program"),
            (3, "OnelabRun runs a program"),
            (4, "ExternalProcess runs a program"),
            (5, "Save writes a file"),
            (6, "Print writes a file"),
            (7, "Printf with > writes a file"),
        ];
        assert_eq!(
            told(script),
            expected.map(|(line, what)| (line, what.to_owned()))
        );
    }

    #[test]
    fn drawing_is_no_deed() {
        let script = "\
// SystemCall \"x\";
Print.Background = 1; Mesh.SaveAll = 1; Mesh . Save = 1;
a = \"SystemCall\"; SystemCalls = 2; Save_it = 3;
Include \"b.geo\"; Merge 'part.step'; Merge(\"c.msh\");
Physical Surface(\"Save\") = {1};
";
        assert_eq!(told(script), []);
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
            let told = told(script);
            assert_eq!(told.len(), 1, "{script}");
            assert!(
                told[0].1.contains("computes the name of its file"),
                "{told:?}"
            );
        }
    }
}
