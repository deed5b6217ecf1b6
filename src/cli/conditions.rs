//! Values that are easily given in the wrong unit, printed by `check` in usual units.

use crate::boundary::Directions;
use crate::model::Method;
use crate::pipeline::read::plan::{Displaced, Plan};

/// The thickness, the lattices, and the prescribed displacements with their angles.
pub(super) fn conditions(plan: &Plan) -> Vec<String> {
    let mut lines = vec![length(plan.model.thickness)];
    for region in &plan.regions {
        let Method::Peridynamics(settings) = region.method else {
            continue;
        };
        let spacing = settings.lattice.spacing;
        let turned = match region.angle_by_default {
            true => String::new(),
            false => format!(", turned by {}", degrees(settings.lattice.angle)),
        };
        lines.push(format!(
            "`{}`: spacing {}, horizon {}{turned}",
            region.name(),
            length(spacing),
            length(settings.horizon_ratio * spacing)
        ));
    }
    for condition in &plan.conditions {
        let Some(Displaced {
            directions,
            components,
        }) = condition.displacement
        else {
            continue;
        };
        let (names, turned) = match directions {
            Directions::Turned(0.0) => (["x", "y"], String::new()),
            Directions::Turned(angle) => (["x", "y"], format!(", turned by {}", degrees(angle))),
            Directions::Curve => (["normal", "tangential"], String::new()),
        };
        let given = names.iter().zip(components);
        let given = given.filter_map(|(name, u)| Some(format!("{name} {}", length(u?))));
        let given: Vec<String> = given.collect();
        lines.push(format!(
            "`{}` moves by {}{turned}",
            condition.group,
            given.join(", ")
        ));
    }
    lines
}

/// A length in the largest of m, mm, µm and nm in which it is at least 1.
fn length(metres: f64) -> String {
    let units = [(1.0, "m"), (1e-3, "mm"), (1e-6, "µm")];
    let fits = units
        .iter()
        .find(|(unit, _)| metres.abs() >= unit * (1.0 - 1e-12));
    match fits {
        _ if metres == 0.0 => "0".to_owned(),
        Some((unit, name)) => format!("{} {name}", four_digits(metres / unit)),
        None => format!("{} nm", four_digits(metres / 1e-9)),
    }
}

fn degrees(angle: f64) -> String {
    format!("{} deg", four_digits(angle.to_degrees()))
}

/// A number of four digits without zeros at its end.
fn four_digits(value: f64) -> f64 {
    let digits = 3.0 - value.abs().log10().floor();
    let scale = 10_f64.powf(digits);
    if value == 0.0 {
        0.0
    } else {
        (value * scale).round() / scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_in_the_unit_that_a_person_thinks_in() {
        let lengths = [1.0, 0.02, 2.54e-5, -2e-8, 0.0, 0.001, 123.456e-3].map(length);
        let expected = ["1 m", "20 mm", "25.4 µm", "-20 nm", "0", "1 mm", "123.5 mm"];
        assert_eq!(lengths, expected);
        assert_eq!(degrees(45_f64.to_radians()), "45 deg");
        assert_eq!(degrees(45.0), "2578 deg");
    }
}
