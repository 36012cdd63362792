//! Whether settings can be rendered.

use std::ops::RangeInclusive;

use glam::DVec3;

use super::{
    Alignment, Classification, Compositing, Kernel, MotionBlur, RenderSettings, SheetContent, Stretch,
};
use crate::SceneError;

const NO_PREFILTER: &str = "gaussian where data are interpolated; others with prefilter off";

const NO_MAXIMA: &str = "gaussian: maxima are of values on planes, which other kernels do not have";
const NO_SAMPLES: &str = "gaussian where sheets hold samples (post); others are splatted as colours (pre) or as \
                          sections of sheets";

fn check(
    field: &'static str,
    value: f64,
    range: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), SceneError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(SceneError::invalid(field, value, expected))
    }
}

impl Kernel {
    /// Checks the domain of the kernel's parameters, as [`RenderSettings::validate`] does too.
    ///
    /// # Errors
    /// The first parameter outside its domain, by name.
    pub fn validate(self) -> Result<(), SceneError> {
        match self {
            Self::Gaussian { sigma, radius } => {
                check("kernel sigma", sigma, 0.3..=4.0, "0.3 to 4 voxels")?;
                let radii = 1.5 * sigma..=8.0 * sigma;
                check("kernel radius", radius, radii, "1.5 to 8 sigma")
            }
            Self::CrawfisMax | Self::CubicBspline => Ok(()),
            Self::KaiserBessel { radius, alpha } => {
                check("kernel radius", radius, 1.0..=4.0, "1 to 4 voxels")?;
                check("kernel alpha", alpha, 0.0..=40.0, "0 to 40")
            }
        }
    }
}

impl RenderSettings {
    /// Checks every field's domain.
    ///
    /// # Errors
    /// The first field outside its domain, by name.
    pub fn validate(&self) -> Result<(), SceneError> {
        check(
            "sheet thickness",
            self.sheet_thickness,
            0.01..=16.0,
            "0.01 to 16 voxels",
        )?;
        check(
            "pixel sigma",
            self.filter.pixel_sigma(),
            0.0..=16.0,
            "0 to 16 pixels",
        )?;
        if let Alignment::Auto { budget } = self.alignment {
            check(
                "alignment budget",
                budget,
                0.0..=1.0,
                "0 to 1 of a footprint's peak",
            )?;
        }
        self.coverage.validate()?;
        self.stretching()?;
        if let MotionBlur::Subframes { count } = self.motion_blur {
            check("sub-frames", f64::from(count), 1.0..=4096.0, "1 to 4096")?;
        }
        self.moving()?;
        check("termination", self.termination, 0.0..=0.5, "0 to 0.5")?;
        self.kernel.validate()?;
        self.kernel_suits_method()?;
        self.combinations()?;
        self.rasterizer.validate()?;
        self.table.validate()?;
        self.extraction
            .map_or(Ok(()), |extraction| extraction.validate())?;
        if let Some(light) = self.lighting {
            for (field, value) in [
                ("ambient", light.ambient),
                ("diffuse", light.diffuse),
                ("specular", light.specular),
            ] {
                check(field, value, 0.0..=10.0, "0 to 10")?;
            }
            let direction = DVec3::from_array(light.direction);
            if direction.try_normalize().is_none() || (direction.normalize() - DVec3::Z).length() < 1e-6 {
                return Err(SceneError::invalid(
                    "light direction",
                    light.direction,
                    "finite, and not from behind",
                ));
            }
            check("specular power", light.specular_power, 1.0..=1000.0, "1 to 1000")?;
            check(
                "gradient floor",
                light.gradient_floor,
                1e-6..=10.0,
                "0.000001 to 10",
            )?;
        }
        Ok(())
    }
    /// Refuses motion blur of footprints where their sums are not light, or where they have no closed form.
    fn moving(&self) -> Result<(), SceneError> {
        let reason = match self.compositing {
            _ if !self.motion_blur.moves_footprints() => return Ok(()),
            shown if shown.shows_one_value() => {
                "subframes: the value that is shown of a ray is no sum of footprints that could be blurred one by one"
            }
            Compositing::Xray => "",
            _ if self.classification == Classification::Post => {
                "subframes, or classification before splatting (pre): data that are blurred before they are classified \
                 take colours that nothing in the scene has"
            }
            _ => "",
        };
        let reason = match reason {
            "" if self.alignment == Alignment::Ray || self.stretch == Stretch::Trapezoid => {
                "subframes: footprints across the ray through the centre, and trapezoids, have no closed form in motion"
            }
            reason => reason,
        };
        if reason.is_empty() {
            return Ok(());
        }
        Err(SceneError::invalid("motion blur", self.motion_blur, reason))
    }

    /// Whether the kernel and the method can be used together.
    fn kernel_suits_method(&self) -> Result<(), SceneError> {
        let Some((sigma, _)) = self.kernel.gaussian() else {
            return match self.compositing {
                shown if shown.shows_one_value() => Err(self.refused_kernel(NO_MAXIMA)),
                _ if self.interpolates() => Err(self.refused_kernel(NO_PREFILTER)),
                Compositing::ImageSheets
                    if self.classification == Classification::Post
                        && self.sheet != Some(SheetContent::Section) =>
                {
                    Err(self.refused_kernel(NO_SAMPLES))
                }
                _ => Ok(()),
            };
        };
        // Wider kernels amplify noise without bound when they are inverted.
        if self.prefilter && self.classification == Classification::Post {
            let expected = "0.3 to 1.2 voxels with the prefilter";
            check("kernel sigma", sigma, 0.3..=1.2, expected)?;
        }
        Ok(())
    }

    /// Whether the prefilter has an effect.
    fn interpolates(&self) -> bool {
        let of_data = match self.compositing {
            Compositing::ImageSheets => {
                self.classification == Classification::Post && self.sheet != Some(SheetContent::Section)
            }
            shown => shown.shows_one_value(),
        };
        self.prefilter && of_data
    }

    fn refused_kernel(&self, expected: &'static str) -> SceneError {
        SceneError::invalid("kernel", self.kernel.name(), expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Extraction, FootprintTable, Rasterizer, Reconstruction};

    fn refusal(kernel: Kernel) -> String {
        kernel.validate().expect_err("outside its domain").to_string()
    }

    #[test]
    fn kernels_outside_their_domain_are_refused_by_name() {
        let gaussian = |sigma, radius| Kernel::Gaussian { sigma, radius };
        let blob = |radius, alpha| Kernel::KaiserBessel { radius, alpha };
        assert!(refusal(gaussian(0.1, 0.5)).starts_with("kernel sigma: 0.1"));
        assert!(refusal(gaussian(1.0, 9.0)).starts_with("kernel radius: 9.0"));
        assert!(refusal(blob(5.0, 10.0)).starts_with("kernel radius: 5.0"));
        assert!(refusal(blob(2.0, 41.0)).starts_with("kernel alpha: 41.0"));
        assert!(refusal(blob(2.0, f64::NAN)).starts_with("kernel alpha: NaN"));
        for kernel in [
            Kernel::default(),
            Kernel::CrawfisMax,
            Kernel::CubicBspline,
            Kernel::KAISER_BESSEL,
            blob(1.0, 0.0),
        ] {
            assert_eq!(kernel.validate(), Ok(()));
        }
    }

    #[test]
    fn other_kernels_are_not_prefiltered() {
        for compositing in [Compositing::ImageSheets, Compositing::Mip, Compositing::Mean] {
            let settings = RenderSettings {
                kernel: Kernel::CrawfisMax,
                compositing,
                prefilter: true,
                ..RenderSettings::default()
            };
            let text = settings.validate().expect_err("refused").to_string();
            assert!(text.starts_with("kernel: \"crawfis-max\""), "{text}");
        }
    }

    #[test]
    fn footprints_of_any_kernel_are_splatted_but_planes_have_none() {
        let colors = RenderSettings {
            kernel: Kernel::CubicBspline,
            classification: Classification::Pre,
            ..RenderSettings::default()
        };
        let sections = RenderSettings {
            classification: Classification::Post,
            sheet: Some(SheetContent::Section),
            prefilter: false,
            ..colors
        };
        assert_eq!(colors.validate(), Ok(()));
        assert_eq!(sections.validate(), Ok(()));
        let planes = RenderSettings {
            sheet: None,
            ..sections
        };
        let text = planes.validate().expect_err("refused").to_string();
        assert!(text.contains("sections of sheets"), "{text}");
    }

    #[test]
    fn rasterizers_tables_and_ranges_outside_their_domain_are_refused() {
        let base = RenderSettings::fastsplats2000();
        assert_eq!(base.validate(), Ok(()));
        let table = |entries, sections| RenderSettings {
            table: FootprintTable {
                entries,
                sections,
                ..base.table
            },
            ..base
        };
        let raster = |rasterizer| RenderSettings { rasterizer, ..base };
        let range = |density, gradient| RenderSettings {
            extraction: Some(Extraction { density, gradient }),
            ..base
        };
        let flat = RenderSettings {
            reconstruction: Reconstruction::Surface { flatness: 4.0 },
            ..base
        };
        let planes = RenderSettings {
            rasterizer: Rasterizer::Ellipse1d,
            ..RenderSettings::default()
        };
        for (settings, start) in [
            (table(31, 128), "table entries: 31"),
            (table(1025, 128), "table entries: 1025"),
            (table(128, 0), "table sections: 0"),
            (raster(Rasterizer::Rlut { subpixels: 129 }), "subpixels: 129"),
            (raster(Rasterizer::Blit2d { subpixels: 0 }), "subpixels: 0"),
            (range(Some([2.0, 1.0]), 0.0), "extraction density: [2.0, 1.0]"),
            (range(None, f64::NAN), "extraction gradient: NaN"),
            (flat, "rasterizer: \"square-1d\""),
            (planes, "sheet: None"),
        ] {
            let text = settings.validate().expect_err(start).to_string();
            assert!(text.starts_with(start), "{text}");
        }
    }
}
