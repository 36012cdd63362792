//! Depth order of the voxels of a brick.
//!
//! Camera depth is affine in the voxel index in both projections. So all bricks of a grid share one order, and the
//! voxels that enter a sheet are a run of it: a frame needs no sorting and no buckets.

use glam::DMat3;

use crate::brick::BRICK;
use crate::visibility::BRICK_VOXELS;

/// Vectors may read this far behind the last voxel.
const PADDING: usize = 16;

/// Offsets from a brick's first voxel in camera space, ascending in depth.
#[derive(Debug, Clone)]
pub struct DepthOrder {
    /// Index within the brick, x fastest.
    pub voxel: [u16; BRICK_VOXELS + PADDING],
    /// Camera space, world length.
    pub x: [f32; BRICK_VOXELS + PADDING],
    /// Camera space, world length.
    pub y: [f32; BRICK_VOXELS + PADDING],
    /// Beyond the last voxel: infinity.
    pub depth: [f32; BRICK_VOXELS + PADDING],
}

impl DepthOrder {
    /// Order under the linear part of camera from voxel.
    pub fn update(&mut self, camera_from_voxel: DMat3) {
        let offset = |i: usize| {
            let at = [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)];
            camera_from_voxel * glam::DVec3::from_array(at.map(|a| a as f64))
        };
        let mut order: [(f64, u16); BRICK_VOXELS] = std::array::from_fn(|i| (offset(i).z, i as u16));
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (place, &(depth, voxel)) in order.iter().enumerate() {
            let at = offset(usize::from(voxel));
            self.voxel[place] = voxel;
            (self.x[place], self.y[place], self.depth[place]) = (at.x as f32, at.y as f32, depth as f32);
        }
    }
}

impl Default for DepthOrder {
    fn default() -> Self {
        Self {
            voxel: [0; BRICK_VOXELS + PADDING],
            x: [0.0; BRICK_VOXELS + PADDING],
            y: [0.0; BRICK_VOXELS + PADDING],
            depth: [f32::INFINITY; BRICK_VOXELS + PADDING],
        }
    }
}
