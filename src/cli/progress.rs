//! A run while it goes: for a person, a line per stage and the step that it is at; for a program, a line of
//! JSON per event.

use super::with_causes;
use crate::pipeline::account::summary::Summary;
use crate::pipeline::error::RunError;
use crate::pipeline::record::stamp::Stage;
use crate::pipeline::stages::run::{Observer, Step};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::IsTerminal;
use std::time::Duration;

/// A line per stage on standard error; a spinner while it runs, where a person watches.
pub(super) struct Progress {
    name: String,
    spinner: ProgressBar,
}

impl Progress {
    pub(super) fn new(name: &str) -> Progress {
        let spinner = if std::io::stderr().is_terminal() {
            ProgressBar::new_spinner()
        } else {
            ProgressBar::hidden()
        };
        let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}");
        spinner.set_style(style.expect("the template is well formed"));
        Progress {
            name: name.to_owned(),
            spinner,
        }
    }

    pub(super) fn clear(&self) {
        self.spinner.finish_and_clear();
    }

    fn line(&self, text: &str) {
        self.spinner.suspend(|| eprintln!("{}: {text}", self.name));
    }
}

impl Observer for Progress {
    fn starts(&mut self, stage: Stage) {
        self.spinner.reset_elapsed();
        self.spinner.set_message(format!("{}: {stage}", self.name));
        self.spinner.enable_steady_tick(Duration::from_millis(100));
    }

    fn ends(&mut self, stage: Stage, what: &str, time: Duration) {
        self.line(&format!(
            "{stage:<6}  {:>7.2} s  {what}",
            time.as_secs_f64()
        ));
    }

    fn discretises(&mut self) {
        self.spinner.reset_elapsed();
        self.spinner
            .set_message(format!("{}: discretisation", self.name));
        self.spinner.enable_steady_tick(Duration::from_millis(100));
    }

    fn step(&mut self, step: &Step) {
        self.spinner.set_message(format!("{}: {step}", self.name));
    }

    fn is_fresh(&mut self, stage: Stage) {
        self.line(&format!("{stage:<6}    fresh"));
    }

    fn warns(&mut self, text: &str) {
        self.line(&format!("warning: {text}"));
    }
}

/// The warnings of a run and nothing else, on standard error.
pub(super) struct Warnings {
    name: String,
}

impl Warnings {
    pub(super) fn new(name: &str) -> Warnings {
        Warnings {
            name: name.to_owned(),
        }
    }
}

impl Observer for Warnings {
    fn starts(&mut self, _: Stage) {}
    fn discretises(&mut self) {}
    fn ends(&mut self, _: Stage, _: &str, _: Duration) {}
    fn step(&mut self, _: &Step) {}
    fn is_fresh(&mut self, _: Stage) {}

    fn warns(&mut self, text: &str) {
        eprintln!("{}: warning: {text}", self.name);
    }
}

/// A line of JSON per event on standard output: `run --json`.
pub(super) struct JsonLines {
    pipeline: String,
}

impl JsonLines {
    pub(super) fn new(pipeline: &str) -> JsonLines {
        JsonLines {
            pipeline: pipeline.to_owned(),
        }
    }

    fn line(&self, event: &str, more: Value) {
        let mut line = json!({ "event": event, "pipeline": self.pipeline });
        if let (Some(line), Value::Object(more)) = (line.as_object_mut(), more) {
            line.extend(more);
        }
        print_line(&line);
    }

    /// The end: what `summary.json` holds, or null where the run ends before its output stage.
    pub(super) fn done(&self, summary: Option<&Summary>) {
        self.line("done", json!({ "summary": summary }));
    }
}

/// An error as a line of JSON.
pub(super) fn print_error(error: &RunError, code: u8) {
    let (help, place) = match error {
        RunError::Input(error) => (error.help.clone(), error.place()),
        failure => (failure.help(), None),
    };
    print_line(&json!({
        "event": "error",
        "code": code,
        "message": with_causes(error),
        "help": help,
        "file": place.map(|(file, _)| file),
        "line": place.map(|(_, line)| line),
    }));
}

/// A reader that has gone away is no reason to end the run.
fn print_line(line: &Value) {
    println!("{line}");
}

impl Observer for JsonLines {
    fn starts(&mut self, stage: Stage) {
        self.line("starts", json!({ "stage": stage.name() }));
    }

    fn discretises(&mut self) {}

    fn ends(&mut self, stage: Stage, what: &str, time: Duration) {
        let seconds = time.as_secs_f64();
        self.line(
            "ends",
            json!({ "stage": stage.name(), "seconds": seconds, "what": what }),
        );
    }

    fn step(&mut self, step: &Step) {
        self.line(
            "step",
            serde_json::to_value(step).expect("a step is plain data"),
        );
    }

    fn is_fresh(&mut self, stage: Stage) {
        self.line("fresh", json!({ "stage": stage.name() }));
    }

    fn warns(&mut self, text: &str) {
        self.line("warning", json!({ "text": text }));
    }
}
