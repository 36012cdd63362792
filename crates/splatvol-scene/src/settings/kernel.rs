//! The reconstruction kernel.

use serde::{Deserialize, Serialize};

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
