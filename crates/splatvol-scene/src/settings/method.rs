//! Rendering methods: samples are summed on sheets, or splatted footprint by footprint.

use super::{Classification, Compositing, Filter, Gradient, Kernel, PixelFilter, SplatSettings};

/// Rendering method. Properties common to both are queried by [`Method`]'s own methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Kernels are summed on planes parallel to the picture, and the planes are composited.
    Sheets(SheetSettings),
    /// Footprints are drawn whole, or in sections, and composited one by one: the methods of the papers.
    Splats(SplatSettings),
}

/// Summation of kernels on sheets, and the quantity that a pixel shows of them (huang2000 section 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetSettings {
    /// Quantity that a pixel shows of the sheets along its ray.
    pub shows: Shows,
    /// Thickness of a sheet, relative to the depth of a voxel as the camera sees it; sheets are thinner where voxels are long and
    /// tilted, and at wide angles.
    pub thickness: f64,
    /// Reconstruction kernel: the samples of sheets are sums of Gaussians.
    pub kernel: SheetKernel,
    /// Low-pass in screen space.
    pub filter: PixelFilter,
    /// Source of the gradient that lights a sheet.
    pub gradient: Gradient,
    /// Octaves by which the level of detail is coarser than the picture asks, 0 to 8: by 1, the volume has half of that
    /// resolution, and sheets are as thick in its own voxels. It needs [`Gradient::Differences`] where data are shown;
    /// label maps have no levels and leave it out.
    pub level_bias: f64,
    /// Whether kernel weights are solved so that the reconstruction interpolates the samples. Classified values are
    /// never prefiltered.
    pub prefilter: bool,
}

/// Quantity that a pixel shows of the sheets along its ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// Material, front to back.
    Material(Classification),
    /// Line integral of the extinction: alpha is `1 - exp(-sum)`.
    Xray,
    /// Largest reconstructed value, in its colour, with its opacity per unit distance.
    Mip,
    /// Smallest reconstructed value, likewise.
    MinimumIntensity,
    /// Mean of the reconstructed value inside the volume, likewise.
    Mean,
}

/// The Gaussian of sheets, `exp(-r^2 / 2 sigma^2)`, as [`Kernel::Gaussian`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetKernel {
    /// Standard deviation, voxels.
    pub sigma: f64,
    /// Cut-off, voxels.
    pub radius: f64,
}

impl From<SheetKernel> for Kernel {
    fn from(kernel: SheetKernel) -> Self {
        Self::Gaussian {
            sigma: kernel.sigma,
            radius: kernel.radius,
        }
    }
}

impl From<SheetSettings> for Method {
    fn from(sheets: SheetSettings) -> Self {
        Self::Sheets(sheets)
    }
}

impl From<SplatSettings> for Method {
    fn from(splats: SplatSettings) -> Self {
        Self::Splats(splats)
    }
}

impl From<Shows> for Compositing {
    fn from(shows: Shows) -> Self {
        match shows {
            Shows::Material(_) => Self::ImageSheets,
            Shows::Xray => Self::Xray,
            Shows::Mip => Self::Mip,
            Shows::MinimumIntensity => Self::MinimumIntensity,
            Shows::Mean => Self::Mean,
        }
    }
}

impl SheetSettings {
    /// Whether voxels are classified before they are splatted: colours are splatted, not data.
    pub fn splats_colors(&self) -> bool {
        matches!(self.shows, Shows::Xray | Shows::Material(Classification::Pre))
    }

    /// Whether a pixel shows one value of its ray.
    pub fn shows_one_value(&self) -> bool {
        Compositing::from(self.shows).shows_one_value()
    }

    /// These settings for a volume that is, or is not, a label map: labels are classified before they are splatted.
    #[must_use]
    pub fn of_labels(self, labels: bool) -> Self {
        Self {
            shows: match self.shows {
                Shows::Material(_) if labels => Shows::Material(Classification::Pre),
                shows => shows,
            },
            ..self
        }
    }
}

impl Method {
    /// The compositing, by the name that flags and files use.
    pub fn compositing(&self) -> Compositing {
        match self {
            Self::Sheets(sheets) => sheets.shows.into(),
            Self::Splats(splats) => splats.compositing.into(),
        }
    }

    /// Whether colours or data are splatted where material is shown.
    pub fn classification(&self) -> Classification {
        match self {
            Self::Sheets(sheets) if sheets.splats_colors() => Classification::Pre,
            Self::Sheets(_) => Classification::Post,
            Self::Splats(splats) => splats.compositing.classification(),
        }
    }

    /// Whether voxels are classified before they are splatted.
    pub fn splats_colors(&self) -> bool {
        self.classification() == Classification::Pre
    }

    /// Thickness of sheets, mean voxel spacings.
    pub fn sheet_thickness(&self) -> f64 {
        match self {
            Self::Sheets(sheets) => sheets.thickness,
            Self::Splats(splats) => splats.sheet_thickness,
        }
    }

    /// Reconstruction kernel.
    pub fn kernel(&self) -> Kernel {
        match self {
            Self::Sheets(sheets) => sheets.kernel.into(),
            Self::Splats(splats) => splats.kernel,
        }
    }

    /// Low-pass in screen space.
    pub fn filter(&self) -> Filter {
        match self {
            Self::Sheets(sheets) => sheets.filter.into(),
            Self::Splats(splats) => splats.filter,
        }
    }

    /// Whether the reconstruction interpolates the samples.
    pub fn prefilter(&self) -> bool {
        matches!(self, Self::Sheets(sheets) if sheets.prefilter)
    }

    /// The settings of sheets.
    pub fn sheets(&self) -> Option<&SheetSettings> {
        match self {
            Self::Sheets(sheets) => Some(sheets),
            Self::Splats(_) => None,
        }
    }

    /// The settings of footprints.
    pub fn splats(&self) -> Option<&SplatSettings> {
        match self {
            Self::Sheets(_) => None,
            Self::Splats(splats) => Some(splats),
        }
    }
}
