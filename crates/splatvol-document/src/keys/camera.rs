//! Keys of the camera.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use splatvol_scene::Projection;

use super::keys;
use super::names::{Fit, ViewName};
use crate::camera::CameraPose;

keys! {
    /// A camera as it is asked for: the table `[camera]`. Whatever is absent is chosen so that all is in view.
    pub struct CameraKeys {
        /// Side to look from. Excludes `position`.
        view: ViewName,
        /// Subject of an automatic camera.
        fit: Fit,
        /// Position of the eye, world.
        position: [f64; 3],
        /// Point looked at, world; the middle of what is shown by default.
        target: [f64; 3],
        /// Direction that is up in the picture, world.
        up: [f64; 3],
        /// Vertical field of view, degrees. Excludes `orthographic`.
        fov: f64,
        /// Parallel projection: world units from top to bottom, or `true` for what fits.
        orthographic: Parallel,
        /// Turn around the target, to the camera's right, degrees.
        azimuth: f64,
        /// Turn over the target, upwards, degrees.
        elevation: f64,
        /// Enlargement of the picture's middle.
        zoom: f64,
    }
}

/// A parallel projection.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a world height, or true for what fits")]
pub enum Parallel {
    /// With this world height.
    Height(f64),
    /// `true`: with a height that fits. `false`: in perspective.
    Fits(bool),
}

impl From<&CameraPose> for CameraKeys {
    fn from(pose: &CameraPose) -> Self {
        let (fov, orthographic) = match pose.projection {
            Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
            Projection::Orthographic { height } => (None, Some(Parallel::Height(height))),
        };
        Self {
            position: Some(pose.position),
            target: Some(pose.target),
            up: Some(pose.up),
            fov,
            orthographic,
            ..Self::default()
        }
    }
}

impl CameraKeys {
    /// These keys over those of another document. A view, a position or a fit replaces an earlier place; offsets
    /// (azimuth, elevation, zoom) and lens apply to it.
    #[must_use]
    pub fn over(self, below: &Self) -> Self {
        let mut below = below.clone();
        let replaced = self.view.is_some() || self.position.is_some() || self.fit.is_some();
        if replaced {
            below.view = below.view.filter(|_| self.position.is_none());
            if below.position.take().is_some() {
                // Of a placed camera, only its lens fits another place.
                below.target = None;
                below.up = None;
                below.orthographic = below.orthographic.map(|_| Parallel::Fits(true));
            }
        }
        if let (Some(Parallel::Fits(true)), false) = (self.orthographic, replaced) {
            // What the perspective picture showed at the target's distance.
            if let Some(height) = below.height_at_target(self.target) {
                below.fov = None;
                below.orthographic = Some(Parallel::Height(height));
                return Self {
                    orthographic: None,
                    ..self
                }
                .or(below);
            }
        }
        if self.fov.is_some() {
            below.orthographic = None;
        }
        if self.orthographic.is_some() {
            below.fov = None;
        }
        self.or(below)
    }

    /// World height of the picture at a target, for a camera that has its place and its lens.
    fn height_at_target(&self, target: Option<[f64; 3]>) -> Option<f64> {
        if let Some(Parallel::Height(height)) = self.orthographic {
            return Some(height);
        }
        let (position, target) = (self.position?, target.or(self.target)?);
        let distance = glam::DVec3::from_array(position).distance(glam::DVec3::from_array(target));
        Some(2.0 * distance * libm::tan((0.5 * self.fov?).to_radians()))
    }
}
