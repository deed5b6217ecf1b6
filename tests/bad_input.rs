//! Every kind of bad input gives one message with place and remedy, exit code 2, and nothing is
//! written. The program never panics, whatever the file.

mod workplace;

use peristitch::pipeline::read::plan::Plan;
use proptest::prelude::*;
use std::sync::LazyLock;
use workplace::{PIPELINE, Workplace};

/// The sound pipeline with `old` replaced by `new` is refused.
#[track_caller]
fn assert_edit(old: &str, new: &str, message: &[&str]) {
    let place = Workplace::new();
    place.edit("bar.yaml", old, new);
    place.assert_refused(&["run", "bar.yaml"], 2, message);
}

/// The sound pipeline with the `.geo` edited is refused.
#[track_caller]
fn assert_geo(old: &str, new: &str, message: &[&str]) {
    let place = Workplace::new();
    place.edit("geo/bar.geo", old, new);
    place.assert_refused(&["run", "bar.yaml"], 2, message);
}

#[track_caller]
fn assert_set(set: &str, message: &[&str]) {
    Workplace::new().assert_refused(&["run", "bar.yaml", "--set", set], 2, message);
}

/// The key `boundary` to its end.
const BOUNDARY: &str = "boundary:
  - { group: clamp, displacement: { x: 0, y: 0 } }
  - { group: load, traction: { x: 1.05 MPa } }
";

#[test]
fn files_that_are_no_pipeline() {
    let place = Workplace::new();
    let missing = [
        "there is no pipeline file bra.yaml",
        "did you mean `bar.yaml`?",
    ];
    place.assert_refused(&["run", "bra.yaml"], 2, &missing);
    place.assert_refused(
        &["run", "geo"],
        2,
        &["geo is a folder, not a pipeline file"],
    );
    place.assert_refused(
        &["run", "."],
        2,
        &["is a folder", "name a file: `./bar.yaml`"],
    );
    let needs = "needs `name`, `geometry`, `materials`";
    for (text, message) in [
        (&b""[..], &["p.yaml: the file is empty", needs][..]),
        (b"# nothing\n", &["p.yaml: the file is empty"]),
        (
            b"- a\n- b\n",
            &["p.yaml: a pipeline consists of keys", needs],
        ),
        (b"just words", &["p.yaml: a pipeline consists of keys"]),
        (
            b"name: a\ngeometry: [1, 2\nplane: }\n",
            &["p.yaml:3:", "this is not YAML"],
        ),
        (
            b"name: a\n\tplane: stress\n",
            &["p.yaml:2:", "indent with spaces"],
        ),
        (
            b"name: a\nplane: \xff\xfe\n",
            &["p.yaml:2: the pipeline is not UTF-8 text"],
        ),
        (
            b"name: a\n---\nname: b\n",
            &["p.yaml", "more than one document"],
        ),
    ] {
        place.write("p.yaml", text);
        place.assert_refused(&["run", "p.yaml"], 2, message);
    }
}

/// No address space holds a stack of 2⁴⁶ bytes.
#[test]
fn threads_that_cannot_be_started() {
    let place = Workplace::new();
    let before = place.snapshot();
    let mut command = place.command(&["run", "bar.yaml", "--threads", "2"]);
    let ended = command.env("RUST_MIN_STACK", (1_u64 << 46).to_string());
    let ended = ended.output().expect("the binary starts");
    let message = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(2), "{message}");
    for part in [
        "the threads cannot be started",
        "--threads 1 needs no other",
    ] {
        assert!(message.contains(part), "{message}");
    }
    assert_eq!(place.snapshot(), before);
}

#[test]
fn the_geometry_file() {
    assert_edit(
        "geo/bar.geo",
        "geo",
        &["bar.yaml:3:9", "the geometry file geo is a folder"],
    );
    assert_edit(
        "geo/bar.geo",
        "bar.yaml",
        &["bar.yaml:3:9", "not a kind of file"],
    );
}

#[test]
fn physical_groups() {
    let place = Workplace::new();
    let text = String::from_utf8(place.read("geo/bar.geo")).expect("UTF-8");
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("Physical"));
    place.write("geo/bar.geo", lines.collect::<Vec<_>>().join("\n") + "\n");
    let none = [
        "bar.yaml:3:9",
        "has no physical surface",
        "Physical Surface(\"plate\") = {1};",
    ];
    place.assert_refused(&["run", "bar.yaml"], 2, &none);

    assert_edit(
        "group: load",
        "group: tip",
        &["bar.yaml:19:", "`tip` is a point"],
    );
}

#[test]
fn meshes_that_do_not_fit() {
    // The band is not meshed.
    let hidden =
        "\nHide { Surface{:}; } Show { Surface{70}; Surface{72}; }\nMesh.MeshOnlyVisible = 1;\n";
    let empty = ["bar.yaml:11:12", "region `band` has no elements"];
    assert_geo(
        "Mesh.ElementOrder = order;",
        &format!("Mesh.ElementOrder = order;{hidden}"),
        &empty,
    );
}

#[test]
fn parameters_of_the_geometry() {
    assert_edit(
        "element: 50",
        "element: big",
        &["bar.yaml:5:26", "must be a number"],
    );
    let set = [
        "element = 30 mm does not divide",
        "by `--set geometry.parameters.element=30`",
    ];
    assert_set("geometry.parameters.element=30", &set);
}

#[test]
fn materials() {
    assert_edit(
        "poisson: 1/3",
        "poisson: 0.6",
        &["bar.yaml:8:37", "not between -1 and 1/2"],
    );
    assert_edit("100 GPa", "1e400 GPa", &["bar.yaml:8:19", "is not finite"]);
    assert_edit("100 GPa", ".nan", &["bar.yaml:8:19", "is not a number"]);
    assert_edit(
        "100 GPa",
        "[1, 2]",
        &["bar.yaml:8:19", "`materials.solid.young` is a list"],
    );
    let lines = "materials:\n  solid: { young: 100 GPa, poisson: 1/3 }\n";
    assert_edit(
        lines,
        "",
        &["bar.yaml: the key `materials` is missing", "add, say"],
    );
    // Where the file uses anchors there are no marks, and the key says where.
    assert_edit(
        "solid: { young: 100 GPa",
        "solid: &s { young: 1 x",
        &["`materials.solid.young`"],
    );
}

#[test]
fn regions() {
    let small = ["bar.yaml:15:14", "less than 2", "`horizon: 4`"];
    assert_edit("horizon: 4", "horizon: 1.5", &small);
    assert_edit(
        "horizon: 4",
        "horizon: 1e9",
        &["bar.yaml:15:14", "more than 20"],
    );
    let correction = [
        "bar.yaml:16:",
        "surface_correction",
        "none",
        "volume",
        "energy",
        "force",
        "least-squares",
    ];
    assert_edit(
        "horizon: 4",
        "horizon: 4\n    surface_correction: strong",
        &correction,
    );
    let micromodulus = ["bar.yaml:16:", "micromodulus", "isotropised", "raw"];
    assert_edit(
        "horizon: 4",
        "horizon: 4\n    micromodulus: isotropic",
        &micromodulus,
    );
    for (key, value) in [
        ("micromodulus", "raw"),
        ("surface_correction", "force"),
        ("angle", "20 deg"),
        ("origin", "[0 mm, 0 mm]"),
    ] {
        let lattice_only = [
            "bar.yaml:10:",
            &format!("`{key}` belongs to peridynamic regions"),
            &format!("remove `{key}`"),
        ];
        assert_edit(
            "model: fem, material: solid",
            &format!("model: fem, material: solid, {key}: {value}"),
            &lattice_only,
        );
    }
    let clip = [
        "bar.yaml:16:",
        "the clip needs a lattice with the finite elements' moduli",
        "remove `micromodulus`",
    ];
    assert_edit(
        "    horizon: 4\ncoupling: truss",
        "    horizon: 4\n    micromodulus: raw\ncoupling: clip",
        &clip,
    );
    assert_edit(
        "horizon: 4",
        "horizon: 4\n    angle: 20 mm",
        &["bar.yaml:16:12", "angle"],
    );
    assert_edit(
        "horizon: 4",
        "horizon: 4\n    origin: 0.2 mm",
        &["bar.yaml:16:", "origin"],
    );
    let fem = "- { group: [left, right], model: fem, material: solid }";
    let left =
        "- { group: left, model: peridynamics, material: solid, spacing: 25 mm, horizon: 4 }";
    let lattices = [
        "bar.yaml:11:12",
        "`left` and `band` touch, and their lattices differ",
        "share one lattice",
        "one region",
    ];
    assert_edit(fem, left, &lattices);
    let large = ["bar.yaml:14:14", "no material point", "smaller `spacing`"];
    assert_edit("12.5 mm", "500 mm", &large);
    let tiny = [
        "bar.yaml:14:14",
        "would hold 4.0e22 material points",
        "larger `spacing`",
    ];
    assert_edit("12.5 mm", "1e-9 mm", &tiny);
    let start = PIPELINE.find("regions:").expect("a key");
    let all = &PIPELINE[start..PIPELINE.find("coupling:").expect("a key")];
    assert_edit(all, "regions: []\n", &["bar.yaml:9:", "there is no region"]);
    assert_edit(all, "regions:\n", &["bar.yaml:9:", "there is no region"]);
    assert_edit(all, "", &["bar.yaml: the key `regions` is missing"]);
}

#[test]
fn supports() {
    let none = [
        "bar.yaml:17:",
        "no displacement is prescribed",
        "add a support",
    ];
    assert_edit(BOUNDARY, "boundary: []\n", &none);
    let clamp = "displacement: { x: 0, y: 0 }";
    let y = [
        "bar.yaml:18:",
        "the body can move in y freely",
        "Displacements are prescribed on `clamp`;",
    ];
    assert_edit(clamp, "displacement: { x: 0 }", &y);
    let x = ["the body can move in x and turn about (0, 0.1) m freely"];
    assert_edit(clamp, "displacement: { y: 0 }", &x);
    assert_edit(
        clamp,
        "displacement: { }",
        &["bar.yaml:18:", "no component", "`x`, `y` or both"],
    );
    let corner = format!("{BOUNDARY}  - {{ group: corner, displacement: {{ x: 1 mm }} }}\n");
    let conflict = [
        "bar.yaml:20:",
        "`corner` prescribes 0.001 m",
        "`clamp` prescribes 0 m",
    ];
    assert_edit(BOUNDARY, &corner, &conflict);
}

/// The sound plate with `old` replaced by `new` is refused.
#[track_caller]
fn assert_plate(old: &str, new: &str, message: &[&str]) {
    let place = Workplace::with_plate();
    place.edit("plate.yaml", old, new);
    place.assert_refused(&["run", "plate.yaml"], 2, message);
}

#[test]
fn cracks_and_loading() {
    let surface = [
        "plate.yaml:11:",
        "no physical surface `bend`",
        "mean `band`?",
    ];
    assert_plate("cracks: [crack]", "no_fail: [bend]", &surface);
    let zero = ["plate.yaml:15:", "must not be zero", "from 1 on"];
    assert_plate("steps: 200", "steps: 200, most_passes: 0", &zero);
    assert_plate(
        "every: 7",
        "every: 0",
        &["plate.yaml:16:", "must not be zero"],
    );
    let control = ["plate.yaml:15:", "two-pass", "mean `one-pass`?"];
    assert_plate("one-pass", "two-pass", &control);
}

#[test]
fn programmes() {
    let boundary = |top: &str, bottom: &str| {
        format!(
            "boundary:
  - {{ group: top, displacement: {{ x: 0, y: 5.0e-9 m }}{top} }}
  - {{ group: bottom, displacement: {{ x: 0, y: -5.0e-9 m }}{bottom} }}
"
        )
    };
    let place = Workplace::with_plate();
    let text = String::from_utf8(place.read("plate.yaml")).expect("UTF-8");
    let from = text.find("boundary:").expect("the key");
    let to = text.find("loading:").expect("the key");
    let old = &text[from..to];
    let refused = |boundary: &str, loading: &str, message: &[&str]| {
        let place = Workplace::with_plate();
        place.edit("plate.yaml", old, boundary);
        place.edit(
            "plate.yaml",
            "steps: 200",
            &format!("steps: 200, {loading}"),
        );
        place.assert_refused(&["run", "plate.yaml"], 2, message);
    };
    let both = boundary(", phase: up", ", phase: up");
    let up = "phases: [{ name: up, to: 3 }]";
    refused(
        &both,
        "phases: [{ name: ap }]",
        &["plate.yaml:", "no phase `up`", "mean `ap`?"],
    );
    refused(
        &both,
        "to: 0",
        &["plate.yaml:", "no phase `up`", "there are none"],
    );
    refused(
        &boundary(", phase: up", ""),
        up,
        &[
            "plate.yaml:14:",
            "`bottom` belongs to no phase",
            "one of `up`",
        ],
    );
    refused(
        &both,
        "phases: [{ name: up }, { name: down, to: 3 }]",
        &["plate.yaml:", "the phase `up` has no end", "add `to:`"],
    );
    refused(
        &both,
        "phases: [{ name: up, to: 3 }, { name: down }]",
        &["plate.yaml:", "nothing happens in the phase `down`"],
    );
    refused(
        &both,
        "phases: [{ name: up, to: 3 }, { name: up }]",
        &["plate.yaml:", "two phases have this name"],
    );
    refused(
        &both,
        "to: 5, phases: [{ name: up, to: 3 }]",
        &["plate.yaml:", "`to` belongs to a phase here"],
    );
    refused(
        &both,
        "phases: [{ name: up, to: -3 }]",
        &["plate.yaml:", "not positive"],
    );
    refused(old, "increment: 0", &["plate.yaml:", "not positive"]);
    let probe = format!(
        "{old}probes: {{ cmod: {{ between: [[25 mm, 24 mm], [25 mm, 26 mm]], component: y }} }}\n"
    );
    refused(
        &probe,
        "by: cmot",
        &["plate.yaml:", "no probe `cmot`", "mean `cmod`?"],
    );
    refused(
        &probe,
        "by: cmod",
        &["`by` needs an increment", "a length such as 1 µm"],
    );
    refused(
        &probe,
        "by: cmod, increment: 1 µm, to: 3",
        &["`to` is a load factor", "write `steps:`"],
    );
}

#[test]
fn event_driven_runs_have_no_steps_for_a_probe_to_control() {
    let place = Workplace::with_plate();
    place.edit(
        "plate.yaml",
        "loading: { control: one-pass,",
        "probes: { cmod: { between: [[25 mm, 24 mm], [25 mm, 26 mm]], component: y } }\n\
         loading: { control: event-driven, by: cmod, increment: 1 µm,",
    );
    let message = [
        "has no load steps that a probe could control",
        "take `control: equilibrium`",
    ];
    place.assert_refused(&["run", "plate.yaml"], 2, &message);
}

#[test]
fn strengths() {
    let both = ", tensile_strength: 2.01 MPa, compressive_strength: 20.1 MPa";
    let none = ["plate.yaml:15:", "no bond can break", "remove `loading`"];
    assert_plate(both, "", &none);
    let tensile = "tensile_strength: 2.01 MPa, ";
    let unit = ["plate.yaml:7:", "is a length", "must be a pressure"];
    assert_plate(tensile, "tensile_strength: 2.01 mm, ", &unit);
    let sign = ["plate.yaml:7:", "not positive"];
    assert_plate(tensile, "tensile_strength: -2.01 MPa, ", &sign);
    assert_plate(tensile, "", &["plate.yaml:7:", "needs a tensile strength"]);
    let two = ["plate.yaml:7:", "remove one of"];
    assert_plate(
        both,
        ", tensile_strength: 2 MPa, energy_release_rate: 1 J/m^2",
        &two,
    );
    let rate = ["plate.yaml:7:", "is a pressure", "energy per area"];
    assert_plate(both, ", energy_release_rate: 1 Pa", &rate);
}

#[test]
fn keys_and_values() {
    assert_edit(
        "plane:",
        "plain:",
        &["bar.yaml:6:1", "unknown key `plain`", "mean `plane`?"],
    );
    let solid = "  solid: { young: 100 GPa, poisson: 1/3 }\n";
    let twice = ["bar.yaml:9:3", "`solid` is written twice, first in line 8"];
    assert_edit(solid, &format!("{solid}{solid}"), &twice);
    assert_edit(
        "unit: mm",
        "unit: furlong",
        &["bar.yaml:4:9", "`furlong` is not a unit"],
    );
    assert_edit(
        "name: bar",
        "name: a/b",
        &["bar.yaml:1:7", "cannot name a folder"],
    );
    assert_edit(
        "name: bar",
        "name: ..",
        &["bar.yaml:1:7", "cannot name a folder"],
    );
    assert_edit(
        "name: bar",
        "name:",
        &["bar.yaml:1:1", "cannot name a folder"],
    );
    let component = [
        "bar.yaml:21:8",
        "the key `component` is missing in `probes.tip`",
    ];
    assert_edit(" component: x,", "", &component);
    assert_edit(
        "component: x",
        "component: z",
        &["bar.yaml:21:", "cannot be `z`", "`x`, `y`"],
    );
    assert_edit(
        "[1000 mm, 100 mm]",
        "1 m",
        &["bar.yaml:21:14", "such as `[1 m, 0]`"],
    );
    let fields = [
        "bar.yaml:16:20",
        "`output.fields.0` cannot be `strss`",
        "mean `stress`?",
    ];
    assert_edit("coupling: truss", "output: { fields: [strss] }", &fields);
}

#[test]
fn values_from_the_command_line() {
    let list = "`regions` is a list of 2: write a number from 0 to 1, not `7`";
    assert_set("regions.7.horizon=3", &["names no place", list]);
    assert_set("name.x=3", &["names no place", "`name` is a single value"]);
    assert_set("name", &["not of the form key=value"]);
    assert_set("name=", &["not of the form key=value"]);
    assert_set(
        "regions=3",
        &["is `3`, but must be a list (by `--set regions=3`)"],
    );
    assert_set(
        "regions.1.horizon=1",
        &["less than 2 (by `--set regions.1.horizon=1`)"],
    );
    let place = Workplace::new();
    let both = [
        "run",
        "bar.yaml",
        "--set",
        "plane=stress",
        "--set",
        "regions.1.horizn=3",
    ];
    let blamed = [
        "`horizn` in `regions.1` (by `--set regions.1.horizn=3`)",
        "did you mean `horizon`?",
    ];
    place.assert_refused(&both, 2, &blamed);
}

#[test]
fn the_results_folder() {
    let place = Workplace::new();
    let unwritable = ["cannot create bar.yaml/bar", "`--results FOLDER`"];
    place.assert_refused(
        &["run", "bar.yaml", "--results", "bar.yaml"],
        1,
        &unwritable,
    );
    place.write("copy.yaml", PIPELINE);
    let shared = [
        "bar.yaml and copy.yaml both write to results/bar",
        "`name` of its own",
    ];
    place.assert_refused(&["run", "bar.yaml", "copy.yaml"], 2, &shared);
}

/// Nothing runs if one of several pipelines is bad.
#[test]
fn an_older_result_stays_as_it_is() {
    let place = Workplace::new();
    place.run(&[]);
    place.edit("bar.yaml", "group: load", "group: laod");
    place.write("sound.yaml", PIPELINE.replace("name: bar", "name: sound"));
    let before = place.snapshot();
    assert_eq!(place.call(&["run", "bar.yaml"]).code, Some(2));
    place.edit("bar.yaml", "horizon: 4", "horizon: 1");
    let after_edit = place.snapshot();
    assert_eq!(place.call(&["run", "sound.yaml", "bar.yaml"]).code, Some(2));
    assert_eq!(place.snapshot(), after_edit);
    let results = |files: &std::collections::BTreeMap<std::path::PathBuf, _>| {
        files
            .keys()
            .filter(|name| name.starts_with("results"))
            .count()
    };
    assert_eq!(results(&before), results(&after_edit));
}

/// One change of a text: a character or a line goes, comes twice or becomes another.
fn mutate(text: &str, [kind, place, what]: [usize; 3]) -> String {
    const STRANGE: [char; 16] = [
        '{', '}', '[', ']', ':', ',', '\t', '\n', '\'', '"', '&', '*', '-', 'é', '\u{0}', '9',
    ];
    let other = STRANGE[what % STRANGE.len()];
    let mut characters: Vec<char> = text.chars().collect();
    let mut lines: Vec<&str> = text.lines().collect();
    if characters.is_empty() || lines.is_empty() {
        return other.to_string();
    }
    let (at, line) = (place % characters.len(), place % lines.len());
    match kind % 6 {
        0 => drop(characters.remove(at)),
        1 => characters.insert(at, characters[at]),
        2 => characters[at] = other,
        3 => characters.insert(at, other),
        4 => drop(lines.remove(line)),
        _ => lines.insert(what % lines.len(), lines[line]),
    }
    if kind % 6 < 4 {
        characters.into_iter().collect()
    } else {
        lines.join("\n")
    }
}

/// Its geometry exists, so that reading goes on to the end.
static PLACE: LazyLock<Workplace> = LazyLock::new(Workplace::new);

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    /// Reading ends with a plan or with a message that can be shown, and never in a panic.
    #[test]
    fn no_text_makes_reading_panic(
        changes in prop::collection::vec(any::<[usize; 3]>(), 1..6),
        set in prop::option::of("[a-z0-9.]{0,12}=[ -~]{0,8}"),
    ) {
        let text = changes.into_iter().fold(PIPELINE.to_owned(), |text, change| mutate(&text, change));
        PLACE.write("bar.yaml", text);
        let set: Vec<String> = set.into_iter().collect();
        if let Err(error) = Plan::read(&PLACE.path("bar.yaml"), &set, None) {
            prop_assert!(!error.message.is_empty());
            // Spans outside the text show here.
            let shown = format!("{:?}", miette::Report::new(error));
            prop_assert!(!shown.contains("Failed to read contents"), "{shown}");
        }
    }
}

#[test]
fn loads_and_supports_of_every_kind() {
    let edit = |new: &str, message: &[&str]| {
        let load = "  - { group: load, traction: { x: 1.05 MPa } }";
        assert_edit(load, new, message);
    };
    edit(
        "  - { group: load, force: { x: 1 MPa } }",
        &["bar.yaml:19:", "`1 MPa` is a pressure", "a force"],
    );
    edit(
        "  - { group: load, force: {} }",
        &["this force has no component"],
    );
    edit(
        "  - { group: load, displacement: { x: 0, normal: 0 } }",
        &["along `x` and `y`, or along `normal` and `tangential`"],
    );
    edit(
        "  - { group: load, displacement: { angle: 30 deg } }",
        &["this displacement has no component"],
    );
    edit(
        "  - { group: load, displacement: { x: 0, angle: steep } }",
        &["`steep` is not an angle"],
    );
    edit(
        "  - { group: load, body_force: { y: 1 kN/m^3 } }",
        &["there is no physical surface `load`"],
    );
    edit(
        "  - { group: band, force: { y: 1 kN } }",
        &["is a surface", "only a `body_force`"],
    );
    edit(
        "gravity: { y: -9.81 m/s^2 }",
        &["`gravity` acts on nothing", "`density: 2400 kg/m^3`"],
    );
    edit(
        "  - { group: corner, displacement: { normal: 0 } }",
        &["group `corner` has no normal", "an `angle`"],
    );
    edit(
        "  - { group: clamp, displacement: { x: 1 µm, angle: 30 deg } }",
        &["that contradict each other", "possible together"],
    );
}
