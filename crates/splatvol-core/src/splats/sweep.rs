//! Displacements of a cloud's splats while the shutter is open, and their effect on footprints.

use glam::{Affine3A, Mat3, Vec2, Vec3};
use splatvol_scene::Motion;
use std::sync::Arc;

use super::cloud::{Chunk, SplatCloud};
use super::footprint::{Footprint, Warp};
use super::moving::{Moving, Path, whitening};
use super::projection::CameraView;
use super::ray::Trapezoid;

/// Motion of a cloud's splats in camera space.
#[derive(Debug, Clone)]
pub(super) struct Sweep {
    displacements: Displacements,
    capsule: bool,
    /// Greatest displacement in depth of any splat, world length.
    pub(super) depth_change: f32,
}

#[derive(Debug, Clone)]
enum Displacements {
    /// One map for all: camera space from local space.
    Map(Affine3A),
    /// A vector per voxel of a grid of this size, world.
    Field {
        vectors: Arc<[[f32; 3]]>,
        dims: [usize; 3],
        camera_from_world: Mat3,
    },
}

impl Sweep {
    /// For a cloud whose local space is a grid of `dims` voxels.
    pub(super) fn new(
        motion: &Motion,
        (cloud, dims): (&SplatCloud, [usize; 3]),
        view: &CameraView,
        capsule: bool,
    ) -> Self {
        let displacements = match (motion, motion.camera_displacement(view.camera_from_world)) {
            (_, Some(map)) => {
                let map = map * cloud.world_from_local;
                Displacements::Map(Affine3A::from_mat3_translation(
                    map.matrix3.as_mat3(),
                    map.translation.as_vec3(),
                ))
            }
            (Motion::Field(vectors), None) => Displacements::Field {
                vectors: Arc::clone(vectors),
                dims,
                camera_from_world: view.camera_from_world.matrix3.as_mat3(),
            },
            (_, None) => Displacements::Map(Affine3A::from_mat3(Mat3::ZERO)),
        };
        let mut sweep = Self {
            displacements,
            capsule,
            depth_change: 0.0,
        };
        for chunk in &cloud.chunks {
            let (low, high) = sweep.extremes(cloud, chunk);
            sweep.depth_change = sweep.depth_change.max(-low.z).max(high.z);
        }
        sweep
    }

    /// Displacement of a splat at a local position, camera space.
    #[inline(always)]
    pub(super) fn displacement(&self, local: [f32; 3]) -> Vec3 {
        match &self.displacements {
            Displacements::Map(map) => map.transform_point3(Vec3::from_array(local)),
            Displacements::Field {
                vectors,
                dims,
                camera_from_world,
            } => {
                let [x, y, z] = local.map(|at| at.round().max(0.0) as usize);
                let index = (z * dims[1] + y) * dims[0] + x;
                let vector = vectors.get(index).copied().unwrap_or_default();
                *camera_from_world * Vec3::from_array(vector)
            }
        }
    }

    /// Least and greatest displacement along each axis of a chunk's splats, camera space.
    pub(super) fn extremes(&self, cloud: &SplatCloud, chunk: &Chunk) -> (Vec3, Vec3) {
        let bounds = |(low, high): (Vec3, Vec3), local: [f32; 3]| {
            let displacement = self.displacement(local);
            (low.min(displacement), high.max(displacement))
        };
        let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        match self.displacements {
            // The map is affine, so its extremes are in corners.
            Displacements::Map(_) => chunk.corners().into_iter().fold(nothing, bounds),
            Displacements::Field { .. } => {
                let splats = chunk.first as usize..chunk.end as usize;
                cloud.positions[splats].iter().copied().fold(nothing, bounds)
            }
        }
    }

    /// The footprint of a splat in motion, from its footprint in the shutter's middle. `cut`: the profile's radius,
    /// standard deviations; `scale`: pixels per world length; `ray`: x and y per depth of the centre's ray. The bounds
    /// are those of affine footprints.
    #[inline(always)]
    pub(super) fn blur(
        &self,
        (still, cut): (Footprint, f32),
        displacement: Vec3,
        (scale, ray): (f32, Vec2),
    ) -> Footprint {
        let moved = (displacement.truncate() - ray * displacement.z) * scale;
        let path = match still.warp {
            Warp::Affine { conic, slope } => {
                let [a, b, c] = whitening(conic);
                Path::Affine {
                    whitening: [a, b, c],
                    slope,
                    displacement: [a * moved.x + b * moved.y, c * moved.y],
                    depth_change: displacement.z - slope[0] * moved.x - slope[1] * moved.y,
                }
            }
            Warp::Ray(ray) | Warp::Perpendicular(ray) | Warp::Trapezoid(Trapezoid { ray, .. }) => Path::Ray {
                ray,
                displacement: ray.whitened(displacement.to_array()),
            },
            Warp::Moving(moving) => moving.path,
        };
        let ([x0, y0, x1, y1], half) = (still.bounds, 0.5 * moved.abs());
        let moving = Moving {
            path,
            capsule: self.capsule,
        };
        let mut footprint = Footprint {
            bounds: [x0 - half.x, y0 - half.y, x1 + half.x, y1 + half.y],
            warp: Warp::Moving(moving),
            ..still
        };
        if self.capsule {
            let dimmed = Moving::dimmed(footprint.passage(&moving, footprint.centre).length, cut);
            footprint.weight *= dimmed;
            footprint.opacity *= dimmed;
        }
        footprint
    }
}
