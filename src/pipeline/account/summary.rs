//! `summary.json`: what a run has computed and what it has cost. The fields are the keys of the file.

use super::written_file::WrittenFile;
use crate::pipeline::read::spec::{Control, ReferenceSteps};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

pub const SUMMARY_FILE: &str = "summary.json";

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    pub name: String,
    /// Name of the study that the run belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<String>,
    /// Path of the pipeline file.
    pub pipeline: String,
    /// `solved`, or how a fracture run ended.
    pub outcome: String,
    pub fracture: Option<FractureSummary>,
    /// Versions of this program and of the one that the mesh comes from.
    pub versions: BTreeMap<String, String>,
    /// Parameters of the geometry, as it was meshed.
    pub parameters: BTreeMap<String, Value>,
    pub sizes: Sizes,
    pub lattices: Vec<LatticeSummary>,
    pub interfaces: Vec<InterfaceSummary>,
    pub probes: Vec<ProbeSummary>,
    /// Resultant on each group that prescribes displacements [N].
    pub reactions_n: BTreeMap<String, [f64; 2]>,
    /// Warnings of all stages, each once.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Relative residual of the last solve [-].
    pub residual: f64,
    #[serde(flatten)]
    pub costs: CostSummary,
    /// Results of the output stage.
    pub files: Vec<String>,
}

/// Onset, peak and end of a fracture run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FractureSummary {
    pub driven_by: DrivenBy,
    pub first_break: Option<Event>,
    pub peak: Option<Event>,
    pub end: Option<Event>,
    /// Share of the largest force along the prescribed displacements that is left at the end [-]: what decides
    /// whether the body is separated.
    pub force_left: Option<f64>,
    pub control: Option<Control>,
    /// Why there was no solution any more, where the run ended so.
    pub stopped_because: Option<String>,
    /// Number of nodes of each part that has come off.
    pub fragments: Vec<usize>,
    /// Names of the phases of the load programme.
    pub phases: Option<Vec<String>>,
    /// The largest λ of the last phase: there, a load that only grows would have broken the body.
    pub envelope_peak: Option<Event>,
    pub bonds_broken: usize,
    pub crack_length_m: Option<f64>,
    pub largest_residual: f64,
    /// Steps that have a frame.
    pub frames: Vec<usize>,
    pub reference: Option<ReferenceSteps>,
}

/// A step of a fracture run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Event {
    pub step: usize,
    pub load_factor: f64,
    pub grip_displacement_m: f64,
    /// Largest resultant on a group with prescribed displacements; of the first break that under which the bond
    /// broke.
    pub reaction_n: f64,
    /// Sum of the amounts of all nodal forces, where only forces load the body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_n: Option<f64>,
    /// Middle of the bond that broke first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_m: Option<[f64; 2]>,
}

/// The kind of load on the body in a fracture run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DrivenBy {
    Displacements,
    /// No boundary moves, and the reactions of supports may be rounding: the load is λ.
    Forces,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Sizes {
    pub finite_elements: usize,
    pub finite_element_nodes: usize,
    pub material_points: usize,
    pub bonds: usize,
    pub trusses: usize,
    pub clipped_bonds: usize,
    pub dofs: usize,
    pub stiffness_entries: usize,
    /// Solver of the system, in words.
    pub method: String,
    pub factor_entries: usize,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LatticeSummary {
    /// Names of the regions that the lattice covers.
    pub region: String,
    pub points: usize,
    pub spacing_m: f64,
    pub horizon_m: f64,
    pub points_area_m2: f64,
    pub region_area_m2: f64,
}

/// An interface of finite elements and material points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct InterfaceSummary {
    pub finite_elements: String,
    pub peridynamics: String,
    pub edges: usize,
    pub length_m: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ProbeSummary {
    pub name: String,
    /// `x` or `y`.
    pub component: String,
    /// Position of the node that is read.
    pub at_m: [f64; 2],
    /// Position of the second node, less the displacement of the first one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_m: Option<[f64; 2]>,
    /// The largest distance of these nodes from the points of the pipeline.
    #[serde(default)]
    pub distance_m: f64,
    pub displacement_m: f64,
    pub reference_m: Option<f64>,
    /// Relative error against the reference [-].
    pub error: Option<f64>,
}

/// Times, files and memory of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CostSummary {
    /// One after the other: they sum to `seconds`.
    pub phases: Vec<PhaseSummary>,
    pub seconds: f64,
    /// Phases of other threads, meanwhile.
    pub behind: Vec<PhaseSummary>,
    pub written: WrittenSummary,
    pub memory: MemorySummary,
    pub peak_memory_bytes: Option<u64>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PhaseSummary {
    pub phase: String,
    pub count: usize,
    pub seconds: f64,
    /// Share of the time of all stages [-].
    pub share: f64,
}

/// Files on the disk.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WrittenSummary {
    pub vtu: FilesSummary,
    pub pictures: FilesSummary,
    pub frames: Option<FilesSummary>,
}

/// Files of one kind together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilesSummary {
    pub files: usize,
    /// Bytes of the numbers in them, as they are in memory.
    pub raw_bytes: u64,
    pub bytes: u64,
    pub ratio: Option<f64>,
    /// Time of one thread: computing, packing, writing.
    pub seconds: f64,
    pub megabytes_per_second: Option<f64>,
}

impl FilesSummary {
    /// Sums files whose names end so.
    pub(crate) fn new(made: &[WrittenFile], ending: &str) -> FilesSummary {
        let files = || made.iter().filter(|made| made.name.ends_with(ending));
        let raw_bytes = files().map(|made| made.raw_bytes).sum();
        let bytes = files().map(|made| made.bytes).sum();
        let time: Duration = files().map(|made| made.time).sum();
        let seconds = time.as_secs_f64();
        // No file, no rate.
        let over = |a: f64, b: f64| (b > 0.0).then_some(a / b);
        FilesSummary {
            files: files().count(),
            raw_bytes,
            bytes,
            ratio: over(bytes as f64, raw_bytes as f64),
            seconds,
            megabytes_per_second: over(raw_bytes as f64 / 1e6, seconds),
        }
    }
}

/// The most memory that the process had held, beside that of one factor L.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MemorySummary {
    pub peak_bytes: Option<u64>,
    pub factor_bytes: u64,
    pub peak_over_factor: Option<f64>,
}

/// The summary of the last finished run.
pub fn read_summary(folder: &Path) -> Option<Summary> {
    serde_json::from_slice(&fs::read(folder.join(SUMMARY_FILE)).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_a_ratio_and_a_rate_where_there_are_any() {
        let made = |name: &str, raw_bytes, bytes| WrittenFile {
            name: name.to_owned(),
            raw_bytes,
            bytes,
            time: Duration::from_millis(500),
        };
        let made = [
            made("a.vtu", 6_000_000, 2_000_000),
            made("b.vtu", 2_000_000, 2_000_000),
        ];
        let vtu = FilesSummary::new(&made, ".vtu");
        assert_eq!((vtu.files, vtu.bytes), (2, 4_000_000));
        assert_eq!(
            [vtu.ratio, vtu.megabytes_per_second],
            [Some(0.5), Some(8.0)]
        );
        let none = FilesSummary::new(&made, ".png");
        assert_eq!([none.ratio, none.megabytes_per_second], [None, None]);
    }
}
