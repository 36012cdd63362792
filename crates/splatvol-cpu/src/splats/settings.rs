//! What can be chosen, with the published renderer's values as defaults.

use splatvol_scene::ImageSize;

/// How Gaussians are rendered. Values that make no sense (negative, not finite) count as zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SplatSettings {
    /// Pixels of the picture.
    pub size: ImageSize,
    /// Variance that is added to every footprint, pixels squared.
    pub low_pass: f32,
    /// Centres at this camera depth or nearer are not drawn; in the Gaussians' own units, that is before
    /// `world_from_local`. Perspective only: orthographic cameras draw everything before them.
    pub near: f64,
    /// What lies behind: linear light, straight alpha. Composited in display space.
    pub background: [f32; 4],
}

impl Default for SplatSettings {
    fn default() -> Self {
        Self {
            size: ImageSize::default(),
            low_pass: 0.3,
            near: 0.2,
            background: [0.0; 4],
        }
    }
}

impl SplatSettings {
    /// The defaults for a picture of a size.
    pub(crate) fn new(size: ImageSize) -> Self {
        Self {
            size,
            ..Self::default()
        }
    }
}

/// A value of the settings, or zero.
pub(crate) fn sane(value: f64) -> f64 {
    if value.is_finite() { value.max(0.0) } else { 0.0 }
}
