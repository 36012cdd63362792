//! Checks in advance that a picture can be rendered: by the engine, and by the steps applied to its pictures.

use splatvol_core::engine::Shot;
use splatvol_scene::{Camera, Coverage, ImageSize, RenderSettings, Scene, SceneError};

use crate::shutter;

/// Checks that a scene can be rendered from a camera with these settings, by an engine that
/// [`EngineConfig`](crate::EngineConfig) starts. Rendering refuses nothing that passes here. `docs/scenes.md` has a
/// table of the answers, made with this function.
///
/// # Errors
/// The reason: the field, its value and the accepted values; or the request, and what it cannot be combined with.
pub fn check(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Result<(), SceneError> {
    let shot = Shot {
        scene,
        camera,
        settings,
    };
    check_by(shot, splatvol_cpu::check)
}

/// [`check`] for an engine with a check of its own.
pub(crate) fn check_by(
    shot: Shot<'_>,
    engine: impl FnOnce(Shot<'_>) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    shot.scene.validate()?;
    engine(shot)?;
    coverage(shot.settings)?;
    shutter::sub_frames(shot).map(|_| ())
}

/// Refuses edge samples that would require too large a picture.
fn coverage(settings: &RenderSettings) -> Result<(), SceneError> {
    let Coverage::Adaptive { samples, .. } = settings.coverage else {
        return Ok(());
    };
    let [width, height] = <[u32; 2]>::from(settings.size).map(|side| side.saturating_mul(samples));
    match ImageSize::new(width, height) {
        Ok(_) => Ok(()),
        Err(_) => Err(SceneError::Combination {
            what: "coverage",
            why: "the picture times its samples per axis is too large, ask for fewer samples",
        }),
    }
}
