//! Activate: a brick's voxels into camera space, those that can touch the tile.

use glam::{DVec3, Vec3};
use splatvol_core::bin::TileRect;
use splatvol_core::brick::{ActiveBrick, BLOCK};

use crate::plan::FramePlan;

/// A voxel whose footprint reaches the current sheet or later ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OpenVoxel<T> {
    /// Centre, camera space.
    pub centre: [f32; 3],
    /// What it splats.
    pub payload: T,
}

/// Appends the voxels of a brick whose footprints can touch the tile and for which `payload(index, [x, y, z])` has
/// something to splat; by index, x fastest.
#[inline(always)]
pub(crate) fn activate<T>(
    plan: &FramePlan<'_>,
    rect: &TileRect,
    active: ActiveBrick,
    open: &mut Vec<OpenVoxel<T>>,
    payload: impl Fn(usize, [usize; 3]) -> Option<T>,
) {
    let ([x0, y0, z0], [x1, y1, z1]) = plan.bricks.voxel_box(active.brick as usize);
    let [nx, ny, _] = plan.bricks.voxels;
    let map = plan.projector.camera_from_voxel;
    let corner = map
        .transform_point3(DVec3::new(x0 as f64, y0 as f64, z0 as f64))
        .as_vec3();
    let axes = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|axis| axis.as_vec3());
    for z in z0..z1 {
        for y in y0..y1 {
            let row = corner + axes[1] * (y - y0) as f32 + axes[2] * (z - z0) as f32;
            let start = (z * ny + y) * nx;
            let blocks = active.blocks >> ((y - y0) / BLOCK * 2 + (z - z0) / BLOCK * 4);
            for x in x0..x1 {
                let centre = row + axes[0] * (x - x0) as f32;
                let culled = blocks >> ((x - x0) / BLOCK) & 1 == 0;
                if culled || !plan.window.touches(centre, rect) {
                    continue;
                }
                if let Some(payload) = payload(start + x, [x, y, z]) {
                    open.push(OpenVoxel {
                        centre: centre.to_array(),
                        payload,
                    });
                }
            }
        }
    }
}

/// The conservative test of a splat's box against a tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TileWindow {
    /// f or m.
    pub scale: f32,
    /// Central projection.
    pub perspective: bool,
    /// Principal point, pixels.
    pub principal: [f32; 2],
    /// Reach of a kernel in x, y, depth, camera space.
    pub reach: Vec3,
    /// Reach of the low-pass, pixels.
    pub margin: f32,
    /// Depth of the first sheet.
    pub near: f32,
}

impl TileWindow {
    #[inline(always)]
    fn touches(&self, centre: Vec3, rect: &TileRect) -> bool {
        let (near, far) = if self.perspective {
            let near = (centre.z - self.reach.z).max(self.near);
            (
                self.scale / near,
                self.scale / (centre.z + self.reach.z).max(near),
            )
        } else {
            (self.scale, self.scale)
        };
        let axis = |position: f32, reach: f32, principal: f32, low: usize, high: usize| {
            let (from, to) = (position - reach, position + reach);
            let first = (from * near).min(from * far) + principal - self.margin;
            let last = (to * near).max(to * far) + principal + self.margin;
            last >= low as f32 && first <= high as f32
        };
        axis(centre.x, self.reach.x, self.principal[0], rect.x0, rect.x1)
            && axis(centre.y, self.reach.y, self.principal[1], rect.y0, rect.y1)
    }
}
