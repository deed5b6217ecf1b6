//! What a run costs: the wall time of each phase, and the most memory that the whole has held.

use std::time::{Duration, Instant};

/// One named phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    pub name: &'static str,
    /// Of all its runs together.
    pub time: Duration,
    /// How often it ran.
    pub count: usize,
}

/// Phases in the order in which they first ran.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    pub list: Vec<Phase>,
}

impl Phases {
    /// The phases of [`crate::statics::solve`].
    pub const STATICS: [&'static str; 14] = [
        "support",
        "elements",
        "pattern",
        "ordering",
        "symbolic",
        "assembly",
        "supports",
        "factorisation",
        "solution",
        "active zone",
        "stretches",
        "loose parts",
        "compliance",
        "update",
    ];

    /// Runs `work` and records how long it takes.
    pub fn measure<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(name, start.elapsed(), 1);
        result
    }

    /// Records `count` runs that took `time` together.
    pub fn add(&mut self, name: &'static str, time: Duration, count: usize) {
        match self.list.iter_mut().find(|phase| phase.name == name) {
            Some(phase) => {
                phase.time += time;
                phase.count += count;
            }
            None => self.list.push(Phase { name, time, count }),
        }
    }

    pub fn total(&self) -> Duration {
        self.list.iter().map(|phase| phase.time).sum()
    }
}

/// The most memory that the process has held so far [bytes], where the system tells.
pub fn peak_memory() -> Option<u64> {
    memory("VmHWM:")
}

/// The memory that the process holds now [bytes], where the system tells.
pub fn held_memory() -> Option<u64> {
    memory("VmRSS:")
}

fn memory(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(key))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kilobytes)
}
