//! Which cameras see which frame.
//!
//! Frame i of N is in the middle of its time: at `t = i / N` on a closed path, whose end would repeat its first
//! frame, and at `t = i / (N - 1)` on an open one, which shows both ends. The shutter, open for the share S of the
//! time between frames, sees the n sub-frames at `t + (S (k + 1/2) / n - S/2) / N`, k from 0; footprints in motion
//! move as between the cameras at `t -+ S / (2 N)`.

use glam::DVec3;
use splatvol_scene::{Camera, CameraKey, CameraPath, MotionBlur, Projection, SceneError};

use crate::camera::CameraPose;
use crate::input::Reading;
use crate::keys::{AnimationKeys, CameraFrame, CameraSweep, MotionKeys};
use crate::motion::{self, named_blur};
use crate::{Document, DocumentError, files};

/// Frames unless asked otherwise.
pub const FRAMES: u32 = 90;
/// Frames per second unless asked otherwise.
const RATE: f64 = 30.0;
/// Frames at most.
const MOST: f64 = 1e6;

/// When the pictures are taken, and from where.
#[derive(Debug, Clone)]
pub struct Plan {
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

impl AnimationKeys {
    /// The same, with the key frames of its file.
    ///
    /// # Errors
    /// Files that cannot be read; keys outside their domain, by name.
    pub fn loaded(&self, reading: Reading<'_>) -> Result<Self, DocumentError> {
        self.check()?;
        let Some(path) = &self.path else {
            return Ok(self.clone());
        };
        let keys = files::read_camera_keys(reading.locate(path))?;
        let keys = keys.into_iter().map(|key| CameraFrame {
            time: key.time,
            position: key.position,
            target: key.target,
            up: key.up,
            fov: match key.projection {
                Some(Projection::Perspective { fov_degrees }) => Some(fov_degrees),
                _ => None,
            },
            height: match key.projection {
                Some(Projection::Orthographic { height }) => Some(height),
                _ => None,
            },
        });
        Ok(Self {
            keys: Some(keys.collect()),
            ..self.clone()
        })
    }

    fn check(&self) -> Result<(), DocumentError> {
        let refused = |key: &str, value: &dyn std::fmt::Debug, expected: &str| {
            let why = format!("{value:?}: expected {expected}");
            Err(DocumentError::refused(&format!("animation.{key}"), why))
        };
        if self.turntable.is_some() && (self.path.is_some() || self.keys.is_some()) {
            return refused("turntable", &self.turntable, "none, where there are key frames");
        }
        if self.path.is_some() && self.keys.is_some() {
            return refused("path", &self.path, "none, where there are key frames");
        }
        if self.keys.as_ref().is_some_and(|keys| keys.len() < 2) {
            return refused("key", &self.keys, "at least two key frames");
        }
        if self.fps.is_some_and(|rate| !(0.01..=1000.0).contains(&rate)) {
            return refused("fps", &self.fps, "frames per second, 0.01 to 1000");
        }
        if self.shutter.is_some_and(|share| !(0.0..=1.0).contains(&share)) {
            return refused("shutter", &self.shutter, "a share from 0 to 1");
        }
        if self
            .frames
            .is_some_and(|frames| frames == 0 || f64::from(frames) > MOST)
        {
            return refused("frames", &self.frames, "1 to 1000000");
        }
        Ok(())
    }

    /// Whether the camera turns around its target.
    pub fn turns(&self) -> bool {
        self.path.is_none() && self.keys.is_none()
    }

    /// Whether the shutter is open for some time.
    pub fn has_shutter(&self) -> bool {
        self.shutter.is_some_and(|share| share > 0.0)
    }

    /// Frames per second.
    pub fn rate(&self) -> f64 {
        self.fps.unwrap_or(RATE)
    }
}

impl CameraFrame {
    /// The key frame's camera; what it leaves out is that of `start`.
    ///
    /// # Errors
    /// See [`Camera::new`].
    pub fn camera(&self, start: &Camera) -> Result<Camera, SceneError> {
        let projection = match (self.fov, self.height) {
            (Some(fov_degrees), _) => Projection::Perspective { fov_degrees },
            (None, Some(height)) => Projection::Orthographic { height },
            (None, None) => start.projection(),
        };
        Camera::new(
            DVec3::from_array(self.position),
            self.target.map_or(start.target(), DVec3::from_array),
            self.up.map_or(start.up(), DVec3::from_array),
            projection,
        )
    }
}

impl From<&Camera> for CameraFrame {
    /// A key frame that leaves out nothing but its time.
    fn from(camera: &Camera) -> Self {
        let (fov, height) = match camera.projection() {
            Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
            Projection::Orthographic { height } => (None, Some(height)),
        };
        Self {
            time: None,
            position: camera.position().to_array(),
            target: Some(camera.target().to_array()),
            up: Some(camera.up().to_array()),
            fov,
            height,
        }
    }
}

impl Plan {
    /// For key frames that have been read ([`AnimationKeys::loaded`]), or for a turntable that starts at the camera
    /// `start`, which also gives what key frames leave out. `blur` is how footprints are blurred.
    ///
    /// # Errors
    /// Key frames that do not make a path or a camera; a path with a frame that cannot be rendered.
    pub fn new(
        keys: &AnimationKeys,
        motion: &MotionKeys,
        (start, blur): (&Camera, MotionBlur),
    ) -> Result<Self, DocumentError> {
        let path = match &keys.keys {
            None => CameraPath::turntable(*start, keys.turntable.unwrap_or(360.0))?,
            Some(frames) => through(keys, frames, start)?,
        };
        let frames = match (keys.frames, keys.keys.as_deref()) {
            (Some(frames), _) => frames,
            (None, Some([first, .., last])) => timed(keys, [first.time, last.time], path.is_closed())?,
            (None, _) => FRAMES,
        };
        let steps = if path.is_closed() { frames } else { frames - 1 };
        let plan = Self {
            path,
            frames,
            step: 1.0 / f64::from(steps.max(1)),
            ease: keys.ease == Some(true),
            shutter: keys.shutter.unwrap_or(0.0),
            blur: match keys.has_shutter() {
                true => motion::of_shutter(motion, blur)?,
                false => MotionBlur::None,
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

    /// The document of a frame, from that of all.
    ///
    /// # Errors
    /// See [`Plan::new`].
    pub fn document(&self, all: &Document, frame: u32) -> Result<Document, DocumentError> {
        let sub_frames = self.sub_frames(frame)?;
        let sub_frames: Vec<_> = sub_frames.iter().map(CameraPose::from).collect();
        let motion = match self.motion(frame)? {
            None => all.motion.clone(),
            Some(sweep) => MotionKeys {
                camera: Some(sweep),
                motion_blur: Some(named_blur(self.blur).0),
                ..MotionKeys::default()
            },
        };
        Ok(Document {
            camera: (&CameraPose::from(&self.camera(frame)?)).into(),
            motion: MotionKeys {
                sub_frames: (!sub_frames.is_empty()).then_some(sub_frames),
                ..motion
            },
            ..all.clone()
        })
    }

    /// Number of frames.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The camera in the middle of a frame.
    pub fn camera(&self, frame: u32) -> Result<Camera, DocumentError> {
        self.at(frame, 0.0)
    }

    /// The cameras of a frame's sub-frames; none if the shutter is open for no time.
    pub fn sub_frames(&self, frame: u32) -> Result<Vec<Camera>, DocumentError> {
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

    /// The camera's motion while the shutter is open, if it blurs footprints.
    pub fn motion(&self, frame: u32) -> Result<Option<CameraSweep>, DocumentError> {
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
            let why = format!(
                "the camera zooms at frame {frame}, which blurs no footprint along a motion in space"
            );
            return Err(DocumentError::usage(why).hinting("--motion-blur subframes can show it"));
        }
        let [opening, closing] = [opening, closing].map(|camera| CameraPose {
            projection: middle,
            ..CameraPose::from(&camera)
        });
        Ok(Some(CameraSweep { opening, closing }))
    }

    /// The camera `offset` of the time between frames after the middle of a frame.
    fn at(&self, frame: u32, offset: f64) -> Result<Camera, DocumentError> {
        let time = (f64::from(frame) + offset) * self.step;
        let time = if self.ease { eased(time) } else { time };
        let camera = self.path.camera(time);
        camera.map_err(|error| DocumentError::usage(format!("no camera at frame {frame}: {error}")))
    }
}

/// Whether two projections are the same except for rounding.
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
fn timed(keys: &AnimationKeys, times: [Option<f64>; 2], closed: bool) -> Result<u32, DocumentError> {
    let [Some(first), Some(last)] = times else {
        return Ok(FRAMES);
    };
    let rate = keys.rate();
    let frames = ((last - first) * rate).round() + f64::from(u8::from(!closed));
    if !(1.0..=MOST).contains(&frames) {
        let lasts = last - first;
        let why = format!("lasts {lasts} s, which are {frames} frames at {rate} per second");
        return Err(DocumentError::refused("animation.path", why)
            .hinting("--frames says how many to make (1 to 1000000)"));
    }
    Ok(frames as u32)
}

fn through(
    keys: &AnimationKeys,
    frames: &[CameraFrame],
    start: &Camera,
) -> Result<CameraPath, DocumentError> {
    let refused = |what: String, error: SceneError| {
        let message = format!("{what}: {error}");
        match &keys.path {
            Some(path) => DocumentError::Malformed {
                path: path.into(),
                message,
            },
            None => DocumentError::usage(message),
        }
    };
    let mut cameras = Vec::with_capacity(frames.len());
    for (i, frame) in frames.iter().enumerate() {
        let camera = frame.camera(start);
        cameras.push(CameraKey {
            time: frame.time.unwrap_or(i as f64),
            camera: camera.map_err(|error| refused(format!("key[{i}] makes no camera"), error))?,
        });
    }
    CameraPath::through(&cameras).map_err(|error| refused("keys make no path".to_owned(), error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> Camera {
        let projection = Projection::Perspective { fov_degrees: 30.0 };
        Camera::new(DVec3::Y, DVec3::ZERO, DVec3::Z, projection).unwrap()
    }

    fn turntable(frames: u32) -> AnimationKeys {
        AnimationKeys {
            frames: Some(frames),
            ..AnimationKeys::default()
        }
    }

    fn plan(keys: &AnimationKeys) -> Plan {
        let motion = MotionKeys {
            subframes: keys.shutter.map(|_| 4),
            ..MotionKeys::default()
        };
        Plan::new(keys, &motion, (&start(), MotionBlur::None)).unwrap()
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
        close(&angles(&plan(&turntable(4))), &[0.0, 90.0, 180.0, -90.0]);
        close(
            &angles(&plan(&AnimationKeys {
                turntable: Some(-90.0),
                ..turntable(4)
            })),
            &[0.0, -30.0, -60.0, -90.0],
        );
        close(
            &angles(&plan(&AnimationKeys {
                turntable: Some(90.0),
                ..turntable(1)
            })),
            &[0.0],
        );
        assert_eq!(plan(&AnimationKeys::default()).frames(), 90);
    }

    #[test]
    fn easing_is_smoothstep() {
        let expected = [0.0, 0.15625, 0.5, 0.84375, 1.0].map(|share| 80.0 * share);
        close(
            &angles(&plan(&AnimationKeys {
                turntable: Some(80.0),
                ease: Some(true),
                ..turntable(5)
            })),
            &expected,
        );
    }

    #[test]
    fn the_shutter_is_open_around_the_frame() {
        let blurred = plan(&AnimationKeys {
            shutter: Some(0.5),
            ..turntable(36)
        });
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
        assert_eq!(plan(&AnimationKeys::default()).sub_frames(3).ok().unwrap(), []);
    }
}
