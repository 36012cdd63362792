//! Whether settings can be rendered.

use std::ops::RangeInclusive;

use glam::DVec3;

use super::{
    Alignment, Classification, Compositing, Coverage, Filter, Gradient, Kernel, Method, MotionBlur,
    RenderSettings, SheetSettings, SplatSettings, Stretch,
};
use crate::{Lighting, SceneError};

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
    /// Checks the range of every field, and the requirements between the parts of a method.
    ///
    /// # Errors
    /// The first field that is refused, by name.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.coverage.validate()?;
        self.moving()?;
        check("termination", self.termination, 0.0..=0.5, "0 to 0.5")?;
        match &self.method {
            Method::Sheets(sheets) => sheets.validate()?,
            Method::Splats(splats) => splats.validate()?,
        }
        if let Some(light) = &self.lighting {
            lit(light)?;
        }
        let sums = matches!(self.method.compositing(), Compositing::Xray | Compositing::Mean);
        if self.coverage != Coverage::Off && sums {
            return Err(SceneError::invalid(
                "coverage",
                self.coverage,
                "off: X-rays and means are sums, which the filter of footprints is right for",
            ));
        }
        Ok(())
    }

    /// Refuses motion blur of footprints where their sums are not light, or where they have no closed form.
    fn moving(&self) -> Result<(), SceneError> {
        if let MotionBlur::Subframes { count } = self.motion_blur {
            check("sub-frames", f64::from(count), 1.0..=4096.0, "1 to 4096")?;
        }
        if !self.motion_blur.moves_footprints() {
            return Ok(());
        }
        let reason = match &self.method {
            Method::Sheets(_) => {
                "subframes, or method splats: sheets hold sums of footprints, not footprints"
            }
            Method::Splats(splats) => match splats.blurred() {
                Ok(()) => return Ok(()),
                Err(reason) => reason,
            },
        };
        Err(SceneError::invalid("motion blur", self.motion_blur, reason))
    }
}

impl SheetSettings {
    /// Checks every field's domain.
    fn validate(&self) -> Result<(), SceneError> {
        thickness(self.thickness)?;
        check("level bias", self.level_bias, 0.0..=8.0, "0 to 8 octaves")?;
        if self.gradient == Gradient::Analytic {
            let expected =
                "0 with analytic gradients, which have no levels of detail; gradient differences has them";
            check("level bias", self.level_bias, 0.0..=0.0, expected)?;
        }
        pixel_sigma(self.filter.into())?;
        Kernel::from(self.kernel).validate()?;
        // Wider kernels amplify noise without bound when they are inverted.
        if self.prefilter && !self.splats_colors() {
            let expected = "0.3 to 1.2 voxels with the prefilter";
            check("kernel sigma", self.kernel.sigma, 0.3..=1.2, expected)?;
        }
        Ok(())
    }
}

impl SplatSettings {
    /// Checks the range of every field, and the requirements between fields.
    fn validate(&self) -> Result<(), SceneError> {
        thickness(self.sheet_thickness)?;
        pixel_sigma(self.filter)?;
        if let Alignment::Auto { budget } = self.alignment {
            check(
                "alignment budget",
                budget,
                0.0..=1.0,
                "0 to 1 of a footprint's peak",
            )?;
        }
        if let Alignment::Switch { behind } = self.alignment {
            check(
                "alignment switch",
                behind,
                0.0..=1e6,
                "0 to 1000000 voxel spacings",
            )?;
        }
        self.kernel.validate()?;
        self.reconstruction.validate()?;
        self.combinations()?;
        self.rasterizer.validate()?;
        self.table.validate()?;
        self.extraction.map_or(Ok(()), |extraction| extraction.validate())
    }

    /// Why footprints have no closed form in motion, where they have none.
    fn blurred(&self) -> Result<(), &'static str> {
        if self.compositing.classification() == Classification::Post {
            return Err(DATA_IN_MOTION);
        }
        let across = matches!(self.alignment, Alignment::Ray | Alignment::Switch { .. });
        if across || self.stretch == Stretch::Trapezoid {
            return Err(
                "subframes: footprints across the ray through the centre, and trapezoids, have no closed form in motion",
            );
        }
        Ok(())
    }
}

/// Why data are not blurred footprint by footprint.
pub(super) const DATA_IN_MOTION: &str = "subframes, or classification before splatting (pre): data that are blurred before they are \
     classified take colours that nothing in the scene has";

fn thickness(voxels: f64) -> Result<(), SceneError> {
    check("sheet thickness", voxels, 0.01..=16.0, "0.01 to 16 voxels")
}

fn pixel_sigma(filter: Filter) -> Result<(), SceneError> {
    check("pixel sigma", filter.pixel_sigma(), 0.0..=16.0, "0 to 16 pixels")
}

fn lit(light: &Lighting) -> Result<(), SceneError> {
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
    )
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
