//! What clouds of splats need of scene and settings.
//!
//! Nothing but Gaussians goes the published renderer's way (`splats`), unless sheets are asked for; everything
//! else but a volume alone is gathered into one cloud for the footprint engine. What it holds are colours, so data are
//! classified first, and sheets integrate sections.

use splatvol_scene::{Alignment, Classification, Filter, ImageSize, RenderSettings, Scene, SheetContent};

use crate::splats::SplatSettings;

/// What the published renderer needs of the settings.
pub(crate) fn published_settings(scene: &Scene, size: ImageSize) -> SplatSettings {
    SplatSettings {
        background: scene.background,
        ..SplatSettings::new(size)
    }
}

/// The settings with which the footprint engine renders a cloud.
pub(crate) fn in_sheets(settings: &RenderSettings) -> RenderSettings {
    let filter = match settings.filter {
        Filter::Matched { pixel_sigma } => Filter::Ewa { pixel_sigma },
        filter => filter,
    };
    RenderSettings {
        classification: Classification::Pre,
        sheet: Some(SheetContent::Section),
        prefilter: false,
        filter,
        alignment: match settings.alignment {
            Alignment::Sheet => Alignment::Affine,
            alignment => alignment,
        },
        ..*settings
    }
}
