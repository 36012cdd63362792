//! Flags about footprints: how they are shaped, drawn and hidden.

use clap::{Args, ValueEnum};

use super::help::PAPERS;

/// What the papers' methods differ in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub(crate) struct FootprintArgs {
    /// What a kernel adds to a sheet [default: sample, or section where the method needs it]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) sheet: Option<SheetName>,
    /// How light is lost on its way through a length x of material [default: exp]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) absorption: Option<AbsorptionName>,
    /// Along which lines a kernel is integrated to its footprint [default: sheet]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) alignment: Option<AlignmentName>,
    /// Largest error of a footprint with --alignment auto, share of its peak [default: 0.00390625]
    #[arg(long, value_name = "SHARE", help_heading = PAPERS)]
    pub(crate) alignment_budget: Option<f64>,
    /// How --filter swan stretches kernels [default: box]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) stretch: Option<StretchName>,
    /// How hidden voxels are found and left out [default: auto]
    #[arg(long, value_name = "NAME", help_heading = PAPERS)]
    pub(crate) occlusion: Option<OcclusionName>,
    /// What the kernels stand for [default: volume]
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

/// What a footprint leaves on a sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SheetName {
    /// The kernel integrated over the sheet's depth
    Section,
    /// The kernel's value on the sheet's plane
    Sample,
}

/// Which integrals of a kernel make up its footprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AlignmentName {
    /// Sheets: at constant depth. Whole footprints: as affine
    Sheet,
    /// Along rays parallel to the one through the kernel's centre
    Affine,
    /// Along each pixel's own ray
    Exact,
    /// Along the viewing axis
    Grid,
    /// As discs across the ray through the centre, in perspective
    Ray,
    /// As exact, with kernels stretched across the ray through the centre
    RayIdeal,
    /// As affine where that is within --alignment-budget, as exact elsewhere
    Auto,
}

/// How the swan filter stretches kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StretchName {
    /// The whole kernel by what its centre needs
    Box,
    /// Each depth by what it needs; needs --alignment exact
    Trapezoid,
}

/// How light is lost in material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AbsorptionName {
    /// exp(-x)
    Exp,
    /// 1 - x, as in the papers
    Linear,
}

/// How what is hidden is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OcclusionName {
    /// By counting unfinished pixels
    Auto,
    /// Nothing is left out
    None,
    /// By a summed-area table of the picture (FastSplats)
    Sat,
}

/// What the kernels stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReconstructionName {
    /// A volume
    Volume,
    /// Surfaces: kernels are flattened along the gradient
    Surface,
    /// Surfaces inside a volume: flattened where the gradient is steep
    Mixed,
}
