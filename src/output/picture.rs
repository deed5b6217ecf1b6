//! Pictures of a mesh, of a field on it and of a run's course, as PNG, SVG and PDF.
//!
//! [`mesh::MeshPicture`] shows the regions with their cells, material points and interfaces;
//! [`field::FieldPicture`] a scalar over both. They take polygons and squares in metres and know
//! nothing of elements: [`outline`] and [`facets`] make polygons of cells.
//! [`chart::Chart`] shows numbers over one another.

pub mod chart;
pub mod field;
pub mod mesh;

mod colour_bar;
mod composition;
mod frame;
mod labels;
mod legend;
mod page;
mod pdf;
mod raster;
mod shape;
mod svg;
mod text;
mod ticks;

use super::colour::Rgb;
use super::{WriteError, write_whole};
use crate::geometry::chords_of;
use crate::mesh::{Cell, CellKind};
use frame::Frame;
use std::path::Path;

pub use chart::{Axis, Chart, Curve, Mark};
pub use composition::Composition;
pub use field::{Facet, FieldPicture, Piece, Square};
pub use mesh::{Dot, Filling, MeshPicture, Patch, Region};

/// A finished picture.
#[derive(Clone, Debug)]
pub struct Picture {
    frame: Frame,
    rgb: Vec<u8>,
}

impl Picture {
    /// Width and height [pixels].
    pub fn size(&self) -> [u32; 2] {
        self.frame.page.map(|length| length as u32)
    }

    /// The colour of the pixel in `column` and `row`, from the top left.
    pub fn pixel(&self, column: u32, row: u32) -> Rgb {
        let start = 3 * (row * self.size()[0] + column) as usize;
        [0, 1, 2].map(|channel| self.rgb[start + channel])
    }

    /// The colour at a position of the body [m], or at a point of a chart [SI].
    pub fn colour_at(&self, position: [f64; 2]) -> Rgb {
        let [x, y] = self.frame.to_page(position);
        self.pixel(x as u32, y as u32)
    }

    /// The pixels, row by row.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Writes the picture to `path` (`….png`).
    pub fn write(&self, path: &Path) -> Result<(), PictureError> {
        Ok(write_whole(path, &self.to_png()?)?)
    }

    /// The file's content.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        png_bytes(self.size(), &self.rgb)
    }
}

/// A PNG file of pixels, row by row.
fn png_bytes([width, height]: [u32; 2], rgb: &[u8]) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(rgb))
        .map_err(|source| PictureError::Encoding { source })?;
    Ok(bytes)
}

/// The corners of a polygon along the sides of a cell whose nodes lie at `position` [m].
pub fn outline(cell: &Cell, position: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
    let mut corners = Vec::new();
    for edge in cell.edges() {
        corners.extend(chords_of(&edge, &position));
        corners.pop();
    }
    corners
}

/// A cell as small triangles, each side in `divisions`. `at` gives position [m] and value at a
/// point of the reference cell: the square -1…1 × -1…1, or the triangle (0, 0), (1, 0), (0, 1).
pub fn facets(
    kind: CellKind,
    divisions: usize,
    at: impl Fn([f64; 2]) -> ([f64; 2], f64),
) -> Vec<Facet> {
    let is_triangle = kind.corner_count() == 3;
    let sample = |i: usize, j: usize| {
        let [s, t] = [i, j].map(|k| k as f64 / divisions as f64);
        at(if is_triangle {
            [s, t]
        } else {
            [2.0 * s - 1.0, 2.0 * t - 1.0]
        })
    };
    let facet = |nodes: [(usize, usize); 3]| {
        let samples = nodes.map(|(i, j)| sample(i, j));
        Facet {
            corners: samples.map(|(position, _)| position),
            values: samples.map(|(_, value)| value),
        }
    };
    let mut facets = Vec::new();
    for i in 0..divisions {
        let rows = if is_triangle {
            divisions - i
        } else {
            divisions
        };
        for j in 0..rows {
            facets.push(facet([(i, j), (i + 1, j), (i, j + 1)]));
            if !is_triangle || j + 1 < rows {
                facets.push(facet([(i + 1, j), (i + 1, j + 1), (i, j + 1)]));
            }
        }
    }
    facets
}

/// The corners of a square, one of whose sides is the vector `side`.
fn square([x, y]: [f64; 2], side: [f64; 2]) -> [[f64; 2]; 4] {
    let [a, b] = side.map(|length| length / 2.0);
    [
        [-a + b, -b - a],
        [a + b, b - a],
        [a - b, b + a],
        [-a - b, a - b],
    ]
    .map(|[dx, dy]| [x + dx, y + dy])
}

/// The first number that is NaN or infinite, if any.
fn check_finite(mut numbers: impl Iterator<Item = f64>) -> Result<(), PictureError> {
    match numbers.find(|number| !number.is_finite()) {
        Some(value) => Err(PictureError::NotFinite { value }),
        None => Ok(()),
    }
}

/// Why a picture was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("there is nothing to draw")]
    Empty,
    #[error("a position or value of the picture is {value}")]
    NotFinite { value: f64 },
    #[error("region {region} is drawn, but only {regions} are described")]
    RegionMissing { region: usize, regions: usize },
    #[error("cannot encode the picture as PNG")]
    Encoding { source: png::EncodingError },
    #[error(transparent)]
    Write(#[from] WriteError),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cell;

    /// A unit square, or its lower left half, with one side bent outwards.
    fn nodes(kind: CellKind) -> Vec<[f64; 2]> {
        let corners: &[[f64; 2]] = match kind.corner_count() {
            3 => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            _ => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        };
        let mut nodes = corners.to_vec();
        if kind.is_quadratic() {
            for side in 0..corners.len() {
                let [a, b] = [corners[side], corners[(side + 1) % corners.len()]];
                nodes.push([0, 1].map(|k| (a[k] + b[k]) / 2.0));
            }
            nodes[corners.len()][1] -= 0.25;
        }
        nodes
    }

    fn area(corners: &[[f64; 2]]) -> f64 {
        let next = corners.iter().cycle().skip(1);
        let doubled = corners
            .iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
        doubled.sum::<f64>() / 2.0
    }

    #[test]
    fn an_outline_follows_bent_sides() {
        for kind in CellKind::ALL {
            let nodes = nodes(kind);
            let cell = Cell::new(kind, &(0..nodes.len()).collect::<Vec<_>>());
            let straight = if kind.corner_count() == 3 { 0.5 } else { 1.0 };
            // Below a parabola of height 1/4 lies 1/6; eight chords cut off 1/64 of it.
            let bent = if kind.is_quadratic() {
                63.0 / 64.0 / 6.0
            } else {
                0.0
            };
            let found = area(&outline(&cell, |node| nodes[node]));
            assert!((found - straight - bent).abs() < 1e-12, "{kind:?}: {found}");
        }
    }

    #[test]
    fn facets_fill_the_cell_and_carry_the_field() {
        for kind in CellKind::ALL {
            let is_triangle = kind.corner_count() == 3;
            let whole = if is_triangle { 0.5 } else { 4.0 };
            let facets = facets(kind, 4, |at| (at, at[0] + 2.0 * at[1]));
            assert_eq!(facets.len(), if is_triangle { 16 } else { 32 });
            let areas = facets.iter().map(|facet| area(&facet.corners));
            assert!(areas.clone().all(|area| area > 0.0));
            assert!((areas.sum::<f64>() - whole).abs() < 1e-12);
            for facet in facets {
                let expected = facet.corners.map(|[x, y]| x + 2.0 * y);
                assert_eq!(facet.values, expected);
            }
        }
    }

    #[test]
    fn a_png_holds_the_pixels() {
        let picture = FieldPicture {
            title: "png".to_owned(),
            squares: vec![Square {
                centre: [0.0, 0.0],
                side: [1.0, 0.0],
                value: 1.0,
            }],
            ..FieldPicture::default()
        };
        let picture = picture.draw().expect("a square");
        let bytes = picture.to_png().expect("encodable");
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().expect("a PNG");
        let mut rgb = vec![0; picture.rgb.len()];
        let info = reader.next_frame(&mut rgb).expect("an image");
        assert_eq!([info.width, info.height], picture.size());
        assert!(rgb == picture.rgb);
    }
}
