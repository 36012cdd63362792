//! Pages of TIFF and `BigTIFF` files as samples (TIFF 6.0, and its technical notes 1 to 3).
//!
//! The crates for TIFF take memory by the header alone, turn white and black round without a word, or refuse LZW in tiles
//! that stick out of the page: directories, strips and tiles are read here, compressions by the crates for them. Samples
//! are returned as they are stored: places in a palette, and white where white is zero.
//!
//! | module | holds |
//! |---|---|
//! | [`directory`] | the tags of the pages |
//! | [`page`] | the form of a page: size, type of its samples, compression |
//! | [`chunks`] | strips and tiles, put together |
//! | [`compression`] | the bytes of a strip or tile |
//! | [`jpeg`] | strips and tiles of JPEG, with tables that they share |
//! | [`predictor`] | differences between neighbours, undone; bits, unpacked |

mod chunks;
mod compression;
mod directory;
mod jpeg;
mod page;
mod predictor;

use std::path::Path;

use splatvol_scene::Samples;

use crate::IoError;
use crate::error::Context;
use crate::samples::SampleBuffer;
use crate::source::Source;
use directory::Directories;
pub(crate) use directory::tag;
pub(crate) use page::PageHead;

/// Best ratio of the compressions: deflate has 1032, LZW a little more on large images.
const RATIO: u64 = 1500;
/// Bytes that any file may hold, whatever its length.
const SLACK: u64 = 1 << 20;

/// The pages of a file.
pub(crate) struct Pages {
    directories: Directories,
    /// Bytes that the pages still to be read may have.
    budget: u64,
}

impl Pages {
    /// Opens a regular file at its first page.
    pub(crate) fn open(path: &Path, context: &Context<'_>) -> Result<Self, IoError> {
        let directories = Directories::open(path, context)?;
        let budget = directories.length.saturating_mul(RATIO).saturating_add(SLACK);
        Ok(Self { directories, budget })
    }

    /// Forgets which pages were read, of which a file has so many bytes at most.
    pub(crate) fn read_anew(&mut self) {
        self.budget = self
            .directories
            .length
            .saturating_mul(RATIO)
            .saturating_add(SLACK);
    }

    /// Length of the file in bytes.
    pub(crate) fn length(&self) -> u64 {
        self.directories.length
    }

    /// Number of pages. The last is the current one then.
    pub(crate) fn count(&mut self, context: &Context<'_>) -> Result<usize, IoError> {
        self.directories.count(context)
    }

    /// A text of the current page.
    pub(crate) fn text(&self, tag: u16, context: &Context<'_>) -> Option<String> {
        self.directories.text(tag, context)
    }

    /// Numbers of the current page; none where the tag is missing.
    pub(crate) fn numbers(&self, tag: u16, context: &Context<'_>) -> Vec<f64> {
        self.directories.floats(tag, context).unwrap_or_default()
    }

    /// World length per pixel along x and y, in the unit that a description names.
    pub(crate) fn resolution(&self, context: &Context<'_>) -> [Option<f64>; 2] {
        [tag::X_RESOLUTION, tag::Y_RESOLUTION].map(|tag| {
            let spacing = 1.0 / self.numbers(tag, context).first()?;
            Some(spacing).filter(|spacing| spacing.is_finite() && *spacing > 0.0)
        })
    }

    /// The form of a page, which is the current one then.
    pub(crate) fn head(&mut self, page: usize, context: &Context<'_>) -> Result<PageHead, IoError> {
        self.directories.seek(page, context)?;
        PageHead::read(&self.directories, context)
    }

    /// Interleaved samples of the current page, row by row from the top.
    pub(crate) fn samples(&mut self, head: &PageHead, context: &Context<'_>) -> Result<Samples, IoError> {
        let needed = head.stored_bytes();
        let available = match head.compression {
            compression::NONE => self.directories.length.min(self.budget),
            _ => self.budget,
        };
        if needed > available {
            return Err(context.too_small("samples", needed, available));
        }
        self.budget -= needed;
        let samples = chunks::read(&self.directories, head, context)?;
        let expected = head.samples();
        match samples.len() == expected {
            true => Ok(samples),
            false => Err(context.truncated("samples", expected as u64, samples.len() as u64)),
        }
    }

    /// Byte at which pages without headers begin, whose samples are plain.
    pub(crate) fn contiguous_start(
        &mut self,
        head: &PageHead,
        context: &Context<'_>,
    ) -> Result<u64, IoError> {
        self.directories.seek(0, context)?;
        let start = self.directories.unsigned(tag::STRIP_OFFSETS, context)?;
        if head.components != 1 || head.compression != compression::NONE || !head.is_plain() {
            return Err(context.unsupported("pages without headers that are not plain samples"));
        }
        Ok(start.first().copied().unwrap_or(0))
    }

    /// Pages that follow the first without headers, as ImageJ writes files of more than 4 GB.
    pub(crate) fn contiguous(
        &mut self,
        head: &PageHead,
        pages: impl Iterator<Item = usize>,
        context: &Context<'_>,
    ) -> Result<Samples, IoError> {
        let start = self.contiguous_start(head, context)?;
        let bytes = head.stored_bytes();
        let mut buffer = SampleBuffer::new(head.sample_type, head.endian);
        for page in pages {
            let at = start.saturating_add(bytes.saturating_mul(page as u64));
            let plane = self.directories.bytes(at, bytes, context)?;
            buffer.read(&mut Source::from_bytes(&plane), head.samples(), context)?;
        }
        Ok(buffer.finish().0)
    }
}
