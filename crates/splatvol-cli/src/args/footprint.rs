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
