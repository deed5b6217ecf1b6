//! Flags, eight to a byte in what is kept: `#[serde(with = "bits")]`.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[derive(Serialize, Deserialize)]
struct Packed {
    count: usize,
    bytes: Vec<u8>,
}

pub(crate) fn serialize<S: Serializer>(flags: &[bool], serializer: S) -> Result<S::Ok, S::Error> {
    let pack = |eight: &[bool]| {
        (0..8)
            .zip(eight)
            .map(|(bit, &is)| u8::from(is) << bit)
            .sum()
    };
    let packed = Packed {
        count: flags.len(),
        bytes: flags.chunks(8).map(pack).collect(),
    };
    packed.serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<bool>, D::Error> {
    let Packed { count, bytes } = Packed::deserialize(deserializer)?;
    if bytes.len() != count.div_ceil(8) {
        return Err(serde::de::Error::invalid_length(
            count,
            &"one bit for each flag",
        ));
    }
    Ok((0..count)
        .map(|k| bytes[k / 8] >> (k % 8) & 1 == 1)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Flags(#[serde(with = "super")] Vec<bool>);

    #[test]
    fn every_flag_comes_back_and_takes_a_bit() {
        for count in [0, 1, 7, 8, 9, 1000] {
            let flags = Flags((0..count).map(|k| k * k % 7 < 3).collect());
            let bytes = postcard::to_stdvec(&flags).expect("plain data");
            assert!(bytes.len() <= count / 8 + 5, "{count}: {}", bytes.len());
            assert_eq!(
                postcard::from_bytes::<Flags>(&bytes).expect("the same"),
                flags
            );
        }
    }

    #[test]
    fn a_wrong_count_is_refused() {
        let bytes = postcard::to_stdvec(&Packed {
            count: 9,
            bytes: vec![1],
        })
        .expect("plain data");
        assert!(postcard::from_bytes::<Flags>(&bytes).is_err());
    }
}
