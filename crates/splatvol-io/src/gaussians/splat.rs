//! `.splat` (Kevin Kwok 2023, "antimatter15/splat"): 32 bytes per Gaussian and no header.
//!
//! Mean and standard deviations as six little-endian floats, colour (of degree 0, clipped) and opacity as four bytes,
//! the quaternion w x y z as four bytes, `128 + 128 q`.

use std::path::Path;

use super::LoadedGaussians;
use super::collect::{Collector, Splat, harmonics_of_color};
use super::frame::{self, RDF};
use crate::error::Context;
use crate::source::Source;
use crate::{IoError, ReadOptions};

/// Bytes of a Gaussian.
pub(super) const SIZE: usize = 32;
/// Gaussians that are read at a time.
const CHUNK: u64 = 1 << 12;

/// The Gaussian and its colour.
fn decode(record: &[u8; SIZE]) -> (Splat, [f32; 3]) {
    let float = |i: usize| {
        let bytes = [
            record[4 * i],
            record[4 * i + 1],
            record[4 * i + 2],
            record[4 * i + 3],
        ];
        f64::from(f32::from_le_bytes(bytes))
    };
    let unit = |i: usize| f64::from(record[i]) / 255.0;
    let turn = |i: usize| (f64::from(record[28 + i]) - 128.0) / 128.0;
    let splat = Splat {
        mean: [float(0), float(1), float(2)],
        scale: [float(3), float(4), float(5)],
        rotation: [turn(1), turn(2), turn(3), turn(0)],
        opacity: unit(27),
    };
    (splat, harmonics_of_color([unit(24), unit(25), unit(26)]))
}

/// Reads a `.splat`.
///
/// # Errors
/// A length that is not a multiple of 32 bytes, negative scales, no Gaussian with finite numbers.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new(".splat", path);
    let mut source = Source::open(path)?;
    let size = source.at_most();
    if size == 0 || !size.is_multiple_of(SIZE as u64) {
        return Err(context.field("size in bytes", size, None, "a multiple of 32, above 0"));
    }
    let count = size / SIZE as u64;
    let mut collector = Collector::new(count, 0, options, context)?;
    collector.description.format = ".splat".to_owned();
    collector.description.stored_type = "32 bytes each, little-endian".to_owned();
    collector.description.orientation = frame::describe(RDF);
    let mut left = count;
    while left > 0 {
        let records = left.min(CHUNK);
        let bytes = source.read_bytes("Gaussians", records * SIZE as u64, context)?;
        for record in bytes.as_chunks().0 {
            let (splat, color) = decode(record);
            collector.push(&splat, &[color]);
        }
        left -= records;
    }
    collector.finish(frame::world_from_local(RDF), context)
}
