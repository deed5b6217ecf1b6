//! The numbers that a run ends with: no sign on a zero, and a warning where nothing loads the body.

mod workplace;

use workplace::Workplace;

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
