//! The colours of pictures: a perceptually uniform map for values, muted ones for regions.

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

/// Fills of regions with cells: light, so that the cells' sides stand out.
const CELL_FILLS: [Rgb; 6] = [
    [205, 219, 233],
    [214, 229, 209],
    [234, 222, 202],
    [222, 213, 232],
    [207, 229, 228],
    [230, 213, 217],
];

/// Material points, darker than any fill of cells.
const POINT_FILLS: [Rgb; 6] = [
    [217, 130, 43],
    [86, 122, 168],
    [94, 145, 80],
    [144, 103, 167],
    [62, 150, 148],
    [171, 104, 87],
];

/// Colour of the `index`-th region that consists of cells.
pub fn cell_fill(index: usize) -> Rgb {
    CELL_FILLS[index % CELL_FILLS.len()]
}

/// Colour of the `index`-th region that consists of material points.
pub fn point_fill(index: usize) -> Rgb {
    POINT_FILLS[index % POINT_FILLS.len()]
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

/// Values to colours: the range of a field and, for speed, the map as a table.
#[derive(Clone, Debug)]
pub struct ColourScale {
    pub min: f64,
    pub max: f64,
    table: Vec<Rgb>,
}

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
        let share = |step: usize| step as f64 / (TABLE_STEPS - 1) as f64;
        ColourScale {
            min,
            max,
            table: (0..TABLE_STEPS).map(|step| viridis(share(step))).collect(),
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
