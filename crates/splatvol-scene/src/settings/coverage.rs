//! Coverage: pixels that material covers in part.

use serde::{Deserialize, Serialize};

use crate::SceneError;

/// Anti-aliasing of edges.
///
/// A low-pass of extinction is not one of the picture: a pixel half covered by material of optical depth 4 should
/// be `(1 - e^-4) / 2 = .49` opaque, but half the extinction makes it `1 - e^-2 = .86` opaque. So no filter of
/// footprints is right where opaque material ends within a pixel; only several samples of the picture are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coverage {
    /// One sample per pixel.
    #[default]
    Off,
    /// Pixels that differ from their neighbours are the mean of several samples.
    Adaptive {
        /// Samples per pixel and axis, 2 to 8.
        samples: u32,
        /// Difference of a linear premultiplied colour, or of alpha, among a pixel and its eight neighbours above
        /// which it is sampled, 0 to 1.
        contrast: f64,
    },
}

impl Coverage {
    /// 16 samples where a pixel differs by more than two of 255 levels.
    pub const ADAPTIVE: Self = Self::Adaptive {
        samples: 4,
        contrast: 2.0 / 255.0,
    };

    pub(super) fn validate(self) -> Result<(), SceneError> {
        let Self::Adaptive { samples, contrast } = self else {
            return Ok(());
        };
        if !(2..=8).contains(&samples) {
            return Err(SceneError::invalid(
                "coverage samples",
                samples,
                "2 to 8 per axis",
            ));
        }
        if !(0.0..=1.0).contains(&contrast) {
            return Err(SceneError::invalid("coverage contrast", contrast, "0 to 1"));
        }
        Ok(())
    }
}
