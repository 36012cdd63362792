//! Whole settings by name.

use super::{
    Absorption, Alignment, Classification, Compositing, Coverage, Filter, FootprintTable, GaussianMode,
    Gradient, Kernel, MotionBlur, Occlusion, Rasterizer, Reconstruction, RenderSettings, SheetContent,
    Stretch,
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
            coverage: Coverage::default(),
            alignment: Alignment::default(),
            stretch: Stretch::default(),
            rasterizer: Rasterizer::default(),
            table: FootprintTable::default(),
            occlusion: Occlusion::default(),
            extraction: None,
            reconstruction: Reconstruction::default(),
            gaussians: GaussianMode::default(),
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

    /// FastSplats as huang2000 measured them (section 6): classified splats on sheets a voxel apart, a Gaussian of radius 2
    /// cut in 128 sections, `square-1d` into tables of 128 entries of 8 bits, opacities that are not attenuated within a
    /// sheet, and a summed-area table that hides voxels and bricks. `exp(-1.38 r^2)`, which is sigma 0.602, is the papers'
    /// kernel of that radius (mueller1998 section 4.3). Footprints lie parallel to the picture, so that they are circles.
    pub fn fastsplats2000() -> Self {
        Self {
            classification: Classification::Pre,
            sheet_thickness: 1.0,
            sheet: Some(SheetContent::Section),
            absorption: Absorption::Linear,
            filter: Filter::None,
            alignment: Alignment::Grid,
            rasterizer: Rasterizer::Square1d,
            table: FootprintTable::default(),
            occlusion: Occlusion::Sat,
            gradient: Gradient::Differences,
            kernel: Kernel::Gaussian {
                sigma: 0.602,
                radius: 2.0,
            },
            prefilter: false,
            termination: 1.0 / 256.0,
            ..Self::best()
        }
    }
}
