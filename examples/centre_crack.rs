//! The plate with a centre crack, by peridynamics alone and by the hybrid, as the horizon shrinks:
//!
//! ```text
//! cargo run --release --example centre_crack                   # δ/a = 0.4 and 0.2
//! cargo run --release --example centre_crack -- 0.4 0.2 0.1    # 400² points: some minutes, 3 GB
//! cargo run --release --example centre_crack -- m=6 0.4        # δ = 6 dx
//! ```
//!
//! What is measured: `peristitch::verification::centre_crack`. What came out: docs/convergence.md.

use peristitch::verification::centre_crack::{Plate, Points, Ratios, ratios};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let ratio = match given.first().and_then(|a| a.strip_prefix("m=")) {
        Some(ratio) => ratio.parse()?,
        None => 4.0,
    };
    let mut horizons: Vec<f64> = given.iter().filter_map(|a| a.parse().ok()).collect();
    if horizons.is_empty() {
        horizons = vec![0.4, 0.2];
    }
    let plates = [Plate::Peridynamics, Plate::Hybrid];
    let kinds = [Points::Paper, Points::Default];
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
