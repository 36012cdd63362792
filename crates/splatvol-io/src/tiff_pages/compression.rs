//! Strips and tiles without their compression.

use std::io::Read;

use flate2::read::ZlibDecoder;
use weezl::{BitOrder, LzwStatus};

use super::RATIO;
use crate::IoError;
use crate::error::Context;

pub(super) const NONE: u64 = 1;
const LZW: u64 = 5;
pub(super) const JPEG: u64 = 7;
const DEFLATE: u64 = 8;
const DEFLATE_OF_ADOBE: u64 = 32_946;
const PACK_BITS: u64 = 32_773;
const ZSTD: u64 = 50_000;

/// Compressions and their names; a few of them are read.
const NAMES: &[(u64, &str)] = &[
    (NONE, "uncompressed"),
    (2, "CCITT RLE"),
    (3, "CCITT group 3"),
    (4, "CCITT group 4"),
    (LZW, "LZW"),
    (6, "old JPEG"),
    (JPEG, "JPEG"),
    (DEFLATE, "deflate"),
    (DEFLATE_OF_ADOBE, "deflate"),
    (PACK_BITS, "PackBits"),
    (33_003, "JPEG 2000"),
    (33_005, "JPEG 2000"),
    (34_712, "JPEG 2000"),
    (34_887, "LERC"),
    (34_925, "LZMA"),
    (ZSTD, "zstd"),
    (50_001, "WebP"),
    (50_002, "JPEG XL"),
    (22_610, "JPEG XR"),
    (34_934, "JPEG XR"),
    (52_546, "JPEG XL"),
];

/// Name of a compression.
pub(super) fn name(compression: u64) -> String {
    let known = NAMES.iter().find(|(number, _)| *number == compression);
    known.map_or_else(
        || format!("compression {compression}"),
        |(_, name)| (*name).to_owned(),
    )
}

/// Exactly `length` bytes.
pub(super) fn decompress(
    (coded, compression): (&[u8], u64),
    length: usize,
    context: &Context<'_>,
) -> Result<Vec<u8>, IoError> {
    let corrupt = |error: String| context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error));
    let limit = length as u64;
    let mut decoded = Vec::new();
    let result = match compression {
        NONE => coded.take(limit).read_to_end(&mut decoded),
        LZW => {
            decoded = lzw(coded, length).map_err(corrupt)?;
            Ok(decoded.len())
        }
        DEFLATE | DEFLATE_OF_ADOBE => ZlibDecoder::new(coded).take(limit).read_to_end(&mut decoded),
        PACK_BITS => {
            unpack(coded, length, &mut decoded);
            Ok(decoded.len())
        }
        ZSTD => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(coded);
            let decoder = decoder.map_err(|error| corrupt(error.to_string()))?;
            decoder.take(limit).read_to_end(&mut decoded)
        }
        other => return Err(context.unsupported(format!("samples compressed by {}", name(other)))),
    };
    result.map_err(|error| corrupt(error.to_string()))?;
    match decoded.len() == length {
        true => Ok(decoded),
        false => Err(context.truncated("strip or tile", limit, decoded.len() as u64)),
    }
}

/// LZW as TIFF 6.0 has it (section 13), up to `length` bytes. Writers may leave the end's code out.
fn lzw(coded: &[u8], length: usize) -> Result<Vec<u8>, String> {
    let most = (coded.len() as u64).saturating_mul(RATIO);
    let mut decoded = vec![0; length.min(usize::try_from(most).unwrap_or(usize::MAX))];
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
    let (mut read, mut written) = (0, 0);
    while written < decoded.len() {
        let step = decoder.decode_bytes(&coded[read..], &mut decoded[written..]);
        read += step.consumed_in;
        written += step.consumed_out;
        match step.status {
            Ok(LzwStatus::Ok) => {}
            Ok(LzwStatus::Done | LzwStatus::NoProgress) => break,
            Err(error) => return Err(error.to_string()),
        }
    }
    decoded.truncate(written);
    Ok(decoded)
}

/// `PackBits` (TIFF 6.0, section 9), up to `length` bytes.
fn unpack(mut coded: &[u8], length: usize, decoded: &mut Vec<u8>) {
    while let Some((&head, rest)) = coded.split_first() {
        let left = length - decoded.len();
        match head {
            _ if left == 0 => return,
            0..=127 => {
                let count = (usize::from(head) + 1).min(rest.len());
                decoded.extend_from_slice(&rest[..count.min(left)]);
                coded = &rest[count..];
            }
            128 => coded = rest,
            _ => {
                let Some((&value, rest)) = rest.split_first() else {
                    return;
                };
                decoded.resize(decoded.len() + (257 - usize::from(head)).min(left), value);
                coded = rest;
            }
        }
    }
}
