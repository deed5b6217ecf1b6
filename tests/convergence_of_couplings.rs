//! The study of `examples/manufactured.rs` at its two coarsest levels, as docs/convergence.md has it: the
//! order of the three couplings on a field that crosses the interface, and what m does.

// Its command line is not called here.
#[allow(dead_code)]
#[path = "../examples/manufactured.rs"]
mod study;

use study::{COUPLINGS, error, exact, slope};

const PAGE: &str = include_str!("../docs/convergence.md");

/// Of the three couplings: errors with dx = 1/32 and 1/64 at δ = 4 dx, and the range of the order. A truss at the
/// interface carries a wrong stress in a strip as wide as δ: order one in the end, 1.15 from 1/128 to 1/256.
const LEVELS: [([&str; 2], [f64; 2]); 3] = [
    (["1.497e-2", "6.148e-3"], [1.1, 1.4]),
    (["8.451e-5", "2.035e-5"], [1.95, 2.15]),
    (["1.672e-5", "3.952e-6"], [1.95, 2.15]),
];

/// The same with δ = 1/16 throughout, dx = 1/32 and 1/64.
const REFINED: [[&str; 2]; 3] = [
    ["8.443e-3", "6.148e-3"],
    ["8.406e-5", "2.035e-5"],
    ["2.173e-5", "3.952e-6"],
];

/// 3u,xx + u,yy + 2v,xy = 0 and 3v,yy + v,xx + 2u,xy = 0, by differences.
#[test]
fn the_field_needs_no_body_force() {
    let h = 1e-3;
    for [x, y] in [[0.1, 0.2], [0.5, 0.9], [0.8, 0.4]] {
        let at = |i: f64, j: f64| exact([x + i * h, y + j * h]);
        let second = |k: usize, [i, j]: [f64; 2]| {
            (at(i, j)[k] - 2.0 * at(0.0, 0.0)[k] + at(-i, -j)[k]) / (h * h)
        };
        let mixed = |k: usize| {
            0.5 * (second(k, [1.0, 1.0]) - second(k, [1.0, 0.0]) - second(k, [0.0, 1.0]))
        };
        let (xx, yy) = ([1.0, 0.0], [0.0, 1.0]);
        let along_x = 3.0 * second(0, xx) + second(0, yy) + 2.0 * mixed(1);
        let along_y = 3.0 * second(1, yy) + second(1, xx) + 2.0 * mixed(0);
        // h² times the fourth derivatives, and rounding over h².
        assert!(
            along_x.abs() < 1e-5 && along_y.abs() < 1e-5,
            "{along_x} {along_y}"
        );
        assert!(second(0, xx).abs() > 0.1, "terms of the order of one");
    }
}

#[test]
fn two_levels_and_the_order() {
    for ((name, coupling), (expected, [low, high])) in COUPLINGS.into_iter().zip(LEVELS) {
        let errors = [32, 64].map(|count| error(coupling, count, 4.0).expect("a solution"));
        let printed = errors.map(|error| format!("{error:.3e}"));
        assert_eq!(printed, expected, "{name}");
        assert!(
            PAGE.contains(&printed.join(" | ")),
            "docs/convergence.md, {name}: {printed:?}"
        );
        let order = -slope(&[[32.0, errors[0]], [64.0, errors[1]]]);
        assert!((low..high).contains(&order), "{name}: {order}");
    }
}

#[test]
fn more_points_in_the_same_horizon() {
    for ((name, coupling), expected) in COUPLINGS.into_iter().zip(REFINED) {
        let errors = [(32, 2.0), (64, 4.0)].map(|(count, ratio)| {
            let error = error(coupling, count, ratio).expect("a solution");
            format!("{error:.3e}")
        });
        assert_eq!(errors, expected, "{name}");
        assert!(
            PAGE.contains(&errors.join(" | ")),
            "docs/convergence.md, {name}"
        );
    }
}

#[test]
fn a_slope() {
    let line = [1.0f64, 2.0, 5.0].map(|x| [x, 3.0 * x.powf(-1.5)]);
    assert!((slope(&line) + 1.5).abs() < 1e-14);
}
