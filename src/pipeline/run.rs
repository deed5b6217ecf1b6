//! Runs the stages that are stale: mesh → solve → output. Bad input is found before anything is
//! written; what is written appears under its name only when it is whole.

use super::plan::Plan;
use super::quantity;
use super::results::{Outcome, ResultsError};
use super::source::InputError;
use super::spec::Spec;
use super::stamp::{self, Manifest, Reasons, Recipe, Stage};
use super::validate::discretise;
use crate::boundary::Boundary;
use crate::gmsh::{self, Extract, GeoScript, GmshError};
use crate::model::Model;
use crate::output::{WriteError, write_whole};
use crate::phases::{Phase, Phases, peak_memory};
use crate::statics::{self, Solution, StaticsError, SystemSize};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use thiserror::Error;

/// Why a run ended early.
#[derive(Debug, Error)]
pub enum RunError {
    /// Exit code 2.
    #[error(transparent)]
    Input(Box<InputError>),
    /// Exit code 1, like all that follow.
    #[error(transparent)]
    Gmsh(Box<GmshError>),
    #[error(transparent)]
    Statics(#[from] StaticsError),
    #[error(transparent)]
    Results(#[from] ResultsError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot {action} {}: {source}", .path.display())]
    File {
        action: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    #[error("another run is writing to {}", .folder.display())]
    Busy { folder: PathBuf },
}

impl From<InputError> for RunError {
    fn from(error: InputError) -> RunError {
        RunError::Input(Box::new(error))
    }
}

/// What to run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The last stage to run.
    pub until: Stage,
    /// Run every stage, stale or not.
    pub force: bool,
    pub gmsh: gmsh::Options,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            until: Stage::Output,
            force: false,
            gmsh: gmsh::Options::default(),
        }
    }
}

/// Told of what happens while it happens.
pub trait Observer {
    fn starts(&mut self, stage: Stage);
    fn ends(&mut self, stage: Stage, what: &str, time: Duration);
    fn is_fresh(&mut self, stage: Stage);
    fn warns(&mut self, text: &str);
}

const MESH_FILE: &str = "mesh.bin";
const SOLUTION_FILE: &str = "solution.bin";
pub const SUMMARY_FILE: &str = "summary.json";

/// The solve stage's result, as it is kept.
#[derive(Serialize, Deserialize)]
struct StoredSolution {
    displacement: Vec<[f64; 2]>,
    reaction: Vec<[f64; 2]>,
    residual: f64,
    size: [usize; 3],
    phases: Vec<(String, f64)>,
}

/// Which stages are stale, and why, without running or writing anything. Behind a stale stage the
/// others are stale for that reason alone, since what it will deliver is not known.
///
/// # Errors
/// An unreadable geometry.
pub fn staleness(plan: &Plan) -> Result<Vec<(Stage, Reasons)>, RunError> {
    let mut list: Vec<(Stage, Reasons)> = Vec::new();
    for stage in Stage::ALL {
        let upstream = list
            .iter()
            .find(|(_, reasons)| !reasons.is_empty())
            .map(|(stage, _)| *stage);
        let reasons = match upstream {
            Some(earlier) => vec![format!("{earlier} is stale")],
            None => stamp::stale(&plan.folder, stage, &recipe(plan, stage)?),
        };
        list.push((stage, reasons));
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
) -> Result<Option<Value>, RunError> {
    let mut run = Run {
        plan,
        options,
        observer,
        phases: Phases::default(),
        lock: None,
    };
    let mesh = run.mesh()?;
    let model = |mesh: &Extract| -> Result<(Model, Boundary), RunError> {
        Ok(discretise(plan, to_mesh(plan, mesh)?)?)
    };
    let downstream_fresh =
        !mesh.is_new && run.is_fresh(Stage::Solve)? && run.is_fresh(Stage::Output)?;
    if downstream_fresh && options.until == Stage::Output {
        Stage::ALL
            .into_iter()
            .for_each(|stage| run.observer.is_fresh(stage));
        return Ok(read_summary(&plan.folder));
    }
    let start = std::time::Instant::now();
    let (model, boundary) = model(&mesh.extract)?;
    run.phases.list.push(Phase {
        name: "discretisation",
        time: start.elapsed(),
    });
    run.warn_of_areas(&model);
    run.keep_mesh(&mesh)?;
    if options.until == Stage::Mesh {
        return Ok(None);
    }
    let solution = run.solve(&model, &boundary)?;
    if options.until == Stage::Solve {
        return Ok(None);
    }
    let outcome = Outcome {
        plan,
        model: &model,
        boundary: &boundary,
        solution: &solution,
        gmsh_version: &mesh.extract.gmsh_version,
    };
    run.output(&outcome).map(Some)
}

/// The geometry, meshed and checked, without writing anything: for `check`.
///
/// # Errors
/// See [`RunError`].
pub fn discretised(plan: &Plan, options: &Options) -> Result<(Model, Boundary, Extract), RunError> {
    let extract = mesh_geometry(plan, options)?;
    let (model, boundary) = discretise(plan, to_mesh(plan, &extract)?)?;
    Ok((model, boundary, extract))
}

/// The mesh stage's result.
struct Meshed {
    extract: Extract,
    bytes: Vec<u8>,
    /// Made in this run, and not yet kept.
    is_new: bool,
    time: Duration,
}

struct Run<'a> {
    plan: &'a Plan,
    options: &'a Options,
    observer: &'a mut dyn Observer,
    phases: Phases,
    lock: Option<File>,
}

impl Run<'_> {
    fn is_fresh(&self, stage: Stage) -> Result<bool, RunError> {
        if self.options.force {
            return Ok(false);
        }
        Ok(stamp::stale(&self.plan.folder, stage, &recipe(self.plan, stage)?).is_empty())
    }

    fn mesh(&mut self) -> Result<Meshed, RunError> {
        if self.is_fresh(Stage::Mesh)?
            && let Some((extract, bytes)) = read_stored(&self.plan.folder.join(MESH_FILE))
        {
            return Ok(Meshed {
                extract,
                bytes,
                is_new: false,
                time: Duration::ZERO,
            });
        }
        self.observer.starts(Stage::Mesh);
        let start = std::time::Instant::now();
        let extract = mesh_geometry(self.plan, self.options)?;
        extract
            .warnings
            .iter()
            .for_each(|warning| self.observer.warns(&format!("Gmsh: {warning}")));
        let bytes = encode(&extract);
        let time = start.elapsed();
        self.phases.list.push(Phase { name: "gmsh", time });
        Ok(Meshed {
            extract,
            bytes,
            is_new: true,
            time,
        })
    }

    fn keep_mesh(&mut self, mesh: &Meshed) -> Result<(), RunError> {
        if !mesh.is_new {
            self.observer.is_fresh(Stage::Mesh);
            return Ok(());
        }
        self.lock()?;
        self.begin(Stage::Mesh)?;
        write_whole(&self.plan.folder.join(MESH_FILE), &mesh.bytes)?;
        self.finish(Stage::Mesh, &[MESH_FILE.to_owned()])?;
        let what = format!(
            "Gmsh {}: {} nodes, {} groups",
            mesh.extract.gmsh_version,
            mesh.extract.nodes.len(),
            mesh.extract.groups.len()
        );
        self.observer.ends(Stage::Mesh, &what, mesh.time);
        Ok(())
    }

    fn solve(&mut self, model: &Model, boundary: &Boundary) -> Result<Solution, RunError> {
        let path = self.plan.folder.join(SOLUTION_FILE);
        if self.is_fresh(Stage::Solve)?
            && let Some((stored, _)) = read_stored::<StoredSolution>(&path)
        {
            self.observer.is_fresh(Stage::Solve);
            return Ok(self.restore(stored));
        }
        self.observer.starts(Stage::Solve);
        let start = std::time::Instant::now();
        let solution = statics::solve(model, boundary, &mut self.phases)?;
        self.lock()?;
        self.begin(Stage::Solve)?;
        write_whole(&path, &encode(&store(&solution, &self.phases)))?;
        self.finish(Stage::Solve, &[SOLUTION_FILE.to_owned()])?;
        let what = format!(
            "{} unknowns, {} bonds, {} trusses; residual {:.0e}",
            solution.size.dofs,
            model.bond_count,
            model.springs.len() - model.bond_count,
            solution.residual
        );
        self.observer.ends(Stage::Solve, &what, start.elapsed());
        Ok(solution)
    }

    /// The stored solution, with the times that it took when it was computed.
    fn restore(&mut self, stored: StoredSolution) -> Solution {
        let known = Phases::STATICS;
        for (name, seconds) in stored.phases {
            if let Some(name) = known.into_iter().find(|known| **known == name) {
                self.phases.list.push(Phase {
                    name,
                    time: Duration::from_secs_f64(seconds),
                });
            }
        }
        let [dofs, stiffness_entries, factor_entries] = stored.size;
        Solution {
            displacement: stored.displacement,
            reaction: stored.reaction,
            residual: stored.residual,
            size: SystemSize {
                dofs,
                stiffness_entries,
                factor_entries,
            },
        }
    }

    fn output(&mut self, outcome: &Outcome) -> Result<Value, RunError> {
        if self.is_fresh(Stage::Output)?
            && let Some(summary) = read_summary(&self.plan.folder)
        {
            self.observer.is_fresh(Stage::Output);
            return Ok(summary);
        }
        self.observer.starts(Stage::Output);
        let start = std::time::Instant::now();
        self.lock()?;
        self.begin(Stage::Output)?;
        let folder = &self.plan.folder;
        let draft = tempfile::Builder::new()
            .prefix(".draft-")
            .tempdir_in(folder)
            .map_err(|source| file_error("create a folder in", folder, source))?;
        let mut files = outcome.write(draft.path(), &mut self.phases)?;
        files.push(SUMMARY_FILE.to_owned());
        let summary = outcome.summary(&files, &self.phases, peak_memory());
        let text = serde_json::to_string_pretty(&summary).expect("a summary is plain data");
        write_whole(&draft.path().join(SUMMARY_FILE), text.as_bytes())?;
        for file in &files {
            fs::rename(draft.path().join(file), folder.join(file))
                .map_err(|source| file_error("write", &folder.join(file), source))?;
        }
        self.finish(Stage::Output, &files)?;
        let what = format!("{} files in {}", files.len(), folder.display());
        self.observer.ends(Stage::Output, &what, start.elapsed());
        Ok(summary)
    }

    fn warn_of_areas(&mut self, model: &Model) {
        for points in &model.points {
            let first = model.fe_node_count();
            let areas = &model.areas[points.nodes.start - first..points.nodes.end - first];
            let share = areas.iter().sum::<f64>() / points.area;
            if (share - 1.0).abs() > AREA_WARNING {
                self.observer.warns(&format!(
                    "the material points of `{}` stand for {:.2} % of its area",
                    model.regions[points.region].name,
                    100.0 * share
                ));
            }
        }
    }

    /// Keeps other runs out of the results folder from the first write on.
    fn lock(&mut self) -> Result<(), RunError> {
        if self.lock.is_some() {
            return Ok(());
        }
        let folder = &self.plan.folder;
        fs::create_dir_all(folder.join(".stamps"))
            .map_err(|source| file_error("create", folder, source))?;
        let path = folder.join(".stamps/lock");
        let file = File::create(&path).map_err(|source| file_error("create", &path, source))?;
        match file.try_lock() {
            Ok(()) => self.lock = Some(file),
            Err(fs::TryLockError::WouldBlock) => {
                return Err(RunError::Busy {
                    folder: folder.clone(),
                });
            }
            Err(fs::TryLockError::Error(source)) => return Err(file_error("lock", &path, source)),
        }
        Ok(())
    }

    /// From here to [`Run::finish`] the stage has no manifest: a killed run leaves it stale. What it
    /// wrote last time and will not write again must not stay behind.
    fn begin(&self, stage: Stage) -> Result<(), RunError> {
        let old = stamp::read(&self.plan.folder, stage);
        remove(&stamp::path(&self.plan.folder, stage))?;
        if stage == Stage::Output {
            for name in old.iter().flat_map(|manifest| manifest.outputs.keys()) {
                remove(&self.plan.folder.join(name))?;
            }
        }
        Ok(())
    }

    fn finish(&self, stage: Stage, files: &[String]) -> Result<(), RunError> {
        let folder = &self.plan.folder;
        let mut outputs = BTreeMap::new();
        for name in files {
            outputs.insert(name.clone(), hash_of(&folder.join(name))?);
        }
        let manifest = Manifest {
            recipe: recipe(self.plan, stage)?,
            outputs,
        };
        let text = serde_json::to_string_pretty(&manifest).expect("a manifest is plain data");
        Ok(write_whole(&stamp::path(folder, stage), text.as_bytes())?)
    }
}

/// A lattice whose areas are off by more than this is worth a word: the paper's full cells on grid
/// nodes are.
const AREA_WARNING: f64 = 1e-6;

/// What a stage would be made from now. Inputs that an earlier stage writes are hashed as they are
/// on disk.
fn recipe(plan: &Plan, stage: Stage) -> Result<Recipe, RunError> {
    let folder = &plan.folder;
    let kept = |name: &str| {
        (
            name.to_owned(),
            stamp::hash_file(&folder.join(name)).unwrap_or_else(|| "missing".to_owned()),
        )
    };
    let physics = [
        "geometry",
        "plane",
        "thickness",
        "materials",
        "regions",
        "coupling",
        "boundary",
    ];
    let (settings, inputs) = match stage {
        Stage::Mesh => {
            let mut settings = settings(&plan.spec, &["geometry/parameters"]);
            settings.insert("gmsh".to_owned(), gmsh_library());
            (settings, geometry_files(plan)?)
        }
        Stage::Solve => {
            let mut settings = settings(&plan.spec, &physics);
            settings.retain(|key, _| !key.starts_with("geometry/") || key == "geometry/unit");
            (settings, [kept(MESH_FILE)].into())
        }
        Stage::Output => {
            let mut settings = settings(&plan.spec, &physics);
            settings.retain(|key, _| !key.starts_with("geometry/") || key == "geometry/unit");
            settings.extend(self::settings(&plan.spec, &["name", "probes", "output"]));
            (settings, [kept(MESH_FILE), kept(SOLUTION_FILE)].into())
        }
    };
    Ok(Recipe::new(stage, settings, inputs))
}

/// The parts of the pipeline file below `prefixes`, one line per value, quantities in SI units.
fn settings(spec: &Spec, prefixes: &[&str]) -> BTreeMap<String, String> {
    let mut flat = BTreeMap::new();
    let value = serde_json::to_value(spec).expect("a spec is plain data");
    flatten("", &value, &mut flat);
    let below = |key: &str| {
        prefixes
            .iter()
            .any(|p| key == *p || key.starts_with(&format!("{p}/")))
    };
    flat.retain(|key, _| below(key));
    flat
}

fn flatten(key: &str, value: &Value, flat: &mut BTreeMap<String, String>) {
    let join = |step: &str| {
        if key.is_empty() {
            step.to_owned()
        } else {
            format!("{key}/{step}")
        }
    };
    match value {
        Value::Object(map) => map
            .iter()
            .for_each(|(step, v)| flatten(&join(step), v, flat)),
        Value::Array(list) => {
            list.iter()
                .enumerate()
                .for_each(|(k, v)| flatten(&join(&k.to_string()), v, flat));
        }
        Value::String(text) => {
            flat.insert(key.to_owned(), canonical(text));
        }
        other => {
            flat.insert(key.to_owned(), other.to_string());
        }
    }
}

/// `2.5 mm` and `0.0025 m` are the same quantity.
fn canonical(text: &str) -> String {
    match quantity::parse_any(text) {
        Ok((number, Some(dimension))) => format!("{number:e} ({})", dimension.symbol()),
        Ok((number, None)) => format!("{number}"),
        Err(_) => text.to_owned(),
    }
}

/// The file name of the library that would mesh, which carries its version.
fn gmsh_library() -> String {
    let search = gmsh::library::Places::of_this_process().search();
    let name = search.found.first().and_then(|path| path.file_name());
    name.map_or_else(
        || "none".to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// The geometry and all that it includes, with their hashes.
fn geometry_files(plan: &Plan) -> Result<BTreeMap<String, String>, RunError> {
    let file = &plan.geometry.file;
    let is_script = file.extension().is_some_and(|extension| extension == "geo");
    let files = if is_script {
        GeoScript::scan(file)
            .map_err(|error| gmsh_error(plan, error.into()))?
            .files
    } else {
        vec![file.clone()]
    };
    files
        .into_iter()
        .map(|file| Ok((file.display().to_string(), hash_of(&file)?)))
        .collect()
}

fn mesh_geometry(plan: &Plan, options: &Options) -> Result<Extract, RunError> {
    gmsh::mesh(
        &plan.geometry.file,
        &plan.geometry.parameters,
        &options.gmsh,
    )
    .map_err(|error| gmsh_error(plan, error))
}

/// Whose fault is it? The user's errors get their place in the pipeline and exit code 2.
fn gmsh_error(plan: &Plan, error: GmshError) -> RunError {
    let key = match &error {
        GmshError::UnknownParameter { name, .. }
        | GmshError::FixedParameter { name, .. }
        | GmshError::ParameterOfMesh { name, .. }
        | GmshError::ParameterValue { name, .. } => format!("geometry/parameters/{name}"),
        GmshError::FileMissing { .. }
        | GmshError::FileKind { .. }
        | GmshError::PathNotText { .. }
        | GmshError::Script(_)
        | GmshError::Failed { .. } => "geometry/file".to_owned(),
        _ => return RunError::Gmsh(Box::new(error)),
    };
    plan.source.error(&key, error.to_string(), None).into()
}

fn to_mesh(plan: &Plan, extract: &Extract) -> Result<crate::mesh::Mesh, RunError> {
    let mesh = extract.to_mesh(plan.geometry.unit_in_metres);
    Ok(mesh.map_err(|error| plan.source.error("geometry/file", error.to_string(), None))?)
}

fn encode(value: &impl Serialize) -> Vec<u8> {
    postcard::to_stdvec(value).expect("plain data in memory can be encoded")
}

fn read_stored<T: for<'de> Deserialize<'de>>(path: &Path) -> Option<(T, Vec<u8>)> {
    let bytes = fs::read(path).ok()?;
    Some((postcard::from_bytes(&bytes).ok()?, bytes))
}

fn store(solution: &Solution, phases: &Phases) -> StoredSolution {
    let SystemSize {
        dofs,
        stiffness_entries,
        factor_entries,
    } = solution.size;
    let statics = phases
        .list
        .iter()
        .filter(|phase| Phases::STATICS.contains(&phase.name));
    StoredSolution {
        displacement: solution.displacement.clone(),
        reaction: solution.reaction.clone(),
        residual: solution.residual,
        size: [dofs, stiffness_entries, factor_entries],
        phases: statics
            .map(|p| (p.name.to_owned(), p.time.as_secs_f64()))
            .collect(),
    }
}

/// The summary of the last finished run.
pub fn read_summary(folder: &Path) -> Option<Value> {
    serde_json::from_slice(&fs::read(folder.join(SUMMARY_FILE)).ok()?).ok()
}

fn hash_of(path: &Path) -> Result<String, RunError> {
    let unreadable = || file_error("read", path, io::ErrorKind::NotFound.into());
    stamp::hash_file(path).ok_or_else(unreadable)
}

fn remove(path: &Path) -> Result<(), RunError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(file_error("remove", path, source))
        }
        _ => Ok(()),
    }
}

fn file_error(action: &'static str, path: &Path, source: io::Error) -> RunError {
    RunError::File {
        action,
        path: path.to_owned(),
        source,
    }
}

/// Removes what the stages have written, and the folder if nothing else is in it. Returns the number
/// of files removed.
///
/// # Errors
/// A file that cannot be removed.
pub fn clean(plan: &Plan) -> Result<usize, RunError> {
    let folder = &plan.folder;
    let mut removed = 0;
    for stage in Stage::ALL {
        let Some(manifest) = stamp::read(folder, stage) else {
            continue;
        };
        for name in manifest.outputs.keys() {
            remove(&folder.join(name))?;
            removed += 1;
        }
        remove(&stamp::path(folder, stage))?;
    }
    remove(&folder.join(".stamps/lock"))?;
    // Both fail where the user keeps something there.
    let _ = fs::remove_dir(folder.join(".stamps"));
    let _ = fs::remove_dir(folder);
    Ok(removed)
}
