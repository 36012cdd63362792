//! Which cameras see which frame.
//!
//! Frame i of N is in the middle of its time: at `t = i / N` of a closed path, whose end would be its first frame
//! again, and at `t = i / (N - 1)` of an open one, which shows both ends. The shutter, open for the share S of the
//! time between frames, sees the n sub-frames at `t + (S (k + 1/2) / n - S/2) / N`, k from 0; footprints in motion
//! move as between the cameras at `t -+ S / (2 N)`.

use anyhow::Context;
use glam::DVec3;
use splatvol::{Camera, CameraKey, CameraPath, MotionBlur, Projection};
use splatvol_document::CameraPose;
use splatvol_io::{StoredCameraKey, read_camera_keys};

use crate::args::AnimateArgs;
use crate::failure::{During, Failure, Step};
use crate::recipe::MotionRecipe;
use crate::resolve::motion;

/// Frames unless asked otherwise.
const FRAMES: u32 = 90;

/// When the pictures are taken, and from where.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    path: CameraPath,
    frames: u32,
    /// Time between frames, 1 for the whole path.
    step: f64,
    ease: bool,
    /// Share of the time between frames.
    shutter: f64,
    /// How the camera's motion is blurred.
    blur: MotionBlur,
}

/// The flags' plan, before the position of the volume is known.
pub(crate) fn stored_keys(args: &AnimateArgs) -> Result<Option<Vec<StoredCameraKey>>, Failure> {
    args.path
        .as_deref()
        .map(read_camera_keys)
        .transpose()
        .during(Step::Input)
}

impl Plan {
    /// For key frames, or a turntable, whose camera is `start`, which also says what key frames leave out. `blur` is how
    /// footprints are blurred.
    pub(crate) fn new(
        args: &AnimateArgs,
        keys: Option<&[StoredCameraKey]>,
        (start, blur): (&Camera, MotionBlur),
    ) -> Result<Self, Failure> {
        let path = match keys {
            None => CameraPath::turntable(*start, args.turntable.unwrap_or(360.0)).during(Step::Usage)?,
            Some(keys) => through(args, keys, start)?,
        };
        let frames = match (args.frames, keys) {
            (Some(frames), _) => frames,
            (None, Some([first, .., last])) => timed(args, [first.time, last.time], path.is_closed())?,
            (None, _) => FRAMES,
        };
        let steps = if path.is_closed() { frames } else { frames - 1 };
        let plan = Self {
            path,
            frames,
            step: 1.0 / f64::from(steps.max(1)),
            ease: args.ease,
            shutter: args.shutter,
            blur: if args.shutter > 0.0 {
                motion::of_shutter(&args.render.motion, blur)?
            } else {
                MotionBlur::None
            },
        };
        // A path that cannot be rendered is refused before the first frame, not after many.
        for frame in 0..frames {
            plan.camera(frame)?;
            plan.sub_frames(frame)?;
            plan.motion(frame)?;
        }
        Ok(plan)
    }

    /// Number of frames.
    pub(crate) fn frames(&self) -> u32 {
        self.frames
    }

    /// The camera in the middle of a frame.
    pub(crate) fn camera(&self, frame: u32) -> Result<Camera, Failure> {
        self.at(frame, 0.0)
    }

    /// The cameras of a frame's sub-frames; none where the shutter is open for no time.
    pub(crate) fn sub_frames(&self, frame: u32) -> Result<Vec<Camera>, Failure> {
        let MotionBlur::Subframes { count: count @ 2.. } = self.blur else {
            return Ok(Vec::new());
        };
        (0..count)
            .map(|k| {
                self.at(
                    frame,
                    self.shutter * ((f64::from(k) + 0.5) / f64::from(count) - 0.5),
                )
            })
            .collect()
    }

    /// The camera's motion while the shutter is open, where it blurs footprints.
    pub(crate) fn motion(&self, frame: u32) -> Result<Option<MotionRecipe>, Failure> {
        if !self.blur.moves_footprints() {
            return Ok(None);
        }
        let middle = self.camera(frame)?.projection();
        let half = 0.5 * self.shutter;
        let [opening, closing] = [self.at(frame, -half)?, self.at(frame, half)?];
        if ![opening, closing]
            .iter()
            .all(|camera| is_near(camera.projection(), middle))
        {
            return Err(Failure::usage(format!(
                "the camera zooms at frame {frame}, which blurs no footprint along a motion in space"
            ))
            .hint("--motion-blur subframes can show it"));
        }
        let [opening, closing] = [opening, closing].map(|camera| CameraPose {
            projection: middle,
            ..CameraPose::from(&camera)
        });
        Ok(Some(MotionRecipe::Camera { opening, closing }))
    }

    /// The camera `offset` of the time between frames after the middle of a frame.
    fn at(&self, frame: u32, offset: f64) -> Result<Camera, Failure> {
        let time = (f64::from(frame) + offset) * self.step;
        let time = if self.ease { eased(time) } else { time };
        self.path
            .camera(time)
            .with_context(|| format!("no camera at frame {frame}"))
            .during(Step::Usage)
    }
}

/// Whether two projections are the same but for rounding.
fn is_near(a: Projection, b: Projection) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
    match (a, b) {
        (Projection::Perspective { fov_degrees: a }, Projection::Perspective { fov_degrees: b })
        | (Projection::Orthographic { height: a }, Projection::Orthographic { height: b }) => near(a, b),
        _ => false,
    }
}

/// Smoothstep, in every round of a closed path.
fn eased(time: f64) -> f64 {
    let t = time - time.floor();
    time.floor() + t * t * (3.0 - 2.0 * t)
}

/// Frames that take as long as the keys say.
fn timed(args: &AnimateArgs, times: [Option<f64>; 2], closed: bool) -> Result<u32, Failure> {
    let [Some(first), Some(last)] = times else {
        return Ok(FRAMES);
    };
    let frames = ((last - first) * args.fps).round() + f64::from(u8::from(!closed));
    if !(1.0..=1e6).contains(&frames) {
        return Err(Failure::usage(format!(
            "--path lasts {} s, which are {frames} frames at {} per second",
            last - first,
            args.fps
        ))
        .hint("--frames says how many to make (1 to 1000000)"));
    }
    Ok(frames as u32)
}

fn through(args: &AnimateArgs, keys: &[StoredCameraKey], start: &Camera) -> Result<CameraPath, Failure> {
    let name = args.path.as_deref().unwrap_or(std::path::Path::new("")).display();
    let mut cameras = Vec::with_capacity(keys.len());
    for (i, key) in keys.iter().enumerate() {
        let camera = Camera::new(
            DVec3::from_array(key.position),
            key.target.map_or(start.target(), DVec3::from_array),
            key.up.map_or(start.up(), DVec3::from_array),
            key.projection.unwrap_or(start.projection()),
        );
        cameras.push(CameraKey {
            time: key.time.unwrap_or(i as f64),
            camera: camera
                .with_context(|| format!("{name}: key[{i}] makes no camera"))
                .during(Step::Input)?,
        });
    }
    CameraPath::through(&cameras)
        .with_context(|| format!("{name}: keys make no path"))
        .during(Step::Input)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser;
    use splatvol::Projection;

    fn args(flags: &str) -> AnimateArgs {
        let line = format!("splatvol animate sample:ball -o a.gif {flags}");
        match Cli::parse_from(line.split_whitespace()).command {
            Command::Animate(args) => *args,
            other => panic!("{other:?}"),
        }
    }

    fn start() -> Camera {
        let projection = Projection::Perspective { fov_degrees: 30.0 };
        Camera::new(DVec3::Y, DVec3::ZERO, DVec3::Z, projection).unwrap()
    }

    fn plan(flags: &str) -> Plan {
        Plan::new(&args(flags), None, (&start(), MotionBlur::None))
            .map_err(|failure| format!("{failure:?}"))
            .unwrap()
    }

    /// Degrees turned.
    fn angle(camera: &Camera) -> f64 {
        let position = camera.position();
        (-position.x).atan2(position.y).to_degrees()
    }

    fn angles(plan: &Plan) -> Vec<f64> {
        (0..plan.frames())
            .map(|i| angle(&plan.camera(i).ok().unwrap()))
            .collect()
    }

    fn close(found: &[f64], expected: &[f64]) {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(found.len() == expected.len() && near, "{found:?} {expected:?}");
    }

    #[test]
    fn whole_turns_leave_out_the_end_and_other_angles_show_it() {
        close(&angles(&plan("--frames 4")), &[0.0, 90.0, 180.0, -90.0]);
        close(
            &angles(&plan("--frames 4 --turntable -90")),
            &[0.0, -30.0, -60.0, -90.0],
        );
        close(&angles(&plan("--frames 1 --turntable 90")), &[0.0]);
        assert_eq!(plan("").frames(), 90);
    }

    #[test]
    fn easing_is_smoothstep() {
        let expected = [0.0, 0.15625, 0.5, 0.84375, 1.0].map(|share| 80.0 * share);
        close(&angles(&plan("--frames 5 --turntable 80 --ease")), &expected);
    }

    #[test]
    fn the_shutter_is_open_around_the_frame() {
        let blurred = plan("--frames 36 --shutter 0.5 --subframes 4");
        let seen = |frame| -> Vec<f64> {
            blurred
                .sub_frames(frame)
                .ok()
                .unwrap()
                .iter()
                .map(angle)
                .collect()
        };
        let offsets = [-1.875, -0.625, 0.625, 1.875];
        close(&seen(0), &offsets);
        close(&seen(9), &offsets.map(|offset| 90.0 + offset));
        assert_eq!(plan("").sub_frames(3).ok().unwrap(), []);
    }
}
