//! Checks the operators, clips and isosurfaces of a volume against the settings.

use splatvol_scene::{Gradient, Scene, SceneError, SheetSettings, Shows, SingleVolume};

use super::{ONE_VALUE, asked_of};

/// Rejects features of the scene that whole footprints do not support.
pub(super) fn footprints(scene: &Scene, single: &SingleVolume<'_>) -> Result<(), SceneError> {
    match asked_of(std::slice::from_ref(single.item), &scene.clips) {
        None => Ok(()),
        Some(what) => Err(SceneError::Combination {
            what,
            why: "whole footprints and sections of them are drawn without it, use image sheets and the usual filters",
        }),
    }
}

/// Rejects features of the scene that sheets do not support.
pub(super) fn on_sheets(
    scene: &Scene,
    single: &SingleVolume<'_>,
    sheets: &SheetSettings,
) -> Result<(), SceneError> {
    if single.labels && sheets.shows_one_value() {
        return Err(SceneError::Combination {
            what: "a label map",
            why: "maxima, minima and means are of amounts, and its values are names; use image sheets or X-ray",
        });
    }
    let Some(what) = asked_of(std::slice::from_ref(single.item), &scene.clips) else {
        return Ok(());
    };
    let refuse = |why| Err(SceneError::Combination { what, why });
    let operated = !single.item.operators.is_empty() || !single.isosurfaces.is_empty();
    match sheets.shows {
        Shows::Mip | Shows::MinimumIntensity | Shows::Mean => return refuse(ONE_VALUE),
        Shows::Xray if operated => {
            return refuse("X-rays have no sheets whose pixels could be lit, use image sheets");
        }
        Shows::Xray | Shows::Material(_) => {}
    }
    let post = !sheets.splats_colors();
    if operated && !post {
        return refuse(
            "pre-classified sheets hold colours, neither values nor gradients, use post-classification",
        );
    }
    if post && sheets.gradient != Gradient::Differences {
        return refuse(
            "what analytic gradients (preset best) light has no operators, clips or isosurfaces, use gradients by differences",
        );
    }
    Ok(())
}
