//! Which operators, clips and isosurfaces of a volume go with which settings.

use splatvol_scene::{
    Classification, Compositing, Gradient, RenderSettings, Scene, SceneError, SingleVolume,
};

use super::{ONE_VALUE, asked_of};
use crate::classic;

/// Refuses what the scene asks for where the settings cannot show it.
pub(super) fn check(
    scene: &Scene,
    single: &SingleVolume<'_>,
    settings: &RenderSettings,
) -> Result<(), SceneError> {
    if single.labels && settings.compositing.shows_one_value() {
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
    if classic::render(single.item.motion.as_ref(), settings) {
        return refuse(
            "whole footprints and sections of them are drawn without it, use image sheets and the usual filters",
        );
    }
    match settings.compositing {
        Compositing::Mip | Compositing::MinimumIntensity | Compositing::Mean => {
            return refuse(ONE_VALUE);
        }
        Compositing::Xray if operated => {
            return refuse("X-rays have no sheets whose pixels could be lit, use image sheets");
        }
        _ => {}
    }
    let post = settings.compositing != Compositing::Xray && settings.classification == Classification::Post;
    if operated && !post {
        return refuse(
            "pre-classified sheets hold colours, neither values nor gradients, use post-classification",
        );
    }
    if post && settings.gradient != Gradient::Differences {
        return refuse(
            "what analytic gradients (preset best) light has no operators, clips or isosurfaces, use gradients by differences",
        );
    }
    Ok(())
}
