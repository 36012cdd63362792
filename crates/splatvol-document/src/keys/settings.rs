//! Keys of the method: kind of picture, quality, kernel, footprints, light.

use super::keys;
use super::names::{
    AbsorptionName, AlignmentName, ClassificationName, CompositingName, CoverageName, FilterName,
    GaussianModeName, GradientName, KernelEdgeName, KernelName, OcclusionName, PrecisionName, PresetName,
    RasterizerName, ReconstructionName, SheetName, SheetPrecisionName, SheetValuesName, StretchName,
};

keys! {
    /// How the picture is made: the table `[settings]`. A key is called as the command's flag.
    pub struct SettingKeys {
        /// Quality or speed; other keys go over it. `balanced` by default.
        preset: PresetName,
        /// Kind of picture.
        compositing: CompositingName,
        /// Whether colours are splatted, or data that get colours on each sheet.
        classification: ClassificationName,
        /// How 3-D Gaussians are composited.
        gaussians: GaussianModeName,
        /// Thickness of a sheet, mean voxel spacings.
        sheet_thickness: f64,
        /// Gradients by which sheets are lit.
        gradient: GradientName,
        /// Octaves by which the level of detail is coarser than the picture asks: 1 halves the resolution.
        level_bias: f64,
        /// Low-pass filter against aliasing in the picture.
        filter: FilterName,
        /// Standard deviation of the filters `ewa` and `matched`, pixels.
        pixel_sigma: f64,
        /// Anti-aliasing of edges.
        coverage: CoverageName,
        /// Samples per pixel and axis with `coverage = "adaptive"`, 2 to 8.
        coverage_samples: u32,
        /// Difference of neighbouring pixels above which they get several samples, share of white.
        coverage_contrast: f64,
        /// Transmittance below which a pixel is finished.
        termination: f64,
        /// Reconstruction kernel.
        kernel: KernelName,
        /// Standard deviation of the Gaussian kernel, voxels.
        kernel_sigma: f64,
        /// Cut-off of the Gaussian or Kaiser-Bessel kernel, voxels.
        kernel_radius: f64,
        /// Shape of the Kaiser-Bessel kernel, broad at 0.
        kernel_alpha: f64,
        /// The edge of the Gaussian kernel's footprint, where it is cut.
        kernel_edge: KernelEdgeName,
        /// Whether the reconstruction interpolates the samples, or smooths them.
        prefilter: bool,
        /// Contribution of a kernel to a sheet.
        sheet: SheetName,
        /// The value of a pixel on a sheet of sections.
        sheet_values: SheetValuesName,
        /// Number format of a sheet's pixels.
        sheet_precision: SheetPrecisionName,
        /// How light is lost on its way through material.
        absorption: AbsorptionName,
        /// Along which lines a kernel is integrated to its footprint.
        alignment: AlignmentName,
        /// Largest error of a footprint with `alignment = "auto"`, share of its peak.
        alignment_budget: f64,
        /// How far behind the depth where voxels are a pixel apart `alignment = "switch"` switches, mean voxel spacings.
        alignment_switch: f64,
        /// How the filter `swan` stretches kernels.
        stretch: StretchName,
        /// How hidden voxels are found and left out.
        occlusion: OcclusionName,
        /// Meaning of the kernels.
        reconstruction: ReconstructionName,
        /// How much thinner kernels get along the gradient, where they stand for surfaces.
        flatness: f64,
        /// Least gradient of a surface, value ranges per voxel.
        surface_gradient: f64,
        /// How footprints are drawn.
        rasterizer: RasterizerName,
        /// Entries of a footprint table, 32 to 1024.
        table_entries: u32,
        /// Number format of a table's entries.
        table_precision: PrecisionName,
        /// Parts into which a table cuts the kernel along depth, 1 to 128.
        table_sections: u32,
        /// Places per pixel and axis that centres are rounded to by `rlut`, `blit-2d` and `hybrid`.
        subpixels: u32,
        /// Largest radius of a footprint that `hybrid` draws as `blit-2d`, pixels, 1 to 64.
        blit_radius: u32,
        /// Least and greatest value of voxels that are splatted.
        extract_density: [f64; 2],
        /// Least gradient of voxels that are splatted, value ranges per voxel.
        extract_gradient: f64,
        /// Whether the picture is lit.
        shade: bool,
        /// Share of the colour that needs no light.
        ambient: f64,
        /// Share of the colour under full light.
        diffuse: f64,
        /// Strength of the white highlight.
        specular: f64,
        /// Exponent of the highlight.
        specular_power: f64,
        /// Gradient at which light from a direction has half its effect, value ranges per voxel.
        gradient_floor: f64,
        /// Direction to the light, as the camera sees it: x right, y down, z forward.
        light: [f64; 3],
    }
}

impl SettingKeys {
    /// The keys of the light alone.
    #[must_use]
    pub fn light_only(&self) -> Self {
        Self {
            shade: self.shade,
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            specular_power: self.specular_power,
            gradient_floor: self.gradient_floor,
            light: self.light,
            ..Self::default()
        }
    }

    /// All keys but those of the light.
    #[must_use]
    pub fn without_light(&self) -> Self {
        Self {
            shade: None,
            ambient: None,
            diffuse: None,
            specular: None,
            specular_power: None,
            gradient_floor: None,
            light: None,
            ..self.clone()
        }
    }

    /// Whether any key describes the light.
    pub(crate) fn describes_light(&self) -> bool {
        let numbers = Self {
            shade: None,
            ..self.light_only()
        };
        !numbers.is_empty()
    }

    /// These keys over those of another document: keys that exclude each other do not mix, a preset replaces everything
    /// but the kind of picture, and a filter or kernel of another name has its own parameters.
    #[must_use]
    pub fn over(self, below: &Self) -> Self {
        let mut below = match self.preset {
            Some(preset) => below.shown(preset),
            None => below.clone(),
        };
        self.clear_light(&mut below);
        self.clear_kernel(&mut below);
        self.clear_filter(&mut below);
        self.clear_footprints(&mut below);
        self.or(below)
    }

    /// The keys that a preset leaves alone, because they say what is shown; presets of the papers are whole
    /// methods.
    fn shown(&self, preset: PresetName) -> Self {
        let light = self.light_only();
        match preset {
            PresetName::Best | PresetName::Balanced | PresetName::Fast | PresetName::Draft => Self {
                compositing: self.compositing,
                classification: self.classification,
                ..light
            },
            _ => light,
        }
    }

    fn clear_light(&self, below: &mut Self) {
        if self.shade == Some(false) {
            *below = below.without_light();
        }
        // Asking for any property of the light turns it on.
        if self.describes_light() && below.shade == Some(false) {
            below.shade = None;
        }
    }

    /// A wider kernel keeps its cut-off in standard deviations.
    fn clear_kernel(&self, below: &mut Self) {
        let usual = KernelName::Gaussian;
        let old = below.kernel.unwrap_or(usual);
        let new = self.kernel.unwrap_or(old);
        if new != old {
            below.kernel_sigma = None;
            below.kernel_radius = None;
            below.kernel_alpha = None;
        }
        if self.kernel.is_some() && new != usual {
            below.prefilter = None;
        }
        if let (Some(sigma), None) = (self.kernel_sigma, self.kernel_radius) {
            below.kernel_radius = below
                .kernel_sigma
                .zip(below.kernel_radius)
                .map(|(old_sigma, old_radius)| old_radius / old_sigma * sigma);
        }
        if self.kernel_radius.is_some() {
            below.kernel_alpha = None;
        }
    }

    fn clear_filter(&self, below: &mut Self) {
        let has_width = |name| matches!(name, FilterName::Ewa | FilterName::Matched);
        if self.filter.is_some_and(|name| !has_width(name)) {
            below.pixel_sigma = None;
        }
        if self.pixel_sigma.is_some() && below.filter.is_some_and(|name| !has_width(name)) {
            below.filter = Some(FilterName::Ewa);
        }
        if self.coverage == Some(CoverageName::Off) {
            below.coverage_samples = None;
            below.coverage_contrast = None;
        }
    }

    fn clear_footprints(&self, below: &mut Self) {
        if self.alignment.is_some_and(|name| name != AlignmentName::Auto) {
            below.alignment_budget = None;
        }
        match self.reconstruction {
            Some(ReconstructionName::Volume) => (below.flatness, below.surface_gradient) = (None, None),
            Some(ReconstructionName::Surface) => below.surface_gradient = None,
            Some(ReconstructionName::Mixed) | None => {}
        }
        if let Some(name) = self.rasterizer {
            below.subpixels = None;
            if name == RasterizerName::Auto {
                below.table_entries = None;
                below.table_precision = None;
                below.table_sections = None;
            }
        }
    }
}
