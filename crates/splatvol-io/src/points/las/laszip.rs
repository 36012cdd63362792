//! The record by which LAZ files say how points are compressed (laszip record 22204), and the layers of their chunks.
//!
//! The decoder takes memory for the layers' sizes before it reads them, so every chunk is walked through first.

use super::check::Bytes;
use crate::IoError;
use crate::error::Context;

/// User of the record, and its number.
const USER: &[u8; 16] = b"laszip encoded\0\0";
const RECORD: u16 = 22_204;
/// Compressor of chunks of layers.
const LAYERED: u16 = 3;
/// First type of items that are stored in layers.
const FIRST_LAYERED: u16 = 10;

/// What the record says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Laszip {
    compressor: u16,
    /// Points of a chunk; 0 or all ones where chunks differ.
    chunk_size: u32,
    /// Type, bytes and version of the parts of a point.
    items: Vec<[u16; 3]>,
}

impl Laszip {
    /// Reads the body at `place` of a record whose header stands before it.
    pub(super) fn read(bytes: &Bytes<'_>, header: u64, place: u64) -> Option<Self> {
        let (user, number): ([u8; 16], u16) = (bytes.array(header + 2)?, bytes.u16(header + 18)?);
        if (&user, number) != (USER, RECORD) {
            return None;
        }
        let count = u64::from(bytes.u16(place + 32)?);
        let item = |index| {
            let at = place + 34 + 6 * index;
            Some([bytes.u16(at)?, bytes.u16(at + 2)?, bytes.u16(at + 4)?])
        };
        Some(Self {
            compressor: bytes.u16(place)?,
            chunk_size: bytes.u32(place + 12)?,
            items: (0..count).map(item).collect::<Option<_>>()?,
        })
    }

    /// True where chunks consist of layers.
    pub(super) fn layered(&self) -> bool {
        self.compressor == LAYERED
    }

    /// Chunks that so many points need; none where chunks differ.
    pub(super) fn chunks(&self, points: u64) -> Option<u64> {
        let differ = self.chunk_size == 0 || self.chunk_size == u32::MAX;
        (!differ && self.compressor > 1).then(|| points.div_ceil(u64::from(self.chunk_size)))
    }

    /// Refuses items that are not those of the points, or that the compressor does not have.
    pub(super) fn check(&self, record: u16, context: &Context<'_>) -> Result<(), IoError> {
        let bytes: u64 = self.items.iter().map(|[_, bytes, _]| u64::from(*bytes)).sum();
        if bytes != u64::from(record) {
            let expected = format!("{record}, the bytes of a point");
            return Err(context.field("bytes of laszip items", bytes, None, expected));
        }
        let fits = |[kind, _, version]: &[u16; 3]| match (self.layered(), kind) {
            (true, FIRST_LAYERED..=14) => (3..=4).contains(version),
            (false, 0 | 6..=9) => (1..=2).contains(version),
            _ => false,
        };
        match self.items.iter().find(|item| !fits(item)) {
            None => Ok(()),
            Some([kind, _, version]) => {
                let found = format!("type {kind}, version {version}");
                let expected = format!("items of compressor {}", self.compressor);
                Err(context.field("laszip item", found, None, expected))
            }
        }
    }

    /// Layers of a chunk (LAZ specification, compressor 3).
    fn layers(&self) -> u64 {
        let of_item = |[kind, bytes, _]: &[u16; 3]| match kind {
            // A point, colours, colours with infrared, a wave packet, extra bytes.
            10 => 9,
            11 | 13 => 1,
            12 => 2,
            _ => u64::from(*bytes),
        };
        self.items.iter().map(of_item).sum()
    }

    /// End of a chunk of layers: a point, the number of points, the size of each layer, the layers.
    pub(super) fn end_of_layers(&self, bytes: &Bytes<'_>, at: u64, record: u16) -> Option<u64> {
        let layers = self.layers();
        let sizes = at + u64::from(record) + 4;
        (0..layers).try_fold(sizes + 4 * layers, |end, layer| {
            end.checked_add(u64::from(bytes.u32(sizes + 4 * layer)?))
        })
    }
}
