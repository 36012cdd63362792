//! The methods of the papers: whole footprints, or sections of them, drawn and composited one by one.

use super::{
    Absorption, Alignment, Classification, Compositing, Extraction, Filter, Kernel, KernelEdge, Occlusion,
    Rasterizer, Reconstruction, SheetPrecision, SheetValues, Stretch, TableLayout,
};
use crate::SceneError;

/// Shape, rasterisation, occlusion culling and compositing of footprints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplatSettings {
    /// Compositing order, and whether colours or data are splatted.
    pub compositing: SplatCompositing,
    /// Thickness of image sheets, and twice the distance at which whole footprints begin, mean voxel spacings.
    pub sheet_thickness: f64,
    /// The values of sheets of data.
    pub sheet_values: SheetValues,
    /// Number format of sheets.
    pub sheet_precision: SheetPrecision,
    /// Absorption of light along the way through material.
    pub absorption: Absorption,
    /// Screen-space low-pass.
    pub filter: Filter,
    /// Choice of the integrals of a kernel that make up its footprint.
    pub alignment: Alignment,
    /// Stretching of kernels by the swan filter.
    pub stretch: Stretch,
    /// Rasterisation of footprints.
    pub rasterizer: Rasterizer,
    /// The table that rasterisers look footprints up in; [`Rasterizer::Auto`] needs none.
    pub table: TableLayout,
    /// Culling of hidden footprints.
    pub occlusion: Occlusion,
    /// Voxels that have splats; `None` for all that the transfer function shows.
    pub extraction: Option<Extraction>,
    /// Whether the kernels reconstruct a volume or surfaces.
    pub reconstruction: Reconstruction,
    /// Reconstruction kernel.
    pub kernel: Kernel,
    /// The edge of a Gaussian kernel.
    pub kernel_edge: KernelEdge,
}

/// In which order footprints are composited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SplatCompositing {
    /// Whole ones, front to back (Westover 1989; zwicker2001 eq. 4).
    FrontToBack,
    /// Whole ones, back to front: the same picture, and nothing can be left out for being hidden.
    BackToFront,
    /// Whole ones, added up on the slices of the grid that are most nearly parallel to the picture (Westover 1990,
    /// zwicker2001 section 6).
    AxisSheets,
    /// Sections of them, added up on sheets parallel to the picture (huang2000 section 2).
    ImageSheets(Classification),
    /// Whole ones, in no order: their optical depth is added up.
    Xray,
}

impl SplatCompositing {
    /// Whether colours or data are splatted.
    pub fn classification(self) -> Classification {
        match self {
            Self::ImageSheets(classification) => classification,
            _ => Classification::Pre,
        }
    }
}

impl From<SplatCompositing> for Compositing {
    fn from(compositing: SplatCompositing) -> Self {
        match compositing {
            SplatCompositing::FrontToBack => Self::PerSplat,
            SplatCompositing::BackToFront => Self::PerSplatBackToFront,
            SplatCompositing::AxisSheets => Self::AxisSheets,
            SplatCompositing::ImageSheets(_) => Self::ImageSheets,
            SplatCompositing::Xray => Self::Xray,
        }
    }
}

impl Default for SplatSettings {
    /// Whole footprints of the kernel of [`super::RenderSettings::best`], front to back.
    fn default() -> Self {
        Self {
            compositing: SplatCompositing::FrontToBack,
            sheet_thickness: 0.5,
            sheet_values: SheetValues::default(),
            sheet_precision: SheetPrecision::default(),
            absorption: Absorption::default(),
            filter: Filter::default(),
            alignment: Alignment::default(),
            stretch: Stretch::default(),
            rasterizer: Rasterizer::default(),
            table: TableLayout::default(),
            occlusion: Occlusion::default(),
            extraction: None,
            reconstruction: Reconstruction::default(),
            kernel: Kernel::default(),
            kernel_edge: KernelEdge::default(),
        }
    }
}

impl SplatSettings {
    /// Whether whole footprints are composited one by one.
    fn is_per_splat(&self) -> bool {
        matches!(
            self.compositing,
            SplatCompositing::FrontToBack | SplatCompositing::BackToFront
        )
    }

    /// These settings for a volume that is, or is not, a label map: labels are classified before they are splatted.
    #[must_use]
    pub fn of_labels(self, labels: bool) -> Self {
        Self {
            compositing: match self.compositing {
                SplatCompositing::ImageSheets(_) if labels => {
                    SplatCompositing::ImageSheets(Classification::Pre)
                }
                compositing => compositing,
            },
            ..self
        }
    }

    /// Refuses parts that make no sense together.
    pub(super) fn combinations(&self) -> Result<(), SceneError> {
        let refuse =
            |field, value: &dyn std::fmt::Debug, reason| Err(SceneError::invalid(field, value, reason));
        if self.filter == Filter::SwanAlpha && !self.is_per_splat() {
            return refuse(
                "filter",
                &self.filter,
                "swan: swan-alpha lowers the opacity of single splats, which only per-splat compositing has",
            );
        }
        let has_no_front = matches!(
            self.compositing,
            SplatCompositing::BackToFront | SplatCompositing::Xray
        );
        if self.occlusion.is_of_whole_picture() && has_no_front {
            return refuse(
                "occlusion",
                &self.occlusion,
                "none: only what is composited front to back can be hidden by what is there",
            );
        }
        let data = self.compositing.classification() == Classification::Post;
        if data && self.reconstruction != Reconstruction::Volume {
            return refuse(
                "reconstruction",
                &self.reconstruction,
                "volume: flattened kernels of data do not add up to one; classify before splatting (pre)",
            );
        }
        self.stretching()?;
        self.edge()?;
        self.zeros()?;
        self.precision()?;
        self.rasterizer_suits_kernels()
    }

    /// Refuses a stretch that nothing would apply.
    fn stretching(&self) -> Result<(), SceneError> {
        if self.stretch == Stretch::Box {
            return Ok(());
        }
        let reason = if !matches!(self.filter, Filter::Swan | Filter::SwanAlpha) {
            ONLY_SWAN
        } else if self.alignment != Alignment::Exact {
            "box: a trapezoid has another footprint at every depth, which only exact alignment integrates"
        } else {
            return Ok(());
        };
        Err(SceneError::invalid("stretch", self.stretch, reason))
    }

    /// Refuses means of values where voxels without splats should be zeros.
    fn zeros(&self) -> Result<(), SceneError> {
        let data = self.compositing.classification() == Classification::Post;
        if !data || self.extraction.is_none() || self.sheet_values == SheetValues::Sum {
            return Ok(());
        }
        let reason =
            "sum: voxels that are not extracted would take the mean of those that are, not the least value";
        Err(SceneError::invalid("sheet values", self.sheet_values, reason))
    }

    /// Refuses levels of numbers that have no bounds, and of sheets that are not there.
    fn precision(&self) -> Result<(), SceneError> {
        if self.sheet_precision == SheetPrecision::F32 {
            return Ok(());
        }
        let reason = match self.compositing {
            SplatCompositing::ImageSheets(Classification::Post) => return Ok(()),
            SplatCompositing::ImageSheets(_) | SplatCompositing::AxisSheets => {
                if self.absorption == Absorption::Linear {
                    return Ok(());
                }
                "f32: optical depths have no highest level; opacities do (absorption linear)"
            }
            _ => "f32: the others are of sheets",
        };
        Err(SceneError::invalid(
            "sheet precision",
            self.sheet_precision,
            reason,
        ))
    }

    /// Refuses an edge that the footprints would not have.
    fn edge(&self) -> Result<(), SceneError> {
        if self.kernel_edge == KernelEdge::Smooth {
            return Ok(());
        }
        let reason = if self.kernel.gaussian().is_none() {
            "smooth: only Gaussians are cut"
        } else if self.rasterizer != Rasterizer::Auto {
            "smooth: tables hold the line integrals of a kernel that is cut in space; evaluate footprints (auto)"
        } else {
            return Ok(());
        };
        Err(SceneError::invalid("kernel edge", self.kernel_edge, reason))
    }

    /// Refuses rasterisers of circles if footprints are not circles, whatever the camera.
    fn rasterizer_suits_kernels(&self) -> Result<(), SceneError> {
        let flattened = self.reconstruction != Reconstruction::Volume;
        if flattened && self.rasterizer.draws_circles() {
            return Err(SceneError::invalid(
                "rasterizer",
                self.rasterizer.name(),
                "ellipse-1d, linear-1d or auto: flattened kernels leave ellipses of every direction",
            ));
        }
        Ok(())
    }
}

/// Why kernels are not stretched.
pub(super) const ONLY_SWAN: &str = "box: only the swan filter stretches kernels";
