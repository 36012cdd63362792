//! Settings of splats that are composited one by one.

pub(crate) use splatvol_core::cloud_view::{LowPass, sane};
use splatvol_core::cloud_view::{PUBLISHED_LOW_PASS, PUBLISHED_NEAR};
use splatvol_scene::{ImageSize, Lighting};

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
