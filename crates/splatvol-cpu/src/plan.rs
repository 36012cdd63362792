//! The plan of a frame: everything that tiles share and only read.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use splatvol_core::bin::{Projector, TileGrid, TileLists};
use splatvol_core::brick::BrickGrid;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::coefficients::Coefficients;
use splatvol_core::footprint::FootprintShape;
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::sheets::SheetStack;
use splatvol_scene::{Camera, Classification, Compositing, Grid, RenderSettings};

use crate::stage::activate::TileWindow;
use crate::stage::cover::BoxCover;

/// What tiles are rendered from.
#[derive(Debug)]
pub(crate) struct FramePlan<'a> {
    pub settings: &'a RenderSettings,
    pub coefficients: &'a Coefficients,
    pub bricks: &'a BrickGrid,
    pub table: &'a ClassificationTable,
    pub projector: Projector<'a>,
    pub window: TileWindow,
    pub tiles: TileGrid,
    pub lists: TileLists,
    /// Geometric mean of the voxel spacing, world length.
    pub mean_spacing: f64,
    /// World length to which opacities refer.
    pub unit_distance: f64,
    /// Bricks that can change a pixel, before projection.
    pub active_bricks: usize,
    /// The volume's box, for the coverage of post-classified values.
    pub cover: BoxCover,
    /// Set where the picture is given up.
    pub stop: Option<&'a AtomicBool>,
}

impl FramePlan<'_> {
    /// Whether the picture has been given up.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}

/// Grid, kernel and camera of a frame, before anything is projected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Geometry {
    /// Camera space from lattice index, the continuation's margin included.
    pub camera_from_lattice: DAffine3,
    pub shape: FootprintShape,
    pub sheets: SheetStack,
    pub mean_spacing: f64,
    /// How far a voxel acts, voxels per axis, low-pass and one sheet included.
    pub voxel_reach: [f64; 3],
}

/// True where kernels are integrated over sheets rather than sampled on them.
pub(crate) fn splats_color(settings: &RenderSettings) -> bool {
    match settings.compositing {
        Compositing::ImageSheets => settings.classification == Classification::Pre,
        Compositing::Mip | Compositing::MinimumIntensity | Compositing::Mean => false,
        _ => true,
    }
}

impl Geometry {
    /// Projects the grid's kernel and lays the sheets.
    pub(crate) fn new(grid: &Grid, margin: [usize; 3], camera: &Camera, settings: &RenderSettings) -> Self {
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
        let linear = camera_from_voxel.matrix3;
        let kernel = GaussianKernel::new(settings.kernel);
        let covariance = linear * linear.transpose() * kernel.sigma.powi(2);
        // Integrals keep their mass by a wide cut and a kernel of unit integral; samples are normalised by weights.
        let cut = if splats_color(settings) {
            kernel.cut().max(5.0)
        } else {
            kernel.cut()
        };
        let mass = if splats_color(settings) {
            1.0
        } else {
            kernel.mass()
        };
        let shape = FootprintShape::new(covariance, grid.cell_volume() * mass, cut);
        let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
        let corners: Vec<DVec3> = (0..8)
            .map(|i| {
                DVec3::from_array(std::array::from_fn(
                    |a| if i >> a & 1 == 0 { 0.0 } else { last[a] },
                ))
            })
            .map(|voxel| camera_from_voxel.transform_point3(voxel))
            .collect();
        let mean_spacing = grid.mean_spacing();
        let spacing = settings.sheet_thickness * mean_spacing;
        let reach = shape.depth_reach();
        let sheets = match settings.compositing {
            // A line integral is exact in one piece where rays are parallel; where they diverge, pieces of a few voxels
            // keep the footprints' drift along the ray small.
            Compositing::Xray if screen.perspective => {
                SheetStack::covering(&corners, reach, 4.0 * spacing, &screen)
            }
            Compositing::Xray => SheetStack::single(&corners, reach, &screen),
            _ => SheetStack::covering(&corners, reach, spacing, &screen),
        };
        let farthest = sheets.plane(sheets.count);
        let low_pass = cut * settings.filter.pixel_sigma() / screen.scale_at(farthest);
        let rows: DMat3 = linear.inverse().transpose();
        let per_axis = |row: DVec3| kernel.radius + (low_pass + spacing) * row.length();
        let first_point = -DVec3::from_array(margin.map(|m| m as f64));
        Self {
            camera_from_lattice: camera_from_voxel * DAffine3::from_translation(first_point),
            shape,
            sheets,
            mean_spacing,
            voxel_reach: [
                per_axis(rows.x_axis),
                per_axis(rows.y_axis),
                per_axis(rows.z_axis),
            ],
        }
    }
}

impl<'a> FramePlan<'a> {
    /// Culls, projects and bins.
    pub(crate) fn new(
        geometry: &'a Geometry,
        (coefficients, bricks): (&'a Coefficients, &'a BrickGrid),
        (table, unit_distance): (&'a ClassificationTable, f64),
        (camera, settings): (&Camera, &'a RenderSettings),
        tile_edge: usize,
    ) -> Self {
        let screen = camera.screen_from_camera(settings.size);
        let pixel_sigma = settings.filter.pixel_sigma();
        let Geometry {
            camera_from_lattice,
            ref shape,
            sheets,
            mean_spacing,
            voxel_reach,
        } = *geometry;
        let projector = Projector {
            camera_from_voxel: camera_from_lattice,
            sigma: GaussianKernel::new(settings.kernel).sigma,
            screen,
            shape,
            pixel_sigma,
            sheets,
        };
        let active = match settings.compositing {
            // What is shown may lie where opacity is zero; only voxels that do not exist are left out.
            shown if shown.shows_one_value() => bricks.occupied(),
            _ if splats_color(settings) => bricks.visible(table),
            _ => bricks.active(table, voxel_reach),
        };
        let tiles = TileGrid::new(settings.size, tile_edge);
        let projected = active
            .par_iter()
            .filter_map(|&brick| projector.project(bricks, brick))
            .collect();
        let window = TileWindow {
            scale: screen.scale as f32,
            perspective: screen.perspective,
            principal: screen.centre.as_vec2().to_array(),
            reach: shape.lateral_reach().extend(shape.depth_reach()).as_vec3(),
            margin: (shape.cut * pixel_sigma) as f32,
            near: sheets.first as f32,
        };
        Self {
            settings,
            coefficients,
            bricks,
            table,
            projector,
            window,
            tiles,
            lists: TileLists::new(projected, &tiles),
            mean_spacing,
            unit_distance,
            active_bricks: active.len(),
            cover: BoxCover::new(&projector, coefficients),
            stop: None,
        }
    }
}
