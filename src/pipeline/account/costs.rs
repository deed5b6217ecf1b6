//! Costs of a run: times of its phases, bytes of its files, memory. A stage's manifest keeps its share for
//! the summary of a later run, which finds the stage fresh.

use super::summary::{CostSummary, FilesSummary, MemorySummary, PhaseSummary, WrittenSummary};
use super::written_file::WrittenFile;
use crate::phases::{Phase, Phases};
use crate::statics::SystemSize;
use serde::{Deserialize, Serialize};

/// Costs of a stage, or of several.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Costs {
    /// One after the other: they sum to the time of the stages.
    pub phases: Phases,
    /// On other threads, meanwhile.
    pub behind: Phases,
    /// The frames that the solve has written.
    pub frames: Option<FilesSummary>,
    /// Results of the output stage. No manifest keeps them: a fresh output stage has its summary.
    #[serde(skip)]
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn every_phase_of_a_stage_comes_back_whatever_its_name() {
        let mut costs = Costs {
            peak_memory: Some(7),
            ..Costs::default()
        };
        let time = Duration::from_millis(250);
        costs.phases.add("active zone", time, 3);
        costs.behind.add("frames", time, 5);
        let kept = serde_json::to_string(&costs).expect("plain data");
        let restored: Costs = serde_json::from_str(&kept).expect("what was kept");
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
