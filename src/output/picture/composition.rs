//! A picture before it is pixels, SVG or PDF: the plot's content and the page around it.

use super::frame::Frame;
use super::page::{Page, Pixels};
use super::raster::Raster;
use super::shape::Shape;
use super::{Picture, PictureError, pdf, svg};
use crate::output::colour::{Rgb, WHITE};

/// Draws the part of a plot that stays pixels in any form.
pub(super) type Content = Box<dyn Fn(&mut Raster) + Send + Sync>;

/// Width of the thinnest line of a small picture [pixels of it].
const THINNEST: f64 = 0.8;

/// A picture's elements with their positions on the page.
pub struct Composition {
    pub(super) frame: Frame,
    pub(super) content: Option<Content>,
    /// Lines and polygons drawn over the content.
    pub(super) shapes: Vec<Shape>,
    pub(super) page: Page,
}

impl Composition {
    pub fn picture(&self) -> Picture {
        self.zoomed(1.0)
    }

    /// The picture with `zoom` pixels for one.
    pub fn zoomed(&self, zoom: f64) -> Picture {
        let frame = self.frame.zoomed(zoom);
        let thinnest = if zoom < 1.0 { THINNEST / zoom } else { 0.0 };
        let plot = frame.paint(zoom, |plot| {
            if let Some(content) = &self.content {
                content(plot);
            }
            for shape in &self.shapes {
                shape.paint(thinnest, plot);
            }
        });
        let [page_width, left, top] =
            [frame.page[0], frame.plot[0], frame.plot[1]].map(|p| p as usize);
        let mut rgb = vec![WHITE[0]; 3 * page_width * frame.page[1] as usize];
        for (row, pixels) in plot.chunks_exact(frame.plot_width() as usize).enumerate() {
            let start = 3 * ((top + row) * page_width + left);
            rgb[start..start + 3 * pixels.len()].copy_from_slice(pixels.as_flattened());
        }
        let mut pixels = Pixels {
            width: frame.page[0],
            zoom,
            rgb: &mut rgb,
        };
        pixels.draw(&self.page);
        Picture { frame, rgb }
    }

    /// An SVG file's content.
    ///
    /// # Errors
    /// Pixels that cannot be encoded.
    pub fn svg(&self) -> Result<String, PictureError> {
        svg::svg(self)
    }

    /// A PDF file's content.
    pub fn pdf(&self) -> Vec<u8> {
        pdf::pdf(self)
    }

    /// The pixels below the shapes.
    pub(super) fn content(&self) -> Option<Vec<Rgb>> {
        let content = self.content.as_ref()?;
        Some(self.frame.paint(1.0, content))
    }

    /// Width and height [pixels].
    pub fn size(&self) -> [u32; 2] {
        self.frame.page.map(|length| length as u32)
    }

    /// Position on the page [pixels] of a position of the body [m], or of a point of a chart.
    pub fn place_of(&self, position: [f64; 2]) -> [f64; 2] {
        self.frame.to_page(position)
    }
}
