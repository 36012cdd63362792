//! The methods of the papers, whole. What a paper leaves open is as in [`RenderSettings::best`].

use super::{
    Absorption, Alignment, Classification, Compositing, Filter, Kernel, MotionBlur, RenderSettings,
    SheetContent,
};

impl RenderSettings {
    /// swan1997: splats composited one by one, each perpendicular to the ray through its voxel; beyond the distance k they
    /// grow and their opacity falls (section 4.3, 5). Set the filter to [`Filter::Swan`] to let extinction fall instead,
    /// which keeps opaque data opaque.
    pub fn swan1997() -> Self {
        Self {
            compositing: Compositing::PerSplat,
            classification: Classification::Pre,
            sheet: Some(SheetContent::Section),
            filter: Filter::SwanAlpha,
            alignment: Alignment::Ray,
            kernel: Kernel::CrawfisMax,
            prefilter: false,
            ..Self::best()
        }
    }

    /// mueller1998: the same, but each footprint takes the cheapest alignment that errs by less than a level of eight bits
    /// (section 4.2 switches by depth instead), and motion, where a scene has any, makes capsules of them (section 5.1).
    pub fn mueller1998() -> Self {
        Self {
            alignment: Alignment::AUTO,
            motion_blur: MotionBlur::Capsule,
            ..Self::swan1997()
        }
    }

    /// zwicker2001: affine footprints of Gaussians as wide as a voxel, cut at two standard deviations, low-passed by the
    /// identity, added up on slices of the grid (sections 4 and 6); `1 - x` in place of `exp(-x)` (eq. 4).
    pub fn ewa2001() -> Self {
        Self {
            compositing: Compositing::AxisSheets,
            classification: Classification::Pre,
            sheet: Some(SheetContent::Section),
            absorption: Absorption::Linear,
            filter: Filter::Ewa { pixel_sigma: 1.0 },
            alignment: Alignment::Affine,
            kernel: Kernel::Gaussian {
                sigma: 1.0,
                radius: 2.0,
            },
            prefilter: false,
            ..Self::best()
        }
    }
}
