//! The marked points of a chart and the texts beside them.

use super::super::frame::Frame;
use super::super::labels::{Place, leader};
use super::super::page::{Anchor, Page};
use super::super::shape::Shape;
use crate::output::colour::{WHITE, ZERO};

/// A point of a curve that is shown as a disc with a text beside it.
#[derive(Clone, Debug)]
pub struct Mark {
    /// [SI units of the axes]
    pub at: [f64; 2],
    pub label: String,
}

const LEADER_WIDTH: f64 = 2.0;

/// The text beside a mark.
pub(super) struct Label {
    pub text: String,
    /// Position of the mark [pixels of the plot].
    pub at: [f64; 2],
    pub place: Place,
}

impl Label {
    /// A white box that hides the grid, which would strike the text through.
    pub fn clearing(&self) -> Shape {
        let [l, t, r, b] = self.place.map(f64::from);
        Shape::Fill {
            corners: vec![[l, t], [r, t], [r, b], [l, b]],
            colour: WHITE,
        }
    }

    /// The line from the mark to a text that stands apart from it.
    pub fn lead(&self) -> Option<Shape> {
        Some(Shape::Trace {
            path: leader(self.place, self.at)?.to_vec(),
            width: LEADER_WIDTH,
            colour: ZERO,
        })
    }

    pub fn write(&self, page: &mut Page, frame: &Frame) {
        let [left, top, _, bottom] = self.place;
        let at = [frame.plot[0] + left, frame.plot[1] + (top + bottom) / 2];
        page.draw_text(&self.text, at, Anchor::Left);
    }
}
