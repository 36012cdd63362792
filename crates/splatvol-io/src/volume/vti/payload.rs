//! The numbers of one array of a .vti file.
//!
//! Binary data are a header of words (4 or 8 bytes each, in the file's byte order) and the data themselves. Plain: one
//! word, the number of bytes. Compressed: number of blocks, bytes per block, bytes of the last block (0: a whole one),
//! compressed bytes of each block; then the blocks, one zlib stream or bare LZ4 block each. In base64 the two parts may
//! be encoded separately, which the padding in the middle shows.

use splatvol_scene::Samples;

use super::base64_text::Base64Reader;
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
    let encoded = match place {
        Place::Ascii(text) => {
            let (samples, warning, used) = decode_text(text.as_bytes(), sample_type, count, 0, context)?;
            if !text[used..].trim().is_empty() {
                let expected = format!("{count} numbers, no more");
                return Err(context.field("DataArray", &text[used..], None, expected));
            }
            return Ok((samples, warning));
        }
        Place::Base64(text) => from_base64(Source::from_bytes(text.as_bytes())),
        Place::Appended { offset, next } => {
            let section = section(appended, (*offset, *next), coding, context)?;
            coding.unwrap(Source::from_bytes(section))
        }
    };
    let mut buffer = SampleBuffer::new(sample_type, coding.endian);
    let take = |source: &mut Source<'_>, samples| buffer.read(source, samples, context);
    each_part(encoded, (sample_type, count), coding, (context, take))?;
    Ok(buffer.finish())
}

impl Coding {
    /// The bytes of appended data, without their base64.
    pub(super) fn unwrap<'a>(&self, appended: Source<'a>) -> Source<'a> {
        match self.appended_base64 {
            true => from_base64(appended),
            false => appended,
        }
    }
}

/// Passes the bytes of `count` numbers on, part by part: sources, and how many numbers each has.
pub(super) fn each_part(
    mut encoded: Source<'_>,
    (sample_type, count): (SampleType, usize),
    coding: Coding,
    (context, mut take): (
        &Context<'_>,
        impl FnMut(&mut Source<'_>, usize) -> Result<(), IoError>,
    ),
) -> Result<(), IoError> {
    if let Some(compressor) = coding.compressor {
        let blocks = Blocks { compressor, coding };
        return blocks.each(encoded, (sample_type, count), context, take);
    }
    let (declared, expected) = (
        number(&mut encoded, coding, context)?,
        sample_type.byte_count(count),
    );
    match declared == expected {
        true => take(&mut encoded, count),
        false => {
            let expected = format!("{expected} for the extent");
            Err(context.field("bytes of data", declared, None, expected))
        }
    }
}

/// The data at an offset, in base64 up to the next ones.
fn section<'a>(
    appended: Option<&'a [u8]>,
    (offset, next): (u64, Option<u64>),
    coding: Coding,
    context: &Context<'_>,
) -> Result<&'a [u8], IoError> {
    let appended =
        appended.ok_or_else(|| context.field("AppendedData", "", None, "an <AppendedData> element"))?;
    let tail = usize::try_from(offset)
        .ok()
        .and_then(|offset| appended.get(offset..))
        .ok_or_else(|| {
            let expected = format!("at most {}, the length of the appended data", appended.len());
            context.field("offset", offset, None, expected)
        })?;
    let length = next.filter(|_| coding.appended_base64);
    Ok(length.map_or(tail, |next| &tail[..tail.len().min((next - offset) as usize)]))
}

/// The bytes of a text of base64, which ends with the source or before the next tag.
pub(super) fn from_base64(text: Source<'_>) -> Source<'_> {
    let at_most = text.at_most() / 4 * 3 + 3;
    Source::bounded(Base64Reader::new(text), at_most)
}

/// The next number of a header.
pub(super) fn number(source: &mut Source<'_>, coding: Coding, context: &Context<'_>) -> Result<u64, IoError> {
    let mut word = [0; 8];
    let word = &mut word[..coding.header_word];
    let found = source.fill(word, context)?;
    if found < word.len() {
        return Err(context.truncated("header of the data", word.len() as u64, found as u64));
    }
    let join = |value: u64, &byte: &u8| value << 8 | u64::from(byte);
    Ok(match coding.endian {
        Endian::Little => word.iter().rev().fold(0, join),
        Endian::Big => word.iter().fold(0, join),
    })
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
        mut encoded: Source<'_>,
        (sample_type, count): (SampleType, usize),
        context: &Context<'_>,
        mut take: impl FnMut(&mut Source<'_>, usize) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        let coding = self.coding;
        let mut next = || number(&mut encoded, coding, context);
        let (blocks, size, last) = (next()?, next()?, next()?);
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
        let header = blocks.saturating_mul(coding.header_word as u64);
        let lengths = encoded.read_bytes("lengths of the blocks", header, context)?;
        let mut lengths = Source::from_bytes(&lengths);
        for block in 1..=blocks {
            let length = number(&mut lengths, coding, context)?;
            encoded.check_declared("compressed blocks", length, context)?;
            let samples = if block == blocks { last } else { size } / width;
            let mut take = |source: &mut Source<'_>| {
                take(source, samples as usize)?;
                match source.rest(context)? {
                    Rest::Nothing => Ok(()),
                    Rest::Excess => {
                        let found = format!("more than {} bytes", samples * width);
                        Err(context.field(format!("block {block} of {blocks}"), found, None, "as declared"))
                    }
                }
            };
            match self.compressor {
                Compressor::Zlib => {
                    let mut stream = encoded.part(length);
                    take(&mut stream.part(length).inflate(Codec::Zlib))?;
                    // What stands behind the stream's end.
                    let left = stream.at_most();
                    stream.skip(left, context)?;
                }
                Compressor::Lz4 => {
                    let stream = encoded.read_bytes("compressed blocks", length, context)?;
                    let plain = from_lz4(&stream, samples * width, context)?;
                    take(&mut Source::from_bytes(&plain))?;
                }
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
