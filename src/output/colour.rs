//! The colours of pictures: perceptually uniform maps for values, muted colours for regions.
//!
//! Values of one sign have viridis. Values of both have a map that diverges from white at zero; it is
//! straight in lightness L of Oklab (Ottosson 2020) on both sides, so that equal steps look equal and a
//! print in grey still tells the magnitude, and a shade off white, so that a crack that gapes is apart:
//!
//! ```text
//! L = 0.95 − 0.55 t,  chroma 0.15 t^(3/4),  hue 258° (blue, negative) or 30° (red, positive);  t = |v|/v_max
//! ```

/// Red, green, blue.
pub type Rgb = [u8; 3];

pub const WHITE: Rgb = [255, 255, 255];
pub const INK: Rgb = [38, 40, 44];
/// Sides of cells.
pub const CELL_EDGE: Rgb = [112, 120, 130];
/// Lines across a chart at its ticks.
pub const GRID: Rgb = [217, 221, 226];
/// The line across a chart at zero.
pub const ZERO: Rgb = [150, 156, 164];
/// Interfaces and cracks.
pub const INTERFACE: Rgb = [200, 30, 45];

/// Colours of regions that can be told apart.
pub const REGION_COLOURS: usize = 12;

/// Fills of regions with cells: light, so that the cells' sides stand out.
const CELL_FILLS: [Rgb; REGION_COLOURS] = [
    [205, 219, 233],
    [214, 229, 209],
    [234, 222, 202],
    [222, 213, 232],
    [207, 229, 228],
    [230, 213, 217],
    [250, 238, 160],
    [176, 190, 214],
    [246, 196, 168],
    [176, 210, 160],
    [196, 176, 218],
    [200, 200, 200],
];

/// Material points, darker than any fill of cells.
const POINT_FILLS: [Rgb; REGION_COLOURS] = [
    [217, 130, 43],
    [86, 122, 168],
    [94, 145, 80],
    [144, 103, 167],
    [62, 150, 148],
    [171, 104, 87],
    [196, 168, 40],
    [58, 72, 120],
    [206, 98, 142],
    [112, 112, 112],
    [60, 92, 48],
    [110, 170, 214],
];

/// Colour of the `index`-th region that consists of cells.
pub fn cell_fill(index: usize) -> Rgb {
    CELL_FILLS[index % REGION_COLOURS]
}

/// Colour of the `index`-th region that consists of material points.
pub fn point_fill(index: usize) -> Rgb {
    POINT_FILLS[index % REGION_COLOURS]
}

/// Curves of a chart, apart for colour-blind readers too: Okabe and Ito's colours but yellow, which
/// is too pale for a line.
const CURVES: [Rgb; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [0, 0, 0],
];

/// Colour of the `index`-th curve of a chart.
pub fn curve(index: usize) -> Rgb {
    CURVES[index % CURVES.len()]
}

/// `colour` over white, covering the share `opacity`.
pub fn tint(colour: Rgb, opacity: f64) -> Rgb {
    colour.map(|channel| (255.0 - (255.0 - f64::from(channel)) * opacity).round() as u8)
}

/// The viridis map: dark blue at 0, yellow at 1; values outside are clamped.
pub fn viridis(share: f64) -> Rgb {
    let colour = colorous::VIRIDIS.eval_continuous(share.clamp(0.0, 1.0));
    [colour.r, colour.g, colour.b]
}

/// The diverging map: blue at 0, white at 1/2, red at 1; values outside are clamped.
pub fn diverging(share: f64) -> Rgb {
    let signed = 2.0 * share.clamp(0.0, 1.0) - 1.0;
    let t = signed.abs();
    let hue: f64 = if signed < 0.0 { 258.0 } else { 30.0 };
    let (sin, cos) = hue.to_radians().sin_cos();
    let chroma = 0.15 * t.powf(0.75);
    from_oklab([0.95 - 0.55 * t, chroma * cos, chroma * sin])
}

/// Oklab to sRGB, both after Ottosson (2020).
fn from_oklab([lightness, a, b]: [f64; 3]) -> Rgb {
    let cone = [
        lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b,
    ]
    .map(|root| root * root * root);
    let linear = [
        [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
        [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
        [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0],
    ]
    .map(|row: [f64; 3]| row.iter().zip(cone).map(|(m, c)| m * c).sum::<f64>());
    linear.map(|channel| {
        let channel = channel.clamp(0.0, 1.0);
        let encoded = if channel <= 0.003_130_8 {
            12.92 * channel
        } else {
            1.055 * channel.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * encoded).round() as u8
    })
}

/// Values to colours: the range of a field and, for speed, the map as a table.
#[derive(Clone, Debug)]
pub struct ColourScale {
    pub min: f64,
    pub max: f64,
    table: Vec<Rgb>,
}

/// A field has both signs if the lesser extreme is at least this share of the larger one; less is the
/// noise of a field of one sign.
const BOTH_SIGNS: f64 = 0.05;

/// Steps of the table: more than a monitor tells apart.
const TABLE_STEPS: usize = 1024;

/// A field is constant if its range is smaller than this share of its largest magnitude: more
/// digits no axis could show.
const CONSTANT: f64 = 1e-9;

impl ColourScale {
    /// The range of `values`; 0 to 0 without any. They must be finite.
    pub fn of(values: impl Iterator<Item = f64>) -> ColourScale {
        let widen = |(min, max): (f64, f64), v: f64| (min.min(v), max.max(v));
        let (min, max) = values.fold((f64::INFINITY, f64::NEG_INFINITY), widen);
        let (min, max) = if min <= max { (min, max) } else { (0.0, 0.0) };
        ColourScale {
            min,
            max,
            table: table(viridis),
        }
    }

    /// Symmetric about zero, in the diverging map, if the range has both signs.
    #[must_use]
    pub fn signed(self) -> ColourScale {
        let [lesser, most] = [f64::min, f64::max].map(|of| of(-self.min, self.max));
        if lesser < BOTH_SIGNS * most || self.is_constant() {
            return self;
        }
        ColourScale {
            min: -most,
            max: most,
            table: table(diverging),
        }
    }

    pub fn is_constant(&self) -> bool {
        self.max - self.min <= CONSTANT * self.min.abs().max(self.max.abs())
    }

    /// The colour of `value`; the middle of the map if the field is constant.
    pub fn colour(&self, value: f64) -> Rgb {
        let share = if self.is_constant() {
            0.5
        } else {
            ((value - self.min) / (self.max - self.min)).clamp(0.0, 1.0)
        };
        self.table[(share * (TABLE_STEPS - 1) as f64).round() as usize]
    }
}

fn table(map: impl Fn(f64) -> Rgb) -> Vec<Rgb> {
    let share = |step: usize| step as f64 / (TABLE_STEPS - 1) as f64;
    (0..TABLE_STEPS).map(|step| map(share(step))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_has_its_published_ends_and_middle() {
        assert_eq!(viridis(0.0), [68, 1, 84]);
        assert_eq!(viridis(1.0), [253, 231, 37]);
        let middle = viridis(0.5).map(i32::from);
        for (channel, published) in middle.into_iter().zip([33, 145, 140]) {
            assert!((channel - published).abs() <= 3, "{middle:?}");
        }
    }

    /// CIE L*, a*, b* of an sRGB colour (D65): not the space that the map is made from.
    fn lab(colour: Rgb) -> [f64; 3] {
        let linear = colour.map(|channel| {
            let c = f64::from(channel) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        });
        let of_white = |row: [f64; 3], white: f64| {
            let sum: f64 = row.iter().zip(linear).map(|(m, c)| m * c).sum();
            let share = sum / white;
            if share > 0.008_856 {
                share.cbrt()
            } else {
                7.787 * share + 16.0 / 116.0
            }
        };
        let x = of_white([0.4124, 0.3576, 0.1805], 0.9505);
        let y = of_white([0.2126, 0.7152, 0.0722], 1.0);
        let z = of_white([0.0193, 0.1192, 0.9505], 1.089);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn lightness(colour: Rgb) -> f64 {
        lab(colour)[0]
    }

    /// ΔE of 5 is seen at a glance (2.3 is just noticeable); points stand close, so more.
    #[test]
    fn any_two_regions_can_be_told_apart() {
        for (fill, least) in [(cell_fill as fn(usize) -> Rgb, 7.0), (point_fill, 15.0)] {
            for a in 0..REGION_COLOURS {
                for b in 0..a {
                    let [p, q] = [lab(fill(a)), lab(fill(b))];
                    let squares = (0..3).map(|k| (p[k] - q[k]).powi(2));
                    let apart = squares.sum::<f64>().sqrt();
                    assert!(apart > least, "{a} {b}: {apart}");
                }
            }
        }
    }

    #[test]
    fn oklab_has_its_published_white_and_red() {
        assert_eq!(from_oklab([1.0, 0.0, 0.0]), [255; 3]);
        let red = from_oklab([0.627_955, 0.224_863, 0.125_846]);
        assert_eq!(red, [255, 0, 0]);
    }

    #[test]
    fn the_diverging_map_is_white_at_zero_and_falls_alike_to_both_sides() {
        let middle = diverging(0.5);
        assert!(
            middle.iter().all(|&c| (235..245).contains(&c)),
            "{middle:?}"
        );
        let [blue, red] = [diverging(0.0), diverging(1.0)];
        assert!(
            blue[2] > blue[0] + 80 && red[0] > red[2] + 80,
            "{blue:?} {red:?}"
        );
        for step in 0..20 {
            let t = f64::from(step) / 40.0;
            let [low, high] = [0.5 - t, 0.5 + t].map(|share| lightness(diverging(share)));
            // Hues differ in what L* makes of them.
            assert!((low - high).abs() < 6.0, "{t}: {low} {high}");
            for sign in [-1.0, 1.0] {
                let next = lightness(diverging(0.5 + sign * (t + 0.025)));
                let fall = lightness(diverging(0.5 + sign * t)) - next;
                assert!((2.0..5.0).contains(&fall), "{t} {sign}: {fall}");
            }
        }
    }

    #[test]
    fn a_scale_of_both_signs_is_symmetric() {
        let signed = |values: [f64; 2]| ColourScale::of(values.into_iter()).signed();
        let both = signed([-1.0, 4.0]);
        assert_eq!((both.min, both.max), (-4.0, 4.0));
        assert_eq!(both.colour(4.0), diverging(1.0));
        assert_eq!(both.colour(-4.0), diverging(0.0));
        for one in [signed([-0.1, 4.0]), signed([1.0, 4.0]), signed([0.0, 4.0])] {
            assert_eq!(one.colour(4.0), viridis(1.0));
        }
        assert!(signed([0.0, 0.0]).is_constant());
    }

    #[test]
    fn the_ends_of_a_scale_are_the_ends_of_the_map() {
        let scale = ColourScale::of([3.0, -1.0, 2.0].into_iter());
        assert_eq!((scale.min, scale.max), (-1.0, 3.0));
        assert_eq!(scale.colour(-1.0), viridis(0.0));
        assert_eq!(scale.colour(3.0), viridis(1.0));
        assert_ne!(scale.colour(1.0), scale.colour(2.0));
    }

    #[test]
    fn a_constant_or_missing_field_has_the_middle_colour() {
        for values in [vec![], vec![0.0], vec![7.0, 7.0 + 1e-12]] {
            let scale = ColourScale::of(values.into_iter());
            assert!(scale.is_constant());
            assert_eq!(scale.colour(7.0), scale.colour(-1e9));
        }
    }
}
