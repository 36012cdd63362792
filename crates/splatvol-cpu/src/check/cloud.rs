//! What clouds of splats cannot show: several things, meshes, points, Gaussians.

use splatvol_scene::{Compositing, Filter, Rasterizer, Reconstruction, RenderSettings, Scene, SceneError};

use super::{asked, asked_of, volume};
use crate::route::own_layer;

/// Refuses what the published way to render Gaussians does not have.
pub(super) fn published(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
    if settings.compositing != Compositing::ImageSheets {
        return Err(SceneError::invalid(
            "compositing",
            settings.compositing,
            "image-sheets, or Gaussians volumetric: as published they are composited over each other, one by one",
        ));
    }
    footprints_in_motion(scene, settings)?;
    match asked(scene) {
        None => Ok(()),
        Some(what) => Err(SceneError::Combination {
            what,
            why: "Gaussians are drawn whole, one by one, without it",
        }),
    }
}

/// Refuses what layers do not have: volumes have what they have alone, and a cloud is cut by the clips of the scene.
pub(super) fn layers(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
    footprints_in_motion(scene, settings)?;
    for item in &scene.items {
        if let Some(single) = own_layer(item, settings) {
            volume::check(scene, &single, settings)?;
        } else if let Some(what) = asked_of(std::slice::from_ref(item), &[]) {
            return Err(SceneError::Combination {
                what,
                why: "it is of volumes; meshes, points and Gaussians are classified first, without it",
            });
        }
    }
    Ok(())
}

/// Refuses what sheets of clouds do not have.
pub(super) fn sheets(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
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
    footprints_in_motion(scene, settings)?;
    match asked(scene) {
        None => Ok(()),
        Some(what) => Err(SceneError::Combination {
            what,
            why: "it is of a volume alone; several things, meshes, points and Gaussians are classified first, without it",
        }),
    }
}

fn footprints_in_motion(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
    if settings.motion_blur.moves_footprints() && scene.items.iter().any(|item| item.motion.is_some()) {
        return Err(SceneError::invalid(
            "motion blur",
            settings.motion_blur,
            "subframes: footprints are blurred one by one in pictures of one volume alone",
        ));
    }
    Ok(())
}
