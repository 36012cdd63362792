//! The voxels of a brick by camera depth.
//!
//! Camera depth is affine in the voxel index in both projections, so all bricks of a grid share one order, and the voxels
//! that enter a sheet are a run of it: no sorting, no buckets per frame.

use glam::DMat3;
use splatvol_core::brick::BRICK;
use splatvol_core::visibility::BRICK_VOXELS;

/// Vectors may read this far behind the last voxel.
const PADDING: usize = 16;

/// Offsets from a brick's first voxel in camera space, ascending in depth.
#[derive(Debug, Clone)]
pub(crate) struct DepthOrder {
    /// Index within the brick, x fastest.
    pub voxel: [u16; BRICK_VOXELS + PADDING],
    pub x: [f32; BRICK_VOXELS + PADDING],
    pub y: [f32; BRICK_VOXELS + PADDING],
    /// Beyond the last voxel: infinity.
    pub depth: [f32; BRICK_VOXELS + PADDING],
}

impl DepthOrder {
    /// Order under the linear part of camera from voxel.
    pub(crate) fn new(camera_from_voxel: DMat3) -> Self {
        let offset = |i: usize| {
            let at = [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)];
            camera_from_voxel * glam::DVec3::from_array(at.map(|a| a as f64))
        };
        let mut order: [usize; BRICK_VOXELS] = std::array::from_fn(|i| i);
        order.sort_by(|&a, &b| offset(a).z.total_cmp(&offset(b).z).then(a.cmp(&b)));
        let mut sorted = Self {
            voxel: [0; BRICK_VOXELS + PADDING],
            x: [0.0; BRICK_VOXELS + PADDING],
            y: [0.0; BRICK_VOXELS + PADDING],
            depth: [f32::INFINITY; BRICK_VOXELS + PADDING],
        };
        for (place, &voxel) in order.iter().enumerate() {
            let at = offset(voxel);
            sorted.voxel[place] = voxel as u16;
            (sorted.x[place], sorted.y[place], sorted.depth[place]) = (at.x as f32, at.y as f32, at.z as f32);
        }
        sorted
    }
}
