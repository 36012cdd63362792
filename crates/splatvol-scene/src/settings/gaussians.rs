//! How 3-D Gaussians are composited.

use serde::{Deserialize, Serialize};

/// How 3-D Gaussians are composited.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GaussianMode {
    /// As the published renderer does where a scene is Gaussians, alone or with points, and image sheets are asked for; in
    /// sheets where there is more.
    #[default]
    Auto,
    /// As the published renderer does: one by one in the order of their centres, display colours, its constants. What
    /// interpenetrates pops. Points and samples of meshes are splatted among them; volumes are refused.
    #[serde(rename = "3dgs")]
    Published,
    /// In sheets, with everything else: `1 - exp(-tau)`, linear light, no popping.
    Volumetric,
}
