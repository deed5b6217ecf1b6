//! `peristitch sweep`: the runs of a study, several at a time within the machine's memory.
//!
//! Each run is a process of its own, `peristitch run`; its messages go to a file of its own. A run that
//! fails does not stop the others. What is fresh does not run: a sweep that was ended goes on.

use crate::pipeline::error::RunError;
use crate::pipeline::stages::run::{self, Options};
use crate::pipeline::study::sweep::{Run, Study};
use crate::pipeline::study::table::{LOG_FOLDER, Row, Status, log_file, row};
use crate::statics::Estimate;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fs::{self, File};
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How to run a study.
pub(super) struct Settings {
    /// Runs at a time.
    pub jobs: usize,
    /// Threads of each.
    pub threads: usize,
    pub force: bool,
}

/// Share of the free memory that runs may be expected to take together.
const MEMORY_SHARE: f64 = 0.8;

/// How often a run is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Runs what is not fresh of `chosen` runs; `None` if it was interrupted.
///
/// # Errors
/// The log folder cannot be made, or the program cannot be started.
pub(super) fn sweep(
    study: &Study,
    chosen: &[usize],
    settings: &Settings,
    interrupted: &AtomicBool,
) -> Result<Option<()>, RunError> {
    let logs = study.folder.join(LOG_FOLDER);
    fs::create_dir_all(&logs).map_err(|source| file_error("make", &logs, source))?;
    let program = std::env::current_exe()
        .map_err(|source| file_error("find", Path::new("peristitch"), source))?;
    let sweep = Sweep {
        study,
        settings,
        program,
        memory: Memory::new(free_memory().map_or(f64::INFINITY, |free| MEMORY_SHARE * free)),
        progress: progress(chosen.len()),
        interrupted,
    };
    let next = AtomicUsize::new(0);
    let first_error = Mutex::new(None);
    std::thread::scope(|scope| {
        for _ in 0..settings.jobs.min(chosen.len()) {
            scope.spawn(|| {
                while let Some(&index) = chosen.get(next.fetch_add(1, Ordering::Relaxed))
                    && !interrupted.load(Ordering::Relaxed)
                {
                    if let Err(error) = sweep.run(&study.runs[index]) {
                        let mut first = first_error.lock().unwrap_or_else(PoisonError::into_inner);
                        first.get_or_insert(error);
                        return;
                    }
                }
            });
        }
    });
    sweep.progress.finish_and_clear();
    match first_error
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner)
    {
        Some(error) => Err(error),
        None => Ok((!interrupted.load(Ordering::Relaxed)).then_some(())),
    }
}

struct Sweep<'a> {
    study: &'a Study,
    settings: &'a Settings,
    program: PathBuf,
    memory: Memory,
    progress: ProgressBar,
    interrupted: &'a AtomicBool,
}

impl Sweep<'_> {
    fn run(&self, run: &Run) -> Result<(), RunError> {
        let start = Instant::now();
        // What cannot be read or meshed fails as a run, with its message in the log.
        let is_done = || {
            matches!(
                row(self.study, run),
                Ok(Row {
                    status: Status::Done,
                    ..
                })
            )
        };
        if !self.settings.force && is_done() {
            // Of a sweep that was killed when this run had just ended.
            let _ = fs::remove_file(log_file(self.study, run));
            self.tell(run, "fresh");
            return Ok(());
        }
        let log = log_file(self.study, run);
        let until_mesh = self.child(run, &log, &["--until", "mesh"])?;
        if until_mesh == Some(true)
            && let Ok(estimate) = estimate(run)
        {
            let _held = self.memory.take(estimate.bytes as f64);
            self.child(run, &log, &[])?;
        }
        if self.interrupted.load(Ordering::Relaxed) {
            return Ok(());
        }
        let seconds = start.elapsed().as_secs_f64();
        let text = match row(self.study, run) {
            Ok(done) if done.status == Status::Done => {
                let _ = fs::remove_file(&log);
                let outcome = done.result("outcome").and_then(|outcome| outcome.as_str());
                format!("{seconds:.1} s  {}", outcome.unwrap_or("done"))
            }
            Ok(Row {
                status: Status::Failed(message),
                ..
            }) => format!("failed: {message}"),
            _ => format!("failed: see {}", log.display()),
        };
        self.tell(run, &text);
        Ok(())
    }

    /// Whether the process ended well; `None` if it was interrupted.
    fn child(&self, run: &Run, log: &Path, more: &[&str]) -> Result<Option<bool>, RunError> {
        let file = File::create(log).map_err(|source| file_error("write", log, source))?;
        let copy = file
            .try_clone()
            .map_err(|source| file_error("write", log, source))?;
        let mut command = Command::new(&self.program);
        command
            .arg("run")
            .arg(&self.study.pipeline)
            .arg("--brief")
            .arg("--tied");
        command.arg("--results").arg(&self.study.folder);
        command.args(["--threads", &self.settings.threads.to_string()]);
        for set in &run.overrides {
            command.arg("--set").arg(set);
        }
        if self.settings.force && more.is_empty() {
            command.arg("--force");
        }
        command
            .args(more)
            .stdin(Stdio::piped())
            .stdout(copy)
            .stderr(file);
        let mut child = command
            .spawn()
            .map_err(|source| file_error("start", &self.program, source))?;
        wait(&mut child, self.interrupted)
            .map_err(|source| file_error("wait for", &self.program, source))
    }

    fn tell(&self, run: &Run, text: &str) {
        let line = || eprintln!("{:<40}  {text}", run.name);
        self.progress.suspend(line);
        self.progress.inc(1);
    }
}

fn wait(child: &mut Child, interrupted: &AtomicBool) -> io::Result<Option<bool>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status.success()));
        }
        if interrupted.load(Ordering::Relaxed) {
            // An error here means that it has ended by itself.
            let _ = child.kill();
            return child.wait().map(|_| None);
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

fn estimate(run: &Run) -> Result<Estimate, RunError> {
    let (model, boundary, _) = run::discretised(&run.plan, &Options::default())?;
    Ok(Estimate::new(&model, &boundary, None, run.plan.breaks())?)
}

fn file_error(action: &'static str, path: &Path, source: io::Error) -> RunError {
    RunError::File {
        action,
        path: path.to_owned(),
        source,
    }
}

fn progress(runs: usize) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(runs as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} runs, {elapsed}, {eta} to go");
    bar.set_style(style.expect("the template is well formed"));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Memory that the system says can be had [bytes].
fn free_memory() -> Option<f64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(1024.0 * kilobytes)
}

/// The memory that runs are expected to take: a run that would take too much waits, unless no other run
/// holds any.
struct Memory {
    limit: f64,
    taken: Mutex<f64>,
    freed: Condvar,
}

struct Held<'a> {
    memory: &'a Memory,
    bytes: f64,
}

impl Memory {
    fn new(limit: f64) -> Memory {
        Memory {
            limit,
            taken: Mutex::new(0.0),
            freed: Condvar::new(),
        }
    }

    fn take(&self, bytes: f64) -> Held<'_> {
        let taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let is_too_much = |taken: &mut f64| *taken > 0.0 && *taken + bytes > self.limit;
        let taken = self.freed.wait_while(taken, is_too_much);
        *taken.unwrap_or_else(PoisonError::into_inner) += bytes;
        Held {
            memory: self,
            bytes,
        }
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        let mut taken = self
            .memory
            .taken
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *taken -= self.bytes;
        // Rounding must not keep an empty account from being empty.
        if *taken < 1.0 {
            *taken = 0.0;
        }
        self.memory.freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_would_take_too_much_waits_until_there_is_room() {
        let memory = Memory::new(10.0);
        let most = Mutex::new(0.0_f64);
        std::thread::scope(|scope| {
            for k in 0..20 {
                let (memory, most) = (&memory, &most);
                scope.spawn(move || {
                    // Alone, even one that is too large runs.
                    let _held = memory.take(if k == 7 { 12.0 } else { 4.0 });
                    let taken = *memory.taken.lock().expect("no panic");
                    let mut most = most.lock().expect("no panic");
                    *most = most.max(taken);
                    std::thread::sleep(Duration::from_millis(1));
                });
            }
        });
        assert_eq!(*memory.taken.lock().expect("no panic"), 0.0);
        let most = *most.lock().expect("no panic");
        assert!(most == 12.0 || most == 8.0, "{most}");
    }

    #[test]
    fn the_system_tells_its_memory() {
        let free = free_memory().expect("Linux");
        assert!(free > 1e7 && free < 1e15, "{free}");
    }
}
