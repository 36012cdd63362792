//! What sheets hold, and how they become a picture.

use serde::{Deserialize, Serialize};

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
