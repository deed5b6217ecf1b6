//! `where`: places by position.

use super::Reader;
use crate::mesh::selection::{Coordinate, Place, Selection};
use crate::pipeline::read::quantity::Dimension;
use crate::pipeline::read::source::InputError;
use crate::pipeline::read::spec::{self, Scalar};

impl Reader<'_> {
    /// The name of the place at which an entry of `boundary` acts, and the selection if it is none of the
    /// mesh's groups.
    pub(super) fn place(
        &self,
        index: usize,
        written: &spec::Boundary,
    ) -> Result<(String, Option<Selection>), InputError> {
        let key = format!("boundary/{index}");
        match (&written.group, &written.position) {
            (Some(group), None) => Ok((group.0.clone(), None)),
            (None, Some(position)) => {
                let selection = self.selection(&format!("{key}/where"), position)?;
                Ok((label(position), Some(selection)))
            }
            (None, None) => {
                let help = "add `group: NAME`, or a position: `where: { x: min }`".to_owned();
                let message = "this entry names no place";
                Err(self.source.error(&key, message, Some(help)))
            }
            (Some(_), Some(_)) => {
                let help = "remove one of them".to_owned();
                let message = "an entry has a `group` or a `where`, not both";
                Err(self.source.error(&key, message, Some(help)))
            }
        }
    }

    fn selection(&self, key: &str, written: &spec::Position) -> Result<Selection, InputError> {
        let by_coordinates = written.x.is_some() || written.y.is_some();
        let given = [
            by_coordinates,
            written.rectangle.is_some(),
            written.near.is_some(),
            written.between.is_some(),
        ];
        if given.iter().filter(|given| **given).count() != 1 {
            let message = "a place is given in one way";
            let help = "there are: `{ x: min }`, `{ y: 10 mm }`, `{ x: max, y: min }`, `{ box: [[0, 0], [10 mm, 2 \
                        mm]] }`, `{ near: [20 mm, 10 mm] }`, `{ between: [[0, 0], [0, 5 mm]] }`";
            return Err(self.source.error(key, message, Some(help.to_owned())));
        }
        let point = |field: &str, [x, y]: &[Scalar; 2]| {
            let at = |k: usize, value: &Scalar| {
                self.quantity(&format!("{key}/{field}/{k}"), value, Dimension::LENGTH)
            };
            Ok::<_, InputError>([at(0, x)?, at(1, y)?])
        };
        let pair = |field: &str, [a, b]: &[[Scalar; 2]; 2]| {
            let end = |k: usize, written| point(&format!("{field}/{k}"), written);
            Ok::<_, InputError>([end(0, a)?, end(1, b)?])
        };
        let place = if let Some(corners) = &written.rectangle {
            Place::Rectangle(pair("box", corners)?)
        } else if let Some(at) = &written.near {
            Place::Near(point("near", at)?)
        } else if let Some(ends) = &written.between {
            Place::Between(pair("between", ends)?)
        } else {
            Place::Coordinates([
                self.coordinate(&format!("{key}/x"), written.x.as_ref())?,
                self.coordinate(&format!("{key}/y"), written.y.as_ref())?,
            ])
        };
        let tolerance = written.tolerance.as_ref();
        let tolerance = tolerance
            .map(|value| self.positive(&format!("{key}/tolerance"), value, Dimension::LENGTH))
            .transpose()?;
        Ok(Selection { place, tolerance })
    }

    fn coordinate(
        &self,
        key: &str,
        written: Option<&Scalar>,
    ) -> Result<Option<Coordinate>, InputError> {
        let Some(written) = written else {
            return Ok(None);
        };
        Ok(Some(match written.0.trim() {
            "min" => Coordinate::Lowest,
            "max" => Coordinate::Highest,
            word if word.chars().all(char::is_alphabetic) => {
                let help = "write `min`, `max`, or a coordinate such as `10 mm`".to_owned();
                let message = format!("`{word}` is no coordinate");
                return Err(self.source.error(key, message, Some(help)));
            }
            _ => Coordinate::At(self.quantity(key, written, Dimension::LENGTH)?),
        }))
    }
}

/// The place as messages and results name it: `x = min`.
fn label(position: &spec::Position) -> String {
    let point = |[x, y]: &[Scalar; 2]| format!("({}, {})", x.0, y.0);
    if let Some([a, b]) = &position.rectangle {
        return format!("box {} to {}", point(a), point(b));
    }
    if let Some(at) = &position.near {
        return format!("near {}", point(at));
    }
    if let Some([a, b]) = &position.between {
        return format!("between {} and {}", point(a), point(b));
    }
    let part = |axis: &str, value: &Option<Scalar>| {
        let value = value.as_ref();
        value.map(|value| format!("{axis} = {}", value.0))
    };
    let parts = [part("x", &position.x), part("y", &position.y)];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
