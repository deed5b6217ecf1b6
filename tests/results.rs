//! What a run leaves in results/NAME/, for the hybrid Q8 bar of Table 1: VTU read back by VTK's own
//! reader and by meshio, pictures, summary; and what `check` had announced.

mod workplace;

use peristitch::gmsh;
use peristitch::model::Model;
use peristitch::phases::Phases;
use peristitch::pipeline::read::plan::Plan;
use peristitch::pipeline::stages::run::{self, Options};
use peristitch::statics::{self, Solution};
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use tempfile::TempDir;
use workplace::{BINARY, repository};

const NAME: &str = "cantilever_hybrid_q8";
const ELEMENTS: usize = 1600;
const NODES: usize = 5042;
const POINTS: usize = 6399;
const BONDS: usize = 147_230;
const TRUSSES: usize = 1600;
/// Components of vectors and tensors in a file.
const SPACE: usize = 3;
const TENSOR: usize = 9;

fn pipeline() -> PathBuf {
    repository().join(format!("pipelines/{NAME}.yaml"))
}

fn peristitch(arguments: &[&str]) -> String {
    let mut command = Command::new(BINARY);
    let output = command.args(arguments).output().expect("the binary starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// One run with bonds for all tests.
static RESULTS: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pipeline = pipeline();
    let [pipeline, results] = [&pipeline, folder.path()].map(|path| path.to_str().expect("UTF-8"));
    peristitch(&[
        "run",
        pipeline,
        "--results",
        results,
        "--set",
        "output.bonds=true",
    ]);
    folder
});

fn result(file: &str) -> PathBuf {
    RESULTS.path().join(NAME).join(file)
}

fn summary() -> Value {
    let text = std::fs::read(result("summary.json")).expect("a summary");
    serde_json::from_slice(&text).expect("JSON")
}

/// The same computation through the library, without any file.
fn solved() -> (Model, Solution) {
    let plan = Plan::read(&pipeline(), &[], None).expect("a sound pipeline");
    let gmsh = gmsh::Options {
        worker: Some(BINARY.into()),
        ..Default::default()
    };
    let options = Options {
        gmsh,
        ..Default::default()
    };
    let (model, boundary, _) = run::discretised(&plan, &options).expect("a sound model");
    let solution = statics::solve(&model, &boundary);
    (model, solution.expect("a solution"))
}

fn read_back(file: &Path) -> Value {
    let output = Command::new(repository().join(".venv/bin/python"))
        .arg(repository().join("tests/python/read_vtu.py"))
        .arg(file)
        .output()
        .expect("`make setup` has made .venv");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// What both readers found in a part of the results.
fn part(name: &str) -> [Value; 2] {
    let mut found = read_back(&result(&format!("{NAME}_{name}.vtu")));
    ["vtk", "meshio"].map(|reader| found[0][reader].take())
}

/// A field's rows of `width` numbers, all of them finite.
#[track_caller]
fn rows(field: &Value, width: usize) -> Vec<Vec<f64>> {
    let number = |text: &Value| match text {
        Value::String(text) => text.parse().expect("a float"),
        other => other.as_f64().expect("an integer"),
    };
    let rows = field.as_array().expect("rows").iter();
    let rows: Vec<Vec<f64>> = rows
        .map(|row| row.as_array().expect("a row").iter().map(number).collect())
        .collect();
    assert!(
        rows.iter()
            .all(|row| row.len() == width && row.iter().all(|x| x.is_finite()))
    );
    rows
}

#[track_caller]
fn assert_cells(found: &[Value; 2], vtk: u8, meshio: &str, count: usize) {
    assert_eq!(found[0]["types"], Value::from(vec![vtk; count]));
    assert_eq!(found[1]["types"], Value::from(vec![meshio; count]));
    assert_eq!(found[0]["cells"], found[1]["cells"]);
}

/// Node by node, found by its position. Files hold every bit: the tolerance is for the two
/// computations, whose bits agree as well.
#[track_caller]
fn assert_displacement(part: &Value, (model, solution): &(Model, Solution), count: usize) {
    let bits = |x: &[f64]| [x[0].to_bits(), x[1].to_bits()];
    let nodes: HashMap<_, _> = model.positions.iter().map(|x| bits(x)).zip(0..).collect();
    let components = solution.displacement.iter().flatten();
    let largest = components.fold(0.0, |most: f64, u| most.max(u.abs()));
    let points = rows(&part["points"], SPACE);
    let found = rows(&part["point_data"]["displacement"], SPACE);
    assert_eq!([points.len(), found.len()], [count; 2]);
    let mut seen = BTreeSet::new();
    for (point, found) in points.iter().zip(&found) {
        let node: usize = nodes[&bits(point)];
        let expected = solution.displacement[node];
        let error = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(
            error <= 1e-12 * largest && found[2] == 0.0,
            "{found:?} {expected:?}"
        );
        assert!(seen.insert(node), "node {node} comes twice");
    }
}

#[test]
fn finite_elements() {
    let found = part("elements");
    let solved = solved();
    assert_cells(&found, 23, "quad8", ELEMENTS);
    for part in &found {
        let points = rows(&part["points"], SPACE);
        assert_displacement(part, &solved, NODES);
        for field in ["stress", "strain"] {
            for t in rows(&part["point_data"][field], TENSOR) {
                assert!(
                    t[1] == t[3] && [t[2], t[5], t[6], t[7]] == [0.0; 4],
                    "{field}: {t:?}"
                );
            }
        }
        // At the load σ_xx is the traction: band and clamp are two heights away (1.6e-8).
        let stress = rows(&part["point_data"]["stress"], TENSOR);
        let at_load = (0..NODES).filter(|&n| points[n][0] > 1.0 - 1e-9);
        let error = at_load
            .map(|n| (stress[n][0] / 1.05e6 - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-7, "{error}");
        assert_eq!(
            rows(&part["cell_data"]["region_id"], 1),
            vec![vec![0.0]; ELEMENTS]
        );
    }
}

#[test]
fn material_points() {
    let found = part("points");
    let solved = solved();
    assert_cells(&found, 1, "vertex", POINTS);
    for part in &found {
        assert_displacement(part, &solved, POINTS);
        let areas = rows(&part["point_data"]["area"], 1);
        assert!(
            areas
                .iter()
                .all(|area| (area[0] / 6.25e-6 - 1.0).abs() < 1e-12)
        );
    }
}

#[test]
fn bonds_and_trusses() {
    let found = part("bonds");
    let solved = solved();
    let stiffness = &solved.0.interactions.stiffness;
    let stiff = |range: Range<usize>| range.filter(|&s| stiffness[s] != 0.0).count();
    let trusses = stiff(BONDS..BONDS + TRUSSES);
    assert_cells(&found, 3, "line", stiff(0..BONDS) + trusses);
    for part in &found {
        assert_displacement(part, &solved, NODES + POINTS);
        let stiffness = rows(&part["cell_data"]["stiffness"], 1);
        assert!(stiffness.iter().all(|k| k[0] > 0.0));
        let is_truss = rows(&part["cell_data"]["truss"], 1);
        assert_eq!(is_truss.iter().filter(|is| is[0] == 1.0).count(), trusses);
        // Of the order of σ/E = 1.05e-5, ten times that at most.
        let stretch = rows(&part["cell_data"]["stretch"], 1);
        let largest = stretch
            .iter()
            .fold(0.0, |most: f64, s| most.max(s[0].abs()));
        assert!((0.5e-5..1.05e-4).contains(&largest), "{largest:e}");
    }
}

#[test]
fn the_series_lists_parts_that_exist() {
    let found = read_back(&result(&format!("{NAME}.pvd")));
    let counts = |entry: &Value| {
        let count = |key: &str| entry[key].as_u64().expect("a count") as usize;
        (count("points"), count("cells"))
    };
    let parts: Vec<_> = found
        .as_array()
        .expect("entries")
        .iter()
        .map(counts)
        .collect();
    // Bonds without stiffness, as long as the horizon, are not drawn.
    let bonds = (NODES + POINTS, parts[2].1);
    assert!((0.9..1.0).contains(&(bonds.1 as f64 / (BONDS + TRUSSES) as f64)));
    assert_eq!(parts, [(NODES, ELEMENTS), (POINTS, POINTS), bonds]);
}

#[test]
fn pictures_show_something() {
    for name in [
        "mesh.png",
        "displacement_x.png",
        "displacement_y.png",
        "stress_xx.png",
        "stress_yy.png",
        "stress_xy.png",
        "principal_stress.png",
    ] {
        let file = std::fs::File::open(result(name)).expect("a picture");
        let mut reader = png::Decoder::new(std::io::BufReader::new(file))
            .read_info()
            .expect("PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("it fits")];
        let info = reader.next_frame(&mut pixels).expect("PNG");
        assert!(info.width >= 400 && info.height >= 150, "{name}: {info:?}");
        let bytes = info.color_type.samples();
        let pixels: Vec<&[u8]> = pixels[..info.buffer_size()].chunks_exact(bytes).collect();
        let coloured = pixels.iter().filter(|pixel| **pixel != pixels[0]).count();
        let colours: BTreeSet<_> = pixels.iter().collect();
        // The bar fills a good part of the picture, in more colours than a frame and its text.
        assert!(
            coloured > pixels.len() / 10 && colours.len() > 20,
            "{name}: {coloured}"
        );
    }
}

#[test]
fn the_summary_tells_where_the_time_went() {
    let summary = summary();
    let phases = summary["phases"].as_array().expect("phases");
    let names: Vec<&str> = phases
        .iter()
        .filter_map(|phase| phase["phase"].as_str())
        .collect();
    let statics = Phases::STATICS;
    assert_eq!(
        names,
        [
            &["gmsh", "discretisation"],
            &statics[..],
            &[Phases::OTHER, "vtu", "pictures"]
        ]
        .concat()
    );
    let sum = |key: &str| {
        phases
            .iter()
            .filter_map(|phase| phase[key].as_f64())
            .sum::<f64>()
    };
    // Sums of fourteen numbers.
    assert!((sum("share") - 1.0).abs() < 1e-12);
    assert!((sum("seconds") / summary["seconds"].as_f64().expect("a time") - 1.0).abs() < 1e-12);
    for file in summary["files"].as_array().expect("files") {
        assert!(result(file.as_str().expect("a name")).is_file(), "{file}");
    }
    assert_eq!(summary["outcome"], "solved");
}

#[test]
fn the_summary_tells_what_went_to_the_disk_and_what_memory_it_took() {
    let summary = summary();
    let number = |value: &Value| value.as_f64().expect("a number");
    for (kind, ending, count) in [("vtu", ".vtu", 3), ("pictures", ".png", 7)] {
        let account = &summary["written"][kind];
        let files = summary["files"].as_array().expect("files").iter();
        let files: Vec<&str> = files
            .filter_map(Value::as_str)
            .filter(|file| file.ends_with(ending))
            .collect();
        let size = |file: &&str| std::fs::metadata(result(file)).expect("a file").len();
        let bytes: u64 = files.iter().map(size).sum();
        assert_eq!(
            (files.len(), account["files"].as_u64()),
            (count, Some(count as u64))
        );
        assert_eq!(account["bytes"].as_u64(), Some(bytes));
        let ratio = bytes as f64 / number(&account["raw_bytes"]);
        assert_eq!(number(&account["ratio"]), ratio);
        assert!(0.0 < ratio && ratio < 1.0, "{kind}: {ratio}");
        let rate = number(&account["raw_bytes"]) / 1e6 / number(&account["seconds"]);
        assert!((number(&account["megabytes_per_second"]) / rate - 1.0).abs() < 1e-12);
    }
    // Positions, connectivity, offsets, types and fields of three parts; the bonds' displacements too.
    let points = 24 * (NODES + POINTS + NODES + POINTS);
    let [quads, vertices] = [(8 * 8 + 9) * ELEMENTS, (8 + 9) * POINTS];
    let fields = (24 + 72 + 72) * (NODES + POINTS) + 8 * (ELEMENTS + POINTS) + (16 + 8) * POINTS;
    let lines = read_back(&result(&format!("{NAME}.pvd")))[2]["cells"]
        .as_u64()
        .expect("lines");
    let bonds = 24 * (NODES + POINTS) + (16 + 9 + 8 + 8 + 4) * lines as usize;
    let raw = points + quads + vertices + fields + bonds;
    assert_eq!(summary["written"]["vtu"]["raw_bytes"], raw);
    let memory = &summary["memory"];
    assert_eq!(
        memory["factor_bytes"].as_u64(),
        summary["sizes"]["factor_entries"].as_u64().map(|n| 8 * n)
    );
    assert_eq!(memory["peak_bytes"], summary["peak_memory_bytes"]);
    assert!(number(&memory["peak_over_factor"]) > 1.0);
}

/// Sizes to the digit, memory within 30 %.
#[test]
fn check_announces_what_the_run_then_needs() {
    let pipeline = pipeline();
    let checked = peristitch(&["check", pipeline.to_str().expect("UTF-8")]);
    let numbers = |label: &str| -> Vec<usize> {
        let line = checked
            .lines()
            .find_map(|line| line.trim().strip_prefix(label));
        let line = line.unwrap_or_else(|| panic!("{label} is not in\n{checked}"));
        line.split(|c: char| !c.is_ascii_digit())
            .filter_map(|word| word.parse().ok())
            .collect()
    };
    let summary = summary();
    let size = |key: &str| summary["sizes"][key].as_u64().expect("a size") as usize;
    assert_eq!(
        numbers("finite elements"),
        [size("finite_elements"), size("finite_element_nodes")]
    );
    assert_eq!(numbers("material points"), [size("material_points")]);
    assert_eq!(numbers("bonds"), [size("bonds")]);
    assert_eq!(numbers("trusses"), [size("trusses")]);
    assert_eq!(numbers("unknowns"), [size("dofs")]);
    assert_eq!(numbers("factor")[0], size("factor_entries"));
    assert_eq!([size("bonds"), size("trusses")], [BONDS, TRUSSES]);
    let announced = 1e6 * numbers("to expect")[0] as f64;
    let needed = summary["peak_memory_bytes"].as_f64().expect("a size");
    assert!(
        (announced / needed - 1.0).abs() < 0.3,
        "{announced:e} of {needed:e} bytes"
    );
}
