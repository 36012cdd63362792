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

    /// At most `expected` bytes, or a description of the fault.
    fn decode(self, bytes: &[u8], expected: usize) -> Result<Vec<u8>, String> {
        // One byte more than expected shows that there are too many.
        let limit = expected as u64 + 1;
        let read = |reader: &mut dyn Read| {
            let mut decoded = Vec::new();
            let result = reader.take(limit).read_to_end(&mut decoded);
            result.map(|_| decoded).map_err(|error| error.to_string())
        };
        match self {
            Self::Blosc => blosc::decode(bytes, expected),
            Self::Gzip => read(&mut GzDecoder::new(bytes)),
            Self::Zlib => read(&mut ZlibDecoder::new(bytes)),
            Self::Zstd => zstd(bytes, expected),
            Self::Lz4 => lz4(bytes.get(4..).unwrap_or_default(), expected),
            Self::Crc32c => {
                let (data, sum) = bytes.split_last_chunk::<4>().ok_or("no checksum")?;
                match crc32c(data) == u32::from_le_bytes(*sum) {
                    true => Ok(data.to_vec()),
                    false => Err("a wrong checksum".to_owned()),
                }
            }
        }
    }
}

/// Undoes `codecs` (in the order of writing); the result has `expected` bytes.
pub(super) fn decode(bytes: &[u8], codecs: &[Codec], expected: usize) -> Result<Vec<u8>, String> {
    let mut decoded = bytes.to_vec();
    for (index, codec) in codecs.iter().enumerate().rev() {
        // Checksums behind the first codec make data longer than the samples.
        let slack = 4 * codecs[..index]
            .iter()
            .filter(|codec| **codec == Codec::Crc32c)
            .count();
        decoded = codec.decode(&decoded, expected + slack)?;
    }
    match decoded.len() == expected {
        true => Ok(decoded),
        false => Err(format!("{} bytes in place of {expected}", decoded.len())),
    }
}

/// One block of LZ4.
pub(super) fn lz4(coded: &[u8], length: usize) -> Result<Vec<u8>, String> {
    // A byte decodes to 255 at most.
    if length > coded.len().saturating_mul(255) {
        return Err(format!("{} bytes of LZ4 for {length}", coded.len()));
    }
    lz4_flex::block::decompress(coded, length).map_err(|error| error.to_string())
}

/// Frames of Zstandard, up to `length` bytes and one.
pub(super) fn zstd(coded: &[u8], length: usize) -> Result<Vec<u8>, String> {
    let mut decoder = ruzstd::decoding::StreamingDecoder::new(coded).map_err(|error| error.to_string())?;
    let mut decoded = Vec::new();
    let mut limited = (&mut decoder).take(length as u64 + 1);
    limited
        .read_to_end(&mut decoded)
        .map_err(|error| error.to_string())?;
    Ok(decoded)
}

/// RFC 3720, B.4: polynomial 0x1edc6f41, reflected.
pub(super) fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            crc >> 1 ^ if crc & 1 == 1 { 0x82f6_3b78 } else { 0 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_rfc() {
        // RFC 3720, B.4: 32 zeros, and the bytes 0 to 31.
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&(0..32).collect::<Vec<u8>>()), 0x46dd_794e);
    }
}
