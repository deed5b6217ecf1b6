//! The numbers that a run ends with: no sign on a zero, no noise for a peak, the load that broke the first
//! bond and where it was, and the frame of the peak.

mod workplace;

use peristitch::pipeline::record::frames::Frame;
use serde_json::Value;
use workplace::{Workplace, repository};

/// A bar of 40 × 20 mm, half elements and half points, as `bar.yaml`.
fn bar(materials: &str, more: &str) -> Workplace {
    let place = Workplace::new();
    place.write(
        "geo/bar.geo",
        "Point(1)={0,0,0,2}; Point(2)={40,0,0,2}; Point(3)={40,20,0,2}; Point(4)={0,20,0,2};\n\
         Point(5)={20,0,0,2}; Point(6)={20,20,0,2};\n\
         Line(1)={1,5}; Line(2)={5,2}; Line(3)={2,3}; Line(4)={3,6}; Line(5)={6,4}; Line(6)={4,1};\n\
         Line(7)={5,6}; Line Loop(1)={1,7,5,6}; Line Loop(2)={2,3,4,-7};\n\
         Plane Surface(1)={1}; Plane Surface(2)={2};\n\
         Physical Surface(\"a\")={1}; Physical Surface(\"b\")={2};\n\
         Physical Line(\"left\")={6}; Physical Line(\"right\")={3}; Physical Point(\"corner\")={1};\n\
         Mesh.ElementOrder=2;\n",
    );
    place.write(
        "bar.yaml",
        format!(
            "name: bar\ngeometry: {{ file: geo/bar.geo, unit: mm }}\nthickness: 1 mm\n\
             materials:\n  m: {{ young: 30 GPa, poisson: 1/3{materials} }}\n\
             regions:\n\
             \x20 - {{ group: a, model: fem, material: m }}\n\
             \x20 - {{ group: b, model: peridynamics, material: m, spacing: 1 mm, horizon: 3 }}\n\
             coupling: clip\n{more}\n"
        ),
    );
    place
}

const STRONG: &str = ", tensile_strength: 3 MPa";

#[test]
fn a_body_that_nothing_loads_is_told_without_signs_of_zero() {
    let place = bar(
        STRONG,
        "boundary:\n  - { group: left, displacement: { x: 0, y: 0 } }\n\
         \x20 - { group: right, displacement: { x: 0, y: 0 } }\n\
         output: { pictures: false }\nloading: { control: event-driven, steps: 10 }",
    );
    let ended = place.run(&[]);
    let warning = "nothing loads the body: every prescribed displacement and load is 0";
    assert_eq!(ended.err.matches(warning).count(), 1, "{}", ended.err);
    for wrong in ["NaN", "-0"] {
        assert!(!ended.out.contains(wrong), "{}", ended.out);
        assert!(!ended.err.contains(wrong), "{}", ended.err);
    }
    let checked = place.call(&["check", "bar.yaml"]).succeeded();
    assert_eq!(checked.err.matches(warning).count(), 1, "{}", checked.err);
}

/// Under the strength nothing breaks; the elastic solution has zeros of both signs.
#[test]
fn no_zero_of_the_history_has_a_sign() {
    let place = bar(
        STRONG,
        "boundary:\n  - { group: left, displacement: { x: 0, y: 0 } }\n\
         \x20 - { group: right, displacement: { x: 1 µm } }\n\
         output: { pictures: false }\nloading: { control: equilibrium, steps: 2 }",
    );
    let ended = place.run(&[]);
    let history = String::from_utf8(place.read("results/bar/history.csv")).expect("UTF-8");
    let cells = history.lines().skip(1).flat_map(|line| line.split(','));
    assert!(cells.clone().count() > 30);
    assert!(
        cells.clone().all(|cell| cell != "-0" && cell != "NaN"),
        "{history}"
    );
    assert!(ended.out.contains("crack length: 0 m"), "{}", ended.out);
    assert_eq!(
        place.summary()["fracture"]["crack_length_m"].to_string(),
        "0.0"
    );
}

/// A rigid translation has no forces, which is no loss of any.
#[test]
fn a_rigid_translation_needs_no_warning() {
    let place = bar(
        "",
        "boundary:\n  - { group: left, displacement: { x: 1 µm, y: 0 } }\n\
         \x20 - { group: right, displacement: { x: 1 µm, y: 0 } }\noutput: { pictures: false }",
    );
    let ended = place.run(&[]);
    assert!(!ended.err.contains("differ by"), "{}", ended.err);
    assert!(!ended.out.contains("-0"), "{}", ended.out);
}

/// The plate, whose history and summary are read.
struct Plate {
    place: Workplace,
    out: String,
    fracture: Value,
}

impl Plate {
    fn run(control: &str, edits: &[[&str; 2]]) -> Plate {
        let place = Workplace::with_plate();
        place.edit(
            "plate.yaml",
            "control: one-pass",
            &format!("control: {control}"),
        );
        for [old, new] in edits {
            place.edit("plate.yaml", old, new);
        }
        let ended = place.call(&["run", "plate.yaml"]).succeeded();
        let summary: Value =
            serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
        Plate {
            place,
            out: ended.out,
            fracture: summary["fracture"].clone(),
        }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let text = self.place.read("results/plate/history.csv");
        let text = String::from_utf8(text).expect("UTF-8");
        let mut lines = text.lines();
        let place = lines
            .next()
            .expect("names")
            .split(',')
            .position(|cell| cell == name);
        let place = place.expect("a column");
        let cell = |line: &str| line.split(',').nth(place).expect("a cell").parse();
        lines.map(|line| cell(line).expect("a number")).collect()
    }

    fn event(&self, name: &str, key: &str) -> f64 {
        self.fracture[name][key].as_f64().expect("a number")
    }

    fn frame(&self, step: usize) -> Frame {
        let file = format!("results/plate/frames/{step:06}.bin");
        Frame::from_file(&self.place.read(&file)).expect("a frame")
    }
}

/// The plate pulled apart by forces on its grips, its lower edge held at one end: the supports carry rounding.
const FORCES: [[&str; 2]; 3] = [
    [
        "{ group: top, displacement: { x: 0, y: 2.0e-8 m } }",
        "{ group: top, traction: { y: 0.1 MPa } }",
    ],
    [
        "{ group: bottom, displacement: { x: 0, y: -2.0e-8 m } }",
        "{ group: bottom, traction: { y: -0.1 MPa } }\n  \
         - { where: { x: min, y: min }, displacement: { x: 0, y: 0 } }\n  \
         - { where: { x: max, y: min }, displacement: { y: 0 } }",
    ],
    [
        "pictures: false",
        "pictures: [load-displacement], formats: [svg]",
    ],
];

#[test]
fn the_peak_of_forces_in_balance_is_their_factor() {
    let plate = Plate::run("event-driven", &FORCES);
    assert_eq!(plate.fracture["driven_by"], "forces");
    let factors = plate.column("load_factor");
    let largest = factors.iter().copied().fold(0.0, f64::max);
    assert_eq!(plate.event("peak", "load_factor"), largest);
    assert_eq!(plate.event("envelope_peak", "load_factor"), largest);
    // Two tractions of λ 0.1 MPa on 50 mm, 1 m thick. The nodal forces are sums of some hundred products.
    let load = 2.0 * largest * 0.1e6 * 0.05;
    assert!((plate.event("peak", "load_n") / load - 1.0).abs() < 1e-12);
    // The supports carry rounding, far below the load.
    assert!(plate.event("peak", "reaction_n") < 1e-6 * load);
    assert!(!plate.out.contains("peak reaction"), "{}", plate.out);
    assert!(
        plate.out.contains("largest load factor: step"),
        "{}",
        plate.out
    );
    let chart = plate.place.read("results/plate/load_displacement.svg");
    let chart = String::from_utf8(chart).expect("UTF-8");
    for axis in [">load factor<", ">displacement along the loads ["] {
        assert!(chart.contains(axis), "{axis}");
    }
    assert_peak_has_frame(&plate);
}

/// The step of the peak has a frame, in its place among those of every seventh step.
fn assert_peak_has_frame(plate: &Plate) {
    let step = plate.event("peak", "step");
    let frames = plate.fracture["frames"].as_array().expect("a list");
    let frames: Vec<f64> = frames
        .iter()
        .map(|step| step.as_f64().expect("a step"))
        .collect();
    assert!(frames.contains(&step), "{step} {frames:?}");
    assert!(frames.is_sorted(), "{frames:?}");
    let series = plate.place.read("results/plate/plate.pvd");
    let series = String::from_utf8(series).expect("UTF-8");
    assert!(
        series.contains(&format!("timestep=\"{step}.0\"")),
        "{series}"
    );
}

/// Against the frame that the run itself writes when it writes all of them. Chips that came off before the peak
/// are among the nodes.
#[test]
fn the_frame_of_the_peak_is_that_of_its_step() {
    for control in ["event-driven", "equilibrium", "one-pass"] {
        let plate = Plate::run(control, &[["every: 7", "every: 100000"]]);
        let step = plate.event("peak", "step") as usize;
        let last = plate.event("end", "step") as usize;
        assert!(0 < step && step < last, "{control}");
        assert_peak_has_frame(&plate);
        let all = Plate::run(control, &[["every: 7", "every: 1"]]);
        let [found, written] = [&plate, &all].map(|plate| plate.frame(step));
        assert_eq!(found.integrity, written.integrity, "{control}");
        assert_eq!(found.load_factor, written.load_factor);
        let size = written
            .displacement
            .iter()
            .flatten()
            .fold(0.0, |size, u| f64::max(size, u.abs()));
        let pairs = found
            .displacement
            .iter()
            .flatten()
            .zip(written.displacement.iter().flatten());
        let error = pairs.fold(0.0, |error, (a, b)| f64::max(error, (a - b).abs())) / size;
        // Updates of a factorisation agree with a factorisation to 1e-10.
        assert!(error < 1e-9, "{control}: {error:e}");
    }
}

/// Under displacements the peak is the largest reaction, whatever the largest opening is; the force that the
/// separation is decided by is told beside it.
#[test]
fn the_largest_opening_is_not_called_a_load() {
    let plate = Plate::run("event-driven", &[["steps: 200", "steps: 400"]]);
    assert_eq!(plate.fracture["driven_by"], "displacements");
    let reactions = plate.column("reaction_n");
    let largest = reactions.iter().copied().fold(0.0, f64::max);
    assert_eq!(plate.event("peak", "reaction_n"), largest);
    assert!(!plate.out.contains("largest load:"), "{}", plate.out);
    let left = plate.fracture["force_left"].as_f64().expect("a share");
    // Two grips that move alike: the force that works on them is the reaction on each.
    let end = plate.event("end", "reaction_n") / largest;
    assert!((left - end).abs() < 1e-6, "{left} {end}");
    let told = format!("{:.1} % of its largest is left", 100.0 * left);
    assert!(plate.out.contains(&told), "{}", plate.out);
}

/// The first bond breaks at the crack's tip, under the force that the whole body carries there; the line of the
/// history holds what is left after the breaks of that step.
#[test]
fn the_first_break_has_the_load_that_broke_it_and_its_place() {
    let plate = Plate::run("equilibrium", &[]);
    let [factors, reactions] = ["load_factor", "reaction_n"].map(|name| plate.column(name));
    let step = plate.event("first_break", "step") as usize;
    // Elastic until then: the reaction is in proportion to λ, to rounding.
    let elastic = reactions[0] / factors[0] * factors[step - 1];
    let told = plate.event("first_break", "reaction_n");
    assert!((told / elastic - 1.0).abs() < 1e-12, "{told} {elastic}");
    assert!(reactions[step - 1] < told, "{} {told}", reactions[step - 1]);
    let at = &plate.fracture["first_break"]["at_m"];
    let [x, y] = [0, 1].map(|axis| at[axis].as_f64().expect("a coordinate"));
    assert!(plate.out.contains(", bond at ("), "{}", plate.out);
    // The tips lie at 20 mm and 30 mm, the crack at half the height of 50 mm; the horizon is 3 mm.
    assert!(((x - 0.025).abs() - 0.005).abs() < 3e-3, "{x}");
    assert!((y - 0.025).abs() < 3e-3, "{y}");
}

/// A strip of glass between unbreakable ones, pulled apart where its notch begins, with an unbreakable end.
fn strip(loading: &str) -> Workplace {
    let place = Workplace::new();
    place.write(
        "geo/strip.geo",
        "Point(1)={0,0,0,2}; Point(2)={40,0,0,2}; Point(3)={60,0,0,2}; Point(4)={60,40,0,2};\n\
         Point(5)={40,40,0,2}; Point(6)={0,40,0,2}; Point(7)={0,4,0,2}; Point(8)={40,4,0,2};\n\
         Point(9)={40,36,0,2}; Point(10)={0,36,0,2}; Point(11)={0,20,0,2}; Point(12)={12,20,0,2};\n\
         Line(1)={1,2}; Line(2)={2,3}; Line(3)={3,4}; Line(4)={4,5}; Line(5)={5,6}; Line(6)={6,10};\n\
         Line(7)={10,7}; Line(8)={7,1}; Line(9)={7,8}; Line(10)={8,9}; Line(11)={9,10}; Line(12)={2,8};\n\
         Line(13)={9,5}; Line(14)={11,12}; Line Loop(1)={9,10,11,7}; Line Loop(2)={1,12,-9,8};\n\
         Line Loop(3)={-11,13,5,6}; Line Loop(4)={2,3,4,-13,-10,-12};\n\
         Plane Surface(1)={1}; Plane Surface(2)={2}; Plane Surface(3)={3}; Plane Surface(4)={4};\n\
         Physical Surface(\"glass\")={1}; Physical Surface(\"stop\")={2,3,4};\n\
         Physical Line(\"crack\")={14};\n",
    );
    place.write(
        "strip.yaml",
        format!(
            "name: strip\ngeometry: {{ file: geo/strip.geo, unit: mm }}\n\
             materials:\n  glass: {{ young: 70 GPa, poisson: 1/3, energy_release_rate: 10 N/m }}\n\
             regions:\n  - {{ group: [glass, stop], model: peridynamics, material: glass, spacing: 1 mm, \
             horizon: 3 }}\nno_fail: [stop]\ncracks: [crack]\nboundary:\n\
             \x20 - {{ where: {{ x: min, y: min }}, displacement: {{ y: -0.1 µm }} }}\n\
             \x20 - {{ where: {{ x: min, y: max }}, displacement: {{ y: 0.1 µm }} }}\n\
             \x20 - {{ where: {{ x: max }}, displacement: {{ x: 0 }} }}\n\
             loading: {{ {loading} }}\noutput: {{ pictures: false, every: 100000 }}\n"
        ),
    );
    place.call(&["run", "strip.yaml"]).succeeded();
    place
}

/// The crack runs from 12 to 40 mm while the load falls to less than half; behind that nothing can break, and the
/// load grows again. `until: steps` goes on.
#[test]
fn a_crack_that_has_reached_unbreakable_material_ends_the_run() {
    let summary = |place: &Workplace| -> Value {
        serde_json::from_slice(&place.read("results/strip/summary.json")).expect("JSON")
    };
    let stopped = summary(&strip("control: event-driven"));
    assert_eq!(stopped["outcome"], "reached unbreakable material");
    let fracture = &stopped["fracture"];
    let number = |event: &str, key: &str| fracture[event][key].as_f64().expect("a number");
    let [peak, end] = ["peak", "end"].map(|event| number(event, "reaction_n"));
    assert!((0.5 * peak..peak).contains(&end), "{end} of {peak}");
    let steps = number("end", "step") as usize;
    let more = format!("control: event-driven, until: steps, steps: {}", steps + 20);
    let all = summary(&strip(&more));
    assert_eq!(all["outcome"], "step limit");
    assert_eq!(
        all["fracture"]["end"]["step"].as_u64(),
        Some(steps as u64 + 20)
    );
}

/// Steps that can break nothing would have no end.
#[test]
fn a_run_without_steps_ends_where_nothing_can_break() {
    let place = bar(
        STRONG,
        "boundary:\n  - { group: left, displacement: { x: 0, y: 0 } }\n\
         \x20 - { group: right, displacement: { x: 0, y: 0 } }\n\
         output: { pictures: false }\nloading: { control: equilibrium }",
    );
    place.run(&[]);
    assert_eq!(place.summary()["outcome"], "nothing left to break");
    place.edit(
        "bar.yaml",
        "control: equilibrium",
        "control: equilibrium, until: steps",
    );
    let refused = place.call(&["run", "bar.yaml"]);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused
            .err
            .contains("`until: steps` needs a number of steps"),
        "{}",
        refused.err
    );
}

/// `check` tells what breaking takes. 20 rows of points at 1 mm see 3 mm far: over a cut between two columns go
/// 342 bonds, dx (20 − |dy|) for each vector (dx, dy) of at most 3 spacings, and the initial crack severs
/// dx |dy| of each, 18 in all.
#[test]
fn check_counts_the_bonds_on_a_crack() {
    let place = Workplace::with_plate();
    let told = place.call(&["check", "plate.yaml"]).succeeded().out;
    assert!(
        told.contains("more for a crack straight across `band`: 324 bonds on 20.000 mm"),
        "{told}"
    );
    // The set-up is a phase of the run, and so are the laws of the bonds.
    place.call(&["run", "plate.yaml"]).succeeded();
    let summary: Value =
        serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
    let phases = summary["phases"].as_array().expect("a list");
    let seconds = |name: &str| {
        let phase = phases.iter().find(|phase| phase["phase"] == name);
        phase
            .and_then(|phase| phase["seconds"].as_f64())
            .expect("a time")
    };
    assert!(seconds("discretisation") > 0.0 && seconds("bond laws") > 0.0);
    let all = phases
        .iter()
        .map(|phase| phase["seconds"].as_f64().expect("a time"));
    let whole = summary["seconds"].as_f64().expect("a time");
    assert!((all.sum::<f64>() / whole - 1.0).abs() < 1e-6);
}

/// `check` tells the memory of event-driven runs, of few events and of many, to a quarter.
#[test]
fn check_tells_the_memory_of_event_driven_runs() {
    for name in ["compact_tension", "three_point_bending"] {
        let place = Workplace::new();
        let pipeline = repository().join(format!("pipelines/{name}.yaml"));
        let pipeline = pipeline.to_str().expect("UTF-8");
        let results = place.path("results");
        let results = results.to_str().expect("UTF-8");
        let call = |command: &str| {
            let arguments = [command, pipeline, "--results", results];
            place.call(&arguments).succeeded().out
        };
        let told = call("check");
        let megabytes = told
            .split("to expect")
            .nth(1)
            .and_then(|rest| rest.split_whitespace().next())
            .and_then(|number| number.parse::<f64>().ok());
        let announced = 1e6 * megabytes.expect("a number");
        call("run");
        let summary = place.read(&format!("results/{name}/summary.json"));
        let summary: Value = serde_json::from_slice(&summary).expect("JSON");
        let taken = summary["peak_memory_bytes"].as_f64().expect("bytes");
        assert!(
            (announced / taken - 1.0).abs() < 0.25,
            "{name}: {announced} {taken}"
        );
    }
}
