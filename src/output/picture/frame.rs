//! The frame around a picture's content: where the body lies on the page, its axes, texts.

use super::raster::{Raster, paint};
use super::text::TextLine;
use super::ticks::{Ticks, Unit};
use crate::output::colour::Rgb;

/// Width of a paper's column [mm].
pub(super) const COLUMN: f64 = 85.0;
/// Largest width of a picture [pixels]: on a paper's column some 360 to the inch.
pub(super) const WIDTH: i32 = 1200;
/// Smallest width of the plot of a slim body [pixels].
const LEAST_PLOT_WIDTH: i32 = 560;
/// The plot's height lies between these [pixels]: a slender body still gets a readable axis, a
/// slim one fits the screen.
const PLOT_HEIGHT: [f64; 2] = [180.0, 960.0];
/// Margins for the numbers and the title of the y axis, about [pixels].
const USUAL_LEFT_ROOM: i32 = 140;
/// Margins between the body and the axes, in shares of the body's larger side.
const MARGIN: f64 = 0.015;
/// Distance between texts [pixels].
pub(super) const GAP: i32 = 14;
pub(super) const TICK: i32 = 8;
/// Numbers along an axis or a colour bar.
pub(super) const MOST_TICKS: i32 = 12;

/// Heights from ascender to descender [pixels]: fonts of 8 and 7 points on a column of 85 mm.
pub(super) const TITLE_SIZE: i32 = 46;
pub(super) const TEXT_SIZE: i32 = 41;

/// The smallest box around a picture's content [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl Bounds {
    /// The box around `positions`; none without an extent.
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

/// The quantity along an axis and the unit of its numbers.
#[derive(Clone, Debug)]
pub(super) struct Quantity {
    pub name: String,
    pub unit: Unit,
}

impl Quantity {
    pub fn label(&self) -> String {
        self.unit.label(&self.name)
    }
}

/// The content's place on the page; x to the right, y up. A body has the same scale on both.
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

/// Widths left free for texts around the plot [pixels].
#[derive(Clone, Copy, Debug)]
pub(super) struct Margins {
    pub above: i32,
    pub below: i32,
    pub right: i32,
    /// Width of the widest text above or below.
    pub across: i32,
}

impl Frame {
    /// Places `bounds` on a page with `margins` for texts beside the axes' own.
    pub fn around(bounds: Bounds, margins: Margins) -> Frame {
        // The labels' width depends on the scale, the scale on the room they leave: two rounds.
        let first = Frame::placed(bounds, margins, USUAL_LEFT_ROOM);
        Frame::placed(bounds, margins, first.left_room())
    }

    fn placed(bounds: Bounds, margins: Margins, left: i32) -> Frame {
        let size = bounds.size();
        let larger = size[0].max(size[1]);
        let [padded_width, padded_height] = size.map(|s| s + 2.0 * MARGIN * larger);
        let most = WIDTH - left - margins.right;
        let least = LEAST_PLOT_WIDTH
            .max(margins.across - margins.right)
            .min(most);
        let [lowest, highest] = PLOT_HEIGHT;
        let scale = (f64::from(most) / padded_width).min(highest / padded_height);
        let width = (scale * padded_width)
            .clamp(least.into(), most.into())
            .round();
        let height = (scale * padded_height).clamp(lowest, highest).round();
        let middle = |axis: usize| (bounds.min[axis] + bounds.max[axis]) / 2.0;
        let [right, bottom] = [left + width as i32, margins.above + height as i32];
        Frame {
            page: [
                right + margins.right,
                bottom + axis_height() + margins.below,
            ],
            plot: [left, margins.above, right, bottom],
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
    /// [pixels], whatever the margins across.
    pub fn stretched(bounds: Bounds, axes: [Quantity; 2], height: i32, margins: Margins) -> Frame {
        let size = bounds.size();
        let spanning = |left: i32| {
            let page = [WIDTH, height];
            let [right, bottom] = [
                page[0] - margins.right,
                page[1] - margins.below - axis_height(),
            ];
            Frame {
                page,
                plot: [left, margins.above, right, bottom],
                origin: bounds.min,
                scale: [
                    f64::from(right - left) / size[0],
                    f64::from(bottom - margins.above) / size[1],
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

    /// Components in the plot [pixels], y downwards, of a vector [m].
    pub fn along_plot(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.scale[0], -y * self.scale[1]]
    }

    pub fn plot_width(&self) -> i32 {
        self.plot[2] - self.plot[0]
    }

    pub fn plot_height(&self) -> i32 {
        self.plot[3] - self.plot[1]
    }

    /// The pixels of the plot's inside.
    pub fn paint(&self, zoom: f64, draw: impl Fn(&mut Raster) + Sync) -> Vec<Rgb> {
        let size = [self.plot_width(), self.plot_height()];
        paint(size.map(|p| p as usize), zoom, draw)
    }

    /// The frame of a picture with `zoom` pixels for one.
    pub fn zoomed(&self, zoom: f64) -> Frame {
        let few = |pixels: i32| (f64::from(pixels) * zoom).ceil() as i32;
        let [left, top, ..] = self.plot.map(few);
        let plot = [
            left,
            top,
            left + few(self.plot_width()),
            top + few(self.plot_height()),
        ];
        Frame {
            page: self.page.map(few),
            plot,
            scale: self.scale.map(|scale| zoom * scale),
            ..self.clone()
        }
    }

    /// Ticks along x (0) or y (1), in the axis's unit.
    pub fn ticks(&self, axis: usize) -> Ticks {
        let (pixels, apart) = match axis {
            0 => (self.plot_width(), 160),
            _ => (self.plot_height(), 66),
        };
        let [min, max] = [0.0, f64::from(pixels)]
            .map(|p| (self.origin[axis] + p / self.scale[axis]) * self.axes[axis].unit.per_si);
        Ticks::within(min, max, (pixels / apart).min(MOST_TICKS) as usize)
    }
}

/// Room above a plot for a title; without one, no more than half a number of the y axis needs.
pub(super) fn title_height(title: &str) -> i32 {
    match title {
        "" => GAP + TEXT_SIZE / 2,
        _ => GAP + TITLE_SIZE + GAP,
    }
}

/// Room below a plot for the labels and the title of its x axis [pixels].
pub(super) fn axis_height() -> i32 {
    TICK + GAP / 2 + TEXT_SIZE + GAP / 2 + TEXT_SIZE + GAP
}

/// Width of a text of [`TEXT_SIZE`] [pixels].
pub(super) fn text_width(text: &str) -> i32 {
    TextLine::plain(text, TEXT_SIZE).width.ceil() as i32
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
    TextLine::plain(title, TITLE_SIZE).width.ceil() as i32
}
