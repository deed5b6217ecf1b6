//! Curves over two axes, such as the reaction of a grip over its displacement, with marked points.

use super::frame::{
    Bounds, Frame, GAP, Quantity, Room, TEXT_SIZE, TITLE_SIZE, shortened, text_width, title_width,
};
use super::labels::{Labels, Place, leader};
use super::legend::{self, Key, Sign, in_rows};
use super::page::{Anchor, Page};
use super::shape::Shape;
use super::ticks::Unit;
use super::{Composition, Picture, PictureError, check_finite};
use crate::output::colour::{self, GRID, Rgb, WHITE, ZERO};

/// What an axis shows.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    pub name: String,
    /// SI unit of the values, to which a prefix is added; empty for a share.
    pub unit: String,
}

/// A point to be pointed at.
#[derive(Clone, Debug)]
pub struct Mark {
    /// [SI units of the axes]
    pub at: [f64; 2],
    pub label: String,
}

/// A polyline; it may turn back and cross itself.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Shown if there are several.
    pub name: String,
    /// [SI units of the axes]
    pub points: Vec<[f64; 2]>,
    /// Of its points those that are shown as such [SI units of the axes].
    pub dots: Vec<[f64; 2]>,
    pub marks: Vec<Mark>,
}

/// All that the picture shows. Both axes include zero.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
}

/// Height of the page without a legend [pixels].
const HEIGHT: i32 = 780;
/// Room between the curves and the plot's box in shares of the range.
const MARGIN: f64 = 0.03;
/// Values closer together than this are all zero: their scale would not be a number.
const LEAST_RANGE: f64 = 1e-300;

/// Widths of lines [pixels].
const CURVE_WIDTH: f64 = 4.0;
const GRID_WIDTH: f64 = 1.0;
const LEADER_WIDTH: f64 = 2.0;
/// Points closer together than this are drawn as one [pixels].
const RESOLUTION: f64 = 0.1;
/// Radius of a marked point, and of a curve that is a point [pixels].
const MARK_RADIUS: f64 = 9.0;
/// Radius of a point that is shown without a text [pixels].
const DOT_RADIUS: f64 = 5.0;
/// The white rim that sets a mark apart from its curve [pixels].
const MARK_RIM: f64 = 2.0;

impl Chart {
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
        let ranges = [0, 1].map(|k| range(self.positions().map(move |position| position[k])));
        let margins = ranges.map(|[min, max]| MARGIN * (max - min));
        let bounds = Bounds {
            min: [0, 1].map(|k| ranges[k][0] - margins[k]),
            max: [0, 1].map(|k| ranges[k][1] + margins[k]),
        };
        check_finite((0..2).map(|k| bounds.max[k] - bounds.min[k]))?;
        let quantity = |axis: &Axis, [min, max]: [f64; 2]| Quantity {
            name: axis.name.clone(),
            unit: Unit::prefixed(&axis.unit, max.max(-min)),
        };
        let axes = [quantity(&self.x, ranges[0]), quantity(&self.y, ranges[1])];
        let room = Room {
            above: GAP + TITLE_SIZE + GAP,
            below: GAP,
            right: 3 * GAP,
            across: 0,
        };
        Ok(Frame::stretched(bounds, axes, HEIGHT, room))
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

/// The text beside a mark.
struct Label {
    text: String,
    /// The mark [pixels of the plot].
    at: [f64; 2],
    place: Place,
}

impl Label {
    /// What takes the grid away, which would strike the text through.
    fn clearing(&self) -> Shape {
        let [l, t, r, b] = self.place.map(f64::from);
        Shape::Fill {
            corners: vec![[l, t], [r, t], [r, b], [l, b]],
            colour: WHITE,
        }
    }

    /// The line from the mark to a text that stands apart from it.
    fn lead(&self) -> Option<Shape> {
        Some(Shape::Trace {
            path: leader(self.place, self.at)?.to_vec(),
            width: LEADER_WIDTH,
            colour: ZERO,
        })
    }

    fn write(&self, page: &mut Page, frame: &Frame) {
        let [left, top, _, bottom] = self.place;
        let at = [frame.plot[0] + left, frame.plot[1] + (top + bottom) / 2];
        page.draw_text(&self.text, at, Anchor::Left);
    }
}

/// One colour per curve, again from the start after the last.
fn colours() -> impl Iterator<Item = Rgb> {
    (0..).map(colour::curve)
}

/// The least and the largest of `values` and zero; zero to one if there is nothing else.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [min, max] = values.fold([0.0_f64; 2], |[min, max], v| [min.min(v), max.max(v)]);
    if max - min < LEAST_RANGE {
        return [0.0, 1.0];
    }
    [min, max]
}

/// The curve on the plot, without points that are hardly apart from the one before [pixels].
fn path(curve: &Curve, frame: &Frame) -> Vec<[f64; 2]> {
    let mut path: Vec<[f64; 2]> = curve.points.iter().map(|&x| frame.to_plot(x)).collect();
    path.dedup_by(|next, kept| (next[0] - kept[0]).hypot(next[1] - kept[1]) < RESOLUTION);
    path
}

/// Lines across the plot at the ticks.
fn grid(frame: &Frame) -> Vec<Shape> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::colour::{INK, curve as colour_of};

    fn axis(name: &str, unit: &str) -> Axis {
        Axis {
            name: name.to_owned(),
            unit: unit.to_owned(),
        }
    }

    fn mark(at: [f64; 2], label: &str) -> Mark {
        Mark {
            at,
            label: label.to_owned(),
        }
    }

    fn chart(curves: Vec<Curve>) -> Chart {
        Chart {
            title: "three-point bending".to_owned(),
            x: axis("grip displacement", "m"),
            y: axis("reaction", "N"),
            curves,
        }
    }

    fn curve(name: &str, points: Vec<[f64; 2]>, marks: Vec<Mark>) -> Curve {
        Curve {
            name: name.to_owned(),
            points,
            dots: Vec::new(),
            marks,
        }
    }

    /// Up to 800 N at 0.2 mm, straight down to 100 N, on to 0.4 mm.
    fn rise_and_drop() -> Chart {
        let points = vec![[0.0, 0.0], [2e-4, 800.0], [2e-4, 100.0], [4e-4, 0.0]];
        let marks = vec![
            mark([2e-4, 800.0], "first bond, step 45"),
            mark([4e-4, 0.0], "separated, step 92"),
        ];
        chart(vec![curve("run", points, marks)])
    }

    /// Whether a pixel within the neighbours of a point has the colour.
    fn shows(picture: &Picture, at: [f64; 2], colour: Rgb) -> bool {
        let [x, y] = picture.frame.to_page(at).map(|p| p as i32);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
        around
            .into_iter()
            .any(|[x, y]| picture.pixel(x as u32, y as u32) == colour)
    }

    fn count(picture: &Picture, [l, t, r, b]: [i32; 4], colour: Rgb) -> usize {
        let pixels = (t..b).flat_map(|y| (l..r).map(move |x| [x as u32, y as u32]));
        pixels
            .filter(|&[x, y]| picture.pixel(x, y) == colour)
            .count()
    }

    #[test]
    fn a_curve_passes_through_its_points_and_nowhere_else() {
        let mut chart = rise_and_drop();
        chart.curves[0].marks.clear();
        let picture = chart.draw().expect("a chart");
        for on in [
            [0.0, 0.0],
            [5e-5, 200.0],
            [1e-4, 400.0],
            [2e-4, 450.0],
            [3e-4, 50.0],
        ] {
            assert!(shows(&picture, on, colour_of(0)), "{on:?}");
        }
        for off in [
            [5e-5, 250.0],
            [2.1e-4, 450.0],
            [3e-4, 80.0],
            [3.9e-4, 790.0],
        ] {
            assert!(!shows(&picture, off, colour_of(0)), "{off:?}");
        }
    }

    #[test]
    fn the_page_is_filled_in_both_directions() {
        let picture = rise_and_drop().draw().expect("a chart");
        assert_eq!(picture.size(), [1200, 780]);
        let frame = &picture.frame;
        let [left, bottom] = frame.to_plot([0.0, 0.0]);
        let [right, top] = frame.to_plot([4e-4, 800.0]);
        assert!((right - left) / f64::from(frame.plot_width()) > 0.9);
        assert!((bottom - top) / f64::from(frame.plot_height()) > 0.9);
    }

    #[test]
    fn a_curve_that_turns_back_is_drawn_as_it_runs() {
        let points = vec![[0.0, 0.0], [3e-3, 900.0], [1e-3, 100.0], [3e-3, 50.0]];
        let picture = chart(vec![curve("snap-back", points, vec![])]).draw();
        let picture = picture.expect("a chart");
        for on in [[1.5e-3, 450.0], [2e-3, 500.0], [2e-3, 75.0]] {
            assert!(shows(&picture, on, colour_of(0)), "{on:?}");
        }
    }

    #[test]
    fn the_line_is_four_pixels_wide() {
        let points = vec![[0.0, 500.0], [1.0, 500.0]];
        let picture = chart(vec![curve("constant", points, vec![])]).draw();
        let picture = picture.expect("a chart");
        let [x, y] = picture.frame.to_page([0.47, 500.0]).map(|p| p as i32);
        let covered: f64 = (y - 5..y + 5)
            .map(|row| picture.pixel(x as u32, row as u32)[0])
            .map(|red| (255.0 - f64::from(red)) / 255.0)
            .sum();
        // A grid line lies below the curve and shows where the curve's edge is soft.
        assert!((covered - 4.0).abs() < 0.5, "{covered}");
    }

    #[test]
    fn zero_is_on_both_axes() {
        for sign in [1.0, -1.0] {
            let points = vec![[sign * 2.0, sign * 7e3], [sign * 3.0, sign * 8e3]];
            let picture = chart(vec![curve("far", points, vec![])]).draw();
            let picture = picture.expect("a chart");
            let [x, y] = picture.frame.to_plot([0.0, 0.0]);
            assert!((0.0..f64::from(picture.frame.plot_width())).contains(&x));
            assert!((0.0..f64::from(picture.frame.plot_height())).contains(&y));
            for zero in [[0.0, sign * 5e3], [sign * 0.7, 0.0]] {
                assert!(shows(&picture, zero, ZERO), "{zero:?}");
            }
        }
    }

    #[test]
    fn a_grid_line_leads_to_the_middle_of_each_tick() {
        let picture = rise_and_drop().draw().expect("a chart");
        let frame = &picture.frame;
        let [left, top, right, bottom] = frame.plot;
        let found = |near: [i32; 2], axis: usize, colour: Rgb| -> Vec<i32> {
            let along = (-6..=6).map(|step| near[axis] + step);
            let is_there = |&along: &i32| {
                let mut pixel = near;
                pixel[axis] = along;
                picture.pixel(pixel[0] as u32, pixel[1] as u32) == colour
            };
            along.filter(is_there).collect()
        };
        for value in [1e-4, 3e-4] {
            let x = frame.to_page([value, 0.0])[0] as i32;
            let tick = found([x, bottom + 4], 0, INK);
            assert_eq!(found([x, top + 3], 0, GRID), tick[1..2]);
        }
        for value in [200.0, 600.0] {
            let y = frame.to_page([0.0, value])[1] as i32;
            let tick = found([left - 4, y], 1, INK);
            assert_eq!(found([right - 3, y], 1, GRID), tick[1..2]);
        }
    }

    #[test]
    fn each_axis_has_the_prefix_of_its_values() {
        let labels = |x: f64, y: f64| {
            let chart = chart(vec![curve("run", vec![[0.0, 0.0], [x, y]], vec![])]);
            let frame = chart.frame().expect("a finite range");
            frame.axes.map(|axis| axis.unit.label(&axis.name))
        };
        assert_eq!(
            labels(4e-4, 800.0),
            ["grip displacement [µm]", "reaction [N]"]
        );
        assert_eq!(
            labels(-2e-3, 1.2e4),
            ["grip displacement [mm]", "reaction [kN]"]
        );
        assert_eq!(
            labels(0.0, -3e7),
            ["grip displacement [m]", "reaction [MN]"]
        );
    }

    #[test]
    fn a_mark_is_a_disc_with_its_text_beside() {
        let picture = rise_and_drop().draw().expect("a chart");
        let [left, top, ..] = picture.frame.plot;
        let chart = rise_and_drop();
        let paths = vec![path(&chart.curves[0], &picture.frame)];
        let labels = chart.labels(&picture.frame, &paths);
        assert_eq!(labels.len(), 2);
        for label in labels {
            let [x, y] = label.at.map(|p| p as i32);
            let disc = [x - 4, y - 4, x + 5, y + 5].map(|p| p + left);
            let disc = [disc[0], disc[1] - left + top, disc[2], disc[3] - left + top];
            assert_eq!(count(&picture, disc, colour_of(0)), 81);
            let [l, t, r, b] = label.place;
            let text = [l + left, t + top, r + left, b + top];
            assert!(count(&picture, text, INK) > 100, "{}", label.text);
            // A corner of the text's box may touch a line: half of a curve's width, squared.
            let corner = (0.5 * CURVE_WIDTH).powi(2) as usize;
            for other in [colour_of(0), GRID, ZERO] {
                let covered = count(&picture, text, other);
                assert!(covered <= corner, "{}: {covered} pixels", label.text);
            }
        }
    }

    #[test]
    fn several_curves_have_their_colours_and_a_legend() {
        let line = |slope: f64| vec![[0.0, 0.0], [1.0, slope]];
        let curves: Vec<Curve> = (0..3)
            .map(|k| curve("run", line(1.0 + f64::from(k)), vec![]))
            .collect();
        let one = chart(curves[..1].to_vec()).draw().expect("a chart");
        let picture = chart(curves).draw().expect("a chart");
        assert_eq!(picture.size()[1], one.size()[1] + legend::ROW as u32);
        let [width, height] = picture.size().map(|length| length as i32);
        for k in 0..3 {
            assert!(shows(&picture, [0.6, 0.6 * (1.0 + k as f64)], colour_of(k)));
            let legend = [0, height - GAP - legend::ROW, width, height];
            assert!(count(&picture, legend, colour_of(k)) > 100);
        }
    }

    #[test]
    fn a_single_point_shows() {
        let picture = chart(vec![curve("start", vec![[1e-3, 20.0]; 3], vec![])]).draw();
        let picture = picture.expect("a chart");
        let [x, y] = picture.frame.to_page([1e-3, 20.0]).map(|p| p as i32);
        let around = [x - 4, y - 4, x + 5, y + 5];
        assert_eq!(count(&picture, around, colour_of(0)), 81);
        let origin = chart(vec![curve("start", vec![[0.0, 0.0]], vec![])]).draw();
        assert!(shows(&origin.expect("a chart"), [0.0, 0.0], colour_of(0)));
    }

    #[test]
    fn any_magnitude_can_be_drawn() {
        for magnitude in [1e-299, 1e-21, 1e-7, 1e9, 1e40, 1e300] {
            let points = vec![[0.0, 0.0], [magnitude, magnitude], [2.0 * magnitude, 0.0]];
            let picture = chart(vec![curve("run", points, vec![])]).draw();
            let picture = picture.expect("a chart");
            for x in [0.4, 1.0, 1.6] {
                let on = [x * magnitude, (1.0 - (x - 1.0_f64).abs()) * magnitude];
                assert!(shows(&picture, on, colour_of(0)), "{x} × {magnitude}");
            }
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let refused = |chart: Chart| chart.draw().expect_err("must be refused");
        assert!(matches!(refused(chart(vec![])), PictureError::Empty));
        let empty = chart(vec![Curve::default(), Curve::default()]);
        assert!(matches!(refused(empty), PictureError::Empty));
        for value in [f64::NAN, f64::INFINITY] {
            let mut broken = rise_and_drop();
            broken.curves[0].points[2][0] = value;
            assert!(matches!(refused(broken), PictureError::NotFinite { .. }));
            let mut broken = rise_and_drop();
            broken.curves[0].marks[1].at[1] = value;
            assert!(matches!(refused(broken), PictureError::NotFinite { .. }));
        }
        let endless = chart(vec![curve(
            "run",
            vec![[-1.7e308, 0.0], [1.7e308, 0.0]],
            vec![],
        )]);
        assert!(matches!(refused(endless), PictureError::NotFinite { .. }));
    }

    #[test]
    fn a_text_too_long_is_shortened() {
        let long = "a label of many words ".repeat(20);
        let short = shortened(&long, 300, text_width);
        assert!(short.ends_with('…') && text_width(&short) <= 300 && short.len() > 15);
        assert_eq!(shortened("short", 300, text_width), "short");
    }
}
