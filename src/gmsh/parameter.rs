//! A parameter of a `.geo`: its default, and what its attributes allow.
//!
//! `DefineConstant[ n = {4, Min 1, Max 9, Choices{1="one", 4="four"}, Name "Parameters/n"} ];` Gmsh's window
//! keeps to `Min`, `Max` and `Choices`, its command line does not; here they bind.

use std::path::PathBuf;

use super::Value;

/// The value that a parameter has unless it is set.
#[derive(Clone, Debug, PartialEq)]
pub enum Default {
    Number(f64),
    Text(String),
    /// An expression that only Gmsh can evaluate, as written.
    Expression(String),
    /// None is written.
    Absent,
}

impl Default {
    /// The value, if it can be read without running the script.
    pub fn value(&self) -> Option<Value> {
        match self {
            Default::Number(number) => Some(Value::Number(*number)),
            Default::Text(text) => Some(Value::Text(text.clone())),
            Default::Expression(_) | Default::Absent => None,
        }
    }
}

impl std::fmt::Display for Default {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Default::Number(number) => write!(f, "{number}"),
            Default::Text(text) => write!(f, "'{text}'"),
            Default::Expression(written) => f.write_str(written),
            Default::Absent => f.write_str("none"),
        }
    }
}

/// The values that a parameter may have, as far as its attributes give them in plain numbers and texts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Range {
    /// `Min`.
    pub lowest: Option<f64>,
    /// `Max`.
    pub highest: Option<f64>,
    /// `Choices`, each with its label, which may be empty.
    pub choices: Vec<(Value, String)>,
}

impl Range {
    /// The expectation that the value does not meet, if there is one.
    pub fn refuses(&self, value: &Value) -> Option<String> {
        let is_chosen = self.choices.is_empty() || self.choices.iter().any(|(v, _)| v == value);
        let is_within = match value {
            Value::Number(number) => {
                self.lowest.is_none_or(|low| low <= *number)
                    && self.highest.is_none_or(|high| *number <= high)
            }
            Value::Text(_) => true,
        };
        (!is_chosen || !is_within).then(|| self.to_string())
    }

    pub fn is_open(&self) -> bool {
        *self == Range::default()
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.choices.is_empty() {
            let choice = |(value, label): &(Value, String)| match label.as_str() {
                "" => value.to_string(),
                label => format!("{value} ({label})"),
            };
            let choices: Vec<String> = self.choices.iter().map(choice).collect();
            return f.write_str(&match choices.split_last() {
                Some((last, [])) => last.clone(),
                Some((last, others)) => format!("{} or {last}", others.join(", ")),
                None => String::new(),
            });
        }
        match (self.lowest, self.highest) {
            (Some(low), Some(high)) => write!(f, "from {low} to {high}"),
            (Some(low), None) => write!(f, "at least {low}"),
            (None, Some(high)) => write!(f, "at most {high}"),
            (None, None) => f.write_str("anything"),
        }
    }
}

/// A variable that can be set from outside, and where it is defined.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub default: Default,
    pub range: Range,
    /// Unit in brackets at the end of its `Name`.
    pub unit: Option<String>,
    pub file: PathBuf,
    /// Counted from 1.
    pub line: usize,
}

impl Parameter {
    /// The values that are allowed instead, if this one is not.
    pub fn refuses(&self, value: &Value) -> Option<String> {
        let fits = |expected: &str| Some(expected.to_owned());
        match (&self.default, value) {
            (_, Value::Number(number)) if !number.is_finite() => fits("finite"),
            (Default::Number(_), Value::Text(_)) => fits("a number"),
            (Default::Text(_), Value::Number(_)) => fits("a text"),
            _ => self.range.refuses(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_told_in_words_and_binds_its_ends() {
        let range = |lowest, highest| Range {
            lowest,
            highest,
            choices: Vec::new(),
        };
        let refusal = |range: &Range, number: f64| range.refuses(&number.into());
        let both = range(Some(1.0), Some(2.5));
        assert_eq!(refusal(&both, 1.0), None);
        assert_eq!(refusal(&both, 2.5), None);
        assert_eq!(refusal(&both, 2.6).as_deref(), Some("from 1 to 2.5"));
        assert_eq!(
            refusal(&range(Some(1.0), None), 0.0).as_deref(),
            Some("at least 1")
        );
        assert_eq!(
            refusal(&range(None, Some(1.0)), 2.0).as_deref(),
            Some("at most 1")
        );
        assert_eq!(refusal(&range(None, None), 1e300), None);
    }

    #[test]
    fn choices_are_listed_with_their_labels() {
        let range = Range {
            choices: vec![
                (1.0.into(), "linear".into()),
                (2.0.into(), String::new()),
                ("q".into(), String::new()),
            ],
            ..Range::default()
        };
        assert_eq!(range.refuses(&2.0.into()), None);
        assert_eq!(range.refuses(&"q".into()), None);
        assert_eq!(
            range.refuses(&3.0.into()).as_deref(),
            Some("1 (linear), 2 or 'q'")
        );
    }
}
