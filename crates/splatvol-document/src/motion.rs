//! Motion while the shutter is open, and its blur.

use glam::DVec3;
use splatvol_scene::{Camera, FlatSettings, Motion, MotionBlur, RenderSettings, SceneError};

use crate::DocumentError;
use crate::keys::names::MotionBlurName;
use crate::keys::{CameraSweep, MotionKeys};

/// Pictures averaged unless asked otherwise.
const SUB_FRAMES: u32 = 16;
/// Pictures averaged at most.
const MOST_SUB_FRAMES: u32 = 1024;

/// Motion of the camera from frame to frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CameraMotion {
    /// It turns: an automatic one shows all sides.
    pub turns: bool,
    /// It moves while the shutter is open.
    pub shutter: bool,
}

/// Camera and subject of a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shot<'a> {
    pub(crate) camera: &'a Camera,
    /// Centre of what is shown, world.
    pub(crate) centre: DVec3,
    /// Whether it is a volume alone: footprints in motion need one, without operators and clips.
    pub(crate) plain: bool,
    /// Whether the camera's own motion is seen through a shutter.
    pub(crate) shutter: bool,
}

impl MotionKeys {
    /// The motion of complete keys.
    ///
    /// # Errors
    /// Poses that do not make a camera.
    pub fn motion(&self) -> Result<Option<Motion>, SceneError> {
        if let Some(velocity) = self.velocity {
            return Ok(Some(Motion::Linear(DVec3::from_array(velocity))));
        }
        if let (Some(degrees), Some(axis), Some(centre)) = (self.spin, self.spin_axis, self.spin_centre) {
            return Ok(Some(Motion::Spin {
                axis: DVec3::from_array(axis),
                centre: DVec3::from_array(centre),
                angle: degrees.to_radians(),
            }));
        }
        self.camera.as_ref().map(CameraSweep::motion).transpose()
    }
}

impl CameraSweep {
    /// The motion of everything as this camera sees it.
    ///
    /// # Errors
    /// Poses that do not make a camera.
    pub fn motion(&self) -> Result<Motion, SceneError> {
        Ok(Motion::Camera {
            opening: self.opening.camera()?,
            closing: self.closing.camera()?,
        })
    }
}

/// The motion, with nothing left open; sets how it is blurred: by the key's method, or by that of `settings` if a
/// preset has one. A scene at rest is not blurred.
///
/// If the shutter sees the camera move, frames have their own motion and their own sub-frames: then there is no motion
/// here, and no blur but that of footprints.
pub(crate) fn resolve(
    keys: &MotionKeys,
    shot: Shot<'_>,
    settings: &mut RenderSettings,
) -> Result<MotionKeys, DocumentError> {
    check(keys)?;
    let method = settings.motion_blur;
    *settings = with_blur(settings, MotionBlur::None)?;
    if shot.shutter {
        let blur = of_shutter(keys, method)?;
        if keys.spin.is_some() || keys.velocity.is_some() {
            return Err(DocumentError::usage(
                "`animation.shutter` shows the camera's motion, `motion.spin` and `motion.velocity` the volume's: give one of them",
            ));
        }
        if blur.moves_footprints() {
            *settings = with_blur(settings, blur)?;
        }
        return Ok(MotionKeys::default());
    }
    let still = MotionKeys {
        sub_frames: keys.sub_frames.clone(),
        ..MotionKeys::default()
    };
    if !keys.moves() {
        let key = match keys.motion_blur {
            None | Some(MotionBlurName::None) if keys.subframes.is_some() => "motion.subframes",
            None | Some(MotionBlurName::None) => return Ok(still),
            Some(_) => "motion.motion-blur",
        };
        return Err(DocumentError::refused(key, "needs a motion").hinting(
            "give --spin DEGREES or --velocity X,Y,Z; or let the camera move: splatvol animate --shutter SHARE",
        ));
    }
    let blur = blur(keys, method, &shot, settings)?;
    *settings = with_blur(settings, blur)?;
    let is_spin = keys.velocity.is_none() && keys.spin.is_some();
    let (name, subframes) = named_blur(blur);
    Ok(MotionKeys {
        spin: keys.spin.filter(|_| is_spin),
        spin_axis: is_spin.then(|| keys.spin_axis.unwrap_or(shot.camera.up().to_array())),
        spin_centre: is_spin.then(|| keys.spin_centre.unwrap_or(shot.centre.to_array())),
        velocity: keys.velocity,
        camera: keys.camera.filter(|_| !is_spin && keys.velocity.is_none()),
        motion_blur: Some(name),
        subframes,
        ..still
    })
}

/// Refuses motions that exclude each other, and too many pictures to average.
fn check(keys: &MotionKeys) -> Result<(), DocumentError> {
    if keys.spin.is_some() && keys.velocity.is_some() {
        return Err(DocumentError::usage(
            "`motion.spin` and `motion.velocity` exclude each other",
        ));
    }
    match keys
        .subframes
        .filter(|count| !(1..=MOST_SUB_FRAMES).contains(count))
    {
        Some(count) => {
            let why = format!("{count}: expected 1 to {MOST_SUB_FRAMES}");
            Err(DocumentError::refused("motion.subframes", why))
        }
        None => Ok(()),
    }
}

/// The settings with another blur: footprints that were drawn one by one only for their blur are on sheets without
/// it.
fn with_blur(settings: &RenderSettings, motion_blur: MotionBlur) -> Result<RenderSettings, SceneError> {
    let settings = RenderSettings::try_from(FlatSettings {
        motion_blur,
        ..(*settings).into()
    })?;
    settings.validate()?;
    Ok(settings)
}

/// How a camera's motion is blurred if the method blurs motion in this way.
///
/// # Errors
/// Keys that exclude each other.
pub fn of_shutter(keys: &MotionKeys, method: MotionBlur) -> Result<MotionBlur, DocumentError> {
    match keys.motion_blur {
        Some(name) => named(keys, name),
        None if method.moves_footprints() && keys.subframes.is_none() => Ok(method),
        None => named(keys, MotionBlurName::Subframes),
    }
}

fn blur(
    keys: &MotionKeys,
    method: MotionBlur,
    shot: &Shot<'_>,
    settings: &RenderSettings,
) -> Result<MotionBlur, DocumentError> {
    let name = match keys.motion_blur {
        Some(name) => name,
        None if keys.subframes.is_some() => MotionBlurName::Subframes,
        None if method.moves_footprints() => return Ok(method),
        None => automatic(settings, shot),
    };
    named(keys, name)
}

fn named(keys: &MotionKeys, name: MotionBlurName) -> Result<MotionBlur, DocumentError> {
    match name {
        MotionBlurName::Subframes => Ok(MotionBlur::Subframes {
            count: keys.subframes.unwrap_or(SUB_FRAMES),
        }),
        _ if keys.subframes.is_some() => Err(DocumentError::refused(
            "motion.subframes",
            "needs `motion.motion-blur` subframes",
        )),
        MotionBlurName::None => Ok(MotionBlur::None),
        MotionBlurName::Capsule => Ok(MotionBlur::Capsule),
        MotionBlurName::Exact => Ok(MotionBlur::Exact),
    }
}

/// A blur as keys.
pub fn named_blur(blur: MotionBlur) -> (MotionBlurName, Option<u32>) {
    match blur {
        MotionBlur::None => (MotionBlurName::None, None),
        MotionBlur::Capsule => (MotionBlurName::Capsule, None),
        MotionBlur::Exact => (MotionBlurName::Exact, None),
        MotionBlur::Subframes { count } => (MotionBlurName::Subframes, Some(count)),
    }
}

/// One picture if that is enough.
fn automatic(settings: &RenderSettings, shot: &Shot<'_>) -> MotionBlurName {
    if shot.plain && with_blur(settings, MotionBlur::Exact).is_ok() {
        MotionBlurName::Exact
    } else {
        MotionBlurName::Subframes
    }
}
