//! `peristitch run`.

use super::numbers::{print_files, print_next, print_numbers, print_phases, print_picture};
use super::progress::{JsonLines, Progress, print_error};
use super::solver::SolverArguments;
use super::{Common, INTERRUPTED, code_of, for_each, report};
use crate::fracture::control::{Ending, Resolution};
use crate::pipeline::account::profile;
use crate::pipeline::account::summary::Summary;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;
use crate::pipeline::record::stamp::Stage;
use crate::pipeline::stages::run::{self, Options};
use crate::pipeline::stages::standing::{Standing, standings};
use crate::trace::Trace;
use clap::{Args, ValueEnum};
use rayon::ThreadPoolBuilder;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

#[derive(Args)]
pub(super) struct RunArguments {
    #[command(flatten)]
    common: Common,
    /// Stop after this stage
    #[arg(long, value_enum, default_value = "output")]
    until: StageName,
    /// Run every stage, stale or not
    #[arg(long)]
    force: bool,
    /// Print what would run, and run nothing
    #[arg(long)]
    dry_run: bool,
    /// Number of threads; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Factorise for every response: slow, to check the updates against
    #[arg(long, conflicts_with_all = ["solver", "iterative_solver"])]
    reference_solver: bool,
    #[command(flatten)]
    solver: SolverArguments,
    /// Write a profile of the run, for chrome://tracing or ui.perfetto.dev
    #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
    trace: Option<PathBuf>,
    /// Print the numbers and one picture, not every file
    #[arg(long)]
    brief: bool,
    /// Print a line of JSON for each stage, step, warning, error and the end, and nothing else
    #[arg(long, conflicts_with_all = ["brief", "verbose", "dry_run"])]
    json: bool,
    /// Print why stages run, and the time of each phase
    #[arg(short, long)]
    verbose: bool,
    /// End when standard input ends: with the process that started this one
    #[arg(long, hide = true)]
    tied: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum StageName {
    Mesh,
    Solve,
    Output,
}

impl From<StageName> for Stage {
    fn from(name: StageName) -> Stage {
        match name {
            StageName::Mesh => Stage::Mesh,
            StageName::Solve => Stage::Solve,
            StageName::Output => Stage::Output,
        }
    }
}

pub(super) fn run(arguments: &RunArguments) -> ExitCode {
    if arguments.tied {
        end_with_parent();
    }
    let options = Options {
        until: arguments.until.into(),
        force: arguments.force,
        resolution: match (arguments.reference_solver, arguments.solver.backend()) {
            (true, _) => Resolution::Reference,
            (false, Some(backend)) => Resolution::By(backend),
            (false, None) => Resolution::Fast,
        },
        ..Options::default()
    };
    let work = || {
        if arguments.dry_run {
            for_each(&arguments.common, |plan| announce(plan, &options))
        } else if let Some(file) = &arguments.trace {
            run_traced(arguments, &options, file)
        } else {
            for_each(&arguments.common, |plan| run_one(plan, &options, arguments))
        }
    };
    let threads = set_up_threads(arguments.threads);
    let done = threads.map_err(RunError::from).and_then(|()| work());
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if arguments.json => {
            let code = code_of(&error);
            print_error(&error, code);
            ExitCode::from(code)
        }
        Err(error) => report(error),
    }
}

/// The main thread is one of those that work is shared out to: to wake another for each piece of a run, and to be
/// woken by it, takes as long as many a piece.
fn set_up_threads(threads: Option<u16>) -> Result<(), InputError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0).into());
    let built = pool.use_current_thread().build_global();
    built.map_err(|source| {
        let help = "--threads 1 needs no other; `ulimit -u` and `ulimit -v` bound them";
        InputError::plain(
            format!("the threads cannot be started: {source}"),
            Some(help.to_owned()),
        )
    })
}

/// A run may end at any moment; one whose parent has gone must not go on by itself.
fn end_with_parent() {
    std::thread::spawn(|| {
        // Nothing is ever written there: this returns when the parent's end of the pipe is closed.
        let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
        std::process::exit(INTERRUPTED.into());
    });
}

/// Runs, and writes the profile of what has run, even if it ends in an error.
fn run_traced(arguments: &RunArguments, options: &Options, file: &Path) -> Result<(), RunError> {
    check_trace(file)?;
    let begin = Instant::now();
    let profiles = RefCell::new(Vec::new());
    let done = for_each(&arguments.common, |plan| {
        let trace = Trace::since(begin);
        profiles
            .borrow_mut()
            .push((plan.name.clone(), trace.clone()));
        let options = Options {
            trace,
            ..options.clone()
        };
        run_one(plan, &options, arguments)
    });
    // The run's own error tells more than that of its profile.
    done.and(profile::write(file, &profiles.into_inner()).map_err(RunError::from))
}

/// A profile that could not be written is told before the run.
fn check_trace(file: &Path) -> Result<(), InputError> {
    let folder = file
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let (message, help) = if file.is_dir() {
        let message = format!("--trace: {} is a folder", file.display());
        (message, "name a file, such as trace.json")
    } else if !folder.is_dir() {
        let message = format!("--trace: there is no folder {}", folder.display());
        (message, "make it, or name another place")
    } else {
        return Ok(());
    };
    Err(InputError::plain(message, Some(help.to_owned())))
}

fn run_one(plan: &Plan, options: &Options, arguments: &RunArguments) -> Result<(), RunError> {
    if arguments.json {
        let mut lines = JsonLines::new(&plan.name);
        let summary = run::run(plan, options, &mut lines)?;
        lines.done(summary.as_ref());
        return summary.map_or(Ok(()), |summary| good_end(plan, &summary));
    }
    if arguments.verbose {
        tell_reasons(plan)?;
    }
    let mut progress = Progress::new(&plan.name);
    let summary = run::run(plan, options, &mut progress);
    progress.clear();
    let Some(summary) = summary? else {
        return Ok(());
    };
    println!("\n{}", plan.name);
    print_numbers(&summary);
    if arguments.brief {
        print_picture(plan, &summary);
    } else {
        print_files(plan, &summary);
        print_next(plan);
    }
    if arguments.verbose {
        print_phases(&summary);
    }
    good_end(plan, &summary)
}

/// Why stages run, to standard error.
fn tell_reasons(plan: &Plan) -> Result<(), RunError> {
    for (stage, standing) in standings(plan)? {
        let Standing::Stale(reasons) = standing else {
            continue;
        };
        for reason in &reasons {
            eprintln!("{}: {stage:<6} is stale: {reason}", plan.name);
        }
    }
    Ok(())
}

/// A run that ended since there was no solution is an error, told behind its results.
fn good_end(plan: &Plan, summary: &Summary) -> Result<(), RunError> {
    let fracture = summary.fracture.as_ref();
    match fracture.and_then(|fracture| Some((fracture, fracture.stopped_because.as_ref()?))) {
        Some((fracture, reason)) if summary.outcome == Ending::Singular.describe() => {
            Err(RunError::Stopped {
                step: fracture.end.as_ref().map_or(0, |end| end.step),
                reason: reason.clone(),
                folder: plan.folder.clone(),
            })
        }
        _ => Ok(()),
    }
}

fn announce(plan: &Plan, options: &Options) -> Result<(), RunError> {
    for (stage, standing) in standings(plan)? {
        if stage <= options.until {
            let verb = match standing {
                _ if options.force => "would run".to_owned(),
                Standing::Fresh => "fresh".to_owned(),
                Standing::Stale(_) => "would run".to_owned(),
                Standing::After(earlier) => {
                    format!("would run if {earlier} delivers something new")
                }
            };
            println!("{}: {stage:<6} {verb}", plan.name);
        }
    }
    Ok(())
}
