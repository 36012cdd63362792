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
    if !single.item.operators.is_empty() {
        return refuse(
            "on the GPU, a volume with operators",
            "operators are applied by the engine cpu",
        );
    }
    let sheets = sheets.of_labels(single.labels);
    let is_cut = !shot.scene.clips.is_empty() || !single.item.clips.is_empty();
    let has_cut_faces =
        sheets.shows == Shows::Material(Classification::Post) && sheets.gradient == Gradient::Differences;
    let drops_voxels = matches!(sheets.shows, Shows::Xray | Shows::Material(Classification::Pre));
    if (is_cut && !has_cut_faces && !drops_voxels) || (!single.isosurfaces.is_empty() && !has_cut_faces) {
        return refuse(
            "on the GPU, clips or isosurfaces with analytic gradients, maxima, minima or means",
            "take the presets default, fast or draft, and composited material",
        );
    }
    if single.item.motion.is_some() {
        return refuse(
            "on the GPU, a volume in motion",
            "motion blur is drawn by the engine cpu",
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
