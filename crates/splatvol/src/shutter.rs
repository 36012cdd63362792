//! Sub-frames: the scenes at rest that make up a motion-blurred picture.
//!
//! If everything moves alike, the camera moves the other way, and nothing derived from the items is computed again. If
//! items move on their own, they are moved to their places: at the time t of -1/2..1/2, `world_from_item` becomes
//! `motion(t) * world_from_item`.

use std::borrow::Cow;

use splatvol_core::engine::Shot;
use splatvol_scene::{Camera, MotionBlur, RenderSettings, Scene, SceneError};

/// A scene at rest, and the camera that sees it.
#[derive(Debug)]
pub(crate) struct Exposed<'a> {
    pub scene: Cow<'a, Scene>,
    pub camera: Camera,
}

/// The sub-frames of a picture; `None` if nothing moves, or footprints are blurred instead.
///
/// # Errors
/// A motion that sub-frames cannot show.
pub(crate) fn sub_frames<'a>(shot: Shot<'a>) -> Result<Option<Vec<Exposed<'a>>>, SceneError> {
    let Shot {
        scene,
        camera,
        settings,
    } = shot;
    let MotionBlur::Subframes { count } = settings.motion_blur else {
        return Ok(None);
    };
    let Some(first) = scene.items.iter().find_map(|item| item.motion.as_ref()) else {
        return Ok(None);
    };
    if scene.items.iter().all(|item| item.motion.as_ref() == Some(first)) {
        let cameras = first.cameras(camera, count)?.into_iter();
        let still = |camera| Exposed {
            scene: Cow::Borrowed(scene),
            camera,
        };
        return Ok(Some(cameras.map(still).collect()));
    }
    let times = (0..count).map(|k| (f64::from(k) + 0.5) / f64::from(count) - 0.5);
    times
        .map(|time| {
            Ok(Exposed {
                scene: Cow::Owned(at(scene, time)?),
                camera: *camera,
            })
        })
        .collect::<Result<_, _>>()
        .map(Some)
}

/// The items of a scene, moved to their places at a time.
fn at(scene: &Scene, time: f64) -> Result<Scene, SceneError> {
    let mut moved = scene.clone();
    for item in &mut moved.items {
        if let Some(motion) = item.motion.take() {
            item.world_from_item = motion.world_at(time)? * item.world_from_item;
        }
    }
    Ok(moved)
}

/// The settings of one sub-frame.
pub(crate) fn still(settings: &RenderSettings) -> RenderSettings {
    RenderSettings {
        motion_blur: MotionBlur::None,
        ..*settings
    }
}
