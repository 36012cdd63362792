//! `.spz` (Niantic, "nianticlabs/spz"), versions 1 to 4.
//!
//! A header of 16 bytes, then one array per attribute: means (24-bit fixed point; half floats in version 1), opacities,
//! colours (degree 0, `c = (byte / 255 - 1/2) / 0.15`), scales (`ln s = byte / 16 - 10`), rotations, harmonics
//! (`(byte - 128) / 128`, colours next to each other). All of it is one gzip stream, or none, in versions 1 to 3.
//! Version 4 has a plain header of 32 bytes, extensions, a table of compressed and uncompressed lengths, and a zstd
//! stream for each array. Rotations are x y z in bytes with w >= 0 left out (versions 1 and 2), or the three smallest
//! components in ten bits each (3 and 4).
//!
//! The frame is RUB unless an extension of version 4 says otherwise. Known extensions: range of harmonics, frame.

mod container;
mod extensions;
mod packed;
mod write;

use std::path::Path;

use super::LoadedGaussians;
use super::collect::Collector;
use super::frame;
use crate::error::Context;
use crate::source::Source;
use crate::{IoError, ReadOptions};
pub(super) use packed::Packed;
pub(super) use write::encode;

/// Reads an `.spz`.
///
/// # Errors
/// An unknown version, arrays cut short, corrupt compressed data.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new("SPZ", path);
    let packed = container::read(Source::open(path)?, options, context)?;
    let mut collector = Collector::new(packed.count, packed.degree.min(3), options, context)?;
    collector.description.format = format!("SPZ {}", packed.version);
    collector.description.stored_type =
        format!("{} fractional bits, {}", packed.fractional_bits, packed.coding);
    collector.description.orientation = frame::describe(packed.frame);
    packed.unpack(&mut collector);
    collector.finish(frame::world_from_local(packed.frame), context)
}

/// SPZ from bytes inside another file.
pub(super) fn from_bytes(
    bytes: &[u8],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Packed, IoError> {
    container::read(Source::from_bytes(bytes), options, context)
}
