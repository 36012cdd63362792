//! The codecs of chunks: what Zarr 2 calls compressor and filters, Zarr 3 codecs
//! (<https://zarr-specs.readthedocs.io>, <https://numcodecs.readthedocs.io>).

use std::io::Read;

use flate2::bufread::{GzDecoder, ZlibDecoder};
use serde_json::Value;

use super::blosc;

/// Codec between bytes and bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Codec {
    Blosc,
    Gzip,
    Zlib,
    Zstd,
    /// numcodecs: four bytes of length, then one LZ4 block.
    Lz4,
    Crc32c,
}

impl Codec {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Blosc => "Blosc",
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Zstd => "zstd",
            Self::Lz4 => "LZ4",
            Self::Crc32c => "crc32c",
        }
    }

    /// The codec of this name in either version.
    pub(super) fn from_name(name: &str) -> Option<Self> {
        Some(match name.trim_start_matches("numcodecs.") {
            "blosc" => Self::Blosc,
            "gzip" => Self::Gzip,
            "zlib" => Self::Zlib,
            "zstd" => Self::Zstd,
            "lz4" => Self::Lz4,
            "crc32c" => Self::Crc32c,
            _ => return None,
        })
    }

    /// The codec of a compressor's description in Zarr 2.
    pub(super) fn from_compressor(value: &Value) -> Option<Self> {
        Self::from_name(value.get("id")?.as_str()?)
    }

    /// Decodes into all of `into`, or describes the fault.
    fn decode(self, bytes: &[u8], into: &mut [u8]) -> Result<(), String> {
        match self {
            Self::Blosc => blosc::decode(bytes, into),
            Self::Gzip => fill(&mut GzDecoder::new(bytes), into),
            Self::Zlib => fill(&mut ZlibDecoder::new(bytes), into),
            Self::Zstd => zstd(bytes, into),
            Self::Lz4 => lz4(bytes.get(4..).unwrap_or_default(), into),
            Self::Crc32c => {
                let data = checked(bytes)?;
                let same = data.len() == into.len();
                same.then(|| into.copy_from_slice(data))
                    .ok_or_else(|| wrong_length(data.len(), into.len()))
            }
        }
    }
}

/// A codec that failed, if it is known, and a description of the fault.
pub(super) type Fault = (Option<Codec>, String);

/// Undoes `codecs`, which are in the order of writing; the result fills `into`.
pub(super) fn decode(bytes: &[u8], codecs: &[Codec], into: &mut [u8]) -> Result<(), Fault> {
    let Some((&last, before)) = codecs.split_last() else {
        return match bytes.len() == into.len() {
            true => {
                into.copy_from_slice(bytes);
                Ok(())
            }
            false => Err((None, wrong_length(bytes.len(), into.len()))),
        };
    };
    let fault = |reason| (Some(last), reason);
    if last == Codec::Crc32c {
        // A sum at the end is cut off without a copy.
        return decode(checked(bytes).map_err(fault)?, before, into);
    }
    if before.is_empty() {
        return last.decode(bytes, into).map_err(fault);
    }
    // Checksums behind the codecs before make data longer than the samples.
    let sums = before.iter().filter(|codec| **codec == Codec::Crc32c).count();
    if sums == before.len() {
        let mut decoded = vec![0; into.len() + 4 * sums];
        last.decode(bytes, &mut decoded).map_err(fault)?;
        return decode(&decoded, before, into);
    }
    let decoded = last.decode_some(bytes, into.len() + 4 * sums).map_err(fault)?;
    decode(&decoded, before, into)
}

impl Codec {
    /// Decodes what another codec has compressed before: up to `most` bytes, and a little more.
    fn decode_some(self, bytes: &[u8], most: usize) -> Result<Vec<u8>, String> {
        let most = most + most / 8 + 4096;
        let read = |reader: &mut dyn Read| {
            let mut decoded = Vec::new();
            let result = reader.take(most as u64).read_to_end(&mut decoded);
            result.map(|_| decoded).map_err(|error| error.to_string())
        };
        let length = |at: usize| {
            let length = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
            let length = length.map(|word: [u8; 4]| u32::from_le_bytes(word) as usize);
            length.filter(|&length| length <= most).ok_or("a wrong length")
        };
        let whole = |length: usize| {
            let mut decoded = vec![0; length];
            self.decode(bytes, &mut decoded).map(|()| decoded)
        };
        match self {
            Self::Gzip => read(&mut GzDecoder::new(bytes)),
            Self::Zlib => read(&mut ZlibDecoder::new(bytes)),
            Self::Zstd => read(&mut zstd_stream(bytes)?),
            Self::Blosc => whole(length(4)?),
            Self::Lz4 => whole(length(0)?),
            Self::Crc32c => Ok(checked(bytes)?.to_vec()),
        }
    }
}

fn wrong_length(found: usize, expected: usize) -> String {
    format!("{found} bytes in place of {expected}")
}

/// The bytes before a right checksum.
fn checked(bytes: &[u8]) -> Result<&[u8], String> {
    let (data, sum) = bytes.split_last_chunk::<4>().ok_or("no checksum")?;
    match crc32c::crc32c(data) == u32::from_le_bytes(*sum) {
        true => Ok(data),
        false => Err("a wrong checksum".to_owned()),
    }
}

/// Fills `into` from a stream that ends there.
pub(super) fn fill(reader: &mut dyn Read, into: &mut [u8]) -> Result<(), String> {
    reader.read_exact(into).map_err(|error| error.to_string())?;
    // Reading past the end also makes the decoder check its checksum.
    match reader.read(&mut [0]).map_err(|error| error.to_string())? {
        0 => Ok(()),
        _ => Err(format!("more than {} bytes", into.len())),
    }
}

/// One block of LZ4.
pub(super) fn lz4(coded: &[u8], into: &mut [u8]) -> Result<(), String> {
    let length = lz4_flex::block::decompress_into(coded, into).map_err(|error| error.to_string())?;
    match length == into.len() {
        true => Ok(()),
        false => Err(wrong_length(length, into.len())),
    }
}

/// Frames of Zstandard.
pub(super) fn zstd(coded: &[u8], into: &mut [u8]) -> Result<(), String> {
    fill(&mut zstd_stream(coded)?, into)
}

fn zstd_stream(coded: &[u8]) -> Result<impl Read, String> {
    ruzstd::decoding::StreamingDecoder::new(coded).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codecs_are_undone_from_the_last_to_the_first() {
        let sum = |bytes: &[u8]| [bytes, &crc32c::crc32c(bytes).to_le_bytes()[..]].concat();
        let lz4 = |bytes: &[u8]| {
            [
                &(bytes.len() as u32).to_le_bytes()[..],
                &lz4_flex::block::compress(bytes),
            ]
            .concat()
        };
        let plain = [7, 7, 7, 7, 7, 7, 7, 7, 7, 3, 2, 1];
        for (codecs, coded) in [
            (vec![], plain.to_vec()),
            (vec![Codec::Crc32c], sum(&plain)),
            (vec![Codec::Lz4], lz4(&plain)),
            (vec![Codec::Lz4, Codec::Crc32c], sum(&lz4(&plain))),
            (vec![Codec::Crc32c, Codec::Lz4], lz4(&sum(&plain))),
            (vec![Codec::Lz4, Codec::Lz4], lz4(&lz4(&plain))),
            (
                vec![Codec::Lz4, Codec::Crc32c, Codec::Crc32c, Codec::Lz4],
                lz4(&sum(&sum(&lz4(&plain)))),
            ),
        ] {
            let mut found = [0; 12];
            decode(&coded, &codecs, &mut found).unwrap();
            assert_eq!(found, plain, "{codecs:?}");
            let (codec, reason) = decode(&coded[..coded.len() - 1], &codecs, &mut found).unwrap_err();
            assert_eq!(codec, codecs.last().copied(), "{reason}");
            assert!(decode(&coded, &codecs, &mut [0; 11]).is_err(), "{codecs:?}");
        }
    }
}
