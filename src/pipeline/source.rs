//! The pipeline file's text, and messages that point into it.

use marked_yaml::types::Node;
use miette::{Diagnostic, NamedSource, SourceSpan};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What is wrong with the input, where, and how to mend it. Exit code 2.
#[derive(Debug, Diagnostic, Error)]
#[error("{message}")]
pub struct InputError {
    pub message: String,
    #[help]
    pub help: Option<String>,
    #[source_code]
    source_code: Option<NamedSource<String>>,
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
        let marks = marked_yaml::parse_yaml(0, &text).ok();
        Source {
            path: path.to_owned(),
            text,
            marks,
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
        let set = self
            .overrides
            .iter()
            .find(|(set, _)| key.starts_with(set.as_str()));
        match set {
            Some((set, value)) => {
                let option = format!("--set {}={value}", set.replace('/', "."));
                InputError::plain(format!("{} (by `{option}`)", message.into()), help)
            }
            None => self.error_at(self.span_of(key), message, help),
        }
    }

    /// An error at a byte offset.
    pub fn error_at_byte(
        &self,
        byte: usize,
        message: impl Into<String>,
        help: Option<String>,
    ) -> InputError {
        self.error_at(Some(self.span_from(byte)), message, help)
    }

    fn error_at(
        &self,
        span: Option<SourceSpan>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> InputError {
        let name = self.path.display().to_string();
        let message = match span {
            Some(_) => message.into(),
            None => format!("{name}: {}", message.into()),
        };
        InputError {
            message,
            help,
            source_code: Some(NamedSource::new(name, self.text.clone()).with_language("yaml")),
            span,
        }
    }

    fn span_of(&self, key: &str) -> Option<SourceSpan> {
        let mut node = self.marks.as_ref()?;
        for step in key.split('/').filter(|step| !step.is_empty()) {
            let child = match node {
                Node::Mapping(mapping) => mapping.get_node(step),
                Node::Sequence(list) => step.parse().ok().and_then(|k| list.get_node(k)),
                Node::Scalar(_) => None,
            };
            match child {
                Some(child) => node = child,
                None => break,
            }
        }
        let character = node.span().start()?.character();
        let byte = self
            .text
            .char_indices()
            .nth(character)
            .map_or(self.text.len(), |(b, _)| b);
        Some(self.span_from(byte))
    }

    /// From `byte` to the end of its line, without a comment.
    fn span_from(&self, byte: usize) -> SourceSpan {
        let byte = (0..=byte.min(self.text.len()))
            .rev()
            .find(|&b| self.text.is_char_boundary(b))
            .unwrap_or(0);
        let line = self.text[byte..].lines().next().unwrap_or("");
        let content = line.split(" #").next().unwrap_or(line).trim_end();
        (byte, content.len().max(1).min(self.text.len() - byte)).into()
    }
}

/// `; did you mean …?` and the valid choices.
pub fn choices<'a>(given: &str, valid: impl IntoIterator<Item = &'a str>) -> String {
    let valid: Vec<&str> = valid.into_iter().collect();
    let closest = valid
        .iter()
        .map(|name| (strsim::damerau_levenshtein(given, name), name))
        .filter(|(distance, name)| *distance <= 1 + name.len() / 3)
        .min();
    let list = valid
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    match closest {
        Some((_, name)) => format!("did you mean `{name}`? There are: {list}"),
        None if valid.is_empty() => "there are none".to_owned(),
        None => format!("there are: {list}"),
    }
}
