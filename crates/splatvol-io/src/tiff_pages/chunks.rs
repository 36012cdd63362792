//! Strips and tiles put together.

use half::f16;
use splatvol_scene::Samples;
use tiff::decoder::ChunkType;
use tiff::tags::Tag;

use super::{PageHead, Pages, SLACK, compression, predictor};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleBuffer};
use crate::source::Source;

/// A tile may be larger than its page by this factor, and by [`SLACK`] bytes.
const MOST_SPARE: u64 = 4;

/// The samples of the current page.
pub(super) fn read(pages: &mut Pages, head: &PageHead, context: &Context<'_>) -> Result<Samples, IoError> {
    let grid = Grid::new(pages, head, context)?;
    let mut image = vec![0; head.samples() * grid.sample];
    for plane in 0..grid.planes {
        for index in 0..grid.per_plane() {
            let chunk = grid.chunk(plane * grid.per_plane() + index, pages, head, context)?;
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
}

impl Grid {
    fn new(pages: &mut Pages, head: &PageHead, context: &Context<'_>) -> Result<Self, IoError> {
        let tiled = matches!(pages.decoder.get_chunk_type(), ChunkType::Tile);
        let tags = match tiled {
            false => [Tag::StripOffsets, Tag::StripByteCounts],
            true => [Tag::TileOffsets, Tag::TileByteCounts],
        };
        let (width, height) = pages.decoder.chunk_dimensions();
        let rows = if tiled { usize::MAX } else { head.size[1] };
        let chunk = [width as usize, (height as usize).min(rows)];
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
            let found = format!("{width} x {height}");
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
            offsets: pages.unsigned(tags[0], context)?,
            lengths: pages.unsigned(tags[1], context)?,
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
        pages: &mut Pages,
        head: &PageHead,
        context: &Context<'_>,
    ) -> Result<Vec<u8>, IoError> {
        let rows = match self.tiled {
            true => self.chunk[1],
            false => self.shown(index % self.per_plane())[1],
        };
        let across = self.chunk[0] * self.components;
        let row_bytes = (across * head.bits as usize).div_ceil(8);
        let mut coded = pages.bytes(self.offsets[index], self.lengths[index], context)?;
        if head.low_bits_first {
            coded.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
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
