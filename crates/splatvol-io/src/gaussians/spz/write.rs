//! SPZ version 3 from Gaussians whose numbers are already in RUB: the inverse of what `packed` does, rounded to
//! nearest.
//!
//! Harmonics keep 5 bits at degree 1 and 4 bits above, as in the reference implementation, so that gzip finds repeats;
//! those beyond -1..1 are clipped.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use splatvol_scene::GaussianAttributes;

use super::super::detect::SPZ_MAGIC;
use super::super::harmonics::harmonics_count;
use super::packed::COLOR_SCALE;
use crate::IoError;

/// Most bits of a mean's fraction: a quarter of a millimetre where lengths are metres.
const FRACTIONAL_BITS: u8 = 12;
/// Means have 24 bits with a sign.
const LARGEST: f64 = 8_388_607.0;

fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

/// The most fractional bits, up to 12, with which all means fit.
fn fractional_bits(attributes: &GaussianAttributes) -> Option<u8> {
    let largest = attributes
        .means
        .as_flattened()
        .iter()
        .fold(0.0, |largest: f64, c| largest.max(f64::from(c.abs())));
    (0..=FRACTIONAL_BITS)
        .rev()
        .find(|bits| largest * f64::from(*bits).exp2() <= LARGEST)
}

/// The index of the largest component of x y z w in 2 bits, the others as sign and 9 bits.
fn pack_rotation(rotation: [f32; 4]) -> [u8; 4] {
    let largest = (0..4).fold(0, |best, i| {
        if rotation[i].abs() > rotation[best].abs() {
            i
        } else {
            best
        }
    });
    let sign = f64::from(rotation[largest].signum());
    let mut word = largest as u32;
    for (i, component) in rotation.into_iter().enumerate() {
        if i != largest {
            let component = f64::from(component) * sign;
            let size = (component.abs() * std::f64::consts::SQRT_2 * 511.0)
                .round()
                .min(511.0) as u32;
            word = (word << 10) | (u32::from(component < 0.0) << 9) | size;
        }
    }
    word.to_le_bytes()
}

fn pack_harmonic(value: f32, bits: u32) -> u8 {
    let step = 1 << (8 - bits);
    let byte = (f64::from(value) * 128.0).round() as i32 + 128;
    ((byte + step / 2).div_euclid(step) * step).clamp(0, 255) as u8
}

/// A whole file.
///
/// # Errors
/// Means too far out for 24 bits.
pub(in super::super) fn encode(
    attributes: &GaussianAttributes,
    degree: u32,
    antialiased: bool,
) -> Result<Vec<u8>, IoError> {
    let encode = |what: String| IoError::Encode { format: "SPZ", what };
    let bits = fractional_bits(attributes)
        .ok_or_else(|| encode(format!("means beyond {LARGEST} do not fit 24 bits")))?;
    let count = u32::try_from(attributes.means.len()).map_err(|_| {
        encode(format!(
            "{} Gaussians, more than 2^32 - 1",
            attributes.means.len()
        ))
    })?;
    let mut bytes = SPZ_MAGIC.to_vec();
    bytes.extend(3u32.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend([degree as u8, bits, u8::from(antialiased), 0]);
    let unit = f64::from(bits).exp2();
    for coordinate in attributes.means.as_flattened() {
        let fixed = (f64::from(*coordinate) * unit).round() as i32;
        bytes.extend(&fixed.to_le_bytes()[..3]);
    }
    bytes.extend(attributes.opacities.iter().map(|o| byte(f64::from(*o) * 255.0)));
    let per_splat = harmonics_count(degree);
    for harmonics in attributes.harmonics.chunks_exact(per_splat) {
        bytes.extend(harmonics[0].map(|c| byte((f64::from(c) * COLOR_SCALE + 0.5) * 255.0)));
    }
    let scales = attributes.scales.as_flattened();
    bytes.extend(scales.iter().map(|s| byte((f64::from(*s).ln() + 10.0) * 16.0)));
    bytes.extend(attributes.rotations.iter().flat_map(|r| pack_rotation(*r)));
    for harmonics in attributes.harmonics.chunks_exact(per_splat) {
        for (index, triple) in harmonics.iter().enumerate().skip(1) {
            let bits = if index < 4 { 5 } else { 4 };
            bytes.extend(triple.map(|c| pack_harmonic(c, bits)));
        }
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    let written = encoder.write_all(&bytes);
    written
        .and_then(|()| encoder.finish())
        .map_err(|error| encode(error.to_string()))
}
