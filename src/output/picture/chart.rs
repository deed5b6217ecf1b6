//! Curves over two axes, such as the reaction of a grip over its displacement, with marked points.

mod axes;
mod marks;

use super::frame::{
    Bounds, Frame, GAP, Margins, Quantity, TEXT_SIZE, shortened, text_width, title_height,
    title_width,
};
use super::labels::Labels;
use super::legend::{self, Key, Sign, in_rows};
use super::page::Page;
use super::shape::Shape;
use super::{Composition, Picture, PictureError, check_finite};
use crate::output::colour::{self, Rgb, WHITE};
use axes::grid;
use marks::Label;

pub use axes::Axis;
pub use marks::Mark;

/// A polyline; it may turn back and cross itself.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Name in the legend, which is drawn if there are several curves.
    pub name: String,
    /// [SI units of the axes]
    pub points: Vec<[f64; 2]>,
    /// Points that are shown as discs [SI units of the axes].
    pub dots: Vec<[f64; 2]>,
    pub marks: Vec<Mark>,
}

/// Title, axes and curves of a chart.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
}

/// Height of the page without a legend [pixels].
const HEIGHT: i32 = 780;
/// Margins between the curves and the plot's box in shares of the range.
const MARGIN: f64 = 0.03;

/// Width of a curve [pixels].
const CURVE_WIDTH: f64 = 4.0;
/// Points closer together than this are drawn as one [pixels].
const RESOLUTION: f64 = 0.1;
/// Radius of a marked point, and of a curve that is a point [pixels].
const MARK_RADIUS: f64 = 9.0;
/// Radius of a point that is shown without a text [pixels].
const DOT_RADIUS: f64 = 5.0;
/// The white rim that sets a mark apart from its curve [pixels].
const MARK_RIM: f64 = 2.0;

impl Chart {
    /// # Errors
    /// See [`PictureError`].
    pub fn draw(&self) -> Result<Picture, PictureError> {
        Ok(self.compose()?.picture())
    }

    /// # Errors
    /// See [`PictureError`].
    pub fn compose(&self) -> Result<Composition, PictureError> {
        check_finite(self.positions().flatten())?;
        if self.positions().next().is_none() {
            return Err(PictureError::Empty);
        }
        let mut frame = self.frame()?;
        let rows = in_rows(self.keys(frame.plot_width()), frame.page[0] - frame.plot[0]);
        frame.extend_below(rows.len() as i32 * legend::ROW);
        let paths: Vec<Vec<[f64; 2]>> = self.curves.iter().map(|c| path(c, &frame)).collect();
        let labels = self.labels(&frame, &paths);
        let mut shapes = grid(&frame);
        shapes.extend(labels.iter().map(Label::clearing));
        shapes.extend(labels.iter().filter_map(Label::lead));
        shapes.extend(self.drawn_curves(&frame, paths));
        let mut page = Page::with_axes(&frame);
        let title = shortened(&self.title, frame.plot_width(), title_width);
        page.draw_title(&frame, &title);
        for label in &labels {
            label.write(&mut page, &frame);
        }
        legend::draw(&mut page, &frame, &rows);
        Ok(Composition {
            frame,
            content: None,
            shapes,
            page,
        })
    }

    fn drawn_curves(&self, frame: &Frame, paths: Vec<Vec<[f64; 2]>>) -> Vec<Shape> {
        let disc = |centre: [f64; 2], radius: f64, colour: Rgb| Shape::Disc {
            centre,
            radius,
            colour,
        };
        let mut shapes = Vec::new();
        for (path, colour) in paths.into_iter().zip(colours()) {
            if let [point] = path[..] {
                shapes.push(disc(point, MARK_RADIUS, colour));
            }
            shapes.push(Shape::Trace {
                path,
                width: CURVE_WIDTH,
                colour,
            });
        }
        for (curve, colour) in self.curves.iter().zip(colours()) {
            let dots = curve.dots.iter().map(|&dot| frame.to_plot(dot));
            shapes.extend(dots.map(|dot| disc(dot, DOT_RADIUS, colour)));
        }
        for (mark, colour) in self.marks() {
            let at = frame.to_plot(mark.at);
            shapes.push(disc(at, MARK_RADIUS + MARK_RIM, WHITE));
            shapes.push(disc(at, MARK_RADIUS, colour));
        }
        shapes
    }

    fn positions(&self) -> impl Iterator<Item = [f64; 2]> {
        let points = self.curves.iter().flat_map(|curve| &curve.points).copied();
        let dots = self.curves.iter().flat_map(|curve| &curve.dots).copied();
        points
            .chain(dots)
            .chain(self.marks().map(|(mark, _)| mark.at))
    }

    /// The marks with their curves' colours.
    fn marks(&self) -> impl Iterator<Item = (&Mark, Rgb)> {
        let coloured = self.curves.iter().zip(colours());
        coloured.flat_map(|(curve, colour)| curve.marks.iter().map(move |mark| (mark, colour)))
    }

    fn frame(&self) -> Result<Frame, PictureError> {
        let axes = [&self.x, &self.y];
        let values = |k: usize| -> Vec<f64> { self.positions().map(|at| at[k]).collect() };
        let ranges = [0, 1].map(|k| axes[k].range(values(k).into_iter()));
        let margins = ranges.map(|[min, max]| MARGIN * (max - min));
        let bounds = Bounds {
            min: [0, 1].map(|k| ranges[k][0] - margins[k]),
            max: [0, 1].map(|k| ranges[k][1] + margins[k]),
        };
        check_finite((0..2).map(|k| bounds.max[k] - bounds.min[k]))?;
        let quantity = |axis: &Axis, range: [f64; 2]| Quantity {
            name: axis.name.clone(),
            unit: axis.unit_for(range),
        };
        let axes = [quantity(&self.x, ranges[0]), quantity(&self.y, ranges[1])];
        let margins = Margins {
            above: title_height(&self.title),
            below: GAP,
            right: 3 * GAP,
            across: 0,
        };
        Ok(Frame::stretched(bounds, axes, HEIGHT, margins))
    }

    /// The legend, none for a single curve, its texts no wider than `width` [pixels].
    fn keys(&self, width: i32) -> Vec<Key> {
        if self.curves.len() < 2 {
            return Vec::new();
        }
        let key = |(curve, colour): (&Curve, Rgb)| Key {
            sign: Sign::Line(colour, 2.0 * CURVE_WIDTH),
            text: shortened(&curve.name, width - legend::ROW, text_width),
        };
        self.curves.iter().zip(colours()).map(key).collect()
    }

    /// The marks' labels, where they cover the `paths` of the curves the least.
    fn labels(&self, frame: &Frame, paths: &[Vec<[f64; 2]>]) -> Vec<Label> {
        let size = [frame.plot_width(), frame.plot_height()];
        let discs: Vec<[f64; 2]> = self.marks().map(|(m, _)| frame.to_plot(m.at)).collect();
        let mut labels = Labels::among(size, paths, &discs, MARK_RADIUS);
        let label = |(mark, _): (&Mark, Rgb)| {
            let text = shortened(&mark.label, size[0] - 2 * GAP, text_width);
            let at = frame.to_plot(mark.at);
            let place = labels.place(at, [text_width(&text), TEXT_SIZE]);
            Label { text, at, place }
        };
        let written = self.marks().filter(|(mark, _)| !mark.label.is_empty());
        written.map(label).collect()
    }
}

/// One colour per curve, again from the start after the last.
fn colours() -> impl Iterator<Item = Rgb> {
    (0..).map(colour::curve)
}

/// The curve on the plot, without points that are hardly apart from the one before [pixels].
fn path(curve: &Curve, frame: &Frame) -> Vec<[f64; 2]> {
    let mut path: Vec<[f64; 2]> = curve.points.iter().map(|&x| frame.to_plot(x)).collect();
    path.dedup_by(|next, kept| (next[0] - kept[0]).hypot(next[1] - kept[1]) < RESOLUTION);
    path
}

#[cfg(test)]
mod tests;
