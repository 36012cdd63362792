//! Flags about the method: compositing, filtering, lighting.

use clap::Args;
use splatvol::{Lighting, RenderSettings};
use splatvol_document::keys::names::{
    ClassificationName, CompositingName, CoverageName, FilterName, GradientName, PresetName,
};

use super::help::{LIGHT, METHOD, QUALITY};
use super::values::{self, Triple};
use super::{FastSplatsArgs, FootprintArgs, KernelArgs};

/// How the picture is made.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct MethodArgs {
    /// Quality or speed [default: balanced]
    ///
    /// Sets sheets, filter and kernel, for quality, for speed or as a paper has them; their own flags go over it.
    #[arg(long, value_name = "NAME", help_heading = METHOD)]
    pub(crate) preset: Option<PresetName>,
    /// Kind of picture [default: image-sheets]
    ///
    /// How what lies behind each other in the volume becomes one colour of a pixel.
    #[arg(long, value_name = "NAME", help_heading = METHOD)]
    pub(crate) compositing: Option<CompositingName>,
    /// Whether colours are splatted, or data that get colours on each sheet [default: post; pre for labels]
    #[arg(long, value_name = "NAME", help_heading = METHOD)]
    pub(crate) classification: Option<ClassificationName>,
    /// Thickness of a sheet, voxels
    #[arg(long, value_name = "VOXELS", help_heading = QUALITY, help = with_default("Thickness of a sheet, voxels", |s| s.method.sheet_thickness()))]
    pub(crate) sheet_thickness: Option<f64>,
    /// Octaves by which the volume is coarser than the picture asks [default: 0; 1 for the preset draft]
    ///
    /// 1 takes the volume at half of the resolution, an eighth of its voxels.
    #[arg(long, value_name = "OCTAVES", value_parser = values::finite, help_heading = QUALITY)]
    pub(crate) level_bias: Option<f64>,
    /// Gradients by which sheets are lit [default: differences]
    #[arg(long, value_name = "NAME", help_heading = LIGHT)]
    pub(crate) gradient: Option<GradientName>,
    /// Low-pass filter against aliasing in the picture [default: matched]
    #[arg(long, value_name = "NAME", help_heading = QUALITY)]
    pub(crate) filter: Option<FilterName>,
    /// Standard deviation of the EWA filter, pixels
    #[arg(long, value_name = "PIXELS", help_heading = QUALITY, help = with_default("Standard deviation of the EWA filter, pixels", |s| s.method.filter().pixel_sigma()))]
    pub(crate) pixel_sigma: Option<f64>,
    /// Anti-aliasing of edges, which no filter of footprints smooths [default: off]
    #[arg(long, value_name = "NAME", help_heading = QUALITY)]
    pub(crate) coverage: Option<CoverageName>,
    /// Samples per pixel and axis with --coverage adaptive, 2 to 8 [default: 4]
    #[arg(long, value_name = "COUNT", help_heading = QUALITY)]
    pub(crate) coverage_samples: Option<u32>,
    /// Difference of neighbouring pixels above which they get several samples [default: 2/255]
    ///
    /// With --coverage adaptive, share of white.
    #[arg(long, value_name = "SHARE", help_heading = QUALITY)]
    pub(crate) coverage_contrast: Option<f64>,
    #[command(flatten)]
    pub(crate) kernel: KernelArgs,
    /// Let the kernel smooth the data instead of interpolating them
    #[arg(long, help_heading = QUALITY)]
    pub(crate) no_prefilter: bool,
    /// Interpolate the data (undoes --no-prefilter of a picture given with --like)
    #[arg(long, help_heading = QUALITY, conflicts_with = "no_prefilter")]
    pub(crate) prefilter: bool,
    /// Transmittance below which a pixel is finished
    #[arg(long, value_name = "SHARE", help_heading = QUALITY, help = with_default("Transmittance below which a pixel is finished", |s| s.termination))]
    pub(crate) termination: Option<f64>,
    #[command(flatten)]
    pub(crate) footprint: FootprintArgs,
    #[command(flatten)]
    pub(crate) fastsplats: FastSplatsArgs,
    /// No light: show the transfer function's colours as they are
    #[arg(long, help_heading = LIGHT)]
    pub(crate) no_shade: bool,
    /// Light the volume (undoes --no-shade of a picture given with --like)
    #[arg(long, help_heading = LIGHT, conflicts_with = "no_shade")]
    pub(crate) shade: bool,
    /// Share of the colour that needs no light
    #[arg(long, value_name = "SHARE", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Share of the colour that needs no light", |s| light(s).ambient))]
    pub(crate) ambient: Option<f64>,
    /// Share of the colour under full light
    #[arg(long, value_name = "SHARE", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Share of the colour under full light", |s| light(s).diffuse))]
    pub(crate) diffuse: Option<f64>,
    /// Strength of the white highlight
    #[arg(long, value_name = "SHARE", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Strength of the white highlight", |s| light(s).specular))]
    pub(crate) specular: Option<f64>,
    /// Exponent of the highlight
    #[arg(long, value_name = "POWER", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Exponent of the highlight", |s| light(s).specular_power))]
    pub(crate) specular_power: Option<f64>,
    /// Gradient at which light from a direction has half its effect
    #[arg(long, value_name = "GRADIENT", help_heading = LIGHT, conflicts_with = "no_shade", help = with_default("Gradient, value ranges per voxel, at which light from a direction has half its effect; flatter regions are lit evenly", |s| light(s).gradient_floor))]
    pub(crate) gradient_floor: Option<f64>,
    /// Direction to the light, as the camera sees it: x right, y down, z forward [default: 0,0,-1]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = LIGHT,
          allow_hyphen_values = true, conflicts_with = "no_shade")]
    pub(crate) light: Option<Triple>,
}

/// A help text that names the settings' own default.
pub(super) fn with_default(text: &str, pick: fn(&RenderSettings) -> f64) -> String {
    let value = pick(&RenderSettings::default());
    format!("{text} [default: {value}]")
}

fn light(settings: &RenderSettings) -> Lighting {
    settings.lighting.unwrap_or_default()
}
