//! Flags about footprints: how they are shaped, drawn and hidden.

use clap::Args;
use splatvol_document::keys::names::{
    AbsorptionName, AlignmentName, KernelEdgeName, OcclusionName, ReconstructionName, SheetName,
    SheetPrecisionName, SheetValuesName, StretchName,
};

use super::help::PAPERS;

/// Differences between the papers' methods.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub(crate) struct FootprintArgs {
    /// Contribution of a kernel to a sheet [default: sample, or section where the method needs it]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) sheet: Option<SheetName>,
    /// The value of a pixel on a sheet of sections [default: mean, or sum with --extract-*]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) sheet_values: Option<SheetValuesName>,
    /// Number format of a sheet's pixels [default: f32]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) sheet_precision: Option<SheetPrecisionName>,
    /// How light is lost on its way through a length x of material [default: exp]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) absorption: Option<AbsorptionName>,
    /// Along which lines a kernel is integrated to its footprint [default: sheet]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) alignment: Option<AlignmentName>,
    /// Largest error of a footprint with --alignment auto, share of its peak [default: 0.00390625]
    #[arg(long, value_name = "SHARE", help_heading = PAPERS)]
    pub(crate) alignment_budget: Option<f64>,
    /// Where --alignment switch switches, voxel spacings behind that from which voxels are less than a pixel apart [default: 70]
    #[arg(long, value_name = "SPACINGS", help_heading = PAPERS)]
    pub(crate) alignment_switch: Option<f64>,
    /// How --filter swan stretches kernels [default: box]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) stretch: Option<StretchName>,
    /// The edge of the Gaussian kernel's footprint, where it is cut [default: smooth]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) kernel_edge: Option<KernelEdgeName>,
    /// How hidden voxels are found and left out [default: auto]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) occlusion: Option<OcclusionName>,
    /// Meaning of the kernels [default: volume]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) reconstruction: Option<ReconstructionName>,
    /// How much thinner kernels get along the gradient [default: 10]
    ///
    /// With --reconstruction surface or mixed.
    #[arg(long, value_name = "FACTOR", help_heading = PAPERS)]
    pub(crate) flatness: Option<f64>,
    /// Least gradient of a surface, value ranges per voxel [default: 0.05]
    ///
    /// With --reconstruction mixed: voxels of a smaller gradient are volume.
    #[arg(long, value_name = "GRADIENT", help_heading = PAPERS)]
    pub(crate) surface_gradient: Option<f64>,
}
