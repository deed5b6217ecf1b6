//! First pipelines of people of the field: their words are taken, or answered with the key to write.

mod workplace;

use peristitch::fracture::laws::Strength;
use peristitch::pipeline::read::plan::Plan;
use workplace::Workplace;

/// The strength of the plate's material, written as `words`.
fn strength(place: &Workplace, words: &str, plane: &str) -> Strength {
    let path = place.path("plate.yaml");
    let material = format!("materials.rock={{young: 30 GPa, {words}}}");
    let plan = Plan::read(&path, &[material, format!("plane={plane}")], None);
    plan.expect("a sound pipeline").regions[1]
        .strength
        .expect("a strength")
}

/// G0 = K_IC²/E', E' = E in plane stress and E/(1 − ν²) in plane strain.
#[test]
fn a_fracture_toughness_is_an_energy_release_rate() {
    let place = Workplace::with_plate();
    let cases = [
        ("stress", "1/3", 1e12 / 30e9),
        ("strain", "1/4", 1e12 * (1.0 - 0.0625) / 30e9),
    ];
    for (plane, poisson, expected) in cases {
        let words = format!("poisson: {poisson}, fracture_toughness: 1 MPa m^0.5");
        let Strength::EnergyReleaseRate(rate) = strength(&place, &words, plane) else {
            panic!("not an energy release rate");
        };
        // Three roundings.
        assert!((rate / expected - 1.0).abs() < 1e-15, "{plane}: {rate}");
    }
    let both = "materials.rock={young: 30 GPa, poisson: 1/3, tensile_strength: 2 MPa, fracture_toughness: 1 MPa√m}";
    let message = [
        "a material breaks by its strength, by its energy release rate or by its fracture toughness",
        "remove one of `tensile_strength`, `fracture_toughness`",
    ];
    place.assert_refused(&["run", "plate.yaml", "--set", both], 2, &message);
}

#[test]
fn words_of_the_field_are_answered_with_the_key() {
    let place = Workplace::with_plate();
    let refused = |key: &str, value: &str, message: &[&str]| {
        let set = format!("{key}={value}");
        place.assert_refused(&["run", "plate.yaml", "--set", &set], 2, message);
    };
    refused(
        "materials.rock.critical_stretch",
        "1e-4",
        &[
            "unknown key `critical_stretch` in `materials.rock`",
            "`tensile_strength: f_t` with f_t = E s0",
            "`energy_release_rate: G0` with G0 = c0 s0² M3",
        ],
    );
    let toughness = [
        "unknown key `K_IC`",
        "write `fracture_toughness: 1 MPa m^0.5`",
    ];
    refused("materials.rock.K_IC", "1e6", &toughness);
    refused("materials.rock.nu", "0.3", &["write `poisson: 1/3`"]);
    refused("regions.1.dx", "1 mm", &["write `spacing: 0.5 mm`"]);
    // A word of materials is none of regions.
    refused(
        "regions.1.nu",
        "1",
        &["unknown key `nu` in `regions.1`", "there are: `group`"],
    );
    refused(
        "thickness",
        "3 MM",
        &["`MM` is not a unit", "did you mean `mm`?"],
    );
}

/// 1 inch is 25.4 mm: the same model, to the byte.
#[test]
fn a_geometry_in_inches() {
    let place = Workplace::new();
    let reads = |unit: &str| {
        let set = format!("geometry.unit={unit}");
        let plan = Plan::read(&place.path("bar.yaml"), &[set], None);
        plan.expect("a sound pipeline").geometry.unit_in_metres
    };
    for unit in ["inch", "in", "25.4 mm"] {
        assert_eq!(reads(unit), 0.0254, "{unit}");
    }
    assert_eq!([reads("ft"), reads("millimeter")], [0.3048, 1e-3]);
}

#[test]
fn plain_numbers_in_place_of_groups() {
    let place = Workplace::new();
    let refused = |set: &str, message: &[&str]| {
        place.assert_refused(&["run", "bar.yaml", "--set", set], 2, message);
    };
    let surface = [
        "there is no physical surface `7` with elements",
        "not a plain surface: add `Physical Surface(\"NAME\") = {7};` to the geometry",
        "there are: `band`, `left`, `right`",
    ];
    refused("regions.1.group=7", &surface);
    let curve = [
        "there is no physical curve or point `4`",
        "not a plain curve: add `Physical Curve(\"NAME\") = {4};` to the geometry",
    ];
    refused("boundary.0.group=4", &curve);
    refused("cracks=[12]", &["`Physical Curve(\"NAME\") = {12};`"]);
}

/// 45 is 45 degrees to everybody but the program.
#[test]
fn an_angle_without_a_unit_above_one_turn_is_refused() {
    let place = Workplace::new();
    let message = [
        "an angle of `45` without a unit is in radians, and more than a whole turn",
        "write `45 deg`, or `45 rad` if it is meant so",
    ];
    let lattice = "regions.1.angle=45";
    place.assert_refused(&["run", "bar.yaml", "--set", lattice], 2, &message);
    let roller = "boundary.0.displacement={y: 0, angle: 45}";
    place.assert_refused(&["run", "bar.yaml", "--set", roller], 2, &message);
    let text = String::from_utf8(place.read("bar.yaml")).expect("UTF-8");
    let sweep = "sweep: { over: { regions.1.angle: [0, 45] } }\n";
    place.write("bar.yaml", text + sweep);
    place.assert_refused(&["sweep", "bar.yaml"], 2, &message);
}

/// Warnings of `check` for a pipeline of one of the geometries of `tests/geo`.
fn warnings(geometry: &str, rest: &str) -> Vec<String> {
    let place = Workplace::new();
    let from = workplace::repository().join("tests/geo").join(geometry);
    std::fs::copy(from, place.path(geometry)).expect("the geometry");
    let head = format!("name: p\ngeometry: {{ file: {geometry}, unit: mm }}\n");
    place.write("p.yaml", head + rest);
    let ended = place.call(&["check", "p.yaml"]).succeeded();
    let lines = ended.err.lines();
    let told = lines.filter_map(|line| line.split_once("warning: "));
    let told = told.map(|(_, text)| text.to_owned()).collect();
    // An elastic run tells the same, and keeps it.
    place.call(&["run", "p.yaml"]).succeeded();
    let summary: serde_json::Value =
        serde_json::from_slice(&place.read("results/p/summary.json")).expect("JSON");
    assert_eq!(serde_json::json!(told), summary["warnings"]);
    told
}

/// Columns of 41 points, and 16 of them on the crack.
#[test]
fn a_crack_on_a_row_of_points_is_told_by_check_and_by_elastic_runs() {
    let told = warnings(
        "crack_on_points.geo",
        "thickness: 1 mm
materials: { m: { young: 30 GPa, poisson: 1/3, energy_release_rate: 20 J/m^2 } }
regions: [{ group: plate, model: peridynamics, material: m, spacing: 1 mm, horizon: 3 }]
cracks: [crack]
boundary:
  - { group: bottom, displacement: { x: 0, y: 0 } }
  - { group: top, displacement: { y: 1 µm } }
output: { pictures: false }
",
    );
    let expected = "the cracks cut 16 material points off; they do not move. A crack that lies on a row of points \
                    is a slot two rows wide: move it, or the lattice's `origin`, by half a spacing";
    assert_eq!(told, [expected]);
}

/// A hole of radius 6 mm becomes a polygon; its chords of length L stray by R − √(R² − L²/4).
#[test]
fn a_coarse_outline_under_a_fine_lattice_is_told() {
    let pipeline = |options: &str| {
        format!(
            "thickness: 2 mm
materials: {{ m: {{ young: 30 GPa, poisson: 1/3, energy_release_rate: 50 J/m^2 }} }}
regions: [{{ group: plate, model: peridynamics, material: m, spacing: {options}, horizon: 3 }}]
boundary:
  - {{ group: bottom, displacement: {{ x: 0, y: 0 }} }}
  - {{ group: top, displacement: {{ y: 1 µm }} }}
output: {{ pictures: false }}
"
        )
    };
    let told = warnings("coarse_hole.geo", &pipeline("0.25 mm"));
    let [note] = &told[..] else {
        panic!("{told:?}");
    };
    let number = |before: &str| -> f64 {
        let (_, rest) = note.split_once(before).expect(note);
        let word = rest.split_whitespace().next().expect(note);
        word.parse().expect(note)
    };
    assert!(
        note.starts_with("the outline of `plate` has straight sides of "),
        "{note}"
    );
    let length = number("straight sides of ");
    let exact = 6.0 - (36.0 - 0.25 * length * length).sqrt();
    // The chord's length times its turn over eight is 1 − φ²/48 of it, at φ = 60 deg 2 % less.
    let stray = number("strays from the curve by ");
    assert!(
        (stray / exact - 1.0).abs() < 0.025,
        "{stray} for {exact}: {note}"
    );
    assert!(
        warnings("coarse_hole.geo", &pipeline("2 mm"))
            .iter()
            .all(|n| !n.contains("curve"))
    );
}

/// 0.3 mm by 10 mm: 2 A/P = 0.29 mm.
#[test]
fn a_thin_layer_in_a_joint_lattice_is_told() {
    let told = warnings(
        "thin_layer.geo",
        "thickness: 1 mm
materials: { m: { young: 30 GPa, poisson: 1/3 }, soft: { young: 3 GPa, poisson: 1/3 } }
regions:
  - { group: [a, b], model: peridynamics, material: m, spacing: 1 mm, horizon: 3 }
  - { group: band, model: peridynamics, material: soft, spacing: 1 mm, horizon: 3 }
boundary:
  - { group: left, displacement: { x: 0 } }
  - { group: corner, displacement: { y: 0 } }
  - { group: right, traction: { x: 3 MPa } }
probes: { r: { at: [40 mm, 10 mm], component: x } }
output: { pictures: false }
",
    );
    let expected = "the region `band` holds no material point, and is 0.3 spacings wide in the mean: choose a smaller \
                    `spacing`, or make it wider";
    assert_eq!(told, [expected]);
}

/// The last line of `history.csv`, by column.
fn last_line(place: &Workplace) -> std::collections::BTreeMap<String, f64> {
    let text = String::from_utf8(place.read("results/plate/history.csv")).expect("UTF-8");
    let lines: Vec<&str> = text.lines().collect();
    let cells = lines[0].split(',').zip(lines[lines.len() - 1].split(','));
    cells
        .filter_map(|(name, cell)| Some((name.to_owned(), cell.parse().ok()?)))
        .collect()
}

/// The grips' edges move by what is prescribed, and a node's column ends with what the summary tells.
#[test]
fn probes_stand_in_the_history_and_may_lie_between_two_points() {
    for control in ["one-pass", "event-driven"] {
        let place = Workplace::with_plate();
        let text = String::from_utf8(place.read("plate.yaml")).expect("UTF-8");
        let probes = "probes:
  open: { between: [[0, 0], [0, 50 mm]], component: y }
  cmod: { between: [[25 mm, 24.5 mm], [25 mm, 25.5 mm]], component: y }
  side: { at: [50 mm, 25.5 mm], component: x }
";
        place.write("plate.yaml", text + probes);
        let set = format!("loading={{ control: {control}, steps: 40 }}");
        place
            .call(&["run", "plate.yaml", "--set", &set])
            .succeeded();
        let line = last_line(&place);
        let grip = line["grip_displacement_m"];
        // Reading adds two displacements of equal size.
        assert!(
            (line["probe_open_m"] / (2.0 * grip) - 1.0).abs() < 1e-12,
            "{control}: {line:?}"
        );
        assert!(line["probe_cmod_m"] > 0.0 && line["probe_cmod_m"] < 2.0 * grip);
        let summary: serde_json::Value =
            serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
        for probe in summary["probes"].as_array().expect("a list") {
            let name = probe["name"].as_str().expect("a name");
            let value = probe["displacement_m"].as_f64().expect("a number");
            let read = line[&format!("probe_{name}_m")];
            // The functional is carried along with the updates, the field is solved for: 1e-9, as their residuals.
            assert!(
                (read / value - 1.0).abs() < 1e-8,
                "{control}: {name} {read} {value}"
            );
            assert!(probe["distance_m"].as_f64().expect("a number") < 1.5e-3);
        }
    }
    let place = Workplace::with_plate();
    let neither = "probes={ a: { component: x } }";
    let message = ["a probe reads one point, `at`, or two points, `between`"];
    place.assert_refused(&["run", "plate.yaml", "--set", neither], 2, &message);
}

/// The held first row of a bar of points is stretched the most, since it cannot contract.
#[test]
fn a_held_row_that_tears_off_is_told_with_the_remedy() {
    let place = Workplace::new();
    place.edit(
        "bar.yaml",
        "{ young: 100 GPa, poisson: 1/3 }",
        "{ young: 100 GPa, poisson: 1/3, tensile_strength: 2 MPa }",
    );
    place.edit(
        "bar.yaml",
        "  - { group: [left, right], model: fem, material: solid }\n",
        "",
    );
    place.edit("bar.yaml", "group: band\n", "group: [left, band, right]\n");
    place.edit(
        "bar.yaml",
        "load, traction: { x: 1.05 MPa }",
        "load, displacement: { x: 1 µm }",
    );
    let text = String::from_utf8(place.read("bar.yaml")).expect("UTF-8");
    place.write(
        "bar.yaml",
        text + "loading: { control: event-driven, steps: 30 }\noutput: { pictures: false }\n",
    );
    let err = place.run(&[]).err;
    let told = "end at points whose displacement is prescribed by ";
    assert!(
        err.contains(told) && err.contains("under `no_fail`"),
        "{err}"
    );
    let warnings = place.summary()["warnings"].to_string();
    assert!(warnings.contains(told), "{warnings}");
    // It is kept when nothing runs, and when only the output runs again.
    place.run(&["--set", "output.bonds=true"]);
    assert_eq!(place.summary()["warnings"].to_string(), warnings);
}

#[test]
fn check_tells_conditions_in_the_units_that_a_person_thinks_in() {
    let place = Workplace::new();
    let turned = "boundary.0.displacement={ x: 0, y: 2.5e-5, angle: 30 deg }";
    let out = place
        .call(&["check", "bar.yaml", "--set", turned])
        .succeeded()
        .out;
    for line in [
        "thickness         1 m\n",
        "`band`: spacing 12.5 mm, horizon 50 mm\n",
        "`clamp` moves by x 0, y 25 µm, turned by 30 deg\n",
    ] {
        assert!(out.contains(line), "{line:?} is not in\n{out}");
    }
}

/// A study of two runs with a crack on a row of points.
#[test]
fn a_study_keeps_its_name_and_the_warnings_of_its_runs() {
    let place = Workplace::new();
    let from = workplace::repository().join("tests/geo/crack_on_points.geo");
    std::fs::copy(from, place.path("plate.geo")).expect("the geometry");
    place.write(
        "slit.yaml",
        "name: slit
geometry: { file: plate.geo, unit: mm }
materials: { m: { young: 30 GPa, poisson: 1/3 } }
regions: [{ group: plate, model: peridynamics, material: m, spacing: 1 mm, horizon: 3 }]
cracks: [crack]
boundary:
  - { group: bottom, displacement: { x: 0, y: 0 } }
  - { group: top, displacement: { y: 1 µm } }
output: { pictures: false, report: true }
sweep: { over: { regions.0.horizon: [3, 4] } }
",
    );
    let out = place.call(&["sweep", "slit.yaml"]).succeeded().out;
    let told = "warning of 2 of 2 runs: the cracks cut 16 material points off";
    assert!(out.contains(told), "{out}");
    let table = String::from_utf8(place.read("results/slit_sweep/sweep.csv")).expect("UTF-8");
    assert_eq!(
        table
            .matches("the cracks cut 16 material points off")
            .count(),
        2,
        "{table}"
    );
    let summary = place.read("results/slit_sweep/horizon-3/summary.json");
    let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
    assert_eq!(summary["study"], "slit");
    let page = String::from_utf8(place.read("results/slit_sweep/horizon-3/report.html"));
    let page = page.expect("UTF-8");
    assert!(page.contains("slit: horizon-3") && page.contains("16 material points off"));
}
