//! Coverage: the kernel's share on the volume's own box (docs/numerics.md, `B`).
//!
//! Per axis `Phi((x + 1/2) / s) - Phi((x - n + 1/2) / s)` with the standard deviation s of the low-passed kernel; the
//! product over the axes is what the kernel's sum over the box's samples is but for the lattice's ripple at the faces.

use glam::{Affine3A, DMat3, DVec3, Vec3, Vec3A};
use splatvol_core::bin::Projector;
use splatvol_core::coefficients::Coefficients;
use splatvol_core::normal::cumulative;

/// The volume's box as camera space sees it.
#[derive(Debug, Clone)]
pub(crate) struct BoxCover {
    voxel_from_camera: Affine3A,
    /// Voxels along x, y, z.
    size: Vec3,
    /// Variance of the kernel, voxels squared, on every axis.
    variance: f32,
    /// Variance along each voxel axis per camera variance of the low-pass.
    low_pass: Vec3,
    table: Vec<f32>,
    /// Whether samples inside may be missing, so that the kernel's weight counts too.
    any_missing: bool,
}

/// Standard deviations that the table covers.
const REACH: f32 = 4.0;
const CELLS: usize = 2048;

impl BoxCover {
    /// Cover of a frame.
    pub(crate) fn new(projector: &Projector<'_>, coefficients: &Coefficients) -> Self {
        let margin = DVec3::from_array(coefficients.margin.map(|m| m as f64));
        let size = DVec3::from_array(coefficients.dims.map(|n| n as f64)) - 2.0 * margin;
        let voxel_from_camera =
            glam::DAffine3::from_translation(-margin) * projector.camera_from_voxel.inverse();
        let linear: DMat3 = voxel_from_camera.matrix3;
        let lateral = |row: DVec3| row.x * row.x + row.y * row.y;
        let rows = linear.transpose();
        let entry = |i: usize| cumulative(f64::from(REACH) * (2.0 * i as f64 / CELLS as f64 - 1.0)) as f32;
        Self {
            voxel_from_camera: Affine3A::from_mat3_translation(
                linear.as_mat3(),
                voxel_from_camera.translation.as_vec3(),
            ),
            size: size.as_vec3(),
            variance: projector.sigma.powi(2) as f32,
            low_pass: DVec3::new(lateral(rows.x_axis), lateral(rows.y_axis), lateral(rows.z_axis)).as_vec3(),
            table: (0..=CELLS).map(entry).collect(),
            any_missing: coefficients.any_missing,
        }
    }

    /// What a plane needs: standard deviations of the kernel per voxel axis, for a low-pass of this camera length.
    pub(crate) fn on_plane(&self, low_pass: f32) -> Vec3 {
        (Vec3::splat(self.variance) + self.low_pass * low_pass * low_pass).map(f32::sqrt)
    }

    /// Whether the kernel at a camera-space point lies on the box altogether.
    pub(crate) fn is_inside(&self, camera: [f32; 3], sigma: Vec3) -> bool {
        let point = self.corner_offset(camera);
        point.cmpge(sigma * REACH).all() && (self.size - point).cmpge(sigma * REACH).all()
    }

    /// Kernel weight on the volume's own samples at a camera-space point, given the weight W on all of the lattice.
    #[inline(always)]
    pub(crate) fn at(&self, camera: [f32; 3], sigma: Vec3, weight: f32) -> f32 {
        let point = self.corner_offset(camera);
        let axis = |x: f32, n: f32, s: f32| self.cumulative(x / s) - self.cumulative((x - n) / s);
        let own = axis(point.x, self.size.x, sigma.x)
            * axis(point.y, self.size.y, sigma.y)
            * axis(point.z, self.size.z, sigma.z);
        if self.any_missing {
            own * weight.min(1.0)
        } else {
            own
        }
    }

    /// Camera space to voxels from the box's first corner.
    #[inline(always)]
    fn corner_offset(&self, camera: [f32; 3]) -> Vec3 {
        Vec3::from(self.voxel_from_camera.transform_point3a(Vec3A::from(camera))) + 0.5
    }

    #[inline(always)]
    fn cumulative(&self, x: f32) -> f32 {
        let position = ((x + REACH) * (CELLS as f32 / (2.0 * REACH))).clamp(0.0, CELLS as f32);
        let cell = (position as usize).min(CELLS - 1);
        self.table[cell] + (position - cell as f32) * (self.table[cell + 1] - self.table[cell])
    }
}
