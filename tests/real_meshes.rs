//! Meshes and scripts as other people write them, and the slips that are made with them: each gives the right
//! number, or one message that names the place and the remedy.

mod workplace;

use peristitch::meshio;
use serde_json::Value;
use std::path::Path;
use workplace::{Ended, Workplace, repository};

/// A folder with the files of one case.
fn case(name: &str) -> Workplace {
    let place = Workplace::new();
    let folder = repository().join("tests/cases").join(name);
    for entry in std::fs::read_dir(folder).expect("the case's folder") {
        let path = entry.expect("an entry").path();
        let file = path.file_name().expect("a name").to_owned();
        std::fs::copy(&path, place.path(Path::new(&file).to_str().expect("UTF-8")))
            .expect("a copy");
    }
    place
}

fn summary(place: &Workplace, name: &str) -> (Ended, Value) {
    let ended = place
        .call(&["run", &format!("{name}.yaml"), "--force"])
        .succeeded();
    let text = place.read(&format!("results/{name}/summary.json"));
    (ended, serde_json::from_slice(&text).expect("JSON"))
}

fn text(place: &Workplace, name: &str) -> String {
    String::from_utf8(place.read(name)).expect("UTF-8")
}

/// The reaction on a group in one direction [N].
fn reaction(summary: &Value, group: &str, axis: usize) -> f64 {
    summary["reactions_n"][group][axis]
        .as_f64()
        .expect("a number")
}

#[track_caller]
fn assert_refused(place: &Workplace, pipeline: &str, texts: &[&str]) {
    for command in ["run", "check"] {
        let ended = place.call(&[command, pipeline]);
        assert_eq!(ended.code, Some(2), "{}", ended.err);
        for text in texts {
            assert!(ended.err.contains(text), "no {text:?} in\n{}", ended.err);
        }
        assert!(!ended.err.contains("NaN"), "{}", ended.err);
    }
    assert!(!place.path("results").exists(), "nothing is written");
}

/// A plate of FE cells on a geometry or mesh, held on `left` and pulled by 1 µm at `right`.
fn plate(file: &str, regions: &[&str]) -> String {
    let region = |group: &&str| format!("  - {{ group: {group}, model: fem, material: m }}\n");
    let regions: String = regions.iter().map(region).collect();
    format!(
        "name: plate\ngeometry: {{ file: {file}, unit: mm }}\nmaterials:\n  m: {{ young: 30 GPa, poisson: 1/3 }}\n\
         regions:\n{regions}boundary:\n  - {{ group: left, displacement: {{ x: 0, y: 0 }} }}\n  - {{ group: right, \
         displacement: {{ x: 1 µm }} }}\noutput: {{ pictures: false }}\n"
    )
}

fn plate_on(script: &str, regions: &[&str]) -> Workplace {
    let place = Workplace::new();
    place.write("plate.geo", script);
    place.write("plate.yaml", plate("plate.geo", regions));
    place
}

// --- Elements twice ---

#[test]
fn an_element_of_two_groups_in_msh_2_2_counts_once() {
    let (_, summary) = summary(&case("01_msh22_twice"), "plate22");
    // 30 GPa × 4 µm / 40 mm × 20 mm × 2 mm.
    assert!(
        (reaction(&summary, "left", 0) + 120.0).abs() < 1e-6,
        "{summary}"
    );
}

#[test]
fn two_surfaces_on_one_loop_are_refused() {
    let place = plate_on(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,4,2};\nPlane Surface(2) = {1};\n\
         Physical Surface(\"plate\") = {1,2};\nPhysical Curve(\"left\") = {4};\nPhysical Curve(\"right\") = {2};\n\
         Mesh.MeshSizeMax = 0.5;\n",
        &["plate"],
    );
    assert_refused(
        &place,
        "plate.yaml",
        &[
            "lie on the same side of their common edge near",
            "drawn twice",
        ],
    );
}

#[test]
fn two_surfaces_on_one_loop_do_no_harm_where_one_is_not_computed_on() {
    let place = plate_on(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,4,2};\nPlane Surface(2) = {1};\n\
         Physical Surface(\"plate\") = {1};\nPhysical Surface(\"other\") = {2};\nPhysical Curve(\"left\") = {4};\n\
         Physical Curve(\"right\") = {2};\n",
        &["plate"],
    );
    place.call(&["run", "plate.yaml"]).succeeded();
}

// --- The mesh that a script made ---

#[test]
fn an_internal_crack_of_a_script_stays_open() {
    let (_, summary) = summary(&case("02_script_mesh_replaced"), "internal_crack");
    // 30.47 kN without the crack.
    let force = reaction(&summary, "top", 1);
    assert!((force / 24_160.0 - 1.0).abs() < 1e-3, "{force}");
}

#[test]
fn an_edge_crack_of_a_script_stays_open_and_is_no_slip() {
    let (ended, summary) = summary(&case("02_script_mesh_replaced"), "crack");
    assert_eq!(summary["sizes"]["finite_element_nodes"], 525);
    // 42.7 kN at a thickness of 2 mm, 1 mm here.
    let force = reaction(&summary, "top", 1);
    assert!((force / 21_350.0 - 1.0).abs() < 2e-3, "{force}");
    assert!(!ended.err.contains("warning"), "{}", ended.err);
}

#[test]
fn recombination_and_order_of_a_script_stay() {
    let place = case("02_script_mesh_replaced");
    let (_, recombined) = summary(&place, "recombine");
    assert_eq!(recombined["sizes"]["finite_elements"], 471);
    let order =
        text(&place, "recombine.geo").replace("RecombineMesh;", "SetOrder 2;\nSave \"x.msh\";");
    place.write("recombine.geo", order);
    let (ended, second) = summary(&place, "recombine");
    assert_eq!(second["sizes"]["finite_elements"], 952);
    assert_eq!(second["sizes"]["finite_element_nodes"], 1985);
    assert!(
        ended.err.contains("recombine.geo:4: `Save` is passed over"),
        "{}",
        ended.err
    );
    assert!(!place.path("x.msh").exists());
}

#[test]
fn what_a_script_has_not_meshed_is_meshed() {
    let place = plate_on(
        "Point(1) = {0,0,0,0.5}; Point(2) = {2,0,0,0.5}; Point(3) = {2,2,0,0.5}; Point(4) = {0,2,0,0.5};\n\
         Line(1) = {1,2}; Line(2) = {2,3}; Line(3) = {3,4}; Line(4) = {4,1};\n\
         Curve Loop(1) = {1,2,3,4}; Plane Surface(1) = {1};\nMesh 2;\nSetOrder 2;\n\
         Point(5) = {4,0,0,0.5}; Point(6) = {4,2,0,0.5}; Line(5) = {2,5}; Line(6) = {5,6}; Line(7) = {6,3};\n\
         Curve Loop(2) = {5,6,7,-2}; Plane Surface(2) = {2};\n\
         Physical Surface(\"a\") = {1}; Physical Surface(\"b\") = {2};\n\
         Physical Curve(\"left\") = {4}; Physical Curve(\"right\") = {6};\n",
        &["a", "b"],
    );
    let (_, summary) = summary(&place, "plate");
    let nodes = summary["sizes"]["finite_element_nodes"]
        .as_u64()
        .expect("a count");
    let elements = summary["sizes"]["finite_elements"]
        .as_u64()
        .expect("a count");
    // Six-node triangles have about two nodes each, three-node ones half of one.
    assert!(nodes > 2 * elements, "{nodes} nodes, {elements} elements");
    assert!(
        reaction(&summary, "right", 0) > 14e3,
        "both parts carry: {summary}"
    );
}

// --- Cells that do not fit together ---

#[test]
fn eight_node_beside_four_node_elements_are_refused_at_their_edge() {
    let place = case("03_mixed_order");
    let edge = "element 4 (quad8) and element 101 (quad4) in plate.inp share the ends of an edge near (20, 2.5)";
    assert_refused(
        &place,
        "mixed_order.yaml",
        &[edge, "give neighbours the same order"],
    );
}

#[test]
fn two_small_elements_beside_a_large_one_are_refused() {
    let nodes = "*NODE\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,2,0\n6,2,1\n7,1,0.5\n8,2,0.5\n";
    let large = "*ELEMENT,TYPE=CPS4,ELSET=all\n1,1,2,3,4\n";
    let eight = "9,0.5,0\n10,0.5,1\n11,0,0.5\n*ELEMENT,TYPE=CPS8,ELSET=all\n1,1,2,3,4,9,7,10,11\n";
    let small = "*ELEMENT,TYPE=CPS4,ELSET=all\n2,2,5,8,7\n3,7,8,6,3\n*NSET,NSET=left\n1,4\n*NSET,NSET=right\n5,8,6\n";
    let place = Workplace::new();
    place.write("plate.yaml", plate("plate.inp", &["all"]));
    place.write("plate.inp", format!("{nodes}{large}{small}"));
    assert_refused(
        &place,
        "plate.yaml",
        &[
            "lies within an edge of element 1 (quad4) near (1, 0.5)",
            "share all nodes",
        ],
    );
    // The middle node is theirs, and the edge still bends where theirs does not.
    place.write("plate.inp", format!("{nodes}{eight}{small}"));
    assert_refused(
        &place,
        "plate.yaml",
        &["element 1 (quad8)", "give neighbours the same order"],
    );
}

// --- Parts that are not joined ---

#[test]
fn a_disk_on_a_rectangle_is_refused_with_the_remedy() {
    let place = case("04_not_fragmented");
    assert_refused(
        &place,
        "not_fragmented.yaml",
        &[
            "of `plate`",
            "of `inclusion` in overlap.geo lie on each other near",
            "BooleanFragments",
            "Coherence",
        ],
    );
}

#[test]
fn rectangles_side_by_side_are_reported_with_the_remedy() {
    let place = case("04_not_fragmented");
    let warning =
        "`a` and `b` lie side by side near (20, 1) over a length of 24, and share no nodes there";
    for command in ["check", "run"] {
        let ended = place.call(&[command, "not_joined.yaml"]).succeeded();
        assert!(
            ended.err.contains(warning) && ended.err.contains("BooleanFragments"),
            "{}",
            ended.err
        );
        assert!(!ended.err.contains("NaN"), "{}", ended.err);
    }
    // Joined, there is nothing to report, and both parts carry.
    let script = text(&place, "touch.geo")
        .replace(
            "Physical Surface(\"a\")",
            "Coherence;\nPhysical Surface(\"a\")",
        )
        .replace("{4}", "{Curve In BoundingBox{-1,-1,-1,1,25,1}}")
        .replace("{6}", "{Curve In BoundingBox{39,-1,-1,41,25,1}}");
    place.write("touch.geo", script);
    let ended = place.call(&["check", "not_joined.yaml"]).succeeded();
    assert!(!ended.err.contains("warning"), "{}", ended.err);
}

#[test]
fn a_part_that_nothing_holds_is_explained_by_the_missing_joint() {
    let place = case("04_not_fragmented");
    place.edit("not_joined.yaml", "{ x: 1 µm, y: 0 }", "{ x: 1 µm }");
    let script = text(&place, "touch.geo").replace(
        "MeshSizeMax = 2",
        "MeshSizeMax = 2;\nTransfinite Curve{8} = 6",
    );
    place.write("touch.geo", script);
    assert_refused(
        &place,
        "not_joined.yaml",
        &[
            "region `b` is tied to nothing that is held",
            "lie side by side",
            "BooleanFragments",
        ],
    );
}

// --- Groups ---

#[test]
fn a_misspelt_group_is_told_before_meshing() {
    let place = case("14_typo_after_meshing");
    // Gmsh would not end within the test: the message has to come before.
    let fine = text(&place, "fine.geo").replace("0.12", "0.001");
    place.write("fine.geo", fine);
    assert_refused(
        &place,
        "typo.yaml",
        &[
            "there is no physical surface `plat`",
            "did you mean `plate`?",
        ],
    );
}

#[test]
fn check_keeps_the_mesh_for_the_run() {
    let place = plate_on(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,4,2};\nPhysical Surface(\"plate\") = {1};\n\
         Physical Curve(\"left\") = {4};\nPhysical Curve(\"right\") = {2};\n",
        &["plate"],
    );
    place.call(&["check", "plate.yaml"]).succeeded();
    let ended = place.call(&["run", "plate.yaml"]).succeeded();
    assert_eq!(ended.stages(), ["solve", "output"], "{}", ended.err);
}

#[test]
fn groups_that_no_region_names_do_not_count() {
    let place = plate_on(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,4,2};\nBox(1) = {6,0,0,1,1,1};\n\
         Physical Surface(\"plate\") = {1};\nPhysical Curve(\"left\") = {4};\nPhysical Curve(\"right\") = {2};\n\
         Physical Volume(\"block\") = {1};\nPhysical Surface(\"face\") = {7};\n",
        &["plate"],
    );
    place.call(&["run", "plate.yaml"]).succeeded();
}

#[test]
fn warnings_of_gmsh_are_at_most_five_and_a_count() {
    let mut script = String::from(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,4,2};\nPhysical Surface(\"plate\") = {1};\n\
         Physical Curve(\"left\") = {4};\nPhysical Curve(\"right\") = {2};\n",
    );
    for number in 1..=9 {
        script += &format!("Warning(\"slip {number}\");\n");
    }
    let place = plate_on(&script, &["plate"]);
    for command in ["check", "run"] {
        let ended = place.call(&[command, "plate.yaml"]).succeeded();
        assert_eq!(
            ended.err.matches("warning: Gmsh: slip").count(),
            5,
            "{command}: {}",
            ended.err
        );
        assert!(
            ended.err.contains("warning: Gmsh: 4 more warnings"),
            "{command}: {}",
            ended.err
        );
    }
}

// --- Formats ---

#[test]
fn nastran_elements_with_an_angle_and_blank_continuations_are_read() {
    let (_, four) = summary(&case("07_nastran_theta"), "theta");
    let (_, eight) = summary(&case("08_nastran_quad8_blank"), "quad8");
    for summary in [&four, &eight] {
        assert_eq!(summary["sizes"]["finite_elements"], 128);
    }
    // Two materials in a row: the same body, by elements of two orders.
    let [a, b] = [&four, &eight].map(|summary| reaction(summary, "302", 0));
    assert!((a / b - 1.0).abs() < 2e-3, "{a} {b}");
}

#[test]
fn integers_of_a_legacy_vtk_make_groups() {
    let (_, summary) = summary(&case("09_vtk_legacy"), "v_pva");
    assert_eq!(summary["sizes"]["finite_elements"], 128);
}

#[test]
fn what_meshio_cannot_read_comes_with_the_way_out() {
    let place = case("09_vtk_legacy");
    place.edit("v_pva.yaml", "v_pva.vtk", "v_bin_nocomp.vtu");
    assert_refused(
        &place,
        "v_pva.yaml",
        &[
            "meshio cannot read it",
            "save it as .vtu with the data mode Appended",
        ],
    );
}

#[test]
fn med_groups_may_have_any_letters() {
    let (_, summary) = summary(&case("10_med"), "utf8");
    assert!(reaction(&summary, "right-end", 0) > 0.0);
}

const FORMATS: &str = r#"
import h5py, meshio, numpy, re, shutil, vtk
nodes = numpy.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], float)
cells = [("quad", numpy.array([[0, 1, 4, 3], [1, 2, 5, 4]]))]
meshio.Mesh(nodes, cells, cell_data={"avsucd:material": [numpy.array([4, 5])]}).write("avs.inp", file_format="avsucd")
meshio.Mesh(nodes, cells, cell_data={"zone": [numpy.array([4, 5])]}).write("one.vtu", binary=False)
text = open("one.vtu").read()
open("two.vtu", "w").write(re.sub('(<VTKFile[^>]*version=")[0-9.]+', r"\g<1>2.2", text))
grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
for node in nodes:
    points.InsertNextPoint(*node)
grid.SetPoints(points)
for corners in cells[0][1]:
    grid.InsertNextCell(vtk.VTK_QUAD, 4, corners.tolist())
zone = vtk.vtkIntArray()
zone.SetName("zone")
for value in (4, 5):
    zone.InsertNextValue(value)
grid.GetCellData().AddArray(zone)
for name, binary in (("ascii.vtk", False), ("binary.vtk", True)):
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(name)
    if binary:
        writer.SetFileTypeToBinary()
    writer.Write()
for name in ("nogroups.med", "polygons.med"):
    shutil.copy("utf8.med", name)
with h5py.File("nogroups.med", "a") as file:
    found = []
    file["FAS"].visititems(lambda name, entry: found.append(entry.name) if name.endswith("/GRO") else None)
    del file[found[0]]
with h5py.File("polygons.med", "a") as file:
    found = []
    file["ENS_MAA"].visititems(lambda name, entry: found.append(entry.name) if name.endswith("/MAI") else None)
    file[found[0]].create_group("POG")
"#;

#[test]
fn other_ways_of_the_formats_are_read_or_come_with_the_way_out() {
    let place = case("10_med");
    let python = repository().join(".venv/bin/python3");
    let made = std::process::Command::new(python)
        .args(["-c", FORMATS])
        .current_dir(place.path("."))
        .output()
        .expect("Python starts");
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let read = |file: &str| meshio::mesh(&place.path(file), &meshio::Options::default());
    for (file, groups) in [
        ("avs.inp", &["4", "5"][..]),
        ("two.vtu", &["zone=4", "zone=5"]),
        ("ascii.vtk", &["zone=4", "zone=5"]),
    ] {
        let mesh = read(file).expect(file).to_mesh(1.0).expect("sound");
        assert_eq!(mesh.surfaces.keys().collect::<Vec<_>>(), groups, "{file}");
        assert_eq!(mesh.cells.len(), 2, "{file}");
    }
    // One family has lost its groups, and the others are read.
    let names = read("nogroups.med").expect("a mesh").groups;
    assert!(names.len() >= 4, "{names:?}");
    for (file, message) in [
        (
            "polygons.med",
            "polygons, which are no elements of this program: mesh the surface with triangles",
        ),
        ("binary.vtk", "save it as .vtu"),
    ] {
        let error = read(file).expect_err(file).to_string();
        assert!(error.contains(message), "{error}");
        assert!(!error.contains("Error:"), "no words of Python: {error}");
    }
}

// --- Places by position ---

/// 40 × 20 mm in two materials' worth of surfaces, with names for two sides.
const SIDES: &str = "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,40,20};\nRectangle(2) = {40,0,0,40,20};\n\
    Coherence;\nPhysical Surface(\"a\") = {1};\nPhysical Surface(\"b\") = {2};\n\
    Physical Curve(\"left\") = {Curve In BoundingBox{-1,-1,-1,1,21,1}};\n\
    Physical Curve(\"right\") = {Curve In BoundingBox{79,-1,-1,81,21,1}};\nMesh.MeshSizeMax = 4;\n";

#[test]
fn a_side_by_position_is_the_side_by_name() {
    let place = plate_on(SIDES, &["a", "b"]);
    let (_, named) = summary(&place, "plate");
    place.edit("plate.yaml", "group: left", "where: { x: min }");
    for right in [
        "{ x: max }",
        "{ x: 80 mm }",
        "{ box: [[79.9 mm, -1 mm], [81 mm, 21 mm]] }",
        "{ between: [[80 mm, 0], [80 mm, 20 mm]] }",
    ] {
        place.write(
            "other.yaml",
            text(&place, "plate.yaml").replace("group: right", &format!("where: {right}")),
        );
        place.edit("other.yaml", "name: plate", "name: other");
        let (_, placed) = summary(&place, "other");
        let expected = reaction(&named, "left", 0);
        let found = reaction(&placed, "x = min", 0);
        assert!(
            (found / expected - 1.0).abs() < 1e-12,
            "{right}: {found} {expected}"
        );
    }
}

#[test]
fn corners_points_and_inner_lines_are_places() {
    let place = plate_on(SIDES, &["a", "b"]);
    let held = "- { where: { x: min, y: min }, displacement: { x: 0, y: 0 } }\n  - { where: { near: [1 mm, 19 mm] }, \
                displacement: { x: 0 } }\n  - { where: { x: 40 mm }, displacement: { x: 2 µm } }";
    place.edit(
        "plate.yaml",
        "- { group: left, displacement: { x: 0, y: 0 } }",
        held,
    );
    let (_, summary) = summary(&place, "plate");
    let reactions = summary["reactions_n"].as_object().expect("an object");
    let names: Vec<&str> = reactions.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "near (1 mm, 19 mm)",
            "right",
            "x = 40 mm",
            "x = min, y = min"
        ]
    );
    let sum: f64 = names.iter().map(|name| reaction(&summary, name, 0)).sum();
    let largest = names
        .iter()
        .map(|name| reaction(&summary, name, 0).abs())
        .fold(0.0, f64::max);
    assert!(sum.abs() < 1e-9 * largest, "{summary}");
}

#[test]
fn a_point_by_position_acts_on_material_points() {
    let place = plate_on(SIDES, &["a"]);
    let lattice = "  - { group: b, model: peridynamics, material: m, spacing: 2 mm, horizon: 3 }\n";
    place.edit(
        "plate.yaml",
        "boundary:\n",
        &format!("{lattice}boundary:\n"),
    );
    place.edit(
        "plate.yaml",
        "{ group: right, displacement: { x: 1 µm } }",
        "{ where: { near: [75 mm, 9 mm] }, force: { x: 1 kN } }",
    );
    let (_, summary) = summary(&place, "plate");
    assert!(
        (reaction(&summary, "left", 0) + 1e3).abs() < 1e-6,
        "{summary}"
    );
}

#[test]
fn a_place_at_which_there_is_nothing_is_told_with_what_there_is() {
    for (written, texts) in [
        (
            "{ x: 80 }",
            &[
                "`x = 80`: no node of the body lies there",
                "(0, 0) to (0.08, 0.02) m",
                "a bare number is in metres",
            ][..],
        ),
        ("{ near: [1, 0] }", &["no node of the body lies there"]),
        (
            "{ between: [[80 mm, 0], [80 mm, 11 mm]] }",
            &[
                "(0.08, 0.011) m is no node of the outline",
                "nearest are at",
            ],
        ),
        ("{ x: left }", &["`left` is no coordinate", "`min`, `max`"]),
        (
            "{ x: min, near: [0, 0] }",
            &["a place is given in one way", "{ x: min }"],
        ),
        ("{}", &["a place is given in one way"]),
        ("{ z: min }", &["unknown key `z`"]),
    ] {
        let place = plate_on(SIDES, &["a", "b"]);
        place.edit("plate.yaml", "group: right", &format!("where: {written}"));
        assert_refused(&place, "plate.yaml", texts);
    }
    let place = plate_on(SIDES, &["a", "b"]);
    place.edit(
        "plate.yaml",
        "group: right",
        "group: right, where: { x: max }",
    );
    assert_refused(&place, "plate.yaml", &["a `group` or a `where`, not both"]);
    place.edit(
        "plate.yaml",
        "group: right, where: { x: max }",
        "phase: none",
    );
    assert_refused(
        &place,
        "plate.yaml",
        &["this entry names no place", "where: { x: min }"],
    );
}

#[test]
fn cards_of_nastran_that_list_nodes_are_groups() {
    let place = case("18_no_curve_groups");
    assert_refused(
        &place,
        "n_spc.yaml",
        &[
            "there is no physical curve or point `301`",
            "`SPC=1`",
            "where: { x: min }",
        ],
    );
    place.edit("n_spc.yaml", "group: 301", "group: SPC=1");
    place.edit("n_spc.yaml", "group: 302", "where: { x: max }");
    let (_, by_card) = summary(&place, "n_spc");
    assert!(reaction(&by_card, "x = max", 0) > 0.0, "{by_card}");
}

#[test]
fn a_mesh_without_groups_is_one_region() {
    let place = plate_on(
        "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0,0,0,40,20};\nMesh.MeshSizeMax = 4;\n",
        &["all"],
    );
    place.edit("plate.yaml", "group: left", "where: { x: min }");
    place.edit("plate.yaml", "group: right", "where: { x: max }");
    let (_, script) = summary(&place, "plate");
    // 30 GPa × 1 µm / 40 mm × 20 mm × 1 m, stiffer by the clamp.
    let force = reaction(&script, "x = max", 0);
    assert!((1.0..1.1).contains(&(force / 15e3)), "{force}");
    place.write(
        "mesh.bdf",
        "GRID,1,,0.,0.,0.\nGRID,2,,40.,0.,0.\nGRID,3,,40.,20.,0.\nGRID,4,,0.,20.,0.\nCQUAD4,1,,1,2,3,4\n",
    );
    place.edit("plate.yaml", "plate.geo", "mesh.bdf");
    let (_, deck) = summary(&place, "plate");
    let force = reaction(&deck, "x = max", 0);
    assert!((1.0..1.1).contains(&(force / 15e3)), "{force}");
    place.edit("plate.yaml", "group: all", "group: plate");
    place.edit("plate.yaml", "mesh.bdf", "plate.geo");
    let ended = place.call(&["run", "plate.yaml"]);
    assert_eq!(ended.code, Some(2), "{}", ended.err);
    assert!(ended.err.contains("`group: all`"), "{}", ended.err);
}

/// Two six-node triangles in MSH 2.2 whose sides are lines of two nodes: the middle nodes are held and moved too.
/// Held sideways as well, σ_x is E/(1 − ν²) ε_x, and the side of 1 mm × 1 m bears 30e9 · 9/8 · 1e-3 · 1e-3 N.
#[test]
fn two_node_lines_along_six_node_triangles_hold_their_middle_nodes() {
    let place = Workplace::new();
    let nodes =
        "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 .5 0 0\n6 1 .5 0\n7 .5 1 0\n8 0 .5 0\n9 .5 .5 0\n";
    let lines = "1 1 2 2 4 4 1\n2 1 2 3 2 2 3\n3 1 2 4 1 1 2\n4 1 2 4 3 3 4\n";
    let triangles = "5 9 2 1 1 1 2 3 5 6 9\n6 9 2 1 1 1 3 4 9 7 8\n";
    place.write(
        "plate.msh",
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"plate\"\n1 2 \"left\"\n1 3 \"right\"\n\
             1 4 \"long\"\n$EndPhysicalNames\n$Nodes\n9\n{nodes}$EndNodes\n$Elements\n6\n{lines}{triangles}\
             $EndElements\n"
        ),
    );
    let sides = "  - { group: long, displacement: { y: 0 } }\noutput:";
    let pipeline = plate("plate.msh", &["plate"]).replace("output:", sides);
    place.write("plate.yaml", pipeline);
    let force = reaction(&summary(&place, "plate").1, "right", 0);
    // A uniform strain is exact; 25 % less with free middle nodes.
    assert!((force / 33_750.0 - 1.0).abs() < 1e-9, "{force}");
}

// --- Half models ---

/// A roller on the ligament of a lattice that can crack, however it is written, and none where it cannot.
#[test]
fn a_roller_on_a_straight_side_of_a_breakable_lattice_is_told() {
    let place = case("17_half_model");
    let told = "holds a straight side of `plate` along its normal";
    let half = text(&place, "sym_half.yaml");
    let roller = "{ group: ligament, displacement: { y: 0 } }";
    let is_told = |name: &str, change: [&str; 2]| {
        let text = half.replace("sym_half\n", &format!("{name}\n"));
        assert!(text.contains(change[0]), "{name}");
        let file = format!("{name}.yaml");
        place.write(&file, text.replace(change[0], change[1]));
        place.call(&["check", &file]).succeeded().err.contains(told)
    };
    assert!(is_told("as_it_is", ["", ""]));
    let others = [
        "{ where: { between: [[16 mm, 0], [40 mm, 0]] }, displacement: { y: 0 } }",
        "{ group: ligament, displacement: { normal: 0 } }",
        "{ group: ligament, displacement: { x: 0, angle: 90 deg } }",
    ];
    for (k, other) in others.into_iter().enumerate() {
        assert!(is_told(&format!("same_{k}"), [roller, other]), "{other}");
    }
    let harmless = [
        [roller, "{ group: ligament, displacement: { x: 0, y: 0 } }"],
        [roller, "{ group: ligament, displacement: { y: 1 µm } }"],
        ["loading:", "no_fail: [plate]\nloading:"],
        [
            "loading: { control: event-driven, steps: 60 }\noutput: { pictures: [damage], every: 100 }\n",
            "",
        ],
    ];
    for (k, change) in harmless.into_iter().enumerate() {
        assert!(!is_told(&format!("harmless_{k}"), change), "{change:?}");
    }
    let full = place.call(&["check", "sym_full.yaml"]).succeeded();
    assert!(!full.err.contains("along its normal"), "{}", full.err);
}
