//! Settings with one field changed, for user code.

use super::{
    Coverage, GaussianMode, Gradient, Method, MotionBlur, PixelFilter, RenderSettings, SheetKernel,
    SheetSettings, Shows,
};
use crate::{ImageSize, Lighting};

impl RenderSettings {
    /// These settings for pictures of another size, pixels.
    #[must_use]
    pub fn with_size(self, size: ImageSize) -> Self {
        Self { size, ..self }
    }

    /// These settings with another method.
    #[must_use]
    pub fn with_method(self, method: impl Into<Method>) -> Self {
        Self {
            method: method.into(),
            ..self
        }
    }

    /// These settings with sheets that show something else: X-rays, maxima, means. Settings of splats take the
    /// sheets of [`RenderSettings::balanced`] for this.
    #[must_use]
    pub fn with_shows(self, shows: Shows) -> Self {
        let sheets = self.method.sheets().copied().unwrap_or_default();
        self.with_method(sheets.with_shows(shows))
    }

    /// These settings with other anti-aliasing of edges.
    #[must_use]
    pub fn with_coverage(self, coverage: Coverage) -> Self {
        Self { coverage, ..self }
    }

    /// These settings with 3-D Gaussians composited in another way.
    #[must_use]
    pub fn with_gaussians(self, gaussians: GaussianMode) -> Self {
        Self { gaussians, ..self }
    }

    /// These settings with motion blurred in another way.
    #[must_use]
    pub fn with_motion_blur(self, motion_blur: MotionBlur) -> Self {
        Self { motion_blur, ..self }
    }

    /// These settings in another light; `None` shows the transfer function's colours as they are.
    #[must_use]
    pub fn with_lighting(self, lighting: impl Into<Option<Lighting>>) -> Self {
        Self {
            lighting: lighting.into(),
            ..self
        }
    }

    /// These settings with another transmittance below which a pixel is finished.
    #[must_use]
    pub fn with_termination(self, termination: f64) -> Self {
        Self { termination, ..self }
    }
}

impl SheetSettings {
    /// These settings, showing something else.
    #[must_use]
    pub fn with_shows(self, shows: Shows) -> Self {
        Self { shows, ..self }
    }

    /// These settings with sheets of another thickness, mean voxel spacings.
    #[must_use]
    pub fn with_thickness(self, thickness: f64) -> Self {
        Self { thickness, ..self }
    }

    /// These settings with another kernel.
    #[must_use]
    pub fn with_kernel(self, kernel: SheetKernel) -> Self {
        Self { kernel, ..self }
    }

    /// These settings with another low-pass.
    #[must_use]
    pub fn with_filter(self, filter: PixelFilter) -> Self {
        Self { filter, ..self }
    }

    /// These settings with gradients from elsewhere.
    #[must_use]
    pub fn with_gradient(self, gradient: Gradient) -> Self {
        Self { gradient, ..self }
    }

    /// These settings with levels of detail that are coarser than the picture asks, octaves.
    #[must_use]
    pub fn with_level_bias(self, level_bias: f64) -> Self {
        Self { level_bias, ..self }
    }

    /// These settings with the reconstruction interpolating the samples, or not.
    #[must_use]
    pub fn with_prefilter(self, prefilter: bool) -> Self {
        Self { prefilter, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplatSettings;

    #[test]
    fn one_field_changes_and_the_others_stay() {
        let size = ImageSize::new(64, 48).unwrap();
        let settings = RenderSettings::best()
            .with_size(size)
            .with_shows(Shows::Mip)
            .with_lighting(None);
        let expected = RenderSettings {
            size,
            method: SheetSettings {
                shows: Shows::Mip,
                ..SheetSettings::best()
            }
            .into(),
            lighting: None,
            ..RenderSettings::best()
        };
        assert_eq!(settings, expected);
    }

    #[test]
    fn settings_of_splats_show_values_by_balanced_sheets() {
        let splats = RenderSettings::default().with_method(SplatSettings::default());
        assert_eq!(splats.method.sheets(), None);
        let shown = splats.with_shows(Shows::Xray).method;
        assert_eq!(shown, SheetSettings::balanced().with_shows(Shows::Xray).into());
    }
}
