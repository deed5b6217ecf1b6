//! Numbers as VTK's XML format holds them inline: in blocks that are compressed by themselves, on all
//! threads, then in base64.
//!
//! ```text
//! number of blocks, bytes of a block, of the last one if it is shorter, of each block when compressed; data
//! ```
//!
//! Both parts are encoded by themselves; the header's numbers are UInt64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compress, Compression, FlushCompress};
use rayon::prelude::*;

/// Measured on fields of a fracture run: a higher level takes longer and saves little
/// (docs/performance.md).
pub(super) const LEVEL: u32 = 2;

/// Bytes of a block before compression: far more than the window of 32 KiB, and enough blocks for all
/// threads.
const BLOCK: usize = 1 << 17;

/// The text of an array.
pub(super) fn packed(bytes: &[u8]) -> String {
    let blocks: Vec<Vec<u8>> = bytes
        .par_chunks(BLOCK)
        .map_init(|| Compress::new(Compression::new(LEVEL), true), compressed)
        .collect();
    let whole_blocks = [blocks.len(), BLOCK, bytes.len() % BLOCK];
    let numbers = whole_blocks.into_iter().chain(blocks.iter().map(Vec::len));
    let header: Vec<u8> = numbers.flat_map(|n| (n as u64).to_le_bytes()).collect();
    let mut text = STANDARD.encode(header);
    STANDARD.encode_string(blocks.concat(), &mut text);
    text
}

fn compressed(compress: &mut Compress, block: &[u8]) -> Vec<u8> {
    compress.reset();
    // What zlib may add to a block that cannot be compressed.
    let mut bytes = Vec::with_capacity(block.len() + block.len() / 1000 + 64);
    loop {
        let read = compress.total_in() as usize;
        let status = compress
            .compress_vec(&block[read..], &mut bytes, FlushCompress::Finish)
            .expect("compressing from memory to memory cannot fail");
        if status == flate2::Status::StreamEnd {
            return bytes;
        }
        bytes.reserve(1024);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn unpacked(text: &str) -> Vec<u8> {
        let number = |bytes: &[u8], k: usize| {
            let bytes = bytes[8 * k..8 * k + 8].try_into().expect("eight bytes");
            u64::from_le_bytes(bytes) as usize
        };
        let decode = |text: &str| STANDARD.decode(text).expect("base64");
        // Four letters for three bytes.
        let count = number(&decode(&text[..32]), 0);
        let letters = (8 * (3 + count)).div_ceil(3) * 4;
        let [header, data] = [&text[..letters], &text[letters..]].map(decode);
        let mut bytes = Vec::new();
        let mut start = 0;
        for block in 0..count {
            let end = start + number(&header, 3 + block);
            let before = bytes.len();
            let mut decoder = flate2::read::ZlibDecoder::new(&data[start..end]);
            decoder.read_to_end(&mut bytes).expect("zlib");
            let is_last = block + 1 == count && number(&header, 2) > 0;
            let expected = number(&header, if is_last { 2 } else { 1 });
            assert_eq!(bytes.len() - before, expected);
            start = end;
        }
        assert_eq!(start, data.len());
        bytes
    }

    #[test]
    fn what_is_packed_comes_back() {
        // Weyl's sequence: bytes that no compressor shortens; and bytes that any does.
        let noise = |k: usize| {
            (k as u64)
                .wrapping_mul(0x9E37_79B9_7F4A_7C15)
                .rotate_left(29) as u8
        };
        for count in [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 17] {
            for bytes in [(0..count).map(noise).collect(), vec![7; count]] {
                assert!(unpacked(&packed(&bytes)) == bytes, "{count}");
            }
        }
    }
}
