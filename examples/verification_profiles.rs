//! Draws the profiles along the ligament of the plate with a hole and of the Brazilian disc, for
//! docs/verification.md: `cargo run --release --example verification_profiles -- docs/images`.

use peristitch::output::picture::chart::{Axis, Chart, Curve};
use peristitch::verification::disc::{self, Disc};
use peristitch::verification::kirsch::{self, Profile};
use std::error::Error;
use std::path::PathBuf;

fn axis(name: &str) -> Axis {
    Axis {
        name: name.to_owned(),
        unit: String::new(),
        ..Axis::default()
    }
}

fn curve(name: &str, points: Vec<[f64; 2]>) -> Curve {
    Curve {
        name: name.to_owned(),
        points,
        ..Curve::default()
    }
}

/// `count` + 1 points of a function between two places.
fn exact([from, to]: [f64; 2], count: u32, f: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let at = |k| from + (to - from) * f64::from(k) / f64::from(count);
    (0..=count).map(|k| [at(k), f(at(k))]).collect()
}

/// Distances from the hole's edge for those from its centre.
fn from_the_hole(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points
        .into_iter()
        .map(|[r, stress]| [r - 1.0, stress])
        .collect()
}

fn plate_with_a_hole() -> Result<Chart, Box<dyn Error>> {
    let found = |per_radius: usize| -> Result<Curve, Box<dyn Error>> {
        let profile = Profile::new(per_radius)?;
        let name = format!("δ = a/{:.0}", 1.0 / profile.horizon);
        Ok(curve(&name, from_the_hole(profile.points)))
    };
    let from_the_edge = "(r − a)/a";
    let kirsch = exact([1.0, 3.0], 200, kirsch::ligament);
    Ok(Chart {
        title: "Plate with a hole: σθ on the ligament".to_owned(),
        x: axis(from_the_edge),
        y: axis("σθ/σ"),
        curves: vec![
            curve("Kirsch", from_the_hole(kirsch)),
            found(10)?,
            found(20)?,
            found(40)?,
        ],
    })
}

fn brazilian_disc() -> Result<Chart, Box<dyn Error>> {
    let mut curves = Vec::new();
    for (axis, stress) in ["σx", "σy"].into_iter().enumerate() {
        let exact = exact([-0.5, 0.5], 200, |x| disc::exact(x)[axis]);
        curves.push(curve(&format!("{stress}, exact"), exact));
        for (disc, name) in [(Disc::Peridynamics, "PD"), (Disc::Hybrid, "hybrid")] {
            let row = disc::profile(disc, disc::PER_DIAMETER)?;
            let points = row.iter().map(|point| [point[0], point[1 + axis]]);
            curves.push(curve(&format!("{stress}, {name}"), points.collect()));
        }
    }
    Ok(Chart {
        title: "Brazilian disc: stress on the horizontal diameter".to_owned(),
        x: axis("x/D"),
        y: axis("σ πDh/2P"),
        curves,
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args()
        .nth(1)
        .map(PathBuf::from)
        .unwrap_or_default();
    for (name, chart) in [
        ("plate_with_a_hole.png", plate_with_a_hole()?),
        ("brazilian_disc.png", brazilian_disc()?),
    ] {
        chart.draw()?.write(&folder.join(name))?;
    }
    Ok(())
}
