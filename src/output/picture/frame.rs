//! The frame around a picture's content: where the body lies on the page, its axes, texts.

use super::PictureError;
use super::raster::{Raster, paint};
use super::text::Writing;
use super::ticks::{Ticks, Unit};
use crate::output::colour::{INK, Rgb, WHITE};
use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{
    BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, PathElement, RGBColor, Rectangle,
};
use plotters::style::Color;

/// Largest width of a picture [pixels].
const WIDTH: i32 = 1600;
/// Smallest width of the plot of a slim body [pixels].
const LEAST_PLOT_WIDTH: i32 = 600;
/// The plot's height lies between these [pixels]: a slender body still gets a readable axis, a
/// slim one fits the screen.
const PLOT_HEIGHT: [f64; 2] = [180.0, 1200.0];
/// Room for the numbers and the title of the y axis, about [pixels].
const USUAL_LEFT_ROOM: i32 = 110;
/// Room between the body and the axes, in shares of the body's larger side.
const MARGIN: f64 = 0.015;
/// Distance between texts [pixels].
pub(super) const GAP: i32 = 14;
const TICK: i32 = 8;
/// Numbers along an axis or a colour bar.
pub(super) const MOST_TICKS: i32 = 12;

pub(super) const TITLE_SIZE: i32 = 34;
pub(super) const TEXT_SIZE: i32 = 26;

/// The smallest box around a picture's content [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl Bounds {
    /// None without an extent.
    pub fn of(positions: impl Iterator<Item = [f64; 2]>) -> Option<Bounds> {
        let bounds: Option<Bounds> = positions.fold(None, |bounds, position| {
            let Bounds { min, max } = bounds.unwrap_or(Bounds {
                min: position,
                max: position,
            });
            Some(Bounds {
                min: [0, 1].map(|k| min[k].min(position[k])),
                max: [0, 1].map(|k| max[k].max(position[k])),
            })
        });
        bounds.filter(|bounds| bounds.size() != [0.0, 0.0])
    }

    fn size(&self) -> [f64; 2] {
        [0, 1].map(|k| self.max[k] - self.min[k])
    }
}

/// What an axis measures, and the unit of its numbers.
#[derive(Clone, Debug)]
pub(super) struct Quantity {
    pub name: String,
    pub unit: Unit,
}

impl Quantity {
    fn label(&self) -> String {
        self.unit.label(&self.name)
    }
}

/// Where the content lies on the page; x to the right, y up. A body has the same scale on both.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Width and height of the page [pixels].
    pub page: [i32; 2],
    /// Left, top, right, bottom of the plot [pixels].
    pub plot: [i32; 4],
    /// The position in the plot's lower left corner [m, or a chart's SI units].
    origin: [f64; 2],
    /// Pixels per metre, or per SI unit of a chart's axes.
    pub scale: [f64; 2],
    pub axes: [Quantity; 2],
}

/// Room for texts around the plot [pixels].
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    pub above: i32,
    pub below: i32,
    pub right: i32,
    /// Width of the widest text above or below.
    pub across: i32,
}

impl Frame {
    /// Places `bounds` on a page with `room` for texts beside the axes' own.
    pub fn around(bounds: Bounds, room: Room) -> Frame {
        // The labels' width depends on the scale, the scale on the room they leave: two rounds.
        let first = Frame::placed(bounds, room, USUAL_LEFT_ROOM);
        Frame::placed(bounds, room, first.left_room())
    }

    fn placed(bounds: Bounds, room: Room, left: i32) -> Frame {
        let size = bounds.size();
        let larger = size[0].max(size[1]);
        let [padded_width, padded_height] = size.map(|s| s + 2.0 * MARGIN * larger);
        let most = WIDTH - left - room.right;
        let least = LEAST_PLOT_WIDTH.max(room.across - room.right).min(most);
        let [lowest, highest] = PLOT_HEIGHT;
        let scale = (f64::from(most) / padded_width).min(highest / padded_height);
        let width = (scale * padded_width)
            .clamp(least.into(), most.into())
            .round();
        let height = (scale * padded_height).clamp(lowest, highest).round();
        let middle = |axis: usize| (bounds.min[axis] + bounds.max[axis]) / 2.0;
        let [right, bottom] = [left + width as i32, room.above + height as i32];
        Frame {
            page: [right + room.right, bottom + axis_height() + room.below],
            plot: [left, room.above, right, bottom],
            origin: [
                middle(0) - width / 2.0 / scale,
                middle(1) - height / 2.0 / scale,
            ],
            scale: [scale; 2],
            axes: ["x", "y"].map(|name| Quantity {
                name: name.to_owned(),
                unit: Unit::of_length(larger),
            }),
        }
    }

    /// Stretches `bounds`, in SI units of the `axes`, over a page of full width and `height`
    /// [pixels], whatever the room across.
    pub fn stretched(bounds: Bounds, axes: [Quantity; 2], height: i32, room: Room) -> Frame {
        let size = bounds.size();
        let spanning = |left: i32| {
            let page = [WIDTH, height];
            let [right, bottom] = [page[0] - room.right, page[1] - room.below - axis_height()];
            Frame {
                page,
                plot: [left, room.above, right, bottom],
                origin: bounds.min,
                scale: [
                    f64::from(right - left) / size[0],
                    f64::from(bottom - room.above) / size[1],
                ],
                axes: axes.clone(),
            }
        };
        // The numbers along y depend on the height alone.
        spanning(spanning(USUAL_LEFT_ROOM).left_room())
    }

    fn left_room(&self) -> i32 {
        let ticks = self.ticks(1);
        let widths = ticks.values().map(|value| text_width(&ticks.label(value)));
        GAP + TEXT_SIZE + GAP + widths.max().unwrap_or(0) + GAP / 2 + TICK
    }

    /// Adds room below the axes [pixels].
    pub fn extend_below(&mut self, height: i32) {
        self.page[1] += height;
    }

    /// Position on the page [pixels], y downwards, of a position [m].
    pub fn to_page(&self, position: [f64; 2]) -> [f64; 2] {
        let [left, _, _, bottom] = self.plot.map(f64::from);
        [
            left + (position[0] - self.origin[0]) * self.scale[0],
            bottom - (position[1] - self.origin[1]) * self.scale[1],
        ]
    }

    /// Position within the plot [pixels], y downwards, of a position [m].
    pub fn to_plot(&self, position: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.to_page(position);
        [x - f64::from(self.plot[0]), y - f64::from(self.plot[1])]
    }

    pub fn plot_width(&self) -> i32 {
        self.plot[2] - self.plot[0]
    }

    pub fn plot_height(&self) -> i32 {
        self.plot[3] - self.plot[1]
    }

    /// The pixels of the plot's inside.
    pub fn paint(&self, draw: impl Fn(&mut Raster) + Sync) -> Vec<Rgb> {
        paint(
            [self.plot_width(), self.plot_height()].map(|p| p as usize),
            draw,
        )
    }

    /// Ticks along x (0) or y (1), in the axis's unit.
    pub fn ticks(&self, axis: usize) -> Ticks {
        let (pixels, apart) = match axis {
            0 => (self.plot_width(), 140),
            _ => (self.plot_height(), 60),
        };
        let [min, max] = [0.0, f64::from(pixels)]
            .map(|p| (self.origin[axis] + p / self.scale[axis]) * self.axes[axis].unit.per_si);
        Ticks::within(min, max, (pixels / apart).min(MOST_TICKS) as usize)
    }
}

/// Room below a plot for the labels and the title of its x axis [pixels].
fn axis_height() -> i32 {
    TICK + GAP / 2 + TEXT_SIZE + GAP / 2 + TEXT_SIZE + GAP
}

/// What plotters may report.
pub type PageError = DrawingAreaErrorKind<<BitMapBackend<'static> as DrawingBackend>::ErrorType>;

/// The page with the plot's inside on it, for texts and lines.
pub(super) struct Page<'a> {
    area: DrawingArea<BitMapBackend<'a>, Shift>,
}

impl<'a> Page<'a> {
    /// `rgb`: room for the page's pixels, row by row.
    pub fn new(frame: &Frame, plot: &[Rgb], rgb: &'a mut [u8]) -> Page<'a> {
        rgb.fill(WHITE[0]);
        let [page_width, left, top] =
            [frame.page[0], frame.plot[0], frame.plot[1]].map(|p| p as usize);
        for (row, pixels) in plot.chunks_exact(frame.plot_width() as usize).enumerate() {
            let start = 3 * ((top + row) * page_width + left);
            rgb[start..start + 3 * pixels.len()].copy_from_slice(pixels.as_flattened());
        }
        let size = (frame.page[0] as u32, frame.page[1] as u32);
        Page {
            area: BitMapBackend::with_buffer(rgb, size).into_drawing_area(),
        }
    }

    /// The plot's box with ticks, their labels and the axes' titles.
    pub fn draw_axes(&self, frame: &Frame) -> Result<(), PictureError> {
        let [left, top, right, bottom] = frame.plot;
        self.draw_box([left - 1, top - 1, right, bottom], INK)?;
        let [x_per_si, y_per_si] = frame.axes.each_ref().map(|axis| axis.unit.per_si);
        let ticks = frame.ticks(0);
        for value in ticks.values() {
            let x = frame.to_page([value / x_per_si, 0.0])[0].round() as i32;
            self.draw_line([x, bottom], [x, bottom + TICK])?;
            let below = [x, bottom + TICK + GAP / 2 + TEXT_SIZE / 2];
            self.draw_text(&ticks.label(value), below, Anchor::Middle)?;
        }
        let ticks = frame.ticks(1);
        for value in ticks.values() {
            let y = frame.to_page([0.0, value / y_per_si])[1].round() as i32;
            self.draw_line([left - TICK, y], [left, y])?;
            let beside = [left - TICK - GAP / 2, y];
            self.draw_text(&ticks.label(value), beside, Anchor::Right)?;
        }
        let below = bottom + axis_height() - GAP - TEXT_SIZE / 2;
        self.draw_text(
            &frame.axes[0].label(),
            [(left + right) / 2, below],
            Anchor::Middle,
        )?;
        let title = Writing::plain(&frame.axes[1].label(), TEXT_SIZE);
        let beside = [GAP + TEXT_SIZE / 2, (top + bottom) / 2];
        self.draw_writing(&title, beside, Anchor::Middle, true)
    }

    /// The picture's title at the top left.
    pub fn draw_title(&self, frame: &Frame, title: &str) -> Result<(), PictureError> {
        let at = [frame.plot[0], GAP + TITLE_SIZE / 2];
        self.draw_writing(&Writing::plain(title, TITLE_SIZE), at, Anchor::Left, false)
    }

    /// `at`: the text's left end, middle or right end, at half its height.
    pub fn draw_text(&self, text: &str, at: [i32; 2], anchor: Anchor) -> Result<(), PictureError> {
        self.draw_writing(&Writing::plain(text, TEXT_SIZE), at, anchor, false)
    }

    /// Text in which `_` begins a subscript.
    pub fn draw_symbol(
        &self,
        text: &str,
        at: [i32; 2],
        anchor: Anchor,
    ) -> Result<(), PictureError> {
        self.draw_writing(&Writing::symbol(text, TEXT_SIZE), at, anchor, false)
    }

    /// An upright writing runs upwards.
    fn draw_writing(
        &self,
        writing: &Writing,
        at: [i32; 2],
        anchor: Anchor,
        upright: bool,
    ) -> Result<(), PictureError> {
        let along = match anchor {
            Anchor::Left => 0.0,
            Anchor::Middle => writing.width / 2.0,
            Anchor::Right => writing.width,
        }
        .round() as i32;
        let foot = (writing.capital / 2.0).round() as i32;
        let mut outcome = Ok(());
        writing.each_pixel(|x, y, coverage| {
            let (x, y) = (x - along, y + foot);
            let turned = if upright { [y, -x] } else { [x, y] };
            let colour = rgb(INK).mix(f64::from(coverage));
            let drawn = self
                .area
                .draw_pixel((at[0] + turned[0], at[1] + turned[1]), &colour);
            if let (Ok(()), Err(source)) = (&outcome, drawn) {
                outcome = Err(PictureError::Drawing { source });
            }
        });
        outcome
    }

    pub fn draw_line(&self, from: [i32; 2], to: [i32; 2]) -> Result<(), PictureError> {
        let path = PathElement::new(vec![from.into(), to.into()], rgb(INK).stroke_width(2));
        self.area
            .draw(&path)
            .map_err(|source| PictureError::Drawing { source })
    }

    /// The outline of a box: left, top, right, bottom, all included.
    pub fn draw_box(&self, [l, t, r, b]: [i32; 4], colour: Rgb) -> Result<(), PictureError> {
        self.area
            .draw(&Rectangle::new([(l, t), (r, b)], rgb(colour)))
            .map_err(|source| PictureError::Drawing { source })
    }

    /// A filled box: left, top, right, bottom, the last two not included.
    pub fn fill_box(&self, [l, t, r, b]: [i32; 4], colour: Rgb) -> Result<(), PictureError> {
        self.area
            .draw(&Rectangle::new([(l, t), (r, b)], rgb(colour).filled()))
            .map_err(|source| PictureError::Drawing { source })
    }

    /// Completes the picture.
    pub fn finish(self) -> Result<(), PictureError> {
        self.area
            .present()
            .map_err(|source| PictureError::Drawing { source })
    }
}

fn rgb([r, g, b]: Rgb) -> RGBColor {
    RGBColor(r, g, b)
}

/// Width of a text of [`TEXT_SIZE`] [pixels].
pub(super) fn text_width(text: &str) -> i32 {
    Writing::plain(text, TEXT_SIZE).width.ceil() as i32
}

/// `text`, or as much of it as fits in `width` [pixels] with an ellipsis for the rest, if `measure`
/// is its width.
pub(super) fn shortened(text: &str, width: i32, measure: impl Fn(&str) -> i32) -> String {
    if measure(text) <= width {
        return text.to_owned();
    }
    let ends = text.char_indices().rev();
    let cut = ends.map(|(end, _)| format!("{}…", text[..end].trim_end()));
    let mut fitting = cut.skip_while(|cut| measure(cut) > width);
    fitting.next().unwrap_or_default()
}

/// Width of a picture's title [pixels].
pub(super) fn title_width(title: &str) -> i32 {
    Writing::plain(title, TITLE_SIZE).width.ceil() as i32
}

/// Which end of a text its position means.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}
