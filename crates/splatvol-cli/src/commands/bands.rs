//! Pictures in bands of rows: posters whose frame would take more memory than there is.
//!
//! A band is a window of the picture (`splatvol::Control::window`): it is rendered, coded, and written to the PNG, and
//! its memory is used for the next. Bands change neither a pixel nor a byte of the file.

use std::ops::Range;
use std::path::Path;

use splatvol::{Frame, ImageSize};
use splatvol_document::resolve::laid_over;
use splatvol_io::{PngDepth, PngRows};

use crate::failure::{During, Failure, Step};
use crate::output::Scratch;

/// Bytes of a pixel of a band: frame, tiles, the frame of a coarser level, codes.
const PIXEL: u64 = 80;
/// Rows by which bands grow: those of a tile.
const STEP: u32 = 128;

/// What pictures that cannot be made in bands could be.
pub(super) const HINT: &str =
    "a PNG file without --depth, by the CPU, is written in bands of rows, however large";

/// Whether the frame of a picture takes more than half of the memory.
pub(super) fn are_needed(size: ImageSize, memory: u64) -> bool {
    size.pixel_count() as u64 * PIXEL > memory / 2
}

/// The bands of a picture, each of at most a quarter of the memory.
pub(super) fn bands(size: ImageSize, memory: u64) -> impl ExactSizeIterator<Item = Range<u32>> {
    let row = u64::from(size.width()) * PIXEL;
    let rows = (memory / 4 / row).min(u64::from(size.height())) as u32;
    let (step, height) = ((rows / STEP * STEP).max(STEP), size.height());
    (0..height.div_ceil(step)).map(move |at| at * step..(at * step + step).min(height))
}

/// The picture that is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheet<'a> {
    pub(super) size: ImageSize,
    pub(super) background: Option<[f64; 4]>,
    pub(super) bits: u8,
    pub(super) metadata: &'a [(String, String)],
}

/// Where bands go: a PNG, as it becomes.
pub(super) struct BandedPng {
    rows: PngRows,
    file: Scratch,
    background: Option<[f64; 4]>,
}

impl BandedPng {
    /// Begins a file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn new(path: &Path, sheet: Sheet<'_>) -> Result<Self, Failure> {
        let Sheet {
            size,
            background,
            bits,
            metadata,
        } = sheet;
        let depth = match bits {
            16 => PngDepth::Sixteen,
            _ => PngDepth::Eight,
        };
        let is_opaque = background.is_some_and(|[.., alpha]| alpha >= 1.0);
        let file = Scratch::beside(path);
        let rows = PngRows::new(file.path(), size, (depth, is_opaque), metadata).during(Step::Output)?;
        Ok(Self {
            rows,
            file,
            background,
        })
    }

    /// Writes the next band.
    pub(super) fn write(&mut self, band: &Frame) -> Result<(), Failure> {
        match self.background {
            Some(background) => self.rows.write(&laid_over(&band.image, background)),
            None => self.rows.write(&band.image),
        }
        .during(Step::Output)
    }

    /// Moves the complete file to its place.
    pub(super) fn keep(self, overwrite: bool) -> Result<(), Failure> {
        let path = self.file.path();
        let other = Scratch::beside(&path.with_extension("rgb.png"));
        self.rows.finish(path, other.path()).during(Step::Output)?;
        std::fs::File::open(path)
            .and_then(|file| file.sync_all())
            .during(Step::Output)?;
        self.file.keep(overwrite)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_all_rows_once_within_the_memory() {
        let size = ImageSize::new(30_000, 20_000).unwrap();
        for memory in [0, 1 << 20, 1 << 30, 1 << 34] {
            let all: Vec<_> = bands(size, memory).collect();
            assert_eq!((all[0].start, all[all.len() - 1].end), (0, 20_000));
            assert!(all.windows(2).all(|pair| pair[0].end == pair[1].start));
            let most = all.iter().map(|rows| rows.len() as u64).max().unwrap();
            assert!(most == 128 || most * 30_000 * PIXEL <= memory / 4, "{most}");
        }
        assert!(are_needed(size, 1 << 30) && !are_needed(ImageSize::default(), 1 << 30));
    }
}
