//! `peristitch watch`: a run whenever a file of a pipeline is saved.
//!
//! Each run is a process of its own, `peristitch run --brief`. A save while it goes kills it and starts
//! another: what a killed run leaves is the old result or an unfinished stage, never a half. The files are
//! looked at many times a second instead of asking the system to tell: that works in the same way for
//! editors that write in place, that write a new file and rename it, and that keep their files on
//! another machine; a dozen files cost nothing.

use super::{Common, INTERRUPTED, check_folders, report};
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;
use crate::pipeline::read::sources::sources;
use crate::pipeline::read::yaml;
use crate::pipeline::record::stamp::hash_file;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant, SystemTime};

/// How often the files are looked at. A save has ended when one look finds nothing new.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// The pipelines to watch, and the options of their runs.
struct Watch {
    pipelines: Vec<PathBuf>,
    /// Values of `--set`.
    overrides: Vec<String>,
    /// Further arguments of `run`.
    arguments: Vec<OsString>,
}

/// Runs every pipeline once, and again after each save, until `interrupts` tells of one. `may_run` is
/// asked before each run, and says what is wrong if it may not.
///
/// # Errors
/// The program cannot be started another time.
fn watch(watch: &Watch, interrupts: &Receiver<()>, may_run: impl Fn() -> bool) -> io::Result<()> {
    let program = std::env::current_exe()?;
    let pipelines = watch.pipelines.iter();
    let mut all: Vec<Watched> = pipelines.map(|path| Watched::new(path, watch)).collect();
    let mut running: Option<Running> = None;
    loop {
        // The first look finds what has changed since the pipelines were read: nothing.
        all.iter_mut().for_each(Watched::look);
        if interrupts.recv_timeout(LOOK_EVERY).is_ok() {
            return running.map_or(Ok(()), Running::end);
        }
        running = match running {
            Some(run) => run.go_on(&all)?,
            None => None,
        };
        if running.is_none()
            && let Some(index) = all.iter().position(Watched::is_due)
        {
            let saved = all[index].begin(watch);
            println!("\n{}: {}", all[index].pipeline.display(), saved.describe());
            if may_run() {
                let child = command(&program, &all[index].pipeline, watch).spawn()?;
                let since = saved.since;
                running = Some(Running {
                    index,
                    child,
                    since,
                });
            }
        }
    }
}

fn command(program: &Path, pipeline: &Path, watch: &Watch) -> Command {
    let mut command = Command::new(program);
    command.arg("run").arg(pipeline).args(["--brief", "--tied"]);
    command.args(&watch.arguments).stdin(Stdio::piped());
    command
}

/// A run that goes on.
struct Running {
    index: usize,
    child: Child,
    /// When the save was noticed.
    since: Instant,
}

impl Running {
    /// The run, if it still goes on.
    fn go_on(mut self, all: &[Watched]) -> io::Result<Option<Running>> {
        if all[self.index].saved.is_some() {
            self.end()?;
            println!("  stopped: a newer save");
            return Ok(None);
        }
        let Some(status) = self.child.try_wait()? else {
            return Ok(Some(self));
        };
        match ending(status) {
            None => println!(
                "  {:.2} s after the save",
                self.since.elapsed().as_secs_f64()
            ),
            Some(why) => println!("  {why}; the next save runs it again"),
        }
        Ok(None)
    }

    fn end(mut self) -> io::Result<()> {
        // An error here means that it has ended by itself.
        let _ = self.child.kill();
        self.child.wait().map(|_| ())
    }
}

/// Why there is no result.
fn ending(status: ExitStatus) -> Option<String> {
    match status.code() {
        Some(0) => None,
        Some(2) => Some("the input is wrong".to_owned()),
        Some(_) => Some("the computation failed".to_owned()),
        None => Some(format!("the run was ended from outside ({status})")),
    }
}

/// A pipeline and its files.
struct Watched {
    pipeline: PathBuf,
    files: BTreeMap<PathBuf, Seen>,
    /// The latest save that has not been run yet.
    saved: Option<Saved>,
    /// Whether the last look found nothing new.
    is_quiet: bool,
}

struct Saved {
    since: Instant,
    /// None: the first run.
    files: BTreeSet<PathBuf>,
}

impl Saved {
    fn describe(&self) -> String {
        if self.files.is_empty() {
            return "the first run".to_owned();
        }
        let names: Vec<String> = self.files.iter().map(|f| f.display().to_string()).collect();
        format!("{} saved", names.join(", "))
    }
}

impl Watched {
    fn new(pipeline: &Path, watch: &Watch) -> Watched {
        let mut watched = Watched {
            pipeline: pipeline.to_owned(),
            files: BTreeMap::new(),
            saved: Some(Saved {
                since: Instant::now(),
                files: BTreeSet::new(),
            }),
            is_quiet: true,
        };
        watched.find_sources(watch);
        watched
    }

    /// Files that are no longer named stay: a pipeline that is broken for a moment names none.
    fn find_sources(&mut self, watch: &Watch) {
        for file in sources(&self.pipeline, &watch.overrides) {
            let seen = Seen::now(&file);
            self.files.entry(file).or_insert(seen);
        }
    }

    fn look(&mut self) {
        let mut changed = BTreeSet::new();
        for (file, seen) in &mut self.files {
            if seen.changes(file) {
                changed.insert(file.clone());
            }
        }
        self.is_quiet = changed.is_empty();
        if !changed.is_empty() {
            let saved = self.saved.get_or_insert_with(|| Saved {
                since: Instant::now(),
                files: BTreeSet::new(),
            });
            saved.files.extend(changed);
        }
    }

    fn is_due(&self) -> bool {
        self.saved.is_some() && self.is_quiet
    }

    /// Returns the save for which a run begins. From here on a change is a new save.
    fn begin(&mut self, watch: &Watch) -> Saved {
        self.find_sources(watch);
        self.saved.take().expect("a run begins when one is due")
    }
}

/// A file as it was when last looked at. Its content counts; its time and size tell when to read it.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    times: Option<(SystemTime, u64)>,
    hash: Option<String>,
}

impl Seen {
    fn now(file: &Path) -> Seen {
        Seen {
            times: times(file),
            hash: hash_file(file),
        }
    }

    /// Whether the content is another one now.
    fn changes(&mut self, file: &Path) -> bool {
        if times(file) == self.times {
            return false;
        }
        let now = Seen::now(file);
        let changes = now.hash != self.hash;
        *self = now;
        changes
    }
}

fn times(file: &Path) -> Option<(SystemTime, u64)> {
    let metadata = std::fs::metadata(file).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

/// A pipeline that is wrong may become right, but it must be there.
pub(super) fn watch_all(common: Common, threads: Option<u16>) -> ExitCode {
    let missing = common.pipelines.iter().find(|pipeline| !pipeline.is_file());
    if let Some(Err(error)) = missing.map(|pipeline| common.plan(pipeline)) {
        return report(error);
    }
    if let Err(error) = yaml::parse_overrides(&common.overrides()) {
        return report(error.into());
    }
    let mut arguments: Vec<OsString> = Vec::new();
    let overrides = common.overrides();
    for value in &overrides {
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
    let watched = watch(
        &Watch {
            pipelines: common.pipelines.clone(),
            overrides,
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_save_is_a_new_content_however_it_is_written() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [file, other] = ["a.geo", "a.geo~"].map(|name| folder.path().join(name));
        fs::write(&file, "x = 1;").expect("writable");
        let mut seen = Seen::now(&file);
        assert!(!seen.changes(&file));
        fs::write(&file, "x = 22;").expect("writable");
        assert!(seen.changes(&file) && !seen.changes(&file));
        // By a rename, as many editors do.
        fs::write(&other, "x = 333;").expect("writable");
        fs::rename(&other, &file).expect("the same folder");
        assert!(seen.changes(&file));
        // The same content saved again.
        let later = SystemTime::now() + Duration::from_secs(5);
        let open = fs::File::options().append(true).open(&file);
        open.and_then(|file| file.set_modified(later))
            .expect("writable");
        assert!(!seen.changes(&file));
        fs::remove_file(&file).expect("there");
        assert!(seen.changes(&file) && !seen.changes(&file));
    }
}
