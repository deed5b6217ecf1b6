//! The study of `examples/centre_crack.rs` at its two coarsest levels, δ/a = 0.4 and 0.2 with δ = 4 dx:
//! stiffness, energy release rate and geometry factor over their references, as docs/convergence.md has
//! them. Two independent figures for peridynamics alone at δ/a = 0.4 are k 0.9986 and G 1.045.

// Its command line is not called here.
#[allow(dead_code)]
#[path = "../examples/centre_crack.rs"]
mod study;

use study::{Plate, Ratios, ratios};

const PAGE: &str = include_str!("../docs/convergence.md");

/// Sums of a fixed lattice: half a unit of the last digit written, and as much for rounding.
const PRINTED: f64 = 1e-4;

fn assert_level(plate: Plate, horizon: f64, expected: [f64; 3]) -> Ratios {
    let found = ratios(plate, horizon, 4.0).expect("a sound plate");
    let values = [found.stiffness, found.rate, found.factor];
    for (value, expected) in values.into_iter().zip(expected) {
        assert!(
            (value - expected).abs() < PRINTED,
            "{plate:?}, δ/a = {horizon}: {values:?}"
        );
    }
    let row = values.map(|value| format!("{value:.4}")).join(" | ");
    assert!(PAGE.contains(&row), "docs/convergence.md: {row}");
    found
}

/// What shrinks with δ does so about linearly: the straight line through both levels ends near 1.
fn assert_trend(coarse: Ratios, fine: Ratios) {
    assert!(fine.rate - 1.0 < coarse.rate - 1.0 && fine.rate > 1.0);
    let limit = 2.0 * fine.factor - coarse.factor;
    assert!((limit - 1.0).abs() < 0.01, "{limit}");
    let order = ((coarse.factor - 1.0) / (fine.factor - 1.0)).log2();
    assert!((0.7..1.2).contains(&order), "{order}");
}

#[test]
fn peridynamics_alone() {
    let coarse = assert_level(Plate::Peridynamics, 0.4, [0.9968, 1.0667, 1.0362]);
    // The independent figures; the rate is that of a difference over other crack lengths.
    assert!((coarse.stiffness / 0.9986 - 1.0).abs() < 0.003);
    assert!((coarse.rate / 1.045 - 1.0).abs() < 0.025);
    let fine = assert_level(Plate::Peridynamics, 0.2, [1.0065, 1.0547, 1.0204]);
    assert_trend(coarse, fine);
}

#[test]
fn hybrid() {
    let coarse = assert_level(Plate::Hybrid, 0.4, [0.9864, 1.0333, 1.0305]);
    let fine = assert_level(Plate::Hybrid, 0.2, [0.9959, 1.0256, 1.0169]);
    assert_trend(coarse, fine);
}
