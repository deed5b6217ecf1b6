//! `output`, checked.

use super::super::quantity::Dimension;
use super::super::source::{InputError, choices};
use super::super::spec::PictureKind;
use super::Reader;
use std::collections::BTreeMap;

/// The maps of displacement and stress.
const MAPS: [(&str, PictureKind, Dimension); 7] = [
    (
        "displacement-x",
        PictureKind::DisplacementX,
        Dimension::LENGTH,
    ),
    (
        "displacement-y",
        PictureKind::DisplacementY,
        Dimension::LENGTH,
    ),
    ("stress-xx", PictureKind::StressXx, Dimension::PRESSURE),
    ("stress-yy", PictureKind::StressYy, Dimension::PRESSURE),
    ("stress-xy", PictureKind::StressXy, Dimension::PRESSURE),
    (
        "principal-stress",
        PictureKind::PrincipalStress,
        Dimension::PRESSURE,
    ),
    ("von-mises", PictureKind::VonMises, Dimension::PRESSURE),
];

impl Reader<'_> {
    /// Ends of the colour bar of single maps [m or Pa]; the other keys of pictures are checked too.
    ///
    /// # Errors
    /// A factor or percentiles out of their range, a range that is empty or of a picture without one.
    pub(crate) fn colour_ranges(&self) -> Result<BTreeMap<PictureKind, [f64; 2]>, InputError> {
        let output = &self.spec.output;
        let fail = |key: &str, message: &str, help: &str| {
            self.source
                .error(key, message.to_owned(), Some(help.to_owned()))
        };
        if output
            .exaggeration
            .is_some_and(|factor| !(factor >= 0.0 && factor.is_finite()))
        {
            let message = "the exaggeration must be a number from 0 on";
            return Err(fail(
                "output/exaggeration",
                message,
                "write 1 for the true shape",
            ));
        }
        let is_sound = |[low, high]: [f64; 2]| 0.0 <= low && low < high && high <= 100.0;
        if output.percentiles.is_some_and(|ends| !is_sound(ends)) {
            let message = "percentiles must be two numbers from 0 to 100, the smaller one first";
            return Err(fail("output/percentiles", message, "write, say, `[1, 99]`"));
        }
        let mut ranges = BTreeMap::new();
        for (name, ends) in &output.colour_ranges {
            let key = format!("output/colour_ranges/{name}");
            let Some(&(_, kind, dimension)) = MAPS.iter().find(|(known, ..)| known == name) else {
                let message = format!("`{name}` is no map of displacement or stress");
                let help = choices(name, MAPS.iter().map(|(known, ..)| *known));
                return Err(self.source.error_at_name(&key, message, Some(help)));
            };
            let end = |k: usize| self.quantity(&format!("{key}/{k}"), &ends[k], dimension);
            let (low, high) = (end(0)?, end(1)?);
            if low >= high {
                let message = "the range is empty: the smaller end stands first";
                return Err(fail(&key, message, "swap the two, or write other ends"));
            }
            ranges.insert(kind, [low, high]);
        }
        Ok(ranges)
    }
}
