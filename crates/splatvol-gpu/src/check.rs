//! Requests that this engine refuses, by name.

use splatvol_core::engine::Shot;
use splatvol_scene::{
    Classification, Gradient, Item, Method, SceneError, SheetSettings, Shows, SingleVolume,
};

/// Largest radius of a kernel, voxels.
const MOST_RADIUS: f64 = 3.0;

/// The volumes of a shot, and the settings of their planes.
///
/// # Errors
/// What the GPU does not draw.
pub(crate) fn supported<'a>(shot: &Shot<'a>) -> Result<(Vec<SingleVolume<'a>>, SheetSettings), SceneError> {
    let volumes: Option<Vec<_>> = shot.scene.items.iter().map(Item::as_volume).collect();
    let Some(volumes) = volumes.filter(|volumes| !volumes.is_empty()) else {
        return refuse(
            "on the GPU, a scene other than volumes, or Gaussians as published",
            "meshes, points and volumetric Gaussians are drawn by the engine cpu; take it, or auto",
        );
    };
    let Method::Sheets(sheets) = shot.settings.method else {
        return refuse(
            "on the GPU, a method other than sheets",
            "the papers' methods are drawn by the engine cpu",
        );
    };
    if volumes.len() > 1 && !matches!(sheets.shows, Shows::Material(_)) {
        return refuse(
            "on the GPU, X-rays, maxima, minima or means of several volumes",
            "the GPU engine composites their material; X-rays of several are drawn by the engine cpu",
        );
    }
    if sheets.kernel.radius > MOST_RADIUS {
        return Err(SceneError::invalid(
            "kernel radius",
            sheets.kernel.radius,
            "at most 3 voxels on the GPU",
        ));
    }
    for single in &volumes {
        check_volume(shot, single, &sheets.of_labels(single.labels))?;
    }
    Ok((volumes, sheets))
}

fn refuse<T>(what: &'static str, why: &'static str) -> Result<T, SceneError> {
    Err(SceneError::Combination { what, why })
}

fn check_volume(
    shot: &Shot<'_>,
    single: &SingleVolume<'_>,
    sheets: &SheetSettings,
) -> Result<(), SceneError> {
    if !single.item.operators.is_empty() {
        return refuse(
            "on the GPU, a volume with operators",
            "operators are applied by the engine cpu",
        );
    }
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
    Ok(())
}
