//! Lines, polygons and discs of a plot, from which pixels or SVG are made.

use super::raster::Raster;
use crate::output::colour::Rgb;

/// Something in the plot; positions in its pixels, y downwards.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Fill {
        corners: Vec<[f64; 2]>,
        colour: Rgb,
    },
    /// A line of a mesh or a grid; see [`Raster::stroke`].
    Stroke {
        path: Vec<[f64; 2]>,
        width: f64,
        colour: Rgb,
    },
    /// A curve; see [`Raster::trace`].
    Trace {
        path: Vec<[f64; 2]>,
        width: f64,
        colour: Rgb,
    },
    Disc {
        centre: [f64; 2],
        radius: f64,
        colour: Rgb,
    },
}

impl Shape {
    /// `thinnest`: least width of a line of a mesh [pixels of the plot], below which it would break up.
    pub fn paint(&self, thinnest: f64, plot: &mut Raster) {
        match self {
            Shape::Fill { corners, colour } => plot.fill(corners, *colour),
            Shape::Stroke {
                path,
                width,
                colour,
            } => plot.stroke(path, width.max(thinnest), *colour),
            Shape::Trace {
                path,
                width,
                colour,
            } => plot.trace(path, *width, *colour),
            Shape::Disc {
                centre,
                radius,
                colour,
            } => plot.fill_disc(*centre, *radius, *colour),
        }
    }
}
