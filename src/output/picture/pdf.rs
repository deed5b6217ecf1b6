//! A composition as PDF: a page as wide as a paper's column; lines, discs and the outlines of letters as
//! such, so that no reader needs our font; a map's colours, of which there may be a million places, as an
//! image.

use super::composition::Composition;
use super::frame::{COLUMN, WIDTH};
use super::page::{Anchor, Item, Text};
use super::shape::Shape;
use super::svg::OUTLINE_WIDTH;
use crate::output::colour::{INK, Rgb};
use ab_glyph::OutlineCurve;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref};
use std::io::Write as _;

/// Length by which a colour of the bar reaches under the next, lest smoothing shows the page between them
/// [pixels].
const OVERLAP: f32 = 0.5;
const POINTS_PER_MILLIMETRE: f64 = 72.0 / 25.4;
/// Name of the map's colours in the page's resources.
const IMAGE: Name = Name(b"map");
/// Distance of a cubic's control points from the ends of a quarter of the unit circle.
const QUARTER: f32 = 0.552_285;

/// The file's content.
pub(super) fn pdf(composition: &Composition) -> Vec<u8> {
    let frame = &composition.frame;
    let scale = (COLUMN * POINTS_PER_MILLIMETRE / f64::from(WIDTH)) as f32;
    let [width, height] = frame.page.map(|pixels| scale * pixels as f32);
    let [left, top, ..] = frame.plot.map(|pixels| pixels as f32);
    let plot = [frame.plot_width(), frame.plot_height()];
    let [wide, high] = plot.map(|pixels| pixels as f32);
    let image = composition.content();

    let mut content = Content::new();
    // Pixels of the page, y downwards.
    content.transform([scale, 0.0, 0.0, -scale, 0.0, height]);
    content
        .set_line_cap(LineCapStyle::RoundCap)
        .set_line_join(LineJoinStyle::RoundJoin);
    content.save_state();
    content.transform([1.0, 0.0, 0.0, 1.0, left, top]);
    content.rect(0.0, 0.0, wide, high).clip_nonzero().end_path();
    if image.is_some() {
        content.save_state();
        content.transform([wide, 0.0, 0.0, -high, 0.0, high]);
        content.x_object(IMAGE);
        content.restore_state();
    }
    for shape in &composition.shapes {
        draw_shape(&mut content, shape);
    }
    content.restore_state();
    for item in &composition.page.items {
        draw_item(&mut content, item);
    }

    let [catalog, pages, page, stream, map] = [1, 2, 3, 4, 5].map(Ref::new);
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut description = pdf.page(page);
    description
        .parent(pages)
        .media_box(Rect::new(0.0, 0.0, width, height))
        .contents(stream);
    let mut resources = description.resources();
    if image.is_some() {
        resources.x_objects().pair(IMAGE, map);
    }
    resources.finish();
    description.finish();
    pdf.stream(stream, &deflated(&content.finish()))
        .filter(Filter::FlateDecode);
    if let Some(pixels) = image {
        let data = deflated(pixels.as_flattened());
        let mut image = pdf.image_xobject(map, &data);
        image
            .width(plot[0])
            .height(plot[1])
            .bits_per_component(8)
            .filter(Filter::FlateDecode);
        image.color_space().device_rgb();
    }
    pdf.finish()
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.expect("a list in memory can always be written to")
}

fn draw_shape(content: &mut Content, shape: &Shape) {
    match shape {
        Shape::Fill { corners, colour } => {
            fill_colour(content, *colour);
            draw_path(content, corners);
            content.close_path().fill_even_odd();
        }
        Shape::Stroke {
            path,
            width,
            colour,
        }
        | Shape::Trace {
            path,
            width,
            colour,
        } => {
            stroke_colour(content, *colour);
            content.set_line_width(*width as f32);
            draw_path(content, path);
            content.stroke();
        }
        Shape::Disc {
            centre,
            radius,
            colour,
        } => {
            fill_colour(content, *colour);
            draw_circle(content, centre.map(|x| x as f32), *radius as f32);
            content.fill_nonzero();
        }
    }
}

fn draw_path(content: &mut Content, path: &[[f64; 2]]) {
    for (index, [x, y]) in path.iter().enumerate() {
        let [x, y] = [*x as f32, *y as f32];
        match index {
            0 => content.move_to(x, y),
            _ => content.line_to(x, y),
        };
    }
}

fn draw_circle(content: &mut Content, [x, y]: [f32; 2], radius: f32) {
    content.move_to(x + radius, y);
    // Direction of the start of each quarter, and of its end.
    for [[a, b], [c, d]] in [
        [[1.0, 0.0], [0.0, 1.0]],
        [[0.0, 1.0], [-1.0, 0.0]],
        [[-1.0, 0.0], [0.0, -1.0]],
        [[0.0, -1.0], [1.0, 0.0]],
    ] {
        let at = |s: f32, t: f32| [x + radius * (s * a + t * c), y + radius * (s * b + t * d)];
        let ([x1, y1], [x2, y2], [x3, y3]) = (at(1.0, QUARTER), at(QUARTER, 1.0), at(0.0, 1.0));
        content.cubic_to(x1, y1, x2, y2, x3, y3);
    }
}

fn draw_item(content: &mut Content, item: &Item) {
    let side = |place: [i32; 4]| place.map(|pixels| pixels as f32);
    match item {
        Item::Rectangle(bar) => {
            let [l, t, r, b] = side(bar.place);
            fill_colour(content, bar.colour);
            content.rect(l, t, r - l, b + OVERLAP - t).fill_nonzero();
        }
        Item::Outline(outline) => {
            let [l, t, r, b] = side(outline.place);
            stroke_colour(content, outline.colour);
            content.set_line_width(OUTLINE_WIDTH as f32);
            content.rect(l + 0.5, t + 0.5, r - l, b - t).stroke();
        }
        Item::Text(text) => draw_text(content, text),
    }
}

fn draw_text(content: &mut Content, text: &Text) {
    let line = text.line();
    let [x, y] = text.at.map(|pixels| pixels as f32);
    let start = match text.anchor {
        Anchor::Left => 0.0,
        Anchor::Middle => -line.width / 2.0,
        Anchor::Right => -line.width,
    };
    // The foot line stands half a capital below the text's middle.
    let foot = line.capital / 2.0;
    content.save_state();
    content.transform(match text.upright {
        true => [0.0, -1.0, 1.0, 0.0, x + foot, y - start],
        false => [1.0, 0.0, 0.0, 1.0, x + start, y + foot],
    });
    fill_colour(content, INK);
    let mut pen = None;
    for curve in line.curves() {
        let (from, to) = match curve {
            OutlineCurve::Line(a, b) => (a, b),
            OutlineCurve::Quad(a, _, c) => (a, c),
            OutlineCurve::Cubic(a, _, _, d) => (a, d),
        };
        if pen != Some(from) {
            content.move_to(from.x, from.y);
        }
        match curve {
            OutlineCurve::Line(..) => content.line_to(to.x, to.y),
            OutlineCurve::Quad(a, b, c) => {
                // The same parabola as a cubic.
                let [p, q] = [a, c].map(|end| {
                    [
                        end.x + 2.0 / 3.0 * (b.x - end.x),
                        end.y + 2.0 / 3.0 * (b.y - end.y),
                    ]
                });
                content.cubic_to(p[0], p[1], q[0], q[1], c.x, c.y)
            }
            OutlineCurve::Cubic(_, b, c, d) => content.cubic_to(b.x, b.y, c.x, c.y, d.x, d.y),
        };
        pen = Some(to);
    }
    content.fill_nonzero();
    content.restore_state();
}

fn fill_colour(content: &mut Content, colour: Rgb) {
    let [r, g, b] = colour.map(share);
    content.set_fill_rgb(r, g, b);
}

fn stroke_colour(content: &mut Content, colour: Rgb) {
    let [r, g, b] = colour.map(share);
    content.set_stroke_rgb(r, g, b);
}

fn share(channel: u8) -> f32 {
    f32::from(channel) / 255.0
}
