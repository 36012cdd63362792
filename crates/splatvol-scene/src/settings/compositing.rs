//! Contents of sheets, and their compositing into a picture.

use serde::{Deserialize, Serialize};

/// Compositing of sheets into a picture.
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
    /// Smallest reconstructed value along the ray, shown likewise.
    #[serde(rename = "minip")]
    MinimumIntensity,
    /// Mean of the reconstructed value along the ray's part inside the volume, shown likewise.
    Mean,
    /// Whole footprints one by one, front to back (Westover 1989; zwicker2001 eq. 4).
    PerSplat,
    /// Whole footprints one by one, back to front: the same picture, and nothing can be left out for being hidden.
    PerSplatBackToFront,
    /// Whole footprints added up on the slices of the grid that are most nearly parallel to the picture (Westover 1990,
    /// zwicker2001 section 6).
    AxisSheets,
}

impl Compositing {
    /// Whether a pixel shows one value, taken from its whole ray: the largest, smallest or mean one. Such pictures
    /// are unlit and splat data, whatever the classification.
    pub fn shows_one_value(self) -> bool {
        matches!(self, Self::Mip | Self::MinimumIntensity | Self::Mean)
    }

    /// Whether whole footprints of classified voxels are composited, so that the data must be classified first.
    pub fn needs_colors(self) -> bool {
        matches!(
            self,
            Self::PerSplat | Self::PerSplatBackToFront | Self::AxisSheets
        )
    }
}

/// Contribution of a footprint to a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SheetContent {
    /// The kernel integrated over the sheet's depth (huang2000 section 2): mass is exact.
    Section,
    /// The kernel's value on the sheet's plane: no blur along depth.
    Sample,
}

/// Absorption of light along the way through material.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Absorption {
    /// `exp(-tau)` (zwicker2001 eq. 1).
    #[default]
    Exp,
    /// `1 - tau`, and nothing below it, as the papers approximate it (zwicker2001 eq. 4).
    Linear,
}

/// Whether colours or data are splatted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Classification {
    /// Voxels are classified and lit, then splatted as colour (sections of the kernel integrated over the sheet).
    Pre,
    /// Data is splatted; each sheet pixel is classified and lit (samples of the kernel on the sheet's plane).
    #[default]
    Post,
}

/// Source of the gradient that lights a sheet.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gradient {
    /// The derivative of the footprints, splatted along with them: exact.
    #[default]
    Analytic,
    /// Central differences between the pixels of neighbouring sheets: five times less to splat.
    Differences,
}
