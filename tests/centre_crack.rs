//! The study of `examples/centre_crack.rs` at its two coarsest levels, δ/a = 0.4 and 0.2 with δ = 4 dx:
//! stiffness, energy release rate and geometry factor over their references, as docs/convergence.md has
//! them. Two independent figures for peridynamics alone at δ/a = 0.4 are k 0.9986 and G 1.045.

use peristitch::verification::centre_crack::{Plate, Points, Ratios, ratios};

const PAGE: &str = include_str!("../docs/convergence.md");

/// Sums of a fixed lattice: half a unit of the last digit written, and as much for rounding.
const PRINTED: f64 = 1e-4;

fn assert_level(plate: Plate, points: Points, horizon: f64, expected: [f64; 3]) -> Ratios {
    let found = ratios(plate, points, horizon, 4.0).expect("a sound plate");
    let values = [found.stiffness, found.rate, found.factor];
    for (value, expected) in values.into_iter().zip(expected) {
        assert!(
            (value - expected).abs() < PRINTED,
            "{plate:?}, {points:?}, δ/a = {horizon}: {values:?}"
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
    let coarse = assert_level(
        Plate::Peridynamics,
        Points::Paper,
        0.4,
        [0.9968, 1.0667, 1.0362],
    );
    // The independent figures; the rate is that of a difference over other crack lengths.
    assert!((coarse.stiffness / 0.9986 - 1.0).abs() < 0.003);
    assert!((coarse.rate / 1.045 - 1.0).abs() < 0.025);
    let fine = assert_level(
        Plate::Peridynamics,
        Points::Paper,
        0.2,
        [1.0065, 1.0547, 1.0204],
    );
    assert_trend(coarse, fine);
}

#[test]
fn hybrid() {
    let coarse = assert_level(Plate::Hybrid, Points::Paper, 0.4, [0.9864, 1.0333, 1.0305]);
    let fine = assert_level(Plate::Hybrid, Points::Paper, 0.2, [0.9959, 1.0256, 1.0169]);
    assert_trend(coarse, fine);
}

/// Isotropised, with corrected surfaces: nothing is left that does not vanish with δ, G included.
#[test]
fn defaults_converge() {
    let coarse_and_fine = [
        (
            Plate::Peridynamics,
            [[1.0076, 1.0703, 1.0268], [1.0034, 1.0381, 1.0154]],
        ),
        (
            Plate::Hybrid,
            [[0.9943, 1.0447, 1.0280], [0.9968, 1.0257, 1.0161]],
        ),
    ];
    for (plate, [coarse, fine]) in coarse_and_fine {
        let coarse = assert_level(plate, Points::Corrected, 0.4, coarse);
        let fine = assert_level(plate, Points::Corrected, 0.2, fine);
        assert_trend(coarse, fine);
        let order = ((coarse.rate - 1.0) / (fine.rate - 1.0)).log2();
        assert!((0.75..1.2).contains(&order), "{plate:?}: {order}");
        // The straight lines end nearer to the references than either level.
        assert!(
            (2.0 * fine.rate - coarse.rate - 1.0).abs() < 0.01,
            "{plate:?}"
        );
        assert!(
            (2.0 * fine.stiffness - coarse.stiffness - 1.0).abs() < 0.002,
            "{plate:?}"
        );
    }
}
