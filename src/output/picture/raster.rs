//! Filled polygons and strokes on a grid of pixels.
//!
//! Each pixel has 3 × 3 samples, and a sample belongs to the polygon that holds its centre. So
//! neighbouring polygons leave no seam, as smoothing each polygon by itself would, and outlines
//! come out smooth when the samples of a pixel are averaged.
//!
//! A picture is painted in bands of rows, each from the whole of what is to be drawn: the samples of a
//! band fit the cache, those of a picture would take fifty megabytes.

use crate::output::colour::{Rgb, WHITE};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Samples per pixel and direction.
const SAMPLES: usize = 3;

/// Vertices are rounded to this share of a sample, so that a vertex computed in two ways, once by
/// each neighbour, is one vertex.
const GRID: f64 = 1.0 / 256.0;

/// Corners of the polygon that is drawn for a circle.
const DISC_CORNERS: usize = 32;

/// Rows of pixels that are painted at a time.
const BAND: usize = 48;

/// The pixels of what `draw` draws on white, row by row; `size` in pixels, of which there are `zoom` to
/// one of the positions and widths that are drawn.
pub(super) fn paint(
    [width, height]: [usize; 2],
    zoom: f64,
    draw: impl Fn(&mut Raster) + Sync,
) -> Vec<Rgb> {
    let mut pixels = vec![WHITE; width * height];
    let bands = pixels.par_chunks_mut((BAND * width).max(1)).enumerate();
    bands.for_each(|(band, pixels)| {
        let first = BAND * band;
        let mut raster = Raster::new(width, first..(first + BAND).min(height));
        raster.per_pixel *= zoom;
        draw(&mut raster);
        raster.average(pixels);
    });
    pixels
}

/// Some rows of a picture under construction; what lies outside of them is cut. Positions are in
/// pixels of the whole picture, y downwards.
pub(super) struct Raster {
    /// [samples]
    width: usize,
    /// [samples]
    rows: Range<usize>,
    /// Samples in the unit of positions.
    per_pixel: f64,
    samples: Vec<Rgb>,
}

impl Raster {
    /// White; all in pixels.
    pub fn new(width: usize, rows: Range<usize>) -> Raster {
        let (width, rows) = (width * SAMPLES, SAMPLES * rows.start..SAMPLES * rows.end);
        Raster {
            width,
            samples: vec![WHITE; width * rows.len()],
            rows,
            per_pixel: SAMPLES as f64,
        }
    }

    /// Whether a shape between these heights [pixels], or one that is shifted by a pixel, leaves no trace.
    fn misses(&self, heights: impl Iterator<Item = f64> + Clone) -> bool {
        let [above, below] =
            [self.rows.start, self.rows.end].map(|row| row as f64 / self.per_pixel);
        heights.clone().all(|y| y < above - 1.0) || heights.clone().all(|y| y > below + 1.0)
    }

    /// Fills a polygon, convex or not, by the even-odd rule.
    pub fn fill(&mut self, corners: &[[f64; 2]], colour: Rgb) {
        if self.misses(corners.iter().map(|corner| corner[1])) {
            return;
        }
        let corners: Vec<[f64; 2]> = corners.iter().map(|&at| self.to_grid(at)).collect();
        self.scan(&corners, |_, _| colour);
    }

    /// Fills a triangle, `colour_of` the value interpolated linearly between its corners.
    pub fn fill_between(
        &mut self,
        corners: [[f64; 2]; 3],
        values: [f64; 3],
        colour_of: impl Fn(f64) -> Rgb,
    ) {
        if self.misses(corners.iter().map(|corner| corner[1])) {
            return;
        }
        let [a, b, c] = corners.map(|at| self.to_grid(at));
        let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let doubled_area = ab[0] * ac[1] - ab[1] * ac[0];
        if doubled_area == 0.0 {
            return;
        }
        self.scan(&[a, b, c], |x, y| {
            let (dx, dy) = (x - a[0], y - a[1]);
            let to_b = (dx * ac[1] - dy * ac[0]) / doubled_area;
            let to_c = (ab[0] * dy - ab[1] * dx) / doubled_area;
            colour_of(values[0] + to_b * (values[1] - values[0]) + to_c * (values[2] - values[0]))
        });
    }

    /// Draws a polyline of the given width [pixels]. Segments along an axis are moved by up to half
    /// a pixel onto the pixels, so that the lines of a grid look alike.
    pub fn stroke(&mut self, path: &[[f64; 2]], width: f64, colour: Rgb) {
        for pair in path.windows(2) {
            if self.misses(around(pair, width)) {
                continue;
            }
            let [[x0, y0], [x1, y1]] = on_pixels([pair[0], pair[1]], width);
            let length = (x1 - x0).hypot(y1 - y0);
            if length == 0.0 {
                continue;
            }
            // Half the width along and across; the overhang closes the joints.
            let [tx, ty] = [x1 - x0, y1 - y0].map(|d| d / length * width / 2.0);
            self.fill(
                &[
                    [x0 - tx - ty, y0 - ty + tx],
                    [x1 + tx - ty, y1 + ty + tx],
                    [x1 + tx + ty, y1 + ty - tx],
                    [x0 - tx + ty, y0 - ty - tx],
                ],
                colour,
            );
        }
    }

    /// Draws a polyline of the given width [pixels] where it is, with round joints and ends: for
    /// curves, whose pieces may be shorter than a pixel. A single point becomes a dot.
    pub fn trace(&mut self, path: &[[f64; 2]], width: f64, colour: Rgb) {
        for &corner in path {
            self.fill_disc(corner, width / 2.0, colour);
        }
        for pair in path.windows(2) {
            if self.misses(around(pair, width)) {
                continue;
            }
            let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
            let length = (x1 - x0).hypot(y1 - y0);
            if length == 0.0 {
                continue;
            }
            let [tx, ty] = [x1 - x0, y1 - y0].map(|d| d / length * width / 2.0);
            self.fill(
                &[
                    [x0 - ty, y0 + tx],
                    [x1 - ty, y1 + tx],
                    [x1 + ty, y1 - tx],
                    [x0 + ty, y0 - tx],
                ],
                colour,
            );
        }
    }

    /// Fills a circle [pixels].
    pub fn fill_disc(&mut self, centre: [f64; 2], radius: f64, colour: Rgb) {
        if self.misses([centre[1] - radius, centre[1] + radius].into_iter()) {
            return;
        }
        let angle = |corner: usize| corner as f64 / DISC_CORNERS as f64 * TAU;
        let rim = (0..DISC_CORNERS).map(angle).map(|angle| {
            [
                centre[0] + radius * angle.cos(),
                centre[1] + radius * angle.sin(),
            ]
        });
        self.fill(&rim.collect::<Vec<_>>(), colour);
    }

    /// `position` in samples, rounded to the grid.
    fn to_grid(&self, position: [f64; 2]) -> [f64; 2] {
        position.map(|x| (x * self.per_pixel / GRID).round() * GRID)
    }

    /// Colours every sample whose centre lies in the polygon with corners on the grid; `colour`
    /// gets that centre. All in samples.
    fn scan(&mut self, corners: &[[f64; 2]], colour: impl Fn(f64, f64) -> Rgb) {
        let rows = corners.iter().map(|corner| corner[1]);
        let top = rows.clone().fold(f64::INFINITY, f64::min);
        let bottom = rows.fold(f64::NEG_INFINITY, f64::max);
        let mut crossings: Vec<f64> = Vec::with_capacity(8);
        let Range { start, end } = self.rows;
        let of = |height: f64| first_centre(height, end).max(start);
        for row in of(top)..of(bottom) {
            let y = row as f64 + 0.5;
            crossings.clear();
            crossings.extend(sides(corners).filter_map(|side| crossing(side, y)));
            crossings.sort_by(f64::total_cmp);
            for span in crossings.chunks_exact(2) {
                let columns = first_centre(span[0], self.width)..first_centre(span[1], self.width);
                let line = (row - start) * self.width;
                for column in columns {
                    self.samples[line + column] = colour(column as f64 + 0.5, y);
                }
            }
        }
    }

    /// Each pixel the mean of its samples.
    fn average(&self, pixels: &mut [Rgb]) {
        let rows = self.samples.chunks_exact(self.width * SAMPLES);
        for (row, pixels) in rows.zip(pixels.chunks_exact_mut(self.width / SAMPLES)) {
            let lines: [&[Rgb]; SAMPLES] =
                std::array::from_fn(|line| &row[line * self.width..(line + 1) * self.width]);
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let mut sum = [0_u32; 3];
                for line in lines {
                    for sample in &line[column * SAMPLES..(column + 1) * SAMPLES] {
                        (0..3).for_each(|k| sum[k] += u32::from(sample[k]));
                    }
                }
                let count = (SAMPLES * SAMPLES) as u32;
                *pixel = sum.map(|channel| ((channel + count / 2) / count) as u8);
            }
        }
    }
}

/// Heights above and below a line of `width`.
fn around(line: &[[f64; 2]], width: f64) -> impl Iterator<Item = f64> + Clone {
    let heights = line.iter().map(|corner| corner[1]);
    heights.flat_map(move |y| [y - width, y + width])
}

/// A segment along an axis moved to where a line of `width` covers whole pixels.
fn on_pixels([mut a, mut b]: [[f64; 2]; 2], width: f64) -> [[f64; 2]; 2] {
    let is_odd = width.round().max(1.0) % 2.0 == 1.0;
    for axis in [0, 1] {
        if (a[axis] - b[axis]).abs() < 1e-6 {
            // Lines halfway between two pixels go the same way, whatever their rounding.
            let shift = if is_odd { 0.5 } else { 0.0 };
            let at = (a[axis] - shift + 1e-6).round() + shift;
            (a[axis], b[axis]) = (at, at);
        }
    }
    [a, b]
}

/// Index of the first sample whose centre is not before `position`, within `0..=count`.
fn first_centre(position: f64, count: usize) -> usize {
    (position - 0.5).ceil().clamp(0.0, count as f64) as usize
}

fn sides(corners: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| [a, b])
}

/// Abscissa at which a side crosses the height `y`. Both polygons at a side compute it from the upper end, so
/// that they get the same bits.
fn crossing([a, b]: [[f64; 2]; 2], y: f64) -> Option<f64> {
    let [upper, lower] = if a[1] < b[1] { [a, b] } else { [b, a] };
    let crosses = upper[1] <= y && y < lower[1];
    crosses.then(|| upper[0] + (y - upper[1]) / (lower[1] - upper[1]) * (lower[0] - upper[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Rgb = [0, 0, 0];

    impl Raster {
        fn pixels(&self) -> Vec<Rgb> {
            let mut pixels = vec![BLACK; self.samples.len() / (SAMPLES * SAMPLES)];
            self.average(&mut pixels);
            pixels
        }
    }

    /// Shapes of every kind across the bands' borders, and beside them.
    #[test]
    fn bands_give_what_the_whole_gives() {
        let [width, height] = [70, 4 * BAND + 7];
        let draw = |raster: &mut Raster| {
            let y = |k: usize| (k * 37 % (height + 40)) as f64 - 20.3;
            for k in 0..60 {
                let shade = [4 * k as u8, 90, 200 - 3 * k as u8];
                let x = k as f64;
                raster.fill(&[[x, y(k)], [x + 9.0, y(k) + 3.0], [x, y(k) + 50.0]], shade);
                let corners = [[x, y(k + 1)], [x + 30.0, y(k + 2)], [x + 5.0, y(k + 3)]];
                raster.fill_between(corners, [0.0, 100.0, 255.0], |v| [v as u8; 3]);
                raster.stroke(&[[x, y(k + 4)], [x + 20.0, y(k + 4)]], 1.0, shade);
                raster.stroke(&[[x, y(k + 5)], [x + 20.0, y(k + 6)]], 5.0, shade);
                raster.trace(&[[x, y(k + 7)], [x + 3.0, y(k + 8)]], 3.0, BLACK);
                raster.fill_disc([x, y(k + 9)], 4.0, WHITE);
            }
        };
        let mut whole = Raster::new(width, 0..height);
        draw(&mut whole);
        assert!(paint([width, height], 1.0, draw) == whole.pixels());
    }

    #[test]
    fn coverage_becomes_grey() {
        let mut raster = Raster::new(3, 0..1);
        raster.fill(&[[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]], BLACK);
        assert_eq!(raster.pixels(), [WHITE, BLACK, WHITE]);

        let mut raster = Raster::new(1, 0..1);
        let third = 1.0 / 3.0;
        raster.fill(&[[0.0, 0.0], [third, 0.0], [third, 1.0], [0.0, 1.0]], BLACK);
        assert_eq!(raster.pixels(), [[170, 170, 170]]);
    }

    /// A fan around a point off the grid: the whole square is covered, every sample once.
    #[test]
    fn neighbours_leave_no_seam() {
        let mut raster = Raster::new(40, 0..40);
        let middle = [17.31, 22.77];
        let rim: Vec<[f64; 2]> = (0..=28)
            .map(|k| std::f64::consts::TAU * f64::from(k) / 28.0)
            .map(|angle| [20.0 + 40.0 * angle.cos(), 20.0 + 40.0 * angle.sin()])
            .collect();
        for pair in rim.windows(2) {
            raster.fill(&[middle, pair[0], pair[1]], BLACK);
        }
        assert!(raster.pixels().iter().all(|&pixel| pixel == BLACK));
    }

    #[test]
    fn values_are_interpolated() {
        let mut raster = Raster::new(12, 0..12);
        let grey = |value: f64| [value.round() as u8; 3];
        let corners = [[0.0, 0.0], [12.0, 0.0], [0.0, 12.0]];
        raster.fill_between(corners, [0.0, 240.0, 120.0], grey);
        let pixel = raster.pixels()[2 * 12 + 3];
        // The centre of the pixel in column 3, row 2.
        assert_eq!(pixel, grey(3.5 / 12.0 * 240.0 + 2.5 / 12.0 * 120.0));
    }

    #[test]
    fn what_lies_outside_is_cut() {
        let mut raster = Raster::new(4, 0..4);
        raster.fill(&[[-1e9, -1e9], [1e9, -1e9], [1e9, 2.0], [-1e9, 2.0]], BLACK);
        let pixels = raster.pixels();
        assert!(pixels[..8].iter().all(|&pixel| pixel == BLACK));
        assert!(pixels[8..].iter().all(|&pixel| pixel == WHITE));
    }

    #[test]
    fn a_stroke_has_its_width() {
        let mut raster = Raster::new(5, 0..5);
        raster.stroke(&[[-2.0, 2.5], [7.0, 2.5]], 1.0, BLACK);
        let column: Vec<Rgb> = raster.pixels().into_iter().skip(2).step_by(5).collect();
        assert_eq!(column, [WHITE, WHITE, BLACK, WHITE, WHITE]);
    }

    /// Ink in shares of a pixel.
    fn ink(raster: &Raster) -> f64 {
        let darkness = |pixel: Rgb| f64::from(255 - pixel[0]) / 255.0;
        raster.pixels().into_iter().map(darkness).sum()
    }

    #[test]
    fn a_disc_has_its_area() {
        let mut raster = Raster::new(30, 0..30);
        raster.fill_disc([15.2, 14.9], 9.0, BLACK);
        let area = std::f64::consts::PI * 81.0;
        assert!((ink(&raster) / area - 1.0).abs() < 0.01);
    }

    /// However many points lie on a line, and whatever its direction, it has its width.
    #[test]
    fn a_trace_has_its_width_whatever_its_pieces() {
        for (end, pieces) in [([90.0, 40.0], 1), ([90.0, 40.0], 900), ([10.3, 90.0], 77)] {
            let start = [10.3, 10.4];
            let path: Vec<[f64; 2]> = (0..=pieces)
                .map(|piece| f64::from(piece) / f64::from(pieces))
                .map(|t| [0, 1].map(|k| start[k] + t * (end[k] - start[k])))
                .collect();
            let mut raster = Raster::new(100, 0..100);
            raster.trace(&path, 3.0, BLACK);
            let length = (end[0] - start[0]).hypot(end[1] - start[1]);
            let area = 3.0 * length + std::f64::consts::PI * 1.5 * 1.5;
            let found = ink(&raster);
            assert!((found / area - 1.0).abs() < 0.02, "{found} for {area}");
        }
    }
}
