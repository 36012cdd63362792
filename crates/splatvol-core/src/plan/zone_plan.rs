//! Plan of a zone, from which its tiles are rendered: footprints on its sheets, and bricks in tile lists.

use rayon::prelude::*;

use super::blocks::{mass_drawn, pixel_reach, room_of};
use super::extents::Extents;
use super::project::BrickProjection;
use super::raster::SheetShape;
use super::view::GridView;
use super::zones::{Evaluation, Zone};
use super::{Bricks, SplatConstants};
use crate::bin::{ProjectedBrick, TileGrid, TileLists};

/// Plan of a zone, from which its tiles are rendered.
#[derive(Debug, Default)]
pub struct ZonePlan {
    /// Its planes, and the visible intervals between them.
    pub zone: Zone,
    /// Its sheets' footprints.
    pub sheets: Vec<SheetShape>,
    /// Bricks by tile.
    pub lists: TileLists,
    /// Constants shared by all its voxels.
    pub constants: SplatConstants,
}

impl ZonePlan {
    /// Footprints on the zone's sheets.
    pub(super) fn project(&mut self, view: &GridView) {
        let &Extents {
            screen, along_rays, ..
        } = view.extents();
        let Self { zone, .. } = self;
        let Zone { planes, raster, .. } = *zone;
        // Slabs have the size of their middle.
        let before = if along_rays { 0.5 * planes.spacing } else { 0.0 };
        self.sheets.clear();
        self.sheets.extend(
            (zone.first_made..=planes.count)
                .map(|i| SheetShape::new(view.shape(), &screen, &raster, planes.plane(i) - before)),
        );
        if !along_rays && zone.footprints != Evaluation::Direct {
            // What blocks leave out is made up for, so that weights have the mean of whole footprints.
            let (cut, room) = (zone.cut as f32, view.room());
            for sheet in &mut self.sheets {
                sheet.peak /= mass_drawn(sheet, cut, &room);
            }
        }
        // Planes before the first have no footprint; its scale stands for theirs.
        let first = self.sheets[0];
        let none = |i| SheetShape {
            depth: planes.plane(i) as f32,
            peak: 0.0,
            ..first
        };
        self.sheets.splice(0..0, (0..zone.first_made).map(none));
        self.constants = SplatConstants {
            slope: view.shape().lateral_slope.as_vec2().to_array(),
            principal: ((screen.centre - 0.5) / raster.step as f64).as_vec2().to_array(),
            depth_exponent: (-0.5 * std::f64::consts::LOG2_E / view.shape().depth_sigma.powi(2)) as f32,
            depth_edge: if along_rays {
                0.0
            } else {
                view.kernel().edge as f32
            },
            per_depth: if screen.perspective { 1.0 } else { 0.0 },
        };
    }

    /// Projection of bricks to the zone, whose sheets have their footprints.
    pub(super) fn projection<'a>(&self, view: &'a GridView) -> BrickProjection<'a> {
        let &Extents {
            screen, along_rays, ..
        } = view.extents();
        let Self { zone, .. } = self;
        let Zone {
            planes, raster, cut, ..
        } = *zone;
        let room = view.room();
        let half_extent = room_of(&self.sheets[zone.first_made], cut as f32, &room);
        BrickProjection {
            camera_from_lattice: view.camera_from_lattice(),
            screen,
            shape: view.shape(),
            planes,
            nearest: zone.nearest(along_rays),
            farthest: planes.plane(planes.count),
            // Along rays, only the voxels at the eye move.
            reach: if along_rays && zone.eye.is_none() {
                0.0
            } else {
                view.depth_reach()
            },
            margin: f64::from(pixel_reach(half_extent, raster.step)),
        }
    }

    /// Sorts the bricks that the zone's sheets meet into tiles.
    pub(super) fn bin(
        &mut self,
        view: &GridView,
        bricks: &dyn Bricks,
        (tiles, projected): (&TileGrid, &mut Vec<Option<ProjectedBrick>>),
    ) {
        let projection = self.projection(view);
        projected.clear();
        projected.resize(bricks.len(), None);
        let each = projected.par_iter_mut().enumerate().with_min_len(256);
        each.for_each(|(i, brick)| *brick = projection.project(bricks.first(i), i));
        self.lists.fill(projected.iter().flatten().copied(), tiles);
    }
}
