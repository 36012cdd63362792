//! Flags about footprints: how they are shaped, drawn and hidden.

use clap::{Args, ValueEnum};

const FOOTPRINTS: &str = "Footprints";

/// What the papers' methods differ in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub(crate) struct FootprintArgs {
    /// What footprints leave on sheets of data [default: sample; section where the method needs it]
    #[arg(long, help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) sheet: Option<SheetName>,
    /// How light is lost in material [default: exp]
    #[arg(long, help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) absorption: Option<AbsorptionName>,
    /// Which integrals of a kernel make up its footprint [default: sheet]
    #[arg(long, help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) alignment: Option<AlignmentName>,
    /// Largest error of a footprint, share of its peak, with --alignment auto [default: 0.00390625]
    #[arg(long, value_name = "SHARE", help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) alignment_budget: Option<f64>,
    /// How --filter swan stretches kernels [default: box]
    #[arg(long, help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) stretch: Option<StretchName>,
    /// How what is hidden is left out [default: auto]
    #[arg(long, help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) occlusion: Option<OcclusionName>,
    /// What the kernels stand for [default: volume]
    #[arg(long, help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) reconstruction: Option<ReconstructionName>,
    /// What kernels are divided by along the gradient, with --reconstruction surface or mixed [default: 10]
    #[arg(long, value_name = "FACTOR", help_heading = FOOTPRINTS, hide_short_help = true)]
    pub(crate) flatness: Option<f64>,
    /// Gradient from which on a voxel is part of a surface, value ranges per voxel, with --reconstruction mixed [default: 0.05]
    #[arg(long, value_name = "GRADIENT", help_heading = FOOTPRINTS, hide_short_help = true)]
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
    /// On sheets of constant depth; whole footprints affine
    Sheet,
    /// Along rays parallel to the one through the centre
    Affine,
    /// Along each pixel's own ray
    Exact,
    /// Along the viewing axis
    Grid,
    /// Discs across the ray through the centre, in perspective
    Ray,
    /// Along each pixel's own ray, stretched across the one through the centre
    RayIdeal,
    /// Affine where that is within --alignment-budget, exact elsewhere
    Auto,
}

/// How the swan filter stretches kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StretchName {
    /// As a whole, by what the centre needs
    Box,
    /// By what each depth needs; with --alignment exact
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
    /// By counts of unfinished pixels
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
