//! A scalar field over cells and material points, with a colour bar.

use super::colour_bar::ColourBar;
use super::frame::{
    Bounds, Frame, GAP, Margins, TEXT_SIZE, shortened, text_width, title_height, title_width,
};
use super::page::{Anchor, Page};
use super::raster::Raster;
use super::shape::Shape;
use super::{Composition, Picture, PictureError, check_finite, square};
use crate::output::colour::{CELL_EDGE, ColourScale, INK, Rgb};

/// A small triangle of a cell, the field linear on it; see [`super::facets`].
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// [m]
    pub corners: [[f64; 2]; 3],
    /// [unit of the field]
    pub values: [f64; 3],
}

/// A material point, the field constant on it.
#[derive(Clone, Copy, Debug)]
pub struct Square {
    /// [m]
    pub centre: [f64; 2],
    /// The first side of its square, as a vector: turned where the lattice is [m].
    pub side: [f64; 2],
    /// [unit of the field]
    pub value: f64,
}

/// A part of a material point's square, cut by the outline of its region.
#[derive(Clone, Debug)]
pub struct Piece {
    /// [m]
    pub corners: Vec<[f64; 2]>,
    /// [unit of the field]
    pub value: f64,
}

/// A scalar field on cells and material points. For the deformed shape, give displaced positions.
#[derive(Clone, Debug, Default)]
pub struct FieldPicture {
    pub title: String,
    /// Symbol or name on the colour bar; `_` begins a subscript, as in `σ_xx`.
    pub quantity: String,
    /// SI unit of the values, to which a prefix is added; empty for a share.
    pub unit: String,
    /// Ends of the colour bar [unit of the field], so that several pictures compare; `None`: the
    /// field's own.
    pub range: Option<[f64; 2]>,
    /// Without a `range`: ends of the colour bar as percentiles of the values, from 0 to 100.
    pub percentiles: Option<[f64; 2]>,
    /// Positions that must be in view as well [m].
    pub in_view: Vec<[f64; 2]>,
    /// Whether the sign matters: a field of both signs then has the diverging map, white at zero.
    pub is_signed: bool,
    /// The factor by which displacements were exaggerated, to be told below the title.
    pub deformation_scale: Option<f64>,
    pub facets: Vec<Facet>,
    pub squares: Vec<Square>,
    pub pieces: Vec<Piece>,
    /// Sides of cells, drawn thinly; see [`crate::geometry::chords_of`] [m].
    pub cells: Vec<Vec<[f64; 2]>>,
    /// Interfaces, drawn strongly [m].
    pub lines: Vec<Vec<[f64; 2]>>,
}

/// Width of the cells' sides, and of the other lines [pixels].
const CELL_WIDTH: f64 = 1.0;
const LINE_WIDTH: f64 = 2.0;
/// Squares are drawn larger than they are by this much [pixels]: on a deformed shape hair-wide gaps between
/// points would make a pattern of lines.
const OVERLAP: f64 = 1.0;

impl FieldPicture {
    /// # Errors
    /// See [`PictureError`].
    pub fn draw(&self) -> Result<Picture, PictureError> {
        Ok(self.clone().compose()?.picture())
    }

    /// # Errors
    /// See [`PictureError`].
    pub fn compose(self) -> Result<Composition, PictureError> {
        self.composed(None)
    }

    /// On a page like another one's, so that both can follow one another.
    ///
    /// # Errors
    /// See [`PictureError`].
    pub fn compose_like(self, other: &Composition) -> Result<Composition, PictureError> {
        self.composed(Some(other.frame.clone()))
    }

    fn composed(self, frame: Option<Frame>) -> Result<Composition, PictureError> {
        check_finite(self.positions().flatten().chain(self.values()))?;
        let bounds = Bounds::of(self.positions()).ok_or(PictureError::Empty)?;
        let own = ColourScale::of(self.values());
        let scale = match (self.range, self.percentiles) {
            (Some(range), _) => ColourScale::of(range.into_iter()),
            (None, Some(ends)) => ColourScale::of(percentiles(self.values(), ends).into_iter()),
            (None, None) => own.clone(),
        };
        let scale = if self.is_signed {
            scale.signed()
        } else {
            scale
        };
        let bar = ColourBar::new(scale, &self.unit);
        let note = self.note(&own, &bar);
        let margins = Margins {
            above: title_height(&self.title) + TEXT_SIZE + GAP,
            below: GAP,
            right: bar.width(),
            across: title_width(&self.title)
                .max(text_width(&note) + bar.head_width(&self.quantity)),
        };
        let frame = frame.unwrap_or_else(|| Frame::around(bounds, margins));
        let mut page = Page::with_axes(&frame);
        self.describe(&note, &bar, &frame, &mut page);
        let stroked = |paths: &[Vec<[f64; 2]>], width: f64, colour: Rgb| -> Vec<Shape> {
            let stroke = |path: &Vec<[f64; 2]>| Shape::Stroke {
                path: path.iter().map(|&x| frame.to_plot(x)).collect(),
                width,
                colour,
            };
            paths.iter().map(stroke).collect()
        };
        let mut shapes = stroked(&self.cells, CELL_WIDTH, CELL_EDGE);
        shapes.extend(stroked(&self.lines, LINE_WIDTH, INK));
        let placed = frame.clone();
        Ok(Composition {
            frame,
            content: Some(Box::new(move |plot| self.fill(&placed, &bar.scale, plot))),
            shapes,
            page,
        })
    }

    /// Title, note and colour bar.
    fn describe(&self, note: &str, bar: &ColourBar, frame: &Frame, page: &mut Page) {
        let width = frame.page[0] - frame.plot[0] - GAP;
        page.draw_title(frame, &shortened(&self.title, width, title_width));
        let at = [frame.plot[0], title_height(&self.title) + TEXT_SIZE / 2];
        let note = shortened(
            note,
            width + GAP - bar.head_width(&self.quantity),
            text_width,
        );
        page.draw_text(&note, at, Anchor::Left);
        bar.draw(page, frame, &self.quantity);
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let facets = self.facets.iter().flat_map(|facet| facet.values);
        let pieces = self.pieces.iter().map(|piece| piece.value);
        let squares = self.squares.iter().map(|square| square.value);
        facets.chain(squares).chain(pieces)
    }

    fn positions(&self) -> impl Iterator<Item = [f64; 2]> {
        let facets = self.facets.iter().flat_map(|facet| facet.corners);
        let squares = self.squares.iter().flat_map(|s| square(s.centre, s.side));
        let lines = self.cells.iter().chain(&self.lines).flatten().copied();
        let in_view = self.in_view.iter().copied();
        let pieces = self.pieces.iter().flat_map(|piece| &piece.corners).copied();
        facets
            .chain(squares)
            .chain(pieces)
            .chain(lines)
            .chain(in_view)
    }

    fn fill(&self, frame: &Frame, scale: &ColourScale, plot: &mut Raster) {
        for facet in &self.facets {
            let corners = facet.corners.map(|corner| frame.to_plot(corner));
            plot.fill_between(corners, facet.values, |value| scale.colour(value));
        }
        for Square {
            centre,
            side,
            value,
        } in &self.squares
        {
            let side = enlarged(frame.along_plot(*side), OVERLAP);
            let corners = square(frame.to_plot(*centre), side);
            plot.fill(&corners, scale.colour(*value));
        }
        for Piece { corners, value } in &self.pieces {
            let corners: Vec<[f64; 2]> = corners.iter().map(|&x| frame.to_plot(x)).collect();
            let colour = scale.colour(*value);
            plot.fill(&corners, colour);
            if let Some(&first) = corners.first() {
                let rim = [corners, vec![first]].concat();
                plot.trace(&rim, OVERLAP, colour);
            }
        }
    }

    /// The line below the title: the field's range and the exaggeration.
    fn note(&self, own: &ColourScale, bar: &ColourBar) -> String {
        let [min, max] = [own.min, own.max].map(|v| bar.with_unit(v));
        let mut note = if own.is_constant() {
            format!("constant {min}")
        } else {
            format!("min {min},  max {max}")
        };
        if let Some(scale) = self.deformation_scale {
            note.push_str(&format!(",  u × {}", scale));
        }
        note
    }
}

/// The values below which so many percent of all lie.
fn percentiles(values: impl Iterator<Item = f64>, ends: [f64; 2]) -> [f64; 2] {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1) as f64;
    ends.map(|end| {
        let place = (end / 100.0 * last).round() as usize;
        sorted.get(place).copied().unwrap_or_default()
    })
}

/// The vector `side`, made longer by `length`.
fn enlarged(side: [f64; 2], length: f64) -> [f64; 2] {
    let factor = 1.0 + length / side[0].hypot(side[1]);
    side.map(|component| component * factor)
}

/// The factor that makes the largest of `displacements` [m] a twentieth of `extent`, the body's
/// larger side [m], rounded down to 1, 2 or 5 times a power of ten.
pub fn deformation_scale(
    extent: f64,
    displacements: impl Iterator<Item = [f64; 2]>,
) -> Option<f64> {
    let largest = displacements.map(|[x, y]| x.hypot(y)).fold(0.0, f64::max);
    let exact = extent / 20.0 / largest;
    if !(exact.is_finite() && exact > 0.0) {
        return None;
    }
    let decade = 10_f64.powf(exact.log10().floor());
    let rounded = [5.0, 2.0].map(|multiple| multiple * decade);
    Some(
        rounded
            .into_iter()
            .find(|&scale| scale <= exact)
            .unwrap_or(decade),
    )
}

#[cfg(test)]
mod tests;
