//! Keys of an animation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::keys;

keys! {
    /// Motion of the camera from frame to frame: the table `[animation]`.
    pub struct AnimationKeys {
        /// Angle by which the camera turns around its target in all, degrees; 360 by default. Excludes a path.
        turntable: f64,
        /// Key frames: a file.
        path: String,
        /// Key frames, at least two.
        #[serde(rename = "key")]
        keys: Vec<CameraFrame>,
        /// Number of frames.
        frames: u32,
        /// Frames per second.
        fps: f64,
        /// Whether it starts and stops gently.
        ease: bool,
        /// Share of a frame's time that the shutter is open, 0..1.
        shutter: f64,
    }
}

/// A key frame; absent keys are the camera's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CameraFrame {
    /// Seconds; all key frames have it, or none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Position of the eye, world.
    pub position: [f64; 3],
    /// Point looked at, world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Direction that is up in the picture, world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Vertical field of view, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
    /// World height of a parallel projection; excludes `fov`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
}

impl AnimationKeys {
    /// These keys over those of another document: ways of the camera replace each other.
    #[must_use]
    pub fn over(self, below: &Self) -> Self {
        let mut below = below.clone();
        if self.turntable.is_some() || self.path.is_some() || self.keys.is_some() {
            below.turntable = None;
            below.path = None;
            below.keys = None;
        }
        self.or(below)
    }
}
