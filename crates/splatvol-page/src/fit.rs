//! Data in fewer bits, or of a coarser level, until they fit.
//!
//! Tried in this order, until one fits: each level of detail, the finest first, in 16, 12 and 8 bits per sample, or in the
//! bits that are asked for. Samples of integers that have no more bits stay what they are. Others, `v` from `low` to
//! `high`, become `round((v - low) / (high - low) (2^bits - 1))`: the error is half a step at most. Samples of which some
//! are missing stay 32-bit floats, whatever the bits: integers have no missing ones. Names of kinds (labels) are not
//! averaged, and not rounded.

use std::io::Write;
use std::sync::Arc;

use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use splatvol::volume::Samples;
use splatvol::{Rescale, SceneError, Volume};
use splatvol_core::mip;
use splatvol_web::VolumeData;

use crate::PageError;

/// Coarsest level: an eighth of the samples along each axis.
const MOST_LEVELS: usize = 4;
/// Bytes by whose compression a packing is chosen.
const TASTE: usize = 1 << 20;
/// Pieces in which data are compressed: it stops at the first that does not fit.
const PIECE: usize = 1 << 16;

/// Bits per sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(into = "u8")]
pub enum Bits {
    /// 256 values.
    Eight,
    /// 4096 values.
    Twelve,
    /// 65536 values.
    Sixteen,
}

impl From<Bits> for u8 {
    fn from(bits: Bits) -> Self {
        match bits {
            Bits::Eight => 8,
            Bits::Twelve => 12,
            Bits::Sixteen => 16,
        }
    }
}

impl Bits {
    /// From the most to the least.
    pub const ALL: [Self; 3] = [Self::Sixteen, Self::Twelve, Self::Eight];

    /// Largest code.
    fn largest(self) -> u16 {
        u16::MAX >> (16 - u8::from(self))
    }

    fn bytes(self) -> usize {
        usize::from(u8::from(self).div_ceil(8))
    }
}

/// Volumes that fit.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The volumes, as the page will have them.
    pub volumes: Vec<Arc<Volume>>,
    /// What the bytes are.
    pub data: Vec<VolumeData>,
    /// All packed samples, gzip.
    pub bytes: Vec<u8>,
    /// Most bits per sample of integers.
    pub bits: Bits,
    /// Halvings along each axis.
    pub level: usize,
    /// Whether every sample is what it was.
    pub exact: bool,
}

/// Makes volumes, each with whether its values are labels, fit into so many bytes of gzip; in given bits, or in as many as
/// possible.
///
/// # Errors
/// Volumes that do not fit, and labels whose numbers do not.
pub fn fit(volumes: &[(Arc<Volume>, bool)], bits: Option<Bits>, most: u64) -> Result<Fitted, PageError> {
    let mut level: Vec<Arc<Volume>> = volumes.iter().map(|(volume, _)| Arc::clone(volume)).collect();
    let labels: Vec<bool> = volumes.iter().map(|(_, labels)| *labels).collect();
    for halvings in 0..MOST_LEVELS {
        if halvings > 0 {
            if labels.contains(&true) {
                break;
            }
            let halves = level.iter().map(half).collect::<Result<_, _>>()?;
            level = halves;
        }
        let mut last: Option<Vec<Arc<Volume>>> = None;
        for bits in bits.map_or(Bits::ALL.to_vec(), |bits| vec![bits]) {
            let coded = level
                .iter()
                .zip(&labels)
                .map(|(volume, labels)| coded(volume, bits, *labels))
                .collect::<Result<Vec<_>, _>>()?;
            // Fewer bits change nothing where all is as short already.
            if last
                .as_ref()
                .is_some_and(|last| last.iter().zip(&coded).all(|(a, b)| Arc::ptr_eq(a, b)))
            {
                continue;
            }
            if let Some((data, bytes)) = packed(&coded, most)? {
                let exact = halvings == 0 && coded.iter().zip(&level).all(|(a, b)| Arc::ptr_eq(a, b));
                return Ok(Fitted {
                    volumes: coded,
                    data,
                    bytes,
                    bits,
                    level: halvings,
                    exact,
                });
            }
            last = Some(coded);
        }
    }
    let why = match labels.contains(&true) {
        true => "names of kinds cannot be averaged to a coarser level".to_owned(),
        false => format!(
            "the data do not fit even at an eighth of their resolution in {} bits",
            bits.map_or(8, u8::from)
        ),
    };
    Err(PageError::TooLarge {
        most,
        least: most + 1,
        why,
    })
}

/// A volume of half the resolution; its own if it is flat.
fn half(volume: &Arc<Volume>) -> Result<Arc<Volume>, SceneError> {
    let half = mip::half(&Arc::clone(volume).into())?;
    let samples = half.samples().clone();
    Volume::new(half.grid().clone(), samples, half.rescale(), volume.unit()).map(Arc::new)
}

/// A volume in so many bits; the same one if it needs no more.
fn coded(volume: &Arc<Volume>, bits: Bits, labels: bool) -> Result<Arc<Volume>, PageError> {
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

/// What bytes are, and the bytes, gzip.
type Packed = (Vec<VolumeData>, Vec<u8>);

/// Packs volumes, and compresses them; `None` if that takes more bytes.
fn packed(volumes: &[Arc<Volume>], most: u64) -> Result<Option<Packed>, PageError> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    let mut all = Vec::new();
    for volume in volumes {
        let [plain, delta] = [false, true].map(|delta| VolumeData::of(volume, delta));
        let [plain_bytes, delta_bytes] = [plain.pack(volume), delta.pack(volume)];
        let taste = |bytes: &[u8]| {
            // From the middle: the edges of most volumes are empty.
            let start = bytes.len().saturating_sub(TASTE) / 2;
            compressed(&bytes[start..bytes.len().min(start + TASTE)])
        };
        let (data, bytes) = match taste(&delta_bytes)?.len() < taste(&plain_bytes)?.len() {
            true => (delta, delta_bytes),
            false => (plain, plain_bytes),
        };
        for piece in bytes.chunks(PIECE) {
            gzip.write_all(piece)?;
            if gzip.get_ref().len() as u64 > most {
                return Ok(None);
            }
        }
        all.push(data);
    }
    let bytes = gzip.finish()?;
    Ok((bytes.len() as u64 <= most).then_some((all, bytes)))
}

fn compressed(bytes: &[u8]) -> Result<Vec<u8>, PageError> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(bytes)?;
    Ok(gzip.finish()?)
}

#[cfg(test)]
mod tests {
    use splatvol::{Grid, LengthUnit};

    use super::*;

    fn volume(samples: Samples) -> Arc<Volume> {
        let grid = Grid::centred([8, 8, 4], [1.0; 3]).unwrap();
        Arc::new(Volume::new(grid, samples, Rescale::default(), LengthUnit::Millimetre).unwrap())
    }

    /// Largest difference of the values of volumes on one grid, data units.
    fn largest_error(a: &Volume, b: &Volume) -> f64 {
        let errors = (0..a.samples().len()).map(|i| (a.value(i) - b.value(i)).abs());
        errors.fold(0.0, f64::max)
    }

    fn waves() -> Vec<f32> {
        (0..256).map(|i| (i as f32 * 0.37).sin() * 100.0).collect()
    }

    #[test]
    fn what_fits_stays_as_it_is() {
        for (samples, bits) in [
            (Samples::U8(vec![7; 256].into()), Bits::Sixteen),
            (
                Samples::I16((0..256).map(|i| i * 100 - 9000).collect::<Vec<_>>().into()),
                Bits::Sixteen,
            ),
        ] {
            let volume = volume(samples);
            let fitted = fit(&[(Arc::clone(&volume), false)], None, 1 << 20).unwrap();
            assert!(fitted.exact && fitted.level == 0 && fitted.bits == bits);
            assert!(Arc::ptr_eq(&fitted.volumes[0], &volume));
        }
    }

    #[test]
    fn floats_are_rounded_by_half_a_step_at_most() {
        let volume = volume(Samples::F32(waves().into()));
        let [low, high] = volume.value_range();
        for bits in Bits::ALL {
            let fitted = fit(&[(Arc::clone(&volume), false)], Some(bits), 1 << 20).unwrap();
            let step = (high - low) / f64::from(bits.largest());
            let error = largest_error(&volume, &fitted.volumes[0]);
            assert!(
                error <= 0.5001 * step && error > 0.05 * step,
                "{bits:?}: {error} of {step}"
            );
            assert!(
                !fitted.exact && fitted.data[0].sample_type == if bits == Bits::Eight { "u8" } else { "u16" }
            );
        }
    }

    #[test]
    fn less_room_means_fewer_bits_then_coarser_levels_then_an_error() {
        let volume = [(volume(Samples::F32(waves().into())), false)];
        let rung = |most: u64| {
            fit(&volume, None, most).map(|fitted| (fitted.level, fitted.bits, fitted.bytes.len() as u64))
        };
        let mut most = 1 << 20;
        let mut rungs = Vec::new();
        while let Ok((level, bits, bytes)) = rung(most) {
            assert!(bytes <= most);
            rungs.push((level, std::cmp::Reverse(bits)));
            most = bytes - 1;
        }
        assert!(rungs.is_sorted() && rungs.len() > 4, "{rungs:?}");
        assert_eq!(rungs[0], (0, std::cmp::Reverse(Bits::Sixteen)));
        assert!(rung(most).unwrap_err().to_string().contains("do not fit"));
    }

    #[test]
    fn missing_samples_stay_missing() {
        let mut values: Vec<f64> = waves().into_iter().map(f64::from).collect();
        values[9] = f64::NAN;
        let fitted = fit(
            &[(volume(Samples::F64(values.into())), false)],
            Some(Bits::Eight),
            1 << 20,
        )
        .unwrap();
        assert_eq!(fitted.data[0].sample_type, "f32");
        assert_eq!(fitted.volumes[0].statistics().non_finite, 1);
    }

    #[test]
    fn labels_are_neither_rounded_nor_averaged() {
        let ids: Vec<f32> = (0..256).map(|i| (i * 37 % 250) as f32 + 3.0).collect();
        let labels = volume(Samples::F32(ids.into()));
        let fitted = fit(&[(Arc::clone(&labels), true)], Some(Bits::Eight), 1 << 20).unwrap();
        assert_eq!(largest_error(&labels, &fitted.volumes[0]), 0.0);
        assert!(
            fit(&[(labels, true)], Some(Bits::Eight), 20)
                .unwrap_err()
                .to_string()
                .contains("averaged")
        );
        let wide = volume(Samples::F32(
            (0..256).map(|i| (i * 2) as f32).collect::<Vec<_>>().into(),
        ));
        let refused = fit(&[(wide, true)], Some(Bits::Eight), 1 << 20).unwrap_err();
        assert!(refused.to_string().contains("whole numbers"), "{refused}");
    }

    #[test]
    fn a_constant_has_no_steps() {
        let fitted = fit(
            &[(volume(Samples::F32(vec![2.5; 256].into())), false)],
            None,
            1 << 20,
        )
        .unwrap();
        assert_eq!(fitted.volumes[0].value_range(), [2.5; 2]);
    }
}
