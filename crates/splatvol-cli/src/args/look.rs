//! Flags about colour and opacity.

use clap::Args;

use super::help::LOOK;
use super::values;

/// How data values look. Without any of these a transfer function is chosen from the data.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct LookArgs {
    /// Transfer function: a file of 3D Slicer (.vp.json), ParaView (.json), Inviwo (.itf) or ImageJ (.lut)
    #[arg(long, value_name = "FILE", help_heading = LOOK, conflicts_with_all = ["cmap", "opacity", "iso"])]
    pub(crate) tf: Option<std::path::PathBuf>,
    /// Colour map, by matplotlib's name: viridis, gray, coolwarm_r (reversed)...
    #[arg(long, value_name = "NAME", help_heading = LOOK, value_parser = values::color_map)]
    pub(crate) cmap: Option<String>,
    /// Opacity curve: linear, geom, sigmoid, foreground; linear_r is reversed
    ///
    /// linear, geom, foreground, sigmoid, or sigmoid_N of steepness N, 1 to 10, 15 or 20; each reversed with _r behind it.
    #[arg(long, value_name = "NAME", help_heading = LOOK, value_parser = values::opacity_curve, conflicts_with = "iso")]
    pub(crate) opacity: Option<String>,
    /// Data values at the ends of colour map and opacity curve
    #[arg(long, value_name = "LO,HI", value_parser = values::range, help_heading = LOOK,
          allow_hyphen_values = true)]
    pub(crate) clim: Option<[f64; 2]>,
    /// World length over which opacities act [default: the mean voxel spacing]
    #[arg(long, value_name = "LENGTH", help_heading = LOOK)]
    pub(crate) unit_distance: Option<f64>,
    /// Values are names of kinds, never interpolated; =false: they are not [default: decided by the data]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", help_heading = LOOK)]
    pub(crate) labels: Option<bool>,
    /// Show the surface of this data value
    #[arg(long, value_name = "VALUE", value_parser = values::finite, help_heading = LOOK, allow_negative_numbers = true)]
    pub(crate) iso: Option<f64>,
}

impl LookArgs {
    /// Whether no flag was given.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
