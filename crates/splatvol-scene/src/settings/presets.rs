//! Whole settings by name.

use super::filter::PIXEL_SIGMA;
use super::{
    Absorption, Alignment, Classification, Coverage, Filter, GaussianMode, Gradient, Kernel, KernelEdge,
    MotionBlur, Occlusion, PixelFilter, Rasterizer, RenderSettings, SheetKernel, SheetSettings, SheetValues,
    Shows, SplatCompositing, SplatSettings,
};
use crate::{ImageSize, Lighting};

/// Error that a finished pixel may leave, in the exact presets.
const EXACT_TERMINATION: f64 = 1.0 / 1024.0;
/// Error that a finished pixel may leave, in the fast presets: less than a level of eight bits.
const FAST_TERMINATION: f64 = 1.0 / 256.0;
/// The narrowest kernel of 35.5 dB on Marschner-Lobb data whose ripple is below 5e-4 (docs/numerics.md).
const EXACT_KERNEL: SheetKernel = SheetKernel {
    sigma: 0.74,
    radius: 3.0,
};
/// A kernel that meets four sheets a voxel apart.
const FAST_KERNEL: SheetKernel = SheetKernel {
    sigma: 0.64,
    radius: 2.0,
};
/// Standard deviation of `exp(-1.38 r^2)`, the papers' Gaussian of radius 2 (mueller1998 section 4.2).
const PAPER_SIGMA: f64 = 0.602;

impl Default for RenderSettings {
    /// [`RenderSettings::balanced`].
    fn default() -> Self {
        Self::balanced()
    }
}

impl Default for SheetSettings {
    /// [`SheetSettings::balanced`].
    fn default() -> Self {
        Self::balanced()
    }
}

impl SheetSettings {
    /// The settings of [`RenderSettings::best`].
    pub fn best() -> Self {
        Self {
            shows: Shows::Material(Classification::Post),
            thickness: 0.5,
            kernel: EXACT_KERNEL,
            filter: PixelFilter::Ewa {
                pixel_sigma: PIXEL_SIGMA,
            },
            gradient: Gradient::Analytic,
            level_bias: 0.0,
            prefilter: true,
        }
    }

    /// The settings of [`RenderSettings::balanced`].
    pub fn balanced() -> Self {
        Self {
            thickness: 0.5,
            ..Self::fast()
        }
    }

    /// The settings of [`RenderSettings::fast`].
    pub fn fast() -> Self {
        Self {
            thickness: 1.0,
            kernel: FAST_KERNEL,
            filter: PixelFilter::Matched {
                pixel_sigma: PIXEL_SIGMA,
            },
            gradient: Gradient::Differences,
            ..Self::best()
        }
    }

    /// The settings of [`RenderSettings::draft`].
    pub fn draft() -> Self {
        Self {
            level_bias: 1.0,
            ..Self::fast()
        }
    }
}

impl RenderSettings {
    /// The most exact method: sheets half a voxel apart, a kernel that reaches 35.5 dB on Marschner-Lobb data, analytic
    /// gradients, and the EWA filter on every footprint.
    pub fn best() -> Self {
        Self::of(SheetSettings::best(), EXACT_TERMINATION)
    }

    /// The fast method with sheets half a voxel apart: pictures do not depend on where sheets happen to lie.
    pub fn balanced() -> Self {
        Self::of(SheetSettings::balanced(), EXACT_TERMINATION)
    }

    /// The fastest method: a kernel four voxels wide that meets four sheets a voxel apart, and gradients by
    /// differences. The EWA filter applies only where footprints are smaller than pixels. Pixels are finished when less
    /// than a level of eight bits shows through.
    pub fn fast() -> Self {
        Self::of(SheetSettings::fast(), FAST_TERMINATION)
    }

    /// [`RenderSettings::fast`] at half of the resolution that the picture asks for, for previews and moving pictures: an
    /// eighth of the voxels. Thin structures fade or grow soft. Where voxels are more than 1.6 pixels wide already, the
    /// picture is that of `fast`.
    pub fn draft() -> Self {
        Self::of(SheetSettings::draft(), FAST_TERMINATION)
    }

    /// FastSplats as huang2000 measured them (section 6): classified splats on sheets a voxel apart, a Gaussian of
    /// radius 2 cut in 128 sections, and `square-1d` into tables of 128 entries of 8 bits. Opacities are not
    /// attenuated within a sheet, values of sheets are sums, and a summed-area table hides voxels and bricks. `exp(-1.38 r^2)`, which is sigma
    /// 0.602, is the papers' kernel of that radius (mueller1998 section 4.2). Footprints lie parallel to the
    /// picture, so that they are circles.
    pub fn fastsplats2000() -> Self {
        let splats = SplatSettings {
            compositing: SplatCompositing::ImageSheets(Classification::Pre),
            sheet_thickness: 1.0,
            sheet_values: SheetValues::Sum,
            absorption: Absorption::Linear,
            filter: Filter::None,
            alignment: Alignment::Grid,
            rasterizer: Rasterizer::Square1d,
            occlusion: Occlusion::Sat,
            kernel: Kernel::Gaussian {
                sigma: PAPER_SIGMA,
                radius: 2.0,
            },
            ..SplatSettings::default()
        };
        Self::of(splats, FAST_TERMINATION)
    }

    /// swan1997: splats composited one by one, each perpendicular to the ray through its voxel; beyond the distance
    /// k they grow and their opacity falls (section 4.3, 5). Set the filter to [`Filter::Swan`] to let extinction
    /// fall instead, which keeps opaque data opaque.
    pub fn swan1997() -> Self {
        Self::of(swan(Alignment::Ray), EXACT_TERMINATION)
    }

    /// mueller1998: as swan1997, but each footprint takes the cheapest alignment that errs by less than a level of
    /// eight bits (section 4.2 switches by depth instead), and a scene's motion turns footprints into capsules (section
    /// 5.1).
    pub fn mueller1998() -> Self {
        Self {
            motion_blur: MotionBlur::Capsule,
            ..Self::of(swan(Alignment::AUTO), EXACT_TERMINATION)
        }
    }

    /// zwicker2001: affine footprints of Gaussians as wide as a voxel, cut at two standard deviations, low-passed
    /// by the identity, added up on slices of the grid (sections 4 and 6); `1 - x` in place of `exp(-x)` (eq. 4). What
    /// lies beyond the cut is left out, and nothing takes its place (section 6).
    pub fn ewa2001() -> Self {
        let splats = SplatSettings {
            compositing: SplatCompositing::AxisSheets,
            absorption: Absorption::Linear,
            filter: Filter::Ewa { pixel_sigma: 1.0 },
            alignment: Alignment::Affine,
            kernel: Kernel::Gaussian {
                sigma: 1.0,
                radius: 2.0,
            },
            kernel_edge: KernelEdge::Raw,
            ..SplatSettings::default()
        };
        Self::of(splats, EXACT_TERMINATION)
    }

    /// Settings with this method and the defaults for the rest of a frame.
    fn of(method: impl Into<super::Method>, termination: f64) -> Self {
        Self {
            size: ImageSize::default(),
            method: method.into(),
            coverage: Coverage::default(),
            gaussians: GaussianMode::default(),
            motion_blur: MotionBlur::default(),
            lighting: Some(Lighting::default()),
            termination,
        }
    }
}

/// Swan's splats, across rays or not.
fn swan(alignment: Alignment) -> SplatSettings {
    SplatSettings {
        filter: Filter::SwanAlpha,
        alignment,
        kernel: Kernel::CrawfisMax,
        ..SplatSettings::default()
    }
}
