//! Runs the stages that are stale: mesh → solve → output. Bad input is found before anything is
//! written; what is written appears under its name only when it is whole.

mod observer;
mod warnings;

use super::fracture::{self, Task};
use super::meshing::{mesh_geometry, to_mesh};
use super::recipe::recipe;
use super::validate::discretise;
use crate::boundary::Boundary;
use crate::fracture::control::Resolution;
use crate::gmsh::{self, Extract};
use crate::meshio::{self};
use crate::model::Model;
use crate::output::write_whole;
use crate::phases::{Phases, peak_memory};
use crate::pipeline::account::costs::{Costs, StoredCosts};
use crate::pipeline::account::summary::{FilesSummary, SUMMARY_FILE, Summary, read_summary};
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::{Loading, Plan};
use crate::pipeline::record::folder::{
    DRAFT_FOLDER, draft, file_error, hash_of, lock, remove, remove_folder, settled, sweep,
};
use crate::pipeline::record::frames::encode;
use crate::pipeline::record::frames::frame_file;
use crate::pipeline::record::solved::Solved;
use crate::pipeline::record::sparse_integrity::SparseIntegrity;
use crate::pipeline::record::stamp::{self, Manifest, Reasons, Recipe, Stage};
use crate::pipeline::record::stored::read_stored;
use crate::pipeline::record::writer::forget_checkpoint;
use crate::pipeline::record::writer::{HISTORY_FILE, WrittenRecord};
use crate::pipeline::show::damage_picture::DAMAGE_PICTURE;
use crate::pipeline::show::report::REPORT_FILE;
use crate::pipeline::show::results::Outcome;
use crate::statics::{self, Backend, Solution};
use crate::trace::{Kind, Trace};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::time::Instant;

pub use observer::{Observer, Step};

/// What to run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The last stage to run.
    pub until: Stage,
    /// Run every stage, stale or not.
    pub force: bool,
    /// How a fracture run finds its responses.
    pub resolution: Resolution,
    pub gmsh: gmsh::Options,
    pub meshio: meshio::Options,
    /// Collects what the profile shows.
    pub trace: Trace,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            until: Stage::Output,
            force: false,
            resolution: Resolution::default(),
            gmsh: gmsh::Options::default(),
            meshio: meshio::Options::default(),
            trace: Trace::default(),
        }
    }
}

pub(crate) const MESH_FILE: &str = "mesh.bin";
pub(crate) const SOLUTION_FILE: &str = "solution.bin";

/// How a stage's result stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    Fresh,
    Stale(Reasons),
    /// Stale if this earlier stage, which must run, delivers something new.
    After(Stage),
}

/// How the stages stand, without running or writing anything.
///
/// # Errors
/// An unreadable geometry.
pub fn standings(plan: &Plan) -> Result<Vec<(Stage, Standing)>, RunError> {
    let on_disk = |name: &str| {
        let hash = stamp::hash_file(&plan.folder.join(name));
        hash.unwrap_or_else(|| "missing".to_owned())
    };
    let mut list: Vec<(Stage, Standing)> = Vec::new();
    for stage in Stage::ALL {
        let upstream = list
            .iter()
            .find(|(_, standing)| *standing != Standing::Fresh);
        let upstream = upstream.map(|(earlier, _)| *earlier);
        let mut recipe = recipe(plan, stage, &on_disk)?;
        if upstream.is_some() {
            // What it will deliver is not known; all else is.
            recipe.assume_inputs_of(stamp::read(&plan.folder, stage));
        }
        let reasons = stamp::stale(&plan.folder, stage, &recipe);
        let standing = match (reasons.is_empty(), upstream) {
            (false, _) => Standing::Stale(reasons),
            (true, None) => Standing::Fresh,
            (true, Some(earlier)) => Standing::After(earlier),
        };
        list.push((stage, standing));
    }
    Ok(list)
}

/// Runs what is stale and returns the summary, or `None` if the run ends before the output stage.
///
/// # Errors
/// See [`RunError`].
pub fn run(
    plan: &Plan,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Option<Summary>, RunError> {
    let _span = options.trace.span(Kind::Run, plan.name.clone());
    let mut run = Run {
        plan,
        options,
        observer,
        costs: Costs::default(),
        kept: BTreeMap::new(),
        lock: None,
    };
    sweep(&plan.folder)?;
    let mesh = run.mesh()?;
    if options.until == Stage::Output
        && let Some(summary) = run.all_fresh(&mesh)?
    {
        return Ok(Some(summary));
    }
    let (model, boundary) = run.discretise(&mesh)?;
    run.keep_mesh(&mesh)?;
    if options.until == Stage::Mesh {
        return Ok(None);
    }
    let solved = run.solve(&model, &boundary)?;
    if options.until == Stage::Solve {
        return Ok(None);
    }
    let outcome = Outcome {
        plan,
        model: &model,
        boundary: &boundary,
        solved: &solved,
        extract: &mesh.extract,
    };
    run.output(&outcome).map(Some)
}

/// The geometry, meshed unless a fresh mesh is there, and checked, without writing anything.
///
/// # Errors
/// See [`RunError`].
pub fn discretised(plan: &Plan, options: &Options) -> Result<(Model, Boundary, Extract), RunError> {
    let extract = match stored_mesh(plan)? {
        Some(extract) => extract,
        None => mesh_geometry(plan, options)?,
    };
    let (model, boundary) = discretise(plan, to_mesh(plan, &extract)?)?;
    Ok((model, boundary, extract))
}

/// What the mesh stage has kept, if it is fresh.
fn stored_mesh(plan: &Plan) -> Result<Option<Extract>, RunError> {
    let recipe = recipe(plan, Stage::Mesh, &|_| String::new())?;
    let is_fresh = stamp::stale(&plan.folder, Stage::Mesh, &recipe).is_empty();
    let stored = is_fresh.then(|| read_stored(&plan.folder.join(MESH_FILE)));
    Ok(stored.flatten().map(|(extract, _)| extract))
}

/// The mesh stage's result.
struct Meshed {
    extract: Extract,
    bytes: Vec<u8>,
    recipe: Recipe,
    /// Made in this run, and not yet kept.
    is_new: bool,
    phases: Phases,
}

struct Run<'a> {
    plan: &'a Plan,
    options: &'a Options,
    observer: &'a mut dyn Observer,
    /// Of all stages so far, those included that an earlier run has done.
    costs: Costs,
    /// Hashes of what the stages of this run have delivered, on disk now or soon.
    kept: BTreeMap<&'static str, String>,
    lock: Option<File>,
}

impl Run<'_> {
    fn recipe(&self, stage: Stage) -> Result<Recipe, RunError> {
        recipe(self.plan, stage, &|name| self.kept[name].clone())
    }

    fn is_fresh(&self, stage: Stage, recipe: &Recipe) -> bool {
        !self.options.force && stamp::stale(&self.plan.folder, stage, recipe).is_empty()
    }

    /// The recipe is written down before Gmsh reads the geometry: an edit in the meantime is then
    /// noticed by the next run.
    fn mesh(&mut self) -> Result<Meshed, RunError> {
        let recipe = self.recipe(Stage::Mesh)?;
        if self.is_fresh(Stage::Mesh, &recipe)
            && let Some((extract, bytes)) = read_stored(&self.plan.folder.join(MESH_FILE))
        {
            self.kept.insert(MESH_FILE, stamp::hash(&bytes));
            self.restore(Stage::Mesh);
            return Ok(Meshed {
                extract,
                bytes,
                recipe,
                is_new: false,
                phases: Phases::default(),
            });
        }
        self.observer.starts(Stage::Mesh);
        let _span = self.options.trace.span(Kind::Stage, Stage::Mesh.name());
        let mut phases = self.phases();
        let program = match meshio::reads(&self.plan.geometry.file) {
            true => "meshio",
            false => "gmsh",
        };
        let extract = phases.measure(program, || mesh_geometry(self.plan, self.options))?;
        for warning in &extract.warnings {
            let program = &extract.origin.program;
            self.observer.warns(&format!("{program}: {warning}"));
        }
        let bytes = encode(&extract);
        self.kept.insert(MESH_FILE, stamp::hash(&bytes));
        self.costs.phases.append(phases.list.clone());
        Ok(Meshed {
            extract,
            bytes,
            recipe,
            is_new: true,
            phases,
        })
    }

    /// The summary, if there is nothing to do.
    fn all_fresh(&mut self, mesh: &Meshed) -> Result<Option<Summary>, RunError> {
        let solution = self.plan.folder.join(SOLUTION_FILE);
        if mesh.is_new || !self.is_fresh(Stage::Solve, &self.recipe(Stage::Solve)?) {
            return Ok(None);
        }
        self.kept.insert(SOLUTION_FILE, hash_of(&solution)?);
        if !self.is_fresh(Stage::Output, &self.recipe(Stage::Output)?) {
            return Ok(None);
        }
        Stage::ALL
            .into_iter()
            .for_each(|stage| self.observer.is_fresh(stage));
        Ok(read_summary(&self.plan.folder))
    }

    fn discretise(&mut self, mesh: &Meshed) -> Result<(Model, Boundary), RunError> {
        let mut phases = self.phases();
        let (model, boundary) = phases.measure("discretisation", || {
            Ok::<_, RunError>(discretise(self.plan, to_mesh(self.plan, &mesh.extract)?)?)
        })?;
        self.costs.phases.append(phases.list);
        self.warn_of_areas(&model);
        self.warn_of_narrow_regions(&model);
        Ok((model, boundary))
    }

    fn keep_mesh(&mut self, mesh: &Meshed) -> Result<(), RunError> {
        if !mesh.is_new {
            self.observer.is_fresh(Stage::Mesh);
            return Ok(());
        }
        self.lock()?;
        self.begin(Stage::Mesh, &[MESH_FILE.to_owned()])?;
        write_whole(&self.plan.folder.join(MESH_FILE), &mesh.bytes)?;
        let costs = Costs {
            phases: mesh.phases.clone(),
            ..Costs::default()
        };
        self.finish(
            Stage::Mesh,
            mesh.recipe.clone(),
            &[MESH_FILE.to_owned()],
            &costs,
        )?;
        let what = format!(
            "{}: {} nodes, {} groups",
            mesh.extract.origin,
            mesh.extract.nodes.len(),
            mesh.extract.groups.len()
        );
        self.observer.ends(Stage::Mesh, &what, mesh.phases.total());
        Ok(())
    }

    fn solve(&mut self, model: &Model, boundary: &Boundary) -> Result<Solved, RunError> {
        let path = self.plan.folder.join(SOLUTION_FILE);
        let recipe = self.recipe(Stage::Solve)?;
        if self.is_fresh(Stage::Solve, &recipe)
            && let Some((stored, bytes)) = read_stored::<Solved>(&path)
            && stored.fits(model)
        {
            self.kept.insert(SOLUTION_FILE, stamp::hash(&bytes));
            self.observer.is_fresh(Stage::Solve);
            self.restore(Stage::Solve);
            return Ok(stored);
        }
        self.lock()?;
        self.observer.starts(Stage::Solve);
        let _span = self.options.trace.span(Kind::Stage, Stage::Solve.name());
        let start = Instant::now();
        let mut costs = Costs {
            phases: self.phases(),
            ..Costs::default()
        };
        let solved = match &self.plan.loading {
            None => {
                let backend = self.options.resolution.backend();
                solve_once(model, boundary, backend, &mut costs.phases)?
            }
            Some(loading) => self.break_apart(loading, model, &recipe, &mut costs)?,
        };
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
        };
        let (solved, WrittenRecord { frames, phases }) =
            fracture::run(&task, self.observer, &mut costs.phases)?;
        costs.behind = phases;
        costs.frames = Some(FilesSummary::new(&frames, ""));
        Ok(solved)
    }

    /// What a stage took when it was done.
    fn restore(&mut self, stage: Stage) {
        if let Some(manifest) = stamp::read(&self.plan.folder, stage) {
            self.costs.append(manifest.costs.into());
        }
    }

    fn phases(&self) -> Phases {
        Phases::traced(self.options.trace.clone())
    }

    fn output(&mut self, outcome: &Outcome) -> Result<Summary, RunError> {
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
        let mut costs = Costs {
            phases: self.phases(),
            ..Costs::default()
        };
        let (made, animation) = outcome.write(draft.path(), &mut costs.phases)?;

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
        let summary = outcome.summary(files.clone(), &self.costs);
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
        if let Some(missing) = outcome.missing_pictures() {
            self.observer.warns(&missing);
        }
        let what = format!("{} files in {}", files.len(), folder.display());
        self.observer.ends(Stage::Output, &what, start.elapsed());
        Ok(summary)
    }

    /// Keeps other runs out of the results folder from the first write on.
    fn lock(&mut self) -> Result<(), RunError> {
        if self.lock.is_none() {
            self.lock = Some(lock(&self.plan.folder)?);
        }
        Ok(())
    }

    /// From here to [`Run::finish`] the manifest says that the stage is unfinished, so that a killed
    /// run leaves it stale. Returns the files of the last time that will not be written again.
    fn begin(&self, stage: Stage, files: &[String]) -> Result<Vec<String>, RunError> {
        let folder = &self.plan.folder;
        let old = stamp::read(folder, stage)
            .map(|manifest| manifest.outputs)
            .unwrap_or_default();
        let obsolete = old
            .keys()
            .filter(|name| !files.contains(name))
            .cloned()
            .collect();
        let mut outputs = old;
        outputs.extend(files.iter().map(|name| (name.clone(), String::new())));
        stamp::write(
            folder,
            stage,
            &Manifest {
                recipe: None,
                outputs,
                costs: StoredCosts::default(),
            },
        )?;
        Ok(obsolete)
    }

    fn finish(
        &self,
        stage: Stage,
        recipe: Recipe,
        files: &[String],
        costs: &Costs,
    ) -> Result<(), RunError> {
        let folder = &self.plan.folder;
        let settle = |name: &String| Ok((name.clone(), settled(&folder.join(name))?));
        let outputs = files.par_iter().map(settle);
        let outputs: BTreeMap<String, String> = outputs.collect::<Result<_, RunError>>()?;
        Ok(stamp::write(
            folder,
            stage,
            &Manifest {
                recipe: Some(recipe),
                outputs,
                costs: costs.into(),
            },
        )?)
    }
}

fn solve_once(
    model: &Model,
    boundary: &Boundary,
    backend: Option<Backend>,
    phases: &mut Phases,
) -> Result<Solved, RunError> {
    let solution = statics::solve_by(model, boundary, backend, phases)?;
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
