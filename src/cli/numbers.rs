//! What a run prints when it is done: the numbers that a person wants to see, and the files.

use crate::pipeline::read::plan::Plan;
use crate::pipeline::record::writer;
use crate::pipeline::show::damage_picture::DAMAGE_PICTURE;
use crate::pipeline::show::report::REPORT_FILE;
use serde_json::Value;

/// Numbers that a person wants to see, to standard output.
pub(super) fn print_numbers(summary: &Value) {
    for probe in list_in(summary, "probes") {
        print_probe(&probe);
    }
    print_fracture(summary);
    print_reactions(&summary["reactions_n"]);
}

fn list_in(summary: &Value, key: &str) -> Vec<Value> {
    summary[key].as_array().cloned().unwrap_or_default()
}

/// The picture that tells most.
pub(super) fn print_picture(plan: &Plan, summary: &Value) {
    let files = list_in(summary, "files");
    let is_there = |name: &&str| files.iter().any(|file| file == name);
    let pictures = [DAMAGE_PICTURE, "displacement_x.png"];
    if let Some(picture) = pictures.into_iter().find(is_there) {
        println!("  {}/{picture}", plan.folder.display());
    }
}

pub(super) fn print_files(plan: &Plan, summary: &Value) {
    let folder = plan.folder.display();
    let files = list_in(summary, "files");
    let files = || files.iter().filter_map(Value::as_str);
    if files().any(|file| file == REPORT_FILE) {
        println!("  {folder}/{REPORT_FILE}  (all of it on one page, for a browser)");
    }
    if !summary["fracture"].is_null() {
        println!("  {folder}/{}  (a line per step)", writer::HISTORY_FILE);
    }
    for file in files() {
        let what = match file.rsplit('.').next() {
            // Listed by the series, or above, or meant for `view`.
            Some("vtu" | "html" | "py") => continue,
            Some("pvd") => "for ParaView: `peristitch view`",
            Some("png" | "svg") => "picture",
            Some("gif") => "the damage as it grows",
            _ => "sizes, times, versions",
        };
        println!("  {folder}/{file}  ({what})");
    }
}

/// What one does next with a result.
pub(super) fn print_next(plan: &Plan) {
    let pipeline = plan.source.path.display();
    if plan.spec.sweep.is_some() {
        println!("  next: peristitch sweep {pipeline}  (its study)");
    }
    println!("  next: peristitch watch {pipeline}  (runs it again after each save)");
}

/// Onset, peak and end of a fracture run, each with what the pipeline gives as its reference.
fn print_fracture(summary: &Value) {
    let fracture = &summary["fracture"];
    if fracture.is_null() {
        return;
    }
    let event = |title: &str, event: &Value, reference: &Value| {
        let reference = reference
            .as_u64()
            .map(|step| format!(" (reference: step {step})"));
        let Some(step) = event["step"].as_u64() else {
            println!("  {title}: never{}", reference.unwrap_or_default());
            return;
        };
        println!(
            "  {title}: step {step}{}, at {:.4e} m and {:.4e} N",
            reference.unwrap_or_default(),
            event["grip_displacement_m"].as_f64().unwrap_or(f64::NAN),
            event["reaction_n"].as_f64().unwrap_or(f64::NAN)
        );
    };
    let reference = &fracture["reference"];
    // The references count load steps, and the events of the event-driven control are none.
    let no_reference = Value::Null;
    let is_event_driven = fracture["control"] == "event-driven";
    let reference = if is_event_driven {
        &no_reference
    } else {
        reference
    };
    event(
        "first bond broken",
        &fracture["first_break"],
        &reference["first_break"],
    );
    event("peak reaction", &fracture["peak"], &Value::Null);
    if is_event_driven {
        event("largest load", &fracture["envelope_peak"], &Value::Null);
    }
    let ending = summary["outcome"].as_str().unwrap_or("ended");
    event(ending, &fracture["end"], &reference["separated"]);
    let fragments = fracture["fragments"].as_array();
    if let Some(fragments) = fragments.filter(|list| !list.is_empty()) {
        let nodes: u64 = fragments.iter().filter_map(Value::as_u64).sum();
        println!(
            "  come off: {} parts of {nodes} points in all",
            fragments.len()
        );
    }
    if let Some(reason) = fracture["stopped_because"].as_str() {
        println!("  because {reason}");
    }
    println!(
        "  bonds broken: {}; crack length: {:.4e} m",
        fracture["bonds_broken"],
        fracture["crack_length_m"].as_f64().unwrap_or(f64::NAN)
    );
}

/// Components below this share of the largest are what rounding leaves of zero.
const ROUNDING: f64 = 1e-9;

fn print_reactions(reactions: &Value) {
    let groups = || reactions.as_object().into_iter().flatten();
    let number = |reaction: &Value, axis: usize| reaction[axis].as_f64().unwrap_or(0.0);
    let largest = groups()
        .flat_map(|(_, reaction)| [0, 1].map(|axis| number(reaction, axis).abs()))
        .fold(0.0, f64::max);
    for (group, reaction) in groups() {
        let [x, y] = [0, 1].map(|axis| match number(reaction, axis) {
            force if force.abs() > ROUNDING * largest => format!("{force:.6e}"),
            _ => "0".to_owned(),
        });
        println!("  reaction on {group}: ({x}, {y}) N");
    }
}

/// A relative error in percent, signed unless it rounds to zero.
fn percent(error: f64) -> String {
    let text = format!("{:+.2}", 100.0 * error);
    match text.as_str() {
        "+0.00" | "-0.00" => "0.00 %".to_owned(),
        _ => text + " %",
    }
}

fn print_probe(probe: &Value) {
    let text = |key: &str| probe[key].as_str().unwrap_or("");
    let number = |key: &str| probe[key].as_f64();
    let mut line = format!(
        "  {}: u_{} = {:.5e} m",
        text("name"),
        text("component"),
        number("displacement_m").unwrap_or(f64::NAN)
    );
    if let (Some(reference), Some(error)) = (number("reference_m"), number("error")) {
        line.push_str(&format!(
            "  ({} of the reference {reference:.4e} m)",
            percent(error)
        ));
    }
    println!("{line}");
}

/// What the time went into, the most first.
pub(super) fn print_phases(summary: &Value) {
    let mut phases = list_in(summary, "phases");
    let seconds = |phase: &Value| phase["seconds"].as_f64().unwrap_or(0.0);
    phases.sort_by(|a, b| seconds(b).total_cmp(&seconds(a)));
    println!("  {:<24}{:>10}{:>8}{:>10}", "phase", "s", "share", "times");
    for phase in &phases {
        println!(
            "  {:<24}{:>10.4}{:>6.1} %{:>10}",
            phase["phase"].as_str().unwrap_or_default(),
            seconds(phase),
            100.0 * phase["share"].as_f64().unwrap_or(0.0),
            phase["count"].as_u64().unwrap_or(0)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_percent_has_no_sign() {
        let percents = [-2.21e-2, 4e-3, 4e-5, -4e-16, 0.0].map(percent);
        assert_eq!(
            percents,
            ["-2.21 %", "+0.40 %", "0.00 %", "0.00 %", "0.00 %"]
        );
    }
}
