//! Requests that this engine refuses, by name.

use splatvol_core::engine::Shot;
use splatvol_scene::{Classification, Gradient, Method, SceneError, SheetSettings, Shows, SingleVolume};

/// Largest radius of a kernel, voxels.
const MOST_RADIUS: f64 = 3.0;

/// The one volume of a shot, and the settings of its planes.
///
/// # Errors
/// What the GPU does not draw.
pub(crate) fn supported<'a>(shot: &Shot<'a>) -> Result<(SingleVolume<'a>, SheetSettings), SceneError> {
    let refuse = |what, why| Err(SceneError::Combination { what, why });
    let Ok(single) = shot.scene.single_volume() else {
        return refuse(
            "on the GPU, a scene other than one volume",
            "the GPU engine draws one volume; take the engine cpu, or auto",
        );
    };
    let Method::Sheets(sheets) = shot.settings.method else {
        return refuse(
            "on the GPU, a method other than sheets",
            "the papers' methods are drawn by the engine cpu",
        );
    };
    if sheets.shows != Shows::Material(Classification::Post) || single.labels {
        return refuse(
            "on the GPU, anything but post-classified sheets",
            "maxima, minima, means, X-rays, labels and pre-classification are drawn by the engine cpu",
        );
    }
    if sheets.gradient != Gradient::Differences {
        return refuse(
            "on the GPU, an analytic gradient",
            "the GPU engine lights by differences (presets default, fast and draft)",
        );
    }
    if !shot.scene.clips.is_empty() || !single.item.operators.is_empty() || !single.isosurfaces.is_empty() {
        return refuse(
            "on the GPU, a volume with clips, operators or isosurfaces",
            "these are drawn by the engine cpu",
        );
    }
    if sheets.kernel.radius > MOST_RADIUS {
        return Err(SceneError::invalid(
            "kernel radius",
            sheets.kernel.radius,
            "at most 3 voxels on the GPU",
        ));
    }
    Ok((single, sheets))
}
