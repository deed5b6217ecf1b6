//! Meshes of other programs, through meshio: the same mesh in every format gives the same solution; sets become
//! groups; what cannot be read is named.

mod workplace;

use peristitch::gmsh::Extract;
use peristitch::mesh::{CellKind, Mesh};
use peristitch::meshio::{self, Options};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::Duration;
use workplace::{PIPELINE, Workplace, repository};

/// Displacements of the hybrid bar in six places: x, y [mm].
const PLACES: [[f64; 2]; 6] = [
    [1000.0, 100.0],
    [1000.0, 0.0],
    [400.0, 100.0],
    [600.0, 200.0],
    [500.0, 93.75],
    [250.0, 50.0],
];

fn python() -> std::path::PathBuf {
    let python = repository().join(".venv/bin/python3");
    assert!(python.exists(), "run `make setup`");
    python
}

/// The small bar on `file` with probes all over, its groups renamed.
fn pipeline(file: &str, rename: &[(&str, &str)]) -> String {
    let mut text = PIPELINE.replace("geo/bar.geo", file);
    if !file.ends_with(".geo") {
        text = text.replace("  parameters: { element: 50, order: 2 }\n", "");
    }
    for (k, [x, y]) in PLACES.iter().enumerate() {
        for axis in ["x", "y"] {
            text += &format!("  p{k}{axis}: {{ at: [{x} mm, {y} mm], component: {axis} }}\n");
        }
    }
    for (old, new) in rename {
        text = text.replace(old, new);
    }
    text
}

fn summary(place: &Workplace, text: &str) -> Value {
    place.write("bar.yaml", text);
    place.call(&["run", "bar.yaml", "--force"]).succeeded();
    place.summary()
}

/// All displacements that the probes read, and the sum of the reaction.
fn numbers(summary: &Value) -> Vec<f64> {
    let probes = summary["probes"].as_array().expect("probes");
    let probes = probes.iter().map(|probe| &probe["displacement_m"]);
    let reactions = summary["reactions_n"].as_object().expect("reactions");
    let reactions = reactions
        .values()
        .flat_map(|r| r.as_array().expect("two components"));
    let all = probes.chain(reactions.take(1));
    all.map(|number| number.as_f64().expect("a number"))
        .collect()
}

#[test]
fn every_format_gives_the_solution_of_the_geometry() {
    let place = Workplace::new();
    let exported = Command::new(python())
        .arg(repository().join("tests/python/export_meshes.py"))
        .arg(place.path("geo/bar.geo"))
        .arg(place.path("geo"))
        .args(["element=50", "order=2"])
        .output()
        .expect("Python starts");
    assert!(
        exported.status.success(),
        "{}",
        String::from_utf8_lossy(&exported.stderr)
    );
    let reference = summary(&place, &pipeline("geo/bar.geo", &[]));
    let expected = numbers(&reference);
    let scale = expected[0].abs();
    let nastran = [
        ("[left, right]", "[1, 3]"),
        ("group: band", "group: 2"),
        ("group: clamp", "group: 204"),
        ("group: load", "group: 205"),
    ];
    // Where every digit is written, the same bits. meshio writes 12 digits into a .bdf, Gmsh 14 into an .inp.
    for (file, rename, tolerance) in [
        ("mesh.inp", &[][..], 0.0),
        ("mesh.bdf", &nastran[..], 1e-12),
        ("mesh.vtu", &[], 0.0),
        ("mesh.vtk", &[], 0.0),
        ("mesh.med", &[], 0.0),
        ("gmsh.inp", &[], 1e-11),
        ("gmsh.med", &[], 0.0),
        ("mesh22.msh", &[], 0.0),
        ("mesh41.msh", &[], 0.0),
    ] {
        let summary = summary(&place, &pipeline(&format!("geo/{file}"), rename));
        for key in [
            "finite_elements",
            "finite_element_nodes",
            "material_points",
            "bonds",
            "dofs",
        ] {
            assert_eq!(
                summary["sizes"][key], reference["sizes"][key],
                "{file}: {key}"
            );
        }
        let found = numbers(&summary);
        assert_eq!(found.len(), expected.len());
        for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
            // Displacements against the tip's, the reaction against itself.
            let unit = if k < 2 * PLACES.len() + 1 {
                scale
            } else {
                b.abs()
            };
            assert!(
                (a - b).abs() <= tolerance * unit,
                "{file}, number {k}: {a:e}, {b:e}"
            );
        }
        let program = if file.ends_with(".msh") {
            "gmsh"
        } else {
            "meshio"
        };
        assert!(summary["versions"][program].is_string(), "{file}");
    }
}

fn read(place: &Workplace, name: &str) -> Result<Extract, String> {
    meshio::mesh(&place.path(name), &Options::default()).map_err(|error| error.to_string())
}

#[track_caller]
fn refusal(place: &Workplace, name: &str, text: &str) -> String {
    place.write(name, text);
    read(place, name).expect_err("must be refused")
}

fn area(mesh: &Mesh, group: &str) -> f64 {
    let cells = mesh.surfaces[group].iter().map(|&cell| &mesh.cells[cell]);
    let of = |cell: &peristitch::mesh::Cell| {
        let at: Vec<[f64; 2]> = cell.nodes().iter().map(|&node| mesh.nodes[node]).collect();
        peristitch::fem::element::area(cell.kind, &at)
    };
    cells.map(of).sum()
}

fn length(mesh: &Mesh, curve: &str) -> f64 {
    let edges = mesh.curves[curve].iter();
    edges
        .map(|edge| {
            let [a, b] = edge.ends.map(|end| mesh.nodes[end]);
            (a[0] - b[0]).hypot(a[1] - b[1])
        })
        .sum()
}

/// As Abaqus/CAE writes: a part, an instance that moves it, sets of the part and of the assembly, a surface,
/// small letters, generated ids, an include, names in quotes, a reduced integration.
const CAE: &str = "\
*Heading
** a comment
*Part, name=Plate
*Node
      1,  0.,  0.
      2,  1.,  0.
      3,  2.,  0.
      4,  0.,  1.
      5,  1.,  1.
      6,  2.,  1.
      7, .5, 0.
      8, 1.5, 0.
      9, 1., .5
     10, .5, 1.
     11, 1.5, 1.0D0
*Include, input=more.inp
*Element, type=cps8r
1, 1, 2, 5, 4,
 7, 9, 10, 13
*Element, type=CPS8R, elset=Right
2, 2, 3, 6, 5, 8, 12, 11, 9
*Elset, elset=All, generate
 1, 2
*Nset, nset=\"Upper side\", generate
 4, 6, 1
*Nset, nset=\"Upper side\"
 10, 11
*Surface, type=ELEMENT, name=Pushed
Right, S2
*End Part
*Assembly, name=Assembly
*Instance, name=Plate-1, part=Plate
 10., 0., 0.
*End Instance
*Nset, nset=Corner, instance=Plate-1
 1,
*Elset, elset=Left, instance=Plate-1
 1
*Surface, type=ELEMENT, name=Held
Plate-1.1, S4
*End Assembly
*Material, name=rock
*Boundary
Corner, 1, 2
*Step
";
const MORE: &str = "*Node\n12, 2., .5\n13, 0., .5\n";

fn cae() -> Workplace {
    let place = Workplace::new();
    place.write("cae.inp", CAE);
    place.write("more.inp", MORE);
    place
}

#[test]
fn sets_of_parts_and_assemblies_and_surfaces_become_groups() {
    let extract = read(&cae(), "cae.inp").expect("a mesh");
    let mesh = extract.to_mesh(1.0).expect("sound");
    assert_eq!(mesh.cells.len(), 2);
    assert!(mesh.cells.iter().all(|cell| cell.kind == CellKind::Quad8));
    assert_eq!(
        mesh.surfaces.keys().collect::<Vec<_>>(),
        ["All", "Left", "Right"]
    );
    for (group, expected) in [("All", 2.0), ("Left", 1.0), ("Right", 1.0)] {
        assert!((area(&mesh, group) - expected).abs() < 1e-14, "{group}");
    }
    assert_eq!(
        mesh.curves.keys().collect::<Vec<_>>(),
        ["Held", "Pushed", "Upper side"]
    );
    for (curve, expected, axis, at) in [
        ("Held", 1.0, 0, 10.0),
        ("Pushed", 1.0, 0, 12.0),
        ("Upper side", 2.0, 1, 1.0),
    ] {
        assert!((length(&mesh, curve) - expected).abs() < 1e-14, "{curve}");
        for edge in &mesh.curves[curve] {
            assert!(
                edge.nodes().all(|node| mesh.nodes[node][axis] == at),
                "{curve}"
            );
            assert_eq!(edge.nodes().count(), 3);
        }
    }
    let corner = &mesh.points["Corner"];
    assert_eq!(corner.len(), 1);
    assert_eq!(mesh.nodes[corner[0]], [10.0, 0.0]);
    let notes = extract.warnings.join("\n");
    assert!(
        notes.contains("*BOUNDARY, *MATERIAL, *STEP: not read"),
        "{notes}"
    );
}

/// meshio's own reader still loses what src/meshio/abaqus.py reads: should it mend that, this test tells.
#[test]
fn what_the_own_reader_of_abaqus_is_for() {
    let place = cae();
    let flat = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n*NODE\n5,2,0,0\n6,2,1,0\n*ELEMENT,TYPE=CPS4\n\
                1,1,2,3,4\n*ELEMENT,TYPE=CPS4,ELSET=b\n2,2,5,6,3\n";
    place.write("flat.inp", flat);
    let script = "import meshio, sys\nmeshio.read(sys.argv[1])";
    let own = |name: &str| {
        let run = Command::new(python())
            .args(["-c", script])
            .arg(place.path(name))
            .output();
        run.expect("Python starts").status.success()
    };
    assert!(!own("cae.inp") && !own("flat.inp"));
    let mesh = read(&place, "flat.inp")
        .expect("a mesh")
        .to_mesh(1.0)
        .expect("sound");
    // Element 1 is in no set.
    assert_eq!((mesh.cells.len(), mesh.surfaces["b"].len()), (1, 1));
    assert!((area(&mesh, "b") - 1.0).abs() < 1e-15);
}

/// One element of each kind that Abaqus calls plane, with the ids of its nodes.
#[test]
fn every_plane_element_of_abaqus_is_known() {
    let nodes = "*NODE\n1,0,0\n2,2,0\n3,2,2\n4,0,2\n5,1,0\n6,2,1\n7,1,2\n8,0,1\n9,1,1\n";
    let kinds = [
        (
            CellKind::Quad4,
            "1,2,3,4",
            &[
                "CPS4", "CPS4R", "CPS4I", "CPE4", "CPE4R", "CPE4H", "S4", "S4R",
            ][..],
        ),
        (
            CellKind::Quad8,
            "1,2,3,4,5,6,7,8",
            &["CPS8", "CPS8R", "CPE8", "CPE8R", "CPE8RH", "S8R"],
        ),
        (
            CellKind::Tri3,
            "1,2,4",
            &["CPS3", "CPE3", "CPE3H", "S3", "S3R", "STRI3"],
        ),
        (
            CellKind::Tri6,
            "1,2,4,5,9,8",
            &["CPS6", "CPS6M", "CPE6", "CPE6MH", "STRI65"],
        ),
    ];
    let place = Workplace::new();
    for (kind, ids, names) in kinds {
        for name in names {
            let text = format!("{nodes}*ELEMENT, TYPE={name}, ELSET=all\n1,{ids}\n");
            place.write("one.inp", text);
            let mesh = read(&place, "one.inp")
                .expect(name)
                .to_mesh(1.0)
                .expect(name);
            assert_eq!((mesh.cells.len(), mesh.cells[0].kind), (1, kind), "{name}");
            let expected = if kind.corner_count() == 4 { 4.0 } else { 2.0 };
            assert!((area(&mesh, "all") - expected).abs() < 1e-14, "{name}");
        }
    }
}

#[test]
fn what_has_no_place_in_a_plane_computation_is_named() {
    let place = Workplace::new();
    let nodes = "*NODE\n1,0,0,0\n2,2,0,0\n3,2,2,0\n4,0,2,0\n5,1,0,0\n";
    let quad = "*ELEMENT,TYPE=CPS4,ELSET=all\n7,1,2,3,4\n";
    let with = |more: &str| format!("{nodes}{quad}{more}");
    // Left out, with a note.
    let text = with(
        "*ELEMENT, TYPE=B21, ELSET=bar\n8,1,2\n*ELEMENT, TYPE=C3D4\n9,1,2,3,4\n*ELEMENT,TYPE=SPRING1\n10,1\n*TIE\na,b\n",
    );
    place.write("mixed.inp", text);
    let extract = read(&place, "mixed.inp").expect("a mesh");
    let notes = extract.warnings.join("\n");
    for note in [
        "B21 elements name curves here, and have no stiffness",
        "1 of C3D4 left out",
        "1 of SPRING1 left out",
        "*TIE: not read; parts that only these join are not joined",
    ] {
        assert!(notes.contains(note), "{note}: {notes}");
    }
    let mesh = extract.to_mesh(1.0).expect("sound");
    assert_eq!(mesh.curves["bar"].len(), 1);
    // Refused.
    for (text, message) in [
        (
            with("*ELEMENT,TYPE=CAX4\n8,1,2,3,4\n"),
            "CAX4 elements are axisymmetric",
        ),
        (
            with("*ELEMENT,TYPE=CPE4P\n8,1,2,3,4\n"),
            "CPE4P elements: this kind is not supported",
        ),
        (
            with("*NGEN\n1,5,1\n"),
            "*NGEN: generated nodes and elements are not read",
        ),
        (
            with("*ELEMENT,TYPE=CPS4\n8,1,2,3,99\n"),
            "element 8 (CPS4) uses node 99, which is not defined",
        ),
        (
            with("*ELSET,ELSET=x\nnowhere\n"),
            "`x` lists the set `nowhere`, which is not defined above it",
        ),
        (with("*INCLUDE,INPUT=gone.inp\n"), "there is no file"),
        (with("*SURFACE,NAME=s\nall\n"), "`s` names no side S1 to S4"),
        (with("*ELEMENT,TYPE=CPS4\n8,1,2,3\n"), "not a multiple of 5"),
        (
            with("*ELEMENT,TYPE=CPS4\n8,1,3,2,4\n"),
            "element 8 (quad), near (0, 0), is folded",
        ),
        (with("*ELEMENT,TYPE=CPS4\n8,1,5,2,5\n"), "element 8 (quad)"),
        (
            with("").replace("4,0,2,0", "4,0,2,0.25"),
            "node 4 lies at z = 0.25, and 1 of 4 nodes",
        ),
        (
            with("").replace(",ELSET=all", ""),
            "no set holds plane elements",
        ),
        (
            format!("{nodes}*ELEMENT,TYPE=C3D4,ELSET=v\n1,1,2,3,4\n*NSET,NSET=n\n1\n"),
            "no plane elements to compute on; it has the elements 1 C3D4; the node sets n",
        ),
        (
            String::new(),
            "no plane elements to compute on; it has no elements",
        ),
        (
            "*NODE\n1,zero,0\n".to_owned(),
            "could not convert string to float",
        ),
    ] {
        let error = refusal(&place, "bad.inp", &text);
        assert!(error.contains(message), "{message}: {error}");
    }
}

#[test]
fn elements_that_stand_twice_count_once() {
    let place = Workplace::new();
    let text = "*NODE\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,2,0\n6,2,1\n*ELEMENT,TYPE=CPS4,ELSET=all\n\
                1,1,2,3,4\n2,2,5,6,3\n*ELEMENT,TYPE=CPS4,ELSET=again\n7,2,3,4,1\n*NSET,NSET=base\n1,2,5\n";
    place.write("twice.inp", text);
    let extract = read(&place, "twice.inp").expect("a mesh");
    let note =
        "1 elements have the nodes of another one and were left out; their sets hold that one";
    assert_eq!(extract.warnings, [note]);
    let mesh = extract.to_mesh(1.0).expect("sound");
    assert_eq!(mesh.cells.len(), 2);
    assert_eq!(mesh.surfaces["again"], [0]);
    assert_eq!(mesh.cell_numbers, [1, 2]);
    assert_eq!(mesh.curves["base"].len(), 2);
}

/// The eight nodes of a quad run around the element, or clockwise, or in both ways in one file.
#[test]
fn the_order_of_nodes_is_found_by_the_jacobian() {
    let place = Workplace::new();
    let nodes = "*NODE\n1,0,0\n2,2,0\n3,2,2\n4,0,2\n5,1,-0.1\n6,2,1\n7,1,2\n8,0,1\n9,4,0\n10,4,2\n11,3,0\n12,4,1\n13,3,2\n";
    let mesh = |elements: &str| {
        let text =
            format!("{nodes}*ELEMENT,TYPE=CPS8,ELSET=all\n{elements}*NSET,NSET=bottom\n1,5,2\n");
        place.write("order.inp", text);
        read(&place, "order.inp")
    };
    let standard = mesh("1,1,2,3,4,5,6,7,8\n2,2,9,10,3,11,12,13,6\n").expect("a mesh");
    assert_eq!(standard.warnings, [""; 0]);
    let standard = standard.to_mesh(1.0).expect("sound");
    let around = mesh("1,1,5,2,6,3,7,4,8\n2,2,11,9,12,10,13,3,6\n").expect("a mesh");
    assert!(
        around.warnings[0].contains("run around the element"),
        "{:?}",
        around.warnings
    );
    assert_eq!(around.to_mesh(1.0).expect("sound").cells, standard.cells);
    let clockwise = mesh("1,1,4,3,2,8,7,6,5\n2,2,9,10,3,11,12,13,6\n").expect("a mesh");
    assert!(
        clockwise.warnings[0].starts_with("1 elements ran clockwise"),
        "{:?}",
        clockwise.warnings
    );
    assert_eq!(clockwise.to_mesh(1.0).expect("sound").cells, standard.cells);
    let mixed = mesh("1,1,5,2,6,3,7,4,8\n2,2,9,10,3,11,12,13,6\n").expect_err("two orders");
    let expected =
        "in two orders: element 2 has its corners first, element 1 corner and middle in turn";
    assert!(mixed.contains(expected), "{mixed}");
    let folded = mesh("1,1,2,3,4,7,6,5,8\n").expect_err("folded");
    assert!(folded.contains("element 1 (quad8)"), "{folded}");
}

#[test]
fn nastran_names_what_meshio_passes_over() {
    let place = Workplace::new();
    let grids = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n";
    let deck = |cards: &str| format!("BEGIN BULK\n{grids}{cards}ENDDATA\n");
    place.write("a.bdf", deck("CPLSTS4,1,7,1,2,3,4\n"));
    let mesh = read(&place, "a.bdf")
        .expect("a mesh")
        .to_mesh(1.0)
        .expect("sound");
    assert_eq!(mesh.surfaces.keys().collect::<Vec<_>>(), ["7"]);
    // As Gmsh writes it, without the lines around.
    place.write("b.bdf", format!("{grids}CQUAD4,1,5,1,2,3,4\n"));
    let bare = read(&place, "b.bdf").expect("a mesh");
    assert_eq!(bare.groups[0].name, "5");
    for (cards, message) in [
        ("CQUADX8,1,7,1,2,3,4\n", "axisymmetric"),
        (
            "CQUADZ,1,7,1,2,3,4\n",
            "line 6: CQUADZ: this kind of plane elements is not read",
        ),
        (
            "INCLUDE 'b.bdf'\n",
            "line 6: INCLUDE: other files are not read along",
        ),
        (
            "CORD2R,1\nGRID,9,1,0.,0.,0.\n",
            "line 7: GRID: the grid point is given in a coordinate system of its own",
        ),
        (
            "CQUAD4,1,7,1,2,3,9\n",
            "line 6: CQUAD4: element 1 uses grid point 9, which is not defined",
        ),
        (
            "CQUAD4,1,7,1,2,x,4\n",
            "line 6: CQUAD4: `x` in field 6 is no number of a grid point",
        ),
    ] {
        let error = refusal(&place, "bad.bdf", &deck(cards));
        assert!(error.contains(message), "{message}: {error}");
    }
}

/// Truncated and foreign bytes under every extension: a message, no panic.
#[test]
fn damaged_files_are_refused() {
    let place = Workplace::new();
    for extension in meshio::MESHES {
        let name = format!("bad.{extension}");
        for bytes in [
            &b""[..],
            b"\x89HDF\r\n\x1a\n",
            b"<VTKFile type=\"x\">",
            b"\xff\xfe\x00\x01 1,2,3\n*NODE\n",
        ] {
            place.write(&name, bytes);
            let error = read(&place, &name).expect_err("must be refused");
            assert!(error.contains(&name), "{error}");
            assert!(!error.contains("crashed"), "{error}");
        }
    }
}

#[test]
fn limits_end_the_child() {
    let place = cae();
    let with = |options: Options| {
        meshio::mesh(&place.path("cae.inp"), &options)
            .expect_err("a limit")
            .to_string()
    };
    let time = with(Options {
        time_limit: Duration::ZERO,
        ..Options::default()
    });
    assert!(
        time.contains("had not finished") && time.contains("after 0 s"),
        "{time}"
    );
    let memory = with(Options {
        memory_limit: 1 << 20,
        ..Options::default()
    });
    assert!(
        memory.contains("out of memory") || memory.contains("crashed"),
        "{memory}"
    );
}

#[test]
fn the_pipeline_points_at_the_file_and_says_how_to_get_meshio() {
    let place = cae();
    place.write("bar.yaml", pipeline("cae.inp", &[("unit: mm", "unit: m")]));
    let run = |variables: &[(&str, &Path)], more: &[&str]| {
        let mut command = place.command(&[&["check", "bar.yaml"], more].concat());
        variables.iter().for_each(|(name, value)| {
            command.env(name, value);
        });
        workplace::Ended::from(command.output().expect("the binary starts"))
    };
    // Groups are listed as those of Gmsh are.
    let groups = run(&[], &[]);
    assert_eq!(groups.code, Some(2));
    assert!(
        groups.err.contains("there is no physical surface `left`"),
        "{}",
        groups.err
    );
    assert!(groups.err.contains("`Left`"), "{}", groups.err);
    let parameter = run(&[], &["--set", "geometry.parameters.a=1"]);
    assert!(
        parameter
            .err
            .contains("is not a script, so its parameter 'a' cannot be set"),
        "{}",
        parameter.err
    );
    let none = run(&[("PERISTITCH_PYTHON", Path::new("/bin/false"))], &[]);
    assert_eq!(none.code, Some(1));
    for part in [
        "no Python that has it is found",
        "make setup",
        "PERISTITCH_PYTHON",
        "/bin/false",
    ] {
        assert!(none.err.contains(part), "{}", none.err);
    }
}

/// The manifest has the file's content, that of what it includes, and meshio's version.
#[test]
fn an_edit_of_an_included_file_makes_the_mesh_stale() {
    let place = cae();
    place.write(
        "bar.yaml",
        "name: bar\ngeometry: { file: cae.inp }\nmaterials: { m: { young: 1 GPa, poisson: 0.3 } }\n\
         regions: [ { group: All, model: fem, material: m } ]\n\
         boundary:\n  - { group: Held, displacement: { x: 0, y: 0 } }\n  - { group: Pushed, pressure: 1 Pa }\n",
    );
    assert_eq!(place.run(&[]).stages(), ["mesh", "solve", "output"]);
    assert!(place.run(&[]).stages().is_empty());
    let manifest = String::from_utf8(place.read("results/bar/.stamps/mesh.json")).expect("JSON");
    assert!(manifest.contains("\"meshio\": \"5."), "{manifest}");
    place.edit("more.inp", "12, 2., .5", "12, 2.01, .5");
    let explained = place.call(&["explain", "bar.yaml"]).succeeded();
    assert!(
        explained.out.contains("more.inp has changed"),
        "{}",
        explained.out
    );
    assert_eq!(place.run(&[]).stages(), ["mesh", "solve", "output"]);
}
