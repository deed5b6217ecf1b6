//! VTU and PVD files read back by two independent readers, VTK's own and meshio: every number to
//! the last bit, every cell with its type and node order.

use peristitch::mesh::CellKind;
use peristitch::output::field::{Field, FieldName, Values};
use peristitch::output::pvd;
use peristitch::output::vtu::{Part, PartCell};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Values that a text format, f32 or a careless writer would change.
const AWKWARD: [f64; 8] = [
    -0.0,
    1e-300,
    5e-324,
    0.1 + 0.2,
    -1.234_567_890_123_456_7e-8,
    f64::MAX,
    f64::MIN_POSITIVE,
    1.0 / 3.0,
];

fn awkward(index: usize) -> f64 {
    AWKWARD[index % AWKWARD.len()] * if index < AWKWARD.len() { 1.0 } else { 0.7 }
}

fn awkward_scalars(count: usize) -> Vec<f64> {
    (0..count).map(awkward).collect()
}

fn awkward_vectors(count: usize) -> Vec<[f64; 2]> {
    (0..count).map(|i| [awkward(i), awkward(i + 3)]).collect()
}

fn awkward_tensors(count: usize) -> Vec<[f64; 4]> {
    (0..count)
        .map(|i| [awkward(i), awkward(i + 1), awkward(i + 2), awkward(i + 5)])
        .collect()
}

/// A Q8 with a curved side, a Q4, a T6 and a T3 in a row; corners first, then mid-sides.
fn four_kinds() -> Part {
    let points = vec![
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [0.5, -0.125],
        [1.0, 0.5],
        [0.5, 1.0],
        [0.0, 0.5],
        [2.0, 0.0],
        [2.0, 1.0],
        [3.0, 0.0],
        [2.5, 0.0],
        [2.5, 0.5],
        [2.0, 0.5],
        [3.0, 1.0 / 3.0],
    ];
    let mut part = Part::new(points);
    part.push_cell(
        PartCell::Surface(CellKind::Quad8),
        &[0, 1, 2, 3, 4, 5, 6, 7],
    );
    part.push_cell(PartCell::Surface(CellKind::Quad4), &[1, 8, 9, 2]);
    part.push_cell(PartCell::Surface(CellKind::Tri6), &[8, 10, 9, 11, 12, 13]);
    part.push_cell(PartCell::Surface(CellKind::Tri3), &[10, 14, 9]);
    part
}

fn with_all_fields(mut part: Part) -> Part {
    let fields = |count: usize| {
        vec![
            Field::scalar(FieldName::Area, awkward_scalars(count)),
            Field::vector(FieldName::Displacement, awkward_vectors(count)),
            Field::symmetric_tensor(FieldName::Stress, awkward_tensors(count)),
            Field::integer(
                FieldName::Region,
                (0..count as i32).map(|i| i32::MIN + i).collect(),
            ),
        ]
    };
    part.point_data = fields(part.points.len());
    part.cell_data = fields(part.cells().len());
    part
}

fn vertices(count: usize) -> Part {
    with_all_fields(Part::of_vertices(
        (0..count).map(|i| [awkward(i), i as f64 * 0.1]).collect(),
    ))
}

/// Runs the Python readers on `files`.
fn read_back(files: &[PathBuf]) -> Value {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join(".venv/bin/python");
    let output = Command::new(&python)
        .arg(root.join("tests/python/read_vtu.py"))
        .args(files)
        .output()
        .unwrap_or_else(|error| panic!("{} does not run: {error}", python.display()));
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{log}");
    serde_json::from_slice(&output.stdout).expect("the script prints JSON")
}

/// Writes `part`, reads it with both readers and compares everything.
#[track_caller]
fn assert_reads_back(part: &Part, kinds: &[(u8, &str)]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("part.vtu");
    part.write(&path).expect("a valid part");
    let found = read_back(&[path]);
    for reader in ["vtk", "meshio"] {
        let found = &found[0][reader];
        assert_eq!(bits(&found["points"]), in_space(&part.points), "{reader}");
        assert_fields(reader, &found["point_data"], &part.point_data);
        assert_fields(reader, &found["cell_data"], &part.cell_data);
    }
    let expected: Vec<u8> = kinds.iter().map(|kind| kind.0).collect();
    assert_eq!(found[0]["vtk"]["types"], Value::from(expected));
    let expected: Vec<&str> = kinds.iter().map(|kind| kind.1).collect();
    assert_eq!(found[0]["meshio"]["types"], Value::from(expected));
    assert_eq!(found[0]["vtk"]["cells"], found[0]["meshio"]["cells"]);
}

#[track_caller]
fn assert_fields(reader: &str, found: &Value, expected: &[Field]) {
    let found = found.as_object().expect("an object of arrays");
    assert_eq!(found.len(), expected.len(), "{reader}");
    for Field { name, values } in expected {
        let found = &found[name.as_str()];
        let rows: Vec<Vec<u64>> = match values {
            Values::Scalar(v) => v.iter().map(|x| vec![x.to_bits()]).collect(),
            Values::Vector(v) => in_space(v),
            Values::SymmetricTensor(v) => v
                .iter()
                .map(|&[xx, yy, zz, xy]| [xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, zz])
                .map(|row| row.iter().map(|x| x.to_bits()).collect())
                .collect(),
            Values::Integer(v) => {
                let rows: Vec<Vec<i32>> = v.iter().map(|&x| vec![x]).collect();
                assert_eq!(*found, serde_json::json!(rows), "{reader}: {name}");
                continue;
            }
        };
        assert_eq!(bits(found), rows, "{reader}: {name}");
    }
}

fn in_space(vectors: &[[f64; 2]]) -> Vec<Vec<u64>> {
    vectors
        .iter()
        .map(|&[x, y]| vec![x.to_bits(), y.to_bits(), 0])
        .collect()
}

/// Rows of floats, each printed with Python's `repr`, as bits.
#[track_caller]
fn bits(rows: &Value) -> Vec<Vec<u64>> {
    let float = |text: &Value| -> u64 {
        let text = text.as_str().expect("floats are strings");
        text.parse::<f64>().expect("a float").to_bits()
    };
    let row = |row: &Value| row.as_array().expect("a row").iter().map(float).collect();
    rows.as_array().expect("rows").iter().map(row).collect()
}

#[test]
fn surface_cells_of_every_kind() {
    let kinds = [
        (23, "quad8"),
        (9, "quad"),
        (22, "triangle6"),
        (5, "triangle"),
    ];
    assert_reads_back(&with_all_fields(four_kinds()), &kinds);
}

#[test]
fn quadratic_cells_keep_their_node_order() {
    let part = four_kinds();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("part.vtu");
    part.write(&path).expect("a valid part");
    let found = read_back(&[path]);
    for reader in ["vtk", "meshio"] {
        let cells = found[0][reader]["cells"].as_array().expect("cells");
        for (cell, corners) in [(&cells[0], 4), (&cells[2], 3)] {
            let nodes: Vec<usize> = serde_json::from_value(cell.clone()).expect("node numbers");
            let at = |k: usize| part.points[nodes[k]];
            for side in 0..corners {
                let [a, b, middle] = [at(side), at((side + 1) % corners), at(corners + side)];
                let off = [0, 1].map(|k| middle[k] - (a[k] + b[k]) / 2.0);
                assert!(off[0].hypot(off[1]) <= 0.125, "{reader}: side {side}");
            }
        }
    }
}

#[test]
fn material_points() {
    assert_reads_back(&vertices(20), &[(1, "vertex"); 20]);
}

#[test]
fn bonds() {
    let points = (0..4).map(|i| [f64::from(i), 0.1]).collect();
    let pairs = [[0, 1], [1, 2], [3, 0]];
    let part = with_all_fields(Part::of_lines(points, &pairs));
    assert_reads_back(&part, &[(3, "line"); 3]);
}

/// 4096 points: every array of the file fills vtkio's compression blocks of 32 KiB exactly, and
/// vtkio appends an empty block.
#[test]
fn arrays_that_fill_whole_compression_blocks() {
    assert_reads_back(&vertices(4096), &[(1, "vertex"); 4096]);
}

/// 4097 points: every array spans several blocks and the last is partial.
#[test]
fn arrays_of_several_compression_blocks() {
    assert_reads_back(&vertices(4097), &[(1, "vertex"); 4097]);
}

/// All bonds may break. meshio cannot read an empty grid, whoever wrote it.
#[test]
fn empty_parts() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, points) in [("empty.vtu", vec![]), ("no_cells.vtu", vec![[0.0, 1.0]; 3])] {
        let count = points.len();
        let path = folder.path().join(name);
        Part::new(points).write(&path).expect("valid");
        let list = folder.path().join("list.pvd");
        let entry = pvd::Entry {
            time: 0.0,
            part: 0,
            name: String::new(),
            file: name.to_owned(),
        };
        pvd::write(&list, &[entry]).expect("valid");
        let found = read_back(&[list]);
        assert_eq!(found[0]["points"], count);
        assert_eq!(found[0]["cells"], 0);
    }
}

#[test]
fn a_time_series_opens_file_by_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let name = "bars & <stitches>";
    std::fs::create_dir(folder.path().join(name)).expect("a new folder");
    let mut entries = Vec::new();
    for step in 0..3 {
        for (part, grid) in [four_kinds(), vertices(5)].iter().enumerate() {
            let file = format!("{name}/{part}_{step}.vtu");
            grid.write(&folder.path().join(&file)).expect("valid");
            entries.push(pvd::Entry {
                time: f64::from(step) * 0.1,
                part,
                name: format!("part \"{part}\""),
                file,
            });
        }
    }
    let path = folder.path().join("series.pvd");
    pvd::write(&path, &entries).expect("valid");

    let found = read_back(&[path]);
    let found = found.as_array().expect("entries");
    assert_eq!(found.len(), entries.len());
    for (found, entry) in found.iter().zip(&entries) {
        let text = |key: &str| found[key].as_str().expect("an attribute").to_owned();
        assert_eq!(text("timestep").parse(), Ok(entry.time));
        assert_eq!(text("part"), entry.part.to_string());
        assert_eq!(text("name"), entry.name);
        assert_eq!(text("file"), entry.file);
        let counts = [(15, 4), (5, 5)][entry.part];
        assert_eq!(found["points"], counts.0);
        assert_eq!(found["cells"], counts.1);
    }
}
