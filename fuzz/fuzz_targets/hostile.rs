//! One reader, named by `$INPUT`, fed with what coverage leads to: it may refuse, but neither panic nor
//! overflow, read beyond its memory, hang or hold too much.
//!
//! ```text
//! INPUT=pipeline cargo fuzz run hostile corpus/pipeline
//! ```

#![no_main]

#[path = "../../tests/hostile/readers.rs"]
mod readers;

use libfuzzer_sys::fuzz_target;
use readers::{Read, reader};
use std::path::Path;

thread_local! {
    static READ: Read = {
        let name = std::env::var("INPUT").expect("INPUT names a kind of input");
        let geo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../geo");
        reader(&name, &geo).unwrap_or_else(|| panic!("INPUT: no kind {name:?}"))
    };
}

fuzz_target!(|bytes: &[u8]| READ.with(|read| drop(read(bytes))));
