//! What a run costs: times of its phases, bytes of its files, memory; and how a stage's share of that is
//! kept for the summary of a later run, which finds the stage fresh.

use super::summary::{CostSummary, FilesSummary, MemorySummary, PhaseSummary, WrittenSummary};
use super::written_file::WrittenFile;
use crate::phases::{Phase, Phases};
use crate::statics::SystemSize;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Of a stage, or of several.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    /// One after the other: they sum to the time of the stages.
    pub phases: Phases,
    /// On other threads, meanwhile.
    pub behind: Phases,
    /// The frames that the solve has written.
    pub frames: Option<FilesSummary>,
    /// Results of the output stage.
    pub made: Vec<WrittenFile>,
    /// The most memory that the process had held by then [bytes].
    pub peak_memory: Option<u64>,
}

impl Costs {
    pub(crate) fn append(&mut self, costs: Costs) {
        self.phases.append(costs.phases.list);
        self.behind.append(costs.behind.list);
        self.frames = costs.frames.or(self.frames.take());
        self.made.extend(costs.made);
        self.peak_memory = self.peak_memory.max(costs.peak_memory);
    }

    pub(crate) fn summary(&self, size: SystemSize) -> CostSummary {
        let whole = self.phases.total().as_secs_f64();
        let list = |phases: &Phases| {
            let entry = |phase: &Phase| PhaseSummary {
                phase: phase.name.to_string(),
                count: phase.count,
                seconds: phase.time.as_secs_f64(),
                share: phase.time.as_secs_f64() / whole,
            };
            phases.list.iter().map(entry).collect()
        };
        CostSummary {
            phases: list(&self.phases),
            seconds: whole,
            behind: list(&self.behind),
            written: WrittenSummary {
                vtu: FilesSummary::new(&self.made, ".vtu"),
                pictures: FilesSummary::new(&self.made, ".png"),
                frames: self.frames.clone(),
            },
            memory: self.memory(size),
            peak_memory_bytes: self.peak_memory,
        }
    }

    fn memory(&self, size: SystemSize) -> MemorySummary {
        let factor = (size_of::<f64>() * size.factor_entries) as u64;
        // A system without entries of L has no such ratio.
        let ratio = |peak: u64| (factor > 0).then_some(peak as f64 / factor as f64);
        MemorySummary {
            peak_bytes: self.peak_memory,
            factor_bytes: factor,
            peak_over_factor: self.peak_memory.and_then(ratio),
        }
    }
}

/// What a manifest keeps of a stage's costs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredCosts {
    phases: Vec<StoredPhase>,
    behind: Vec<StoredPhase>,
    frames: Option<FilesSummary>,
    peak_memory: Option<u64>,
}

/// Name, seconds, how often.
type StoredPhase = (String, f64, usize);

impl From<&Costs> for StoredCosts {
    fn from(costs: &Costs) -> StoredCosts {
        let stored = |phases: &Phases| {
            let list = phases.list.iter();
            list.map(|p| (p.name.to_string(), p.time.as_secs_f64(), p.count))
                .collect()
        };
        StoredCosts {
            phases: stored(&costs.phases),
            behind: stored(&costs.behind),
            frames: costs.frames.clone(),
            peak_memory: costs.peak_memory,
        }
    }
}

impl From<StoredCosts> for Costs {
    fn from(stored: StoredCosts) -> Costs {
        let phases = |stored: Vec<StoredPhase>| {
            let mut phases = Phases::default();
            phases.append(stored.into_iter().map(|(name, seconds, count)| Phase {
                name: name.into(),
                time: Duration::try_from_secs_f64(seconds).unwrap_or_default(),
                count,
            }));
            phases
        };
        Costs {
            phases: phases(stored.phases),
            behind: phases(stored.behind),
            frames: stored.frames,
            peak_memory: stored.peak_memory,
            ..Costs::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_of_a_stage_comes_back_whatever_its_name() {
        let mut costs = Costs {
            peak_memory: Some(7),
            ..Costs::default()
        };
        let time = Duration::from_millis(250);
        costs.phases.add("active zone", time, 3);
        costs.behind.add("frames", time, 5);
        let restored = Costs::from(StoredCosts::from(&costs));
        assert_eq!(restored.phases.list, costs.phases.list);
        assert_eq!(restored.behind.list, costs.behind.list);
        assert_eq!(restored.peak_memory, Some(7));
    }

    #[test]
    fn memory_stands_beside_the_factor() {
        let costs = Costs {
            peak_memory: Some(1200),
            ..Costs::default()
        };
        let size = SystemSize {
            dofs: 10,
            stiffness_entries: 40,
            factor_entries: 100,
            backend: crate::statics::Backend::Multifrontal,
        };
        let memory = costs.memory(size);
        assert_eq!((memory.factor_bytes, memory.peak_bytes), (800, Some(1200)));
        assert_eq!(memory.peak_over_factor, Some(1.5));
    }
}
