//! Volumes: samples in fewer bits, and levels of half the resolution.
//!
//! Samples `v` from `low` to `high` become `round((v - low) / (high - low) (2^bits - 1))`: the error is half a step at most.

use std::io::Write;
use std::sync::Arc;

use flate2::Compression;
use flate2::write::GzEncoder;
use splatvol::volume::Samples;
use splatvol::{Rescale, SceneError, Volume};
use splatvol_core::mip;
use splatvol_document::HeldContent;
use splatvol_web::{ItemData, VolumeData};

use super::{Bits, Coded};
use crate::PageError;

/// Bytes by whose compression a packing is chosen.
const TASTE: usize = 1 << 20;

/// Codes a volume in so many bits; it stays the same one if it needs no more.
pub(super) fn code(volume: &Arc<Volume>, bits: Bits, labels: bool) -> Result<Coded, PageError> {
    let coded = match bits {
        Bits::Own => Arc::clone(volume),
        _ => rounded(volume, bits, labels)?,
    };
    let [plain, delta] = [false, true].map(|delta| VolumeData::of(&coded, delta));
    let [plain_bytes, delta_bytes] = [plain.pack(&coded), delta.pack(&coded)];
    let taste = |bytes: &[u8]| {
        // From the middle: the edges of most volumes are empty.
        let start = bytes.len().saturating_sub(TASTE) / 2;
        compressed(&bytes[start..bytes.len().min(start + TASTE)])
    };
    let (data, bytes) = match taste(&delta_bytes)?.len() < taste(&plain_bytes)?.len() {
        true => (delta, delta_bytes),
        false => (plain, plain_bytes),
    };
    Ok(Coded {
        exact: Arc::ptr_eq(&coded, volume),
        content: HeldContent::Volume(coded),
        data: ItemData::Volume(data),
        bytes,
    })
}

/// A volume of half the resolution; its own if it is flat.
pub(super) fn half(volume: &Arc<Volume>) -> Result<Arc<Volume>, SceneError> {
    let half = mip::half(&Arc::clone(volume).into())?;
    let samples = half.samples().clone();
    Volume::new(half.grid().clone(), samples, half.rescale(), volume.unit()).map(Arc::new)
}

/// A volume in so many bits; the same one if it needs no more.
fn rounded(volume: &Arc<Volume>, bits: Bits, labels: bool) -> Result<Arc<Volume>, PageError> {
    if volume.statistics().non_finite > 0 {
        return floats(volume);
    }
    if is_short(volume.samples(), bits) {
        return Ok(Arc::clone(volume));
    }
    let [low, high] = volume.value_range();
    let steps = f64::from(bits.largest());
    let slope = if labels { 1.0 } else { (high - low) / steps };
    if labels && !(high - low <= steps && (0..volume.samples().len()).all(|i| volume.value(i).fract() == 0.0))
    {
        return Err(PageError::TooLarge {
            most: steps as u64,
            least: (high - low) as u64,
            why: format!(
                "names of kinds from {low} to {high} are not whole numbers of {} bits",
                u8::from(bits)
            ),
        });
    }
    let rescale = Rescale {
        // A constant has no steps.
        slope: if slope > 0.0 { slope } else { 1.0 },
        intercept: low,
    };
    let codes = (0..volume.samples().len()).map(|i| ((volume.value(i) - low) / rescale.slope).round());
    let samples = match bits.bytes() {
        1 => Samples::U8(codes.map(|code| code as u8).collect::<Vec<_>>().into()),
        _ => Samples::U16(codes.map(|code| code as u16).collect::<Vec<_>>().into()),
    };
    let coded = Volume::new(volume.grid().clone(), samples, rescale, volume.unit())?;
    Ok(Arc::new(coded.into_shared()))
}

/// Whether samples are integers of no more bits.
fn is_short(samples: &Samples, bits: Bits) -> bool {
    let wide = |[low, high]: [i64; 2]| high - low > i64::from(bits.largest());
    match samples {
        Samples::U8(_) | Samples::I8(_) => true,
        Samples::U16(data) => bits.bytes() == 2 && !wide(extremes(data.iter().map(|&v| i64::from(v)))),
        Samples::I16(data) => bits.bytes() == 2 && !wide(extremes(data.iter().map(|&v| i64::from(v)))),
        _ => false,
    }
}

fn extremes(values: impl Iterator<Item = i64>) -> [i64; 2] {
    values.fold([i64::MAX, i64::MIN], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// A volume of 32-bit floats; the same one if it is.
fn floats(volume: &Arc<Volume>) -> Result<Arc<Volume>, PageError> {
    if matches!(volume.samples(), Samples::F32(_)) {
        return Ok(Arc::clone(volume));
    }
    let values: Vec<f32> = (0..volume.samples().len())
        .map(|i| volume.value(i) as f32)
        .collect();
    let samples = Samples::F32(values.into());
    let coded = Volume::new(volume.grid().clone(), samples, Rescale::default(), volume.unit())?;
    Ok(Arc::new(coded.into_shared()))
}

fn compressed(bytes: &[u8]) -> Result<Vec<u8>, PageError> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(bytes)?;
    Ok(gzip.finish()?)
}
