//! Reproducible noise: an integer hash of lattice points, and smooth noise between them.
//!
//! Integer arithmetic only decides the lattice values, so that they are the same on every machine.

use glam::Vec3;

/// Hash of a lattice point; the finaliser is that of `MurmurHash3`.
#[inline]
pub(crate) fn hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let mut h = seed
        ^ (x as u32).wrapping_mul(0x9E37_79B1)
        ^ (y as u32).wrapping_mul(0x85EB_CA77).rotate_left(11)
        ^ (z as u32).wrapping_mul(0xC2B2_AE3D).rotate_left(21);
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// Uniform noise in [-1, 1) of a lattice point.
#[inline]
pub(crate) fn white(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    (hash(x, y, z, seed) >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0
}

/// Sum of two uniform numbers, in (-1, 1), with a triangular density: close enough to Gaussian for scanner noise.
#[inline]
pub(crate) fn triangular(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    let h = hash(x, y, z, seed);
    ((h & 0xFFFF) as f32 + (h >> 16) as f32) * (1.0 / 65_536.0) - 1.0
}

/// Smooth noise in [-1, 1] with features about 1 apart: lattice values joined by smoothstep weights.
pub(crate) fn smooth(p: Vec3, seed: u32) -> f32 {
    let cell = p.floor();
    let t = p - cell;
    let w = t * t * (Vec3::splat(3.0) - 2.0 * t);
    let [x, y, z] = cell.to_array().map(|c| c as i32);
    let along_x = |dy: i32, dz: i32| {
        let a = white(x, y + dy, z + dz, seed);
        a + w.x * (white(x.wrapping_add(1), y + dy, z + dz, seed) - a)
    };
    let along_y = |dz: i32| {
        let a = along_x(0, dz);
        a + w.y * (along_x(1, dz) - a)
    };
    let a = along_y(0);
    a + w.z * (along_y(1) - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_fills_its_range_without_bias() {
        let count = 20_000;
        let values: Vec<f32> = (0..count).map(|i| white(i, 3 * i, -i, 7)).collect();
        let mean = values.iter().sum::<f32>() / count as f32;
        let variance = values.iter().map(|v| v * v).sum::<f32>() / count as f32;
        assert!(mean.abs() < 0.02, "{mean}");
        assert!((variance - 1.0 / 3.0).abs() < 0.02, "{variance}");
        let spread = |i: i32| triangular(i, -i, 5, 1);
        let variance = (0..count).map(|i| spread(i).powi(2)).sum::<f32>() / count as f32;
        assert!((variance - 1.0 / 6.0).abs() < 0.01, "{variance}");
    }

    #[test]
    fn smooth_noise_meets_its_lattice_and_is_continuous() {
        assert_eq!(smooth(Vec3::new(3.0, -2.0, 5.0), 9), white(3, -2, 5, 9));
        let mut last = smooth(Vec3::new(-1.5, 0.3, 0.7), 9);
        for i in 1..3000 {
            let here = smooth(Vec3::new(-1.5 + i as f32 * 1e-3, 0.3, 0.7), 9);
            assert!((here - last).abs() < 5e-3);
            last = here;
        }
    }
}
