//! Whole settings by name.

use super::{
    Absorption, Alignment, Classification, Compositing, Filter, Gradient, Kernel, MotionBlur, Occlusion,
    Rasterizer, Reconstruction, RenderSettings, Stretch,
};
use crate::{ImageSize, Lighting};

impl Default for RenderSettings {
    /// [`RenderSettings::balanced`].
    fn default() -> Self {
        Self::balanced()
    }
}

impl RenderSettings {
    /// The most exact method: sheets half a voxel apart, a kernel that reaches 36 dB on Marschner-Lobb data, analytic
    /// gradients, and the EWA filter on every footprint.
    pub fn best() -> Self {
        Self {
            size: ImageSize::default(),
            compositing: Compositing::default(),
            classification: Classification::default(),
            sheet_thickness: 0.5,
            sheet: None,
            absorption: Absorption::default(),
            filter: Filter::default(),
            alignment: Alignment::default(),
            stretch: Stretch::default(),
            rasterizer: Rasterizer::default(),
            occlusion: Occlusion::default(),
            reconstruction: Reconstruction::default(),
            motion_blur: MotionBlur::default(),
            gradient: Gradient::Analytic,
            kernel: Kernel::default(),
            prefilter: true,
            lighting: Some(Lighting::default()),
            termination: 1.0 / 1024.0,
        }
    }

    /// The fast method with sheets half a voxel apart: pictures do not depend on where sheets happen to lie.
    pub fn balanced() -> Self {
        Self {
            sheet_thickness: 0.5,
            termination: Self::best().termination,
            ..Self::fast()
        }
    }

    /// The fastest method: a kernel four voxels wide that meets four sheets a voxel apart, gradients by differences, the EWA
    /// filter only where footprints are smaller than pixels, and pixels finished when what shows through is less than a
    /// level of eight bits.
    pub fn fast() -> Self {
        Self {
            sheet_thickness: 1.0,
            filter: Filter::Matched { pixel_sigma: 0.55 },
            gradient: Gradient::Differences,
            kernel: Kernel::Gaussian {
                sigma: 0.64,
                radius: 2.0,
            },
            termination: 1.0 / 256.0,
            ..Self::best()
        }
    }
}
