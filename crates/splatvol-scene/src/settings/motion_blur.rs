//! Motion blur.

use serde::{Deserialize, Serialize};

/// Blur of motion ([`crate::Motion`]) while the shutter is open.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionBlur {
    /// Not at all: the picture is that of the shutter's middle.
    #[default]
    None,
    /// Footprints are cut in half, drawn apart along their motion, and dimmed by the silhouette's growth
    /// (mueller1998 section 5, figure 11 and eq. 11): too bright, and more so the longer they are.
    Capsule,
    /// Footprints are integrated along their motion in closed form. Occlusion is that of the shutter's middle, so
    /// this is right for translucent material.
    Exact,
    /// The mean of pictures taken while the shutter is open: occlusion is right, too, at the cost of all pictures.
    Subframes {
        /// Number of pictures.
        count: u32,
    },
}

impl MotionBlur {
    /// Whether footprints themselves are blurred.
    pub fn moves_footprints(self) -> bool {
        matches!(self, Self::Capsule | Self::Exact)
    }
}
