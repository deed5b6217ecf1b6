//! The command line: arguments → pipelines, progress to standard error, results to standard output.
//! Exit codes: 0 done, 1 the computation failed, 2 the input is wrong.

#[macro_use]
mod say;
mod check;
mod conditions;
mod new;
mod numbers;
mod progress;
mod run;
mod solver;
mod study;
mod sweep;
mod verify;
mod view;
mod watch;

use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;
use crate::pipeline::read::{reference, schema};
use crate::pipeline::record::folder;
use check::{check, list};
use clap::{Args, CommandFactory, Parser, Subcommand};
use solver::SolverArguments;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Quasi-static fracture in two dimensions by a hybrid of peridynamics and finite elements.
#[derive(Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  peristitch new my_plate
  peristitch run my_plate.yaml
  peristitch run pipelines/*.yaml --until mesh
  peristitch run p.yaml --set geometry.parameters.element=5 --set regions.1.horizon=3
  peristitch watch p.yaml
  peristitch check p.yaml
  peristitch view p.yaml
  peristitch explain p.yaml
  peristitch sweep p.yaml
  peristitch verify

Exit codes: 0 done, 1 the computation failed, 2 the input is wrong.";

const RUN_HELP: &str = "\
Examples:
  peristitch run p.yaml --set regions.1.horizon=3
  peristitch run p.yaml --json | jq -r 'select(.event == \"step\") | .load_factor'

Progress goes to standard error: one line per stage, and the current step if it is a terminal. Results go to
standard output.";

const COMPLETIONS_HELP: &str = "\
Examples:
  peristitch completions bash > ~/.local/share/bash-completion/completions/peristitch
  peristitch completions zsh > ~/.zfunc/_peristitch
  peristitch completions fish > ~/.config/fish/completions/peristitch.fish";

const WATCH_HELP: &str = "\
Example: open both files in an editor, the picture in a viewer, and
  peristitch watch pipelines/plate_mode_i.yaml --set regions.1.spacing='1 mm'

A save during a run stops that run and starts another one. Errors are shown, and the next save runs again.
Ctrl-C ends it with exit code 130; the results are then those of the last finished run, or a run that
the same command continues.";

#[derive(Subcommand)]
enum Command {
    /// Write NAME.geo and NAME.yaml: a plate to start from
    New {
        /// A name such as my_plate, or studies/my_plate
        #[arg(value_name = "NAME")]
        name: PathBuf,
    },
    /// Run every stage that is stale: mesh, solve, output
    #[command(after_help = RUN_HELP)]
    Run(run::RunArguments),
    /// Run, and run again after every save of the YAML, the .geo or an included file
    #[command(after_help = WATCH_HELP)]
    Watch {
        #[command(flatten)]
        common: Common,
        /// Number of threads; the results do not depend on it
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
        threads: Option<u16>,
    },
    /// Validate, and print sizes and the expected memory and time; writes nothing
    Check {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        solver: SolverArguments,
    },
    /// Print which stages are fresh
    Status(Common),
    /// Print why stages are stale
    Explain(Common),
    /// Open the results in ParaView with deformed shape, damage and mesh, or write a PNG file
    View {
        #[command(flatten)]
        common: Common,
        /// Write a picture instead, by pvpython or by VTK's Python package
        #[arg(long, value_name = "FILE")]
        png: Option<PathBuf>,
        /// The step of a fracture run to draw, or the nearest one that has a frame [default: the last]
        #[arg(long, value_name = "STEP", requires = "png")]
        step: Option<usize>,
    },
    /// Remove the results
    Clean(Common),
    /// Run the study that the pipeline's `sweep` describes, and write its table
    #[command(after_help = study::SWEEP_HELP)]
    Sweep(study::SweepArguments),
    /// Write the runs of a study as a Makefile or a Snakefile
    Plan(study::PlanArguments),
    /// Measure the verification table against its references; takes some minutes
    Verify {
        /// Only the cases that take about a second
        #[arg(long)]
        quick: bool,
        /// Print JSON
        #[arg(long, conflicts_with = "markdown")]
        json: bool,
        /// Print a table for a Markdown page
        #[arg(long)]
        markdown: bool,
    },
    /// Print the JSON schema of a pipeline, for editors, or the reference of its keys
    Schema {
        /// The reference as a page in Markdown
        #[arg(long)]
        markdown: bool,
    },
    /// Print the completions of commands and options for a shell
    #[command(after_help = COMPLETIONS_HELP)]
    Completions {
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Print the manual page
    #[command(after_help = "Example: peristitch man > ~/.local/share/man/man1/peristitch.1")]
    Man,
}

#[derive(Args)]
struct Common {
    /// Pipeline files (YAML)
    #[arg(required = true, value_name = "PIPELINE")]
    pipelines: Vec<PathBuf>,
    /// Set a value of the pipeline, such as regions.1.horizon=3; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// The folder for NAME/ [default: results/ beside pipelines/, or beside the file]
    #[arg(long, value_name = "FOLDER")]
    results: Option<PathBuf>,
    /// Let the .geo run programs and write files: the same as --set geometry.trust=true
    #[arg(long)]
    trust_geometry: bool,
}

impl Common {
    /// The values of `--set`, and of the options that are short for it.
    fn overrides(&self) -> Vec<String> {
        let mut overrides = self.overrides.clone();
        if self.trust_geometry {
            overrides.push("geometry.trust=true".to_owned());
        }
        overrides
    }

    fn plan(&self, pipeline: &Path) -> Result<Plan, RunError> {
        let overrides = self.overrides();
        Ok(Plan::read(pipeline, &overrides, self.results.as_deref())?)
    }
}

/// Parses the arguments and does what they say.
pub fn main() -> ExitCode {
    say::end(command())
}

fn command() -> ExitCode {
    set_up_messages();
    let done = match Cli::parse().command {
        Command::Run(arguments) => return run::run(&arguments),
        Command::Watch { common, threads } => return watch::watch_all(common, threads),
        Command::Sweep(arguments) => return study::sweep(&arguments),
        Command::Plan(arguments) => study::plan(&arguments),
        Command::New { name } => new::begin(&name),
        Command::Check { common, solver } => {
            for_each(&common, |plan| check(plan, solver.backend()))
        }
        Command::Status(common) => for_each(&common, |plan| list(plan, false)),
        Command::Explain(common) => for_each(&common, |plan| list(plan, true)),
        Command::View { common, png, step } => match png {
            None => for_each(&common, view::show),
            Some(file) => match common.pipelines.as_slice() {
                [_] => for_each(&common, |plan| view::draw(plan, &file, step)),
                _ => {
                    let message = "--png: one file cannot hold the pictures of several pipelines";
                    let help = "name one pipeline".to_owned();
                    Err(InputError::plain(message, Some(help)).into())
                }
            },
        },
        Command::Clean(common) => for_each(&common, |plan| {
            let removed = folder::clean(plan)?;
            println!("{}: {removed} files removed", plan.folder.display());
            Ok(())
        }),
        Command::Verify {
            quick,
            json,
            markdown,
        } => return verify::verify(quick, json, markdown),
        Command::Schema { markdown: true } => print(&reference::text()),
        Command::Schema { markdown: false } => print(&schema::text()),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "peristitch", &mut text);
            print(&String::from_utf8_lossy(&text))
        }
        Command::Man => {
            let mut text = Vec::new();
            let page = clap_mangen::Man::new(Cli::command()).render(&mut text);
            page.expect("memory takes everything");
            print(&String::from_utf8_lossy(&text))
        }
    };
    done.map_or_else(report, |()| ExitCode::SUCCESS)
}

/// A reader that has read enough, such as `head`, is no error.
fn print(text: &str) -> Result<(), RunError> {
    print!("{text}");
    Ok(())
}

/// Exit code after Ctrl-C, as shells give it.
const INTERRUPTED: u8 = 130;

/// Reads all pipelines before the first one acts, so that bad input stops everything.
fn for_each(common: &Common, act: impl Fn(&Plan) -> Result<(), RunError>) -> Result<(), RunError> {
    let plans = common.pipelines.iter();
    let plans: Vec<Plan> = plans
        .map(|pipeline| common.plan(pipeline))
        .collect::<Result<_, _>>()?;
    check_folders(&plans)?;
    plans.iter().try_for_each(act)
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

/// Exit code of a run that ends with this error.
fn code_of(error: &RunError) -> u8 {
    match error {
        RunError::Input(_) => 2,
        _ => 1,
    }
}

fn report(error: RunError) -> ExitCode {
    let code = code_of(&error);
    let report = match error {
        RunError::Input(error) => *error,
        failure => InputError::plain(with_causes(&failure), failure.help()),
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
