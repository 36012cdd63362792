//! Directions and rotations with the same bits on every platform: glam's own functions call the sine and cosine of the
//! C library.

use glam::{Mat3, Vec2, Vec3};

/// The direction at an angle from x towards y, radians.
pub(crate) fn direction(angle: f32) -> Vec2 {
    let (sine, cosine) = libm::sincosf(angle);
    Vec2::new(cosine, sine)
}

/// The rotation by angles about the x, y and z axes, in this order, radians.
pub(crate) fn about_axes([x, y, z]: [f32; 3]) -> Mat3 {
    let (x, y, z) = (direction(x), direction(y), direction(z));
    let about_x = Mat3::from_cols(Vec3::X, Vec3::new(0.0, x.x, x.y), Vec3::new(0.0, -x.y, x.x));
    let about_y = Mat3::from_cols(Vec3::new(y.x, 0.0, -y.y), Vec3::Y, Vec3::new(y.y, 0.0, y.x));
    let about_z = Mat3::from_cols(Vec3::new(z.x, z.y, 0.0), Vec3::new(-z.y, z.x, 0.0), Vec3::Z);
    about_z * about_y * about_x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agree_with_glam() {
        for i in 0..50 {
            let angle = 0.37 * i as f32 - 9.0;
            assert!(
                direction(angle).abs_diff_eq(Vec2::from_angle(angle), 1e-6),
                "{angle}"
            );
            let angles = [angle, 0.3 * angle, 2.0 - angle];
            let expected = Mat3::from_rotation_z(angles[2])
                * Mat3::from_rotation_y(angles[1])
                * Mat3::from_rotation_x(angles[0]);
            assert!(about_axes(angles).abs_diff_eq(expected, 1e-6), "{angle}");
        }
    }
}
