//! The plate with a centre crack, by peridynamics alone and by the hybrid, as the horizon shrinks:
//!
//! ```text
//! cargo run --release --example centre_crack                   # δ/a = 0.4 and 0.2
//! cargo run --release --example centre_crack -- 0.4 0.2 0.1    # 400² points: some minutes, 3 GB
//! cargo run --release --example centre_crack -- m=6 0.4        # δ = 6 dx
//! cargo run --release --example centre_crack -- paper 0.4      # with the paper's points only
//! ```
//!
//! What is measured: `peristitch::verification::centre_crack`. What came out: docs/convergence.md.

use peristitch::verification::centre_crack::{Plate, Points, Ratios, ratios};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let ratio = given.iter().find_map(|a| a.strip_prefix("m="));
    let ratio = ratio.map_or(Ok(4.0), str::parse)?;
    let mut horizons: Vec<f64> = given.iter().filter_map(|a| a.parse().ok()).collect();
    if horizons.is_empty() {
        horizons = vec![0.4, 0.2];
    }
    let plates = [Plate::Peridynamics, Plate::Hybrid];
    let asked = |name: &str| given.iter().any(|a| a == name);
    let kinds = match [asked("paper"), asked("corrected")] {
        [true, false] => vec![Points::Paper],
        [false, true] => vec![Points::Corrected],
        _ => vec![Points::Paper, Points::Corrected],
    };
    for (points, plate) in kinds.iter().flat_map(|&k| plates.map(|plate| (k, plate))) {
        println!("| {plate:?}, {points:?}, δ = {ratio} dx, δ/a | k | G | Y |");
        println!("| --- | --- | --- | --- |");
        for &horizon in &horizons {
            let Ratios {
                stiffness,
                rate,
                factor,
            } = ratios(plate, points, horizon, ratio)?;
            println!("| {horizon} | {stiffness:.4} | {rate:.4} | {factor:.4} |");
        }
        println!();
    }
    Ok(())
}
