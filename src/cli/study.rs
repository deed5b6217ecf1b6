//! `peristitch sweep` and `peristitch plan`: a study run here, or written down for another engine.

use super::sweep::{self, Settings};
use super::{Common, INTERRUPTED, report};
use crate::output::write_whole;
use crate::pipeline::error::RunError;
use crate::pipeline::read::source::{InputError, choices};
use crate::pipeline::stages::run::{self, Options};
use crate::pipeline::study::engines::{Job, makefile, snakefile};
use crate::pipeline::study::sweep::Study;
use crate::pipeline::study::table::{Row, Status, draw_charts, log_file, row, write_table};
use crate::statics::Estimate;
use clap::Args;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;

pub(super) const SWEEP_HELP: &str = "\
Example: in the pipeline
  sweep: { over: { regions.1.spacing: [1 mm, 0.5 mm], regions.1.horizon: [3, 4] } }
and then
  peristitch sweep p.yaml

A run that is fresh does not run again; one that failed is tried again.";

#[derive(Args)]
pub(super) struct SweepArguments {
    #[command(flatten)]
    common: Common,
    /// Runs at a time [default: one for each processor]; fewer if memory is short
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Only this run; repeatable
    #[arg(long, value_name = "RUN")]
    only: Vec<String>,
    /// Run nothing: list the runs and their state
    #[arg(long, conflicts_with = "collect")]
    list: bool,
    /// Run nothing: write the table of the results so far
    #[arg(long)]
    collect: bool,
    /// Run every stage, stale or not
    #[arg(long)]
    force: bool,
}

#[derive(Args)]
pub(super) struct PlanArguments {
    #[command(flatten)]
    common: Common,
    /// Write a Makefile
    #[arg(long, value_name = "FILE", required_unless_present = "snakemake")]
    make: Option<PathBuf>,
    /// Write a Snakefile; meshes every run to estimate its memory
    #[arg(long, value_name = "FILE")]
    snakemake: Option<PathBuf>,
    /// Threads of each run
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
}

/// The studies of all pipelines, read before the first one runs.
fn studies(common: &Common) -> Result<Vec<Study>, InputError> {
    let read = |path: &PathBuf| Study::read(path, &common.overrides(), common.results.as_deref());
    common.pipelines.iter().map(read).collect()
}

pub(super) fn sweep(arguments: &SweepArguments) -> ExitCode {
    let chosen = studies(&arguments.common).and_then(|studies| {
        let chosen: Result<Vec<_>, _> =
            studies.iter().map(|s| choose(s, &arguments.only)).collect();
        Ok((chosen?, studies))
    });
    let (chosen, studies) = match chosen {
        Ok(all) => all,
        Err(error) => return report(error.into()),
    };
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)).expect("it is set once");
    let mut failed = false;
    for (study, chosen) in studies.iter().zip(&chosen) {
        match sweep_one(study, chosen, arguments, &interrupted) {
            Ok(Some(all_done)) => failed |= !all_done,
            Ok(None) => return ExitCode::from(INTERRUPTED),
            Err(error) => return report(error),
        }
    }
    ExitCode::from(u8::from(failed))
}

/// The runs that `--only` names, or all.
fn choose(study: &Study, only: &[String]) -> Result<Vec<usize>, InputError> {
    let names = || study.runs.iter().map(|run| run.name.as_str());
    let find = |name: &String| {
        names().position(|known| known == name).ok_or_else(|| {
            let message = format!(
                "the sweep of {} has no run `{name}`",
                study.pipeline.display()
            );
            InputError::plain(message, Some(choices(name, names())))
        })
    };
    match only {
        [] => Ok((0..study.runs.len()).collect()),
        only => only.iter().map(find).collect(),
    }
}

/// Whether all chosen runs are done; `None` if it was interrupted.
fn sweep_one(
    study: &Study,
    chosen: &[usize],
    arguments: &SweepArguments,
    interrupted: &AtomicBool,
) -> Result<Option<bool>, RunError> {
    let processors = available_parallelism().map_or(1, usize::from);
    let jobs = arguments
        .jobs
        .map_or(processors, usize::from)
        .min(chosen.len().max(1));
    if !arguments.list && !arguments.collect {
        let settings = Settings {
            jobs,
            threads: (processors / jobs).max(1),
            force: arguments.force,
        };
        if sweep::sweep(study, chosen, &settings, interrupted)?.is_none() {
            eprintln!("ended; the same command goes on");
            return Ok(None);
        }
    }
    let rows: Vec<Row> = study
        .runs
        .iter()
        .map(|run| row(study, run))
        .collect::<Result<_, _>>()?;
    if arguments.list {
        print_list(study, &rows);
        return Ok(Some(true));
    }
    let table = write_table(study, &rows)?;
    let charts = draw_charts(study, &rows).map_err(|error| RunError::Results(error.into()))?;
    print_table(study, &rows, chosen);
    println!("  {}  (a line per run)", table.display());
    for chart in charts {
        println!("  {}  (picture)", chart.display());
    }
    Ok(Some(chosen.iter().all(|&k| rows[k].status == Status::Done)))
}

fn print_list(study: &Study, rows: &[Row]) {
    for (run, row) in study.runs.iter().zip(rows) {
        let status = match &row.status {
            Status::Done => "done".to_owned(),
            Status::Missing => "to run".to_owned(),
            Status::Failed(message) => format!("failed: {message}"),
        };
        println!("{:<40}  {status}", run.name);
    }
}

/// How many are done, and what to do about the others.
fn print_table(study: &Study, rows: &[Row], chosen: &[usize]) {
    let done = rows.iter().filter(|row| row.status == Status::Done).count();
    println!("\n{}: {done} of {} runs are done", study.name, rows.len());
    let mut warnings: BTreeMap<&str, usize> = BTreeMap::new();
    for warning in rows.iter().flat_map(|row| &row.warnings) {
        *warnings.entry(warning).or_default() += 1;
    }
    for (warning, count) in warnings {
        println!("  warning of {count} of {} runs: {warning}", rows.len());
    }
    let failed = chosen.iter().filter(|&&k| rows[k].status != Status::Done);
    for &k in failed {
        let run = &study.runs[k];
        println!(
            "  not done: {}; its messages: {}",
            run.name,
            log_file(study, run).display()
        );
        println!(
            "    again: peristitch sweep {} --only {}",
            study.pipeline.display(),
            run.name
        );
    }
}

pub(super) fn plan(arguments: &PlanArguments) -> Result<(), RunError> {
    let common = &arguments.common;
    let [study] = &studies(common)?[..] else {
        let message = "`plan` takes one pipeline";
        let help = "call it once for each, with a file of its own".to_owned();
        return Err(InputError::plain(message, Some(help)).into());
    };
    let program = std::env::current_exe().map_err(|error| {
        InputError::plain(format!("this program's own path is unknown: {error}"), None)
    })?;
    let overrides = common.overrides();
    let job = Job {
        program: &program,
        overrides: &overrides,
        results: common.results.as_deref(),
        threads: arguments.threads.into(),
    };
    if let Some(file) = &arguments.make {
        write_whole(file, makefile(study, &job)?.as_bytes())?;
        println!(
            "{} runs; next: make -k -j2 -f {}",
            study.runs.len(),
            file.display()
        );
    }
    if let Some(file) = &arguments.snakemake {
        let megabytes = study.runs.iter().map(|run| {
            let (model, boundary, _) = run::discretised(&run.plan, &Options::default())?;
            let estimate = Estimate::new(&model, &boundary, None, run.plan.breaks())?;
            Ok(estimate.bytes.div_ceil(1_000_000))
        });
        let megabytes: Vec<u64> = megabytes.collect::<Result<_, RunError>>()?;
        write_whole(file, snakefile(study, &job, &megabytes).as_bytes())?;
        println!(
            "{} runs; next: snakemake --keep-going --cores 2 --snakefile {}",
            study.runs.len(),
            file.display()
        );
    }
    Ok(())
}
