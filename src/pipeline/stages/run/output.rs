//! The output stage: files are written into a draft folder and moved when all are there.

use super::{Observer, Run};
use crate::output::write_whole;
use crate::phases::{collect, peak_memory};
use crate::pipeline::account::costs::Costs;
use crate::pipeline::account::summary::{SUMMARY_FILE, Summary, read_summary};
use crate::pipeline::error::RunError;
use crate::pipeline::record::folder::{draft, file_error, remove};
use crate::pipeline::record::stamp::Stage;
use crate::pipeline::show::report::REPORT_FILE;
use crate::pipeline::show::results::Outcome;
use crate::trace::Kind;
use std::fs::{self};
use std::time::Instant;

impl Run<'_> {
    pub(super) fn output(&mut self, outcome: &Outcome) -> Result<Summary, RunError> {
        let recipe = self.recipe(Stage::Output)?;
        if self.is_fresh(Stage::Output, &recipe)
            && let Some(summary) = read_summary(&self.plan.folder)
        {
            self.observer.is_fresh(Stage::Output);
            return Ok(summary);
        }
        self.observer.starts(Stage::Output);
        let _span = self.options.trace.span(Kind::Stage, Stage::Output.name());
        let start = Instant::now();
        self.lock()?;
        let folder = &self.plan.folder;
        // A draft in the folder and a manifest that calls all finished must not meet.
        self.begin(Stage::Output, &[])?;
        let draft = draft(folder)?;
        let trace = &self.options.trace;
        let (written, phases) = collect(trace, || outcome.write(draft.path(), trace));
        let (made, animation) = written?;
        let mut costs = Costs {
            phases,
            ..Costs::default()
        };
        costs.phases.complete(start.elapsed());
        costs.peak_memory = peak_memory();
        costs.made = made;
        self.costs.append(costs);
        let made = self.costs.made.iter();
        let mut files: Vec<String> = made.map(|made| made.name.clone()).collect();
        if self.plan.output.is_reported() {
            files.push(REPORT_FILE.to_owned());
        }
        files.push(SUMMARY_FILE.to_owned());
        let missing = outcome.missing_pictures();
        let mut summary = outcome.summary(files.clone(), &self.costs);
        summary.warnings.clone_from(&self.observer.warnings);
        summary.warnings.extend(missing.clone());
        let text = serde_json::to_string_pretty(&summary).expect("a summary is plain data") + "\n";
        write_whole(&draft.path().join(SUMMARY_FILE), text.as_bytes())?;
        if self.plan.output.is_reported() {
            outcome.report(draft.path(), &self.costs.made, animation.as_ref(), &summary)?;
        }
        let obsolete = self.begin(Stage::Output, &files)?;
        for file in &files {
            fs::rename(draft.path().join(file), folder.join(file))
                .map_err(|source| file_error("write", &folder.join(file), source))?;
        }
        for file in &obsolete {
            remove(&folder.join(file))?;
        }
        self.finish(Stage::Output, recipe, &files, &Costs::default())?;
        if let Some(missing) = missing {
            self.observer.warns(&missing);
        }
        let what = format!("{} files in {}", files.len(), folder.display());
        self.observer.ends(Stage::Output, &what, start.elapsed());
        Ok(summary)
    }
}
