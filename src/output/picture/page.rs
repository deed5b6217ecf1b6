//! Texts, ticks and boxes around a picture's content: a list, from which pixels or SVG are made.

use super::frame::{Frame, GAP, TEXT_SIZE, TICK, TITLE_SIZE, axis_height};
use super::text::TextLine;
use crate::output::colour::{INK, Rgb};

/// Width of a tick [pixels].
const TICK_WIDTH: i32 = 3;

/// A line of text.
#[derive(Clone, Debug)]
pub(super) struct Text {
    pub text: String,
    /// Height from the highest ascender to the lowest descender [pixels].
    pub size: i32,
    /// Whether `_` begins a subscript.
    pub is_symbol: bool,
    /// Position of the end named by `anchor`, at half the height of a capital [pixels].
    pub at: [i32; 2],
    pub anchor: Anchor,
    /// Whether the text runs upwards.
    pub upright: bool,
}

/// The end of a text to which its position refers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}

impl Text {
    pub fn line(&self) -> TextLine {
        if self.is_symbol {
            TextLine::symbol(&self.text, self.size)
        } else {
            TextLine::plain(&self.text, self.size)
        }
    }
}

/// A filled rectangle: left, top, right, bottom, the last two not included [pixels].
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub place: [i32; 4],
    pub colour: Rgb,
}

#[derive(Clone, Debug)]
pub(super) enum Item {
    Text(Text),
    Rectangle(Rectangle),
    /// The sides of a box, a pixel wide, whose places are included.
    Outline(Rectangle),
}

/// The items on a page, the first at the bottom.
#[derive(Clone, Debug, Default)]
pub(super) struct Page {
    pub items: Vec<Item>,
}

impl Page {
    /// The plot's box with ticks, their labels and the axes' titles.
    pub fn with_axes(frame: &Frame) -> Page {
        let mut page = Page::default();
        let [left, top, right, bottom] = frame.plot;
        page.draw_box([left - 1, top - 1, right, bottom], INK);
        let [x_per_si, y_per_si] = frame.axes.each_ref().map(|axis| axis.unit.per_si);
        let half = TICK_WIDTH / 2;
        let ticks = frame.ticks(0);
        for value in ticks.values() {
            let x = frame.to_page([value / x_per_si, 0.0])[0].round() as i32;
            page.fill_box([x - half, bottom, x + half + 1, bottom + TICK], INK);
            let below = [x, bottom + TICK + GAP / 2 + TEXT_SIZE / 2];
            page.draw_text(&ticks.label(value), below, Anchor::Middle);
        }
        let ticks = frame.ticks(1);
        for value in ticks.values() {
            let y = frame.to_page([0.0, value / y_per_si])[1].round() as i32;
            page.fill_box([left - TICK, y - half, left, y + half + 1], INK);
            let beside = [left - TICK - GAP / 2, y];
            page.draw_text(&ticks.label(value), beside, Anchor::Right);
        }
        let below = bottom + axis_height() - GAP - TEXT_SIZE / 2;
        let middle = [(left + right) / 2, (top + bottom) / 2];
        let label = |axis: usize| frame.axes[axis].label();
        page.draw_text(&label(0), [middle[0], below], Anchor::Middle);
        let beside = [GAP + TEXT_SIZE / 2, middle[1]];
        page.draw_upright(&label(1), beside);
        page
    }

    /// The picture's title at the top left.
    pub fn draw_title(&mut self, frame: &Frame, title: &str) {
        if title.is_empty() {
            return;
        }
        let at = [frame.plot[0], GAP + TITLE_SIZE / 2];
        self.write(title, TITLE_SIZE, at, Anchor::Left, [false; 2]);
    }

    /// `at`: the text's left end, middle or right end, at half its height.
    pub fn draw_text(&mut self, text: &str, at: [i32; 2], anchor: Anchor) {
        self.write(text, TEXT_SIZE, at, anchor, [false; 2]);
    }

    /// Text in which `_` begins a subscript.
    pub fn draw_symbol(&mut self, text: &str, at: [i32; 2], anchor: Anchor) {
        self.write(text, TEXT_SIZE, at, anchor, [true, false]);
    }

    /// Text that runs upwards, with its middle at `at`.
    fn draw_upright(&mut self, text: &str, at: [i32; 2]) {
        self.write(text, TEXT_SIZE, at, Anchor::Middle, [false, true]);
    }

    fn write(
        &mut self,
        text: &str,
        size: i32,
        at: [i32; 2],
        anchor: Anchor,
        [is_symbol, upright]: [bool; 2],
    ) {
        self.items.push(Item::Text(Text {
            text: text.to_owned(),
            size,
            is_symbol,
            at,
            anchor,
            upright,
        }));
    }

    /// The outline of a box: left, top, right, bottom, all included.
    pub fn draw_box(&mut self, place: [i32; 4], colour: Rgb) {
        self.items.push(Item::Outline(Rectangle { place, colour }));
    }

    /// A filled box: left, top, right, bottom, the last two not included.
    pub fn fill_box(&mut self, place: [i32; 4], colour: Rgb) {
        self.items
            .push(Item::Rectangle(Rectangle { place, colour }));
    }
}

/// The four sides of an outline.
fn sides(&Rectangle { place, colour }: &Rectangle) -> [Rectangle; 4] {
    let [l, t, r, b] = place;
    let places = [
        [l, t, r + 1, t + 1],
        [l, b, r + 1, b + 1],
        [l, t, l + 1, b + 1],
        [r, t, r + 1, b + 1],
    ];
    places.map(|place| Rectangle { place, colour })
}

/// The pixels of a page, row by row.
pub(super) struct Pixels<'a> {
    /// [pixels]
    pub width: i32,
    /// Pixels for one of the page.
    pub zoom: f64,
    pub rgb: &'a mut [u8],
}

impl Pixels<'_> {
    pub fn draw(&mut self, page: &Page) {
        for item in &page.items {
            match item {
                Item::Text(text) => self.write(text),
                Item::Rectangle(bar) => self.fill(bar),
                Item::Outline(outline) => sides(outline).iter().for_each(|side| self.fill(side)),
            }
        }
    }

    fn fill(&mut self, Rectangle { place, colour }: &Rectangle) {
        let [left, top] = [place[0], place[1]].map(|p| (f64::from(p) * self.zoom).floor() as i32);
        let [right, bottom] =
            [place[2], place[3]].map(|p| (f64::from(p) * self.zoom).ceil() as i32);
        for y in top..bottom {
            for x in left..right {
                self.mix([x, y], *colour, 1.0);
            }
        }
    }

    fn write(&mut self, text: &Text) {
        let zoomed = |pixels: i32| (f64::from(pixels) * self.zoom).round() as i32;
        let at = text.at.map(zoomed);
        let line = Text {
            size: zoomed(text.size),
            ..text.clone()
        }
        .line();
        let along = match text.anchor {
            Anchor::Left => 0.0,
            Anchor::Middle => line.width / 2.0,
            Anchor::Right => line.width,
        }
        .round() as i32;
        let foot = (line.capital / 2.0).round() as i32;
        line.each_pixel(|x, y, coverage| {
            let (x, y) = (x - along, y + foot);
            let [dx, dy] = if text.upright { [y, -x] } else { [x, y] };
            self.mix([at[0] + dx, at[1] + dy], INK, coverage);
        });
    }

    /// Mixes `colour` into a pixel; pixels off the page are ignored.
    fn mix(&mut self, [x, y]: [i32; 2], colour: Rgb, coverage: f32) {
        if !(0..self.width).contains(&x) || y < 0 {
            return;
        }
        let start = 3 * (y * self.width + x) as usize;
        let Some(pixel) = self.rgb.get_mut(start..start + 3) else {
            return;
        };
        for (channel, ink) in pixel.iter_mut().zip(colour) {
            let [below, above] = [*channel, ink].map(f32::from);
            *channel = (below + coverage * (above - below)).round() as u8;
        }
    }
}
