//! The axes of a lattice, which may be turned against x and y.

use crate::geometry::Outline;

/// The lattice's axes, about the origin of x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// Cosine and sine of the angle; `None`: parallel to x and y, where nothing is rounded.
    turn: Option<[f64; 2]>,
}

impl Axes {
    /// Turned counter-clockwise by `angle` [rad].
    pub fn new(angle: f64) -> Axes {
        Axes {
            turn: (angle != 0.0).then(|| [angle.cos(), angle.sin()]),
        }
    }

    /// Coordinates along the lattice's axes.
    pub fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.turn {
            None => [x, y],
            Some([c, s]) => [c * x + s * y, c * y - s * x],
        }
    }

    /// Coordinates along x and y.
    pub fn global(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.turn {
            None => [x, y],
            Some([c, s]) => [c * x - s * y, c * y + s * x],
        }
    }

    /// An outline in the lattice's axes.
    pub fn outline(&self, outline: &Outline) -> Outline {
        let turned = |polygon: &Vec<[f64; 2]>| polygon.iter().map(|&x| self.local(x)).collect();
        Outline {
            loops: outline.loops.iter().map(turned).collect(),
        }
    }
}

/// Directions within this angle are one [rad]: mesh coordinates carry noise of a relative 1e-10.
const SAME: f64 = 1e-6;

/// The share of an outline that must run in one direction, or at right angles to it, for a lattice to follow
/// it. Chords of curves are many directions, of which none has as much.
const LEADING: f64 = 0.25;

/// The angle of a lattice along most of an outline, between −45° and 45° [rad]: that of the direction in
/// which, at right angles to it included, the greatest length of the outline runs; of equal ones the least
/// turned. Zero if none has a quarter of the length, or if two equal ones are turned to either side.
pub fn dominant_angle(outline: &Outline) -> f64 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let mut sides: Vec<(f64, f64)> = outline
        .segments()
        .filter(|[a, b]| a != b)
        .map(|[a, b]| {
            let [x, y] = [b[0] - a[0], b[1] - a[1]];
            let angle = y.atan2(x);
            let angle = angle - (angle / FRAC_PI_2).round() * FRAC_PI_2;
            // The two ends of the range are one direction.
            let angle = if angle < SAME - FRAC_PI_4 {
                angle + FRAC_PI_2
            } else {
                angle
            };
            (angle, x.hypot(y))
        })
        .collect();
    sides.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = sides.iter().map(|(_, length)| length).sum();
    // Mean angle and length of each direction.
    let mut directions: Vec<(f64, f64)> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (angle, length) in sides {
        match directions.last_mut() {
            Some((mean, sum)) if angle - last < SAME => {
                *mean += (angle - *mean) * length / (*sum + length);
                *sum += length;
            }
            _ => directions.push((angle, length)),
        }
        last = angle;
    }
    let longest = directions.iter().map(|d| d.1).fold(0.0, f64::max);
    let leading = directions.iter().filter(|(_, length)| {
        *length > (1.0 - SAME) * longest && *length > (1.0 - SAME) * LEADING * total
    });
    let leading: Vec<f64> = leading.map(|d| d.0).collect();
    let least = leading
        .iter()
        .map(|a| a.abs())
        .fold(f64::INFINITY, f64::min);
    let mut found = leading.into_iter().filter(|a| a.abs() < least + SAME);
    match (found.next(), found.next()) {
        (Some(angle), None) if angle.abs() >= SAME => angle,
        // None, or two that are turned to either side.
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn polygon(corners: &[[f64; 2]], turn: f64) -> Outline {
        let axes = Axes::new(turn);
        Outline {
            loops: vec![corners.iter().map(|&x| axes.global(x)).collect()],
        }
    }

    #[test]
    fn a_lattice_follows_the_longest_sides() {
        let notched = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 2.0],
            [2.2, 2.0],
            [2.0, 1.0],
            [1.8, 2.0],
            [0.0, 2.0],
        ];
        for degrees in [0.0, 1.0, 30.0, 44.0, -20.0, 45.0] {
            let turn = f64::to_radians(degrees);
            let found = dominant_angle(&polygon(&notched, turn));
            assert!((found - turn).abs() < 1e-12, "{degrees} {found}");
        }
        // 70° is 20° the other way round; nothing turned is exactly zero.
        let found = dominant_angle(&polygon(&notched, 70_f64.to_radians()));
        assert!((found + 20_f64.to_radians()).abs() < 1e-12);
        assert_eq!(dominant_angle(&polygon(&notched, 1e-9)), 0.0);
    }

    #[test]
    fn a_circle_and_a_hexagon_have_no_direction_of_their_own() {
        for sides in [6, 12, 17, 64, 96] {
            let corner = |k: usize| {
                let (s, c) = (2.0 * PI * k as f64 / sides as f64).sin_cos();
                [c, s]
            };
            let corners: Vec<[f64; 2]> = (0..sides).map(corner).collect();
            // A hexagon's sides at 0° and ±30° are equally long.
            assert_eq!(dominant_angle(&polygon(&corners, 0.5 * PI)), 0.0, "{sides}");
        }
    }
}
