//! The command line: arguments → pipelines, progress to standard error, results to standard output.
//! Exit codes: 0 done, 1 the computation failed, 2 the input is wrong.

mod watch;

use crate::fracture::control::{Ending, Resolution};
use crate::pipeline::damage_picture::DAMAGE_PICTURE;
use crate::pipeline::folder;
use crate::pipeline::parameters::parameter_lines;
use crate::pipeline::plan::Plan;
use crate::pipeline::profile;
use crate::pipeline::run::{self, Observer, Options, RunError, Standing};
use crate::pipeline::scribe;
use crate::pipeline::source::InputError;
use crate::pipeline::stamp::Stage;
use crate::pipeline::yaml;
use crate::statics::{Estimate, Method};
use crate::trace::Trace;
use crate::verification::{self, Check, Reference, table};
use clap::{Args, Parser, Subcommand, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use watch::Watch;

/// Quasi-static fracture in two dimensions: peridynamics stitched into finite elements.
#[derive(Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  peristitch run pipelines/cantilever_hybrid_q8.yaml
  peristitch run pipelines/*.yaml --until mesh
  peristitch run p.yaml --set geometry.parameters.element=5 --set regions.1.horizon=3
  peristitch watch p.yaml
  peristitch check p.yaml
  peristitch explain p.yaml
  peristitch verify

Exit codes: 0 done, 1 the computation failed, 2 the input is wrong.";

const WATCH_HELP: &str = "\
Example: open both files in an editor, the picture in a viewer, and
  peristitch watch pipelines/plate_mode_i.yaml --set regions.1.spacing='1 mm'

A save while a run goes stops it and starts another one. Errors are shown, and the next save runs again.
Ctrl-C ends it with exit code 130; the results are then those of the last finished run, or a run that
the same command continues.";

#[derive(Subcommand)]
enum Command {
    /// Run every stage that is stale: mesh, solve, output
    Run {
        #[command(flatten)]
        common: Common,
        /// Stop after this stage
        #[arg(long, value_enum, default_value = "output")]
        until: StageName,
        /// Run every stage, stale or not
        #[arg(long)]
        force: bool,
        /// Say what would run, and run nothing
        #[arg(long)]
        dry_run: bool,
        /// Number of threads; the results do not depend on it
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
        /// Factorise anew whenever bonds have broken: slow, to check the fast way against
        #[arg(long)]
        reference_solver: bool,
        /// Solve by conjugate gradients on two levels, as large lattices are, whatever the size
        #[arg(long, conflicts_with = "reference_solver")]
        iterative_solver: bool,
        /// Write a profile of the run, for chrome://tracing or ui.perfetto.dev
        #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
        trace: Option<PathBuf>,
        /// Print the numbers and one picture, not every file
        #[arg(long)]
        brief: bool,
    },
    /// Run, and run again whenever the YAML, the .geo or what it includes is saved
    #[command(after_help = WATCH_HELP)]
    Watch {
        #[command(flatten)]
        common: Common,
        /// Number of threads; the results do not depend on it
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
    },
    /// Validate, and print sizes and the memory and time to expect; writes nothing
    Check {
        #[command(flatten)]
        common: Common,
        /// As if run with this
        #[arg(long)]
        iterative_solver: bool,
    },
    /// Print which stages are fresh
    Status(Common),
    /// Print why stages are stale
    Explain(Common),
    /// Remove the results
    Clean(Common),
    /// Measure what the program gets right, here and now, against references; some minutes
    Verify {
        /// Only the cases that take a second or so
        #[arg(long)]
        quick: bool,
        /// Print JSON
        #[arg(long, conflicts_with = "markdown")]
        json: bool,
        /// Print a table for a Markdown page
        #[arg(long)]
        markdown: bool,
    },
}

#[derive(Args)]
struct Common {
    /// Pipeline files (YAML)
    #[arg(required = true, value_name = "PIPELINE")]
    pipelines: Vec<PathBuf>,
    /// Set a value of the pipeline, such as regions.1.horizon=3; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Where NAME/ goes [default: results/ beside pipelines/, or beside the file]
    #[arg(long, value_name = "FOLDER")]
    results: Option<PathBuf>,
}

impl Common {
    fn plan(&self, pipeline: &Path) -> Result<Plan, RunError> {
        Ok(Plan::read(
            pipeline,
            &self.overrides,
            self.results.as_deref(),
        )?)
    }
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

/// Parses the arguments and does what they say.
pub fn main() -> ExitCode {
    set_up_messages();
    match Cli::parse().command {
        Command::Run {
            common,
            until,
            force,
            dry_run,
            threads,
            reference_solver,
            iterative_solver,
            trace,
            brief,
        } => {
            if let Some(threads) = threads {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
                pool.build_global().expect("no parallel work has begun yet");
            }
            let options = Options {
                until: until.into(),
                force,
                resolution: match (reference_solver, iterative_solver) {
                    (true, _) => Resolution::Reference,
                    (false, true) => Resolution::TwoLevel,
                    (false, false) => Resolution::Fast,
                },
                ..Options::default()
            };
            if dry_run {
                for_each(&common, |plan| announce(plan, &options))
            } else if let Some(file) = trace {
                run_traced(&common, options, &file, brief)
            } else {
                for_each(&common, |plan| run_one(plan, &options, brief))
            }
        }
        Command::Watch { common, threads } => watch_all(common, threads),
        Command::Check {
            common,
            iterative_solver,
        } => {
            let method = iterative_solver.then_some(Method::TwoLevel);
            for_each(&common, |plan| check(plan, method))
        }
        Command::Status(common) => for_each(&common, |plan| list(plan, false)),
        Command::Explain(common) => for_each(&common, |plan| list(plan, true)),
        Command::Clean(common) => for_each(&common, |plan| {
            let removed = folder::clean(plan)?;
            println!("{}: {removed} files removed", plan.folder.display());
            Ok(())
        }),
        Command::Verify {
            quick,
            json,
            markdown,
        } => verify(quick, json, markdown),
    }
}

/// A pipeline that is wrong may become right, but it must be there.
fn watch_all(common: Common, threads: Option<u16>) -> ExitCode {
    let missing = common.pipelines.iter().find(|pipeline| !pipeline.is_file());
    if let Some(Err(error)) = missing.map(|pipeline| common.plan(pipeline)) {
        return report(error);
    }
    if let Err(error) = yaml::parse_overrides(&common.overrides) {
        return report(error.into());
    }
    let mut arguments: Vec<OsString> = Vec::new();
    for value in &common.overrides {
        arguments.extend(["--set".into(), value.into()]);
    }
    if let Some(folder) = &common.results {
        arguments.extend(["--results".into(), folder.into()]);
    }
    if let Some(threads) = threads {
        arguments.extend(["--threads".into(), threads.to_string().into()]);
    }
    let (sender, interrupts) = mpsc::channel();
    let set = ctrlc::set_handler(move || {
        // Nobody listens once the watch is over.
        let _ = sender.send(());
    });
    set.expect("it is set once");
    let files = common
        .pipelines
        .iter()
        .map(|path| path.display().to_string());
    let files: Vec<String> = files.collect();
    eprintln!(
        "watches {} and their geometry; Ctrl-C ends it",
        files.join(", ")
    );
    let watched = watch::watch(
        &Watch {
            pipelines: common.pipelines.clone(),
            overrides: common.overrides.clone(),
            arguments,
        },
        &interrupts,
        || keep_apart(&common),
    );
    match watched {
        Ok(()) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            let message = format!("cannot start a run: {error}");
            report(InputError::plain(message, None).into())
        }
    }
}

/// What a shell makes of Ctrl-C.
const INTERRUPTED: u8 = 130;

/// Whether the pipelines that can be read have results folders of their own; says so if they have not.
fn keep_apart(common: &Common) -> bool {
    let plans = common
        .pipelines
        .iter()
        .map(|pipeline| common.plan(pipeline));
    let plans: Vec<Plan> = plans.flatten().collect();
    match check_folders(&plans) {
        Ok(()) => true,
        Err(error) => {
            report(error.into());
            false
        }
    }
}

/// Runs, and writes the profile of what has run, even if it ends in an error.
fn run_traced(common: &Common, options: Options, file: &Path, brief: bool) -> ExitCode {
    if let Err(error) = check_trace(file) {
        return report(error.into());
    }
    let begin = Instant::now();
    let profiles = RefCell::new(Vec::new());
    let code = for_each(common, |plan| {
        let trace = Trace::since(begin);
        profiles
            .borrow_mut()
            .push((plan.name.clone(), trace.clone()));
        let options = Options {
            trace,
            ..options.clone()
        };
        run_one(plan, &options, brief)
    });
    match profile::write(file, &profiles.into_inner()) {
        Ok(()) => code,
        Err(error) => report(error.into()),
    }
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

/// A line per case as it is measured, then the table; fails if a check falls short.
fn verify(quick: bool, json: bool, markdown: bool) -> ExitCode {
    let cases = verification::ladder().into_iter();
    let cases: Vec<_> = cases.filter(|case| case.is_quick || !quick).collect();
    let mut checks = Vec::new();
    let mut failed = false;
    for (number, case) in cases.iter().enumerate() {
        let start = Instant::now();
        eprint!("[{:>2}/{}] {} ... ", number + 1, cases.len(), case.name);
        match case.run() {
            Ok(measured) => {
                let short = measured.iter().filter(|check| !check.holds()).count();
                let verdict = match short {
                    0 => "holds".to_owned(),
                    short => format!("{short} of {} fall short", measured.len()),
                };
                eprintln!("{verdict} ({:.1} s)", start.elapsed().as_secs_f64());
                checks.extend(measured);
            }
            Err(error) => {
                eprintln!("failed: {error}");
                failed = true;
            }
        }
    }
    if json {
        let list: Vec<Value> = checks.iter().map(check_as_json).collect();
        println!("{:#}", Value::Array(list));
    } else if markdown {
        print!("{}", table::markdown(&checks));
    } else {
        print!("{}", table::aligned(&checks));
    }
    match failed || !checks.iter().all(Check::holds) {
        true => ExitCode::from(1),
        false => ExitCode::SUCCESS,
    }
}

fn check_as_json(check: &Check) -> Value {
    let reference = match check.reference {
        Reference::Value { value, within } => {
            json!({ "value": value, "within_relative": within })
        }
        Reference::Zero { within } => json!({ "value": 0.0, "within": within }),
        Reference::Between { low, high } => json!({ "low": low, "high": high }),
    };
    json!({
        "case": check.case,
        "quantity": check.quantity,
        "reference": reference,
        "source": check.source,
        "measured": check.measured,
        "error": check.error(),
        "holds": check.holds(),
    })
}

/// Reads all pipelines before the first one acts, so that bad input stops everything.
fn for_each(common: &Common, act: impl Fn(&Plan) -> Result<(), RunError>) -> ExitCode {
    let plans: Result<Vec<Plan>, RunError> = common
        .pipelines
        .iter()
        .map(|pipeline| common.plan(pipeline))
        .collect();
    let done = plans.and_then(|plans| {
        check_folders(&plans)?;
        plans.iter().try_for_each(act)
    });
    done.map_or_else(report, |()| ExitCode::SUCCESS)
}

/// Each pipeline needs a results folder of its own.
fn check_folders(plans: &[Plan]) -> Result<(), InputError> {
    let mut owners = BTreeMap::new();
    for plan in plans {
        if let Some(first) = owners.insert(&plan.folder, plan) {
            let (first, second) = (first.source.path.display(), plan.source.path.display());
            let message = format!(
                "{first} and {second} both write to {}",
                plan.folder.display()
            );
            let help = "give each pipeline a `name` of its own".to_owned();
            return Err(InputError::plain(message, Some(help)));
        }
    }
    Ok(())
}

fn report(error: RunError) -> ExitCode {
    let (report, code) = match error {
        RunError::Input(error) => (*error, 2),
        failure => (InputError::plain(with_causes(&failure), failure.help()), 1),
    };
    eprintln!("{:?}", miette::Report::new(report));
    ExitCode::from(code)
}

/// The message, and each cause that it does not tell itself.
fn with_causes(failure: &RunError) -> String {
    let mut message = failure.to_string();
    let mut cause = std::error::Error::source(failure);
    while let Some(source) = cause {
        let text = source.to_string();
        if !message.contains(&text) {
            message.push_str(&format!(": {text}"));
        }
        cause = source.source();
    }
    message
}

/// Messages are wrapped for a person's terminal alone: a log is searched for them.
fn set_up_messages() {
    let is_terminal = std::io::stderr().is_terminal();
    let set = miette::set_hook(Box::new(move |_| {
        let options = miette::MietteHandlerOpts::new()
            .wrap_lines(is_terminal)
            .break_words(false);
        Box::new(options.build())
    }));
    set.expect("it is set once, before the first message");
}

fn run_one(plan: &Plan, options: &Options, brief: bool) -> Result<(), RunError> {
    let mut progress = Progress::new(&plan.name);
    let summary = run::run(plan, options, &mut progress);
    progress.clear();
    let Some(summary) = summary? else {
        return Ok(());
    };
    println!("\n{}", plan.name);
    print_numbers(&summary);
    if brief {
        print_picture(plan, &summary);
    } else {
        print_files(plan, &summary);
    }
    let fracture = &summary["fracture"];
    match fracture["stopped_because"].as_str() {
        Some(reason) if summary["outcome"] == Ending::Singular.describe() => {
            Err(RunError::Stopped {
                step: fracture["end"]["step"].as_u64().unwrap_or(0),
                reason: reason.to_owned(),
                folder: plan.folder.clone(),
            })
        }
        _ => Ok(()),
    }
}

fn announce(plan: &Plan, options: &Options) -> Result<(), RunError> {
    for (stage, standing) in run::standings(plan)? {
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

fn list(plan: &Plan, reasons_too: bool) -> Result<(), RunError> {
    for (stage, standing) in run::standings(plan)? {
        let state = match &standing {
            Standing::Fresh => "fresh".to_owned(),
            Standing::Stale(_) => "stale".to_owned(),
            Standing::After(earlier) => format!("stale if {earlier} delivers something new"),
        };
        println!("{}: {stage:<6} {state}", plan.name);
        if let (true, Standing::Stale(reasons)) = (reasons_too, standing) {
            reasons.iter().for_each(|reason| println!("    {reason}"));
        }
    }
    Ok(())
}

fn check(plan: &Plan, method: Option<Method>) -> Result<(), RunError> {
    let (model, boundary, extract) = run::discretised(plan, &Options::default())?;
    let estimate = Estimate::new(&model, &boundary, method, plan.loading.is_some())?;
    println!("{}: sound", plan.name);
    println!(
        "  mesh              {}, {} groups",
        extract.origin,
        extract.groups.len()
    );
    for (index, line) in parameter_lines(plan, &extract)?.iter().enumerate() {
        let title = if index == 0 { "parameters" } else { "" };
        println!("  {title:<18}{line}");
    }
    println!(
        "  finite elements   {} with {} nodes",
        model.elements.len(),
        model.fe_node_count() - model.inner_nodes().len()
    );
    println!("  material points   {}", model.areas.len());
    let (ties, what) = model.ties();
    println!("  bonds             {}", model.bond_count);
    println!("  {what:<18}{ties}");
    for interface in &model.interfaces {
        println!(
            "  interface         `{}` to `{}`: {} edges",
            model.regions[interface.finite_elements].name,
            model.regions[interface.peridynamics].name,
            interface.edges.len()
        );
    }
    println!("  unknowns          {}", estimate.dofs);
    match estimate.method {
        Method::Direct => println!(
            "  factor            {} entries, {:.2e} flops",
            estimate.factor_entries, estimate.flops
        ),
        Method::TwoLevel => println!(
            "  solver            two levels, conjugate gradients; {:.1e} entries in the coarse factor",
            estimate.factor_entries as f64
        ),
    }
    println!(
        "  to expect         {}, {}",
        megabytes(estimate.bytes),
        about(estimate.time)
    );
    Ok(())
}

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 / 1e6)
}

fn about(time: Duration) -> String {
    format!("about {:.1} s", time.as_secs_f64().max(0.1))
}

/// Numbers that a person wants to see, to standard output.
fn print_numbers(summary: &Value) {
    for probe in list_in(summary, "probes") {
        print_probe(&probe);
    }
    print_fracture(summary);
    print_reactions(&summary["reactions_n"]);
}

fn list_in(summary: &Value, key: &str) -> Vec<Value> {
    summary[key].as_array().cloned().unwrap_or_default()
}

/// The picture that tells most.
fn print_picture(plan: &Plan, summary: &Value) {
    let files = list_in(summary, "files");
    let is_there = |name: &&str| files.iter().any(|file| file == name);
    let pictures = [DAMAGE_PICTURE, "displacement_x.png"];
    if let Some(picture) = pictures.into_iter().find(is_there) {
        println!("  {}/{picture}", plan.folder.display());
    }
}

fn print_files(plan: &Plan, summary: &Value) {
    let folder = plan.folder.display();
    if !summary["fracture"].is_null() {
        println!("  {folder}/{}  (a line per step)", scribe::HISTORY_FILE);
    }
    for file in list_in(summary, "files")
        .iter()
        .filter_map(Value::as_str)
        .filter(|file| !file.ends_with(".vtu"))
    {
        let what = match file.rsplit('.').next() {
            Some("pvd") => "open it in ParaView",
            Some("png") => "picture",
            _ => "sizes, times, versions",
        };
        println!("  {folder}/{file}  ({what})");
    }
}

/// Onset, peak and end of a fracture run, each with what the pipeline gives as its reference.
fn print_fracture(summary: &Value) {
    let fracture = &summary["fracture"];
    if fracture.is_null() {
        return;
    }
    let event = |title: &str, event: &Value, reference: &Value| {
        let reference = reference
            .as_u64()
            .map(|step| format!(" (reference: step {step})"));
        let Some(step) = event["step"].as_u64() else {
            println!("  {title}: never{}", reference.unwrap_or_default());
            return;
        };
        println!(
            "  {title}: step {step}{}, at {:.4e} m and {:.4e} N",
            reference.unwrap_or_default(),
            event["grip_displacement_m"].as_f64().unwrap_or(f64::NAN),
            event["reaction_n"].as_f64().unwrap_or(f64::NAN)
        );
    };
    let reference = &fracture["reference"];
    // The references count load steps, and the events of the event-driven control are none.
    let no_reference = Value::Null;
    let is_event_driven = fracture["control"] == "event-driven";
    let reference = if is_event_driven {
        &no_reference
    } else {
        reference
    };
    event(
        "first bond broken",
        &fracture["first_break"],
        &reference["first_break"],
    );
    event("peak reaction", &fracture["peak"], &Value::Null);
    if is_event_driven {
        event("largest load", &fracture["envelope_peak"], &Value::Null);
    }
    let ending = summary["outcome"].as_str().unwrap_or("ended");
    event(ending, &fracture["end"], &reference["separated"]);
    let fragments = fracture["fragments"].as_array();
    if let Some(fragments) = fragments.filter(|list| !list.is_empty()) {
        let nodes: u64 = fragments.iter().filter_map(Value::as_u64).sum();
        println!(
            "  come off: {} parts of {nodes} points in all",
            fragments.len()
        );
    }
    if let Some(reason) = fracture["stopped_because"].as_str() {
        println!("  because {reason}");
    }
    println!(
        "  bonds broken: {}; crack length: {:.4e} m",
        fracture["bonds_broken"],
        fracture["crack_length_m"].as_f64().unwrap_or(f64::NAN)
    );
}

/// Components below this share of the largest are what rounding leaves of zero.
const ROUNDING: f64 = 1e-9;

fn print_reactions(reactions: &Value) {
    let groups = || reactions.as_object().into_iter().flatten();
    let number = |reaction: &Value, axis: usize| reaction[axis].as_f64().unwrap_or(0.0);
    let largest = groups()
        .flat_map(|(_, reaction)| [0, 1].map(|axis| number(reaction, axis).abs()))
        .fold(0.0, f64::max);
    for (group, reaction) in groups() {
        let [x, y] = [0, 1].map(|axis| match number(reaction, axis) {
            force if force.abs() > ROUNDING * largest => format!("{force:.6e}"),
            _ => "0".to_owned(),
        });
        println!("  reaction on {group}: ({x}, {y}) N");
    }
}

/// A relative error in percent, signed unless it rounds to zero.
fn percent(error: f64) -> String {
    let text = format!("{:+.2}", 100.0 * error);
    match text.as_str() {
        "+0.00" | "-0.00" => "0.00 %".to_owned(),
        _ => text + " %",
    }
}

fn print_probe(probe: &Value) {
    let text = |key: &str| probe[key].as_str().unwrap_or("");
    let number = |key: &str| probe[key].as_f64();
    let mut line = format!(
        "  {}: u_{} = {:.5e} m",
        text("name"),
        text("component"),
        number("displacement_m").unwrap_or(f64::NAN)
    );
    if let (Some(reference), Some(error)) = (number("reference_m"), number("error")) {
        line.push_str(&format!(
            "  ({} of the reference {reference:.4e} m)",
            percent(error)
        ));
    }
    println!("{line}");
}

/// A line per stage on standard error; a spinner while it runs, where a person watches.
struct Progress {
    name: String,
    spinner: ProgressBar,
}

impl Progress {
    fn new(name: &str) -> Progress {
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

    fn clear(&self) {
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

    fn progress(&mut self, text: &str) {
        self.spinner.set_message(format!("{}: {text}", self.name));
    }

    fn is_fresh(&mut self, stage: Stage) {
        self.line(&format!("{stage:<6}    fresh"));
    }

    fn warns(&mut self, text: &str) {
        self.line(&format!("warning: {text}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_percent_has_no_sign() {
        let percents = [-2.21e-2, 4e-3, 4e-5, -4e-16, 0.0].map(percent);
        assert_eq!(
            percents,
            ["-2.21 %", "+0.40 %", "0.00 %", "0.00 %", "0.00 %"]
        );
    }
}
