//! Footprints of a grid: a Gaussian in camera space, factorised by depth.
//!
//! A voxel's kernel is a Gaussian with centre u and covariance V' in camera space. It is stored as
//!
//! `N3(x; u, V') = N1(z; u_z, s_z^2) N2((x, y); (u_x, u_y) + slope (z - u_z), L)`
//!
//! with `s_z^2 = V'_zz`, `slope = V'_xyz / V'_zz` and `L = V'_xy - slope slope^T V'_zz`. Sheets have constant
//! depth, and on a plane of constant depth a perspective camera is a similarity of scale `s = f / z`. So a sheet
//! cuts the footprint in a **2-D Gaussian that is exact in both projections** ([`crate::plan::SheetShape`]).
//! zwicker2001 section 4.4 instead linearises the perspective map at the splat's centre, as [`crate::splats`] does on
//! request. There is no Jacobian here and no error that grows with the field angle, and all voxels of a grid share one
//! conic per sheet. The low-pass of `pixel_sigma` pixels adds to the screen covariance, as in zwicker2001 eq. 22.

use glam::{DMat3, DVec2};

/// Share of the variances below which an off-diagonal number is rounding: a rotated sphere has no other.
const ROUNDING: f64 = 1e-9;

/// Footprint parameters shared by all voxels of a grid: all but the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootprintShape {
    /// Standard deviation in depth, world length.
    pub depth_sigma: f64,
    /// Drift of the centre (x, y) per depth.
    pub lateral_slope: DVec2,
    /// Covariance xx, xy, yy of x and y at a given depth, world length squared.
    pub lateral_covariance: [f64; 3],
}

impl FootprintShape {
    /// Standard deviation in depth along a ray that moves by so much across per depth, world length: what decides how fine a
    /// field can be along it. Of a long ellipsoid that is tilted it is less than [`Self::depth_sigma`].
    pub fn ray_sigma(&self, ray: DVec2) -> f64 {
        let [xx, xy, yy] = self.lateral_covariance;
        let DVec2 { x, y } = ray - self.lateral_slope;
        let determinant = xx * yy - xy * xy;
        let of_slope = (x * x * yy - 2.0 * x * y * xy + y * y * xx) / determinant;
        (1.0 / (self.depth_sigma * self.depth_sigma) + of_slope)
            .sqrt()
            .recip()
    }

    /// Factorises a camera-space covariance.
    pub fn new(covariance: DMat3) -> Self {
        let depth_variance = covariance.z_axis.z;
        let slope = covariance.z_axis.truncate() / depth_variance;
        // Exact zeros let rasterizers separate x from y.
        let scale = (covariance.x_axis.x + covariance.y_axis.y + depth_variance) * ROUNDING;
        let clean = |value: f64, threshold: f64| if value.abs() < threshold { 0.0 } else { value };
        let slope = slope.map(|s| clean(s, scale / depth_variance));
        let drift = slope * slope * depth_variance;
        Self {
            depth_sigma: depth_variance.sqrt(),
            lateral_slope: slope,
            lateral_covariance: [
                covariance.x_axis.x - drift.x,
                clean(covariance.x_axis.y - slope.x * slope.y * depth_variance, scale),
                covariance.y_axis.y - drift.y,
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn rays_are_as_long_as_the_inverse_covariance_says() {
        let m = DMat3::from_cols(
            DVec3::new(1.0, 0.2, -0.4),
            DVec3::new(0.1, 0.7, 0.3),
            DVec3::new(2.0, -1.0, 3.0),
        );
        let covariance = m * m.transpose();
        let expected = covariance.inverse().z_axis.z.powf(-0.5);
        let shape = FootprintShape::new(covariance);
        assert!((shape.ray_sigma(DVec2::ZERO) / expected - 1.0).abs() < 1e-12);
        let ray = DVec2::new(0.3, -0.2);
        let along = ray.extend(1.0);
        let expected = along.dot(covariance.inverse() * along).powf(-0.5);
        assert!((shape.ray_sigma(ray) / expected - 1.0).abs() < 1e-12);
        let steepest = shape.ray_sigma(shape.lateral_slope);
        assert!((steepest / shape.depth_sigma - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_shape_has_the_covariance_that_it_is_made_of() {
        let m = DMat3::from_cols(
            DVec3::new(0.9, 0.2, -0.1),
            DVec3::new(-0.3, 1.4, 0.25),
            DVec3::new(0.1, -0.4, 2.2),
        );
        let covariance = m * m.transpose() * 0.49;
        let shape = FootprintShape::new(covariance);
        let (t, z) = (shape.lateral_slope, shape.depth_sigma.powi(2));
        let [xx, xy, yy] = shape.lateral_covariance;
        let found = DMat3::from_cols(
            DVec3::new(xx + t.x * t.x * z, xy + t.x * t.y * z, t.x * z),
            DVec3::new(xy + t.x * t.y * z, yy + t.y * t.y * z, t.y * z),
            DVec3::new(t.x * z, t.y * z, z),
        );
        assert!(found.abs_diff_eq(covariance, 1e-12), "{found} {covariance}");
    }

    #[test]
    fn a_rotated_sphere_is_a_sphere_to_the_bit() {
        let turned = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.1);
        let shape = FootprintShape::new(turned * turned.transpose() * 0.49);
        assert_eq!(shape.lateral_slope, DVec2::ZERO);
        assert_eq!(shape.lateral_covariance[1], 0.0);
    }
}
