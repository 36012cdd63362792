//! Plain settings of a frame. The methods of the papers are values here, never separate renderers.
//!
//! Start from a preset and change what differs, by `with_*` or by `..`: such code still compiles when a new version
//! adds fields, which this crate does not call a breaking change. Code that lists every field may break.
//!
//! ```
//! use splatvol_scene::{RenderSettings, Shows};
//!
//! let xray = RenderSettings::best().with_shows(Shows::Xray).with_lighting(None);
//! let same = RenderSettings {
//!     lighting: None,
//!     ..RenderSettings::best().with_shows(Shows::Xray)
//! };
//! assert_eq!(xray, same);
//! ```

mod compositing;
mod coverage;
mod extraction;
mod filter;
mod flat;
mod footprint;
mod gaussians;
mod kernel;
mod kernel_edge;
mod method;
mod motion_blur;
mod presets;
mod sheet_precision;
mod sheet_values;
mod splats;
mod stretch;
mod table;
mod validate;
mod with;

pub use compositing::{Absorption, Classification, Compositing, Gradient, SheetContent};
pub use coverage::Coverage;
pub use extraction::Extraction;
pub use filter::{Filter, PixelFilter};
pub use flat::FlatSettings;
pub use footprint::{Alignment, Occlusion, Rasterizer, Reconstruction};
pub use gaussians::GaussianMode;
pub use kernel::Kernel;
pub use kernel_edge::KernelEdge;
pub use method::{Method, SheetKernel, SheetSettings, Shows};
pub use motion_blur::MotionBlur;
pub use sheet_precision::SheetPrecision;
pub use sheet_values::SheetValues;
pub use splats::{SplatCompositing, SplatSettings};
pub use stretch::Stretch;
pub use table::{TableLayout, TablePrecision};

use crate::{ImageSize, Lighting};

/// All settings of a frame besides scene and camera. Engines that have only one method take its settings:
/// `RenderSettings<SheetSettings>`.
///
/// Files and flags hold them as [`FlatSettings`], a flat list of keys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings<M = Method> {
    /// Picture size, pixels.
    pub size: ImageSize,
    /// Rendering method.
    pub method: M,
    /// Anti-aliasing of edges.
    pub coverage: Coverage,
    /// Compositing of 3-D Gaussians.
    pub gaussians: GaussianMode,
    /// Motion blur; the modes that move footprints belong to [`Method::Splats`].
    pub motion_blur: MotionBlur,
    /// Phong lighting; `None` shows the transfer function's colours as they are.
    pub lighting: Option<Lighting>,
    /// A pixel is finished when its transmittance falls below this; the error it leaves is at most this.
    pub termination: f64,
}

impl<M> RenderSettings<M> {
    /// These settings with another method.
    pub fn with<N>(&self, method: N) -> RenderSettings<N> {
        RenderSettings {
            size: self.size,
            method,
            coverage: self.coverage,
            gaussians: self.gaussians,
            motion_blur: self.motion_blur,
            lighting: self.lighting,
            termination: self.termination,
        }
    }
}
