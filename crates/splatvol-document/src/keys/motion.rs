//! Keys of motion while the shutter is open, and of its blur.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::keys;
use super::names::MotionBlurName;
use crate::camera::CameraPose;

keys! {
    /// Motion while the shutter is open, and its blur: the table `[motion]`.
    pub struct MotionKeys {
        /// Angle by which everything spins, degrees.
        spin: f64,
        /// Axis of the spin, world; the camera's up by default.
        spin_axis: [f64; 3],
        /// Centre of the spin, world; that of everything by default.
        spin_centre: [f64; 3],
        /// Way that everything moves, world lengths.
        velocity: [f64; 3],
        /// Motion of the camera, as an animation made it.
        camera: CameraSweep,
        /// How motion is blurred.
        motion_blur: MotionBlurName,
        /// Number of pictures averaged by `motion-blur = "subframes"`.
        subframes: u32,
        /// Cameras of the pictures of which this is the mean, as an animation made them.
        sub_frames: Vec<CameraPose>,
    }
}

/// A camera that moves from one pose to another while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CameraSweep {
    /// As the shutter opens.
    pub opening: CameraPose,
    /// As it closes.
    pub closing: CameraPose,
}

impl MotionKeys {
    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        self.spin.is_some() || self.velocity.is_some() || self.camera.is_some()
    }

    /// These keys over those of another document, whose picture may have the same camera and show the same things. A
    /// motion replaces another one; another camera has no motion of its own; other data spin about their own centre.
    #[must_use]
    pub fn over(self, below: &Self, same_camera: bool, same_items: bool) -> Self {
        let mut below = below.clone();
        if !(same_camera && self.is_empty()) {
            below.sub_frames = None;
        }
        if !same_camera && below.camera.take().is_some() && !below.moves() {
            below.motion_blur = None;
            below.subframes = None;
        }
        if !same_items {
            below.spin_axis = None;
            below.spin_centre = None;
        }
        if self.moves() {
            // A new motion is meant to be seen.
            below = Self {
                motion_blur: below.motion_blur.filter(|name| *name != MotionBlurName::None),
                subframes: below.subframes,
                ..Self::default()
            };
        }
        if self
            .motion_blur
            .is_some_and(|name| name != MotionBlurName::Subframes)
        {
            below.subframes = None;
        }
        if self.subframes.is_some() && self.motion_blur.is_none() {
            below.motion_blur = None;
        }
        self.or(below)
    }
}
