//! Flags about the method: compositing, filtering, lighting.

use clap::{Args, ValueEnum};

use splatvol::{Lighting, RenderSettings};

use super::KernelArgs;
use super::values::{self, Triple};
use super::{FastSplatsArgs, FootprintArgs};

const METHOD: &str = "Method";
const LIGHT: &str = "Lighting";

/// How the picture is made.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct MethodArgs {
    /// Quality or speed: what sheets, filter and kernel are unless their own flags say so [default: balanced]
    #[arg(long, value_name = "NAME", help_heading = METHOD)]
    pub(crate) preset: Option<PresetName>,
    /// How sheets become a picture [default: image-sheets]
    #[arg(long, help_heading = METHOD)]
    pub(crate) compositing: Option<CompositingName>,
    /// Splat classified colours (pre), or data that each sheet classifies (post) [default: post; pre for labels]
    #[arg(long, help_heading = METHOD)]
    pub(crate) classification: Option<ClassificationName>,
    /// Thickness of a sheet, voxels
    #[arg(long, value_name = "VOXELS", help_heading = METHOD, help = with_default("Thickness of a sheet, voxels", |s| s.method.sheet_thickness()))]
    pub(crate) sheet_thickness: Option<f64>,
    /// Gradients that light the sheets [default: differences]
    #[arg(long, help_heading = METHOD)]
    pub(crate) gradient: Option<GradientName>,
    /// Low-pass filter in the picture [default: matched]
    #[arg(long, help_heading = METHOD)]
    pub(crate) filter: Option<FilterName>,
    /// Standard deviation of the EWA filter, pixels
    #[arg(long, value_name = "PIXELS", help_heading = METHOD, help = with_default("Standard deviation of the EWA filter, pixels", |s| s.method.filter().pixel_sigma()))]
    pub(crate) pixel_sigma: Option<f64>,
    /// Anti-aliasing of edges, where a low-pass of footprints is not one of the picture [default: off]
    #[arg(long, help_heading = METHOD)]
    pub(crate) coverage: Option<CoverageName>,
    /// Samples per pixel and axis of an edge, with --coverage adaptive, 2 to 8 [default: 4]
    #[arg(long, value_name = "COUNT", help_heading = METHOD, hide_short_help = true)]
    pub(crate) coverage_samples: Option<u32>,
    #[command(flatten)]
    pub(crate) kernel: KernelArgs,
    /// Let the kernel smooth the data instead of interpolating them
    #[arg(long, help_heading = METHOD)]
    pub(crate) no_prefilter: bool,
    /// Interpolate the data (undoes --no-prefilter of a picture given with --like)
    #[arg(long, hide_short_help = true, help_heading = METHOD, conflicts_with = "no_prefilter")]
    pub(crate) prefilter: bool,
    /// Transmittance at which a pixel is finished
    #[arg(long, value_name = "SHARE", help_heading = METHOD, help = with_default("Transmittance at which a pixel is finished", |s| s.termination))]
    pub(crate) termination: Option<f64>,
    #[command(flatten)]
    pub(crate) footprint: FootprintArgs,
    #[command(flatten)]
    pub(crate) fastsplats: FastSplatsArgs,
    /// Show the transfer function's colours as they are
    #[arg(long, help_heading = LIGHT)]
    pub(crate) no_shade: bool,
    /// Light the volume (undoes --no-shade of a picture given with --like)
    #[arg(long, hide_short_help = true, help_heading = LIGHT, conflicts_with = "no_shade")]
    pub(crate) shade: bool,
    /// Share of the colour that needs no light
    #[arg(long, value_name = "SHARE", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Share of the colour that needs no light", |s| light(s).ambient))]
    pub(crate) ambient: Option<f64>,
    /// Share of the colour under full light
    #[arg(long, value_name = "SHARE", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Share of the colour under full light", |s| light(s).diffuse))]
    pub(crate) diffuse: Option<f64>,
    /// White highlight
    #[arg(long, value_name = "SHARE", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("White highlight", |s| light(s).specular))]
    pub(crate) specular: Option<f64>,
    /// Exponent of the highlight
    #[arg(long, value_name = "POWER", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Exponent of the highlight", |s| light(s).specular_power))]
    pub(crate) specular_power: Option<f64>,
    /// Gradient (value ranges per voxel) that is half a surface
    #[arg(long, value_name = "GRADIENT", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Gradient (value ranges per voxel) that is half a surface; what has less is lit from all sides", |s| light(s).gradient_floor))]
    pub(crate) gradient_floor: Option<f64>,
    /// Towards the light: x right, y down, z forward [default: 0,0,-1, at the camera]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = LIGHT,
          allow_hyphen_values = true, conflicts_with = "no_shade")]
    pub(crate) light: Option<Triple>,
}

impl MethodArgs {
    /// All but how things are lit.
    pub(crate) fn without_light(&self) -> Self {
        Self {
            no_shade: false,
            shade: false,
            ambient: None,
            diffuse: None,
            specular: None,
            specular_power: None,
            gradient_floor: None,
            light: None,
            ..self.clone()
        }
    }
}

/// Whole settings by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PresetName {
    /// Nearest to the exact integral; meshes are lit by differences
    Best,
    /// In a hundredth of the time, hardly to be told apart
    Balanced,
    /// In half of that time; steep edges show where sheets lie
    Fast,
    /// Anti-aliased splats one by one, across their rays
    #[value(name = "swan1997")]
    Swan1997,
    /// The same with alignment by error budget and capsules of motion
    #[value(name = "mueller1998")]
    Mueller1998,
    /// Elliptical Gaussians on slices of the grid, low-passed by a pixel
    #[value(name = "ewa2001")]
    Ewa2001,
    /// FastSplats as published in 2000: colours, tables, a summed-area table
    #[value(name = "fastsplats2000")]
    FastSplats2000,
}

/// How sheets become a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CompositingName {
    /// Front to back, through sheets parallel to the picture
    ImageSheets,
    /// Sum of the extinction, as in a radiograph
    Xray,
    /// Largest value along the ray
    Mip,
    /// Smallest value along the ray
    Minip,
    /// Mean value along the ray
    Mean,
    /// Whole footprints one by one, front to back (Westover 1989)
    PerSplat,
    /// Whole footprints one by one, back to front
    PerSplatBackToFront,
    /// Whole footprints on slices of the grid (Westover 1990)
    AxisSheets,
}

/// What is splatted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ClassificationName {
    Pre,
    Post,
}

/// Low-pass filter in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilterName {
    /// Footprints as they are
    None,
    /// Every footprint is widened
    Ewa,
    /// Footprints narrower than the filter are widened to it
    Matched,
    /// Footprints of voxels less than a pixel apart are scaled up, and get thinner (Swan 1997)
    Swan,
    /// The same, but their opacity falls, as the paper has it
    SwanAlpha,
}

/// Anti-aliasing of edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CoverageName {
    /// One sample per pixel
    Off,
    /// Pixels that differ from their neighbours are the mean of several samples
    Adaptive,
}

/// Where the gradient that lights a sheet comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum GradientName {
    /// Derivatives of the footprints, splatted along with them
    Analytic,
    /// Differences between the pixels of neighbouring sheets
    Differences,
}

/// A help text that names the settings' own default.
pub(super) fn with_default(text: &str, pick: fn(&RenderSettings) -> f64) -> String {
    let value = pick(&RenderSettings::default());
    format!("{text} [default: {value}]")
}

fn light(settings: &RenderSettings) -> Lighting {
    settings.lighting.unwrap_or_default()
}
