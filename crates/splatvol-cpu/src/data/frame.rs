//! A post-classified frame: kernel and camera to sheets, bricks to tiles.

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists};
use splatvol_core::brick::{ActiveBrick, BRICK};
use splatvol_core::footprint::FootprintShape;
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::sheets::SheetStack;
use splatvol_core::visibility::BrickStore;
use splatvol_scene::{Camera, Filter, Grid, RenderSettings, ScreenFromCamera};

use super::order::DepthOrder;
use super::ring::LANES;
use super::shade::{PlaneShader, ShadeTable};
use super::sheet::{Raster, shapes};
use super::splat::{MAX_BLOCKS, SplatConstants};
use super::tile::DataFrame;
use crate::stage::shade::Phong;

/// Standard deviations at which footprints are cut that a low-pass or an ellipse has deprived of the kernel's own window.
const GAUSSIAN_CUT: f64 = 3.4;

/// Plans a frame.
pub(crate) fn plan<'a>(
    (grid, margin): (&Grid, [usize; 3]),
    (store, table): (&'a BrickStore, &'a ShadeTable),
    (camera, settings): (&Camera, &RenderSettings),
    tile_edge: usize,
) -> DataFrame<'a> {
    let screen = camera.screen_from_camera(settings.size);
    let first_point = -DVec3::from_array(margin.map(|m| m as f64));
    let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
    let camera_from_lattice = camera_from_voxel * DAffine3::from_translation(first_point);
    let linear = camera_from_voxel.matrix3;
    let kernel = GaussianKernel::windowed(settings.kernel);
    let shape = FootprintShape::new(
        linear * linear.transpose() * kernel.sigma.powi(2),
        1.0,
        kernel.cut(),
    );
    let per_voxel = shape.depth_sigma / kernel.sigma;
    let reach = kernel.radius * per_voxel;
    let spacing = settings.sheet_thickness * per_voxel;
    let groups = ((2.0 * kernel.radius / settings.sheet_thickness / LANES as f64) - 1e-9).ceil() as usize;
    let stack = SheetStack::covering(&corners(grid, camera_from_voxel), reach, spacing, &screen);
    let edge = kernel.edge;
    let (low_pass, matched) = match settings.filter {
        Filter::None => (0.0, false),
        Filter::Ewa { pixel_sigma } => (pixel_sigma * pixel_sigma, false),
        Filter::Matched { pixel_sigma } => (pixel_sigma * pixel_sigma, true),
    };
    let step = 1;
    let [xx, xy, yy] = shape.lateral_covariance;
    let drift = shape.lateral_slope.abs().max_element();
    let round = xy == 0.0 && (xx - yy).abs() < 1e-6 * xx && drift < 1e-6;
    let widest = screen.scale_at(stack.plane(stack.count));
    let filtered = low_pass
        > if matched {
            xx.min(yy) * widest * widest
        } else {
            0.0
        };
    let ellipses = !round;
    let windowed = round && !filtered;
    let raster = Raster {
        step,
        low_pass,
        matched,
        peak: kernel.lattice_sum.powi(-3),
    };
    let sheets = shapes(&shape, &screen, &raster, &stack);
    let cut = if windowed { kernel.cut() } else { GAUSSIAN_CUT };
    let nearest = sheets
        .iter()
        .find(|s| s.scale.is_finite())
        .copied()
        .unwrap_or_default();
    let half_extent = nearest.half_extent(cut as f32);
    let points = half_extent[0].max(half_extent[1]);
    let size = MAX_BLOCKS;
    let projection = BrickProjection {
        camera_from_lattice,
        screen,
        shape: &shape,
        stack,
        reach,
        margin: f64::from(points),
    };
    let tiles = TileGrid::new(settings.size, tile_edge);
    let bricks: Vec<ProjectedBrick> = (0..store.first.len())
        .into_par_iter()
        .with_min_len(256)
        .filter_map(|i| projection.project(store, i))
        .collect();
    let mean_spacing = grid.mean_spacing();
    let per_pixel = if screen.perspective {
        1.0 / screen.scale as f32
    } else {
        0.0
    };
    DataFrame {
        store,
        order: DepthOrder::new(linear),
        camera_from_lattice,
        stack,
        sheets,
        tiles,
        lists: TileLists::new(bricks, &tiles),
        constants: SplatConstants {
            slope: shape.lateral_slope.as_vec2().to_array(),
            principal: [0.0; 2],
            depth_exponent: (-0.5 * std::f64::consts::LOG2_E / shape.depth_sigma.powi(2)) as f32,
            depth_edge: edge as f32,
        },
        shader: PlaneShader {
            table,
            phong: settings.lighting.as_ref().map(|l| Phong::new(l, mean_spacing)),
            spacing: spacing as f32,
            background: store.background,
            principal: screen.centre.as_vec2().to_array(),
            per_pixel,
            termination: settings.termination as f32,
        },
        depth_reach: reach as f32,
        half_extent,
        cut: cut as f32,
        size,
        ellipses,
        groups,
        principal: (screen.centre / step as f64 - 0.5).as_vec2().to_array(),
    }
}

fn corners(grid: &Grid, camera_from_voxel: DAffine3) -> [DVec3; 8] {
    let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
    std::array::from_fn(|i| {
        let voxel = DVec3::from_array(std::array::from_fn(
            |a| if i >> a & 1 == 0 { 0.0 } else { last[a] },
        ));
        camera_from_voxel.transform_point3(voxel)
    })
}

/// Bricks to screen rectangles and front sheets.
struct BrickProjection<'a> {
    camera_from_lattice: DAffine3,
    screen: ScreenFromCamera,
    shape: &'a FootprintShape,
    stack: SheetStack,
    reach: f64,
    /// Reach of a footprint around its centre on the nearest sheet, pixels.
    margin: f64,
}

impl BrickProjection<'_> {
    fn project(&self, store: &BrickStore, index: usize) -> Option<ProjectedBrick> {
        let first = DVec3::from_array(store.first[index].map(f64::from));
        let corner = self.camera_from_lattice.transform_point3(first);
        let linear = self.camera_from_lattice.matrix3 * (BRICK as f64 - 1.0);
        let (mut low, mut high) = (corner, corner);
        for axis in [linear.x_axis, linear.y_axis, linear.z_axis] {
            low += axis.min(DVec3::ZERO);
            high += axis.max(DVec3::ZERO);
        }
        let drift = (self.shape.lateral_slope.abs() * self.reach).extend(self.reach);
        let (low, high) = (low - drift, high + drift);
        if high.z < self.stack.first {
            return None;
        }
        let near = low.z.max(self.stack.first);
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
            front_sheet: self.stack.first_touched(low.z) as u32,
            rect: [from.x as f32, from.y as f32, to.x as f32, to.y as f32],
        })
    }
}
