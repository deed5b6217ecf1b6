//! A study as a Makefile or a Snakefile: the same runs, handed out by GNU make or by Snakemake.
//!
//! Every job is a plain `peristitch run` with the values of its run, and the last one collects the table.
//! Both engines go by times of files, peristitch by their content: a job that they start in vain does nothing.

use super::sweep::{Run, Study};
use super::table::{LOG_FOLDER, TABLE_FILE};
use crate::pipeline::account::summary::SUMMARY_FILE;
use crate::pipeline::read::source::InputError;
use crate::pipeline::read::sources::sources;
use serde_json::json;
use std::fmt::Write;
use std::path::Path;

/// The settings of a job besides the study: the program, and the `--results` and `--set` of the command
/// line.
pub struct Job<'a> {
    pub program: &'a Path,
    pub overrides: &'a [String],
    pub results: Option<&'a Path>,
    pub threads: usize,
}

/// The text of a Makefile.
///
/// # Errors
/// A path that make cannot name.
pub fn makefile(study: &Study, job: &Job) -> Result<String, InputError> {
    let folder = study.folder.display().to_string();
    let files: Vec<String> = inputs(study, job);
    let paths = files.iter().chain([&folder]);
    let hard =
        |c: char| c.is_whitespace() || matches!(c, ':' | '$' | '#' | '%' | '=' | '\\' | ';' | '\'');
    if let Some(path) = paths.into_iter().find(|path| path.contains(hard)) {
        let message = format!("make cannot name the path `{path}`");
        let help = "use a folder without blanks and `:$#%=\\;'` in its name, `--results FOLDER`, or \
                    `--snakemake`";
        return Err(InputError::plain(message, Some(help.to_owned())));
    }
    let mut text = format!(
        "# The runs of {}; made by `peristitch plan`.\n\
         # make -k -j2 -f THIS_FILE\n\n\
         PERISTITCH ?= {}\n\
         FOLDER := {folder}\n\
         INPUTS := {}\n\
         RUNS :=",
        study.pipeline.display(),
        in_make(&shell(&job.program.display().to_string())),
        files.join(" ")
    );
    for run in &study.runs {
        let _ = write!(text, " \\\n  {}", run.name);
    }
    let _ = write!(
        text,
        "\n\n$(FOLDER)/{TABLE_FILE}: $(RUNS:%=$(FOLDER)/%/{SUMMARY_FILE})\n\
         \t$(PERISTITCH) sweep {} --collect\n\n\
         $(RUNS:%=$(FOLDER)/%/{SUMMARY_FILE}): $(INPUTS)\n\
         \t@mkdir -p $(FOLDER)/{LOG_FOLDER}\n\
         \t$(PERISTITCH) run {} --brief --threads {} --results $(FOLDER) $(SET) \\\n\
         \t  > $(FOLDER)/{LOG_FOLDER}/$(notdir $(@D)).txt 2>&1\n\
         \t@touch $@\n\n",
        in_make(&common(study, job)),
        in_make(&shell(&study.pipeline.display().to_string())),
        job.threads
    );
    for run in &study.runs {
        let _ = writeln!(
            text,
            "$(FOLDER)/{}/{SUMMARY_FILE}: SET = {}",
            run.name,
            in_make(&sets(run))
        );
    }
    Ok(text)
}

/// The text of a Snakefile. `megabytes`: what each run is expected to take.
pub fn snakefile(study: &Study, job: &Job, megabytes: &[u64]) -> String {
    let runs = study.runs.iter().zip(megabytes);
    let runs: serde_json::Map<_, _> = runs
        .map(|(run, mb)| (run.name.clone(), json!({ "set": sets(run), "mem_mb": mb })))
        .collect();
    let folder = study.folder.display().to_string();
    let text = |text: &str| json!(text).to_string();
    let in_braces = |text: String| json!(text.replace('{', "{{").replace('}', "}}")).to_string();
    let program = shell(&job.program.display().to_string());
    let pipeline = shell(&study.pipeline.display().to_string());
    format!(
        "# The runs of {pipeline_path}; made by `peristitch plan`.\n\
         # snakemake --keep-going --cores 2 --snakefile THIS_FILE\n\
         import os\n\n\
         PERISTITCH = os.environ.get(\"PERISTITCH\", {program})\n\
         FOLDER = {folder}\n\
         INPUTS = {inputs}\n\
         RUNS = {runs:#}\n\n\n\
         rule all:\n    input: FOLDER + \"/{TABLE_FILE}\"\n\n\n\
         rule run:\n    \
             input: INPUTS\n    \
             output: FOLDER + \"/{{run}}/{SUMMARY_FILE}\"\n    \
             log: FOLDER + \"/{LOG_FOLDER}/{{run}}.txt\"\n    \
             params:\n        \
                 peristitch=PERISTITCH,\n        \
                 folder=FOLDER,\n        \
                 set=lambda wildcards: RUNS[wildcards.run][\"set\"],\n    \
             threads: {threads}\n    \
             resources: mem_mb=lambda wildcards: RUNS[wildcards.run][\"mem_mb\"]\n    \
             shell:\n        \
                 \"{{params.peristitch}} run \" {pipeline} \" --brief --threads {{threads}} --results {{params.folder:q}}\"\n        \
                 \" {{params.set}} > {{log:q}} 2>&1\"\n\n\n\
         rule collect:\n    \
             input: expand(FOLDER + \"/{{run}}/{SUMMARY_FILE}\", run=RUNS)\n    \
             output: FOLDER + \"/{TABLE_FILE}\"\n    \
             params: peristitch=PERISTITCH\n    \
             shell: \"{{params.peristitch}} sweep \" {common} \" --collect\"\n",
        pipeline_path = study.pipeline.display(),
        program = text(&program),
        folder = text(&folder),
        inputs = json!(inputs(study, job)),
        runs = serde_json::Value::Object(runs),
        threads = job.threads,
        pipeline = in_braces(pipeline),
        common = in_braces(common(study, job)),
    )
}

/// The pipeline file, its geometry and what that includes.
fn inputs(study: &Study, job: &Job) -> Vec<String> {
    let files = sources(&study.pipeline, job.overrides).into_iter();
    files.map(|file| file.display().to_string()).collect()
}

/// The arguments that name the study, for the shell.
fn common(study: &Study, job: &Job) -> String {
    let mut arguments = vec![shell(&study.pipeline.display().to_string())];
    for value in job.overrides {
        arguments.push(format!("--set {}", shell(value)));
    }
    if let Some(results) = job.results {
        arguments.push(format!(
            "--results {}",
            shell(&results.display().to_string())
        ));
    }
    arguments.join(" ")
}

fn sets(run: &Run) -> String {
    let sets = run
        .overrides
        .iter()
        .map(|set| format!("--set {}", shell(set)));
    sets.collect::<Vec<_>>().join(" ")
}

/// A word of the shell: quoted unless it is plain.
fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./=,+:@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// A text of a Makefile.
fn in_make(text: &str) -> String {
    text.replace('$', "$$").replace('#', r"\#")
}
