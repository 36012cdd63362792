//! Which operators, clips and isosurfaces go with which settings.

use splatvol_scene::{Classification, Compositing, Gradient, RenderSettings, SceneError};

use crate::route::VolumeScene;

/// Refuses what the scene asks for where the settings cannot show it.
pub(crate) fn check(scene: &VolumeScene<'_>, settings: &RenderSettings) -> Result<(), SceneError> {
    let refuse = |what, why| Err(SceneError::Combination { what, why });
    let operated = !scene.operators.is_empty() || !scene.isosurfaces.is_empty();
    if !operated && scene.clips.is_empty() {
        return Ok(());
    }
    let what = if !scene.isosurfaces.is_empty() {
        "an isosurface"
    } else if !scene.operators.is_empty() {
        "an operator (texture, bump or environment map, gradient opacity, 2-D transfer function)"
    } else {
        "a clip"
    };
    if crate::footprints::is_needed(settings) || crate::footprints::blurs(scene, settings) {
        return refuse(
            what,
            "whole footprints and sections of them are drawn without it, use image sheets and the usual filters",
        );
    }
    match settings.compositing {
        Compositing::Mip | Compositing::MinimumIntensity | Compositing::Mean => {
            return refuse(
                what,
                "maximum, minimum and mean show one value of a ray alone, use image sheets",
            );
        }
        Compositing::Xray if operated => {
            return refuse(
                what,
                "X-rays have no sheets whose pixels could be lit, use image sheets",
            );
        }
        _ => {}
    }
    let post = settings.compositing != Compositing::Xray && settings.classification == Classification::Post;
    if operated && !post {
        return refuse(
            what,
            "pre-classified sheets hold colours, neither values nor gradients, use post-classification",
        );
    }
    if settings.gradient != Gradient::Differences {
        return refuse(
            what,
            "analytic gradients (preset best) go slice by slice, use gradients by differences",
        );
    }
    if post && !settings.prefilter {
        return refuse(
            what,
            "data that are not prefiltered go slice by slice, use the prefilter",
        );
    }
    if scene.volume.statistics().non_finite > 0 {
        return refuse(
            what,
            "volumes with missing samples go slice by slice, fill them first",
        );
    }
    Ok(())
}

/// The error where the camera sees footprints of too different size for all sheets at once.
pub(crate) fn too_close(scene: &VolumeScene<'_>) -> Result<(), SceneError> {
    if scene.operators.is_empty() && scene.isosurfaces.is_empty() && scene.clips.is_empty() {
        return Ok(());
    }
    Err(SceneError::Combination {
        what: "this view of a scene with operators, clips or isosurfaces",
        why: "the camera is too close to the volume or its angle too wide, move it away or make the angle smaller",
    })
}
