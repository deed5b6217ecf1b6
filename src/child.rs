//! A child process that reads one line of JSON, works, and leaves its result in a file: Gmsh and meshio run in
//! such ones, so that a crash or a runaway there becomes an error here.
//!
//! The line goes to its standard input, which stays open until it ends: it exits when that pipe does, and so
//! never outlives its parent. Its log goes to a file, not a pipe: a process that it starts could hold a pipe
//! open for ever.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Number of the log's last lines that are kept.
const LOG_LINES: usize = 20;
/// Length of the log's end that is read to find them [bytes].
const LOG_TAIL: u64 = 64 * 1024;
/// A log longer than this is a loop that writes [bytes].
pub const LONGEST_LOG: u64 = 64_000_000;
/// Interval at which the process is polled.
const POLL: Duration = Duration::from_millis(5);

/// The end of a process.
pub enum End {
    Exit(ExitStatus),
    TimeLimit,
    /// It was stopped since its log grew beyond [`LONGEST_LOG`].
    Flood,
}

/// The process could not be run.
#[derive(Debug)]
pub struct ChildError {
    pub action: &'static str,
    pub source: io::Error,
}

/// The running process: killed if it is dropped before it has ended.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail only if it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs `command` to its end, with `message` and an end-of-line as its input.
///
/// # Errors
/// A log that cannot be created, a command that cannot be started.
pub fn run(
    command: &mut Command,
    message: &[u8],
    log_file: &Path,
    limit: Duration,
) -> Result<End, ChildError> {
    let error = |action| move |source| ChildError { action, source };
    let log = File::create(log_file).map_err(error("create the log"))?;
    let errors = log.try_clone().map_err(error("create the log"))?;
    let mut running = command
        .stdin(Stdio::piped())
        .stdout(log)
        .stderr(errors)
        .spawn()
        .map(Running)
        .map_err(error("start it"))?;
    let mut input = running.0.stdin.take().expect("it was piped");
    // A process that cannot be written to has ended: its exit status says more.
    let _ = input
        .write_all(message)
        .and_then(|()| input.write_all(b"\n"));
    let end = wait(&mut running.0, log_file, limit).map_err(error("wait for it"));
    drop(input);
    end
}

fn wait(child: &mut Child, log: &Path, limit: Duration) -> io::Result<End> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(End::Exit(status));
        }
        if start.elapsed() >= limit {
            return Ok(End::TimeLimit);
        }
        if log.metadata().is_ok_and(|log| log.len() > LONGEST_LOG) {
            return Ok(End::Flood);
        }
        std::thread::sleep(POLL);
    }
}

/// The log's last lines; fewer, or none, if it cannot be read.
pub fn last_lines(log: &Path) -> Vec<String> {
    let mut bytes = Vec::new();
    let read = File::open(log).and_then(|mut file| {
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(LOG_TAIL)))?;
        file.read_to_end(&mut bytes)
    });
    if read.is_err() {
        return Vec::new();
    }
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.split(['\n', '\r']).map(str::trim_end);
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    let first = lines.len().saturating_sub(LOG_LINES);
    lines[first..]
        .iter()
        .map(|line| (*line).to_owned())
        .collect()
}

pub fn describe(status: ExitStatus) -> String {
    match (status.signal(), status.code()) {
        (Some(6), _) => "signal 6, abort".to_owned(),
        (Some(9), _) => "signal 9, killed: out of memory?".to_owned(),
        (Some(11), _) => "signal 11, segmentation fault".to_owned(),
        (Some(signal), _) => format!("signal {signal}"),
        (None, code) => format!("exit code {}", code.unwrap_or_default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_lines_of_the_log_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("log");
        let text: String = (0..10_000).map(|i| format!("line {i}\r\n\n")).collect();
        std::fs::write(&log, text).unwrap();
        let lines = last_lines(&log);
        assert_eq!(lines.len(), LOG_LINES);
        assert_eq!(lines.last().map(String::as_str), Some("line 9999"));
        assert!(last_lines(&folder.path().join("absent")).is_empty());
    }
}
