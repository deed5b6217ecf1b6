//! An observer that keeps the warnings, so that they stand in the results too.

use super::{Observer, Step};
use crate::pipeline::record::stamp::Stage;
use std::time::Duration;

pub(super) struct WarningLog<'a> {
    observer: &'a mut dyn Observer,
    /// Each warning once, in the order in which they came.
    pub warnings: Vec<String>,
}

impl WarningLog<'_> {
    pub(super) fn new(observer: &mut dyn Observer) -> WarningLog<'_> {
        WarningLog {
            observer,
            warnings: Vec::new(),
        }
    }

    /// The observer, to be told what does not belong into the results.
    pub(super) fn inner(&mut self) -> &mut dyn Observer {
        self.observer
    }

    /// Keeps warnings that have been told.
    pub(super) fn keeps(&mut self, warnings: Vec<String>) {
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }
}

impl Observer for WarningLog<'_> {
    fn starts(&mut self, stage: Stage) {
        self.observer.starts(stage);
    }

    fn ends(&mut self, stage: Stage, what: &str, time: Duration) {
        self.observer.ends(stage, what, time);
    }

    fn discretises(&mut self) {
        self.observer.discretises();
    }

    fn step(&mut self, step: &Step) {
        self.observer.step(step);
    }

    fn is_fresh(&mut self, stage: Stage) {
        self.observer.is_fresh(stage);
    }

    fn warns(&mut self, text: &str) {
        self.observer.warns(text);
        self.keeps(vec![text.to_owned()]);
    }
}
