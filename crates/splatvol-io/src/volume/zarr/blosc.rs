//! Chunks of Blosc 1 (<https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>): blocks, split by the bytes
//! of their elements, shuffled, and compressed by LZ4, zlib, Zstandard or `BloscLZ`. Existing crates bring the library
//! in C.

use std::io::Write;

use flate2::bufread::ZlibDecoder;
use flate2::write::ZlibEncoder;

use super::codec::{fill, lz4, zstd};
use super::shuffle::{shuffle_bits, unshuffle, unshuffle_bits};

const HEADER: usize = 16;
/// Flags of a chunk.
const BYTES_SHUFFLED: u8 = 1;
const STORED: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const UNSPLIT: u8 = 0x10;
/// Bytes of the blocks that are written: those of a processor's second cache hold two.
pub(super) const BLOCK: usize = 128 << 10;
const ZLIB_LEVEL: u32 = 4;
/// Elements wider than this are not split, nor are blocks with fewer elements than the second.
const SPLIT_SIZE: usize = 16;
const SPLIT_ELEMENTS: usize = 128;

/// Decodes a chunk into all of `into`, or describes the fault.
pub(super) fn decode(chunk: &[u8], into: &mut [u8]) -> Result<(), String> {
    let expected = into.len();
    let word = |at: usize| {
        chunk
            .get(at..at + 4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)
    };
    let (Some(length), Some(block), Some(_)) = (word(4), word(8), word(12)) else {
        return Err(format!("a Blosc header of {} bytes", chunk.len()));
    };
    if length != expected {
        return Err(format!("a Blosc chunk of {length} bytes, not {expected}"));
    }
    let (flags, size) = (chunk[2], usize::from(chunk[3]).max(1));
    if flags & STORED != 0 {
        let plain = chunk.get(HEADER..HEADER + length).ok_or("too few bytes")?;
        into.copy_from_slice(plain);
        return Ok(());
    }
    if block == 0 || length == 0 {
        return Err(format!("Blosc blocks of {block} bytes"));
    }
    let block = block.min(length);
    let mut scratch = vec![0; block];
    for (index, into) in into.chunks_mut(block).enumerate() {
        let bytes = into.len();
        let whole = bytes == block;
        let split = flags & UNSPLIT == 0 && size <= SPLIT_SIZE && block / size >= SPLIT_ELEMENTS && whole;
        let shuffle = match (
            flags & BYTES_SHUFFLED != 0 && size > 1,
            flags & BITS_SHUFFLED != 0,
        ) {
            (true, _) => Some(unshuffle as fn(&[u8], usize, &mut [u8])),
            (_, true) => Some(unshuffle_bits as fn(&[u8], usize, &mut [u8])),
            _ => None,
        };
        let at = word(HEADER + 4 * index).ok_or("too few blocks")?;
        let parts = if split { size } else { 1 };
        match shuffle {
            None => decode_block(chunk, at, parts, flags >> 5, into)?,
            Some(unshuffle) => {
                decode_block(chunk, at, parts, flags >> 5, &mut scratch[..bytes])?;
                unshuffle(&scratch[..bytes], size, into);
            }
        }
    }
    Ok(())
}

/// Decodes the parts of a block that begins at a byte of the chunk.
fn decode_block(chunk: &[u8], mut at: usize, parts: usize, codec: u8, into: &mut [u8]) -> Result<(), String> {
    if !into.len().is_multiple_of(parts) {
        return Err(format!("a block of {} bytes in {parts} parts", into.len()));
    }
    let length = into.len() / parts;
    for into in into.chunks_exact_mut(length) {
        let head = chunk.get(at..).and_then(<[u8]>::split_first_chunk::<4>);
        let coded = head.and_then(|(count, rest)| rest.get(..u32::from_le_bytes(*count) as usize));
        let coded = coded.ok_or("a block outside the chunk")?;
        part(coded, codec, into)?;
        at += 4 + coded.len();
    }
    Ok(())
}

fn part(coded: &[u8], codec: u8, into: &mut [u8]) -> Result<(), String> {
    if coded.len() == into.len() {
        into.copy_from_slice(coded);
        return Ok(());
    }
    match codec {
        0 => blosclz(coded, into),
        1 => lz4(coded, into),
        3 => fill(&mut ZlibDecoder::new(coded), into),
        4 => zstd(coded, into),
        other => Err(format!("Blosc's compressor {other}")),
    }
}

/// Compresses bytes, which are elements of `size`, with their bits shuffled.
pub(super) fn encode(bytes: &[u8], size: usize, compressor: Compressor) -> Vec<u8> {
    let block = BLOCK.min(bytes.len()).max(1);
    let blocks = bytes.len().div_ceil(block);
    let flags = UNSPLIT | BITS_SHUFFLED | (compressor as u8) << 5;
    // Version 2 of the format, version 1 of the compressor's.
    let mut chunk = vec![2, 1, flags, size as u8];
    let word = |number: usize| (number as u32).to_le_bytes();
    for number in [bytes.len(), block, 0] {
        chunk.extend(word(number));
    }
    chunk.resize(HEADER + 4 * blocks, 0);
    let mut scratch = vec![0; block];
    for (index, plain) in bytes.chunks(block).enumerate() {
        let start = word(chunk.len());
        chunk[HEADER + 4 * index..][..4].copy_from_slice(&start);
        shuffle_bits(plain, size, &mut scratch[..plain.len()]);
        let shuffled = &scratch[..plain.len()];
        let coded = compressor.compress(shuffled);
        let kept = if coded.len() < plain.len() {
            &coded[..]
        } else {
            shuffled
        };
        chunk.extend(word(kept.len()));
        chunk.extend_from_slice(kept);
    }
    if chunk.len() >= HEADER + bytes.len() {
        chunk.truncate(HEADER);
        chunk[2] |= STORED;
        chunk.extend_from_slice(bytes);
    }
    let total = word(chunk.len());
    chunk[12..HEADER].copy_from_slice(&total);
    chunk
}

/// Compressors that chunks are written with, by their numbers in Blosc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    Lz4 = 1,
    Zlib = 3,
}

impl Compressor {
    fn compress(self, bytes: &[u8]) -> Vec<u8> {
        match self {
            Self::Lz4 => lz4_flex::block::compress(bytes),
            Self::Zlib => {
                let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::new(ZLIB_LEVEL));
                // Writing to memory cannot fail; if it did, the block would be stored as it is.
                let coded = encoder.write_all(bytes).and_then(|()| encoder.finish());
                coded.unwrap_or_else(|_| bytes.to_vec())
            }
        }
    }
}

/// `BloscLZ`, a relative of `FastLZ`: literals, and matches at up to 8191 bytes or, in a longer form, 73726.
fn blosclz(coded: &[u8], into: &mut [u8]) -> Result<(), String> {
    const NEAR: usize = 8191;
    let cut = || "a BloscLZ block that ends early".to_owned();
    let long = || "a BloscLZ block that is too long".to_owned();
    let mut bytes = coded.iter().map(|&byte| usize::from(byte));
    let mut control = bytes.next().ok_or_else(cut)? & 31;
    let mut end = 0;
    loop {
        if control < 32 {
            for _ in 0..=control {
                *into.get_mut(end).ok_or_else(long)? = bytes.next().ok_or_else(cut)? as u8;
                end += 1;
            }
        } else {
            let mut count = (control >> 5) + 2;
            if control >> 5 == 7 {
                loop {
                    let more = bytes.next().ok_or_else(cut)?;
                    count += more;
                    if more != 255 {
                        break;
                    }
                }
            }
            let high = control & 31;
            let low = bytes.next().ok_or_else(cut)?;
            let distance = match (high, low) {
                (31, 255) => {
                    let far = bytes.next().ok_or_else(cut)? << 8;
                    (far | bytes.next().ok_or_else(cut)?) + NEAR + 1
                }
                _ => (high << 8 | low) + 1,
            };
            if distance > end || count > into.len() - end {
                return Err("a BloscLZ match outside its block".to_owned());
            }
            for _ in 0..count {
                into[end] = into[end - distance];
                end += 1;
            }
        }
        match bytes.next() {
            Some(next) => control = next,
            None if end == into.len() => return Ok(()),
            None => return Err(cut()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(chunk: &[u8], length: usize) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; length];
        decode(chunk, &mut bytes).map(|()| bytes)
    }

    /// Chunks that c-blosc 1.21 made of the same 700 words, in blocks of 512 bytes.
    #[test]
    fn chunks_of_the_library_decode() {
        let word = |i: u32| (i / 7 * 3 + if i > 500 { i * 7919 % 251 } else { 0 }) as u16;
        let expected: Vec<u8> = (0..700).flat_map(|i| word(i).to_le_bytes()).collect();
        let shuffled_blosclz = include_bytes!("../../../tests/fixtures/blosclz1.blosc");
        let shuffled_lz4 = include_bytes!("../../../tests/fixtures/lz41.blosc");
        let bits_zstd = include_bytes!("../../../tests/fixtures/zstd2.blosc");
        for chunk in [&shuffled_blosclz[..], shuffled_lz4, bits_zstd] {
            assert_eq!(decoded(chunk, expected.len()).unwrap(), expected);
            assert!(decoded(chunk, expected.len() + 1).is_err());
            for length in 0..chunk.len() {
                assert!(decoded(&chunk[..length], expected.len()).is_err(), "{length}");
            }
        }
    }

    #[test]
    fn chunks_come_back_whatever_their_size() {
        for size in [1, 2, 4, 8] {
            for count in [1, 7, 8, 64, 70_000] {
                for noise in [0, 255] {
                    let bytes: Vec<u8> = (0..count * size)
                        .map(|i| {
                            (i / 50) as u8
                                ^ ((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as u8 & noise
                        })
                        .collect();
                    for compressor in [Compressor::Lz4, Compressor::Zlib] {
                        let chunk = encode(&bytes, size, compressor);
                        assert!(chunk.len() <= HEADER + bytes.len());
                        assert_eq!(
                            decoded(&chunk, bytes.len()).unwrap(),
                            bytes,
                            "{size} {count} {noise}"
                        );
                    }
                }
            }
        }
    }
}
