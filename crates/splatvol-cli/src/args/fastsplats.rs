//! Flags about tables of footprints and about the range of interest.

use clap::Args;
use splatvol_document::keys::names::{PrecisionName, RasterizerName};

use super::help::PAPERS;
use super::values;

/// How footprints are drawn, and which voxels have any.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub(crate) struct FastSplatsArgs {
    /// How footprints are drawn (FastSplats) [default: auto]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) rasterizer: Option<RasterizerName>,
    /// Number of entries of a footprint table, 32 to 1024 [default: 128]
    #[arg(long, value_name = "COUNT", help_heading = PAPERS)]
    pub(crate) table_entries: Option<u32>,
    /// Number format of a table's entries [default: u8]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) table_precision: Option<PrecisionName>,
    /// Number of parts into which a table cuts the kernel along depth, 1 to 128 [default: 128]
    #[arg(long, value_name = "COUNT", help_heading = PAPERS)]
    pub(crate) table_sections: Option<u32>,
    /// Places per pixel and axis that centres are rounded to [default: rlut 10, blit-2d 2, hybrid 8]
    ///
    /// With --rasterizer rlut 1 to 128, with blit-2d and hybrid 1 to 8.
    #[arg(long, value_name = "COUNT", help_heading = PAPERS)]
    pub(crate) subpixels: Option<u32>,
    /// Largest radius of a footprint that --rasterizer hybrid copies, pixels [default: 4]
    #[arg(long, value_name = "PIXELS", help_heading = PAPERS)]
    pub(crate) blit_radius: Option<u32>,
    /// Splat only voxels of these values, as the transfer function counts them
    #[arg(long, value_name = "LO,HI", value_parser = values::range, help_heading = PAPERS,
          allow_hyphen_values = true)]
    pub(crate) extract_density: Option<[f64; 2]>,
    /// Splat only voxels of at least this gradient, value ranges per voxel [default: 0]
    #[arg(long, value_name = "GRADIENT", help_heading = PAPERS)]
    pub(crate) extract_gradient: Option<f64>,
}
