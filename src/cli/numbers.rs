//! Closing lines of a run: the main numbers, and the files.

use crate::output::number::{percent, quantity, scientific, signed_percent};
use crate::pipeline::account::summary::{
    DrivenBy, Event, FractureSummary, PhaseSummary, ProbeSummary, Summary,
};
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::spec::Control;
use crate::pipeline::record::writer;
use crate::pipeline::show::damage_picture::DAMAGE_PICTURE;
use crate::pipeline::show::report::REPORT_FILE;
use std::collections::BTreeMap;

/// Numbers that a person wants to see, to standard output.
pub(super) fn print_numbers(summary: &Summary) {
    summary.probes.iter().for_each(print_probe);
    if let Some(fracture) = &summary.fracture {
        print_fracture(&summary.outcome, fracture);
    }
    print_reactions(&summary.reactions_n);
}

/// The picture that tells most.
pub(super) fn print_picture(plan: &Plan, summary: &Summary) {
    let is_there = |name: &&str| summary.files.iter().any(|file| file == name);
    let pictures = [DAMAGE_PICTURE, "displacement_x.png"];
    if let Some(picture) = pictures.into_iter().find(is_there) {
        println!("  {}/{picture}", plan.folder.display());
    }
}

pub(super) fn print_files(plan: &Plan, summary: &Summary) {
    let folder = plan.folder.display();
    if summary.files.iter().any(|file| file == REPORT_FILE) {
        println!("  {folder}/{REPORT_FILE}  (all of it on one page, for a browser)");
    }
    if summary.fracture.is_some() {
        println!("  {folder}/{}  (a line per step)", writer::HISTORY_FILE);
    }
    for file in &summary.files {
        let what = match file.rsplit('.').next() {
            // Listed by the series, or above, or meant for `view`.
            Some("vtu" | "html" | "py") => continue,
            Some("pvd") => "for ParaView: `peristitch view`",
            Some("png" | "svg" | "pdf") => "picture",
            Some("gif") => "the damage as it grows",
            _ => "sizes, times, versions",
        };
        println!("  {folder}/{file}  ({what})");
    }
}

/// Next command for a result.
pub(super) fn print_next(plan: &Plan) {
    let pipeline = plan.source.path.display();
    if plan.spec.sweep.is_some() {
        println!("  next: peristitch sweep {pipeline}  (its study)");
    }
    println!("  next: peristitch watch {pipeline}  (runs it again after each save)");
}

/// First break, peak and end of a fracture run, each with what the pipeline gives as its reference.
fn print_fracture(outcome: &str, fracture: &FractureSummary) {
    let print = |title: &str, event: &Option<Event>, reference: Option<usize>| {
        let driven_by = fracture.driven_by;
        let line = described_event(title, event.as_ref(), reference, driven_by);
        println!("  {line}");
    };
    // The references count load steps, and the events of the event-driven control are none.
    let is_event_driven = fracture.control == Some(Control::EventDriven);
    let reference = fracture.reference.filter(|_| !is_event_driven);
    let reference = reference.unwrap_or_default();
    print(
        "first bond broken",
        &fracture.first_break,
        reference.first_break,
    );
    if fracture.driven_by == DrivenBy::Displacements {
        print("peak reaction", &fracture.peak, None);
    }
    if fracture.driven_by == DrivenBy::Forces || is_event_driven {
        print("largest load factor", &fracture.envelope_peak, None);
    }
    print(outcome, &fracture.end, reference.separated);
    if let Some(left) = fracture.force_left {
        println!(
            "  force along the prescribed displacements: {} of its largest is left",
            percent(left, 1)
        );
    }
    if !fracture.fragments.is_empty() {
        println!(
            "  come off: {} parts of {} points in all",
            fracture.fragments.len(),
            fracture.fragments.iter().sum::<usize>()
        );
    }
    if let Some(reason) = &fracture.stopped_because {
        println!("  because {reason}");
    }
    let length = fracture.crack_length_m;
    let length = length.map(|length| format!("; crack length: {} m", scientific(length, 4)));
    println!(
        "  bonds broken: {}{}",
        fracture.bonds_broken,
        length.unwrap_or_default()
    );
}

/// An event in one line: its step, its load, and the place of the bond that broke.
fn described_event(
    title: &str,
    event: Option<&Event>,
    reference: Option<usize>,
    driven_by: DrivenBy,
) -> String {
    let reference = reference.map_or_else(String::new, |step| format!(" (reference: step {step})"));
    let Some(event) = event else {
        return format!("{title}: never{reference}");
    };
    let factor = quantity(event.load_factor, "");
    let load = match driven_by {
        DrivenBy::Displacements => format!(
            "at {} m and {} N",
            scientific(event.grip_displacement_m, 4),
            scientific(event.reaction_n, 4)
        ),
        DrivenBy::Forces => match event.load_n {
            Some(load) => format!("at λ = {factor}, {} N", scientific(load, 4)),
            None => format!("at λ = {factor}"),
        },
    };
    let place = event.at_m.map_or_else(String::new, |at| {
        let [x, y] = at.map(|metres| quantity(1e3 * metres, ""));
        let factor = match driven_by {
            DrivenBy::Displacements => format!(", λ = {factor}"),
            DrivenBy::Forces => String::new(),
        };
        format!("{factor}, bond at ({x}, {y}) mm")
    });
    format!("{title}: step {}{reference}, {load}{place}", event.step)
}

/// Components below this share of the largest are what rounding leaves of zero.
const ROUNDING: f64 = 1e-9;

fn print_reactions(reactions: &BTreeMap<String, [f64; 2]>) {
    let forces = reactions.values().flatten();
    let largest = forces.fold(0.0, |largest: f64, force| largest.max(force.abs()));
    for (group, reaction) in reactions {
        let [x, y] = reaction.map(|force| match force.abs() > ROUNDING * largest {
            true => format!("{force:.6e}"),
            false => "0".to_owned(),
        });
        println!("  reaction on {group}: ({x}, {y}) N");
    }
}

fn print_probe(probe: &ProbeSummary) {
    let mut line = format!(
        "  {}: u_{} = {:.5e} m",
        probe.name, probe.component, probe.displacement_m
    );
    if let (Some(reference), Some(error)) = (probe.reference_m, probe.error) {
        line.push_str(&format!(
            "  ({} of the reference {reference:.4e} m)",
            signed_percent(error)
        ));
    }
    println!("{line}");
}

/// Phases by their time, the longest first.
pub(super) fn print_phases(summary: &Summary) {
    let mut phases: Vec<&PhaseSummary> = summary.costs.phases.iter().collect();
    phases.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    println!("  {:<24}{:>10}{:>8}{:>10}", "phase", "s", "share", "times");
    for phase in phases {
        println!(
            "  {:<24}{:>10.4}{:>6.1} %{:>10}",
            phase.phase,
            phase.seconds,
            100.0 * phase.share,
            phase.count
        );
    }
}
