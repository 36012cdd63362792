//! Project: bricks to the tiles and sheets of a zone that they can touch.

use glam::{DAffine3, DVec2, DVec3};
use splatvol_scene::ScreenFromCamera;

use crate::bin::ProjectedBrick;
use crate::brick::{ActiveBrick, BRICK};
use crate::footprint::FootprintShape;
use crate::sheets::Planes;

/// Bricks to screen rectangles and front sheets.
#[derive(Debug)]
pub(super) struct BrickProjection<'a> {
    pub camera_from_lattice: DAffine3,
    pub screen: ScreenFromCamera,
    pub shape: &'a FootprintShape,
    pub planes: Planes,
    /// Least depth that a footprint of the zone has, and largest that a voxel may begin at.
    pub nearest: f64,
    pub farthest: f64,
    /// Reach of a voxel in depth.
    pub reach: f64,
    /// Reach of a voxel around the centre of its nearest footprint, pixels.
    pub margin: f64,
}

/// Share of a sheet's thickness by which bricks count as nearer and farther than they are, for rounding.
const SLACK: f64 = 1e-3;

impl BrickProjection<'_> {
    /// Bounds of a brick's footprints; `None` where the brick meets no sheet.
    pub(super) fn project(&self, first: [u32; 3], index: usize) -> Option<ProjectedBrick> {
        let first = DVec3::from_array(first.map(f64::from));
        let corner = self.camera_from_lattice.transform_point3(first);
        let linear = self.camera_from_lattice.matrix3 * (BRICK as f64 - 1.0);
        let (mut low, mut high) = (corner, corner);
        for axis in [linear.x_axis, linear.y_axis, linear.z_axis] {
            low += axis.min(DVec3::ZERO);
            high += axis.max(DVec3::ZERO);
        }
        let drift = (self.shape.lateral_slope.abs() * self.reach).extend(self.reach);
        let (low, high) = (low - drift, high + drift);
        let slack = SLACK * self.planes.spacing;
        if high.z < self.nearest - slack || low.z > self.farthest + slack {
            return None;
        }
        let near = low.z.max(self.nearest);
        let scales = [self.screen.scale_at(near), self.screen.scale_at(high.z.max(near))];
        let bound = |value: DVec2, pick: fn(f64, f64) -> f64| {
            let [a, b] = scales.map(|scale| value * scale);
            DVec2::new(pick(a.x, b.x), pick(a.y, b.y)) + self.screen.centre
        };
        let from = bound(low.truncate(), f64::min) - self.margin;
        let to = bound(high.truncate(), f64::max) + self.margin;
        Some(ProjectedBrick {
            active: ActiveBrick {
                brick: index as u32,
                blocks: u8::MAX,
            },
            front_sheet: self.planes.first_touched(low.z) as u32,
            rect: [from.x as f32, from.y as f32, to.x as f32, to.y as f32],
        })
    }
}
