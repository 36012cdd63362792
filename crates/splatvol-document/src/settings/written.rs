//! From complete settings to the keys that say the same.

use splatvol_scene::{
    Alignment, Classification, Compositing, Coverage, Filter, FlatSettings, Kernel, Lighting, Rasterizer,
    Reconstruction,
};

use crate::keys::SettingKeys;
use crate::keys::names::{
    AlignmentName, CoverageName, FilterName, KernelName, RasterizerName, ReconstructionName,
};

/// All keys of complete settings except size and motion blur, which have their own places in a document.
pub fn written(settings: &FlatSettings) -> SettingKeys {
    let keys = SettingKeys {
        compositing: Some(settings.compositing.into()),
        classification: classification(settings).map(Into::into),
        gaussians: Some(settings.gaussians.into()),
        sheet_thickness: Some(settings.sheet_thickness),
        gradient: Some(settings.gradient.into()),
        level_bias: Some(settings.level_bias),
        termination: Some(settings.termination),
        prefilter: Some(settings.prefilter),
        sheet: settings.sheet.map(Into::into),
        sheet_values: Some(settings.sheet_values.into()),
        sheet_precision: Some(settings.sheet_precision.into()),
        absorption: Some(settings.absorption.into()),
        stretch: Some(settings.stretch.into()),
        kernel_edge: Some(settings.kernel_edge.into()),
        occlusion: Some(settings.occlusion.into()),
        extract_density: settings.extraction.and_then(|extraction| extraction.density),
        extract_gradient: settings.extraction.map(|extraction| extraction.gradient),
        ..SettingKeys::default()
    };
    let keys = with_filter(keys, settings);
    let keys = with_kernel(keys, settings.kernel);
    let keys = with_footprints(keys, settings);
    with_light(keys, settings.lighting)
}

/// Colours or data; `None` if a ray's value is shown, for which there is no difference.
fn classification(settings: &FlatSettings) -> Option<Classification> {
    let data = settings.compositing.shows_one_value() || settings.compositing == Compositing::Xray;
    (!data || settings.classification == Classification::Pre).then_some(settings.classification)
}

fn with_filter(keys: SettingKeys, settings: &FlatSettings) -> SettingKeys {
    let (filter, pixel_sigma) = match settings.filter {
        Filter::None => (FilterName::None, None),
        Filter::Ewa { pixel_sigma } => (FilterName::Ewa, Some(pixel_sigma)),
        Filter::Matched { pixel_sigma } => (FilterName::Matched, Some(pixel_sigma)),
        Filter::Swan => (FilterName::Swan, None),
        Filter::SwanAlpha => (FilterName::SwanAlpha, None),
    };
    let (coverage, coverage_samples, coverage_contrast) = match settings.coverage {
        Coverage::Off => (CoverageName::Off, None, None),
        Coverage::Adaptive { samples, contrast } => (CoverageName::Adaptive, Some(samples), Some(contrast)),
    };
    SettingKeys {
        filter: Some(filter),
        pixel_sigma,
        coverage: Some(coverage),
        coverage_samples,
        coverage_contrast,
        ..keys
    }
}

fn with_kernel(keys: SettingKeys, kernel: Kernel) -> SettingKeys {
    let (name, [sigma, radius, alpha]) = match kernel {
        Kernel::Gaussian { sigma, radius } => (KernelName::Gaussian, [Some(sigma), Some(radius), None]),
        Kernel::CrawfisMax => (KernelName::CrawfisMax, [None; 3]),
        Kernel::CubicBspline => (KernelName::CubicBspline, [None; 3]),
        Kernel::KaiserBessel { radius, alpha } => {
            (KernelName::KaiserBessel, [None, Some(radius), Some(alpha)])
        }
    };
    SettingKeys {
        kernel: Some(name),
        kernel_sigma: sigma,
        kernel_radius: radius,
        kernel_alpha: alpha,
        // Only Gaussians are prefiltered.
        prefilter: keys.prefilter.filter(|_| name == KernelName::Gaussian),
        ..keys
    }
}

fn with_footprints(keys: SettingKeys, settings: &FlatSettings) -> SettingKeys {
    let (alignment, alignment_budget, alignment_switch) = match settings.alignment {
        Alignment::Sheet => (AlignmentName::Sheet, None, None),
        Alignment::Affine => (AlignmentName::Affine, None, None),
        Alignment::Exact => (AlignmentName::Exact, None, None),
        Alignment::Grid => (AlignmentName::Grid, None, None),
        Alignment::Ray => (AlignmentName::Ray, None, None),
        Alignment::RayIdeal => (AlignmentName::RayIdeal, None, None),
        Alignment::Switch { behind } => (AlignmentName::Switch, None, Some(behind)),
        Alignment::Auto { budget } => (AlignmentName::Auto, Some(budget), None),
    };
    let (reconstruction, flatness, surface_gradient) = match settings.reconstruction {
        Reconstruction::Volume => (ReconstructionName::Volume, None, None),
        Reconstruction::Surface { flatness } => (ReconstructionName::Surface, Some(flatness), None),
        Reconstruction::Mixed { flatness, gradient } => {
            (ReconstructionName::Mixed, Some(flatness), Some(gradient))
        }
    };
    let (rasterizer, subpixels, blit_radius) = match settings.rasterizer {
        Rasterizer::Auto => (RasterizerName::Auto, None, None),
        Rasterizer::Linear1d => (RasterizerName::Linear1d, None, None),
        Rasterizer::Square1d => (RasterizerName::Square1d, None, None),
        Rasterizer::Ellipse1d => (RasterizerName::Ellipse1d, None, None),
        Rasterizer::Rlut { subpixels } => (RasterizerName::Rlut, Some(subpixels), None),
        Rasterizer::Blit2d { subpixels } => (RasterizerName::Blit2d, Some(subpixels), None),
        Rasterizer::Hybrid { subpixels, radius } => (RasterizerName::Hybrid, Some(subpixels), Some(radius)),
    };
    let table = Some(settings.table).filter(|_| settings.rasterizer.has_table());
    SettingKeys {
        alignment: Some(alignment),
        alignment_budget,
        alignment_switch,
        reconstruction: Some(reconstruction),
        flatness,
        surface_gradient,
        rasterizer: Some(rasterizer),
        subpixels,
        blit_radius,
        table_entries: table.map(|table| table.entries),
        table_precision: table.map(|table| table.precision.into()),
        table_sections: table.map(|table| table.sections),
        ..keys
    }
}

fn with_light(keys: SettingKeys, lighting: Option<Lighting>) -> SettingKeys {
    SettingKeys {
        shade: Some(lighting.is_some()),
        ambient: lighting.map(|light| light.ambient),
        diffuse: lighting.map(|light| light.diffuse),
        specular: lighting.map(|light| light.specular),
        specular_power: lighting.map(|light| light.specular_power),
        gradient_floor: lighting.map(|light| light.gradient_floor),
        light: lighting.map(|light| light.direction),
        ..keys
    }
}
