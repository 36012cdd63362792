//! Pictures of several things: which engine renders a composition, and with which settings.
//!
//! Nothing but Gaussians goes the published renderer's way (`splatvol_gaussians`), unless sheets are asked for; everything
//! else is gathered into one cloud for the footprint engine. What it holds are colours, so data are classified first, and
//! sheets integrate sections.

use splatvol_gaussians::{GaussianSettings, Placed};
use splatvol_scene::{
    Alignment, Classification, Compositing, Composition, Content, Coverage, Filter, GaussianMode, ImageSize,
    MotionBlur, Rasterizer, Reconstruction, RenderSettings, SceneError, SheetContent,
};

/// The Gaussians of a composition that is to be rendered as published; `None` where sheets are.
///
/// # Errors
/// Things besides Gaussians, where the published way is asked for.
pub(crate) fn published<'a>(
    composition: &'a Composition,
    settings: &RenderSettings,
) -> Result<Option<Vec<Placed<'a>>>, SceneError> {
    match (settings.gaussians, composition.is_gaussians()) {
        (GaussianMode::Volumetric, _) | (GaussianMode::Auto, false) => Ok(None),
        (GaussianMode::Published, false) => Err(SceneError::Combination {
            what: "the published way to render Gaussians (3dgs)",
            why: "it sorts whole Gaussians and knows nothing else; use volumetric, which composites them with \
                  everything else sheet by sheet",
        }),
        (GaussianMode::Auto | GaussianMode::Published, true) => {
            let placed = composition.items.iter().filter_map(|item| match &item.content {
                Content::Gaussians(gaussians) => Some(Placed {
                    gaussians,
                    world_from_item: item.world_from_item,
                }),
                _ => None,
            });
            Ok(Some(placed.collect()))
        }
    }
}

/// What the published renderer needs of the settings.
pub(crate) fn published_settings(composition: &Composition, size: ImageSize) -> GaussianSettings {
    GaussianSettings {
        background: composition.background,
        ..GaussianSettings::new(size)
    }
}

/// The settings with which the footprint engine renders a composition.
///
/// # Errors
/// Methods that need the samples of one grid.
pub(crate) fn in_sheets(settings: &RenderSettings) -> Result<RenderSettings, SceneError> {
    let refuse = |why| {
        Err(SceneError::Combination {
            what: "a composition",
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
    if settings.coverage != Coverage::Off {
        return refuse("its edges are not sampled; use coverage off");
    }
    let filter = match settings.filter {
        Filter::Matched { pixel_sigma } => Filter::Ewa { pixel_sigma },
        filter => filter,
    };
    Ok(RenderSettings {
        classification: Classification::Pre,
        sheet: Some(SheetContent::Section),
        prefilter: false,
        motion_blur: MotionBlur::None,
        filter,
        alignment: match settings.alignment {
            Alignment::Sheet => Alignment::Affine,
            alignment => alignment,
        },
        ..*settings
    })
}
