//! Runs the stages that are stale: mesh → solve → output. Bad input is found before anything is
//! written; what is written appears under its name only when it is whole.

mod mesh;
mod mesh_warnings;
mod observer;
mod output;
mod solve;
mod warning_log;

use crate::boundary::Boundary;
use crate::fracture::control::Resolution;
use crate::gmsh::{self, Extract};
use crate::meshio;
use crate::model::Model;
use crate::phases::{collect, measure};
use crate::pipeline::account::costs::Costs;
use crate::pipeline::account::summary::{Summary, read_summary};
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::{NOTHING_LOADS, Plan};
use crate::pipeline::record::folder::{hash_of, lock, settled, sweep};
use crate::pipeline::record::stamp::{self, Manifest, Recipe, Stage};
use crate::pipeline::record::stored::read_stored;
use crate::pipeline::show::results::Outcome;
use crate::pipeline::stages::joints::unjoined;
use crate::pipeline::stages::meshing::{mesh_geometry, to_mesh};
use crate::pipeline::stages::notes::notes;
use crate::pipeline::stages::recipe::recipe;
use crate::pipeline::stages::validate::discretise;
use crate::trace::{Kind, Trace};
use mesh::Meshed;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::time::{Duration, Instant};
use warning_log::WarningLog;

pub use observer::{Observer, Step};

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The last stage to run.
    pub until: Stage,
    /// Run every stage, stale or not.
    pub force: bool,
    /// Method by which a fracture run finds its responses.
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
    let mut run = Run::new(plan, options, observer);
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

/// The geometry, meshed unless a fresh mesh is there, and checked. A mesh that was made is kept for the run.
///
/// # Errors
/// See [`RunError`].
pub fn check(
    plan: &Plan,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Checked, RunError> {
    let mut run = Run::new(plan, options, observer);
    let mesh = run.mesh()?;
    let start = Instant::now();
    let (model, boundary) = run.discretise(&mesh)?;
    let set_up = start.elapsed();
    if let Err(error) = run.keep_mesh(&mesh) {
        let warning = format!("the mesh is not kept for the run: {error}");
        run.observer.warns(&warning);
    }
    Ok(Checked {
        model,
        boundary,
        extract: mesh.extract,
        set_up,
    })
}

/// A pipeline that is sound.
pub struct Checked {
    pub model: Model,
    pub boundary: Boundary,
    pub extract: Extract,
    /// Time that its discretisation has taken, and takes in every run.
    pub set_up: Duration,
}

/// The mesh that the mesh stage has kept, if it is fresh.
fn stored_mesh(plan: &Plan) -> Result<Option<Extract>, RunError> {
    let recipe = recipe(plan, Stage::Mesh, &|_| String::new())?;
    let is_fresh = stamp::stale(&plan.folder, Stage::Mesh, &recipe).is_empty();
    let stored = is_fresh.then(|| read_stored(&plan.folder.join(MESH_FILE)));
    Ok(stored.flatten().map(|(extract, _)| extract))
}

struct Run<'a> {
    plan: &'a Plan,
    options: &'a Options,
    observer: WarningLog<'a>,
    /// Costs of all stages so far, those included that an earlier run has done.
    costs: Costs,
    /// Hashes of what the stages of this run have delivered, on disk now or soon.
    kept: BTreeMap<&'static str, String>,
    lock: Option<File>,
}

impl<'a> Run<'a> {
    fn new(plan: &'a Plan, options: &'a Options, observer: &'a mut dyn Observer) -> Run<'a> {
        Run {
            plan,
            options,
            observer: WarningLog::new(observer),
            costs: Costs::default(),
            kept: BTreeMap::new(),
            lock: None,
        }
    }

    fn recipe(&self, stage: Stage) -> Result<Recipe, RunError> {
        recipe(self.plan, stage, &|name| self.kept[name].clone())
    }

    fn is_fresh(&self, stage: Stage, recipe: &Recipe) -> bool {
        !self.options.force && stamp::stale(&self.plan.folder, stage, recipe).is_empty()
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
        self.warn_of_mesh(&mesh.extract);
        self.observer.discretises();
        let (discretised, phases) = collect(&self.options.trace, || {
            measure("discretisation", || {
                let mesh = to_mesh(self.plan, &mesh.extract)?;
                let (model, boundary) = discretise(self.plan, mesh)?;
                let mut sentences = unjoined(self.plan, &model);
                sentences.extend(notes(self.plan, &model, &boundary));
                Ok::<_, RunError>((model, boundary, sentences))
            })
        });
        let (model, boundary, sentences) = discretised?;
        self.costs.phases.append(phases.list);
        if self.plan.loads_nothing() {
            self.observer.warns(NOTHING_LOADS);
        }
        for sentence in sentences {
            self.observer.warns(&sentence);
        }
        Ok((model, boundary))
    }

    /// Adds the costs that a fresh stage had when it ran.
    fn restore(&mut self, stage: Stage) {
        if let Some(manifest) = stamp::read(&self.plan.folder, stage) {
            self.costs.append(manifest.costs);
        }
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
                costs: Costs::default(),
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
                costs: costs.clone(),
            },
        )?)
    }
}
