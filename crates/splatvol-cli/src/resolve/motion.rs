//! Motion while the shutter is open, and its blur.

use glam::DVec3;
use splatvol::{Camera, FlatSettings, MotionBlur, RenderSettings, SceneError};

use crate::args::{CameraArgs, MotionArgs, MotionBlurName, RenderArgs};
use crate::failure::{During, Failure, Step};
use crate::recipe::{MotionRecipe, Recipe};

/// Pictures averaged unless asked otherwise.
const SUB_FRAMES: u32 = 16;

/// Motion of the camera from frame to frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CameraMotion {
    /// It turns: an automatic one shows all sides.
    pub(crate) turns: bool,
    /// It moves while the shutter is open.
    pub(crate) shutter: bool,
    /// It moves, so that it is not an earlier picture's.
    pub(crate) animated: bool,
}

/// Camera and subject of a picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shot<'a> {
    pub(crate) camera: &'a Camera,
    /// Centre of what is shown, world.
    pub(crate) centre: DVec3,
    /// Whether it is a volume as it is: footprints in motion are of one, and know neither operators nor clips.
    pub(crate) plain: bool,
    /// Whether the camera's own motion is seen through a shutter (`animate --shutter`).
    pub(crate) shutter: bool,
}

/// Settings of an earlier picture that are kept.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Earlier<'a> {
    motion: Option<&'a MotionRecipe>,
    blur: MotionBlur,
    /// Whether what is shown is the earlier picture's.
    same_input: bool,
    /// Whether the camera is the earlier picture's.
    same_camera: bool,
}

impl<'a> Earlier<'a> {
    /// The earlier picture's settings that neither flags nor camera replace.
    pub(crate) fn new(like: &'a Recipe, args: &RenderArgs, moves: CameraMotion) -> Self {
        let input = args.input.as_ref();
        Self {
            motion: like.motion.as_ref(),
            blur: like.settings.motion_blur,
            same_input: input
                .is_none_or(|own| like.volume().is_some_and(|like| *own == like.input.reference)),
            same_camera: args.camera == CameraArgs::default() && !moves.animated,
        }
    }
}

/// The motion of the scene; sets how it is blurred: by a flag's method, the earlier picture's, or that of `settings`, where
/// a preset says so. What does not move is not blurred.
///
/// Where the shutter sees the camera move, frames know their own motion, and sub-frames are theirs too: then there is no
/// motion here, and no blur but that of footprints.
pub(crate) fn resolve(
    args: &MotionArgs,
    earlier: Option<Earlier<'_>>,
    shot: Shot<'_>,
    settings: &mut RenderSettings,
) -> Result<Option<MotionRecipe>, Failure> {
    let method = settings.motion_blur;
    *settings = with_blur(settings, MotionBlur::None).during(Step::Usage)?;
    if shot.shutter {
        let blur = of_shutter(args, method)?;
        if args.spin.is_some() || args.velocity.is_some() {
            return Err(Failure::usage(
                "--shutter shows the camera's motion, --spin and --velocity the volume's: give one of them",
            ));
        }
        if blur.moves_footprints() {
            *settings = blurred(settings, blur)?;
        }
        return Ok(None);
    }
    let kept = earlier.and_then(|earlier| kept(earlier, &shot));
    let motion = asked(args, &shot).or(kept);
    if motion.is_none() {
        let flag = match args.motion_blur {
            None | Some(MotionBlurName::None) if args.subframes.is_some() => "--subframes",
            None | Some(MotionBlurName::None) => return Ok(None),
            Some(_) => "--motion-blur",
        };
        return Err(Failure::usage(format!("{flag} needs a motion")).hint(
            "give --spin DEGREES or --velocity X,Y,Z; or let the camera move: splatvol animate --shutter SHARE",
        ));
    }
    let earlier = earlier.filter(|earlier| earlier.motion.is_some());
    let known = Some(method).filter(|method| method.moves_footprints());
    let known = known.or(earlier.map(|earlier| earlier.blur));
    *settings = blurred(settings, blur(args, known, &shot, settings)?)?;
    Ok(motion)
}

/// The settings without blur.
pub(crate) fn still(settings: FlatSettings) -> FlatSettings {
    FlatSettings {
        motion_blur: MotionBlur::None,
        ..settings
    }
}

/// The settings with a blur that they allow.
fn blurred(settings: &RenderSettings, blur: MotionBlur) -> Result<RenderSettings, Failure> {
    with_blur(settings, blur).during(Step::Usage)
}

/// The settings with another blur: what was splatted one by one for the sake of one alone is on sheets without it.
fn with_blur(settings: &RenderSettings, motion_blur: MotionBlur) -> Result<RenderSettings, SceneError> {
    let settings = RenderSettings::try_from(FlatSettings {
        motion_blur,
        ..(*settings).into()
    })?;
    settings.validate()?;
    Ok(settings)
}

/// How a camera's motion is blurred, where the method blurs motion like this.
pub(crate) fn of_shutter(args: &MotionArgs, method: MotionBlur) -> Result<MotionBlur, Failure> {
    match args.motion_blur {
        Some(name) => named(args, name, SUB_FRAMES),
        None if method.moves_footprints() && args.subframes.is_none() => Ok(method),
        None => named(args, MotionBlurName::Subframes, SUB_FRAMES),
    }
}

/// The motion that the flags ask for.
fn asked(args: &MotionArgs, shot: &Shot<'_>) -> Option<MotionRecipe> {
    let velocity = args.velocity.map(|velocity| MotionRecipe::Linear { velocity });
    velocity.or_else(|| args.spin.map(|degrees| spin(degrees, shot)))
}

fn spin(degrees: f64, shot: &Shot<'_>) -> MotionRecipe {
    MotionRecipe::Spin {
        axis: shot.camera.up().to_array(),
        centre: shot.centre.to_array(),
        degrees,
    }
}

/// The earlier picture's motion. Another camera leaves the volume's as it was, and has none of its own.
fn kept(earlier: Earlier<'_>, shot: &Shot<'_>) -> Option<MotionRecipe> {
    match *earlier.motion? {
        MotionRecipe::Camera { .. } if !earlier.same_camera => None,
        MotionRecipe::Spin { degrees, .. } if !earlier.same_input => Some(spin(degrees, shot)),
        motion => Some(motion),
    }
}

fn blur(
    args: &MotionArgs,
    known: Option<MotionBlur>,
    shot: &Shot<'_>,
    settings: &RenderSettings,
) -> Result<MotionBlur, Failure> {
    let count = match known {
        Some(MotionBlur::Subframes { count }) => count,
        _ => SUB_FRAMES,
    };
    let name = match (args.motion_blur, known) {
        (Some(name), _) => name,
        (None, _) if args.subframes.is_some() => MotionBlurName::Subframes,
        // A new motion asks to be seen.
        (None, Some(MotionBlur::None)) if args.spin.is_some() || args.velocity.is_some() => {
            automatic(settings, shot)
        }
        (None, Some(blur)) => return Ok(blur),
        (None, None) => automatic(settings, shot),
    };
    named(args, name, count)
}

fn named(args: &MotionArgs, name: MotionBlurName, count: u32) -> Result<MotionBlur, Failure> {
    match name {
        MotionBlurName::Subframes => Ok(MotionBlur::Subframes {
            count: args.subframes.unwrap_or(count),
        }),
        _ if args.subframes.is_some() => Err(Failure::usage("--subframes needs --motion-blur subframes")),
        MotionBlurName::None => Ok(MotionBlur::None),
        MotionBlurName::Capsule => Ok(MotionBlur::Capsule),
        MotionBlurName::Exact => Ok(MotionBlur::Exact),
    }
}

/// One picture where that is enough.
fn automatic(settings: &RenderSettings, shot: &Shot<'_>) -> MotionBlurName {
    if shot.plain && with_blur(settings, MotionBlur::Exact).is_ok() {
        MotionBlurName::Exact
    } else {
        MotionBlurName::Subframes
    }
}
