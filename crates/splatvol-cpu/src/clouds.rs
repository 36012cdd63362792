//! What clouds of splats need of scene and settings.
//!
//! Nothing but Gaussians goes the published renderer's way (`splatvol_gaussians`), unless sheets are asked for; everything
//! else but a volume alone is gathered into one cloud for the footprint engine. What it holds are colours, so data are
//! classified first, and sheets integrate sections.

use splatvol_gaussians::GaussianSettings;
use splatvol_scene::{
    Alignment, Classification, Compositing, Filter, ImageSize, Item, Rasterizer, Reconstruction,
    RenderSettings, Scene, SceneError, SheetContent,
};

/// Why the published way knows no operators, clips and isosurfaces.
pub(crate) const PUBLISHED: &str = "Gaussians are drawn whole, one by one, without it";
/// Why a cloud knows no operators, clips and isosurfaces.
pub(crate) const CLOUD: &str = "only a volume alone is rendered with it; several things, meshes, points and Gaussians are classified first, without it";

/// Refuses what is asked of items that clouds do not have, and why.
pub(crate) fn check(scene: &Scene, settings: &RenderSettings, why: &'static str) -> Result<(), SceneError> {
    let asks = |of: fn(&Item) -> bool| scene.items.iter().any(of);
    let what = if asks(Item::shows_isosurfaces) {
        "an isosurface"
    } else if asks(|item| !item.operators.is_empty()) {
        "an operator (texture, bump or environment map, gradient opacity, 2-D transfer function)"
    } else if !scene.clips.is_empty() || asks(|item| !item.clips.is_empty()) {
        "a clip"
    } else if settings.motion_blur.moves_footprints() && asks(|item| item.motion.is_some()) {
        return Err(SceneError::invalid(
            "motion blur",
            settings.motion_blur,
            "subframes: footprints are blurred one by one in pictures of one volume alone",
        ));
    } else {
        return Ok(());
    };
    Err(SceneError::Combination { what, why })
}

/// What the published renderer needs of the settings.
pub(crate) fn published_settings(scene: &Scene, size: ImageSize) -> GaussianSettings {
    GaussianSettings {
        background: scene.background,
        ..GaussianSettings::new(size)
    }
}

/// The settings with which the footprint engine renders a cloud.
///
/// # Errors
/// Methods that need the samples of one grid.
pub(crate) fn in_sheets(settings: &RenderSettings) -> Result<RenderSettings, SceneError> {
    let refuse = |why| {
        Err(SceneError::Combination {
            what: "anything but one volume",
            why,
        })
    };
    if settings.compositing.shows_one_value() || settings.compositing == Compositing::AxisSheets {
        return refuse(
            "maxima, minima, means and the slices of a grid are of one volume; use image sheets, per-splat or X-ray",
        );
    }
    if settings.rasterizer != Rasterizer::Auto {
        return refuse(
            "tables hold the footprints of one kernel, and each splat here has its own; use rasterizer auto",
        );
    }
    if matches!(settings.filter, Filter::Swan | Filter::SwanAlpha) {
        return refuse("swan's filter compares the voxels of one grid with pixels; use ewa or matched");
    }
    if settings.kernel.gaussian().is_none() {
        return refuse("kernels of ellipsoids are Gaussians; use the gaussian kernel");
    }
    if settings.reconstruction != Reconstruction::Volume || settings.extraction.is_some() {
        return refuse("flattening and ranges of interest are of one volume");
    }
    let filter = match settings.filter {
        Filter::Matched { pixel_sigma } => Filter::Ewa { pixel_sigma },
        filter => filter,
    };
    Ok(RenderSettings {
        classification: Classification::Pre,
        sheet: Some(SheetContent::Section),
        prefilter: false,
        filter,
        alignment: match settings.alignment {
            Alignment::Sheet => Alignment::Affine,
            alignment => alignment,
        },
        ..*settings
    })
}
