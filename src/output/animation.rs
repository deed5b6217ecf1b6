//! Pictures that follow one another, as a GIF, which every viewer, slide and browser plays.
//!
//! A GIF has 256 colours. All pictures share a palette of viridis, greys and the tints of lines; a pixel has
//! the nearest of them.

use super::colour::{CELL_EDGE, INK, Rgb, WHITE, tint, viridis};
use super::picture::Picture;
use rayon::prelude::*;
use std::collections::HashMap;

/// A picture in the colours of the palette.
#[derive(Clone, Debug)]
pub struct Still {
    /// [pixels]
    pub size: [u32; 2],
    /// Indices into the palette, row by row.
    pub indices: Vec<u8>,
}

/// Greys from ink to white, tints of the cells' sides, steps of viridis.
const GREYS: usize = 40;
const TINTS: usize = 8;
const STEPS: usize = 200;

/// The colours of all stills.
pub fn palette() -> Vec<Rgb> {
    let share = |k: usize, count: usize| k as f64 / (count - 1) as f64;
    let grey = |k: usize| {
        let t = share(k, GREYS);
        [0, 1, 2].map(|c| {
            let [ink, white] = [INK[c], WHITE[c]].map(f64::from);
            (ink + t * (white - ink)).round() as u8
        })
    };
    let greys = (0..GREYS).map(grey);
    let tints = (1..=TINTS).map(|k| tint(CELL_EDGE, k as f64 / TINTS as f64));
    greys
        .chain(tints)
        .chain((0..STEPS).map(|k| viridis(share(k, STEPS))))
        .collect()
}

impl Still {
    pub fn of(picture: &Picture) -> Still {
        let palette = palette();
        let mut known: HashMap<Rgb, u8> = HashMap::new();
        let mut last = (WHITE, GREYS as u8 - 1);
        let (pixels, _) = picture.rgb().as_chunks::<3>();
        let mut index = |&pixel: &Rgb| {
            if pixel != last.0 {
                let found = known
                    .entry(pixel)
                    .or_insert_with(|| nearest(&palette, pixel));
                last = (pixel, *found);
            }
            last.1
        };
        Still {
            size: picture.size(),
            indices: pixels.iter().map(&mut index).collect(),
        }
    }

    /// A PNG file, of a colour table.
    ///
    /// # Errors
    /// A size that PNG does not know.
    pub fn to_png(&self) -> Result<Vec<u8>, AnimationError> {
        let mut bytes = Vec::new();
        let [width, height] = self.size;
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(palette().into_flattened());
        encoder.set_compression(png::Compression::Balanced);
        encoder.write_header()?.write_image_data(&self.indices)?;
        Ok(bytes)
    }
}

/// The first of the nearest colours.
fn nearest(palette: &[Rgb], colour: Rgb) -> u8 {
    let distance = |other: &Rgb| {
        let apart = (0..3).map(|k| i32::from(other[k]) - i32::from(colour[k]));
        apart.map(|d| d * d).sum::<i32>()
    };
    let places = palette.iter().enumerate();
    let found = places.min_by_key(|(_, other)| distance(other));
    found.map_or(0, |(index, _)| index as u8)
}

/// The whole film takes about so long, but no picture more or less than this, and the last one stays
/// [hundredths of a second].
const FILM: u16 = 400;
const SHORTEST: u16 = 8;
const LONGEST: u16 = 40;
const LAST: u16 = 250;

/// How long each of `count` pictures is seen [hundredths of a second].
fn delays(count: usize) -> Vec<u16> {
    let each = (usize::from(FILM) / count.max(1)) as u16;
    let mut delays = vec![each.clamp(SHORTEST, LONGEST); count];
    if let Some(last) = delays.last_mut() {
        *last = LAST;
    }
    delays
}

/// The GIF, which begins again when it ends. All stills have one size.
///
/// # Errors
/// See [`AnimationError`].
pub fn film(stills: &[Still]) -> Result<Vec<u8>, AnimationError> {
    let size = stills.first().map_or([0; 2], |still| still.size);
    let [width, height] = size.map(|side| u16::try_from(side).unwrap_or(0));
    if width == 0 || height == 0 || stills.iter().any(|still| still.size != size) {
        return Err(AnimationError::Size { size });
    }
    let frame = |(still, delay): (&Still, u16)| {
        let mut frame = gif::Frame::from_indexed_pixels(width, height, still.indices.clone(), None);
        frame.delay = delay;
        frame.make_lzw_pre_encoded();
        frame
    };
    let timed: Vec<(&Still, u16)> = stills.iter().zip(delays(stills.len())).collect();
    let frames: Vec<gif::Frame> = timed.into_par_iter().map(frame).collect();
    let mut bytes = Vec::new();
    let mut encoder = gif::Encoder::new(&mut bytes, width, height, palette().as_flattened())?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for frame in &frames {
        encoder.write_lzw_pre_encoded_frame(frame)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    #[error("the pictures of an animation must have one size up to 65535 pixels, not {size:?}")]
    Size { size: [u32; 2] },
    #[error("cannot encode the animation as GIF")]
    Encoding(#[from] gif::EncodingError),
    #[error("cannot encode a picture of the animation as PNG")]
    Png(#[from] png::EncodingError),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::picture::{FieldPicture, Square};

    /// A square of one value.
    fn still(value: f64) -> Still {
        let picture = FieldPicture {
            title: "film".to_owned(),
            range: Some([0.0, 1.0]),
            squares: vec![Square {
                centre: [0.5, 0.5],
                side: [1.0, 0.0],
                value,
            }],
            ..FieldPicture::default()
        };
        Still::of(&picture.compose().expect("a square").zoomed(0.5))
    }

    /// The colour in the middle of the plot, left of the colour bar.
    fn middle(still: &Still) -> Rgb {
        let [width, height] = still.size.map(|side| side as usize);
        palette()[usize::from(still.indices[height / 2 * width + 2 * width / 5])]
    }

    #[test]
    fn a_colour_of_the_map_stays_within_a_step() {
        for value in [0.0, 0.31, 0.5, 0.777, 1.0] {
            let [found, expected] = [middle(&still(value)), viridis(value)];
            let apart = (0..3).map(|k| found[k].abs_diff(expected[k])).max();
            assert!(apart <= Some(3), "{found:?} {expected:?}");
        }
        assert!(palette().len() <= 256);
        assert_eq!(palette()[usize::from(nearest(&palette(), WHITE))], WHITE);
        assert_eq!(palette()[usize::from(nearest(&palette(), INK))], INK);
    }

    #[test]
    fn the_file_has_the_pictures_and_holds_the_last() {
        let stills = [0.0, 0.4, 0.8].map(still);
        let bytes = film(&stills).expect("a film");
        assert_eq!(bytes, film(&stills).expect("a film"));
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(bytes.as_slice()).expect("a GIF");
        assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
        let mut delays = Vec::new();
        for still in &stills {
            let frame = decoder
                .read_next_frame()
                .expect("readable")
                .expect("a frame");
            delays.push(frame.delay);
            let width = usize::from(frame.width);
            let at = 4 * (usize::from(frame.height) / 2 * width + 2 * width / 5);
            assert_eq!(frame.buffer[at..at + 3], middle(still));
        }
        assert!(decoder.read_next_frame().expect("readable").is_none());
        assert_eq!(delays, [LONGEST, LONGEST, LAST]);
    }

    #[test]
    fn pictures_of_two_sizes_are_refused() {
        let [a, mut b] = [still(0.1), still(0.2)];
        b.size[0] -= 1;
        assert!(matches!(film(&[a, b]), Err(AnimationError::Size { .. })));
        assert!(matches!(film(&[]), Err(AnimationError::Size { .. })));
    }
}
