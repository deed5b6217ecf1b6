//! From `.geo` files to meshes, with every Gmsh library of this machine.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use peristitch::gmsh::{
    self, Extract, ExtractError, GeoScript, GmshError, Options, Value, library,
};
use peristitch::mesh::{Cell, CellKind, Edge, Mesh};

const MILLIMETRE: f64 = 1e-3;
const WORKER: &str = env!("CARGO_BIN_EXE_peristitch");

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn cantilever() -> PathBuf {
    repository().join("geo/cantilever.geo")
}

fn geo(name: &str) -> PathBuf {
    repository().join("tests/geo").join(name)
}

/// Every library found; the project's own among them.
fn libraries() -> Vec<PathBuf> {
    let found = library::Places::of_this_process().search().found;
    let own = repository().join(".venv");
    assert!(
        found.iter().any(|path| path.starts_with(&own)),
        "no library in {}, run `make setup`; found: {found:?}",
        own.display()
    );
    found
}

fn options(library: &Path) -> Options {
    Options {
        worker: Some(WORKER.into()),
        library: Some(library.to_owned()),
        time_limit: Duration::from_secs(60),
        // Some of the scripts here crash on purpose, or save what they mesh.
        trust: true,
        ..Options::default()
    }
}

fn values(parameters: &[(&str, Value)]) -> BTreeMap<String, Value> {
    let pairs = parameters.iter().cloned();
    pairs
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

fn numbers(parameters: &[(&str, f64)]) -> BTreeMap<String, Value> {
    let pairs = parameters.iter();
    pairs
        .map(|&(name, value)| (name.to_owned(), value.into()))
        .collect()
}

fn extract(library: &Path, file: &Path, parameters: &[(&str, f64)]) -> Extract {
    gmsh::mesh(file, &numbers(parameters), &options(library))
        .unwrap_or_else(|error| panic!("{}: {error}", library.display()))
}

fn failure(library: &Path, file: &Path) -> GmshError {
    gmsh::mesh(file, &BTreeMap::new(), &options(library)).expect_err("must fail")
}

/// Area of a straight-sided cell, positive if counter-clockwise [m²].
fn area(mesh: &Mesh, cell: &Cell) -> f64 {
    let corners = cell.corners();
    let position = |i: usize| mesh.nodes[corners[i % corners.len()]];
    let cross = |i: usize| {
        let ([xa, ya], [xb, yb]) = (position(i), position(i + 1));
        0.5 * (xa * yb - xb * ya)
    };
    (0..corners.len()).map(cross).sum()
}

fn total_area(mesh: &Mesh) -> f64 {
    mesh.cells.iter().map(|cell| area(mesh, cell)).sum()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn cantilever_has_the_counts_of_a_structured_mesh() {
    // 100 x 20 squares: 2121 corners and 4120 sides; triangles add 2000 diagonals.
    let cases = [
        (1.0, 0.0, CellKind::Quad4, 2000, 2121),
        (2.0, 0.0, CellKind::Quad8, 2000, 2121 + 4120),
        (1.0, 1.0, CellKind::Tri3, 4000, 2121),
        (2.0, 1.0, CellKind::Tri6, 4000, 2121 + 4120 + 2000),
    ];
    for library in libraries() {
        for (order, triangles, kind, cells, nodes) in cases {
            let parameters = [("order", order), ("triangles", triangles)];
            let extract = extract(&library, &cantilever(), &parameters);
            assert_eq!(extract.warnings, [""; 0]);
            let mesh = extract.to_mesh(MILLIMETRE).unwrap();
            assert_eq!(
                (mesh.cells.len(), mesh.nodes.len()),
                (cells, nodes),
                "{kind:?}"
            );
            assert!(mesh.cells.iter().all(|cell| cell.kind == kind));
            assert!(mesh.cells.iter().all(|cell| area(&mesh, cell) > 0.0));
            assert!(
                (total_area(&mesh) - 0.2).abs() < 1e-12,
                "{}",
                total_area(&mesh)
            );
            let sizes = ["left", "band", "right"].map(|name| mesh.surfaces[name].len());
            assert_eq!(sizes, [2, 1, 2].map(|fifths| fifths * cells / 5));
            let edges = ["clamp", "load", "top", "bottom"].map(|name| mesh.curves[name].len());
            assert_eq!(edges, [20, 20, 100, 100]);
            for edge in mesh.curves.values().flatten() {
                assert_eq!(edge.middle.is_some(), kind.is_quadratic());
            }
        }
    }
}

#[test]
fn cantilever_groups_lie_where_they_should() {
    for library in libraries() {
        let mesh = extract(&library, &cantilever(), &[])
            .to_mesh(MILLIMETRE)
            .unwrap();
        let offset = |curve: &str, axis: usize, value: f64| {
            let nodes = mesh.curves[curve].iter().flat_map(|edge| edge.nodes());
            largest(nodes.map(|node| mesh.nodes[node][axis] - value))
        };
        assert!(offset("clamp", 0, 0.0) < 1e-12);
        assert!(offset("load", 0, 1.0) < 1e-12);
        assert!(offset("bottom", 1, 0.0) < 1e-12);
        assert!(offset("top", 1, 0.2) < 1e-12);
        assert_eq!(mesh.points["corner"].len(), 1);
        assert_eq!(mesh.nodes[mesh.points["corner"][0]], [0.0, 0.0]);
        let tip = mesh.nodes[mesh.points["tip"][0]];
        assert!((tip[0] - 1.0).hypot(tip[1] - 0.1) < 1e-12, "{tip:?}");
    }
}

#[test]
fn interfaces_are_found_and_middle_nodes_are_exact() {
    for library in libraries() {
        let mesh = extract(&library, &cantilever(), &[])
            .to_mesh(MILLIMETRE)
            .unwrap();
        for (a, b, x) in [("left", "band", 0.4), ("band", "right", 0.6)] {
            let shared = mesh.shared_edges(&mesh.surfaces[a], &mesh.surfaces[b]);
            assert_eq!(shared.len(), 20);
            let nodes = shared.iter().flat_map(|edge| edge.nodes());
            assert!(largest(nodes.map(|node| mesh.nodes[node][0] - x)) < 1e-12);
            let upwards = |edge: &Edge| mesh.nodes[edge.ends[1]][1] > mesh.nodes[edge.ends[0]][1];
            assert!(
                shared.iter().all(upwards),
                "the first region lies on the left"
            );
        }
        assert!(
            mesh.shared_edges(&mesh.surfaces["left"], &mesh.surfaces["right"])
                .is_empty()
        );
        for edge in mesh.cells.iter().flat_map(Cell::edges) {
            let [a, b] = edge.ends.map(|end| mesh.nodes[end]);
            let middle = mesh.nodes[edge.middle.unwrap()];
            assert_eq!(middle, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
        }
    }
}

#[test]
fn cantilever_without_left_and_right() {
    for library in libraries() {
        let parameters = [("band_start", 0.0), ("band_end", 1000.0), ("element", 20.0)];
        let mesh = extract(&library, &cantilever(), &parameters)
            .to_mesh(MILLIMETRE)
            .unwrap();
        assert_eq!(mesh.surfaces.keys().collect::<Vec<_>>(), ["band"]);
        assert_eq!(mesh.surfaces["band"].len(), 500);
        assert_eq!(mesh.curves["clamp"].len() + mesh.curves["load"].len(), 20);
        assert!((total_area(&mesh) - 0.2).abs() < 1e-12);
    }
}

#[test]
fn cantilever_refuses_parameters_that_do_not_fit() {
    let cases = [
        (("element", 7.0), "divide"),
        (("band_end", 605.0), "multiples of element"),
        (("band_end", 300.0), "within the bar"),
    ];
    for library in libraries() {
        for (parameter, expected) in cases {
            let error =
                gmsh::mesh(&cantilever(), &numbers(&[parameter]), &options(&library)).unwrap_err();
            let GmshError::Failed { errors, .. } = &error else {
                panic!("{error}");
            };
            assert_eq!(errors.len(), 1, "{error}");
            assert!(errors[0].text.contains(expected), "{error}");
        }
    }
}

#[test]
fn every_version_gives_the_same_mesh() {
    let libraries = libraries();
    for parameters in [&[][..], &[("triangles", 1.0), ("order", 1.0)]] {
        let reference = extract(&libraries[0], &cantilever(), parameters);
        for library in &libraries[1..] {
            let other = extract(library, &cantilever(), parameters);
            assert_ne!(other.origin, reference.origin);
            assert_eq!(other.groups, reference.groups);
            let pairs = other.nodes.iter().zip(&reference.nodes);
            let differences = pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]);
            assert!(largest(differences) < 1e-9);
        }
    }
}

#[test]
fn equal_input_gives_equal_bytes() {
    for library in libraries() {
        let bytes = || postcard::to_stdvec(&extract(&library, &cantilever(), &[])).unwrap();
        let first = bytes();
        assert_eq!(first, bytes());
        let read: Extract = postcard::from_bytes(&first).unwrap();
        assert_eq!(read, extract(&library, &cantilever(), &[]));
    }
}

#[test]
fn parameters_are_set_however_they_are_written() {
    let file = geo("parameters.geo");
    let side = |mesh: &Mesh, name: &str| {
        let cells = &mesh.surfaces[name];
        let area: f64 = cells
            .iter()
            .map(|&cell| area(mesh, &mesh.cells[cell]))
            .sum();
        area.sqrt()
    };
    let names = ["plate", "second", "labelled", "tested", "fixed"];
    for library in libraries() {
        let mesh = extract(&library, &file, &[]).to_mesh(1.0).unwrap();
        for (name, expected) in names.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0]) {
            assert!((side(&mesh, name) - expected).abs() < 1e-9, "{name}");
        }
        let parameters = values(&[
            ("plain", 11.0.into()),
            ("listed", 12.5.into()),
            ("labelled", 13.0.into()),
            ("tested", 14.0.into()),
            ("name", "renamed".into()),
            ("label", "two words".into()),
        ]);
        let mesh = gmsh::mesh(&file, &parameters, &options(&library)).unwrap();
        let mesh = mesh.to_mesh(1.0).unwrap();
        let names = ["renamed", "two words", "labelled", "tested", "fixed"];
        for (name, expected) in names.iter().zip([11.0, 12.5, 13.0, 14.0, 5.0]) {
            assert!((side(&mesh, name) - expected).abs() < 1e-9, "{name}");
        }
    }
}

#[test]
fn wrong_parameters_are_refused_before_gmsh_runs() {
    // The worker does not exist: had it been started, the error would be another.
    let options = Options {
        worker: Some("/nonexistent".into()),
        ..Options::default()
    };
    let error = |file: PathBuf, name: &str, value: Value| {
        gmsh::mesh(&file, &values(&[(name, value)]), &options)
            .unwrap_err()
            .to_string()
    };
    let message = error(cantilever(), "elment", 5.0.into());
    assert!(message.contains("did you mean 'element'?"), "{message}");
    let all = "band_end, band_start, element, order, triangles";
    assert!(message.contains(all), "{message}");
    let message = error(cantilever(), "element", "ten".into());
    assert!(message.contains("must be a number, not 'ten'"), "{message}");
    let message = error(cantilever(), "element", f64::NAN.into());
    assert!(message.contains("must be finite"), "{message}");
    let message = error(geo("parameters.geo"), "name", 1.0.into());
    assert!(message.contains("must be a text"), "{message}");
    let message = error(geo("parameters.geo"), "fixed", 1.0.into());
    assert!(message.contains("DefineConstant[ fixed ="), "{message}");
    let message = error(geo("syntax_error.geo"), "x", 1.0.into());
    assert!(message.contains("It defines none"), "{message}");
}

#[test]
fn an_included_file_has_parameters_and_is_a_dependency() {
    let script = GeoScript::scan(&geo("nine_nodes.geo")).unwrap();
    assert_eq!(script.files, [geo("nine_nodes.geo"), geo("square.geo")]);
    for library in libraries() {
        let extract = extract(&library, &geo("nine_nodes.geo"), &[("divisions", 5.0)]);
        assert_eq!(extract.groups[0].blocks[0].tags.len(), 25);
    }
}

#[test]
fn an_options_file_beside_the_script_is_read_by_gmsh_and_is_a_dependency() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("square.geo");
    let opt = folder.path().join("square.geo.opt");
    std::fs::copy(geo("square.geo"), &file).unwrap();
    std::fs::write(
        &opt,
        "Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 1;\n",
    )
    .unwrap();
    assert_eq!(GeoScript::scan(&file).unwrap().files, [file.clone(), opt]);
    for library in libraries() {
        assert_eq!(extract(&library, &file, &[]).groups[0].blocks[0].kind, 16);
    }
}

#[test]
fn a_crack_that_bounds_no_surface_is_meshed() {
    for library in libraries() {
        for (order, nodes) in [(1.0, 25 + 5), (2.0, 65 + 9)] {
            let extract = extract(&library, &geo("crack.geo"), &[("order", order)]);
            let mesh = extract.to_mesh(MILLIMETRE).unwrap();
            assert_eq!(mesh.nodes.len(), nodes);
            let crack = &mesh.curves["crack"];
            let length = |edge: &Edge| {
                let [a, b] = edge.ends.map(|end| mesh.nodes[end]);
                (a[0] - b[0]).hypot(a[1] - b[1])
            };
            let expected = 1e-3 * (5.0_f64.sqrt() + 13.0_f64.sqrt());
            assert!((crack.iter().map(length).sum::<f64>() - expected).abs() < 1e-12);
            assert!(
                crack
                    .windows(2)
                    .all(|pair| pair[0].ends[1] == pair[1].ends[0])
            );
            let tip = mesh.points["crack tip"][0];
            assert_eq!(crack.last().unwrap().ends[1], tip);
            let of_cells = mesh.cells.iter().flat_map(|cell| cell.nodes());
            assert!(of_cells.copied().all(|node| node != tip));
            assert!((total_area(&mesh) - 1e-4).abs() < 1e-15);
        }
    }
}

#[test]
fn groups_overlap_go_unnamed_and_run_clockwise() {
    for library in libraries() {
        let mesh = extract(&library, &geo("groups.geo"), &[])
            .to_mesh(1.0)
            .unwrap();
        assert_eq!(mesh.cells.len(), 18);
        assert_eq!(mesh.nodes.len(), 28 + 45, "nodes of no group are left out");
        assert_eq!(mesh.surfaces["all"], (0..18).collect::<Vec<_>>());
        let mut parts = [mesh.surfaces["17"].clone(), mesh.surfaces["second"].clone()].concat();
        parts.sort_unstable();
        assert_eq!(parts, mesh.surfaces["all"]);
        assert_eq!(mesh.curves["3"].len(), 6);
        for cell in &mesh.cells {
            assert!((area(&mesh, cell) - 1.0 / 9.0).abs() < 1e-9);
            for edge in cell.edges() {
                let [a, b] = edge.ends.map(|end| mesh.nodes[end]);
                let middle = mesh.nodes[edge.middle.unwrap()];
                assert_eq!(middle, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            }
        }
    }
}

#[test]
fn a_saved_mesh_gives_the_mesh_of_its_geometry() {
    let folder = tempfile::tempdir().unwrap();
    let saver = folder.path().join("saver.geo");
    let saved = folder.path().join("saved.msh");
    let text = format!(
        "Include \"{}\";\nMesh 2;\nSave \"{}\";\n",
        cantilever().display(),
        saved.display()
    );
    std::fs::write(&saver, text).unwrap();
    for library in libraries() {
        extract(&library, &saver, &[("element", 50.0)]);
        let direct = extract(&library, &cantilever(), &[("element", 50.0)]);
        let direct = direct.to_mesh(1.0).unwrap();
        let mesh = extract(&library, &saved, &[]).to_mesh(1.0).unwrap();
        assert_eq!(mesh.cells.len(), 80);
        assert_eq!(mesh.cells, direct.cells);
        assert_eq!(mesh.surfaces, direct.surfaces);
        assert_eq!(mesh.curves, direct.curves);
        assert_eq!(mesh.points, direct.points);
        let pairs = mesh.nodes.iter().zip(&direct.nodes);
        assert!(largest(pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]])) < 1e-9);
        let parameters = numbers(&[("element", 5.0)]);
        let error = gmsh::mesh(&saved, &parameters, &options(&library)).unwrap_err();
        assert!(
            matches!(error, GmshError::ParameterOfMesh { .. }),
            "{error}"
        );
        std::fs::remove_file(&saved).unwrap();
    }
}

#[test]
fn geometry_that_cannot_be_computed_on_is_refused() {
    for library in libraries() {
        let refusal = |name: &str| extract(&library, &geo(name), &[]).to_mesh(1.0).unwrap_err();
        let error = refusal("nine_nodes.geo");
        let ExtractError::ElementKind { group, count, .. } = &error else {
            panic!("{error}");
        };
        assert_eq!((group.as_str(), *count), ("square", 9));
        assert!(
            error
                .to_string()
                .contains("Mesh.SecondOrderIncomplete = 1;"),
            "{error}"
        );
        let error = refusal("no_surface.geo");
        assert!(
            matches!(error, ExtractError::NoPhysicalSurface { surfaces: 0, .. }),
            "{error}"
        );
        assert!(
            error.to_string().contains("physical curve 'edge'"),
            "{error}"
        );
        let error = refusal("tilted.geo");
        assert!(
            matches!(
                error,
                ExtractError::OffPlane {
                    count: 12,
                    total: 16,
                    ..
                }
            ),
            "{error}"
        );
    }
}

#[test]
fn syntax_error_has_file_and_line() {
    let file = geo("syntax_error.geo");
    for library in libraries() {
        let error = failure(&library, &file);
        let GmshError::Failed { errors, log, .. } = &error else {
            panic!("{error}");
        };
        assert_eq!(errors[0].file.as_deref(), Some(file.as_path()));
        assert_eq!(errors[0].line, Some(3));
        assert!(errors[0].text.contains("syntax error"), "{error}");
        assert!(
            log.iter().any(|line| line.contains("syntax error")),
            "{log:?}"
        );
        assert!(
            error
                .to_string()
                .contains("syntax_error.geo:3: syntax error"),
            "{error}"
        );
    }
}

#[test]
fn missing_and_foreign_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let merging = folder.path().join("merging.geo");
    std::fs::write(&merging, "Merge \"absent.msh\";").unwrap();
    let foreign = folder.path().join("mesh.inp");
    std::fs::write(&foreign, "").unwrap();
    let broken = folder.path().join("broken.msh");
    std::fs::write(&broken, "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4").unwrap();
    let empty = folder.path().join("empty.msh");
    std::fs::write(&empty, "").unwrap();
    for library in libraries() {
        let error = failure(&library, Path::new("nowhere.geo"));
        assert!(matches!(error, GmshError::FileMissing { .. }), "{error}");
        let error = failure(&library, &foreign);
        assert!(matches!(error, GmshError::FileKind { .. }), "{error}");
        let error = failure(&library, &merging);
        assert!(error.to_string().contains("absent.msh"), "{error}");
        let error = failure(&library, &broken);
        assert!(matches!(error, GmshError::Failed { .. }), "{error}");
        let refused = gmsh::mesh(&empty, &BTreeMap::new(), &options(&library))
            .map(|extract| extract.to_mesh(1.0).is_err());
        assert!(!matches!(refused, Ok(false)));
    }
}

#[test]
fn warnings_are_returned() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("warning.geo");
    let text = format!(
        "Include \"{}\";\nWarning(\"mind the gap\");\na = 1; b = 2;",
        geo("square.geo").display()
    );
    std::fs::write(&file, text).unwrap();
    for library in libraries() {
        let extract = extract(&library, &file, &[]);
        let [from_scan, from_gmsh] = extract.warnings.as_slice() else {
            panic!("{:?}", extract.warnings);
        };
        assert!(from_gmsh.contains("mind the gap"), "{from_gmsh}");
        assert!(
            from_scan.contains("warning.geo:3: the file does not end"),
            "{from_scan}"
        );
    }
}

/// The traps that `GeoScript` warns of are Gmsh's: should a version mend one, this test tells.
#[test]
fn silent_traps_are_real() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        file
    };
    let square = geo("square.geo").display().to_string();
    let set = "Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 1;";
    let lost = write("lost.geo", &format!("Include \"{square}\";\n{set}"));
    let kept = write("kept.geo", &format!("Include \"{square}\";\n{set}\n"));
    let early = write(
        "early.geo",
        &format!("Include \"{square}\"; Delete Physicals;\n"),
    );
    for library in libraries() {
        let kind = |file: &Path| extract(&library, file, &[]).groups[0].blocks[0].kind;
        assert_eq!(kind(&lost), 10, "the second statement is lost");
        assert_eq!(kind(&kept), 16);
        assert_eq!(
            kind(&early),
            3,
            "the groups are deleted before they are made"
        );
    }
}

#[test]
fn a_crash_is_an_error_with_the_log() {
    for library in libraries() {
        let error = failure(&library, &geo("crash.geo"));
        let GmshError::Crashed { ending, log, .. } = &error else {
            panic!("{error}");
        };
        assert!(ending.contains("signal 6"), "{error}");
        assert!(
            log.iter().any(|line| line.contains("about to crash")),
            "{log:?}"
        );
    }
}

#[test]
fn a_runaway_is_stopped_at_the_time_limit() {
    for library in libraries() {
        let options = Options {
            time_limit: Duration::from_millis(1500),
            ..options(&library)
        };
        let start = Instant::now();
        let error = gmsh::mesh(&geo("endless.geo"), &BTreeMap::new(), &options).unwrap_err();
        assert!(start.elapsed() < Duration::from_secs(10));
        let GmshError::TimeLimit { log, .. } = &error else {
            panic!("{error}");
        };
        assert!(
            log.iter().any(|line| line.contains("the loop begins")),
            "{log:?}"
        );
    }
}

#[test]
fn a_command_that_outlives_the_script_does_not_hold_us_up() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("background.geo");
    let text = format!(
        "Include \"{}\";\nSystemCall \"sleep 30 &\";\n",
        geo("square.geo").display()
    );
    std::fs::write(&file, text).unwrap();
    let start = Instant::now();
    extract(&libraries()[0], &file, &[]);
    assert!(start.elapsed() < Duration::from_secs(20));
}

#[test]
fn the_worker_ends_with_its_parent() {
    for library in libraries() {
        let folder = tempfile::tempdir().unwrap();
        let request = serde_json::json!({
            "geometry": geo("endless.geo"),
            "mesh_dimension": 2,
            "arguments": [],
            "parameters": [],
            "trust": true,
            "libraries": [library],
            "outcome": folder.path().join("outcome"),
        });
        let mut worker = Command::new(WORKER)
            .arg(gmsh::WORKER_COMMAND)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut input = worker.stdin.take().unwrap();
        writeln!(input, "{request}").unwrap();
        let output = BufReader::new(worker.stdout.take().unwrap());
        let begun = output
            .lines()
            .any(|line| line.unwrap().contains("the loop begins"));
        assert!(begun, "the worker must be at work before it is left alone");
        assert!(worker.try_wait().unwrap().is_none());
        drop(input);
        let start = Instant::now();
        while worker.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(10) {
            std::thread::sleep(Duration::from_millis(10));
        }
        let ended = worker.try_wait().unwrap().is_some();
        if !ended {
            worker.kill().unwrap();
        }
        assert!(ended);
    }
}

#[test]
fn a_library_that_does_not_load_is_named_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("libgmsh.so.4.99");
    std::fs::write(&broken, "no library at all ".repeat(100)).unwrap();
    let error = failure(&broken, &cantilever());
    let GmshError::LibraryNotLoaded { tried } = &error else {
        panic!("{error}");
    };
    assert_eq!(tried[0].0, broken);
    for part in [
        "libgmsh.so.4.99",
        "invalid ELF header",
        "make setup",
        "GMSH_LIB",
    ] {
        assert!(error.to_string().contains(part), "{error}");
    }
    let error = failure(Path::new("/nonexistent/libgmsh.so"), &cantilever());
    assert!(
        matches!(error, GmshError::LibraryNotLoaded { .. }),
        "{error}"
    );
}

#[test]
fn a_worker_that_is_none_is_an_error() {
    let library = &libraries()[0];
    let with_worker = |worker: &str| {
        let options = Options {
            worker: Some(worker.into()),
            ..options(library)
        };
        gmsh::mesh(&cantilever(), &BTreeMap::new(), &options).unwrap_err()
    };
    let error = with_worker("/bin/false");
    assert!(matches!(error, GmshError::Crashed { .. }), "{error}");
    assert!(error.to_string().contains("exit code 1"), "{error}");
    let error = with_worker("/nonexistent");
    assert!(matches!(error, GmshError::Worker { .. }), "{error}");
}
