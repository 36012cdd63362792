//! Settings as flat keys for files and flags, whatever the method.
//!
//! Not every flat record describes a picture: a setting of one method may not exist in the other. The conversion to
//! [`RenderSettings`] chooses the method by the settings requested, and refuses by key those that it does not have. The
//! conversion back always leads to the same settings.

use serde::{Deserialize, Serialize};

use super::splats::ONLY_SWAN;
use super::validate::DATA_IN_MOTION;
use super::{
    Absorption, Alignment, Classification, Compositing, Coverage, Extraction, Filter, GaussianMode, Gradient,
    Kernel, KernelEdge, Method, MotionBlur, Occlusion, Rasterizer, Reconstruction, RenderSettings,
    SheetContent, SheetKernel, SheetPrecision, SheetSettings, SheetValues, Shows, SplatCompositing,
    SplatSettings, Stretch, TableLayout,
};
use crate::{ImageSize, Lighting, SceneError};

/// All settings of a frame besides scene and camera, as flat keys.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct FlatSettings {
    /// Picture size, pixels.
    pub size: ImageSize,
    /// Compositing of sheets or splats into a picture.
    pub compositing: Compositing,
    /// Splat colours or splat data.
    pub classification: Classification,
    /// Sheet thickness, mean voxel spacings.
    pub sheet_thickness: f64,
    /// Contribution of a footprint to a sheet: sections require that footprints are drawn one by one; `None` chooses
    /// the one that suits the other settings.
    pub sheet: Option<SheetContent>,
    /// The value of a pixel on a sheet of sections.
    pub sheet_values: SheetValues,
    /// Number format of a sheet's pixels.
    pub sheet_precision: SheetPrecision,
    /// Absorption of light along the way through material.
    pub absorption: Absorption,
    /// Screen-space low-pass.
    pub filter: Filter,
    /// Anti-aliasing of edges.
    pub coverage: Coverage,
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
    /// Compositing of 3-D Gaussians.
    pub gaussians: GaussianMode,
    /// Motion blur.
    pub motion_blur: MotionBlur,
    /// Source of the gradient that lights a sheet.
    pub gradient: Gradient,
    /// Octaves by which the level of detail is coarser than the picture asks; footprints have no levels and leave it out.
    pub level_bias: f64,
    /// Reconstruction kernel.
    pub kernel: Kernel,
    /// The edge of a Gaussian kernel's footprints.
    pub kernel_edge: KernelEdge,
    /// Whether the reconstruction interpolates the samples, where data are splatted.
    pub prefilter: bool,
    /// Phong lighting; `None` shows the transfer function's colours as they are.
    pub lighting: Option<Lighting>,
    /// Transmittance below which a pixel is finished.
    pub termination: f64,
}

const NO_PREFILTER: &str = "gaussian where data are interpolated; others with prefilter off";
const NO_MAXIMA: &str = "gaussian: maxima are of values on planes, which other kernels do not have";
const NO_SAMPLES: &str = "gaussian where sheets hold samples (post); others are splatted as colours (pre) or as \
                          sections of sheets";

impl Default for FlatSettings {
    /// The settings of [`RenderSettings::default`].
    fn default() -> Self {
        RenderSettings::default().into()
    }
}

impl From<RenderSettings> for FlatSettings {
    fn from(settings: RenderSettings) -> Self {
        let splats = settings.method.splats().copied();
        let parts = splats.unwrap_or_default();
        let sheets = settings.method.sheets();
        let flat = Self {
            size: settings.size,
            compositing: settings.method.compositing(),
            classification: match settings.method {
                Method::Sheets(SheetSettings {
                    shows: Shows::Material(classification),
                    ..
                }) => classification,
                Method::Sheets(_) => Classification::default(),
                Method::Splats(splats) => splats.compositing.classification(),
            },
            sheet_thickness: settings.method.sheet_thickness(),
            sheet: None,
            sheet_values: parts.sheet_values,
            sheet_precision: parts.sheet_precision,
            absorption: parts.absorption,
            filter: settings.method.filter(),
            coverage: settings.coverage,
            alignment: parts.alignment,
            stretch: parts.stretch,
            rasterizer: parts.rasterizer,
            table: parts.table,
            occlusion: parts.occlusion,
            extraction: parts.extraction,
            reconstruction: parts.reconstruction,
            gaussians: settings.gaussians,
            motion_blur: settings.motion_blur,
            gradient: sheets.map_or(Gradient::Differences, |sheets| sheets.gradient),
            level_bias: sheets.map_or(0.0, |sheets| sheets.level_bias),
            kernel: settings.method.kernel(),
            kernel_edge: parts.kernel_edge,
            prefilter: settings.method.prefilter(),
            lighting: settings.lighting,
            termination: settings.termination,
        };
        // Sections of footprints are asked for by name, unless motion alone asks for footprints: without it there
        // are sheets.
        let sections = match parts.compositing {
            SplatCompositing::ImageSheets(Classification::Post) => true,
            SplatCompositing::ImageSheets(Classification::Pre) => !flat.moves_sheets(),
            SplatCompositing::Xray => !flat.wants_splats(),
            _ => false,
        };
        Self {
            sheet: (splats.is_some() && sections).then_some(SheetContent::Section),
            ..flat
        }
    }
}

impl TryFrom<FlatSettings> for RenderSettings {
    type Error = SceneError;

    /// Chooses the method.
    ///
    /// # Errors
    /// A setting that the chosen method does not have, by key. Value ranges are checked by
    /// [`RenderSettings::validate`].
    fn try_from(flat: FlatSettings) -> Result<Self, SceneError> {
        let method = if flat.wants_splats() {
            Method::Splats(flat.splats()?)
        } else {
            Method::Sheets(flat.sheets()?)
        };
        Ok(Self {
            size: flat.size,
            method,
            coverage: flat.coverage,
            gaussians: flat.gaussians,
            motion_blur: flat.motion_blur,
            lighting: flat.lighting,
            termination: flat.termination,
        })
    }
}

impl FlatSettings {
    /// Whether any setting requires whole footprints, drawn one by one.
    fn wants_splats(&self) -> bool {
        self.compositing.needs_colors()
            || self.uses_footprints()
            || self.reconstruction != Reconstruction::Volume
            || self.motion_blur.moves_footprints()
            || (self.sheet == Some(SheetContent::Section) && !self.compositing.shows_one_value())
    }

    /// Whether motion alone requires footprints.
    fn moves_sheets(&self) -> bool {
        let still = Self {
            motion_blur: MotionBlur::None,
            ..*self
        };
        self.motion_blur.moves_footprints() && !still.wants_splats()
    }

    /// Whether any setting requires footprints, apart from the settings that themselves decide between colours and
    /// data.
    pub fn uses_footprints(&self) -> bool {
        self.filter.of_sheets().is_none()
            || self.alignment != Alignment::Sheet
            || self.occlusion != Occlusion::Auto
            || self.absorption != Absorption::Exp
            || self.rasterizer != Rasterizer::Auto
            || self.extraction.is_some()
            || self.kernel.gaussian().is_none()
            || self.kernel_edge != KernelEdge::Smooth
            || self.sheet_values != SheetValues::Mean
            || self.sheet_precision != SheetPrecision::F32
    }

    /// The settings of sheets.
    fn sheets(&self) -> Result<SheetSettings, SceneError> {
        if self.stretch != Stretch::Box {
            return Err(SceneError::invalid("stretch", self.stretch, ONLY_SWAN));
        }
        let shows = match self.compositing {
            Compositing::Xray => Shows::Xray,
            Compositing::Mip => Shows::Mip,
            Compositing::MinimumIntensity => Shows::MinimumIntensity,
            Compositing::Mean => Shows::Mean,
            _ => Shows::Material(self.classification),
        };
        let (sigma, radius) = self
            .kernel
            .gaussian()
            .ok_or_else(|| self.refused_kernel(NO_SAMPLES))?;
        let sheets = SheetSettings {
            shows,
            thickness: self.sheet_thickness,
            kernel: SheetKernel { sigma, radius },
            filter: self.filter.of_sheets().ok_or_else(|| {
                SceneError::invalid("filter", self.filter, "ewa, matched or none on sheets")
            })?,
            gradient: self.gradient,
            level_bias: self.level_bias,
            prefilter: self.prefilter,
        };
        if self.sheet == Some(SheetContent::Sample) && sheets.splats_colors() {
            return Err(self.refused_samples());
        }
        Ok(sheets)
    }

    /// The settings of footprints.
    fn splats(&self) -> Result<SplatSettings, SceneError> {
        Ok(SplatSettings {
            compositing: self.splat_compositing()?,
            sheet_thickness: self.sheet_thickness,
            sheet_values: self.sheet_values,
            sheet_precision: self.sheet_precision,
            absorption: self.absorption,
            filter: self.filter,
            alignment: self.alignment,
            stretch: self.stretch,
            rasterizer: self.rasterizer,
            table: self.table,
            occlusion: self.occlusion,
            extraction: self.extraction,
            reconstruction: self.reconstruction,
            kernel: self.kernel,
            kernel_edge: self.kernel_edge,
        })
    }

    fn splat_compositing(&self) -> Result<SplatCompositing, SceneError> {
        if self.compositing.needs_colors() && self.classification == Classification::Post {
            return Err(SceneError::invalid(
                "classification",
                self.classification,
                "pre: whole footprints are composited as colours, so data must be classified before they are splatted",
            ));
        }
        let colors = self.classification == Classification::Pre || self.compositing == Compositing::Xray;
        if self.sheet == Some(SheetContent::Sample) && colors {
            return Err(self.refused_samples());
        }
        match self.compositing {
            Compositing::PerSplat => Ok(SplatCompositing::FrontToBack),
            Compositing::PerSplatBackToFront => Ok(SplatCompositing::BackToFront),
            Compositing::AxisSheets => Ok(SplatCompositing::AxisSheets),
            Compositing::Xray => Ok(SplatCompositing::Xray),
            Compositing::ImageSheets => {
                if self.classification == Classification::Post {
                    self.sections_of_data()?;
                }
                Ok(SplatCompositing::ImageSheets(self.classification))
            }
            Compositing::Mip | Compositing::MinimumIntensity | Compositing::Mean => Err(self.no_value()),
        }
    }

    /// Accepts data only as sections of sheets: refuses samples, flattened kernels and moving footprints.
    fn sections_of_data(&self) -> Result<(), SceneError> {
        if self.reconstruction != Reconstruction::Volume {
            return Err(SceneError::invalid(
                "reconstruction",
                self.reconstruction,
                "volume: flattened kernels of data do not add up to one; classify before splatting (pre)",
            ));
        }
        if self.motion_blur.moves_footprints() {
            return Err(SceneError::invalid(
                "motion blur",
                self.motion_blur,
                DATA_IN_MOTION,
            ));
        }
        if self.sheet == Some(SheetContent::Section) {
            return Ok(());
        }
        if self.kernel.gaussian().is_none() {
            let expected = if self.prefilter { NO_PREFILTER } else { NO_SAMPLES };
            return Err(self.refused_kernel(expected));
        }
        Err(SceneError::invalid(
            "sheet",
            self.sheet,
            "section: this filter, alignment, rasterizer, kernel, occlusion, absorption or extraction works on \
             footprints, which are classified first (pre) or splatted as sections of sheets",
        ))
    }

    /// Why footprints show no maximum, minimum or mean.
    fn no_value(&self) -> SceneError {
        if self.kernel.gaussian().is_none() {
            return self.refused_kernel(NO_MAXIMA);
        }
        if self.motion_blur.moves_footprints() {
            return SceneError::invalid(
                "motion blur",
                self.motion_blur,
                "subframes: the value that is shown of a ray is no sum of footprints that could be blurred one by one",
            );
        }
        SceneError::invalid(
            "compositing",
            self.compositing,
            "image-sheets: maxima, minima and means are of values on planes; this filter, alignment, rasterizer, \
             occlusion, absorption, reconstruction or extraction works on footprints",
        )
    }

    fn refused_samples(&self) -> SceneError {
        SceneError::invalid(
            "sheet",
            SheetContent::Sample,
            "section: classified colours are integrated over a sheet's depth, or mass would be lost",
        )
    }

    fn refused_kernel(&self, expected: &'static str) -> SceneError {
        SceneError::invalid("kernel", self.kernel.name(), expected)
    }
}

impl Serialize for RenderSettings {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        FlatSettings::from(*self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for RenderSettings {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let flat = FlatSettings::deserialize(deserializer)?;
        Self::try_from(flat).map_err(serde::de::Error::custom)
    }
}
