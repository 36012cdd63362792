//! Plan: turns a camera and a grid into plain data from which an engine renders tiles.
//!
//! | module | from | to |
//! |---|---|---|
//! | `view`, `distance` | kernel, grid and camera | planes, and the kernel as the camera sees it |
//! | `extents`, `zones` | planes | runs of sheets with one raster each |
//! | `raster`, `blocks` | a sheet | its footprint, and how far it reaches |
//! | `ray_shapes` | a ray | the footprint of a voxel that is integrated along it |
//! | `order` | the camera | the order in which a brick's voxels come, nearest first |
//! | `project`, `zone_plan` | bricks | rectangles of the picture and first sheets, in lists per tile |
//! | `segments` | several levels of a grid | runs of planes, each of one level |
//! | `reach` | a rectangle of the picture | the bricks that it can show |
//!
//! A [`FramePlan`] holds numbers only: no reference to samples, no trait object, no vector type of a processor.
//! Data per pixel is in single precision; depths and places are computed in double precision here, and rounded
//! once. Planes and footprints depend on the grid's box and the camera, never on the needed bricks, on threads,
//! tiles or memory.

mod blocks;
mod distance;
mod extents;
mod order;
mod project;
mod raster;
mod ray_shapes;
mod reach;
mod segments;
#[cfg(test)]
mod tests;
mod view;
mod zone_plan;
mod zones;

use glam::DVec3;
use rayon::prelude::*;
use splatvol_scene::{ImageSize, RenderSettings, ScreenFromCamera, SheetSettings};

pub use blocks::{BELOW_CUT, MAX_BLOCKS, Room, SIZES, TRIMMED, blocks_of, mass_drawn, room_of};
pub use extents::low_pass;
pub use order::DepthOrder;
pub use raster::{Raster, SheetShape, half_extent};
pub use ray_shapes::RayShapes;
pub use reach::Reach;
pub use segments::{Ramp, Segment, behind_each_other};
pub use view::{GridView, Sampling, on_common_planes};
pub use zone_plan::ZonePlan;
pub use zones::{Evaluation, Zone};

use crate::bin::{ProjectedBrick, TileGrid};
use crate::field::FieldStore;

/// Sheets that footprints are drawn on at once.
pub const GROUP: usize = 4;

/// Bricks with voxels to splat.
pub trait Bricks: std::fmt::Debug + Sync {
    /// Number of bricks.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// First lattice point of a brick.
    fn first(&self, index: usize) -> [u32; 3];
}

impl Bricks for FieldStore {
    fn len(&self) -> usize {
        Self::len(self)
    }

    fn first(&self, index: usize) -> [u32; 3] {
        Self::first(self, index)
    }
}

/// Rays of the pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct Rays {
    /// Image coordinates of the principal point.
    pub principal: [f32; 2],
    /// Ray of a pixel at image x, y: `(x + 1/2 - principal) * per_pixel` per depth, 0 where parallel.
    pub per_pixel: f32,
    /// Width of a pixel, world length, where rays are parallel.
    pub plane_per_pixel: f32,
}

impl Rays {
    /// Rays of a projection.
    pub fn new(screen: &ScreenFromCamera) -> Self {
        let per_pixel = 1.0 / screen.scale as f32;
        Self {
            principal: screen.centre.as_vec2().to_array(),
            per_pixel: if screen.perspective { per_pixel } else { 0.0 },
            plane_per_pixel: per_pixel,
        }
    }
}

/// View-dependent constants of splatting, shared by all voxels of a zone.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct SplatConstants {
    /// Drift of the footprint's centre per depth.
    pub slope: [f32; 2],
    /// Raster coordinates of the principal point, from the ring's first point.
    pub principal: [f32; 2],
    /// `-log2(e) / 2 s^2`, s the kernel's standard deviation in depth.
    pub depth_exponent: f32,
    /// Edge subtracted from the kernel's profile in depth, so that it ends without a step.
    pub depth_edge: f32,
    /// Lateral motion of rays per depth, relative to their place on a plane over its depth: 1 in perspective, 0 for
    /// parallel rays.
    pub per_depth: f32,
}

/// Plan of one layer of a frame, from which its tiles are rendered; the next frame reuses its memory.
#[derive(Debug)]
pub struct FramePlan {
    /// The picture's tiles.
    pub tiles: TileGrid,
    /// Rays of the pixels.
    pub rays: Rays,
    /// Transmittance below which a pixel is finished.
    pub termination: f32,
    /// Groups of [`GROUP`] sheets that a voxel is splatted into.
    pub groups: usize,
    /// Reach of a voxel in depth, world length.
    pub reach: f32,
    /// Room for footprints of neighbouring sheets.
    pub room: Room,
    /// The voxels of a brick by depth.
    pub order: DepthOrder,
    /// First voxel of each brick, camera space, world length.
    pub corners: Vec<[f32; 3]>,
    /// Tiles, sorted by descending number of bricks: in this order threads finish at nearly the same time.
    pub longest_first: Vec<u32>,
    zones: Vec<ZonePlan>,
    zone_count: usize,
    projected: Vec<Option<ProjectedBrick>>,
}

impl Default for FramePlan {
    fn default() -> Self {
        Self {
            tiles: TileGrid::new(ImageSize::default(), 64),
            rays: Rays::default(),
            termination: 0.0,
            groups: 1,
            reach: 0.0,
            room: Room::default(),
            order: DepthOrder::default(),
            corners: Vec::new(),
            longest_first: Vec::new(),
            zones: Vec::new(),
            zone_count: 0,
            projected: Vec::new(),
        }
    }
}

impl FramePlan {
    /// Zones, front to back.
    pub fn zones(&self) -> &[ZonePlan] {
        &self.zones[..self.zone_count]
    }

    /// Number of visible intervals, front to back.
    pub fn sheets(&self) -> usize {
        self.zones().iter().map(|plan| plan.zone.shown.len()).sum()
    }

    /// Plans a frame of a grid.
    pub fn of_grid(
        &mut self,
        view: &GridView,
        bricks: &dyn Bricks,
        settings: &RenderSettings<SheetSettings>,
        tile_edge: usize,
    ) {
        self.tiles = TileGrid::new(settings.size, tile_edge);
        self.rays = view.rays();
        self.termination = settings.termination as f32;
        self.groups = view.groups();
        self.reach = view.reach_of_sheets();
        self.room = view.room();
        self.order.update(view.camera_from_voxel());
        let corner = |index: usize| {
            let first = DVec3::from_array(bricks.first(index).map(f64::from));
            view.camera_from_lattice()
                .transform_point3(first)
                .as_vec3()
                .to_array()
        };
        (0..bricks.len())
            .into_par_iter()
            .with_min_len(1024)
            .map(corner)
            .collect_into_vec(&mut self.corners);
        self.zone_count = 0;
        view.cutting().cut(|zone| {
            if self.zones.len() == self.zone_count {
                self.zones.push(ZonePlan::default());
            }
            self.zones[self.zone_count].zone = zone;
            self.zone_count += 1;
        });
        for plan in &mut self.zones[..self.zone_count] {
            plan.project(view);
            plan.bin(view, bricks, (&self.tiles, &mut self.projected));
        }
        self.sort_tiles();
    }

    /// Plans a frame of one zone on the pixels, with only depth and scale per sheet. `project`: bounds of each of
    /// `count` chunks of splats.
    pub fn of_pixels(
        &mut self,
        (screen, settings): (&ScreenFromCamera, &RenderSettings<SheetSettings>),
        (zone, sheets): (Zone, impl Iterator<Item = SheetShape>),
        (count, project): (usize, impl Fn(usize) -> Option<ProjectedBrick> + Sync),
        tiles: TileGrid,
    ) {
        let Self { zones, projected, .. } = self;
        if zones.is_empty() {
            zones.push(ZonePlan::default());
        }
        self.zone_count = 1;
        let plan = &mut zones[0];
        plan.zone = zone;
        plan.sheets.clear();
        plan.sheets.extend(sheets);
        projected.resize(count, None);
        let chunks = projected.par_iter_mut().enumerate();
        chunks.for_each(|(index, chunk)| *chunk = project(index));
        plan.lists.fill(projected.iter().flatten().copied(), &tiles);
        self.tiles = tiles;
        self.rays = Rays::new(screen);
        self.termination = settings.termination as f32;
        self.sort_tiles();
    }

    /// Sorts tiles by their bricks in all zones.
    fn sort_tiles(&mut self) {
        let order = &mut self.longest_first;
        order.clear();
        order.extend(0..self.tiles.len() as u32);
        let zones = &self.zones[..self.zone_count];
        order.sort_unstable_by_key(|&tile| {
            let bricks = zones
                .iter()
                .map(|plan| plan.lists.of(tile as usize).len())
                .sum::<usize>();
            (std::cmp::Reverse(bricks), tile)
        });
    }
}
