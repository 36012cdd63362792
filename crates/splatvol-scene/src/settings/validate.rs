//! Whether settings can be rendered.

use glam::DVec3;

use super::{Classification, Kernel, RenderSettings};
use crate::SceneError;

impl RenderSettings {
    /// Checks every field's domain.
    ///
    /// # Errors
    /// The first field outside its domain, by name.
    pub fn validate(&self) -> Result<(), SceneError> {
        let check = |field, value: f64, range: std::ops::RangeInclusive<f64>, expected| {
            if range.contains(&value) {
                Ok(())
            } else {
                Err(SceneError::invalid(field, value, expected))
            }
        };
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
        check("termination", self.termination, 0.0..=0.5, "0 to 0.5")?;
        let Kernel::Gaussian { sigma, radius } = self.kernel;
        check("kernel sigma", sigma, 0.3..=4.0, "0.3 to 4 voxels")?;
        check(
            "kernel radius",
            radius,
            1.5 * sigma..=8.0 * sigma,
            "1.5 to 8 sigma",
        )?;
        // Wider kernels amplify noise without bound when they are inverted.
        if self.prefilter && self.classification == Classification::Post {
            check(
                "kernel sigma",
                sigma,
                0.3..=1.2,
                "0.3 to 1.2 voxels with the prefilter",
            )?;
        }
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
}
