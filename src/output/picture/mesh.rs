//! The mesh with its regions: what is finite elements, what is material points, and where they
//! meet.

mod colouring;

use super::frame::{Bounds, Frame, GAP, Margins, shortened, text_width, title_height, title_width};
use super::legend::{self, Key, Sign, in_rows};
use super::page::Page;
use super::raster::Raster;
use super::shape::Shape;
use super::ticks::grouped;
use super::{Composition, Picture, PictureError, check_finite, square};
use crate::output::colour::{
    CELL_EDGE, INK, INTERFACE, REGION_COLOURS, Rgb, cell_fill, point_fill, tint,
};
use colouring::colour_indices;

/// The discretisation of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    Cells,
    Points,
}

/// A part of the body with one colour and one line in the legend.
#[derive(Clone, Debug)]
pub struct Region {
    /// Name in the legend, shortened where it is long.
    pub name: String,
    /// The model, as the reader calls it.
    pub model: String,
    pub filling: Filling,
    /// Number of its cells or material points.
    pub count: usize,
}

/// A cell, or the part of a material point's square that lies in its region.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Corners [m]; see [`super::outline`] for cells.
    pub outline: Vec<[f64; 2]>,
    /// Index into [`MeshPicture::regions`].
    pub region: usize,
}

/// A material point.
#[derive(Clone, Copy, Debug)]
pub struct Dot {
    /// [m]
    pub centre: [f64; 2],
    /// The first side of its square, as a vector: turned where the lattice is [m].
    pub side: [f64; 2],
    /// Whether the whole square is its own; else [`MeshPicture::pieces`] hold its part.
    pub is_whole: bool,
    /// Index into [`MeshPicture::regions`].
    pub region: usize,
}

/// Regions with their cells and material points, interfaces and cracks.
#[derive(Clone, Debug, Default)]
pub struct MeshPicture {
    pub title: String,
    pub regions: Vec<Region>,
    /// Pairs of `regions` that touch, which get different colours.
    pub neighbours: Vec<[usize; 2]>,
    pub cells: Vec<Patch>,
    pub points: Vec<Dot>,
    /// Parts of the points' squares that the outline of a region cuts.
    pub pieces: Vec<Patch>,
    /// Interfaces of regions, drawn strongly; see [`crate::geometry::chords_of`] [m].
    pub interfaces: Vec<Vec<[f64; 2]>>,
    /// Initial cracks, drawn strongest [m].
    pub cracks: Vec<Vec<[f64; 2]>>,
}

/// Width of an interface's line [pixels].
const INTERFACE_WIDTH: f64 = 3.0;
/// Width of a crack's line [pixels].
const CRACK_WIDTH: f64 = 4.0;
/// Below this spacing dots would merge: the squares are filled instead [pixels].
const SMALLEST_DOT_SPACING: f64 = 3.0;
/// Lines of a legend that a reader looks through.
const MOST_KEYS: usize = 12;

impl MeshPicture {
    /// # Errors
    /// See [`PictureError`].
    pub fn draw(&self) -> Result<Picture, PictureError> {
        Ok(self.clone().compose()?.picture())
    }

    /// # Errors
    /// See [`PictureError`].
    pub fn compose(self) -> Result<Composition, PictureError> {
        self.check()?;
        let bounds = Bounds::of(self.positions()).ok_or(PictureError::Empty)?;
        let keys = self.keys(i32::MAX);
        let widest_key = keys.iter().map(Key::width).max().unwrap_or(0);
        let margins = Margins {
            above: title_height(&self.title),
            below: GAP,
            right: 2 * GAP,
            across: widest_key.max(title_width(&self.title)),
        };
        let mut frame = Frame::around(bounds, margins);
        let width = frame.page[0] - frame.plot[0];
        let rows = in_rows(self.keys(width), width);
        frame.extend_below(rows.len() as i32 * legend::ROW);
        let sides = self.sides(&frame);
        let width = edge_width(&sides);
        let mut shapes = Vec::new();
        shapes.extend(sides.iter().map(|side| Shape::Stroke {
            path: side.clone(),
            width,
            colour: CELL_EDGE,
        }));
        shapes.extend(stroked(
            &self.interfaces,
            INTERFACE_WIDTH,
            INTERFACE,
            &frame,
        ));
        shapes.extend(stroked(&self.cracks, CRACK_WIDTH, INK, &frame));
        let mut page = Page::with_axes(&frame);
        page.draw_title(&frame, &self.title);
        legend::draw(&mut page, &frame, &rows);
        let placed = frame.clone();
        Ok(Composition {
            frame,
            content: Some(Box::new(move |plot| {
                self.fill_cells(&sides, plot);
                self.draw_points(&placed, plot);
            })),
            shapes,
            page,
        })
    }
}

/// The content of the plot.
impl MeshPicture {
    fn positions(&self) -> impl Iterator<Item = [f64; 2]> {
        let cells = self
            .cells
            .iter()
            .flat_map(|cell| cell.outline.iter().copied());
        let whole = self.points.iter().filter(|dot| dot.is_whole);
        let points = whole.flat_map(|dot| square(dot.centre, dot.side));
        let pieces = self.pieces.iter().flat_map(|piece| &piece.outline).copied();
        let lines = self
            .interfaces
            .iter()
            .chain(&self.cracks)
            .flatten()
            .copied();
        cells.chain(points).chain(pieces).chain(lines)
    }

    fn check(&self) -> Result<(), PictureError> {
        check_finite(self.positions().flatten())?;
        let regions = self.regions.len();
        let cells = self.cells.iter().map(|cell| cell.region);
        let points = self.points.iter().map(|dot| dot.region);
        let pieces = self.pieces.iter().map(|piece| piece.region);
        match cells
            .chain(points)
            .chain(pieces)
            .find(|&region| region >= regions)
        {
            Some(region) => Err(PictureError::RegionMissing { region, regions }),
            None => Ok(()),
        }
    }

    /// One colour per region, of the palette of its filling.
    fn colours(&self) -> Vec<Rgb> {
        let mut colours = vec![INK; self.regions.len()];
        for (filling, fill) in [
            (Filling::Cells, cell_fill as fn(usize) -> Rgb),
            (Filling::Points, point_fill),
        ] {
            let members: Vec<usize> = (0..self.regions.len())
                .filter(|&region| self.regions[region].filling == filling)
                .collect();
            let place = |region: usize| members.binary_search(&region).ok();
            let neighbours = self.neighbours.iter();
            let neighbours: Vec<[usize; 2]> = neighbours
                .filter_map(|&[a, b]| Some([place(a)?, place(b)?]))
                .collect();
            let indices = colour_indices(members.len(), &neighbours, REGION_COLOURS);
            for (&region, index) in members.iter().zip(indices) {
                colours[region] = fill(index);
            }
        }
        colours
    }

    /// The cells' closed outlines in the plot.
    fn sides(&self, frame: &Frame) -> Vec<Vec<[f64; 2]>> {
        let side = |cell: &Patch| {
            let corners = cell.outline.iter().chain(cell.outline.first());
            corners.map(|&x| frame.to_plot(x)).collect()
        };
        self.cells.iter().map(side).collect()
    }

    fn fill_cells(&self, sides: &[Vec<[f64; 2]>], plot: &mut Raster) {
        let colours = self.colours();
        for (cell, side) in self.cells.iter().zip(sides) {
            plot.fill(&side[..cell.outline.len()], colours[cell.region]);
        }
    }

    fn draw_points(&self, frame: &Frame, plot: &mut Raster) {
        let colours = self.colours();
        let spacing = |dot: &Dot| {
            let [x, y] = frame.along_plot(dot.side);
            x.hypot(y)
        };
        let closest = self
            .points
            .iter()
            .map(spacing)
            .fold(f64::INFINITY, f64::min);
        let opacity = match closest < SMALLEST_DOT_SPACING {
            true => DENSE_TINT,
            false => LIGHT_TINT,
        };
        for piece in &self.pieces {
            let corners: Vec<[f64; 2]> = piece.outline.iter().map(|&x| frame.to_plot(x)).collect();
            plot.fill(&corners, tint(colours[piece.region], opacity));
        }
        for dot in &self.points {
            let colour = colours[dot.region];
            let side = frame.along_plot(dot.side);
            let centre = frame.to_plot(dot.centre);
            let is_dense = side[0].hypot(side[1]) < SMALLEST_DOT_SPACING;
            if dot.is_whole {
                let opacity = if is_dense { DENSE_TINT } else { LIGHT_TINT };
                plot.fill(&square(centre, side), tint(colour, opacity));
            }
            if !is_dense {
                plot.fill(&square(centre, side.map(|x| x * DOT_SHARE)), colour);
            }
        }
    }
}

/// Opacity of the squares where dots would merge.
const DENSE_TINT: f64 = 0.7;
/// Opacity of the squares under the dots.
pub(super) const LIGHT_TINT: f64 = 0.3;
/// Side of a dot in shares of the spacing.
const DOT_SHARE: f64 = 0.5;

/// Width of the thinnest line [pixels].
const THIN: f64 = 1.0 / 3.0;

/// Width of the cells' sides [pixels]: thinner the smaller the cells, so that fills stay visible.
fn edge_width(cells: &[Vec<[f64; 2]>]) -> f64 {
    let mut sizes: Vec<f64> = cells
        .iter()
        .filter_map(|corners| Bounds::of(corners.iter().copied()))
        .map(|Bounds { min, max }| (max[0] - min[0]).min(max[1] - min[1]))
        .collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or_default();
    (median / 12.0).clamp(THIN, 1.0)
}

fn stroked(
    paths: &[Vec<[f64; 2]>],
    width: f64,
    colour: Rgb,
    frame: &Frame,
) -> impl Iterator<Item = Shape> {
    paths.iter().map(move |path| Shape::Stroke {
        path: path.iter().map(|&x| frame.to_plot(x)).collect(),
        width,
        colour,
    })
}

impl MeshPicture {
    /// The legend: at most [`MOST_KEYS`] lines, none wider than `width` [pixels].
    fn keys(&self, width: i32) -> Vec<Key> {
        let lines = [
            (&self.interfaces, "interface", INTERFACE, INTERFACE_WIDTH),
            (&self.cracks, "crack", INK, CRACK_WIDTH),
        ];
        let line = |(_, text, colour, width): (_, &str, Rgb, f64)| Key {
            sign: Sign::Line(colour, width),
            text: text.to_owned(),
        };
        let lines = lines.into_iter().filter(|(paths, ..)| !paths.is_empty());
        let lines: Vec<Key> = lines.map(line).collect();
        let regions = self.regions.len();
        let shown = match regions + lines.len() {
            all if all <= MOST_KEYS => regions,
            _ => MOST_KEYS - lines.len() - 1,
        };
        let described = self.regions[..shown].iter().zip(self.colours());
        let rest = (shown < regions).then(|| Key {
            sign: Sign::None,
            text: format!("and {} more", regions - shown),
        });
        let keys = described.map(|(region, colour)| region_key(region, colour, width));
        keys.chain(rest).chain(lines).collect()
    }
}

fn region_key(region: &Region, colour: Rgb, width: i32) -> Key {
    let (sign, things) = match region.filling {
        Filling::Cells => (Sign::Cells(colour), "cells"),
        Filling::Points => (Sign::Points(colour), "points"),
    };
    let described = format!(": {}, {} {things}", region.model, grouped(region.count));
    let taken = legend::ROW + text_width(&described);
    let name = shortened(&region.name, width - taken, text_width);
    let text = name + &described;
    Key { sign, text }
}

#[cfg(test)]
mod tests;
