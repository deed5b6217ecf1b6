//! `peristitch check`, which keeps the mesh that it makes; `status` and `explain`, which write nothing.

use super::conditions::conditions;
use super::progress::Warnings;
use crate::fracture::crack_length::Cut;
use crate::model::Model;
use crate::output::number::quantity;
use crate::phases::machine_memory;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::show::results::lattice_name;
use crate::pipeline::stages::parameters::parameter_lines;
use crate::pipeline::stages::run::{self, Checked, Options};
use crate::pipeline::stages::standing::{Standing, standings};
use crate::statics::{Backend, Breaks, Estimate};
use std::time::Duration;

/// How each stage stands, and why.
pub(super) fn list(plan: &Plan, reasons_too: bool) -> Result<(), RunError> {
    for (stage, standing) in standings(plan)? {
        let state = match &standing {
            Standing::Fresh => "fresh".to_owned(),
            Standing::Stale(_) => "stale".to_owned(),
            Standing::After(earlier) => format!("stale if {earlier} delivers something new"),
        };
        println!("{}: {stage:<6} {state}", plan.name);
        if let (true, Standing::Stale(reasons)) = (reasons_too, standing) {
            reasons.iter().for_each(|reason| println!("    {reason}"));
        }
    }
    Ok(())
}

/// Whether the pipeline is sound, its sizes, and what a run will take.
pub(super) fn check(plan: &Plan, backend: Option<Backend>) -> Result<(), RunError> {
    let mut warnings = Warnings::new(&plan.name);
    let Checked {
        model,
        boundary,
        extract,
        set_up,
    } = run::check(plan, &Options::default(), &mut warnings)?;
    let estimate = Estimate::new(&model, &boundary, backend, plan.breaks())?;
    estimate.fits(machine_memory())?;
    println!("{}: sound", plan.name);
    println!(
        "  mesh              {}, {} groups",
        extract.origin,
        extract.groups.len()
    );
    for (index, line) in conditions(plan).iter().enumerate() {
        let title = if index == 0 { "thickness" } else { "" };
        println!("  {title:<18}{line}");
    }
    for (index, line) in parameter_lines(plan, &extract)?.iter().enumerate() {
        let title = if index == 0 { "parameters" } else { "" };
        println!("  {title:<18}{line}");
    }
    println!(
        "  finite elements   {} with {} nodes",
        model.elements.len(),
        model.fe_node_count()
    );
    println!("  material points   {}", model.areas.len());
    let (ties, what) = model.ties();
    println!("  bonds             {}", model.interactions.bonds().len());
    println!("  {what:<18}{ties}");
    if let Some(line) = cells(&model) {
        println!("  cells             {line}");
    }
    for interface in &model.topology.interfaces {
        println!(
            "  interface         `{}` to `{}`: {} edges",
            model.regions[interface.finite_elements].name,
            model.regions[interface.peridynamics].name,
            interface.edges.len()
        );
    }
    println!("  unknowns          {}", estimate.dofs);
    match estimate.backend {
        Backend::Multifrontal | Backend::Faer => println!(
            "  factor            {} entries, {:.2e} flops",
            estimate.factor_entries, estimate.flops
        ),
        Backend::TwoLevel => println!(
            "  solver            two levels, conjugate gradients; {:.1e} entries in the coarse factor",
            estimate.factor_entries as f64
        ),
    }
    println!(
        "  to expect         {}, {}",
        megabytes(estimate.bytes),
        about(set_up + estimate.time)
    );
    if plan.breaks() != Breaks::Never {
        for (index, points) in model.points.iter().enumerate() {
            let title = if index == 0 { "breaking" } else { "" };
            let Cut { bonds, length } = Cut::across(&model, points);
            println!(
                "  {title:<18}{} more for a crack straight across `{}`: {bonds} bonds on {}",
                about(estimate.time_per_bond * bonds as u32),
                lattice_name(&model, points),
                quantity(1e3 * length, "mm")
            );
        }
    }
    println!("  next: peristitch run {}", plan.source.path.display());
    Ok(())
}

/// How many functionals the cells have, and the share of a modulus that they carry.
fn cells(model: &Model) -> Option<String> {
    let count = model.interactions.cells().len();
    let plane = model.settings.plane;
    let of_points = model.points.iter().flat_map(|p| model.members(p.region));
    let materials = of_points.map(|region| model.regions[region].material);
    let largest = materials.max_by(|a, b| a.cell_share(plane).total_cmp(&b.cell_share(plane)))?;
    let modulus = match largest.poisson < plane.bond_based_poisson() {
        true => "shear",
        false => "area",
    };
    (count > 0).then(|| {
        format!(
            "{count} functionals, for ν = {} carrying {:.0} % of the {modulus} modulus",
            largest.poisson,
            100.0 * largest.cell_share(plane)
        )
    })
}

fn megabytes(bytes: u64) -> String {
    format!("{:.0} MB", bytes as f64 / 1e6)
}

fn about(time: Duration) -> String {
    format!("about {:.1} s", time.as_secs_f64().max(0.1))
}
