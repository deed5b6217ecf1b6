//! The legend below a picture of a mesh.

use super::frame::{Frame, GAP, text_width};
use super::mesh::LIGHT_TINT;
use super::page::{Anchor, Page};
use crate::output::colour::{CELL_EDGE, Rgb, tint};

/// Side of a box in the legend [pixels].
const KEY_SIZE: i32 = 36;

/// The sign before a legend's text.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sign {
    Cells(Rgb),
    Points(Rgb),
    Line(Rgb, f64),
    None,
}

/// A legend's sign and text.
pub(super) struct Key {
    pub sign: Sign,
    pub text: String,
}

impl Key {
    /// Sign, text, and room up to the next [pixels].
    pub fn width(&self) -> i32 {
        KEY_SIZE + GAP + text_width(&self.text) + 3 * GAP
    }
}

/// Height of a row of the legend [pixels].
pub(super) const ROW: i32 = KEY_SIZE + GAP;

/// The legend's keys, as many in a row as fit in `width` [pixels].
pub(super) fn in_rows(keys: Vec<Key>, width: i32) -> Vec<Vec<Key>> {
    let mut rows: Vec<Vec<Key>> = Vec::new();
    let mut used = 0;
    for key in keys {
        let wanted = key.width();
        match rows.last_mut() {
            Some(row) if used + wanted <= width => row.push(key),
            _ => {
                rows.push(vec![key]);
                used = 0;
            }
        }
        used += wanted;
    }
    rows
}

/// Draws the rows at the bottom of the page.
pub(super) fn draw(page: &mut Page, frame: &Frame, rows: &[Vec<Key>]) {
    let mut top = frame.page[1] - GAP - rows.len() as i32 * ROW;
    for row in rows {
        let mut left = frame.plot[0];
        for key in row {
            draw_sign(page, key.sign, [left, top]);
            let text = [left + KEY_SIZE + GAP, top + KEY_SIZE / 2];
            page.draw_text(&key.text, text, Anchor::Left);
            left += key.width();
        }
        top += ROW;
    }
}

/// Draws a sign with its top left corner at `at`.
fn draw_sign(page: &mut Page, sign: Sign, [x, y]: [i32; 2]) {
    let whole = [x, y, x + KEY_SIZE, y + KEY_SIZE];
    match sign {
        Sign::Cells(colour) => {
            page.fill_box(whole, colour);
            page.draw_box([x, y, x + KEY_SIZE - 1, y + KEY_SIZE - 1], CELL_EDGE);
        }
        Sign::Points(colour) => {
            page.fill_box(whole, tint(colour, LIGHT_TINT));
            let half = KEY_SIZE / 2;
            for corner in [[x, y], [x + half, y], [x, y + half], [x + half, y + half]] {
                let [l, t] = corner.map(|c| c + half / 4);
                page.fill_box([l, t, l + half / 2 + 1, t + half / 2 + 1], colour);
            }
        }
        Sign::Line(colour, width) => {
            let top = y + (KEY_SIZE - width as i32) / 2;
            page.fill_box([x, top, x + KEY_SIZE, top + width as i32], colour);
        }
        Sign::None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_breaks_into_rows_that_fit() {
        let key = || Key {
            sign: Sign::Cells([0; 3]),
            text: "grip: finite elements, 800 cells".to_owned(),
        };
        let width = 2 * key().width() + 10;
        let rows = in_rows((0..5).map(|_| key()).collect(), width);
        assert_eq!(rows.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 1]);
    }
}
