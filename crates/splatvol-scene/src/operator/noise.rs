//! Gradient noise (Perlin 1985, with the fifth-degree fade of Perlin 2002): zero at lattice points, features about
//! 1 apart.
//!
//! The gradients are chosen by an integer hash and everything else is multiplication and addition: the same on
//! every machine.

use glam::{IVec3, Vec3};

/// Hash of a lattice point; the finaliser is that of `MurmurHash3`.
fn hash(point: IVec3, seed: u32) -> u32 {
    let mut h = seed
        ^ (point.x as u32).wrapping_mul(0x9E37_79B1)
        ^ (point.y as u32).wrapping_mul(0x85EB_CA77).rotate_left(11)
        ^ (point.z as u32).wrapping_mul(0xC2B2_AE3D).rotate_left(21);
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    h ^ (h >> 16)
}

/// The twelve directions to the edges of a cube, four of them twice.
fn slope(hash: u32, p: Vec3) -> f32 {
    let h = hash & 15;
    let u = if h < 8 { p.x } else { p.y };
    let v = match h {
        0..4 => p.y,
        12 | 14 => p.x,
        _ => p.z,
    };
    (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
}

/// Largest coordinate: beyond, a float has no fractions left.
const FARTHEST: f32 = 4e6;

/// Noise at a point, about -1 to 1, with continuous second derivatives; another one for each seed.
pub fn gradient_noise(p: Vec3, seed: u32) -> f32 {
    let p = p.clamp(Vec3::splat(-FARTHEST), Vec3::splat(FARTHEST));
    let cell = p.floor();
    let t = p - cell;
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let cell = cell.as_ivec3();
    let corner = |x: i32, y: i32, z: i32| {
        let offset = IVec3::new(x, y, z);
        slope(hash(cell + offset, seed), t - offset.as_vec3())
    };
    let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
    let row = |y: i32, z: i32| mix(corner(0, y, z), corner(1, y, z), fade.x);
    let slice = |z: i32| mix(row(0, z), row(1, z), fade.y);
    mix(slice(0), slice(1), fade.z)
}

/// Sum of octaves of noise: each twice as fine and half as strong as the one before.
pub(super) fn octaves(mut p: Vec3, count: u32, shape: impl Fn(f32) -> f32) -> f32 {
    let (mut sum, mut strength) = (0.0, 1.0);
    for seed in 0..count {
        sum += strength * shape(gradient_noise(p, seed));
        strength *= 0.5;
        p *= 2.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_zero_on_the_lattice_continuous_and_without_bias() {
        let (mut sum, mut most) = (0.0f64, 0.0f32);
        let count = 20_000;
        for i in 0..count {
            let p = Vec3::new(0.137, 0.071, -0.093) * i as f32;
            let value = gradient_noise(p, 5);
            let step = 1e-3;
            assert!((gradient_noise(p + step, 5) - value).abs() < 8.0 * step, "{p}");
            sum += f64::from(value);
            most = most.max(value.abs());
        }
        assert_eq!(gradient_noise(Vec3::new(3.0, -7.0, 12.0), 1), 0.0);
        assert!((sum / f64::from(count)).abs() < 0.01, "{sum}");
        assert!((0.6..1.1).contains(&most), "{most}");
        assert!(gradient_noise(Vec3::splat(f32::MAX), 0).is_finite());
    }
}
