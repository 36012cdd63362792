//! View: a camera relative to one cloud, with all constants of projection, computed in f64 and stored in f32.
//!
//! The camera is transformed into the cloud's frame, so that offsets are small numbers near the camera wherever the
//! cloud lies. Its position is stored in two f32, high and low part.

use fearless_simd::{f32x16, prelude::*};
use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::Camera;

use super::settings::{CloudSettings, LowPass, sane};

/// Pixels along an edge of the published renderer's tiles, to which it widens three standard deviations.
pub(crate) const REFERENCE_TILE: u32 = 16;
/// Tangents beyond this many times the picture's are cut in the derivative of the projection.
const TANGENT_LIMIT: f64 = 1.3;
/// Least variance at which an ellipse is still representable in f32, pixels squared.
pub(crate) const LEAST_VARIANCE: f32 = 1e-6;

/// A camera before a cloud.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalView {
    /// Camera position, local, in two f32: the rounded value and the remainder.
    pub eye: [[f32; 3]; 2],
    /// Linear part of `camera_from_local`, rows.
    pub camera_from_local: [[f32; 3]; 3],
    /// View direction, local, if all pixels share it.
    pub direction: Option<[f32; 3]>,
    pub perspective: bool,
    /// Pixels per length at depth 1, or at every depth.
    pub scale: f32,
    /// Principal point, pixels.
    pub centre: [f32; 2],
    /// Limits of x/z and y/z in the derivative; zero for orthographic cameras.
    pub tangent_limit: [f32; 2],
    /// Camera depth, world length.
    pub near: f32,
    pub low_pass: LowPass,
    /// Columns and rows of the published renderer's tiles.
    pub reference_tiles: [u32; 2],
}

impl LocalView {
    /// View of a cloud in its own space, with the near limit `near`, camera depth, world length.
    pub(crate) fn new(
        world_from_local: &DAffine3,
        near: f64,
        camera: &Camera,
        settings: &CloudSettings,
    ) -> Self {
        let local_from_world = world_from_local.inverse();
        let linear = camera.camera_from_world().matrix3 * world_from_local.matrix3;
        let eye = local_from_world.transform_point3(camera.position());
        let high = eye.as_vec3();
        let screen = camera.screen_from_camera(settings.size);
        let limit = |pixels: u32| {
            if screen.perspective {
                (TANGENT_LIMIT * 0.5 * f64::from(pixels) / screen.scale) as f32
            } else {
                0.0
            }
        };
        let (width, height) = (settings.size.width(), settings.size.height());
        Self {
            eye: [high.to_array(), (eye - high.as_dvec3()).as_vec3().to_array()],
            camera_from_local: rows(linear),
            direction: (!screen.perspective).then(|| {
                let forward = camera.camera_from_world().matrix3.transpose() * DVec3::Z;
                let local = local_from_world.matrix3 * forward;
                local.normalize_or_zero().as_vec3().to_array()
            }),
            perspective: screen.perspective,
            scale: screen.scale as f32,
            centre: screen.centre.as_vec2().to_array(),
            tangent_limit: [limit(width), limit(height)],
            near: if screen.perspective { near as f32 } else { 0.0 },
            low_pass: settings.low_pass.sane(),
            reference_tiles: [width, height].map(|pixels| pixels.div_ceil(REFERENCE_TILE)),
        }
    }
}

impl LowPass {
    fn sane(self) -> Self {
        let sane = |variance| sane(f64::from(variance)) as f32;
        match self {
            Self::Added(variance) => Self::Added(sane(variance)),
            Self::Lacking(variance) => Self::Lacking(sane(variance)),
        }
    }

    /// Variance to add to covariances xx, xy, yy of this determinant.
    #[inline(always)]
    pub(super) fn added<S: Simd>(self, simd: S, [xx, xy, yy, determinant]: [f32x16<S>; 4]) -> f32x16<S> {
        let variance = match self {
            Self::Added(variance) => return f32x16::splat(simd, variance),
            Self::Lacking(variance) => f32x16::splat(simd, variance),
        };
        // The smaller eigenvalue as determinant over the larger one, without cancellation.
        let half = (xx - yy) * 0.5;
        let larger = (xx + yy) * 0.5 + (half * half + xy * xy).sqrt();
        let smaller = determinant / larger.max(f32x16::splat(simd, f32::MIN_POSITIVE));
        (variance - smaller).max(f32x16::splat(simd, LEAST_VARIANCE))
    }
}

/// A matrix by rows, f32.
pub(crate) fn rows(matrix: DMat3) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|row| matrix.row(row).as_vec3().to_array())
}
