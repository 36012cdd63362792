//! The arrays of an SPZ file and what their bytes stand for.

use half::f16;

use super::super::collect::{Collector, Splat, with_largest};
use super::super::frame::Frame;
use super::super::harmonics::harmonics_count;

/// Scale of colours in bytes.
pub(super) const COLOR_SCALE: f64 = 0.15;

/// Arrays as stored.
pub(in super::super) struct Packed {
    pub(super) version: u32,
    pub(in super::super) count: u64,
    pub(in super::super) degree: u32,
    pub(super) fractional_bits: u8,
    pub(super) antialiased: bool,
    /// Name of the compression.
    pub(super) coding: &'static str,
    pub(super) frame: Frame,
    /// Values of the bytes 0 and 255 of harmonics, unless the mapping is (byte - 128) / 128.
    pub(super) harmonics_range: Option<[f32; 2]>,
    /// Means, opacities, colours, scales, rotations, harmonics.
    pub(super) arrays: [Vec<u8>; 6],
    pub(super) warnings: Vec<String>,
}

/// Bytes per Gaussian in each of the arrays.
pub(super) fn sizes(version: u32, degree: u32) -> [u64; 6] {
    let mean = if version == 1 { 6 } else { 9 };
    let rotation = if version >= 3 { 4 } else { 3 };
    let harmonics = 3 * (harmonics_count(degree) as u64 - 1);
    [mean, 1, 3, 3, rotation, harmonics]
}

impl Packed {
    /// Passes all Gaussians and the warnings to the collector.
    pub(in super::super) fn unpack(&self, collector: &mut Collector) {
        collector.antialiased = self.antialiased;
        collector.description.warnings.extend_from_slice(&self.warnings);
        if self.degree > 3 {
            collector.warn("harmonics of degree 4 are left out");
        }
        let sizes = sizes(self.version, self.degree).map(|size| size as usize);
        let mut harmonics = vec![[0.0; 3]; harmonics_count(self.degree)];
        for index in 0..self.count as usize {
            let part = |array: usize| &self.arrays[array][index * sizes[array]..][..sizes[array]];
            let colors = part(2);
            let scales = part(3);
            harmonics[0] =
                std::array::from_fn(|c| ((f64::from(colors[c]) / 255.0 - 0.5) / COLOR_SCALE) as f32);
            for (triple, bytes) in harmonics[1..].iter_mut().zip(part(5).as_chunks::<3>().0) {
                *triple = bytes.map(|byte| self.harmonic(byte));
            }
            let splat = Splat {
                mean: self.mean(part(0)),
                scale: std::array::from_fn(|axis| (f64::from(scales[axis]) / 16.0 - 10.0).exp()),
                rotation: rotation(part(4)),
                opacity: f64::from(part(1)[0]) / 255.0,
            };
            collector.push(&splat, &harmonics);
        }
    }

    fn mean(&self, bytes: &[u8]) -> [f64; 3] {
        if let [a, b, c, d, e, f] = *bytes {
            let half = |low, high| f16::from_le_bytes([low, high]).to_f64();
            return [half(a, b), half(c, d), half(e, f)];
        }
        let unit = f64::from(self.fractional_bits).exp2().recip();
        let (triples, _) = bytes.as_chunks::<3>();
        std::array::from_fn(|axis| {
            let [low, middle, high] = triples[axis];
            // The upper 24 bits, then an arithmetic shift for the sign.
            f64::from(i32::from_le_bytes([0, low, middle, high]) >> 8) * unit
        })
    }

    fn harmonic(&self, byte: u8) -> f32 {
        match self.harmonics_range {
            Some([min, max]) => min + f32::from(byte) / 255.0 * (max - min),
            None => (f32::from(byte) - 128.0) / 128.0,
        }
    }
}

/// Quaternion x y z w.
fn rotation(bytes: &[u8]) -> [f64; 4] {
    match *bytes {
        [a, b, c, d] => {
            let word = u32::from_le_bytes([a, b, c, d]);
            let part = |shift: u32| {
                let size = f64::from((word >> shift) & 511) / 511.0 * std::f64::consts::FRAC_1_SQRT_2;
                if (word >> (shift + 9)) & 1 == 1 {
                    -size
                } else {
                    size
                }
            };
            with_largest((word >> 30) as usize, [part(20), part(10), part(0)])
        }
        [x, y, z, ..] => {
            let part = |byte| f64::from(byte) / 127.5 - 1.0;
            with_largest(3, [part(x), part(y), part(z)])
        }
        _ => [0.0; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smallest_three_keep_order_and_sign() {
        // Largest is y (1); x, z, w in the upper, middle, lower ten bits.
        let word = (1u32 << 30) | (511 << 20) | (512 << 10) | (512 | 256);
        let [x, y, z, w] = rotation(&word.to_le_bytes());
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!((x - half).abs() < 1e-12 && z == 0.0);
        assert!((w + half * 256.0 / 511.0).abs() < 1e-12);
        assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-12);
    }
}
