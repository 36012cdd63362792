//! Rotations with the same bits on every platform: glam's own call the sine and cosine of the C library.

use glam::{DQuat, DVec3};

/// The rotation about an axis of length 1, right-handed, by an angle in radians.
pub fn about(axis: DVec3, angle: f64) -> DQuat {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let [x, y, z] = (axis * sine).to_array();
    DQuat::from_xyzw(x, y, z, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_glam() {
        for i in 0..50 {
            let angle = 0.37 * f64::from(i) - 9.0;
            let axis = DVec3::new(angle.sin(), 0.3, angle.cos()).normalize();
            let expected = DQuat::from_axis_angle(axis, angle);
            assert!(about(axis, angle).abs_diff_eq(expected, 1e-15), "{angle}");
        }
    }
}
