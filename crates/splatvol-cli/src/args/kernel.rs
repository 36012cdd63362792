//! Flags about the reconstruction kernel.

use clap::Args;
use splatvol::RenderSettings;
use splatvol_document::keys::names::KernelName;

use super::help::KERNEL;
use super::method::with_default;

/// The reconstruction kernel and its shape.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub(crate) struct KernelArgs {
    /// Reconstruction kernel [default: gaussian]
    #[arg(long, value_name = "NAME", help_heading = KERNEL)]
    pub(crate) kernel: Option<KernelName>,
    /// Standard deviation of the gaussian kernel, voxels
    #[arg(long, value_name = "VOXELS", help_heading = KERNEL, help = with_default("Standard deviation of the gaussian kernel, voxels", |s| gaussian(s).0))]
    pub(crate) kernel_sigma: Option<f64>,
    /// Cut-off of the gaussian or kaiser-bessel kernel, voxels
    #[arg(long, value_name = "VOXELS", help_heading = KERNEL, help = with_default("Cut-off of the gaussian or kaiser-bessel kernel, voxels", |s| gaussian(s).1))]
    pub(crate) kernel_radius: Option<f64>,
    /// Shape of the kaiser-bessel kernel, broad at 0 [default: the most even, 10.4443 for radius 2]
    #[arg(long, value_name = "NUMBER", help_heading = KERNEL)]
    pub(crate) kernel_alpha: Option<f64>,
}

/// Sigma and radius of the default kernel.
fn gaussian(settings: &RenderSettings) -> (f64, f64) {
    settings.method.kernel().gaussian().unwrap_or_default()
}
