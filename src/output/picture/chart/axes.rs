//! The axes of a chart: their ranges, and the grid at their ticks.

use super::super::frame::Frame;
use super::super::shape::Shape;
use super::super::ticks::Unit;
use crate::output::colour::{GRID, Rgb, ZERO};

/// Name and unit of an axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    pub name: String,
    /// SI unit of the values, to which a prefix is added; empty for a share.
    pub unit: String,
    /// Whether `unit` stands as it is, without a prefix: degrees, or the unit of a `.geo`.
    pub keeps_unit: bool,
    /// Whether the axis shows the range of the values, and not zero as well.
    pub is_cropped: bool,
}

/// Values closer together than this are all zero: their scale would not be a number.
const LEAST_RANGE: f64 = 1e-300;

const GRID_WIDTH: f64 = 1.0;

/// Values that differ by a smaller share of the largest are one value, about which nothing can be cropped.
const LEAST_SPREAD: f64 = 1e-6;

/// Rounding at the ends of a cropped axis, in shares of its range: the room beside the values.
const CROPPED_ROOM: f64 = 0.05;

impl Axis {
    /// The range of `values`, with zero unless the axis is cropped; zero to one if there is nothing else.
    pub(super) fn range(&self, values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
        let widen = |[min, max]: [f64; 2], v: f64| [min.min(v), max.max(v)];
        let [least, most] = values
            .clone()
            .fold([f64::INFINITY, f64::NEG_INFINITY], widen);
        let spread = most - least;
        if self.is_cropped && spread > LEAST_SPREAD * most.abs().max(least.abs()) {
            return [least - CROPPED_ROOM * spread, most + CROPPED_ROOM * spread];
        }
        let [min, max] = values.fold([0.0_f64; 2], widen);
        if max - min < LEAST_RANGE {
            return [0.0, 1.0];
        }
        [min, max]
    }

    /// The unit of the numbers along the axis.
    pub(super) fn unit_for(&self, [min, max]: [f64; 2]) -> Unit {
        match self.keeps_unit {
            true => Unit {
                name: self.unit.clone(),
                per_si: 1.0,
            },
            false => Unit::prefixed(&self.unit, max.max(-min)),
        }
    }
}

/// Lines across the plot at the ticks.
pub(super) fn grid(frame: &Frame) -> Vec<Shape> {
    let far = [frame.plot_width(), frame.plot_height()].map(f64::from);
    let line = |axis: usize, position: f64, colour: Rgb| {
        // The middle of the tick's pixels.
        let at = frame.to_plot([position; 2])[axis].round() + 0.5;
        let path = match axis {
            0 => vec![[at, 0.0], [at, far[1]]],
            _ => vec![[0.0, at], [far[0], at]],
        };
        Shape::Stroke {
            path,
            width: GRID_WIDTH,
            colour,
        }
    };
    let mut lines = Vec::new();
    for axis in [0, 1] {
        let per_si = frame.axes[axis].unit.per_si;
        let ticks = frame.ticks(axis);
        lines.extend(ticks.values().map(|value| line(axis, value / per_si, GRID)));
    }
    let is_shown = |axis: &usize| {
        let at = frame.to_plot([0.0; 2])[*axis];
        (0.0..=far[*axis]).contains(&at)
    };
    let zeros = [0, 1].into_iter().filter(is_shown);
    lines.extend(zeros.map(|axis| line(axis, 0.0, ZERO)));
    lines
}
