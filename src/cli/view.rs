//! `peristitch view`: the script `view.py` of the results, in ParaView, or into a PNG file by whatever can
//! draw it here: `pvpython`, else a Python that has VTK's package.

use crate::pipeline::account::summary::read_summary;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;
use crate::pipeline::show::view::VIEW_FILE;
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Variable by which the script finds the results: ParaView does not pass the script's own path.
const RESULTS: &str = "PERISTITCH_RESULTS";

/// Starts ParaView and waits for its end.
pub(super) fn show(plan: &Plan) -> Result<(), RunError> {
    let script = script(plan)?;
    let mut argument = std::ffi::OsString::from("--script=");
    argument.push(&script);
    let started = Command::new("paraview")
        .arg(argument)
        .env(RESULTS, absolute(&plan.folder))
        .status();
    match started {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(error(
            format!("ParaView has ended with {status}"),
            format!(
                "without a display, `--png FILE` draws a picture; {}",
                by_hand(plan)
            ),
        )),
        Err(_) => Err(error(
            "ParaView is not found: there is no `paraview` on the PATH".to_owned(),
            format!(
                "install it (Debian: `apt install paraview`; else https://www.paraview.org/download); {}. \
                 `--png FILE` draws a picture by VTK's Python package",
                by_hand(plan)
            ),
        )),
    }
}

/// Draws a picture into `file`.
pub(super) fn draw(plan: &Plan, file: &Path, step: Option<usize>) -> Result<(), RunError> {
    let script = script(plan)?;
    let step = step.map(|step| nearest_frame(plan, step)).transpose()?;
    // A picture that is cut off by a crash must not pass for one.
    let partial = absolute(file).with_extension("partial.png");
    let mut failures = Vec::new();
    for program in programs() {
        let mut command = Command::new(&program);
        command.arg(&script).arg(&partial).stdin(Stdio::null());
        command.args(step.map(|step| step.to_string()));
        let output = command.env(RESULTS, absolute(&plan.folder)).output();
        let Ok(output) = output else {
            failures.push(format!("{}: not there", program.display()));
            continue;
        };
        if output.status.success() && partial.is_file() {
            return match std::fs::rename(&partial, file) {
                Ok(()) => {
                    println!("{}  (by {})", file.display(), program.display());
                    Ok(())
                }
                Err(source) => Err(RunError::File {
                    action: "write",
                    path: file.to_owned(),
                    source,
                }),
            };
        }
        // What is there stays as it was.
        let _ = std::fs::remove_file(&partial);
        failures.push(format!("{}: {}", program.display(), reason(&output)));
    }
    let message = format!(
        "nothing here draws {}\n  {}",
        file.display(),
        failures.join("\n  ")
    );
    let help = format!(
        "`pip install vtk` in the Python that is used, or install ParaView; {}",
        by_hand(plan)
    );
    Err(error(message, help))
}

/// Programs that may be able to draw, the best first. `.venv`: where Gmsh is looked for, too.
fn programs() -> Vec<PathBuf> {
    let mut programs = vec![PathBuf::from("pvpython")];
    let active = env::var_os("VIRTUAL_ENV").map(PathBuf::from);
    let here = env::current_dir().ok();
    let program = env::current_exe().ok();
    let starts = here.iter().chain(&program);
    let nearest = starts.filter_map(|start| {
        let mut upwards = start.ancestors().map(|folder| folder.join(".venv"));
        upwards.find(|folder| folder.is_dir())
    });
    for environment in active.into_iter().chain(nearest) {
        let python = environment.join("bin/python3");
        if python.is_file() && !programs.contains(&python) {
            programs.push(python);
        }
    }
    programs.push(PathBuf::from("python3"));
    programs
}

/// The last line that a program has said, or how it ended.
fn reason(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let last = text.lines().rev().find(|line| !line.trim().is_empty());
    match last {
        Some(line) if output.status.code().is_some() => line.trim().to_owned(),
        _ => output.status.to_string(),
    }
}

/// The step nearest to `step` that has a frame; of two the earlier one.
fn nearest_frame(plan: &Plan, step: usize) -> Result<usize, InputError> {
    let fracture = read_summary(&plan.folder).and_then(|summary| summary.fracture);
    let frames = fracture.map_or_else(Vec::new, |fracture| fracture.frames);
    let nearest = frames.iter().min_by_key(|frame| frame.abs_diff(step));
    let Some(&nearest) = nearest else {
        let message = format!("--step: {} has no frame of step {step}", plan.name);
        let help = "only a run with `loading` has steps: leave --step out".to_owned();
        return Err(InputError::plain(message, Some(help)));
    };
    if nearest != step {
        eprintln!(
            "{}: step {step} has no frame; the nearest one is of step {nearest} (`output.every` says how many there are)",
            plan.name
        );
    }
    Ok(nearest)
}

fn script(plan: &Plan) -> Result<PathBuf, RunError> {
    let script = absolute(&plan.folder).join(VIEW_FILE);
    if script.is_file() {
        return Ok(script);
    }
    let pipeline = plan.source.path.display();
    Err(error(
        format!("there are no results in {}", plan.folder.display()),
        format!("`peristitch run {pipeline}` makes them"),
    ))
}

fn by_hand(plan: &Plan) -> String {
    let file = plan.folder.join(format!("{}.pvd", plan.name));
    format!("or open {} in a ParaView elsewhere", file.display())
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

fn error(message: String, help: String) -> RunError {
    RunError::Viewer { message, help }
}
