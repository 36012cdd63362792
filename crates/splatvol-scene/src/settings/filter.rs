//! The low-pass filter in screen space.

use serde::{Deserialize, Serialize};

/// Low-pass of a footprint by default, standard deviations in pixels: energy is kept (docs/numerics.md), and
/// renderers of 3-D Gaussians have the same, 0.3 pixels squared.
pub(super) const PIXEL_SIGMA: f64 = 0.55;

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
    /// The EWA filter where it is needed: footprints narrower than this are convolved with the missing variance, as
    /// swan1997 widens footprints beyond the distance k; wider ones stay as sharp as they are.
    Matched {
        /// Smallest standard deviation of a footprint, pixels.
        pixel_sigma: f64,
    },
    /// Footprints of voxels that lie less than a pixel apart are scaled up as a whole, as if these were a pixel
    /// apart; their optical depth falls as their area grows (swan1997 section 4.3, eq. 4 and 8).
    Swan,
    /// As [`Filter::Swan`], but opacity falls instead, as the paper's text has it: opaque data turn translucent.
    SwanAlpha,
}

/// The low-pass filters available where samples are summed on sheets; swan's filter needs whole footprints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PixelFilter {
    /// Same as [`Filter::None`].
    None,
    /// Same as [`Filter::Ewa`].
    Ewa {
        /// Standard deviation of the Gaussian, pixels.
        pixel_sigma: f64,
    },
    /// Same as [`Filter::Matched`].
    Matched {
        /// Smallest standard deviation of a footprint, pixels.
        pixel_sigma: f64,
    },
}

impl From<PixelFilter> for Filter {
    fn from(filter: PixelFilter) -> Self {
        match filter {
            PixelFilter::None => Self::None,
            PixelFilter::Ewa { pixel_sigma } => Self::Ewa { pixel_sigma },
            PixelFilter::Matched { pixel_sigma } => Self::Matched { pixel_sigma },
        }
    }
}

impl Filter {
    /// The equivalent filter for sheets; `None` for swan's.
    pub fn of_sheets(self) -> Option<PixelFilter> {
        match self {
            Self::None => Some(PixelFilter::None),
            Self::Ewa { pixel_sigma } => Some(PixelFilter::Ewa { pixel_sigma }),
            Self::Matched { pixel_sigma } => Some(PixelFilter::Matched { pixel_sigma }),
            Self::Swan | Self::SwanAlpha => None,
        }
    }

    /// Standard deviation in pixels, 0 for none.
    pub fn pixel_sigma(self) -> f64 {
        match self {
            Self::None | Self::Swan | Self::SwanAlpha => 0.0,
            Self::Ewa { pixel_sigma } | Self::Matched { pixel_sigma } => pixel_sigma,
        }
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::Ewa {
            pixel_sigma: PIXEL_SIGMA,
        }
    }
}
