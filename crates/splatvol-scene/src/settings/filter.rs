//! The low-pass filter in screen space.

use serde::{Deserialize, Serialize};

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
    /// Footprints of voxels that lie less than a pixel apart are scaled up, as a whole, until they do not; their optical
    /// depth falls as their area grows (swan1997 section 4.3, eq. 4 and 8).
    Swan,
    /// The same, but their opacity falls instead, as the paper's text has it: opaque data turn translucent.
    SwanAlpha,
}

impl Filter {
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
        Self::Ewa { pixel_sigma: 0.55 }
    }
}
