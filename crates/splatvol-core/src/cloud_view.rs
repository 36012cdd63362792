//! A cloud's view: a camera relative to splats that are composited whole, with all constants of their projection,
//! computed in f64 and stored in f32; and the constants of the published renderer of 3-D Gaussians (Kerbl, Kopanas,
//! Leimkuehler and Drettakis 2023).
//!
//! The camera is transformed into the cloud's frame, so that offsets are small numbers near the camera wherever the
//! cloud lies. Its position is stored in two f32, high and low part.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Camera, Filter, ImageSize, RenderSettings};

/// Variance that the published renderer adds to every footprint, pixels squared: Gaussians are trained with it.
pub const PUBLISHED_LOW_PASS: f32 = 0.3;
/// Camera depth, in the Gaussians' own units, below which the published renderer draws none.
pub const PUBLISHED_NEAR: f64 = 0.2;
/// Pixels along an edge of the published renderer's tiles, to which it widens three standard deviations.
pub const REFERENCE_TILE: u32 = 16;
/// `log2(255)`: splats count where the logarithm of their opacity is above its negative.
pub const LOG2_255: f32 = 7.994_353_3;
/// Opacities below this count as none.
pub const LEAST_ALPHA: f32 = 1.0 / 255.0;
/// A smaller opacity, whose logarithm is finite.
pub const UNSEEN_ALPHA: f32 = 1.0 / 256.0;
/// Opacity is cut here.
pub const MOST_ALPHA: f32 = 0.99;
/// Pixels end before their transmittance falls below this.
pub const LEAST_TRANSMITTANCE: f32 = 1e-4;
/// Least squared difference of the eigenvalues of a footprint's covariance from their mean, as published.
pub const LEAST_SPREAD: f32 = 0.1;
/// Bound of the ratio of determinants by which antialiased Gaussians are dimmed (Yu et al. 2024, "Mip-Splatting", eq. 11).
pub const LEAST_RATIO: f32 = 2.5e-5;
/// Least variance at which an ellipse is still representable in f32, pixels squared.
pub const LEAST_VARIANCE: f32 = 1e-6;

/// Tangents beyond this many times the picture's are cut in the derivative of the projection.
const TANGENT_LIMIT: f64 = 1.3;

/// Variance that footprints get, pixels squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LowPass {
    /// Variance added to every footprint.
    Added(f32),
    /// Only as much as the footprint's narrower axis lacks of this variance.
    Lacking(f32),
}

/// A cut Gaussian, less its value at the cut so that it ends without a step, with its integral kept (docs/numerics.md,
/// "Per-splat compositing"): the profile of whole footprints of optical depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutProfile {
    /// Edge subtracted from a Gaussian of peak 1.
    pub edge: f32,
    /// End of the profile, `log2(e) d^T V^-1 d / 2`.
    pub end: f32,
    /// Factor by which the cut raises the peak of a footprint of unit mass.
    pub peak_of_mass: f32,
}

impl CutProfile {
    /// Cut at so many standard deviations.
    pub fn new(cut: f64) -> Self {
        let half = 0.5 * cut * cut;
        let edge = libm::exp(-half);
        Self {
            edge: edge as f32,
            end: (half * std::f64::consts::LOG2_E) as f32,
            peak_of_mass: ((1.0 - edge) / (1.0 - edge - edge * half)) as f32,
        }
    }
}

/// Standard deviations at which whole footprints of optical depth are cut: where the method's kernel is; four where it is no
/// Gaussian.
pub fn cut_of(settings: &RenderSettings) -> f64 {
    let kernel = settings.method.kernel().gaussian();
    kernel.map_or(4.0, |(sigma, radius)| radius / sigma)
}

/// Camera depth, world length, from which whole footprints of optical depth are drawn: half a sheet. `spacing`: of their cloud.
pub fn near_of_depths(settings: &RenderSettings, spacing: f64) -> f64 {
    0.5 * settings.method.sheet_thickness() * spacing
}

/// A camera before a cloud.
#[derive(Debug, Clone, Copy)]
pub struct CloudView {
    /// Camera position, local, in two f32: the rounded value and the remainder.
    pub eye: [[f32; 3]; 2],
    /// Linear part of `camera_from_local`, rows.
    pub camera_from_local: [[f32; 3]; 3],
    /// View direction, local, if all pixels share it.
    pub direction: Option<[f32; 3]>,
    /// Whether rays meet at the eye.
    pub perspective: bool,
    /// Pixels per length at depth 1, or at every depth.
    pub scale: f32,
    /// Principal point, pixels.
    pub centre: [f32; 2],
    /// Limits of x/z and y/z in the derivative; zero for orthographic cameras.
    pub tangent_limit: [f32; 2],
    /// Camera depth, world length.
    pub near: f32,
    /// Variance that footprints get.
    pub low_pass: LowPass,
    /// Columns and rows of the published renderer's tiles.
    pub reference_tiles: [u32; 2],
}

impl CloudView {
    /// View of a cloud in its own space, with the near limit `near`, camera depth, world length.
    pub fn new(
        world_from_local: &DAffine3,
        near: f64,
        (camera, size): (&Camera, ImageSize),
        low_pass: LowPass,
    ) -> Self {
        let local_from_world = world_from_local.inverse();
        let linear = camera.camera_from_world().matrix3 * world_from_local.matrix3;
        let eye = local_from_world.transform_point3(camera.position());
        let high = eye.as_vec3();
        let screen = camera.screen_from_camera(size);
        let limit = |pixels: u32| {
            if screen.perspective {
                (TANGENT_LIMIT * 0.5 * f64::from(pixels) / screen.scale) as f32
            } else {
                0.0
            }
        };
        let (width, height) = (size.width(), size.height());
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
            low_pass: low_pass.sane(),
            reference_tiles: [width, height].map(|pixels| pixels.div_ceil(REFERENCE_TILE)),
        }
    }
}

impl LowPass {
    /// That of a filter. Swan's filters depend on the voxels of one grid and are applied elsewhere.
    pub fn of(filter: Filter) -> Self {
        let variance = |sigma: f64| (sigma * sigma) as f32 + LEAST_VARIANCE;
        match filter {
            Filter::None | Filter::Swan | Filter::SwanAlpha => Self::Added(LEAST_VARIANCE),
            Filter::Ewa { pixel_sigma } => Self::Added(variance(pixel_sigma)),
            Filter::Matched { pixel_sigma } => Self::Lacking(variance(pixel_sigma)),
        }
    }

    fn sane(self) -> Self {
        match self {
            Self::Added(variance) => Self::Added(sane(f64::from(variance)) as f32),
            Self::Lacking(variance) => Self::Lacking(sane(f64::from(variance)) as f32),
        }
    }
}

/// A value of the settings, or zero where it is negative or not finite.
pub fn sane(value: f64) -> f64 {
    if value.is_finite() { value.max(0.0) } else { 0.0 }
}

/// The near limit of Gaussians, camera depth, world length: [`PUBLISHED_NEAR`] in their own units.
pub fn near_of_gaussians(near: f64, world_from_local: &DAffine3) -> f64 {
    sane(near) * libm::cbrt(world_from_local.matrix3.determinant().abs())
}

/// A matrix by rows, f32.
pub fn rows(matrix: DMat3) -> [[f32; 3]; 3] {
    [0, 1, 2].map(|row| matrix.row(row).as_vec3().to_array())
}
