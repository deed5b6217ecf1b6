//! The numbers of the report that are asked for first.

use crate::output::number::{percent, quantity, scientific, signed_percent};
use crate::pipeline::account::summary::{DrivenBy, Event, FractureSummary, ProbeSummary, Summary};
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::spec::Control;
use serde_json::json;

/// Reactions below this share of the largest are what rounding leaves of zero.
const ROUNDING: f64 = 1e-9;

/// Ending of the run, and the versions.
pub(super) fn headline(summary: &Summary) -> String {
    let version = |program: &str| summary.versions.get(program).map_or("", String::as_str);
    format!(
        "{}. peristitch {}, Gmsh {}",
        summary.outcome,
        version("peristitch"),
        version("gmsh")
    )
}

/// Name and value of what is asked for first.
pub(super) fn numbers(plan: &Plan, summary: &Summary) -> Vec<[String; 2]> {
    let mut rows = Vec::new();
    let mut row = |name: &str, value: String| rows.push([name.to_owned(), value]);
    if let Some(fracture) = &summary.fracture {
        for (name, event, reference) in events(summary, fracture) {
            let reference =
                reference.map_or_else(String::new, |step| format!(" (reference: step {step})"));
            row(
                name,
                format!(
                    "step {}{reference}: {}",
                    event.step,
                    described(event, fracture.driven_by)
                ),
            );
        }
        if let Some(left) = fracture.force_left {
            let name = "force along the prescribed displacements at the end";
            row(name, format!("{} of its largest", percent(left, 1)));
        }
        row("control", super::plain(&json!(fracture.control)));
        row("bonds broken", fracture.bonds_broken.to_string());
        if let Some(length) = fracture.crack_length_m {
            row("crack length", quantity(length, "m"));
        }
    }
    for probe in &summary.probes {
        row(&format!("probe {}", probe.name), described_probe(probe));
    }
    let forces = summary.reactions_n.values().flatten();
    let largest = forces.fold(0.0, |largest: f64, force| largest.max(force.abs()));
    for (group, reaction) in &summary.reactions_n {
        let [x, y] = reaction.map(|force| match force.abs() <= ROUNDING * largest {
            true => "0".to_owned(),
            false => quantity(force, "N"),
        });
        row(&format!("reaction on {group}"), format!("x {x}, y {y}"));
    }
    row("thickness", quantity(plan.model.thickness, "m"));
    for (name, material) in &plan.spec.materials {
        let written = json!(material);
        let properties = written.as_object().into_iter().flatten();
        let properties: Vec<String> = properties
            .map(|(key, value)| format!("{} {}", key.replace('_', " "), super::plain(value)))
            .collect();
        row(&format!("material {name}"), properties.join(", "));
    }
    for lattice in &summary.lattices {
        let [spacing, horizon] = [lattice.spacing_m, lattice.horizon_m];
        row(
            &format!("lattice {}", lattice.region),
            format!(
                "dx {}, δ {} = {} dx",
                quantity(spacing, "m"),
                quantity(horizon, "m"),
                quantity(horizon / spacing, "")
            ),
        );
    }
    let sizes = &summary.sizes;
    for (name, count) in [
        ("finite elements", sizes.finite_elements),
        ("their nodes", sizes.finite_element_nodes),
        ("material points", sizes.material_points),
        ("bonds", sizes.bonds),
        ("trusses", sizes.trusses),
        ("unknowns", sizes.dofs),
    ] {
        row(name, count.to_string());
    }
    row("residual", format!("{:.1e}", summary.residual));
    for warning in &summary.warnings {
        row("warning", warning.clone());
    }
    rows
}

/// The steps that are asked for first, each with its name and the pipeline's reference for it.
fn events<'a>(
    summary: &'a Summary,
    fracture: &'a FractureSummary,
) -> Vec<(&'a str, &'a Event, Option<usize>)> {
    // The references count load steps, and the events of the event-driven control are none; under the
    // other controls the load only grows, so that the largest load is the end.
    let is_event_driven = fracture.control == Some(Control::EventDriven);
    let reference = fracture.reference.filter(|_| !is_event_driven);
    let by_forces = fracture.driven_by == DrivenBy::Forces;
    let largest_load = fracture.envelope_peak.as_ref();
    let largest_load = largest_load.filter(|_| is_event_driven || by_forces);
    let peak = fracture.peak.as_ref().filter(|_| !by_forces);
    let events = [
        (
            "first bond broken",
            fracture.first_break.as_ref(),
            reference.and_then(|reference| reference.first_break),
        ),
        ("largest reaction", peak, None),
        ("largest load factor", largest_load, None),
        (
            &summary.outcome,
            fracture.end.as_ref(),
            reference.and_then(|reference| reference.separated),
        ),
    ];
    let there = events.into_iter();
    there
        .filter_map(|(name, event, reference)| Some((name, event?, reference)))
        .collect()
}

/// The load of an event, and the place of the bond that broke.
fn described(event: &Event, driven_by: DrivenBy) -> String {
    let mut text = format!("load factor {}", quantity(event.load_factor, ""));
    match (driven_by, event.load_n) {
        (DrivenBy::Displacements, _) => {
            text += &format!(
                ", grip displacement {}, reaction {}",
                quantity(event.grip_displacement_m, "m"),
                quantity(event.reaction_n, "N")
            );
        }
        (DrivenBy::Forces, Some(load)) => text += &format!(", load {}", quantity(load, "N")),
        (DrivenBy::Forces, None) => {}
    }
    if let Some(at) = event.at_m {
        let [x, y] = at.map(|metres| quantity(1e3 * metres, ""));
        text += &format!(", bond at ({x}, {y}) mm");
    }
    text
}

fn described_probe(probe: &ProbeSummary) -> String {
    let displacement = scientific(probe.displacement_m, 5);
    let mut text = format!("u_{} = {displacement} m", probe.component);
    if let (Some(reference), Some(error)) = (probe.reference_m, probe.error) {
        text += &format!(
            "; reference {} m, error {}",
            scientific(reference, 5),
            signed_percent(error)
        );
    }
    text
}
