//! The pipeline file's text, and messages that point into it.

use super::nesting::is_shallow;
use marked_yaml::types::{MarkedScalarNode, Marker, Node, Span};
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thiserror::Error;

/// An error of the input, its place, and the fix. Exit code 2.
#[derive(Debug, Diagnostic, Error)]
#[error("{message}")]
pub struct InputError {
    pub message: String,
    #[help]
    pub help: Option<String>,
    #[source_code]
    source_code: Option<Arc<NamedSource<String>>>,
    #[label("here")]
    span: Option<SourceSpan>,
}

impl InputError {
    /// An error with no place in a pipeline file.
    pub fn plain(message: impl Into<String>, help: Option<String>) -> InputError {
        InputError {
            message: message.into(),
            help,
            source_code: None,
            span: None,
        }
    }
}

impl InputError {
    /// The file that the message points into, and the line, from 1 on.
    pub fn place(&self) -> Option<(&str, usize)> {
        let (source, span) = (self.source_code.as_ref()?, self.span?);
        let before = source.inner().get(..span.offset())?;
        Some((source.name(), 1 + before.matches('\n').count()))
    }
}

/// A pipeline file as it was read.
#[derive(Clone, Debug)]
pub struct Source {
    pub path: PathBuf,
    text: String,
    /// Absent where the text is not YAML, or uses anchors.
    marks: Option<Node>,
    /// Keys that the command line sets, `a/b/c`, and their values.
    overrides: Vec<(String, String)>,
}

impl Source {
    pub fn new(path: &Path, text: String, overrides: Vec<(String, String)>) -> Source {
        let marks = is_shallow(&text).then(|| marked_yaml::parse_yaml(0, &text));
        Source {
            path: path.to_owned(),
            text,
            marks: marks.and_then(Result::ok),
            overrides,
        }
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    pub fn overrides(&self) -> &[(String, String)] {
        &self.overrides
    }

    /// An error at a key such as `regions/1/spacing`; where the file does not hold the key, at what
    /// holds it.
    pub fn error(&self, key: &str, message: impl Into<String>, help: Option<String>) -> InputError {
        let message = message.into();
        if let Some((set, value)) = self
            .overrides
            .iter()
            .rev()
            .find(|(set, _)| within(key, set))
        {
            let option = format!("--set {}={value}", set.replace('/', "."));
            return InputError::plain(format!("{message} (by `{option}`)"), help);
        }
        match self.span_of(key) {
            Some(span) => self.error_at(span, message, help),
            None => self.error_in_file(format!("`{}`: {message}", key.replace('/', ".")), help),
        }
    }

    /// An error at the name of a key, not at its value.
    pub fn error_at_name(&self, key: &str, message: String, help: Option<String>) -> InputError {
        let (holder, name) = key.rsplit_once('/').unwrap_or(("", key));
        match self.name_in(holder, name) {
            Some(mark) if !self.is_overridden(key) => self.error_at_mark(&mark, message, help),
            _ => self.error(key, message, help),
        }
    }

    fn name_in(&self, holder: &str, name: &str) -> Option<Span> {
        let mapping = self.node(holder)?.as_mapping()?;
        let mut names = mapping.keys();
        let found = names.find(|key| key.as_str() == name)?;
        Some(*found.span())
    }

    /// The value of a key, or of the last step to it that is there.
    fn nearest(&self, key: &str) -> Option<&Node> {
        let mut node = self.marks.as_ref()?;
        for step in steps(key) {
            match child(node, step) {
                Some(child) => node = child,
                None => break,
            }
        }
        Some(node)
    }

    fn node(&self, key: &str) -> Option<&Node> {
        steps(key).try_fold(self.marks.as_ref()?, child)
    }

    /// Whether the command line sets a key.
    pub fn is_overridden(&self, key: &str) -> bool {
        self.overrides.iter().any(|(set, _)| within(key, set))
    }

    /// An error at a byte offset.
    pub fn error_at_byte(&self, byte: usize, message: String, help: Option<String>) -> InputError {
        self.error_at(self.span_from(byte), message, help)
    }

    /// An error at what marked_yaml has marked.
    pub fn error_at_mark(&self, mark: &Span, message: String, help: Option<String>) -> InputError {
        let byte = mark.start().map_or(0, |mark| self.byte_of(mark));
        self.error_at_byte(byte, message, help)
    }

    /// An error of the file as a whole.
    pub fn error_in_file(&self, message: impl Into<String>, help: Option<String>) -> InputError {
        InputError::plain(format!("{}: {}", self.path.display(), message.into()), help)
    }

    fn error_at(&self, span: SourceSpan, message: String, help: Option<String>) -> InputError {
        let name = self.path.display().to_string();
        let source = NamedSource::new(name, self.text.clone()).with_language("yaml");
        InputError {
            message,
            help,
            source_code: Some(Arc::new(source)),
            span: Some(span),
        }
    }

    fn span_of(&self, key: &str) -> Option<SourceSpan> {
        let node = self.nearest(key)?;
        let byte = self.byte_of(node.span().start()?);
        let is_absent = |scalar: &MarkedScalarNode| scalar.as_str().is_empty();
        let is_absent = node.as_scalar().is_some_and(is_absent);
        Some(self.span_from(if is_absent {
            self.key_before(byte)
        } else {
            byte
        }))
    }

    /// A value that is not there is marked where the next thing begins: the line that ends before.
    fn key_before(&self, byte: usize) -> usize {
        let before = self.text[..byte].trim_end();
        let line = before.rfind('\n').map_or(0, |newline| newline + 1);
        line + before[line..].find(|c: char| c != ' ').unwrap_or(0)
    }

    fn byte_of(&self, mark: &Marker) -> usize {
        self.text
            .char_indices()
            .nth(mark.character())
            .map_or(self.text.len(), |(byte, _)| byte)
    }

    fn line_from(&self, byte: usize) -> (usize, &str) {
        let boundary = |&b: &usize| self.text.is_char_boundary(b);
        let byte = (0..=byte.min(self.text.len()))
            .rev()
            .find(boundary)
            .unwrap_or(0);
        (byte, self.text[byte..].lines().next().unwrap_or(""))
    }

    /// The line that holds a byte.
    pub fn line_at_byte(&self, byte: usize) -> &str {
        let (byte, _) = self.line_from(byte);
        let start = self.text[..byte]
            .rfind('\n')
            .map_or(0, |newline| newline + 1);
        self.line_from(start).1
    }

    /// From `byte` to the end of the value that begins there, or of its line.
    fn span_from(&self, byte: usize) -> SourceSpan {
        let (byte, line) = self.line_from(byte);
        (byte, extent(line).max(1).min(self.text.len() - byte)).into()
    }
}

fn steps(key: &str) -> impl Iterator<Item = &str> {
    key.split('/').filter(|step| !step.is_empty())
}

fn child<'a>(node: &'a Node, step: &str) -> Option<&'a Node> {
    match node {
        Node::Mapping(mapping) => mapping.get_node(step),
        Node::Sequence(list) => list.get_node(step.parse().ok()?),
        Node::Scalar(_) => None,
    }
}

/// Whether `key` is `holder` or lies below it.
fn within(key: &str, holder: &str) -> bool {
    key.strip_prefix(holder)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// The length of the value that `line` begins with: a flow list or mapping to its bracket, any other
/// to a comma or bracket that is not its own, to a comment or to the end.
fn extent(line: &str) -> usize {
    let mut depth = 0;
    let mut quote = None;
    let mut before = ' ';
    for (byte, character) in line.char_indices() {
        match (quote, character) {
            (Some(open), _) if open == character => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') if byte == 0 || " [{,".contains(before) => quote = Some(character),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') if depth > 1 => depth -= 1,
            (None, ']' | '}') if depth == 1 => return byte + 1,
            (None, ']' | '}') => return line[..byte].trim_end().len(),
            (None, ',') if depth == 0 => return line[..byte].trim_end().len(),
            (None, '#') if before == ' ' => return line[..byte].trim_end().len(),
            _ => {}
        }
        before = character;
    }
    line.trim_end().len()
}

/// Names as a list: `a`, `b`.
pub fn quoted(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    names.join(", ")
}

/// The valid choices, and the one that was perhaps meant.
pub fn choices<'a>(given: &str, valid: impl IntoIterator<Item = &'a str>) -> String {
    let valid: Vec<&str> = valid.into_iter().collect();
    let is_close = |distance: usize, name: &str| {
        distance <= 1 + name.chars().count() / 3 && distance < name.chars().count()
    };
    let closest = valid
        .iter()
        .map(|name| (strsim::damerau_levenshtein(given, name), name))
        .filter(|(distance, name)| is_close(*distance, name))
        .min();
    let list = quoted(&valid);
    match (closest, valid.len()) {
        (_, 0) => "there are none".to_owned(),
        (Some((_, name)), 1) => format!("did you mean `{name}`? It is the only one"),
        (Some((_, name)), _) => format!("did you mean `{name}`? There are: {list}"),
        (None, 1) => format!("the only one is {list}"),
        (None, _) => format!("there are: {list}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_ends_where_the_next_begins() {
        let cases = [
            ("100 GPaa, poisson: 1/3 }", "100 GPaa"),
            ("[left, rigth], model: fem", "[left, rigth]"),
            ("{ group: [a, b], x: 1 } # why", "{ group: [a, b], x: 1 }"),
            ("'a, b', c", "'a, b'"),
            ("1.5               # in spacings", "1.5"),
            ("kernal: quartic", "kernal: quartic"),
            ("[left,", "[left,"),
            ("it's, so", "it's"),
        ];
        for (line, value) in cases {
            assert_eq!(&line[..extent(line)], value);
        }
    }

    #[test]
    fn only_what_is_alike_is_meant() {
        assert_eq!(choices("z", ["x", "y"]), "there are: `x`, `y`");
        assert_eq!(
            choices("rigth", ["left", "right"]),
            "did you mean `right`? There are: `left`, `right`"
        );
        assert_eq!(
            choices("trus", ["truss"]),
            "did you mean `truss`? It is the only one"
        );
        assert_eq!(choices("a", []), "there are none");
    }

    #[test]
    fn a_key_is_within_itself_and_what_holds_it() {
        assert!(within("regions/1/spacing", "regions/1"));
        assert!(within("regions/1", "regions/1"));
        assert!(!within("regions/10/spacing", "regions/1"));
    }
}
