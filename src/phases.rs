//! The cost of a run: the wall time of each phase, and the peak memory of the whole.

use crate::trace::{Kind, Trace};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::cell::RefCell;
use std::time::{Duration, Instant};

/// One named phase.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Phase {
    pub name: Cow<'static, str>,
    /// Wall time of all its runs together.
    pub time: Duration,
    /// How often it ran.
    pub count: usize,
}

/// Phases in the order in which they first ran.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Phases {
    pub list: Vec<Phase>,
}

thread_local! {
    /// The phases that this thread collects now, and where their spans go.
    static COLLECTED: RefCell<Option<(Phases, Trace)>> = const { RefCell::new(None) };
}

/// Runs `work` and records how long it takes, if it runs inside of [`collect`] on the same thread.
pub fn measure<T>(name: &'static str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    let time = start.elapsed();
    COLLECTED.with_borrow_mut(|collected| {
        if let Some((phases, trace)) = collected {
            trace.record(Kind::Phase, name, start, time);
            phases.add(name, time, 1);
        }
    });
    result
}

/// Runs `work` and collects the phases that are measured on this thread meanwhile; each leaves a span in
/// `trace`.
pub fn collect<T>(trace: &Trace, work: impl FnOnce() -> T) -> (T, Phases) {
    let collecting = (Phases::default(), trace.clone());
    let outer = COLLECTED.replace(Some(collecting));
    let result = work();
    let collected = COLLECTED.replace(outer);
    let (phases, _) = collected.expect("each collection puts the one around it back");
    (result, phases)
}

impl Phases {
    /// The phases of [`crate::statics::solve`].
    pub const STATICS: [&'static str; 8] = [
        "support",
        "elements",
        "pattern",
        "ordering",
        "symbolic",
        "assembly",
        "factorisation",
        "solution",
    ];

    /// Name of the time that belongs to no other phase.
    pub const OTHER: &'static str = "other";

    /// Records `count` runs that took `time` together, at no particular moment.
    pub fn add(&mut self, name: impl Into<Cow<'static, str>>, time: Duration, count: usize) {
        let name = name.into();
        match self.list.iter_mut().find(|phase| phase.name == name) {
            Some(phase) => {
                // Times of a stored stage may be forged.
                phase.time = phase.time.saturating_add(time);
                phase.count = phase.count.saturating_add(count);
            }
            None => self.list.push(Phase { name, time, count }),
        }
    }

    /// Adds what others have recorded.
    pub fn append(&mut self, phases: impl IntoIterator<Item = Phase>) {
        for Phase { name, time, count } in phases {
            self.add(name, time, count);
        }
    }

    /// Records as [`Phases::OTHER`] what the phases leave of `whole`.
    pub fn complete(&mut self, whole: Duration) {
        let other = whole.saturating_sub(self.total());
        self.add(Phases::OTHER, other, 1);
    }

    pub fn total(&self) -> Duration {
        let times = self.list.iter().map(|phase| phase.time);
        times.fold(Duration::ZERO, Duration::saturating_add)
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

/// The address space that the process has reserved [bytes], where the system tells.
pub fn reserved_memory() -> Option<u64> {
    memory("VmSize:")
}

/// The memory that this process can have at most [bytes]: of the machine, or less in a container; where
/// the system tells.
pub fn machine_memory() -> Option<u64> {
    let machine = number_in("/proc/meminfo", "MemTotal:");
    let group = ["memory.max", "memory/memory.limit_in_bytes"]
        .iter()
        .find_map(|file| {
            let text = std::fs::read_to_string(format!("/sys/fs/cgroup/{file}")).ok()?;
            text.trim().parse().ok()
        });
    machine.into_iter().chain(group).min()
}

fn memory(key: &str) -> Option<u64> {
    number_in("/proc/self/status", key)
}

fn number_in(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collection_holds_the_phases_measured_inside_of_it_on_its_thread() {
        let trace = Trace::default();
        measure("before", || ());
        let (inner, outer) = collect(&trace, || {
            measure("assembly", || ());
            let (_, inner) = collect(&trace, || measure("solution", || ()));
            std::thread::scope(|scope| {
                scope.spawn(|| measure("elsewhere", || ()));
            });
            measure("assembly", || ());
            inner
        });
        let told = |phases: Phases| -> Vec<(String, usize)> {
            let list = phases.list.into_iter();
            list.map(|phase| (phase.name.into_owned(), phase.count))
                .collect()
        };
        assert_eq!(told(inner), [("solution".to_owned(), 1)]);
        assert_eq!(told(outer), [("assembly".to_owned(), 2)]);
    }

    #[test]
    fn phases_add_up_to_the_whole() {
        let mut phases = Phases::default();
        let seconds = Duration::from_secs;
        phases.add("assembly", seconds(2), 3);
        phases.add("assembly", seconds(1), 1);
        phases.complete(seconds(5));
        let told = |phase: &Phase| (phase.name.to_string(), phase.time, phase.count);
        let list: Vec<_> = phases.list.iter().map(told).collect();
        assert_eq!(
            list,
            [
                ("assembly".to_owned(), seconds(3), 4),
                ("other".to_owned(), seconds(2), 1)
            ]
        );
        assert_eq!(phases.total(), seconds(5));
    }
}
