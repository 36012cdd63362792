//! Volumes with a closed form: the analytic tests of reconstruction and compositing.

use glam::DVec3;

use crate::fill::{unit_position, voxels};

/// Marschner and Lobb 1994 on [-1, 1]^3: `(1 - sin(pi z / 2) + alpha (1 + rho(sqrt(x^2 + y^2)))) / (2 (1 + alpha))`
/// with `rho(r) = cos(2 pi fM cos(pi r / 2))`; values in [0, 1]. z is the axis of the rings, as in the paper.
pub(crate) fn marschner_lobb(dims: [usize; 3]) -> Vec<f32> {
    voxels(dims, |[x, y, z]| {
        let p = DVec3::new(
            unit_position(x, dims[0]),
            unit_position(y, dims[1]),
            unit_position(z, dims[2]),
        );
        marschner_lobb_value(p) as f32
    })
}

fn marschner_lobb_value(p: DVec3) -> f64 {
    use std::f64::consts::{FRAC_PI_2, TAU};
    const ALPHA: f64 = 0.25;
    const FREQUENCY: f64 = 6.0;
    let rings = libm::cos(TAU * FREQUENCY * libm::cos(FRAC_PI_2 * p.truncate().length()));
    (1.0 - libm::sin(FRAC_PI_2 * p.z) + ALPHA * (1.0 + rings)) / (2.0 * (1.0 + ALPHA))
}

/// Ball `1 - (r/R)^2`, below 0 outside, with R nine tenths of the half side. Second differences are constant, so
/// that the reconstruction error of any kernel is known.
pub(crate) fn ball(dims: [usize; 3]) -> Vec<f32> {
    const RADIUS: f64 = 0.9;
    voxels(dims, |[x, y, z]| {
        let p = DVec3::new(
            unit_position(x, dims[0]),
            unit_position(y, dims[1]),
            unit_position(z, dims[2]),
        );
        (1.0 - p.length_squared() / (RADIUS * RADIUS)) as f32
    })
}

/// Ramp from 0 to 1 along x.
pub(crate) fn slab(dims: [usize; 3]) -> Vec<f32> {
    voxels(dims, |[x, _, _]| (0.5 * (unit_position(x, dims[0]) + 1.0)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marschner_lobb_has_its_published_values() {
        // On the axis rho = cos(2 pi 6) = 1; on the unit circle rho = cos(0) = 1.
        for (p, expected) in [
            (DVec3::ZERO, 1.5 / 2.5),
            (DVec3::new(0.0, 0.0, 1.0), 0.5 / 2.5),
            (DVec3::new(0.0, 0.0, -1.0), 2.5 / 2.5),
            (DVec3::new(1.0, 0.0, 0.0), 1.5 / 2.5),
        ] {
            assert!((marschner_lobb_value(p) - expected).abs() < 1e-12, "{p}");
        }
    }

    #[test]
    fn ball_is_one_in_the_middle_and_zero_at_its_radius() {
        let values = ball([21, 21, 21]);
        let at = |x: usize, y: usize, z: usize| values[(z * 21 + y) * 21 + x];
        assert_eq!(at(10, 10, 10), 1.0);
        assert!(at(19, 10, 10).abs() < 1e-6 && at(10, 1, 10).abs() < 1e-6);
        assert!(at(0, 10, 10) < 0.0);
    }
}
