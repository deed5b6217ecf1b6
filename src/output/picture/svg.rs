//! A composition as SVG: axes, texts, lines and discs as such; a map's colours, of which there may be a
//! million places, as an embedded PNG.
//!
//! The page is as wide as it is on a paper's column of 85 mm. Texts stay texts; `textLength` gives them the
//! width that they have here, whatever font the viewer has.

use super::composition::Composition;
use super::frame::{COLUMN, WIDTH};
use super::page::{Anchor, Item, Text};
use super::shape::Shape;
use super::{PictureError, png_bytes};
use crate::output::colour::{INK, Rgb};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write as _;

/// The size of a font that is as high as ours, in shares of the distance from ascender to descender.
const EM: f64 = 0.87;
/// Width of an outline [pixels]: 0.4 points on a column.
pub(super) const OUTLINE_WIDTH: f64 = 2.0;
/// Subscripts: size in shares of the text's, drop in shares of its em.
const SUBSCRIPT: [f64; 2] = [0.72, 0.16];

/// The file's content.
pub(super) fn svg(composition: &Composition) -> Result<String, PictureError> {
    let frame = &composition.frame;
    let [width, height] = frame.page;
    let millimetres = |pixels: i32| COLUMN / f64::from(WIDTH) * f64::from(pixels);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.2}mm\" height=\"{:.2}mm\" \
         viewBox=\"0 0 {width} {height}\" \
         font-family=\"Ubuntu, 'DejaVu Sans', Arial, Helvetica, sans-serif\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        millimetres(width),
        millimetres(height)
    );
    let [left, top, ..] = frame.plot;
    let [wide, high] = [frame.plot_width(), frame.plot_height()];
    let _ = writeln!(
        svg,
        "<svg x=\"{left}\" y=\"{top}\" width=\"{wide}\" height=\"{high}\" viewBox=\"0 0 {wide} {high}\">"
    );
    if let Some(pixels) = composition.content() {
        let png = png_bytes([wide, high].map(|p| p as u32), pixels.as_flattened())?;
        let data = STANDARD.encode(png);
        let _ = writeln!(
            svg,
            "<image width=\"{wide}\" height=\"{high}\" href=\"data:image/png;base64,{data}\"/>"
        );
    }
    draw_shapes(&mut svg, &composition.shapes);
    svg.push_str("</svg>\n");
    for item in &composition.page.items {
        match item {
            Item::Rectangle(bar) => {
                let [l, t, r, b] = bar.place;
                let _ = writeln!(
                    svg,
                    "<rect x=\"{l}\" y=\"{t}\" width=\"{}\" height=\"{}\" fill=\"{}\" \
                     shape-rendering=\"crispEdges\"/>",
                    r - l,
                    b - t,
                    hex(bar.colour)
                );
            }
            // One closed line: sides drawn apart would vanish one by one where a pixel of the screen is
            // larger than they are wide.
            Item::Outline(outline) => {
                let [l, t, r, b] = outline.place;
                let [x, y] = [l, t].map(|corner| f64::from(corner) + 0.5);
                let _ = writeln!(
                    svg,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" fill=\"none\" \
                     stroke=\"{}\" stroke-width=\"{OUTLINE_WIDTH}\"/>",
                    r - l,
                    b - t,
                    hex(outline.colour)
                );
            }
            Item::Text(text) => write_text(&mut svg, text),
        }
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// Neighbours that look alike share a path.
fn draw_shapes(svg: &mut String, shapes: &[Shape]) {
    let same = |a: &Shape, b: &Shape| style(a) == style(b) && !matches!(a, Shape::Disc { .. });
    for group in shapes.chunk_by(same) {
        let Some(first) = group.first() else {
            continue;
        };
        if let Shape::Disc {
            centre: [x, y],
            radius,
            colour,
        } = first
        {
            let fill = hex(*colour);
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{fill}\"/>"
            );
            continue;
        }
        let _ = write!(svg, "<path {} d=\"", style(first));
        for shape in group {
            match shape {
                Shape::Fill { corners, .. } => {
                    draw_path(svg, corners);
                    svg.push('Z');
                }
                Shape::Stroke { path, .. } | Shape::Trace { path, .. } => draw_path(svg, path),
                Shape::Disc { .. } => {}
            }
        }
        svg.push_str("\"/>\n");
    }
}

fn draw_path(svg: &mut String, path: &[[f64; 2]]) {
    for (index, [x, y]) in path.iter().enumerate() {
        let to = if index == 0 { 'M' } else { 'L' };
        let _ = write!(svg, "{to}{x:.2} {y:.2}");
    }
}

fn style(shape: &Shape) -> String {
    match shape {
        Shape::Fill { colour, .. } | Shape::Disc { colour, .. } => {
            format!("fill=\"{}\"", hex(*colour))
        }
        Shape::Stroke { width, colour, .. } | Shape::Trace { width, colour, .. } => format!(
            "fill=\"none\" stroke=\"{}\" stroke-width=\"{width:.2}\" stroke-linecap=\"round\" \
             stroke-linejoin=\"round\"",
            hex(*colour)
        ),
    }
}

fn write_text(svg: &mut String, text: &Text) {
    let line = text.line();
    let anchor = match text.anchor {
        Anchor::Left => "start",
        Anchor::Middle => "middle",
        Anchor::Right => "end",
    };
    let [x, y] = text.at;
    let size = EM * f64::from(text.size);
    // The foot line stands half a capital below the text's middle.
    let foot = f64::from(line.capital) / 2.0;
    let place = if text.upright {
        format!("transform=\"translate({x} {y}) rotate(-90)\" y=\"{foot:.1}\"")
    } else {
        format!("x=\"{x}\" y=\"{:.1}\"", f64::from(y) + foot)
    };
    let fixed = if text.is_symbol {
        String::new()
    } else {
        format!(
            " textLength=\"{:.1}\" lengthAdjust=\"spacingAndGlyphs\"",
            line.width
        )
    };
    let content = if text.is_symbol {
        symbol(&text.text, size)
    } else {
        escape(&text.text)
    };
    let _ = writeln!(
        svg,
        "<text {place} font-size=\"{size:.1}\" text-anchor=\"{anchor}\" fill=\"{}\"{fixed}>{content}</text>",
        hex(INK)
    );
}

/// A text with subscripts, set as by [`super::text::TextLine::symbol`].
fn symbol(text: &str, size: f64) -> String {
    let mut parts = text.split('_');
    let mut content = escape(parts.next().unwrap_or_default());
    for part in parts {
        let end = part.find(|c: char| !c.is_alphanumeric());
        let (subscript, rest) = part.split_at(end.unwrap_or(part.len()));
        let drop = SUBSCRIPT[1] * size;
        let _ = write!(
            content,
            "<tspan font-size=\"{:.1}\" dy=\"{drop:.1}\">{}</tspan>",
            SUBSCRIPT[0] * size,
            escape(subscript)
        );
        if !rest.is_empty() {
            let _ = write!(
                content,
                "<tspan dy=\"{:.1}\">{}</tspan>",
                -drop,
                escape(rest)
            );
        }
    }
    content
}

/// `text` in an element of XML or HTML.
fn escape(text: &str) -> String {
    crate::output::markup::escape(text)
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
