//! The text of a Gmsh script: where its commands, brackets and strings are.

use std::ops::Range;

use super::Value;
use super::parameter::{Default, Range as Allowed};

/// The text of a script, and a twin of equal length in which comments and the contents of strings
/// are blank: syntax is sought in the twin, strings are read from the text.
pub(super) struct Text {
    pub text: String,
    pub code: String,
}

impl Text {
    pub fn new(text: &str) -> Text {
        let mut code = Vec::with_capacity(text.len());
        let bytes = text.as_bytes();
        let mut at = 0;
        while at < bytes.len() {
            let rest = &bytes[at..];
            let (length, visible) = match rest {
                [b'/', b'/', ..] => (until(rest, b"\n"), 0),
                [b'/', b'*', ..] => (2 + until(&rest[2..], b"*/") + 2, 0),
                [quote @ (b'"' | b'\''), ..] => (1 + until_quote(&rest[1..], *quote) + 1, 1),
                _ => (1, 1),
            };
            let token = &rest[..length.min(rest.len())];
            code.extend(token.iter().enumerate().map(|(i, &byte)| {
                let delimiter = visible == 1 && (i == 0 || i + 1 == token.len());
                let keep = byte == b'\n' || (delimiter && byte.is_ascii());
                if keep { byte } else { b' ' }
            }));
            at += token.len();
        }
        Text {
            text: text.to_owned(),
            code: String::from_utf8(code).expect("only ASCII bytes are kept, others are blanks"),
        }
    }

    /// The places at which a keyword stands as a word of its own.
    pub fn words<'a>(&'a self, word: &'a str) -> impl Iterator<Item = Range<usize>> + 'a {
        let part = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let code = self.code.as_bytes();
        let found = self.code.match_indices(word);
        found
            .map(|(start, word)| start..start + word.len())
            .filter(move |at| {
                let before = at.start.checked_sub(1).map(|i| &code[i]);
                !before.is_some_and(part) && !code.get(at.end).is_some_and(part)
            })
    }

    /// The inside of the bracket that opens at `from`, blanks skipped.
    pub fn bracketed(&self, from: usize) -> Option<Range<usize>> {
        let code = self.code.as_bytes();
        let open = from + leading_blanks(&self.code[from..]);
        if !matches!(code.get(open), Some(b'[' | b'(' | b'{')) {
            return None;
        }
        let mut depth = 0;
        for (at, byte) in code.iter().enumerate().skip(open) {
            depth += nesting(*byte);
            if depth == 0 {
                return Some(open + 1..at);
            }
        }
        None
    }

    /// The pieces of a range between separators that stand in no inner bracket.
    pub fn split(&self, range: Range<usize>, separator: u8) -> impl Iterator<Item = Range<usize>> {
        let mut pieces = Vec::new();
        let (mut start, mut depth) = (range.start, 0);
        for at in range.clone() {
            let byte = self.code.as_bytes()[at];
            depth += nesting(byte);
            if depth == 0 && byte == separator {
                pieces.push(start..at);
                start = at + 1;
            }
        }
        pieces.push(start..range.end);
        pieces.into_iter()
    }

    /// The variable to which what stands at `at` is assigned.
    pub fn assigned(&self, at: usize) -> Option<String> {
        let before = self.code[..at].trim_end().strip_suffix('=')?;
        let name = before
            .trim_end()
            .rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_');
        name.take(1)
            .find(|name| !name.is_empty())
            .map(str::to_owned)
    }

    /// The contents of the strings within a range.
    pub fn strings(&self, range: Range<usize>) -> Vec<&str> {
        let code = self.code[range.clone()].bytes().enumerate();
        let quotes = code.filter(|(_, byte)| matches!(byte, b'"' | b'\''));
        let quotes: Vec<usize> = quotes.map(|(at, _)| range.start + at).collect();
        let pairs = quotes.chunks_exact(2);
        pairs.map(|pair| &self.text[pair[0] + 1..pair[1]]).collect()
    }

    pub fn default(&self, value: Range<usize>) -> Default {
        let written = self.text[value.clone()].trim();
        if let Ok(number) = self.code[value.clone()].trim().parse() {
            return Default::Number(number);
        }
        match self.strings(value.clone()).as_slice() {
            [] if written.is_empty() => Default::Absent,
            [text] if self.code[value].trim().starts_with(['"', '\'']) => {
                Default::Text((*text).to_owned())
            }
            _ => Default::Expression(written.to_owned()),
        }
    }

    /// `mm` of the attribute `Name "Geometry/Crack length [mm]"`.
    pub fn unit_in_name(&self, attribute: Range<usize>) -> Option<String> {
        if !self.code[attribute.clone()].trim().starts_with("Name") {
            return None;
        }
        let name = *self.strings(attribute).first()?;
        let (_, unit) = name.trim_end().strip_suffix(']')?.rsplit_once('[')?;
        Some(unit.trim().to_owned())
    }

    /// Reads `Min 1`, `Max 9` or `Choices{…}`; what is no plain number or text binds nothing.
    pub fn add_attribute(&self, attribute: Range<usize>, allowed: &mut Allowed) {
        let start = attribute.start + leading_blanks(&self.code[attribute.clone()]);
        let word = self.code[start..attribute.end]
            .split(|c: char| !c.is_ascii_alphabetic())
            .next()
            .unwrap_or("");
        let rest = start + word.len()..attribute.end;
        let number = || self.default(rest.clone()).value().and_then(Value::number);
        match word {
            "Min" => allowed.lowest = number(),
            "Max" => allowed.highest = number(),
            "Choices" => allowed.choices = self.choices(rest.start).unwrap_or_default(),
            _ => {}
        }
    }

    /// `{1, 2}`, `{0="no", 1="yes"}` or `{"x", "y"}`; None if one of them is an expression.
    fn choices(&self, from: usize) -> Option<Vec<(Value, String)>> {
        let inner = self.bracketed(from)?;
        let choice = |piece: Range<usize>| {
            let equals = self.code[piece.clone()].find('=');
            let value = piece.start..equals.map_or(piece.end, |at| piece.start + at);
            let label = equals.map(|at| self.strings(piece.start + at..piece.end));
            let label = label.and_then(|label| label.first().map(|text| (*text).to_owned()));
            let value = self.default(value).value()?;
            Some((value, label.unwrap_or_default()))
        };
        self.split(inner, b',').map(choice).collect()
    }

    /// The line of a position, counted from 1.
    pub fn line(&self, at: usize) -> usize {
        1 + self.code[..at].matches('\n').count()
    }
}

fn nesting(byte: u8) -> i32 {
    match byte {
        b'[' | b'(' | b'{' => 1,
        b']' | b')' | b'}' => -1,
        _ => 0,
    }
}

pub(super) fn leading_blanks(text: &str) -> usize {
    text.len() - text.trim_start().len()
}

/// The number of bytes before `end`, or all.
fn until(bytes: &[u8], end: &[u8]) -> usize {
    let found = bytes.windows(end.len()).position(|window| window == end);
    found.unwrap_or(bytes.len())
}

/// The number of bytes before the closing quote, or all; a backslash hides the byte behind it.
fn until_quote(bytes: &[u8], quote: u8) -> usize {
    let mut at = 0;
    while at < bytes.len() && bytes[at] != quote {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    at.min(bytes.len())
}
