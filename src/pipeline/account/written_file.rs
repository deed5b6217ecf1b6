//! Files of the results, and what they took: bytes on disk against the plain numbers in them.

use crate::trace::{Kind, Trace};
use std::time::{Duration, Instant};

/// A file that was written, under its final name in some folder.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenFile {
    pub name: String,
    /// Bytes of the numbers in it, as they are in memory.
    pub raw_bytes: u64,
    pub bytes: u64,
    /// Time of one thread for computing the fields, packing and writing.
    pub time: Duration,
}

impl WrittenFile {
    /// Records what `make` takes; it gives the bytes of the numbers and of the file.
    pub fn measured<E>(
        name: String,
        trace: &Trace,
        make: impl FnOnce(&str) -> Result<[u64; 2], E>,
    ) -> Result<WrittenFile, E> {
        let start = Instant::now();
        let [raw_bytes, bytes] = make(&name)?;
        let time = start.elapsed();
        trace.record(Kind::File, name.clone(), start, time);
        Ok(WrittenFile {
            name,
            raw_bytes,
            bytes,
            time,
        })
    }
}
