//! Streams of gzip, zlib and Zstandard, wherever they begin in a file.

use std::io::{Read, Write};

use flate2::Compression;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::Change;
use crate::mutate::LONGEST;
use crate::random::Random;

/// Places that are tried for a stream.
const STARTS: usize = 64;

/// Changes the inside of one of the streams of a file; what lies before and behind it is kept.
pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    let is_start = |at: &usize| {
        matches!(
            &bytes[*at..],
            [0x1f, 0x8b, 8, ..] | [0x78, 1 | 0x5e | 0x9c | 0xda, ..]
        ) || bytes[*at..].starts_with(&[0x28, 0xb5, 0x2f, 0xfd])
    };
    let mut found: Vec<_> = (0..bytes.len())
        .filter(is_start)
        .take(STARTS)
        .filter_map(|at| Some((at, unpacked(&bytes[at..])?)))
        .collect();
    if found.is_empty() {
        return None;
    }
    let (at, (mut inside, length)) = found.swap_remove(random.below(found.len()));
    change(&mut inside, random);
    let packed = match bytes[at] {
        0x1f => gzipped(&inside),
        0x78 => deflated(&inside),
        _ => compress_to_vec(&inside[..], CompressionLevel::Fastest),
    };
    Some([&bytes[..at], &packed, &bytes[at + length..]].concat())
}

/// What a stream at the start of these bytes holds, and its own length.
fn unpacked(bytes: &[u8]) -> Option<(Vec<u8>, usize)> {
    let mut inside = Vec::new();
    let most = LONGEST as u64;
    let length = match bytes[0] {
        0x1f => {
            let mut decoder = flate2::bufread::GzDecoder::new(bytes);
            decoder.by_ref().take(most).read_to_end(&mut inside).ok()?;
            bytes.len() - decoder.into_inner().len()
        }
        0x78 => {
            let mut decoder = flate2::bufread::ZlibDecoder::new(bytes);
            decoder.by_ref().take(most).read_to_end(&mut inside).ok()?;
            bytes.len() - decoder.into_inner().len()
        }
        _ => {
            let mut rest = bytes;
            let decoder = ruzstd::decoding::StreamingDecoder::new(&mut rest).ok()?;
            decoder.take(most).read_to_end(&mut inside).ok()?;
            bytes.len() - rest.len()
        }
    };
    Some((inside, length))
}

pub(super) fn inflated(bytes: &[u8]) -> Option<Vec<u8>> {
    unpacked(bytes.starts_with(&[0x78]).then_some(bytes)?).map(|(inside, _)| inside)
}

/// Writing to memory does not fail; if it did, the file would be short.
pub(super) fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), Compression::fast());
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), Compression::fast());
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}
