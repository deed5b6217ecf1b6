//! Error messages of Gmsh, with the place in a file that they name.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::ffi_types::FfiError;

/// An error message of Gmsh, with the place in a file if it names one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    pub file: Option<PathBuf>,
    /// Counted from 1.
    pub line: Option<u32>,
    pub text: String,
}

impl Message {
    /// Reads "'FILE', line N: TEXT"; any other text has no place.
    pub(super) fn parse(text: &str) -> Message {
        let located = || {
            let (file, rest) = text.strip_prefix('\'')?.split_once("', line ")?;
            let (line, message) = rest.split_once(':')?;
            let line = line.trim().parse().ok()?;
            Some((file, line, message.trim()))
        };
        match located() {
            Some((file, line, message)) => Message {
                file: Some(PathBuf::from(file)),
                line: Some(line),
                text: message.to_owned(),
            },
            None => Message {
                file: None,
                line: None,
                text: text.to_owned(),
            },
        }
    }
}

impl std::fmt::Display for Message {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        }
        write!(f, "{}", self.text)
    }
}

impl From<FfiError> for Message {
    fn from(error: FfiError) -> Message {
        Message::parse(&error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn messages_carry_file_and_line() {
        let message = Message::parse("'/a/it's.geo', line 12: syntax error (})");
        assert_eq!(message.file.as_deref(), Some(Path::new("/a/it's.geo")));
        assert_eq!(message.line, Some(12));
        assert_eq!(message.to_string(), "/a/it's.geo:12: syntax error (})");
        let plain = Message::parse("Unable to open file 'x'");
        assert_eq!((&plain.file, plain.line), (&None, None));
        assert_eq!(plain.to_string(), "Unable to open file 'x'");
    }
}
