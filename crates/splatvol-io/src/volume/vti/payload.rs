//! The numbers of one array of a .vti file.
//!
//! Binary data are a header of words (4 or 8 bytes each, in the file's byte order) and the data themselves. Plain: one
//! word, the number of bytes. Compressed: number of blocks, bytes per block, bytes of the last block (0: a whole one),
//! compressed bytes of each block; then the blocks, one zlib stream or bare LZ4 block each. In base64 the two parts may
//! be encoded separately, which the padding in the middle shows.

use std::borrow::Cow;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use splatvol_scene::Samples;

use super::document::{Coding, Compressor, Place};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleBuffer, SampleType, decode_text};
use crate::source::{Codec, Rest, Source};

/// `count` numbers from `place`, and a warning if they lost digits.
pub(crate) fn samples(
    place: &Place<'_>,
    (sample_type, count): (SampleType, usize),
    coding: Coding,
    appended: Option<&[u8]>,
    context: &Context<'_>,
) -> Result<(Samples, Option<String>), IoError> {
    if let Place::Ascii(text) = place {
        let (samples, warning, used) = decode_text(text.as_bytes(), sample_type, count, 0, context)?;
        if !text[used..].trim().is_empty() {
            let expected = format!("{count} numbers, no more");
            return Err(context.field("DataArray", &text[used..], None, expected));
        }
        return Ok((samples, warning));
    }
    let mut buffer = SampleBuffer::new(sample_type, coding.endian);
    let take = |source: &mut Source<'_>, samples| buffer.read(source, samples, context);
    each_part(place, (sample_type, count), coding, appended, (context, take))?;
    Ok(buffer.finish())
}

/// Passes the bytes of `count` numbers on, part by part: sources, and how many numbers each has. `None` for text.
pub(super) fn each_part(
    place: &Place<'_>,
    (sample_type, count): (SampleType, usize),
    coding: Coding,
    appended: Option<&[u8]>,
    (context, mut take): (
        &Context<'_>,
        impl FnMut(&mut Source<'_>, usize) -> Result<(), IoError>,
    ),
) -> Result<Option<()>, IoError> {
    let encoded = match place {
        Place::Ascii(_) => return Ok(None),
        Place::Base64(text) => Cow::Owned(from_base64(text.as_bytes(), context)?),
        Place::Appended { offset, next } => from_appended(appended, (*offset, *next), coding, context)?,
    };
    match coding.compressor {
        Some(compressor) => {
            let blocks = Blocks { compressor, coding };
            blocks.each(&encoded, (sample_type, count), context, take)?;
        }
        None => {
            let plain = plain(&encoded, (sample_type, count), coding, context)?;
            take(&mut Source::from_bytes(plain), count)?;
        }
    }
    Ok(Some(()))
}

/// The bytes behind the header of data that are not compressed.
fn plain<'a>(
    encoded: &'a [u8],
    (sample_type, count): (SampleType, usize),
    coding: Coding,
    context: &Context<'_>,
) -> Result<&'a [u8], IoError> {
    let mut words = Words::new(encoded, coding);
    let (declared, expected) = (words.next(context)?, sample_type.byte_count(count));
    match declared == expected {
        true => Ok(words.rest),
        false => {
            let expected = format!("{expected} for the extent");
            Err(context.field("bytes of data", declared, None, expected))
        }
    }
}

/// The number in a word of a header.
pub(super) fn number(word: &[u8], coding: Coding, context: &Context<'_>) -> Result<u64, IoError> {
    Words::new(word, coding).next(context)
}

/// The data at an offset, without their base64.
fn from_appended<'a>(
    appended: Option<&'a [u8]>,
    (offset, next): (u64, Option<u64>),
    coding: Coding,
    context: &Context<'_>,
) -> Result<Cow<'a, [u8]>, IoError> {
    let appended =
        appended.ok_or_else(|| context.field("AppendedData", "", None, "an <AppendedData> element"))?;
    let tail = usize::try_from(offset)
        .ok()
        .and_then(|offset| appended.get(offset..))
        .ok_or_else(|| {
            let expected = format!("at most {}, the length of the appended data", appended.len());
            context.field("offset", offset, None, expected)
        })?;
    if !coding.appended_base64 {
        return Ok(Cow::Borrowed(tail));
    }
    let length = next.map_or(tail.len(), |next| tail.len().min((next - offset) as usize));
    let text = &tail[..length];
    let end = text.iter().position(|&byte| byte == b'<').unwrap_or(length);
    Ok(Cow::Owned(from_base64(&text[..end], context)?))
}

fn from_base64(text: &[u8], context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let letters: Vec<u8> = text
        .iter()
        .copied()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    let mut decoded = Vec::with_capacity(letters.len() / 4 * 3 + 3);
    let mut rest = letters.as_slice();
    while !rest.is_empty() {
        let end = rest.iter().position(|&byte| byte == b'=').unwrap_or(rest.len());
        let padding = rest[end..].iter().take_while(|&&byte| byte == b'=').count();
        let (part, after) = rest.split_at(end + padding);
        STANDARD
            .decode_vec(part, &mut decoded)
            .map_err(|error| context.field("base64", error, None, "valid base64"))?;
        rest = after;
    }
    Ok(decoded)
}

/// Compressed blocks, and their coding.
struct Blocks {
    compressor: Compressor,
    coding: Coding,
}

impl Blocks {
    /// Passes blocks on, decompressed, and how many numbers each has.
    fn each(
        &self,
        encoded: &[u8],
        (sample_type, count): (SampleType, usize),
        context: &Context<'_>,
        mut take: impl FnMut(&mut Source<'_>, usize) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let coding = self.coding;
        let mut words = Words::new(encoded, coding);
        let (blocks, size, last) = (words.next(context)?, words.next(context)?, words.next(context)?);
        let last = if last == 0 { size } else { last };
        let whole = blocks
            .checked_sub(1)
            .and_then(|whole| whole.checked_mul(size)?.checked_add(last));
        let width = sample_type.size() as u64;
        if whole != Some(sample_type.byte_count(count)) || last > size || blocks > 1 && size % width != 0 {
            let found = format!("{blocks} of {size} bytes, the last of {last}");
            let expected = format!(
                "blocks of whole samples, {} bytes in all",
                sample_type.byte_count(count)
            );
            return Err(context.field("compressed blocks", found, None, expected));
        }
        let lengths_of_blocks = blocks.saturating_mul(coding.header_word as u64);
        let (mut lengths, mut rest) = usize::try_from(lengths_of_blocks)
            .ok()
            .and_then(|length| words.rest.split_at_checked(length))
            .map(|(lengths, rest)| (Words::new(lengths, coding), rest))
            .ok_or_else(|| {
                context.truncated(
                    "lengths of the blocks",
                    lengths_of_blocks,
                    words.rest.len() as u64,
                )
            })?;
        for block in 1..=blocks {
            let length = lengths.next(context)?;
            let (stream, after) = usize::try_from(length)
                .ok()
                .and_then(|length| rest.split_at_checked(length))
                .ok_or_else(|| context.truncated("compressed blocks", length, rest.len() as u64))?;
            rest = after;
            let bytes = if block == blocks { last } else { size };
            let samples = bytes / width;
            let plain;
            let mut source = match self.compressor {
                Compressor::Zlib => Source::from_bytes(stream).inflate(Codec::Zlib),
                Compressor::Lz4 => {
                    plain = from_lz4(stream, bytes, context)?;
                    Source::from_bytes(&plain)
                }
            };
            take(&mut source, samples as usize)?;
            if source.rest(context)? != Rest::Nothing {
                let found = format!("more than {} bytes", samples * width);
                return Err(context.field(format!("block {block} of {blocks}"), found, None, "as declared"));
            }
        }
        Ok(())
    }
}

/// A bare LZ4 block. One of its bytes decodes to 255 at most.
fn from_lz4(stream: &[u8], bytes: u64, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
    let most = (stream.len() as u64).saturating_mul(255);
    if bytes > most {
        return Err(context.too_small("LZ4 blocks", bytes, most));
    }
    lz4_flex::block::decompress(stream, bytes as usize)
        .map_err(|error| context.read(std::io::Error::other(error)))
}

/// The numbers of a header of data.
struct Words<'a> {
    rest: &'a [u8],
    coding: Coding,
}

impl<'a> Words<'a> {
    fn new(bytes: &'a [u8], coding: Coding) -> Self {
        Self { rest: bytes, coding }
    }

    fn next(&mut self, context: &Context<'_>) -> Result<u64, IoError> {
        let size = self.coding.header_word;
        let (word, rest) = self
            .rest
            .split_at_checked(size)
            .ok_or_else(|| context.truncated("header of the data", size as u64, self.rest.len() as u64))?;
        self.rest = rest;
        let join = |value: u64, &byte: &u8| value << 8 | u64::from(byte);
        Ok(match self.coding.endian {
            Endian::Little => word.iter().rev().fold(0, join),
            Endian::Big => word.iter().fold(0, join),
        })
    }
}
