//! A frame: kernel and camera to sheets, bricks to tiles.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists};
use splatvol_core::field::FieldStore;
use splatvol_core::footprint::FootprintShape;
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::normal::mass_within;
use splatvol_scene::{Camera, Gradient, Grid, RenderSettings};

use super::analytic::AnalyticField;
use super::border::Border;
use super::engine::TILE_EDGE;
use super::extents::{Extents, STEEP, Widths, low_pass, steepest, variances};
use super::eye::Eye;
use super::lattice_weights::LatticeWeights;
use super::mode::Bricks;
use super::order::DepthOrder;
use super::place::{pixel_reach, room_of};
use super::project::BrickProjection;
use super::ray_shapes::RayShapes;
use super::ring::LANES;
use super::shade::PlaneShader;
use super::sheet::SheetShape;
use super::splat::SplatConstants;
use super::table::ShadeTable;
use super::tile::{Rays, ZonedFrame};
use super::zones::{Cutting, Kernels, Sheets, Zone};
use crate::phong::Phong;

/// Standard deviations in depth at which kernels are cut where gradients are analytic: there it matters that voxels come and
/// go by rounding.
const DEPTH_CUT_EXACT: f64 = 4.7;

/// How voxels are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sampling {
    /// On planes, coefficients of a field: weights sum to one on the lattice.
    Field,
    /// On planes, classified voxels: a kernel of unit integral.
    Planes,
    /// Along rays, classified voxels: a kernel of unit integral.
    Rays,
}

/// Tangent that rays within a tile differ by at most where footprints along rays are those of its middle.
const WIDEST_TILE: f64 = 0.25;
/// Smallest edge of such tiles, pixels.
const LEAST_TILE: usize = 4;

/// What of a frame does not depend on the volume's content.
#[derive(Debug, Clone)]
pub(crate) struct View {
    camera_from_lattice: DAffine3,
    shape: FootprintShape,
    kernel: GaussianKernel,
    sheets: Sheets,
    extents: Extents,
    /// How far a voxel reaches in depth, world length.
    reach: f64,
    groups: usize,
    round: bool,
    margin: [usize; 3],
    ray_shapes: RayShapes,
}

impl View {
    /// `spacing`: of the planes, world length, where other layers demand one.
    pub(crate) fn new(
        grid: &Grid,
        (camera, settings): (&Camera, &RenderSettings),
        sampling: Sampling,
        spacing: Option<f64>,
    ) -> Self {
        let margin = grid.dims().map(|n| usize::from(n > 1));
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
        let first_point = -DVec3::from_array(margin.map(|m| m as f64));
        let linear = camera_from_voxel.matrix3;
        let kernel = match GaussianKernel::windowed(settings.kernel) {
            kernel if settings.gradient == Gradient::Analytic => kernel.without_tails_cut(DEPTH_CUT_EXACT),
            kernel => kernel,
        };
        let shape = FootprintShape::new(linear * linear.transpose() * kernel.sigma.powi(2));
        let per_voxel = shape.depth_sigma / kernel.sigma;
        let camera_from_lattice = camera_from_voxel * DAffine3::from_translation(first_point);
        let corners = corners(grid, margin, camera_from_lattice);
        let reach = kernel.radius * per_voxel;
        let along_rays = sampling == Sampling::Rays;
        let xray_from = along_rays.then_some(XRAY_FROM * per_voxel);
        let steepest = steepest(&screen, settings.size);
        let (spacing, groups) = if along_rays {
            (per_voxel / slabs_per_voxel(settings), 1)
        } else {
            let thickness = match spacing {
                Some(spacing) => spacing / per_voxel,
                None => settings.sheet_thickness * thinner_where_steep(steepest),
            };
            let groups = (2.0 * kernel.radius / thickness / LANES as f64 - 1e-9).ceil();
            (spacing.unwrap_or(thickness * per_voxel), groups as usize)
        };
        let ray_shapes = RayShapes {
            shape,
            screen,
            cell_volume: grid.cell_volume(),
        };
        let (shape, covariances, round) = if along_rays {
            let (bounding, covariances) = ray_shapes.over(settings.size);
            (bounding, covariances, ray_shapes.is_round())
        } else {
            (shape, [shape.lateral_covariance; 9], is_round(&shape))
        };
        Self {
            camera_from_lattice,
            shape,
            kernel,
            sheets: Sheets::covering(&corners, reach, spacing, (&screen, xray_from)),
            extents: Extents {
                screen,
                variances: variances(&covariances),
                low_pass: low_pass(settings.filter),
                widths: Widths::of(settings),
                peak: peak(&kernel, sampling),
                steepest,
                along_rays,
                reach,
            },
            reach,
            groups,
            round,
            margin,
            ray_shapes,
        }
    }
}

/// Slabs of X-rays per voxel: one tells enough of depth, but the footprints of voxels half of it before and behind its middle are
/// too small or too large by as much as their distance from the eye differs.
fn slabs_per_voxel(settings: &RenderSettings) -> f64 {
    match settings.gradient {
        Gradient::Analytic => 8.0,
        Gradient::Differences => 1.0,
    }
}

/// Depth at which X-rays in perspective begin, voxels.
const XRAY_FROM: f64 = 0.5;

/// Thickness of sheets relative to what the settings ask for: rays of slope t meet planes `sqrt(1 + t^2)` times as far apart,
/// which is made up for beyond a slope of [`THINNER_FROM`].
fn thinner_where_steep(steepest: f64) -> f64 {
    let along = |slope: f64| (1.0 + slope * slope).sqrt();
    (along(THINNER_FROM) / along(steepest)).min(1.0)
}

/// Tangent of the angle between ray and axis, 45 degrees, up to which sheets are as thick along the axis as the settings ask for.
const THINNER_FROM: f64 = 1.0;

/// Whether footprints are circles, and each sheet's lie behind each other.
fn is_round(shape: &FootprintShape) -> bool {
    let [xx, xy, yy] = shape.lateral_covariance;
    let drift = shape.lateral_slope.abs().max_element();
    xy.abs() < 1e-6 * xx && (xx - yy).abs() < 1e-6 * xx && drift < 1e-6
}

impl View {
    /// Sheets that a voxel is splatted into.
    pub(crate) fn sheets_per_voxel(&self) -> u64 {
        (self.groups * LANES) as u64
    }

    /// Distance between planes, world length.
    pub(crate) fn spacing(&self) -> f64 {
        self.sheets.planes.spacing
    }

    /// How far a voxel reaches in depth, world length.
    pub(crate) fn depth_reach(&self) -> f64 {
        self.reach
    }

    /// Footprints along rays.
    pub(crate) fn ray_shapes(&self) -> RayShapes {
        self.ray_shapes
    }

    /// Edge of tiles whose footprints along rays are those of the middle, whatever tiles are asked for, so that these change no
    /// picture: smaller ones at wide angles, where rays differ more.
    pub(crate) fn ray_tile_edge(&self) -> usize {
        if self.extents.steepest <= STEEP {
            return TILE_EDGE;
        }
        let pixels = WIDEST_TILE * self.extents.screen.scale;
        (pixels as usize / LEAST_TILE * LEAST_TILE).clamp(LEAST_TILE, TILE_EDGE)
    }

    fn kernels(&self) -> Kernels {
        Kernels {
            shape: self.shape,
            round: self.round,
            sheets: self.groups * LANES,
            cut: self.kernel.cut(),
        }
    }

    /// Matrix of camera from voxel.
    pub(crate) fn camera_from_voxel(&self) -> DMat3 {
        self.camera_from_lattice.matrix3
    }

    /// Lattice points before the first sample along each axis.
    pub(crate) fn margin(&self) -> [usize; 3] {
        self.margin
    }

    fn rays(&self) -> Rays {
        let screen = &self.extents.screen;
        let per_pixel = 1.0 / screen.scale as f32;
        Rays {
            principal: screen.centre.as_vec2().to_array(),
            per_pixel: if screen.perspective { per_pixel } else { 0.0 },
            plane_per_pixel: per_pixel,
        }
    }

    /// A field whose coefficients are splatted with their kernels' derivatives, and how its planes are shaded.
    pub(crate) fn analytic_field<'a>(
        &self,
        store: &'a FieldStore,
        shader: PlaneShader<'a>,
    ) -> AnalyticField<'a> {
        let margin = DVec3::from_array(self.margin.map(|m| m as f64));
        let camera_from_voxel = self.camera_from_lattice * DAffine3::from_translation(margin);
        let dims = store.volume().grid().dims();
        AnalyticField {
            store,
            shader,
            weights: LatticeWeights::new(camera_from_voxel, dims, self.margin, self.kernel.sigma),
        }
    }

    /// Shader of planes of a field.
    pub(crate) fn shader<'a>(
        &self,
        (store, table): (&'a FieldStore, &'a ShadeTable),
        (settings, mean_spacing): (&RenderSettings, f64),
    ) -> PlaneShader<'a> {
        let margin = DVec3::from_array(self.margin.map(|m| m as f64));
        let camera_from_voxel = self.camera_from_lattice * DAffine3::from_translation(margin);
        let dims = store.volume().grid().dims();
        let Rays {
            principal,
            per_pixel,
            plane_per_pixel,
        } = self.rays();
        PlaneShader {
            table,
            phong: settings.lighting.as_ref().map(|l| Phong::new(l, mean_spacing)),
            spacing: self.sheets.planes.spacing as f32,
            background: store.background(),
            principal,
            per_pixel,
            plane_per_pixel,
            termination: settings.termination as f32,
            border: Border::new(camera_from_voxel, dims, self.margin, self.kernel.sigma),
        }
    }
}

/// Peak of a kernel's samples on planes.
fn peak(kernel: &GaussianKernel, sampling: Sampling) -> f64 {
    let lateral = (2.0 * std::f64::consts::PI).sqrt() * kernel.sigma;
    let along = match sampling {
        // Sums are divided by their weights, whose mean this makes one.
        Sampling::Field if kernel.edge == 0.0 => lateral * mass_within(kernel.cut()),
        Sampling::Field => kernel.lattice_sum,
        _ => lateral * mass_within(kernel.cut()) - 2.0 * kernel.radius * kernel.edge,
    };
    1.0 / (lateral * lateral * along)
}

/// Corners of a grid's lattice, camera space: not those of what is needed of it, which a transfer function changes.
fn corners(grid: &Grid, margin: [usize; 3], camera_from_lattice: DAffine3) -> [DVec3; 8] {
    let dims = grid.dims();
    std::array::from_fn(|i| {
        let last = |a: usize| (dims[a] + 2 * margin[a] - 1) as f64;
        let point = DVec3::from_array(std::array::from_fn(|a| (i >> a & 1) as f64 * last(a)));
        camera_from_lattice.transform_point3(point)
    })
}

/// A frame's plan in memory that the next one uses again.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    order: DepthOrder,
    zones: Vec<Zone>,
    /// Those of this frame's zones first.
    plans: Vec<ZonePlan>,
    projected: Vec<Option<ProjectedBrick>>,
    longest_first: Vec<u32>,
}

/// What a zone's tiles are rendered from.
#[derive(Debug, Default)]
pub(crate) struct ZonePlan {
    pub sheets: Vec<SheetShape>,
    pub lists: TileLists,
    pub constants: SplatConstants,
    /// What the first interval needs of the eye, where it begins there.
    pub eye: Eye,
}

impl Plan {
    /// Plans a frame.
    pub(crate) fn update<'a>(
        &'a mut self,
        view: &View,
        bricks: &'a dyn Bricks,
        settings: &RenderSettings,
        tile_edge: usize,
    ) -> ZonedFrame<'a> {
        let tiles = TileGrid::new(settings.size, tile_edge);
        let Self {
            order,
            zones,
            plans,
            projected,
            longest_first,
        } = self;
        order.update(view.camera_from_lattice.matrix3);
        zones.clear();
        let cutting = Cutting {
            extents: &view.extents,
            sheets: &view.sheets,
            kernels: view.kernels(),
        };
        cutting.cut(|zone| zones.push(zone));
        if plans.len() < zones.len() {
            plans.resize_with(zones.len(), ZonePlan::default);
        }
        for (zone, plan) in zones.iter().zip(&mut *plans) {
            plan.project(view, zone);
            plan.bin((view, zone), bricks, (&tiles, projected));
        }
        let plans = &plans[..zones.len()];
        busiest_first(plans, &tiles, longest_first);
        ZonedFrame {
            bricks,
            order,
            tiles,
            zones,
            plans,
            longest_first,
            camera_from_lattice: view.camera_from_lattice,
            rays: view.rays(),
            termination: settings.termination as f32,
            groups: view.groups,
            reach: if view.extents.along_rays {
                0.0
            } else {
                view.reach as f32
            },
            room: view.extents.room_of_footprints(view.sheets.planes.spacing),
        }
    }
}

/// Tiles by their bricks in all zones, those with most first: taken in this order, threads end at nearly the same time.
fn busiest_first(plans: &[ZonePlan], tiles: &TileGrid, order: &mut Vec<u32>) {
    order.clear();
    order.extend(0..tiles.len() as u32);
    order.sort_unstable_by_key(|&tile| {
        let bricks = plans
            .iter()
            .map(|plan| plan.lists.of(tile as usize).len())
            .sum::<usize>();
        (std::cmp::Reverse(bricks), tile)
    });
}

impl ZonePlan {
    /// Footprints on the zone's sheets.
    fn project(&mut self, view: &View, zone: &Zone) {
        let Extents {
            screen, along_rays, ..
        } = view.extents;
        let Zone { planes, raster, .. } = *zone;
        // Slabs have the size of their middle.
        let before = if along_rays { 0.5 * planes.spacing } else { 0.0 };
        self.sheets.clear();
        self.sheets.extend(
            (zone.first_made..=planes.count)
                .map(|i| SheetShape::new(&view.shape, &screen, &raster, planes.plane(i) - before)),
        );
        // Before the first plane there is none: its scale stands for theirs.
        let first = self.sheets[0];
        let none = |i| SheetShape {
            depth: planes.plane(i) as f32,
            peak: 0.0,
            ..first
        };
        self.sheets.splice(0..0, (0..zone.first_made).map(none));
        self.constants = SplatConstants {
            slope: view.shape.lateral_slope.as_vec2().to_array(),
            principal: ((screen.centre - 0.5) / raster.step as f64).as_vec2().to_array(),
            depth_exponent: (-0.5 * std::f64::consts::LOG2_E / view.shape.depth_sigma.powi(2)) as f32,
            depth_edge: if along_rays { 0.0 } else { view.kernel.edge as f32 },
        };
    }

    /// Sorts the bricks that the zone's sheets meet into tiles.
    fn bin(
        &mut self,
        (view, zone): (&View, &Zone),
        bricks: &dyn Bricks,
        (tiles, projected): (&TileGrid, &mut Vec<Option<ProjectedBrick>>),
    ) {
        let Extents {
            screen, along_rays, ..
        } = view.extents;
        let Zone {
            planes, raster, cut, ..
        } = *zone;
        let room = view.extents.room_of_footprints(planes.spacing);
        let half_extent = room_of(&self.sheets[zone.first_made], cut as f32, room);
        let projection = BrickProjection {
            camera_from_lattice: view.camera_from_lattice,
            screen,
            shape: &view.shape,
            planes,
            nearest: zone.nearest(view.extents.along_rays),
            farthest: planes.plane(planes.count),
            // Of voxels along rays only those at the eye move.
            reach: if along_rays && zone.eye.is_none() {
                0.0
            } else {
                view.reach
            },
            margin: f64::from(pixel_reach(half_extent, raster.step)),
        };
        projected.clear();
        projected.resize(bricks.len(), None);
        let each = projected.par_iter_mut().enumerate().with_min_len(256);
        each.for_each(|(i, brick)| *brick = projection.project(bricks.first(i), i));
        self.lists.fill(projected.iter().flatten().copied(), tiles);
        if zone.begins_at_eye() {
            let kernel = (&view.kernel, raster.peak);
            self.eye
                .update(&view.shape, kernel, view.camera_from_lattice, bricks);
        }
    }
}
