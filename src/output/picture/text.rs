//! Lines of text in pixels, set by the font's own metrics.

use ab_glyph::{Font, FontRef, OutlineCurve, OutlinedGlyph, Point, PxScale, ScaleFont, point};
use std::sync::LazyLock;

static FONT: LazyLock<FontRef> = LazyLock::new(|| {
    FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT)
        .expect("the built-in font is a valid font")
});

/// Height of subscripts in shares of the line's.
const SUBSCRIPT_SIZE: f32 = 0.72;
/// Drop of subscripts in shares of the line's height.
const SUBSCRIPT_DROP: f32 = 0.14;

/// A line of text, its letters placed from the left end of the foot line.
pub(super) struct TextLine {
    letters: Vec<OutlinedGlyph>,
    /// [pixels]
    pub width: f32,
    /// Height of a capital [pixels].
    pub capital: f32,
}

impl TextLine {
    /// `size`: from the highest ascender to the lowest descender [pixels].
    pub fn plain(text: &str, size: i32) -> TextLine {
        let mut line = TextLine::empty(size);
        line.append(text, size as f32, 0.0);
        line
    }

    /// A symbol such as `σ_xx [Pa]`: letters and digits after `_` are a subscript.
    pub fn symbol(text: &str, size: i32) -> TextLine {
        let mut line = TextLine::empty(size);
        let size = size as f32;
        let mut parts = text.split('_');
        line.append(parts.next().unwrap_or_default(), size, 0.0);
        for part in parts {
            let end = part.find(|c: char| !c.is_alphanumeric());
            let (subscript, rest) = part.split_at(end.unwrap_or(part.len()));
            line.append(subscript, size * SUBSCRIPT_SIZE, size * SUBSCRIPT_DROP);
            line.append(rest, size, 0.0);
        }
        line
    }

    fn empty(size: i32) -> TextLine {
        let scale = PxScale::from(size as f32);
        let capital = FONT.outline_glyph(FONT.glyph_id('H').with_scale(scale));
        TextLine {
            letters: Vec::new(),
            width: 0.0,
            capital: capital.map_or(0.0, |letter| -letter.px_bounds().min.y),
        }
    }

    fn append(&mut self, text: &str, size: f32, drop: f32) {
        let font = FONT.as_scaled(size);
        for character in text.chars() {
            let id = font.glyph_id(character);
            let place = point(self.width, drop);
            let letter = id.with_scale_and_position(size, place);
            self.letters.extend(FONT.outline_glyph(letter));
            self.width += font.h_advance(id);
        }
    }

    /// Calls `pixel` with column, row and coverage (0 to 1), from the left end of the foot line.
    pub fn each_pixel(&self, mut pixel: impl FnMut(i32, i32, f32)) {
        for letter in &self.letters {
            let corner = letter.px_bounds().min;
            letter.draw(|column, row, coverage| {
                let at = [
                    corner.x as i32 + column as i32,
                    corner.y as i32 + row as i32,
                ];
                pixel(at[0], at[1], coverage.clamp(0.0, 1.0));
            });
        }
    }

    /// The outlines of the letters, y downwards from the left end of the foot line [pixels].
    pub fn curves(&self) -> impl Iterator<Item = OutlineCurve> + '_ {
        self.letters.iter().flat_map(|letter| {
            let glyph = letter.glyph();
            let scale = glyph.scale.y / FONT.height_unscaled();
            let place = glyph.position;
            let at = move |p: Point| point(place.x + scale * p.x, place.y - scale * p.y);
            let outline = FONT.outline(glyph.id);
            let curves = outline.into_iter().flat_map(|outline| outline.curves);
            curves.map(move |curve| match curve {
                OutlineCurve::Line(a, b) => OutlineCurve::Line(at(a), at(b)),
                OutlineCurve::Quad(a, b, c) => OutlineCurve::Quad(at(a), at(b), at(c)),
                OutlineCurve::Cubic(a, b, c, d) => OutlineCurve::Cubic(at(a), at(b), at(c), at(d)),
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Left, top, right, bottom of the ink.
    fn ink(line: &TextLine) -> [i32; 4] {
        let mut ink = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
        line.each_pixel(|x, y, coverage| {
            if coverage > 0.0 {
                ink = [ink[0].min(x), ink[1].min(y), ink[2].max(x), ink[3].max(y)];
            }
        });
        ink
    }

    #[test]
    fn the_ink_fills_the_width_and_a_capital_stands_on_the_foot_line() {
        let line = TextLine::plain("HIH", 40);
        let [left, top, right, bottom] = ink(&line);
        assert!(left > 0 && f64::from(right) < f64::from(line.width));
        assert!(f64::from(right - left) > 0.8 * f64::from(line.width));
        assert!((-1..=0).contains(&bottom));
        assert!((f64::from(-top) - f64::from(line.capital)).abs() <= 1.0);
    }

    #[test]
    fn a_subscript_is_smaller_and_lower() {
        let [plain, symbol] = [TextLine::plain("ux", 40), TextLine::symbol("u_x", 40)];
        assert!(symbol.width < plain.width);
        assert!(ink(&symbol)[3] > ink(&plain)[3]);
    }

    #[test]
    fn every_character_in_use_is_in_the_font() {
        for character in "µ×−…[]|,.:()0123456789εσνγΔ".chars() {
            assert_ne!(FONT.glyph_id(character).0, 0, "{character}");
        }
    }
}
