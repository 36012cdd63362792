//! Compositing of 3-D Gaussians.

use serde::{Deserialize, Serialize};

/// Compositing of 3-D Gaussians.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GaussianMode {
    /// As in the published renderer if image sheets are asked for and the scene consists of Gaussians, alone or with
    /// points; on sheets if it contains anything else.
    #[default]
    Auto,
    /// As in the published renderer: one by one in the order of their centres, in display colours, with its constants.
    /// Interpenetrating Gaussians pop. Points and samples of meshes are splatted among them; volumes are refused.
    #[serde(rename = "3dgs")]
    Published,
    /// In sheets, with everything else: `1 - exp(-tau)`, linear light, no popping.
    Volumetric,
}
