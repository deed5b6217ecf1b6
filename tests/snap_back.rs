//! A compact tension specimen on soft straps, `pipelines/compact_tension.yaml`: the crack grows while
//! the grips go back, which no programme of growing displacements can follow.
//!
//! Load at which a crack of length a grows, P = K_IC B √W / f(a/W), K_IC = √(E G0) in plane stress, with
//! f of ASTM E399 (Srawley 1976, Int. J. Fracture 12, 475–476: ± 0.5 % for a/W ≥ 0.2):
//!
//! f(α) = (2 + α)(0.886 + 4.64α − 13.32α² + 14.72α³ − 5.6α⁴) / (1 − α)^1.5
//!
//! On a lattice the crack advances by spacings, and is held between them (lattice trapping): the load
//! goes up and down by some 12 % of its middle, the figure of the plate with a centre crack.

mod workplace;

use peristitch::gmsh::Extract;
use peristitch::pipeline::read::plan::Plan;
use peristitch::pipeline::record::frames::Frame;
use peristitch::pipeline::stages::validate::discretise;
use serde_json::Value;
use std::collections::BTreeMap;
use std::process::Command;
use tempfile::TempDir;
use workplace::{BINARY, repository};

/// E [Pa], G0 [J/m²], B, W, end of the notch, initial crack and spacing [m], of the pipeline.
const YOUNG: f64 = 3e9;
const RATE: f64 = 333.0;
const THICKNESS: f64 = 0.01;
const WIDTH: f64 = 0.05;
const NOTCH: f64 = 0.015;
const CRACK: f64 = 0.025;
const SPACING: f64 = 0.625e-3;

/// The load at which a crack of length a [m] grows [N].
fn griffith(a: f64) -> f64 {
    let x = a / WIDTH;
    let polynomial = 0.886 + x * (4.64 + x * (-13.32 + x * (14.72 - 5.6 * x)));
    let f = (2.0 + x) * polynomial / (1.0 - x).powf(1.5);
    (YOUNG * RATE).sqrt() * THICKNESS * WIDTH.sqrt() / f
}

/// The numbers of a line of history.csv by the names of their columns.
type Line = BTreeMap<String, f64>;

struct Run {
    results: TempDir,
    history: Vec<Line>,
    summary: Value,
}

impl Run {
    fn new() -> Run {
        let results = tempfile::tempdir().expect("a temporary folder");
        let output = Command::new(BINARY)
            .arg("run")
            .arg(repository().join("pipelines/compact_tension.yaml"))
            .arg("--results")
            .arg(results.path())
            .args(["--set", "output={ every: 1000000, pictures: false }"])
            .output()
            .expect("the binary starts");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        let folder = results.path().join("compact_tension");
        let text = std::fs::read_to_string(folder.join("history.csv")).expect("a history");
        let mut lines = text.lines().map(|line| line.split(','));
        let names: Vec<String> = (lines.next().expect("names").map(str::to_owned)).collect();
        let line = |values: std::str::Split<char>| {
            let pairs = names.iter().cloned().zip(values);
            pairs
                .filter_map(|(name, value)| Some((name, value.parse().ok()?)))
                .collect()
        };
        let summary = std::fs::read(folder.join("summary.json")).expect("a summary");
        Run {
            history: lines.map(line).collect(),
            summary: serde_json::from_slice(&summary).expect("JSON"),
            results,
        }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        self.history.iter().map(|line| line[name]).collect()
    }

    /// Largest |external work − elastic − dissipated energy| of a line, over its external work.
    fn imbalance(&self) -> f64 {
        let of_line = |line: &Line| {
            let stored = line["elastic_energy_j"] + line["dissipated_energy_j"];
            (stored / line["external_work_j"] - 1.0).abs()
        };
        self.history.iter().map(of_line).fold(0.0, f64::max)
    }

    /// Positions of the ends of the bonds and trusses that the load has broken [m].
    fn broken(&self) -> Vec<[[f64; 2]; 2]> {
        let folder = self.results.path().join("compact_tension");
        let read = |file: &str| std::fs::read(folder.join(file)).expect("a file of the run");
        let extract: Extract = postcard::from_bytes(&read("mesh.bin")).expect("a mesh");
        let pipeline = repository().join("pipelines/compact_tension.yaml");
        let plan = Plan::read(&pipeline, &[], None).expect("a sound pipeline");
        let mesh = extract.to_mesh(plan.geometry.unit_in_metres);
        let (model, _) = discretise(&plan, mesh.expect("a mesh")).expect("a model");
        let last = format!("frames/{:06}.bin", self.history.len());
        let frame: Frame = Frame::from_file(&read(&last)).expect("a frame");
        let interactions = model.interactions.pairs().iter();
        let state = model.integrity.iter().zip(frame.integrity.to_vec());
        let broken = interactions.zip(state).filter(|(_, (was, is))| **was > *is);
        broken
            .map(|(ends, _)| ends.map(|node| model.positions[node as usize]))
            .collect()
    }
}

#[test]
fn the_grips_go_back_while_the_crack_grows() {
    let run = Run::new();
    assert_eq!(run.summary["outcome"], "separated");
    assert_energies(&run);
    assert_snap_back(&run);
    assert_loads(&run);
    assert_straight(&run);
}

fn assert_energies(run: &Run) {
    // Three sums that do not know of each other; 6e-12 measured after 742 events, rounding alone.
    assert!(run.imbalance() < 1e-10, "{:e}", run.imbalance());
    // A balance can fail: without the last line's dissipation it would.
    let last = run.history.last().expect("a line");
    assert!(last["dissipated_energy_j"] > 0.9 * last["external_work_j"]);
    // What the look ahead lets its updates drift; a factorisation alone leaves 1e-14.
    assert!(run.column("residual").into_iter().fold(0.0, f64::max) <= 1e-11);
}

/// From tooth to tooth the crack needs a smaller opening: 20 times in a row, down to two thirds.
fn assert_snap_back(run: &Run) {
    let grip = run.column("grip_displacement_m");
    let back = grip.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert!(back > 100, "{back} events with smaller openings");
    // Upper ends of the teeth: the opening that makes the crack grow by the next spacing.
    let tooth = |advance: f64| {
        let within = run.history.iter().filter(|line| {
            let grown = NOTCH + line["crack_length_m"] - CRACK;
            (advance..advance + SPACING).contains(&grown)
        });
        (within.map(|line| line["grip_displacement_m"])).fold(0.0, f64::max)
    };
    let teeth: Vec<f64> = (0..20).map(|k| tooth(f64::from(k) * SPACING)).collect();
    assert!(teeth.windows(2).all(|pair| pair[1] < pair[0]), "{teeth:?}");
    // 0.64 measured; the straps' compliance is 3.6 times the specimen's at a/W = 0.5 (see docs/fracture.md).
    assert!(teeth[19] < 0.7 * teeth[0], "{teeth:?}");
}

fn assert_loads(run: &Run) {
    let reaction = run.column("reaction_n");
    let peak = reaction.iter().copied().fold(0.0, f64::max) / griffith(CRACK);
    // Not under Griffith's load, for a crack that is held needs more; not above it by more than the
    // 12 % of lattice trapping. 3 % are for the tip, known to half a spacing (2 %), and for straps
    // where E399 has pins.
    assert!((0.97..1.15).contains(&peak), "{peak}");
    // a/W from 0.5 to 0.55, E399's range for tests: the middle of each tooth.
    for tooth in 0..4 {
        let from = CRACK + f64::from(tooth) * SPACING;
        let ratios = run.history.iter().filter_map(|line| {
            let a = NOTCH + line["crack_length_m"];
            let inside = (from..from + SPACING).contains(&a);
            inside.then(|| line["reaction_n"] / griffith(a))
        });
        let (low, high) = ratios.fold((f64::INFINITY, 0.0), |(low, high), ratio| {
            (f64::min(low, ratio), f64::max(high, ratio))
        });
        let middle = 0.5 * (low + high);
        assert!((middle - 1.0).abs() < 0.03, "tooth {tooth}: {middle}");
        let trapping = 0.5 * (high - low);
        assert!(trapping < 0.12, "tooth {tooth}: {trapping}");
    }
}

/// Every bond that broke crosses the line of the crack, and its mirror image broke as well.
fn assert_straight(run: &Run) {
    let broken = run.broken();
    assert_eq!(
        broken.len() as f64,
        run.history.last().expect("a line")["bonds_broken_total"]
    );
    let off = broken.iter().filter(|[a, b]| a[1] * b[1] > 0.0).count();
    assert_eq!(off, 0, "of {} bonds", broken.len());
    let key = |[a, b]: [[f64; 2]; 2], mirror: f64| {
        let [a, b] = [a, b].map(|[x, y]| [x, mirror * y].map(|x| (1e9 * x).round() as i64));
        (a.min(b), a.max(b))
    };
    let mut own: Vec<_> = broken.iter().map(|&bond| key(bond, 1.0)).collect();
    let mut mirrored: Vec<_> = broken.iter().map(|&bond| key(bond, -1.0)).collect();
    own.sort_unstable();
    mirrored.sort_unstable();
    assert!(own == mirrored);
}
