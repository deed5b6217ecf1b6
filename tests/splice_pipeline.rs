//! `coupling: splice` from the pipeline: a disc of points in a plate stretches uniformly, the overlap is in no
//! output, a notched plate separates, and what cannot be spliced is told at its key.

mod workplace;

use serde_json::Value;
use workplace::{PLATE, Workplace, repository};

const STRAIN: f64 = 1e-5;

fn stretched(spacing: &str) -> Workplace {
    let place = Workplace::new();
    let geometry = repository().join("tests/geo/disc.geo");
    std::fs::copy(geometry, place.path("geo/disc.geo")).expect("the geometry");
    place.write(
        "bar.yaml",
        format!(
            "\
name: bar
geometry: {{ file: geo/disc.geo, unit: mm }}
materials: {{ rock: {{ young: 30 GPa, poisson: 1/3 }} }}
regions:
  - {{ group: plate, model: fem, material: rock }}
  - {{ group: disc, model: peridynamics, material: rock, spacing: {spacing}, horizon: 4 }}
coupling: splice
boundary:
  - {{ group: left, displacement: {{ x: 0 }} }}
  - {{ group: corner, displacement: {{ y: 0 }} }}
  - {{ group: right, displacement: {{ x: 1 µm }} }}
probes:
  front: {{ at: [42 mm, 30 mm], component: x }}
  back: {{ at: [58 mm, 30 mm], component: x }}
"
        ),
    );
    place
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn a_disc_in_a_plate_stretches_uniformly() {
    let place = stretched("1 mm");
    place.run(&[]);
    let summary = place.summary();
    for probe in summary["probes"].as_array().expect("a list") {
        let exact = STRAIN * number(&probe["at_m"][0]);
        let error = number(&probe["displacement_m"]) / exact - 1.0;
        // Coordinates from Gmsh, and a few hundred unknowns.
        assert!(error.abs() < 1e-12, "{probe}: {error:e}");
    }
    let [left, right] = ["left", "right"].map(|group| number(&summary["reactions_n"][group][0]));
    let uniform = 30e9 * STRAIN * 0.06;
    assert!(
        (right / uniform - 1.0).abs() < 1e-11,
        "{right} for {uniform}"
    );
    assert!((left / uniform + 1.0).abs() < 1e-11, "{left} for {uniform}");
    let sizes = &summary["sizes"];
    assert!(number(&sizes["overlap_elements"]) > 0.0 && number(&sizes["ghost_bonds"]) > 0.0);
    assert_eq!(number(&sizes["trusses"]), 0.0);
    // The output holds the elements of the plate, and no others; nodes behind the interface are unknowns only.
    let text = std::fs::read(place.path("results/bar/bar_elements.vtu")).expect("a file");
    let text = String::from_utf8_lossy(&text);
    let cells = format!("NumberOfCells=\"{}\"", sizes["finite_elements"]);
    let nodes = format!("NumberOfPoints=\"{}\"", sizes["finite_element_nodes"]);
    assert!(
        text.contains(&cells) && text.contains(&nodes),
        "{cells} {nodes}"
    );
    let nodes = number(&sizes["finite_element_nodes"]) + number(&sizes["material_points"]);
    assert!(number(&sizes["dofs"]) > 2.0 * nodes);
}

#[test]
fn a_notched_plate_separates() {
    let place = Workplace::with_plate();
    place.write(
        "plate.yaml",
        PLATE
            .replace("cracks: [crack]", "cracks: [crack]\ncoupling: splice")
            .replace("one-pass", "equilibrium"),
    );
    let ended = place.call(&["run", "plate.yaml"]);
    assert_eq!(ended.code, Some(0), "{}", ended.err);
    let text = std::fs::read(place.path("results/plate/summary.json")).expect("a file");
    let summary: Value = serde_json::from_slice(&text).expect("JSON");
    assert_eq!(summary["outcome"], "separated");
    assert!(number(&summary["fracture"]["largest_residual"]) < 1e-12);
}

#[test]
fn what_cannot_be_spliced_is_an_error_of_input() {
    // The plate is 15 mm wide above and below the disc, the horizon 18 mm.
    let ended = stretched("4.5 mm").call(&["run", "bar.yaml"]);
    assert_eq!(ended.code, Some(2), "{}", ended.err);
    for part in [
        "region `disc` cannot be spliced",
        "narrower than its horizon of 1.8000e-2 m",
        "make the finite-element region wider",
        "bar.yaml",
    ] {
        let told: String = ended.err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(told.contains(part), "{part}: {}", ended.err);
    }
    let ended = stretched("1 mm").call(&["run", "bar.yaml", "--set", "coupling=splce"]);
    assert_eq!(ended.code, Some(2), "{}", ended.err);
    assert!(ended.err.contains("splice"), "{}", ended.err);
}
