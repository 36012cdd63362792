//! Pages that the decoder of the others does not read: those compressed by Zstandard, and those whose samples are places in a
//! palette. Strips or tiles of interleaved samples, with the predictors of TIFF 6.0 (section 14) and of its technical note 3
//! (floats).

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};

use flate2::read::ZlibDecoder;
use splatvol_scene::Samples;
use tiff::decoder::{ChunkType, Decoder};
use tiff::tags::Tag;

use super::{PageHead, SLACK, bad};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleBuffer};
use crate::source::Source;

/// Compression by Zstandard.
const ZSTD: u64 = 50_000;

/// A tile may be larger than its page by this factor, and by [`SLACK`] bytes.
const MOST_SPARE: u64 = 4;

/// True for pages that are read here.
pub(super) fn reads(head: &PageHead) -> bool {
    head.compression == ZSTD || head.palette
}

/// The samples of the current page.
pub(super) fn read(
    decoder: &mut Decoder<BufReader<File>>,
    head: &PageHead,
    context: &Context<'_>,
) -> Result<Samples, IoError> {
    if head.half {
        return Err(context.unsupported("half floats in a palette, or compressed by zstd"));
    }
    let tags = match decoder.get_chunk_type() {
        ChunkType::Strip => [Tag::StripOffsets, Tag::StripByteCounts],
        ChunkType::Tile => [Tag::TileOffsets, Tag::TileByteCounts],
    };
    let mut numbers = |tag| {
        let found = decoder.find_tag_unsigned_vec::<u64>(tag);
        Ok::<_, IoError>(found.map_err(|error| bad(error, context))?.unwrap_or_default())
    };
    let (offsets, counts) = (numbers(tags[0])?, numbers(tags[1])?);
    let predictor = numbers(Tag::Predictor)?.first().copied().unwrap_or(1);
    let (width, height) = decoder.chunk_dimensions();
    let (width, height) = (width as usize, height as usize);
    let pixel = head.components * head.sample_type.size();
    let whole = width.saturating_mul(height).saturating_mul(pixel);
    if whole == 0 || whole as u64 > MOST_SPARE.saturating_mul(head.bytes()).saturating_add(SLACK) {
        let found = format!("{width} x {height}");
        return Err(context.field(
            "size of strips or tiles",
            found,
            None,
            "about that of the page or less",
        ));
    }
    let across = head.size[0].div_ceil(width.max(1));
    let needed = across.saturating_mul(head.size[1].div_ceil(height.max(1)));
    if offsets.len() < needed || counts.len() < needed {
        let found = format!("{} and {}", offsets.len(), counts.len());
        return Err(context.field(
            "offsets and lengths of strips or tiles",
            found,
            None,
            format!("{needed} each"),
        ));
    }
    let mut image = vec![0; head.size[0] * head.size[1] * pixel];
    for index in 0..needed {
        let (left, top) = (index % across * width, index / across * height);
        let shown = [width.min(head.size[0] - left), height.min(head.size[1] - top)];
        // The last strip is as high as the rest of the image, tiles are whole.
        let rows = if tags[0] == Tag::StripOffsets {
            shown[1]
        } else {
            height
        };
        let coded = bytes(decoder, [offsets[index], counts[index]], context)?;
        let mut chunk = decompress((&coded, head.compression), width * rows * pixel, context)?;
        for row in chunk.chunks_exact_mut(width * pixel) {
            undo(row, head, predictor, context)?;
        }
        for y in 0..shown[1] {
            let from = y * width * pixel;
            let to = ((top + y) * head.size[0] + left) * pixel;
            let length = shown[0] * pixel;
            image[to..to + length].copy_from_slice(&chunk[from..from + length]);
        }
    }
    let count = head.size[0] * head.size[1] * head.components;
    let mut buffer = SampleBuffer::new(head.sample_type, Endian::Little);
    buffer.read(&mut Source::from_bytes(&image), count, context)?;
    Ok(buffer.finish().0)
}

fn bytes(
    decoder: &mut Decoder<BufReader<File>>,
    [offset, count]: [u64; 2],
    context: &Context<'_>,
) -> Result<Vec<u8>, IoError> {
    let file = decoder.inner();
    file.seek(SeekFrom::Start(offset))
        .map_err(|error| context.read(error))?;
    let mut coded = Vec::new();
    file.take(count)
        .read_to_end(&mut coded)
        .map_err(|error| context.read(error))?;
    match coded.len() as u64 == count {
        true => Ok(coded),
        false => Err(context.truncated("strip or tile", count, coded.len() as u64)),
    }
}

/// Exactly `length` bytes.
fn decompress(
    (coded, compression): (&[u8], u64),
    length: usize,
    context: &Context<'_>,
) -> Result<Vec<u8>, IoError> {
    let corrupt = |error: String| context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error));
    let mut decoded = Vec::new();
    let limit = length as u64;
    let result = match compression {
        1 => coded.take(limit).read_to_end(&mut decoded),
        8 | 32_946 => ZlibDecoder::new(coded).take(limit).read_to_end(&mut decoded),
        32_773 => {
            unpack(coded, length, &mut decoded);
            Ok(decoded.len())
        }
        ZSTD => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(coded);
            let decoder = decoder.map_err(|error| corrupt(error.to_string()))?;
            decoder.take(limit).read_to_end(&mut decoded)
        }
        other => return Err(context.unsupported(format!("a palette with samples of compression {other}"))),
    };
    result.map_err(|error| corrupt(error.to_string()))?;
    match decoded.len() == length {
        true => Ok(decoded),
        false => Err(context.truncated("strip or tile", limit, decoded.len() as u64)),
    }
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

/// Undoes the predictor of a row, and makes its samples little-endian.
fn undo(row: &mut [u8], head: &PageHead, predictor: u64, context: &Context<'_>) -> Result<(), IoError> {
    let size = head.sample_type.size();
    let before = head.components * size;
    if predictor == 3 {
        for index in head.components..row.len() {
            row[index] = row[index].wrapping_add(row[index - head.components]);
        }
        // The highest bytes of all samples come first.
        let (shuffled, count) = (row.to_vec(), row.len() / size);
        for (index, byte) in row.iter_mut().enumerate() {
            *byte = shuffled[(size - 1 - index % size) * count + index / size];
        }
        return Ok(());
    }
    if head.endian == Endian::Big {
        row.chunks_exact_mut(size).for_each(<[u8]>::reverse);
    }
    match predictor {
        1 => Ok(()),
        2 => {
            for index in (before..row.len()).step_by(size) {
                let mut carry = 0;
                for byte in index..index + size {
                    let sum = u16::from(row[byte]) + u16::from(row[byte - before]) + carry;
                    row[byte] = sum as u8;
                    carry = sum >> 8;
                }
            }
            Ok(())
        }
        other => Err(context.field("Predictor", other, None, "1, 2 or 3")),
    }
}
