//! Chunks of Blosc 1 (<https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>): blocks, split by the bytes
//! of their elements, shuffled, and compressed by LZ4, zlib, Zstandard or `BloscLZ`. Existing crates bring the library
//! in C.

use std::io::Read;

use flate2::bufread::ZlibDecoder;

const HEADER: usize = 16;
/// Elements wider than this are not split, nor are blocks with fewer elements than the second.
const SPLIT_SIZE: usize = 16;
const SPLIT_ELEMENTS: usize = 128;

/// The `expected` bytes of a chunk, or a description of the fault.
pub(super) fn decode(chunk: &[u8], expected: usize) -> Result<Vec<u8>, String> {
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
    if flags & 2 != 0 {
        let plain = chunk.get(HEADER..HEADER + length);
        return plain
            .map(<[u8]>::to_vec)
            .ok_or_else(|| "too few bytes".to_owned());
    }
    if block == 0 || length == 0 {
        return Err(format!("Blosc blocks of {block} bytes"));
    }
    let mut decoded = Vec::new();
    let mut scratch = Vec::new();
    for index in 0..length.div_ceil(block) {
        let bytes = block.min(length - index * block);
        let whole = bytes == block;
        let split = flags & 0x10 == 0 && size <= SPLIT_SIZE && block / size >= SPLIT_ELEMENTS && whole;
        let parts = if split { size } else { 1 };
        let mut at = word(HEADER + 4 * index).ok_or("too few blocks")?;
        scratch.clear();
        for _ in 0..parts {
            let coded = word(at).and_then(|coded| chunk.get(at + 4..)?.get(..coded));
            let coded = coded.ok_or("a block outside the chunk")?;
            part(coded, bytes / parts, flags >> 5, &mut scratch)?;
            at += 4 + coded.len();
        }
        if scratch.len() != bytes {
            return Err(format!("a block of {} bytes, not {bytes}", scratch.len()));
        }
        match (flags & 1 != 0 && size > 1, flags & 4 != 0) {
            (true, _) => unshuffle(&scratch, size, &mut decoded),
            (_, true) => unshuffle_bits(&scratch, size, &mut decoded),
            _ => decoded.extend_from_slice(&scratch),
        }
    }
    Ok(decoded)
}

fn part(coded: &[u8], length: usize, codec: u8, into: &mut Vec<u8>) -> Result<(), String> {
    if coded.len() == length {
        into.extend_from_slice(coded);
        return Ok(());
    }
    let start = into.len();
    match codec {
        0 => blosclz(coded, length, into)?,
        1 => into.extend(super::codec::lz4(coded, length)?),
        3 => {
            let mut decoder = ZlibDecoder::new(coded).take(length as u64);
            decoder.read_to_end(into).map_err(|error| error.to_string())?;
        }
        4 => into.extend(super::codec::zstd(coded, length)?),
        other => return Err(format!("Blosc's compressor {other}")),
    }
    match into.len() == start + length {
        true => Ok(()),
        false => Err(format!("{} bytes in place of {length}", into.len() - start)),
    }
}

/// Byte j of element i is at `j n + i`; bytes behind the last element are as they were.
fn unshuffle(bytes: &[u8], size: usize, into: &mut Vec<u8>) {
    let count = bytes.len() / size;
    for element in 0..count {
        into.extend((0..size).map(|byte| bytes[byte * count + element]));
    }
    into.extend_from_slice(&bytes[count * size..]);
}

/// Bit b of byte j of element i is bit `i mod 8` of byte `(8 j + b) n / 8 + i / 8`. The library leaves blocks as they
/// are if their number of elements is not a multiple of eight.
fn unshuffle_bits(bytes: &[u8], size: usize, into: &mut Vec<u8>) {
    let row = if (bytes.len() / size).is_multiple_of(8) {
        bytes.len() / size / 8
    } else {
        0
    };
    for element in 0..row * 8 {
        for byte in 0..size {
            let bit = |b: usize| (bytes[(8 * byte + b) * row + element / 8] >> (element % 8) & 1) << b;
            into.push((0..8).map(bit).sum());
        }
    }
    into.extend_from_slice(&bytes[row * 8 * size..]);
}

/// `BloscLZ`, a relative of `FastLZ`: literals, and matches at up to 8191 bytes or, in a longer form, 73726.
fn blosclz(coded: &[u8], length: usize, into: &mut Vec<u8>) -> Result<(), String> {
    const NEAR: usize = 8191;
    let start = into.len();
    let end = start + length;
    let mut bytes = coded.iter().map(|&byte| usize::from(byte));
    let cut = || "a BloscLZ block that ends early".to_owned();
    let mut control = bytes.next().ok_or_else(cut)? & 31;
    loop {
        if control < 32 {
            for _ in 0..=control {
                into.push(bytes.next().ok_or_else(cut)? as u8);
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
            if distance > into.len() - start || count > end - into.len() {
                return Err("a BloscLZ match outside its block".to_owned());
            }
            for _ in 0..count {
                into.push(into[into.len() - distance]);
            }
        }
        match bytes.next() {
            Some(next) => control = next,
            None => return Ok(()),
        }
        if into.len() > end {
            return Err("a BloscLZ block that is too long".to_owned());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chunks that c-blosc 1.21 made of the same 700 words, in blocks of 512 bytes.
    #[test]
    fn chunks_of_the_library_decode() {
        let word = |i: u32| (i / 7 * 3 + if i > 500 { i * 7919 % 251 } else { 0 }) as u16;
        let expected: Vec<u8> = (0..700).flat_map(|i| word(i).to_le_bytes()).collect();
        let shuffled_blosclz = include_bytes!("../../../tests/fixtures/blosclz1.blosc");
        let shuffled_lz4 = include_bytes!("../../../tests/fixtures/lz41.blosc");
        let bits_zstd = include_bytes!("../../../tests/fixtures/zstd2.blosc");
        for chunk in [&shuffled_blosclz[..], shuffled_lz4, bits_zstd] {
            assert_eq!(decode(chunk, expected.len()).unwrap(), expected);
            assert!(decode(chunk, expected.len() + 1).is_err());
            for length in 0..chunk.len() {
                assert!(decode(&chunk[..length], expected.len()).is_err(), "{length}");
            }
        }
    }

    #[test]
    fn bits_come_back_to_their_elements() {
        let plain: Vec<u8> = (0..48u8).map(|i| i.wrapping_mul(37) ^ 11).collect();
        let mut shuffled = vec![0; 48];
        for (i, byte) in plain.iter().enumerate() {
            let (element, of_element) = (i / 3, i % 3);
            for bit in 0..8 {
                shuffled[(8 * of_element + bit) * 2 + element / 8] |= (byte >> bit & 1) << (element % 8);
            }
        }
        let mut found = Vec::new();
        unshuffle_bits(&shuffled, 3, &mut found);
        assert_eq!(found, plain);
    }
}
