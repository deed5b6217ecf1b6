//! The solve stage: one elastic solve, or a fracture run.

use super::{Observer, Run, SOLUTION_FILE};
use crate::boundary::Boundary;
use crate::model::Model;
use crate::output::write_whole;
use crate::phases::{collect, peak_memory};
use crate::pipeline::account::costs::Costs;
use crate::pipeline::account::summary::FilesSummary;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Loading;
use crate::pipeline::record::folder::{DRAFT_FOLDER, remove, remove_folder};
use crate::pipeline::record::frames::{encode, frame_file};
use crate::pipeline::record::solved::Solved;
use crate::pipeline::record::sparse_integrity::SparseIntegrity;
use crate::pipeline::record::stamp::{self, Recipe, Stage};
use crate::pipeline::record::stored::read_stored;
use crate::pipeline::record::writer::{HISTORY_FILE, WrittenRecord, forget_checkpoint};
use crate::pipeline::show::damage_picture::DAMAGE_PICTURE;
use crate::pipeline::stages::fracture::{self, Task};
use crate::statics::{self, Backend, Solution};
use crate::trace::Kind;
use std::time::Instant;

impl Run<'_> {
    pub(super) fn solve(&mut self, model: &Model, boundary: &Boundary) -> Result<Solved, RunError> {
        let path = self.plan.folder.join(SOLUTION_FILE);
        let recipe = self.recipe(Stage::Solve)?;
        if self.is_fresh(Stage::Solve, &recipe)
            && let Some((stored, bytes)) = read_stored::<Solved>(&path)
            && stored.fits(model)
        {
            self.kept.insert(SOLUTION_FILE, stamp::hash(&bytes));
            self.observer.is_fresh(Stage::Solve);
            self.restore(Stage::Solve);
            self.keep_warnings(&stored);
            return Ok(stored);
        }
        self.lock()?;
        self.observer.starts(Stage::Solve);
        let _span = self.options.trace.span(Kind::Stage, Stage::Solve.name());
        let start = Instant::now();
        let mut costs = Costs::default();
        let (solved, phases) = collect(&self.options.trace, || match &self.plan.loading {
            None => solve_once(model, boundary, self.options.resolution.backend()),
            Some(loading) => self.break_apart(loading, model, &recipe, &mut costs),
        });
        let solved = solved?;
        costs.phases = phases;
        costs.peak_memory = peak_memory();
        let mut files = vec![SOLUTION_FILE.to_owned()];
        if let Some(course) = &solved.fracture {
            files.push(HISTORY_FILE.to_owned());
            files.extend(course.frames.iter().map(|&step| frame_file(step)));
        }
        let obsolete = self.begin(Stage::Solve, &files)?;
        let bytes = encode(&solved);
        write_whole(&path, &bytes)?;
        self.kept.insert(SOLUTION_FILE, stamp::hash(&bytes));
        for file in &obsolete {
            remove(&self.plan.folder.join(file))?;
        }
        costs.phases.complete(start.elapsed());
        self.finish(Stage::Solve, recipe, &files, &costs)?;
        forget_checkpoint(&self.plan.folder)?;
        self.costs.append(costs);
        let what = describe(model, &solved);
        self.observer.ends(Stage::Solve, &what, start.elapsed());
        Ok(solved)
    }

    fn keep_warnings(&mut self, solved: &Solved) {
        let course = solved.fracture.iter();
        let warnings = course.flat_map(|course| course.warnings.clone());
        self.observer.keeps(warnings.collect());
    }

    fn break_apart(
        &mut self,
        loading: &Loading,
        model: &Model,
        recipe: &Recipe,
        costs: &mut Costs,
    ) -> Result<Solved, RunError> {
        let folder = &self.plan.folder;
        if self.options.force {
            forget_checkpoint(folder)?;
        }
        // From here on the stage is unfinished; `clean` knows what it writes along the way. The picture
        // is not among its results, and goes when they are whole.
        let along_the_way = [HISTORY_FILE, DAMAGE_PICTURE].map(str::to_owned);
        self.begin(Stage::Solve, &along_the_way)?;
        // A killed run may have left one, which no later output stage would come upon.
        remove_folder(&folder.join(DRAFT_FOLDER))?;
        let recipe = serde_json::to_string(recipe).expect("a recipe is plain data");
        let task = Task {
            plan: self.plan,
            loading,
            model,
            recipe: &recipe,
            resolution: self.options.resolution,
            trace: &self.options.trace,
        };
        let (solved, WrittenRecord { frames, phases }) =
            fracture::run(&task, self.observer.inner())?;
        self.keep_warnings(&solved);
        costs.behind = phases;
        costs.frames = Some(FilesSummary::new(&frames, ""));
        Ok(solved)
    }
}

fn solve_once(
    model: &Model,
    boundary: &Boundary,
    backend: Option<Backend>,
) -> Result<Solved, RunError> {
    let solution = statics::solve_by(model, boundary, backend)?;
    Ok(Solved {
        solution,
        integrity: SparseIntegrity::new(&model.integrity),
        fracture: None,
    })
}

/// The solve stage in one line.
fn describe(model: &Model, solved: &Solved) -> String {
    let Solution { size, residual, .. } = &solved.solution;
    let (ties, what) = model.ties();
    let size = format!(
        "{} unknowns, {} bonds, {ties} {what}",
        size.dofs,
        model.interactions.bonds().len()
    );
    match &solved.fracture {
        None => format!("{size}; residual {residual:.0e}"),
        Some(course) => {
            let last = course.history.last();
            let broken = last.map_or(0, |line| line.bonds_broken_total);
            format!(
                "{size}; {} steps, {broken} bonds broken",
                course.history.len()
            )
        }
    }
}
