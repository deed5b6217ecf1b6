//! What a person of the field writes first, before reading the manual: it is taken, or answered with what to write.

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
        "keep one of `tensile_strength`, `fracture_toughness`",
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
