//! SPZ of version 4: streams of Zstandard behind a table of their sizes.

use std::io::Read;

use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::Change;
use crate::mutate::LONGEST;
use crate::random::Random;

/// Length of the header.
const HEADER: usize = 32;

pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    let is_known = bytes.starts_with(b"NGSP\x04\0\0\0") && bytes.len() > HEADER;
    let table = u32::from_le_bytes(*bytes.get(16..)?.first_chunk()?) as usize;
    let count = usize::from(bytes[15]);
    if !is_known || count == 0 {
        return None;
    }
    let mut at = table + 16 * count;
    let mut streams = Vec::new();
    for index in 0..count {
        let size = u64::from_le_bytes(*bytes.get(table + 16 * index..)?.first_chunk()?) as usize;
        let packed = bytes.get(at..at.checked_add(size)?)?;
        let mut inside = Vec::new();
        let decoder = ruzstd::decoding::StreamingDecoder::new(packed).ok()?;
        decoder.take(LONGEST as u64).read_to_end(&mut inside).ok()?;
        streams.push(inside);
        at += size;
    }
    let chosen = random.below(count);
    change(&mut streams[chosen], random);
    let mut head = bytes[..table].to_vec();
    if random.below(4) == 0 {
        change(&mut head, random);
    }
    let mut body = Vec::new();
    for stream in &streams {
        let packed = compress_to_vec(&stream[..], CompressionLevel::Fastest);
        head.extend((packed.len() as u64).to_le_bytes());
        head.extend((stream.len() as u64).to_le_bytes());
        body.extend(packed);
    }
    Some([head, body].concat())
}
