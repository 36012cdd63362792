//! Settings of splats that are composited one by one.

use splatvol_scene::{ImageSize, Lighting};

/// Variance that the published renderer adds to every footprint, pixels squared: Gaussians are trained with it.
const PUBLISHED_LOW_PASS: f32 = 0.3;
/// Camera depth, in the Gaussians' own units, below which the published renderer draws none.
const PUBLISHED_NEAR: f64 = 0.2;

/// Settings of a cloud of splats. Negative or non-finite values count as zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CloudSettings {
    /// Pixels of the picture.
    pub size: ImageSize,
    /// Low-pass added to footprints.
    pub low_pass: LowPass,
    /// Centres at this camera depth or nearer are not drawn. Perspective only: orthographic cameras draw all splats
    /// in front of them.
    pub near: Near,
    /// Lighting of everything but Gaussians; `None` leaves colours unlit.
    pub lighting: Option<Lighting>,
    /// Blending of splats.
    pub blend_mode: BlendMode,
}

/// Blending of splats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum BlendMode {
    /// Opacities, composited in display colours, as in the published renderer of Gaussians.
    Published {
        /// Background: linear light, straight alpha. Composited in display space.
        background: [f32; 4],
    },
    /// Optical depths, in linear light: each splat a slab of `1 - exp(-tau)`, front to back.
    Light {
        /// Cut of footprints, standard deviations.
        cut: f64,
        /// Pixels end where their transmittance falls to this.
        termination: f32,
    },
    /// Sums of the same optical depths, in any order: line integrals.
    Integral {
        /// Cut of footprints, standard deviations.
        cut: f64,
    },
}

/// Variance that footprints get, pixels squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LowPass {
    /// Variance added to every footprint.
    Added(f32),
    /// Only as much as the footprint's narrower axis lacks of this variance.
    Lacking(f32),
}

/// Near limit of splats, camera depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Near {
    /// In the Gaussians' own units, before `world_from_local`. Other splats use the nearest depth at which any
    /// cloud of Gaussians begins.
    OfGaussians(f64),
    /// World length.
    World(f64),
}

impl CloudSettings {
    /// The published values for a picture of a size.
    pub(crate) fn published(size: ImageSize) -> Self {
        Self {
            size,
            low_pass: LowPass::Added(PUBLISHED_LOW_PASS),
            near: Near::OfGaussians(PUBLISHED_NEAR),
            lighting: None,
            blend_mode: BlendMode::Published { background: [0.0; 4] },
        }
    }
}

/// A value of the settings, or zero.
pub(crate) fn sane(value: f64) -> f64 {
    if value.is_finite() { value.max(0.0) } else { 0.0 }
}
