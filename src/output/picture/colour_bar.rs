//! The bar that gives the value of each colour of a map.

use super::frame::{Frame, GAP, MOST_TICKS, TEXT_SIZE, text_width};
use super::page::{Anchor, Page};
use super::ticks::{Ticks, Unit, significant};
use crate::output::colour::{ColourScale, INK};

/// Width of the colour bar [pixels].
pub(super) const BAR_WIDTH: i32 = 36;
/// Distance between the colour bar's ticks [pixels].
const BAR_TICKS_APART: i32 = 60;

/// The bar of colours at the right of the plot, as high as the plot.
pub(super) struct ColourBar {
    pub scale: ColourScale,
    pub unit: Unit,
}

impl ColourBar {
    pub fn new(scale: ColourScale, si_unit: &str) -> ColourBar {
        let unit = Unit::prefixed(si_unit, scale.min.abs().max(scale.max.abs()));
        ColourBar { scale, unit }
    }

    /// Numbers beside a bar of so many pixels, with their values [SI].
    pub fn ticks(&self, height: i32) -> Vec<(f64, String)> {
        let [min, max] = [self.scale.min, self.scale.max].map(|value| value * self.unit.per_si);
        if self.scale.is_constant() {
            return vec![(self.scale.min, significant(min, 4))];
        }
        let ticks = Ticks::within(
            min,
            max,
            (height / BAR_TICKS_APART).min(MOST_TICKS) as usize,
        );
        let labelled = |value: f64| (value / self.unit.per_si, ticks.label(value));
        ticks.values().map(labelled).collect()
    }

    /// Width of the bar and its numbers, for any height of the plot [pixels].
    pub fn width(&self) -> i32 {
        let labels = (3..=MOST_TICKS).flat_map(|count| self.ticks(count * BAR_TICKS_APART));
        let widest = labels
            .map(|(_, label)| text_width(&label))
            .max()
            .unwrap_or(0);
        2 * GAP + BAR_WIDTH + GAP + widest + 2 * GAP
    }

    /// Width of the text above the bar, with its margin [pixels].
    pub fn head_width(&self, quantity: &str) -> i32 {
        text_width(&self.unit.label(quantity)) + 2 * GAP
    }

    /// `value` [SI] with four digits and the bar's unit.
    pub fn with_unit(&self, value: f64) -> String {
        let number = significant(value * self.unit.per_si, 4);
        format!("{number} {}", self.unit.name).trim_end().to_owned()
    }

    pub fn draw(&self, page: &mut Page, frame: &Frame, quantity: &str) {
        let [_, top, right, bottom] = frame.plot;
        let left = right + 2 * GAP;
        let height = f64::from(bottom - top);
        let range = self.scale.max - self.scale.min;
        for y in top..bottom {
            let share = (f64::from(bottom - y) - 0.5) / height;
            let colour = self.scale.colour(self.scale.min + share * range);
            // Overlapping, so that no seam shows at another size.
            let end = (y + 2).min(bottom);
            page.fill_box([left, y, left + BAR_WIDTH, end], colour);
        }
        page.draw_box([left - 1, top - 1, left + BAR_WIDTH, bottom], INK);
        for (value, label) in self.ticks(bottom - top) {
            let share = if self.scale.is_constant() {
                0.5
            } else {
                (value - self.scale.min) / range
            };
            let y = bottom - (share * height).round() as i32;
            let end = left + BAR_WIDTH;
            page.fill_box([end, y - 1, end + GAP / 2, y + 2], INK);
            page.draw_text(&label, [end + GAP, y], Anchor::Left);
        }
        let head = [frame.page[0] - GAP, top - GAP - TEXT_SIZE / 2];
        page.draw_symbol(&self.unit.label(quantity), head, Anchor::Right);
    }
}
