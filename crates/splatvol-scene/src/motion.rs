//! Motion while the shutter is open.
//!
//! The shutter is open from t = -1/2 to t = 1/2; the scene and the camera of a frame are those of its middle,
//! `t = 0`. As in mueller1998 section 5, every voxel moves linearly: at the time t a voxel at x is at `x + t d(x)`,
//! with d its displacement while the shutter is open. A spin by the angle a about the axis n (unit) through c has,
//! to first order at the middle, `d = a n x (x - c)`; a camera that moves from C0 to C1 displaces a voxel in camera
//! space by `C1 x - C0 x`. Sub-frames need no such approximation: there, the spin is a rotation.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::{Camera, CameraKey, CameraPath, Content, SceneError, Volume, rotation};

/// Motion while the shutter is open, world space.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a scene has one")]
pub enum Motion {
    /// The volume moves by this.
    Linear(DVec3),
    /// The volume spins.
    Spin {
        /// Axis, any length but 0; positive angles are counter-clockwise seen from its tip.
        axis: DVec3,
        /// A point of the axis.
        centre: DVec3,
        /// Angle from opening to closing, radians.
        angle: f64,
    },
    /// The camera moves past the camera of the frame, which is that of the shutter's middle.
    Camera {
        /// Camera when the shutter opens.
        opening: Camera,
        /// Camera when the shutter closes.
        closing: Camera,
    },
    /// Every voxel moves by a vector of its own, in the order of the samples (x fastest).
    Field(Arc<[[f32; 3]]>),
}

impl Motion {
    /// Checks the motion, and that it fits what moves.
    ///
    /// # Errors
    /// Numbers that are not finite, an axis of no length, cameras of different projections, or a field that is not one
    /// vector for each sample of a volume.
    pub fn validate(&self, content: &Content) -> Result<(), SceneError> {
        match self {
            Self::Linear(displacement) if !displacement.is_finite() => Err(SceneError::invalid(
                "velocity",
                displacement.to_array(),
                "finite numbers",
            )),
            Self::Spin { axis, .. } if axis.try_normalize().is_none() => Err(SceneError::invalid(
                "spin axis",
                axis.to_array(),
                "finite, and not zero",
            )),
            Self::Spin { centre, .. } if !centre.is_finite() => Err(SceneError::invalid(
                "spin centre",
                centre.to_array(),
                "finite numbers",
            )),
            Self::Spin { angle, .. } if !angle.is_finite() => {
                Err(SceneError::invalid("spin angle", angle, "a finite number"))
            }
            Self::Camera { opening, closing } if opening.projection() != closing.projection() => {
                Err(SceneError::invalid(
                    "closing camera's projection",
                    closing.projection(),
                    "the opening camera's: zooming has no motion in space",
                ))
            }
            Self::Field(vectors) => match content {
                Content::Volume { volume, .. } => field_is_valid(vectors, volume),
                _ => Err(SceneError::invalid(
                    "motion",
                    "a field",
                    "a displacement, a spin or a camera: only the voxels of a volume move by vectors of their own",
                )),
            },
            _ => Ok(()),
        }
    }

    /// Displacements in camera space of points in the world, for motions that are the same map for all; `None` for a
    /// field.
    pub fn camera_displacement(&self, camera_from_world: DAffine3) -> Option<DAffine3> {
        let of_world = |linear: DMat3, constant: DVec3| {
            let rotation = camera_from_world.matrix3;
            DAffine3::from_mat3_translation(rotation * linear, rotation * constant)
        };
        match self {
            Self::Linear(displacement) => Some(of_world(DMat3::ZERO, *displacement)),
            Self::Spin { axis, centre, angle } => {
                let n = axis.normalize_or_zero() * *angle;
                let cross = DMat3::from_cols(n.cross(DVec3::X), n.cross(DVec3::Y), n.cross(DVec3::Z));
                Some(of_world(cross, -(cross * *centre)))
            }
            Self::Camera { opening, closing } => {
                let [from, to] = [opening, closing].map(Camera::camera_from_world);
                Some(DAffine3::from_mat3_translation(
                    to.matrix3 - from.matrix3,
                    to.translation - from.translation,
                ))
            }
            Self::Field(_) => None,
        }
    }

    /// The map that brings an item to its place at a time from -1/2 to 1/2, world.
    ///
    /// # Errors
    /// Motions of the camera, and of single voxels.
    pub fn world_at(&self, time: f64) -> Result<DAffine3, SceneError> {
        match self {
            Self::Linear(displacement) => Ok(DAffine3::from_translation(time * *displacement)),
            Self::Spin { axis, centre, angle } => {
                let turn = DAffine3::from_quat(rotation::about(axis.normalize_or(DVec3::Z), time * angle));
                Ok(DAffine3::from_translation(*centre) * turn * DAffine3::from_translation(-*centre))
            }
            Self::Camera { .. } => Err(SceneError::invalid(
                "motion",
                "the camera's, of some items",
                "of all items: what a moving camera sees moves as a whole",
            )),
            Self::Field(_) => Err(only_whole_volumes()),
        }
    }

    /// The cameras that see the volume at rest as `camera` sees it move: `count` of them, each in the middle of its
    /// share of the time. The path of a camera in motion is the parabola through its opening, its middle and its
    /// closing.
    ///
    /// # Errors
    /// A field, whose voxels no camera can follow; a camera that passes its target.
    pub fn cameras(&self, camera: &Camera, count: u32) -> Result<Vec<Camera>, SceneError> {
        let times = (0..count).map(|k| (f64::from(k) + 0.5) / f64::from(count) - 0.5);
        match self {
            Self::Linear(displacement) => times
                .map(|t| moved(camera, |point| point - t * *displacement, DQuat::IDENTITY))
                .collect(),
            Self::Spin { axis, centre, angle } => times
                .map(|t| {
                    let turn = rotation::about(axis.normalize_or(DVec3::Z), -t * angle);
                    moved(camera, |point| *centre + turn * (point - *centre), turn)
                })
                .collect(),
            Self::Camera { opening, closing } => {
                let key = |time, camera: &Camera| CameraKey {
                    time,
                    camera: *camera,
                };
                let path = CameraPath::through(&[key(0.0, opening), key(0.5, camera), key(1.0, closing)])?;
                times.map(|t| path.camera(t + 0.5)).collect()
            }
            Self::Field(_) => Err(only_whole_volumes()),
        }
    }
}

fn only_whole_volumes() -> SceneError {
    SceneError::invalid(
        "motion blur",
        "subframes",
        "exact or capsule: sub-frames move volumes and cameras, not single voxels",
    )
}

fn moved(camera: &Camera, place: impl Fn(DVec3) -> DVec3, turn: DQuat) -> Result<Camera, SceneError> {
    Camera::new(
        place(camera.position()),
        place(camera.target()),
        turn * camera.up(),
        camera.projection(),
    )
}

fn field_is_valid(vectors: &[[f32; 3]], volume: &Volume) -> Result<(), SceneError> {
    if vectors.len() != volume.grid().sample_count() {
        return Err(SceneError::SampleCount {
            dims: volume.grid().dims(),
            expected: volume.grid().sample_count(),
            found: vectors.len(),
        });
    }
    match vectors.iter().find(|v| v.iter().any(|c| !c.is_finite())) {
        Some(vector) => Err(SceneError::invalid("motion field", vector, "finite numbers")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, LengthUnit, Projection, Rescale, Samples};

    fn camera() -> Camera {
        let projection = Projection::Perspective { fov_degrees: 40.0 };
        Camera::new(DVec3::new(1.0, 9.0, 2.0), DVec3::ZERO, DVec3::Z, projection).unwrap()
    }

    fn spin(angle: f64) -> Motion {
        Motion::Spin {
            axis: DVec3::new(0.0, 2.0, 1.0),
            centre: DVec3::new(0.5, -1.0, 0.0),
            angle,
        }
    }

    /// To first order, a point moves between the sub-frames' cameras by its displacement.
    #[test]
    fn displacements_are_the_first_order_of_the_sub_frames() {
        let angle = 1e-3;
        let later = Motion::Spin {
            axis: DVec3::Z,
            centre: DVec3::ZERO,
            angle: 0.5 * angle,
        };
        let moving = Motion::Camera {
            opening: later.cameras(&camera(), 2).unwrap()[0],
            closing: later.cameras(&camera(), 2).unwrap()[1],
        };
        let point = DVec3::new(2.0, 1.0, -0.7);
        for motion in [Motion::Linear(DVec3::new(0.3, -0.2, 0.9)), spin(angle), moving] {
            // The first of 50 and the last are 49/50 of the time apart.
            let cameras = motion.cameras(&camera(), 50).unwrap();
            let [first, last] =
                [cameras[0], cameras[49]].map(|c| c.camera_from_world().transform_point3(point));
            let found = (last - first) * 50.0 / 49.0;
            let displacement = motion.camera_displacement(camera().camera_from_world()).unwrap();
            let expected = displacement.transform_point3(point);
            assert!(
                (found - expected).length() < 1e-6,
                "{motion:?}: {found} {expected}"
            );
            assert!(expected.length() > 1e-4);
        }
    }

    /// A volume that moves is seen as the volume at rest from the cameras of the sub-frames.
    #[test]
    fn items_move_against_the_cameras() {
        let point = DVec3::new(2.0, 1.0, -0.7);
        for motion in [Motion::Linear(DVec3::new(0.3, -0.2, 0.9)), spin(0.8)] {
            let cameras = motion.cameras(&camera(), 5).unwrap();
            for (k, seen_from) in cameras.iter().enumerate() {
                let place = motion.world_at((k as f64 + 0.5) / 5.0 - 0.5).unwrap();
                let moved = camera().camera_from_world() * place;
                let expected = moved.transform_point3(point);
                let found = seen_from.camera_from_world().transform_point3(point);
                assert!(
                    (found - expected).length() < 1e-12,
                    "{motion:?}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let grid = Grid::new([2; 3], DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY).unwrap();
        let samples = Samples::F32((0..8).map(|i| i as f32).collect());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let color = vec![crate::ColorPoint::new(0.0, [1.0; 3])];
        let opacity = vec![crate::OpacityPoint::new(0.0, 1.0)];
        let look = crate::TransferFunction::new(color, opacity, None).unwrap();
        let content = crate::Item::volume(volume, look).content;
        let error = |motion: Motion| motion.validate(&content).unwrap_err().to_string();
        assert!(error(Motion::Linear(DVec3::NAN)).starts_with("velocity"));
        assert!(error(spin(f64::INFINITY)).starts_with("spin angle"));
        assert!(error(Motion::Field(vec![[0.0; 3]; 7].into())).contains("found 7"));
        assert!(error(Motion::Field(vec![[f32::NAN; 3]; 8].into())).starts_with("motion field"));
        let still = Motion::Field(vec![[0.0; 3]; 8].into());
        assert!(still.validate(&content).is_ok() && still.cameras(&camera(), 4).is_err());
    }
}
