//! What Gmsh can draw in the plane goes through, with every Gmsh library of this machine: OpenCASCADE and Booleans,
//! STEP, size fields, periodic and transfinite meshes, left-over triangles, curved edges.

mod workplace;

use peristitch::fem::element;
use peristitch::gmsh::{self, Extract, Options, library};
use peristitch::mesh::{Cell, CellKind, Mesh};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::PathBuf;
use std::process::Command;
use workplace::{BINARY, Workplace, repository};

fn libraries() -> Vec<PathBuf> {
    let found = library::Places::of_this_process().search().found;
    assert!(!found.is_empty(), "run `make setup`");
    found
}

/// The mesh of a script by each library.
fn meshes(place: &Workplace, script: &str) -> Vec<Mesh> {
    place.write("geo/x.geo", script);
    let mesh = |library| {
        let options = Options {
            worker: Some(BINARY.into()),
            library: Some(library),
            ..Options::default()
        };
        let extract: Extract = gmsh::mesh(&place.path("geo/x.geo"), &BTreeMap::new(), &options)
            .unwrap_or_else(|error| panic!("{error}"));
        let mesh = extract
            .to_mesh(1.0)
            .unwrap_or_else(|error| panic!("{error}"));
        let positive =
            |cell: &Cell| element::smallest_jacobian(cell.kind, &positions(&mesh, cell)).0 > 0.0;
        assert!(mesh.cells.iter().all(positive));
        mesh
    };
    libraries().into_iter().map(mesh).collect()
}

fn positions(mesh: &Mesh, cell: &Cell) -> Vec<[f64; 2]> {
    cell.nodes().iter().map(|&node| mesh.nodes[node]).collect()
}

/// Area of a physical surface, curved edges included.
fn area(mesh: &Mesh, group: &str) -> f64 {
    let cells = mesh.surfaces[group].iter().map(|&cell| &mesh.cells[cell]);
    cells
        .map(|cell| element::area(cell.kind, &positions(mesh, cell)))
        .sum()
}

fn count(mesh: &Mesh, kind: CellKind) -> usize {
    mesh.cells.iter().filter(|cell| cell.kind == kind).count()
}

const SECOND_ORDER: &str = "Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 1;\n";

/// A plate of 4 × 2 with a hole of radius 0.5, and in it an inclusion of radius 0.3 beside.
#[test]
fn open_cascade_and_booleans_with_curved_edges() {
    let place = Workplace::new();
    let script = format!(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {{0, 0, 0, 4, 2}};\nDisk(2) = {{1, 1, 0, 0.5}};\n\
         BooleanDifference(3) = {{ Surface{{1}}; Delete; }}{{ Surface{{2}}; Delete; }};\nDisk(4) = {{3, 1, 0, 0.3}};\n\
         parts() = BooleanFragments{{ Surface{{3}}; Delete; }}{{ Surface{{4}}; Delete; }};\n\
         inside() = Surface In BoundingBox{{2.6, 0.6, -1, 3.4, 1.4, 1}};\n\
         outside() = Surface{{:}};\noutside() -= inside();\n\
         Physical Surface(\"plate\") = {{outside()}};\nPhysical Surface(\"inclusion\") = {{inside()}};\n\
         hole() = Curve In BoundingBox{{0.4, 0.4, -1, 1.6, 1.6, 1}};\nPhysical Curve(\"hole\") = {{hole()}};\n\
         Mesh.MeshSizeMax = 0.2;\n{SECOND_ORDER}"
    );
    for mesh in meshes(&place, &script) {
        // Each of n quadratic edges, of half the angle a = π/n, leaves a⁵/30 r² of its circle's area; a tenth
        // for the terms in a⁷.
        let misses = |edges: usize, radius: f64| {
            let a = PI / edges as f64;
            edges as f64 * a.powi(5) / 30.0 * radius * radius
        };
        let disc = PI * 0.3 * 0.3;
        let missed = misses(mesh.outline(&mesh.surfaces["inclusion"]).len(), 0.3);
        let inclusion = area(&mesh, "inclusion");
        assert!(((disc - inclusion) / missed - 1.0).abs() < 0.1);
        let missed = misses(mesh.curves["hole"].len(), 0.5);
        let whole = area(&mesh, "plate") + inclusion;
        assert!(((whole - (8.0 - PI * 0.25)) / missed - 1.0).abs() < 0.1);
        for edge in &mesh.curves["hole"] {
            for node in edge.nodes() {
                let [x, y] = mesh.nodes[node];
                assert!(((x - 1.0).hypot(y - 1.0) - 0.5).abs() < 1e-9);
            }
        }
    }
}

/// A STEP file of a plate of 40 mm × 20 mm with a hole: merged as it is in millimetres, with
/// Geometry.OCCTargetUnit = "M" in metres. Its content is part of the manifest.
#[test]
fn step_files_in_millimetres_or_metres() {
    let place = Workplace::new();
    let step = "import gmsh, sys\ngmsh.initialize()\ngmsh.option.setNumber('General.Terminal', 0)\n\
                a = gmsh.model.occ.addRectangle(0, 0, 0, 40, 20)\nb = gmsh.model.occ.addDisk(20, 10, 0, 5, 5)\n\
                gmsh.model.occ.cut([(2, a)], [(2, b)])\ngmsh.model.occ.synchronize()\ngmsh.write(sys.argv[1])\n";
    let python = repository().join(".venv/bin/python3");
    let made = Command::new(python)
        .args(["-c", step])
        .arg(place.path("geo/part.step"))
        .output();
    let made = made.expect("Python starts");
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let script = |unit: &str| {
        format!(
            "SetFactory(\"OpenCASCADE\");\n{unit}Merge \"part.step\";\nPhysical Surface(\"plate\") = {{1}};\n\
             left() = Curve In BoundingBox{{-1e-3, -1, -1, 1e-3, 100, 1}};\nPhysical Curve(\"left\") = {{left()}};\n\
             Mesh.MeshSizeFactor = 0.5;\n{SECOND_ORDER}"
        )
    };
    let expected = 800.0 - PI * 25.0;
    for mesh in meshes(&place, &script("")) {
        assert!((area(&mesh, "plate") / expected - 1.0).abs() < 1e-3);
        assert!(!mesh.curves["left"].is_empty());
    }
    for mesh in meshes(&place, &script("Geometry.OCCTargetUnit = \"M\";\n")) {
        assert!((1e6 * area(&mesh, "plate") / expected - 1.0).abs() < 1e-3);
    }
    // A file in metres, of the same numbers.
    let text = String::from_utf8(place.read("geo/part.step")).expect("text");
    let metres = text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)");
    assert_ne!(metres, text);
    place.write("geo/metres.step", metres);
    let script_of = |unit: &str| script(unit).replace("part.step", "metres.step");
    for mesh in meshes(&place, &script_of("Geometry.OCCTargetUnit = \"M\";\n")) {
        assert!((area(&mesh, "plate") / expected - 1.0).abs() < 1e-3);
    }
    for mesh in meshes(&place, &script_of("")) {
        assert!((1e-6 * area(&mesh, "plate") / expected - 1.0).abs() < 1e-3);
    }
    // Through the pipeline: `unit: mm`, and the CAD file alone says what is missing.
    place.write("geo/x.geo", script(""));
    let pipeline = "name: bar\ngeometry: { file: geo/x.geo, unit: mm }\nmaterials: { m: { young: 1 GPa, poisson: 0.3 } }\n\
                    regions: [ { group: plate, model: fem, material: m } ]\n\
                    boundary: [ { group: left, displacement: { x: 0, y: 0 } } ]\noutput: { pictures: false }\n";
    place.write("bar.yaml", pipeline);
    place.run(&[]);
    let manifest = String::from_utf8(place.read("results/bar/.stamps/mesh.json")).expect("JSON");
    assert!(manifest.contains("part.step"), "{manifest}");
    place.edit("bar.yaml", "geo/x.geo", "geo/part.step");
    let bare = place.call(&["check", "bar.yaml"]);
    assert_eq!(bare.code, Some(2));
    for part in [
        "the geometry has no physical surface",
        "write a .geo beside it",
        "Merge \"part.step\";",
    ] {
        assert!(bare.err.contains(part), "{}", bare.err);
    }
}

const SQUARE: &str = "Point(1) = {0, 0, 0};\nPoint(2) = {1, 0, 0};\nPoint(3) = {1, 1, 0};\nPoint(4) = {0, 1, 0};\n\
                      Line(1) = {1, 2};\nLine(2) = {2, 3};\nLine(3) = {3, 4};\nLine(4) = {4, 1};\n\
                      Curve Loop(1) = {1, 2, 3, 4};\nPlane Surface(1) = {1};\nPhysical Surface(\"square\") = {1};\n\
                      Physical Curve(\"left\") = {4};\nPhysical Curve(\"right\") = {2};\n";

#[test]
fn size_fields_grade_the_mesh() {
    let place = Workplace::new();
    // PointsList is NodesList before Gmsh 4.7.
    let script = format!(
        "{SQUARE}Field[1] = Distance;\nField[1].PointsList = {{1}};\nField[2] = Threshold;\nField[2].InField = 1;\n\
         Field[2].SizeMin = 0.01;\nField[2].SizeMax = 0.1;\nField[2].DistMin = 0.1;\nField[2].DistMax = 0.6;\n\
         Background Field = 2;\nMesh.MeshSizeExtendFromBoundary = 0;\nMesh.MeshSizeFromPoints = 0;\n"
    );
    for mesh in meshes(&place, &script) {
        assert!((area(&mesh, "square") - 1.0).abs() < 1e-12);
        let sizes = |near: bool| {
            let at = |cell: &&Cell| {
                let [x, y] = mesh.nodes[cell.nodes()[0]];
                (x.hypot(y) < 0.1) == near && (x.hypot(y) > 0.8) != near
            };
            let cells: Vec<&Cell> = mesh.cells.iter().filter(at).collect();
            let total: f64 = cells
                .iter()
                .map(|cell| element::area(cell.kind, &positions(&mesh, cell)))
                .sum();
            // The side of the equilateral triangle of the mean area.
            (total / cells.len() as f64 * 4.0 / 3f64.sqrt()).sqrt()
        };
        assert!((sizes(true) / 0.01 - 1.0).abs() < 0.25, "{}", sizes(true));
        assert!((sizes(false) / 0.1 - 1.0).abs() < 0.25, "{}", sizes(false));
    }
}

#[test]
fn periodic_curves_have_nodes_at_equal_heights() {
    let place = Workplace::new();
    let script = format!(
        "{SQUARE}Transfinite Curve {{4}} = 8 Using Progression 1.3;\nPeriodic Curve {{2}} = {{-4}};\n\
         Mesh.MeshSizeMax = 0.3;\n{SECOND_ORDER}"
    );
    for mesh in meshes(&place, &script) {
        let heights = |curve: &str| {
            let nodes = mesh.curves[curve].iter().flat_map(|edge| edge.nodes());
            let mut heights: Vec<f64> = nodes.map(|node| mesh.nodes[node][1]).collect();
            heights.sort_by(f64::total_cmp);
            heights
        };
        let [left, right] = ["left", "right"].map(heights);
        assert_eq!(left.len(), 21);
        assert!(left.iter().zip(&right).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

#[test]
fn transfinite_meshes_with_a_progression() {
    let place = Workplace::new();
    let script = format!(
        "{SQUARE}Transfinite Curve {{1, -3}} = 6 Using Progression 2;\nTransfinite Curve {{2, 4}} = 4;\n\
         Transfinite Surface {{1}};\nRecombine Surface {{1}};\n{SECOND_ORDER}"
    );
    for mesh in meshes(&place, &script) {
        assert_eq!((mesh.cells.len(), count(&mesh, CellKind::Quad8)), (15, 15));
        let widths: Vec<f64> = mesh
            .cells
            .iter()
            .map(|cell| 3.0 * element::area(cell.kind, &positions(&mesh, cell)))
            .collect();
        let [low, high] =
            [f64::min, f64::max].map(|of| widths.iter().copied().reduce(of).expect("cells"));
        // 1, 2, 4, 8, 16 of 31, as near as Gmsh places nodes on a curve with a progression.
        let [low, high] = [low, high].map(|width| 31.0 * width);
        assert!(
            (low - 1.0).abs() < 1e-6 && (high - 16.0).abs() < 1e-6,
            "{low} {high}"
        );
    }
}

#[test]
fn the_size_factor_scales_all_sizes() {
    let place = Workplace::new();
    let cells = |factor: f64| {
        let script = format!("{SQUARE}Mesh.MeshSizeMax = 0.1;\nMesh.MeshSizeFactor = {factor};\n");
        meshes(&place, &script)
            .iter()
            .map(|mesh| mesh.cells.len())
            .collect::<Vec<_>>()
    };
    for (fine, coarse) in cells(0.5).into_iter().zip(cells(1.0)) {
        let ratio = fine as f64 / coarse as f64;
        assert!((3.4..4.6).contains(&ratio), "{ratio}");
    }
}

/// An odd number of edges around a pentagon cannot be all quadrilaterals.
#[test]
fn left_over_triangles_lie_beside_quadrilaterals() {
    let place = Workplace::new();
    let script = format!(
        "Point(1) = {{0, 0, 0}};\nPoint(2) = {{1, 0, 0}};\nPoint(3) = {{1.3, 0.9, 0}};\nPoint(4) = {{0.5, 1.5, 0}};\n\
         Point(5) = {{-0.3, 0.9, 0}};\nLine(1) = {{1, 2}};\nLine(2) = {{2, 3}};\nLine(3) = {{3, 4}};\nLine(4) = {{4, 5}};\n\
         Line(5) = {{5, 1}};\nTransfinite Curve {{1:5}} = 4;\nCurve Loop(1) = {{1:5}};\nPlane Surface(1) = {{1}};\n\
         Recombine Surface {{1}};\nMesh.RecombinationAlgorithm = 0;\nPhysical Surface(\"p\") = {{1}};\n{SECOND_ORDER}"
    );
    for mesh in meshes(&place, &script) {
        assert!(count(&mesh, CellKind::Tri6) % 2 == 1 && count(&mesh, CellKind::Quad8) > 0);
        assert_eq!(
            count(&mesh, CellKind::Tri6) + count(&mesh, CellKind::Quad8),
            mesh.cells.len()
        );
        // The shoelace formula.
        let expected = 0.5 * (0.9 + (1.3 * 1.5 - 0.5 * 0.9) + (0.5 * 0.9 + 0.3 * 1.5));
        assert!((area(&mesh, "p") - expected).abs() < 1e-12);
    }
}

/// The area of a disc of quadratic triangles converges with the fourth power of the size.
#[test]
fn quadratic_edges_follow_curves_with_fourth_order() {
    let place = Workplace::new();
    let errors = |edges: usize| {
        let script = format!(
            "SetFactory(\"OpenCASCADE\");\nDisk(1) = {{0, 0, 0, 1}};\nPhysical Surface(\"disc\") = {{1}};\n\
             Transfinite Curve {{:}} = {};\nMesh.MeshSizeMax = 0.5;\n{SECOND_ORDER}",
            edges + 1
        );
        let meshes = meshes(&place, &script);
        meshes
            .iter()
            .map(|mesh| (area(mesh, "disc") / PI - 1.0).abs())
            .collect::<Vec<_>>()
    };
    for (coarse, fine) in errors(12).into_iter().zip(errors(24)) {
        let order = (coarse / fine).log2();
        assert!((3.8..4.2).contains(&order), "{coarse:e}, {fine:e}");
    }
}

/// A mesh that a script merges, with a background mesh of sizes: what t17 does.
#[test]
fn merged_scripts_and_size_maps() {
    let place = Workplace::new();
    place.write("geo/square.geo", SQUARE);
    let map = "View \"size\" {\nST(0,0,0, 1,0,0, 1,1,0){0.05,0.2,0.2};\nST(0,0,0, 1,1,0, 0,1,0){0.05,0.2,0.2};\n};\n";
    place.write("geo/size.pos", map);
    let script = "Merge \"square.geo\";\nMerge \"size.pos\";\nBackground Mesh View[0];\n\
                  Mesh.MeshSizeExtendFromBoundary = 0;\nMesh.MeshSizeFromPoints = 0;\n";
    for mesh in meshes(&place, script) {
        assert!((area(&mesh, "square") - 1.0).abs() < 1e-12);
        let near = |node: &&[f64; 2]| node[0] < 0.5 && node[1] < 0.5;
        let near = mesh.nodes.iter().filter(near).count();
        assert!(
            2 * near > mesh.nodes.len(),
            "{near} of {}",
            mesh.nodes.len()
        );
    }
    let script = gmsh::GeoScript::scan(&place.path("geo/x.geo")).expect("readable");
    let names: Vec<_> = script
        .files
        .iter()
        .filter_map(|file| file.file_name()?.to_str())
        .collect();
    assert_eq!(names, ["size.pos", "square.geo", "x.geo"]);
}

#[test]
fn cubic_elements_are_refused_with_the_remedy() {
    let place = Workplace::new();
    place.write("geo/x.geo", format!("{SQUARE}Mesh.ElementOrder = 3;\n"));
    let pipeline = "name: bar\ngeometry: { file: geo/x.geo }\nmaterials: { m: { young: 1 GPa, poisson: 0.3 } }\n\
                    regions: [ { group: square, model: fem, material: m } ]\n\
                    boundary: [ { group: left, displacement: { x: 0, y: 0 } } ]\n";
    place.write("bar.yaml", pipeline);
    let ended = place.call(&["check", "bar.yaml"]);
    assert_eq!(ended.code, Some(2));
    for part in [
        "are of type 'Line 4'",
        "the order is at most 2",
        "Mesh.ElementOrder = 2;",
        "bar.yaml:2:",
    ] {
        assert!(ended.err.contains(part), "{part}: {}", ended.err);
    }
}
