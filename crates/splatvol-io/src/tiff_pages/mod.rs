//! Pages of TIFF and `BigTIFF` files as samples (TIFF 6.0, and its technical notes 1 to 3).
//!
//! The `tiff` crate reads directories and JPEG; strips and tiles of all other compressions are decoded here. Its own
//! decoder turns white and black round without a word, refuses LZW in tiles that stick out of the page, and takes memory
//! by the header alone. Samples are returned as they are stored: places in a palette, and white where white is zero.
//!
//! | module | holds |
//! |---|---|
//! | [`page`] | the form of a page: size, type of its samples, compression |
//! | [`chunks`] | strips and tiles, put together |
//! | [`compression`] | the bytes of a strip or tile |
//! | [`predictor`] | differences between neighbours, undone; bits, unpacked |

mod chunks;
mod compression;
mod page;
mod predictor;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use splatvol_scene::Samples;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use crate::IoError;
use crate::error::Context;
use crate::samples::SampleBuffer;
use crate::source::Source;
pub(crate) use page::PageHead;

/// Best ratio of the compressions: deflate has 1032, LZW a little more on large images.
const RATIO: u64 = 1500;
/// Bytes that any file may hold, whatever its length.
const SLACK: u64 = 1 << 20;
/// Longest value of a tag.
const LONGEST_VALUE: u64 = 256 << 20;
/// Shortest page: a directory of no entries and the place of the next.
const DIRECTORY: u64 = 6;

/// The pages of a file.
pub(crate) struct Pages {
    decoder: Decoder<BufReader<File>>,
    length: u64,
    /// Bytes that the pages still to be read may have.
    budget: u64,
    current: usize,
}

impl Pages {
    /// Opens a regular file at its first page.
    pub(crate) fn open(path: &Path, context: &Context<'_>) -> Result<Self, IoError> {
        // Refuses anything but a regular file.
        let length = Source::open(path)?.at_most();
        let file = File::open(path).map_err(|error| context.read(error))?;
        let most = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
        let mut limits = Limits::default();
        limits.ifd_value_size = most(length.min(LONGEST_VALUE));
        limits.decoding_buffer_size = most(length.saturating_mul(RATIO).saturating_add(SLACK));
        limits.intermediate_buffer_size = limits.decoding_buffer_size;
        let decoder = Decoder::new(BufReader::new(file)).map_err(|error| bad(error, context))?;
        Ok(Self {
            decoder: decoder.with_limits(limits),
            length,
            budget: length.saturating_mul(RATIO).saturating_add(SLACK),
            current: 0,
        })
    }

    /// Length of the file in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// Number of pages. The last is the current one then.
    pub(crate) fn count(&mut self, context: &Context<'_>) -> Result<usize, IoError> {
        let mut count = 1;
        while self.decoder.more_images() {
            self.decoder.next_image().map_err(|error| bad(error, context))?;
            count += 1;
            if count as u64 > self.length / DIRECTORY {
                let expected = "as many as the file can hold";
                return Err(context.field("number of pages", count, None, expected));
            }
        }
        self.current = count - 1;
        Ok(count)
    }

    fn seek(&mut self, page: usize, context: &Context<'_>) -> Result<(), IoError> {
        if self.current != page {
            self.decoder
                .seek_to_image(page)
                .map_err(|error| bad(error, context))?;
            self.current = page;
        }
        Ok(())
    }

    /// A text of the current page.
    pub(crate) fn text(&mut self, tag: Tag) -> Option<String> {
        self.decoder.find_tag(tag).ok()??.into_string().ok()
    }

    /// Numbers of the current page; none where the tag is missing.
    pub(crate) fn numbers(&mut self, tag: Tag) -> Vec<f64> {
        self.decoder.get_tag_f64_vec(tag).unwrap_or_default()
    }

    /// Unsigned numbers of the current page; none where the tag is missing.
    fn unsigned(&mut self, tag: Tag, context: &Context<'_>) -> Result<Vec<u64>, IoError> {
        let found = self.decoder.find_tag_unsigned_vec(tag);
        Ok(found.map_err(|error| bad(error, context))?.unwrap_or_default())
    }

    /// World length per pixel along x and y, in the unit that a description names.
    pub(crate) fn resolution(&mut self) -> [Option<f64>; 2] {
        [Tag::XResolution, Tag::YResolution].map(|tag| {
            let value = match self.decoder.find_tag(tag).ok()?? {
                Value::Rational(over, under) => f64::from(over) / f64::from(under),
                other => other.into_f64().ok()?,
            };
            Some(1.0 / value).filter(|spacing| spacing.is_finite() && *spacing > 0.0)
        })
    }

    /// The form of a page, which is the current one then.
    pub(crate) fn head(&mut self, page: usize, context: &Context<'_>) -> Result<PageHead, IoError> {
        self.seek(page, context)?;
        PageHead::read(self, context)
    }

    /// Interleaved samples of the current page, row by row from the top.
    pub(crate) fn samples(&mut self, head: &PageHead, context: &Context<'_>) -> Result<Samples, IoError> {
        let needed = head.stored_bytes();
        let available = match head.compression {
            compression::NONE => self.length.min(self.budget),
            _ => self.budget,
        };
        if needed > available {
            return Err(context.too_small("samples", needed, available));
        }
        self.budget -= needed;
        let samples = match head.compression {
            compression::JPEG => of_jpeg(self.decoder.read_image().map_err(|error| bad(error, context))?),
            _ => chunks::read(self, head, context)?,
        };
        let expected = head.samples();
        match samples.len() == expected {
            true => Ok(samples),
            false => Err(context.truncated("samples", expected as u64, samples.len() as u64)),
        }
    }

    /// Pages that follow the first without headers, as ImageJ writes files of more than 4 GB.
    pub(crate) fn contiguous(
        &mut self,
        head: &PageHead,
        pages: impl Iterator<Item = usize>,
        context: &Context<'_>,
    ) -> Result<Samples, IoError> {
        self.seek(0, context)?;
        let start = self.unsigned(Tag::StripOffsets, context)?;
        let start = start.first().copied().unwrap_or(0);
        if head.components != 1 || head.compression != compression::NONE || !head.is_plain() {
            return Err(context.unsupported("pages without headers that are not plain samples"));
        }
        let bytes = head.stored_bytes();
        let mut buffer = SampleBuffer::new(head.sample_type, head.endian);
        for page in pages {
            let at = start.saturating_add(bytes.saturating_mul(page as u64));
            let left = self.length.saturating_sub(at);
            if left < bytes {
                return Err(context.truncated("samples", bytes, left));
            }
            let file = self.decoder.inner();
            file.seek(SeekFrom::Start(at))
                .map_err(|error| context.read(error))?;
            let mut source = Source::from_reader(file.take(bytes), bytes);
            buffer.read(&mut source, head.samples(), context)?;
        }
        Ok(buffer.finish().0)
    }

    /// Bytes of the file.
    fn bytes(&mut self, offset: u64, count: u64, context: &Context<'_>) -> Result<Vec<u8>, IoError> {
        let file = self.decoder.inner();
        file.seek(SeekFrom::Start(offset))
            .map_err(|error| context.read(error))?;
        let mut bytes = Vec::new();
        file.take(count)
            .read_to_end(&mut bytes)
            .map_err(|error| context.read(error))?;
        match bytes.len() as u64 == count {
            true => Ok(bytes),
            false => Err(context.truncated("strip or tile", count, bytes.len() as u64)),
        }
    }
}

fn of_jpeg(result: DecodingResult) -> Samples {
    match result {
        DecodingResult::U8(data) => Samples::U8(data.into()),
        DecodingResult::U16(data) => Samples::U16(data.into()),
        // JPEG has no others.
        _ => Samples::U8(Vec::new().into()),
    }
}

fn bad(error: tiff::TiffError, context: &Context<'_>) -> IoError {
    match error {
        tiff::TiffError::IoError(error) => context.read(error),
        tiff::TiffError::UnsupportedError(error) => context.unsupported(error.to_string()),
        error => context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error)),
    }
}
