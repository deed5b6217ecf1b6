//! Files of the results, and what they took: bytes on disk against the plain numbers in them.

use crate::trace::{Kind, Trace};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// A file that was written, under its final name in some folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    pub name: String,
    /// Of the numbers in it, as they are in memory.
    pub raw_bytes: u64,
    pub bytes: u64,
    /// Of one thread: computing the fields, packing, writing.
    pub time: Duration,
}

impl Made {
    /// Records what `make` takes; it gives the bytes of the numbers and of the file.
    pub fn measured<E>(
        name: String,
        trace: &Trace,
        make: impl FnOnce(&str) -> Result<[u64; 2], E>,
    ) -> Result<Made, E> {
        let start = Instant::now();
        let [raw_bytes, bytes] = make(&name)?;
        let time = start.elapsed();
        trace.record(Kind::File, name.clone(), start, time);
        Ok(Made {
            name,
            raw_bytes,
            bytes,
            time,
        })
    }
}

/// What the files whose names end so took together, for the summary.
pub(crate) fn account(made: &[Made], ending: &str) -> Value {
    let files = || made.iter().filter(|made| made.name.ends_with(ending));
    let [raw, bytes] = [|made: &Made| made.raw_bytes, |made: &Made| made.bytes]
        .map(|of| files().map(of).sum::<u64>());
    let seconds = files()
        .map(|made| made.time)
        .sum::<Duration>()
        .as_secs_f64();
    // No file, no rate.
    let over = |a: f64, b: f64| (b > 0.0).then_some(a / b);
    json!({
        "files": files().count(),
        "raw_bytes": raw,
        "bytes": bytes,
        "ratio": over(bytes as f64, raw as f64),
        "seconds": seconds,
        "megabytes_per_second": over(raw as f64 / 1e6, seconds),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_account_has_a_ratio_and_a_rate_where_there_are_files() {
        let made = |name: &str, raw_bytes, bytes| Made {
            name: name.to_owned(),
            raw_bytes,
            bytes,
            time: Duration::from_millis(500),
        };
        let made = [
            made("a.vtu", 6_000_000, 2_000_000),
            made("b.vtu", 2_000_000, 2_000_000),
        ];
        let account_of = |ending| account(&made, ending);
        let vtu = account_of(".vtu");
        assert_eq!([&vtu["files"], &vtu["bytes"]], [2, 4_000_000]);
        assert_eq!([&vtu["ratio"], &vtu["megabytes_per_second"]], [0.5, 8.0]);
        let none = account_of(".png");
        assert!(none["ratio"].is_null() && none["megabytes_per_second"].is_null());
    }
}
