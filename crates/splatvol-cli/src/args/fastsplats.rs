//! Flags about tables of footprints and about the range of interest.

use clap::{Args, ValueEnum};

use super::values;

const FASTSPLATS: &str = "FastSplats";

/// How footprints are drawn, and which voxels have any.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub(crate) struct FastSplatsArgs {
    /// How footprints become pixels [default: auto]
    #[arg(long, help_heading = FASTSPLATS, hide_short_help = true)]
    pub(crate) rasterizer: Option<RasterizerName>,
    /// Entries of the footprint table, 32 to 1024 [default: 128]
    #[arg(long, value_name = "COUNT", help_heading = FASTSPLATS, hide_short_help = true)]
    pub(crate) table_entries: Option<u32>,
    /// What an entry of the table is [default: u8]
    #[arg(long, help_heading = FASTSPLATS, hide_short_help = true)]
    pub(crate) table_precision: Option<PrecisionName>,
    /// Parts that the table cuts a kernel into along depth, 1 to 128 [default: 128]
    #[arg(long, value_name = "COUNT", help_heading = FASTSPLATS, hide_short_help = true)]
    pub(crate) table_sections: Option<u32>,
    /// Cells per pixel and axis that centres are snapped to, with --rasterizer rlut (1 to 128) or blit-2d (1 to 8) [default: 10 for rlut, 2 for blit-2d]
    #[arg(long, value_name = "COUNT", help_heading = FASTSPLATS, hide_short_help = true)]
    pub(crate) subpixels: Option<u32>,
    /// Values that have splats, as the transfer function counts them
    #[arg(long, value_name = "LO,HI", value_parser = values::range, help_heading = FASTSPLATS, hide_short_help = true,
          allow_hyphen_values = true)]
    pub(crate) extract_density: Option<[f64; 2]>,
    /// Least gradient of voxels that have splats, value ranges per voxel [default: 0]
    #[arg(long, value_name = "GRADIENT", help_heading = FASTSPLATS, hide_short_help = true)]
    pub(crate) extract_gradient: Option<f64>,
}

/// How footprints become pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RasterizerName {
    /// The fastest for the footprint, without tables
    Auto,
    /// A square root per pixel into a table that is even in the distance
    #[value(name = "linear-1d")]
    Linear1d,
    /// Two additions per pixel into a table that is even in the squared distance; circles
    #[value(name = "square-1d")]
    Square1d,
    /// The same for ellipses
    #[value(name = "ellipse-1d")]
    Ellipse1d,
    /// Squared distances from tables, centres snapped
    Rlut,
    /// Footprints drawn beforehand, centres and radii snapped; circles
    #[value(name = "blit-2d")]
    Blit2d,
}

/// What entries of a table are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PrecisionName {
    /// 8 bits
    U8,
    /// 16 bits
    U16,
    /// Single precision
    F32,
}
