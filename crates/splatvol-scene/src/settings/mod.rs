//! Plain settings of a frame. The methods of the papers are values here, never separate renderers.

mod combinations;
mod compositing;
mod coverage;
mod extraction;
mod filter;
mod footprint;
mod gaussians;
mod kernel;
mod motion_blur;
mod papers;
mod presets;
mod stretch;
mod table;
mod validate;

pub use compositing::{Absorption, Classification, Compositing, Gradient, SheetContent};
pub use coverage::Coverage;
pub use extraction::Extraction;
pub use filter::Filter;
pub use footprint::{Alignment, Occlusion, Rasterizer, Reconstruction};
pub use gaussians::GaussianMode;
pub use kernel::Kernel;
pub use motion_blur::MotionBlur;
pub use stretch::Stretch;
pub use table::{FootprintTable, TablePrecision};

use serde::{Deserialize, Serialize};

use crate::{ImageSize, Lighting};

/// Everything about a frame that is neither scene nor camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RenderSettings {
    /// Picture size, pixels.
    pub size: ImageSize,
    /// How sheets become a picture.
    pub compositing: Compositing,
    /// Splat colours or splat data.
    pub classification: Classification,
    /// Sheet thickness, mean voxel spacings.
    pub sheet_thickness: f64,
    /// What footprints leave on sheets; none for what suits the classification: sections of classified colours,
    /// samples of data.
    pub sheet: Option<SheetContent>,
    /// How light is lost on the way through material.
    pub absorption: Absorption,
    /// Screen-space low-pass.
    pub filter: Filter,
    /// Anti-aliasing of edges.
    pub coverage: Coverage,
    /// Which integrals of a kernel make up its footprint.
    pub alignment: Alignment,
    /// How the swan filter stretches kernels.
    pub stretch: Stretch,
    /// How footprints become pixels.
    pub rasterizer: Rasterizer,
    /// The table that rasterisers look footprints up in; [`Rasterizer::Auto`] needs none.
    pub table: FootprintTable,
    /// How what is hidden is left out.
    pub occlusion: Occlusion,
    /// Which voxels have splats; `None` for all that the transfer function shows.
    pub extraction: Option<Extraction>,
    /// What the kernels stand for.
    pub reconstruction: Reconstruction,
    /// How 3-D Gaussians are composited.
    pub gaussians: GaussianMode,
    /// How motion is blurred.
    pub motion_blur: MotionBlur,
    /// Where the gradient that lights a sheet comes from (post-classification).
    #[serde(default)]
    pub gradient: Gradient,
    /// Reconstruction kernel.
    pub kernel: Kernel,
    /// Whether kernel weights are solved so that the reconstruction interpolates the samples
    /// (post-classification and MIP only; classified values are never prefiltered).
    pub prefilter: bool,
    /// Phong lighting; `None` shows the transfer function's colours as they are.
    pub lighting: Option<Lighting>,
    /// A pixel is finished when its transmittance falls below this; the error it leaves is at most this.
    pub termination: f64,
}
