//! Plain settings of a frame. The methods of the papers are values here, never separate renderers.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{ImageSize, Lighting, SceneError};

/// How sheets become a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compositing {
    /// Sheets parallel to the image, front to back (huang2000 section 2).
    #[default]
    ImageSheets,
    /// Line integrals of the extinction: alpha is `1 - exp(-sum)`, without emission order.
    Xray,
    /// Largest reconstructed value along the ray, shown in its colour with its opacity per unit distance.
    Mip,
}

/// What is splatted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Classification {
    /// Voxels are classified and lit, then splatted as colour (sections of the kernel integrated over the sheet).
    Pre,
    /// Data is splatted; each sheet pixel is classified and lit (samples of the kernel on the sheet's plane).
    #[default]
    Post,
}

/// Low-pass filter in screen space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// Point samples of the footprints.
    None,
    /// The EWA filter (zwicker2001 section 4.5): footprints are convolved with a Gaussian.
    Ewa {
        /// Standard deviation of the Gaussian, pixels; the paper's identity matrix is 1.
        pixel_sigma: f64,
    },
    /// The EWA filter where it is needed: footprints narrower than this are convolved with what they lack to it, as
    /// swan1997 widens footprints beyond the distance k; wider ones stay as sharp as they are.
    Matched {
        /// Smallest standard deviation of a footprint, pixels.
        pixel_sigma: f64,
    },
}

/// Where the gradient that lights a sheet comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gradient {
    /// The derivative of the footprints, splatted along with them: exact.
    #[default]
    Analytic,
    /// Central differences between the pixels of neighbouring sheets: five times less to splat.
    Differences,
}

impl Filter {
    /// Standard deviation in pixels, 0 for none.
    pub fn pixel_sigma(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Ewa { pixel_sigma } | Self::Matched { pixel_sigma } => pixel_sigma,
        }
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::Ewa { pixel_sigma: 0.55 }
    }
}

/// Reconstruction kernel, in voxel space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// `exp(-r^2 / 2 sigma^2)`, cut at `radius` along each axis, normalised to unit lattice sum.
    Gaussian {
        /// Standard deviation, voxels.
        sigma: f64,
        /// Cut-off, voxels.
        radius: f64,
    },
}

impl Default for Kernel {
    fn default() -> Self {
        Self::Gaussian {
            sigma: 0.74,
            radius: 3.0,
        }
    }
}

/// Everything about a frame that is neither scene nor camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RenderSettings {
    /// Picture size, pixels.
    pub size: ImageSize,
    /// How sheets become a picture.
    pub compositing: Compositing,
    /// Splat colours or splat data.
    pub classification: Classification,
    /// Sheet thickness, mean voxel spacings.
    pub sheet_thickness: f64,
    /// Screen-space low-pass.
    pub filter: Filter,
    /// Where the gradient that lights a sheet comes from (post-classification).
    #[serde(default)]
    pub gradient: Gradient,
    /// Reconstruction kernel.
    pub kernel: Kernel,
    /// Whether kernel weights are solved so that the reconstruction interpolates the samples
    /// (post-classification and MIP only; classified values are never prefiltered).
    pub prefilter: bool,
    /// Phong lighting; `None` shows the transfer function's colours as they are.
    pub lighting: Option<Lighting>,
    /// A pixel is finished when its transmittance falls below this; the error it leaves is at most this.
    pub termination: f64,
}

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
            filter: Filter::default(),
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
