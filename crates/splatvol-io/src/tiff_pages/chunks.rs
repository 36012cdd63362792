//! Strips and tiles put together.

use half::f16;
use splatvol_scene::Samples;

use super::directory::{Directories, tag};
use super::{PageHead, SLACK, compression, jpeg, predictor};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleBuffer};
use crate::source::Source;

/// A tile may be larger than its page by this factor, and by [`SLACK`] bytes.
const MOST_SPARE: u64 = 4;

/// The samples of the current page.
pub(super) fn read(
    directory: &Directories,
    head: &PageHead,
    context: &Context<'_>,
) -> Result<Samples, IoError> {
    let grid = Grid::new(directory, head, context)?;
    let mut image = vec![0; head.samples() * grid.sample];
    for plane in 0..grid.planes {
        for index in 0..grid.per_plane() {
            let chunk = grid.chunk(plane * grid.per_plane() + index, directory, head, context)?;
            grid.place(&chunk, [plane, index], &mut image);
        }
    }
    if head.is_half() {
        let halves = image.chunks_exact(2).map(|bytes| [bytes[0], bytes[1]]);
        let floats: Vec<f32> = halves.map(|bytes| f16::from_le_bytes(bytes).to_f32()).collect();
        return Ok(Samples::F32(floats.into()));
    }
    let mut buffer = SampleBuffer::new(head.sample_type, Endian::Little);
    buffer.read(&mut Source::from_bytes(&image), head.samples(), context)?;
    Ok(buffer.finish().0)
}

/// The strips or tiles of a page.
struct Grid {
    /// Columns and rows of the page.
    page: [usize; 2],
    /// Columns and rows of a strip or tile.
    chunk: [usize; 2],
    /// Strips or tiles side by side, and one below the other.
    counts: [usize; 2],
    /// Strips end with the page, tiles are whole.
    tiled: bool,
    /// Planes of components, and interleaved components of each.
    planes: usize,
    components: usize,
    /// Bytes of an unpacked sample.
    sample: usize,
    offsets: Vec<u64>,
    lengths: Vec<u64>,
    /// Tables that all strips or tiles of JPEG share.
    tables: Vec<u8>,
}

impl Grid {
    fn new(directory: &Directories, head: &PageHead, context: &Context<'_>) -> Result<Self, IoError> {
        let tiled = directory.has(tag::TILE_OFFSETS);
        let number = |tag, default: usize| -> Result<usize, IoError> {
            let found = directory.unsigned(tag, context)?.first().copied();
            Ok(found.map_or(default, |number| usize::try_from(number).unwrap_or(usize::MAX)))
        };
        let (tags, chunk) = match tiled {
            false => {
                let rows = number(tag::ROWS_PER_STRIP, head.size[1])?.min(head.size[1]);
                ([tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS], [head.size[0], rows])
            }
            true => {
                let sides = [number(tag::TILE_WIDTH, 0)?, number(tag::TILE_LENGTH, 0)?];
                ([tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS], sides)
            }
        };
        let (planes, components) = match head.planar {
            true => (head.components, 1),
            false => (1, head.components),
        };
        let sample = (head.bits as usize).div_ceil(8);
        let whole = [chunk[1], components, sample]
            .iter()
            .fold(chunk[0], |product, &factor| product.saturating_mul(factor)) as u64;
        let most = MOST_SPARE.saturating_mul(head.samples() as u64 * sample as u64);
        if whole == 0 || whole > most.saturating_add(SLACK) {
            let found = format!("{} x {}", chunk[0], chunk[1]);
            let expected = "about that of the page or less";
            return Err(context.field("size of strips or tiles", found, None, expected));
        }
        let grid = Self {
            page: head.size,
            chunk,
            counts: [0, 1].map(|axis| head.size[axis].div_ceil(chunk[axis])),
            tiled,
            planes,
            components,
            sample,
            offsets: directory.unsigned(tags[0], context)?,
            lengths: directory.unsigned(tags[1], context)?,
            tables: match head.compression {
                compression::JPEG => directory.blob(tag::JPEG_TABLES, context)?,
                _ => Vec::new(),
            },
        };
        let needed = grid.per_plane().saturating_mul(planes);
        if grid.offsets.len() < needed || grid.lengths.len() < needed {
            let found = format!("{} and {}", grid.offsets.len(), grid.lengths.len());
            let expected = format!("{needed} each");
            return Err(context.field("offsets and lengths of strips or tiles", found, None, expected));
        }
        Ok(grid)
    }

    fn per_plane(&self) -> usize {
        self.counts[0].saturating_mul(self.counts[1])
    }

    /// Column and row of the upper left corner of a strip or tile.
    fn corner(&self, index: usize) -> [usize; 2] {
        let [across, _] = self.counts;
        [index % across * self.chunk[0], index / across * self.chunk[1]]
    }

    /// Columns and rows of a strip or tile that lie in the page.
    fn shown(&self, index: usize) -> [usize; 2] {
        let corner = self.corner(index);
        [0, 1].map(|axis| self.chunk[axis].min(self.page[axis] - corner[axis]))
    }

    /// Little-endian samples of whole bytes.
    fn chunk(
        &self,
        index: usize,
        directory: &Directories,
        head: &PageHead,
        context: &Context<'_>,
    ) -> Result<Vec<u8>, IoError> {
        let rows = match self.tiled {
            true => self.chunk[1],
            false => self.shown(index % self.per_plane())[1],
        };
        let across = self.chunk[0] * self.components;
        let row_bytes = (across * head.bits as usize).div_ceil(8);
        let mut coded = directory.bytes(self.offsets[index], self.lengths[index], context)?;
        if head.low_bits_first {
            coded.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
        }
        if head.compression == compression::JPEG {
            let [columns, components] = [self.chunk[0], self.components];
            let form = jpeg::Form {
                size: [columns, rows],
                components,
                photometric: head.photometric,
            };
            return jpeg::decode(&coded, &self.tables, form, context);
        }
        let mut bytes = compression::decompress((&coded, head.compression), row_bytes * rows, context)?;
        for row in bytes.chunks_exact_mut(row_bytes) {
            predictor::undo(row, head, self.components, context)?;
        }
        if head.bits >= 8 {
            return Ok(bytes);
        }
        let rows = bytes.chunks_exact(row_bytes);
        Ok(rows
            .flat_map(|row| predictor::unpacked(row, head.bits, across))
            .collect())
    }

    /// Writes what of a strip or tile lies in the page.
    fn place(&self, chunk: &[u8], [plane, index]: [usize; 2], image: &mut [u8]) {
        let [left, top] = self.corner(index);
        let [columns, rows] = self.shown(index);
        let group = self.components * self.sample;
        let pixel = group * self.planes;
        for y in 0..rows {
            let from = &chunk[y * self.chunk[0] * group..][..columns * group];
            let to = &mut image[((top + y) * self.page[0] + left) * pixel..][..columns * pixel];
            if self.planes == 1 {
                to.copy_from_slice(from);
                continue;
            }
            for (to, from) in to.chunks_exact_mut(pixel).zip(from.chunks_exact(group)) {
                to[plane * group..][..group].copy_from_slice(from);
            }
        }
    }
}
