//! Depth of nesting of a YAML text. The reader that keeps lines and columns goes down by recursion, without
//! end; the one that fills our data stops at 128, and so is asked first.

use serde::de::{
    Deserialize, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use std::fmt;

/// Whether the text is YAML that can be read by recursion.
pub(crate) fn is_shallow(text: &str) -> bool {
    serde_yaml::from_str::<Shape>(text).is_ok()
}

/// More brackets in each other than a pipeline has.
pub(crate) const MOST_BRACKETS: usize = 100;

/// The first line in which more than that are open. Each one costs the readers as much as all those around
/// it: a hundred thousand take minutes. Those in texts and comments count as well: there they come in pairs.
pub(crate) fn too_many_brackets(text: &str) -> Option<usize> {
    let mut open = 0_usize;
    for (index, line) in text.lines().enumerate() {
        for byte in line.bytes() {
            match byte {
                b'[' | b'{' => open += 1,
                b']' | b'}' => open = open.saturating_sub(1),
                _ => {}
            }
            if open > MOST_BRACKETS {
                return Some(index + 1);
            }
        }
    }
    None
}

/// Whatever the text holds, forgotten at once: a key may stand there twice.
struct Shape;

impl<'de> Deserialize<'de> for Shape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Shape, D::Error> {
        deserializer.deserialize_any(Anything)
    }
}

struct Anything;

impl<'de> Visitor<'de> for Anything {
    type Value = Shape;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("anything")
    }

    fn visit_bool<E>(self, _: bool) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_i128<E>(self, _: i128) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_u128<E>(self, _: u128) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_str<E>(self, _: &str) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_unit<E>(self) -> Result<Shape, E> {
        Ok(Shape)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Shape, A::Error> {
        while items.next_element::<Shape>()?.is_some() {}
        Ok(Shape)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Shape, A::Error> {
        while entries.next_entry::<Shape, Shape>()?.is_some() {}
        Ok(Shape)
    }

    fn visit_enum<A: EnumAccess<'de>>(self, tagged: A) -> Result<Shape, A::Error> {
        let (_, value) = tagged.variant::<Shape>()?;
        value.newtype_variant()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_files_are_shallow_and_endless_nesting_is_not() {
        for text in ["a: {b: [1, 2.5, x, null, true]}", "a: 1\na: 2", "a: !b c"] {
            assert!(is_shallow(text), "{text}");
        }
        for unit in ["- ", "? "] {
            assert!(!is_shallow(&unit.repeat(100_000)), "{unit}");
        }
        for unit in ["[", "{a: "] {
            assert!(!is_shallow(&unit.repeat(1000)), "{unit}");
            let text = format!("a: [{{b: 1}}]\n{}", unit.repeat(1000));
            assert_eq!(too_many_brackets(&text), Some(2));
        }
        assert_eq!(too_many_brackets(&"[{a: 1}]\n".repeat(1000)), None);
    }
}
