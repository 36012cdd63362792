//! Selection of the voxels of interest.

use serde::{Deserialize, Serialize};

use crate::SceneError;

/// The range of interest: voxels outside it have no splat (mueller1998 section 3.5, `t = F(gradient, density)`,
/// where F is inside or outside a box).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Extraction {
    /// Least and greatest value kept, in the volume's own units, as transfer functions have them; `None` keeps all.
    pub density: Option<[f64; 2]>,
    /// Least gradient kept, value ranges per mean voxel spacing (as for [`crate::Reconstruction::Mixed`]), by
    /// central differences.
    pub gradient: f64,
}

impl Extraction {
    pub(super) fn validate(&self) -> Result<(), SceneError> {
        if let Some(density) = self.density
            && !(density[0].is_finite() && density[1].is_finite() && density[0] <= density[1])
        {
            return Err(SceneError::invalid(
                "extraction density",
                density,
                "two finite values, the lower one first",
            ));
        }
        if !(0.0..=1e3).contains(&self.gradient) {
            return Err(SceneError::invalid(
                "extraction gradient",
                self.gradient,
                "0 to 1000 value ranges per voxel",
            ));
        }
        Ok(())
    }
}
