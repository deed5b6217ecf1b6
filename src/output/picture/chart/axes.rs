//! The axes of a chart: their ranges, and the grid at their ticks.

use super::super::frame::Frame;
use super::super::shape::Shape;
use crate::output::colour::{GRID, Rgb, ZERO};

/// Name and unit of an axis.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    pub name: String,
    /// SI unit of the values, to which a prefix is added; empty for a share.
    pub unit: String,
}

/// Values closer together than this are all zero: their scale would not be a number.
const LEAST_RANGE: f64 = 1e-300;

const GRID_WIDTH: f64 = 1.0;

/// The least and the largest of `values` and zero; zero to one if there is nothing else.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [min, max] = values.fold([0.0_f64; 2], |[min, max], v| [min.min(v), max.max(v)]);
    if max - min < LEAST_RANGE {
        return [0.0, 1.0];
    }
    [min, max]
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
    lines.extend([0, 1].map(|axis| line(axis, 0.0, ZERO)));
    lines
}
