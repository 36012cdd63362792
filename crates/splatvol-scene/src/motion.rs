//! What moves while the shutter is open.
//!
//! The shutter is open from t = -1/2 to t = 1/2; the scene and the camera of a frame are those of its middle, t = 0. As in
//! mueller1998 section 5 every voxel moves linearly: at the time t a voxel at x is at `x + t d(x)`, d being its
//! displacement while the shutter is open. A spin by the angle a about the axis n (unit) through c has, to first order
//! at the middle, `d = a n x (x - c)`; a camera that moves from C0 to C1 displaces a voxel in camera space by
//! `C1 x - C0 x`. Sub-frames need no such approximation: there, the spin is a rotation.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::{Camera, CameraKey, CameraPath, SceneError, Volume, rotation};

/// What moves while the shutter is open, world space.
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
        /// Where it is when the shutter opens.
        opening: Camera,
        /// Where it is when the shutter closes.
        closing: Camera,
    },
    /// Every voxel moves by a vector of its own, in the order of the samples (x fastest).
    Field(Arc<[[f32; 3]]>),
}

impl Motion {
    /// Checks the motion, and that it fits a volume.
    ///
    /// # Errors
    /// Numbers that are not finite, an axis of no length, cameras of different projections, or a field of another size
    /// than the volume.
    pub fn validate(&self, volume: &Volume) -> Result<(), SceneError> {
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
            Self::Field(vectors) => field_is_valid(vectors, volume),
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

    /// The cameras that see the volume at rest as `camera` sees it move: `count` of them, each in the middle of its share
    /// of the time. The path of a camera in motion is the parabola through its opening, its middle and its closing.
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
            Self::Field(_) => Err(SceneError::invalid(
                "motion blur",
                "subframes",
                "exact or capsule: sub-frames move volumes and cameras, not single voxels",
            )),
        }
    }
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

    /// What the sub-frames' cameras see moves as the displacements say.
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

    #[test]
    fn nonsense_is_refused_by_name() {
        let grid = Grid::new([2; 3], DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY).unwrap();
        let samples = Samples::F32((0..8).map(|i| i as f32).collect());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let error = |motion: Motion| motion.validate(&volume).unwrap_err().to_string();
        assert!(error(Motion::Linear(DVec3::NAN)).starts_with("velocity"));
        assert!(error(spin(f64::INFINITY)).starts_with("spin angle"));
        assert!(error(Motion::Field(vec![[0.0; 3]; 7].into())).contains("found 7"));
        assert!(error(Motion::Field(vec![[f32::NAN; 3]; 8].into())).starts_with("motion field"));
        let still = Motion::Field(vec![[0.0; 3]; 8].into());
        assert!(still.validate(&volume).is_ok() && still.cameras(&camera(), 4).is_err());
    }
}
