//! A frame: kernel and camera to sheets, bricks to tiles.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;
use splatvol_core::bin::{ProjectedBrick, TileGrid, TileLists};
use splatvol_core::brick::{ActiveBrick, BRICK};
use splatvol_core::field::FieldStore;
use splatvol_core::footprint::FootprintShape;
use splatvol_core::kernel::GaussianKernel;
use splatvol_core::normal::mass_within;
use splatvol_core::sheets::Planes;
use splatvol_scene::{Camera, Filter, Gradient, Grid, RenderSettings, ScreenFromCamera};

use super::border::Border;
use super::integral::RayShapes;
use super::lattice_weights::LatticeWeights;
use super::mode::Bricks;
use super::order::DepthOrder;
use super::ring::LANES;
use super::shade::PlaneShader;
use super::sheet::{Raster, SheetShape};
use super::splat::SplatConstants;
use super::table::ShadeTable;
use super::tile::{Rays, SheetFrame, blocks_of, pixel_reach};
use crate::phong::Phong;

/// Standard deviations at which footprints are cut where a low-pass or a coarse raster has changed their width.
const CUT: f64 = 3.4;
/// Widest standard deviation of a footprint, raster points, that the largest blocks hold.
const WIDEST: f64 = 4.6;
/// Standard deviation of the nearest footprints beyond which a coarser raster costs less, raster points.
const COMFORTABLE: f64 = 2.3;
/// Narrowest standard deviation of a footprint, raster points, that a spline of a coarse raster reproduces.
const NARROWEST: f64 = 0.8;
/// The same where gradients are analytic: to the last digits.
const NARROWEST_EXACT: f64 = 1.2;
/// Standard deviations at which footprints are cut where gradients are analytic: what is left out on one side alone tilts them.
const CUT_EXACT: f64 = 4.2;
/// Widest angle between a pixel's ray and the axis, as a tangent.
const STEEPEST: f64 = 0.75;

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

/// What of a frame does not depend on the volume's content.
#[derive(Debug, Clone)]
pub(crate) struct View {
    camera_from_lattice: DAffine3,
    screen: ScreenFromCamera,
    shape: FootprintShape,
    kernel: GaussianKernel,
    stack: Planes,
    raster: Raster,
    reach: f64,
    spread: f64,
    groups: usize,
    round: bool,
    cut: f64,
    margin: [usize; 3],
    ray_shapes: RayShapes,
    /// Voxels are integrated, not sampled on planes.
    along_rays: bool,
}

impl View {
    /// `None` where footprints of one frame differ too much in size to share a raster: close to the camera, or seen at
    /// too wide an angle. `spacing`: of the planes, world length, where other layers demand one.
    pub(crate) fn new(
        grid: &Grid,
        (camera, settings): (&Camera, &RenderSettings),
        sampling: Sampling,
        spacing: Option<f64>,
    ) -> Option<Self> {
        let margin = grid.dims().map(|n| usize::from(n > 1));
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
        let first_point = -DVec3::from_array(margin.map(|m| m as f64));
        let linear = camera_from_voxel.matrix3;
        let kernel = GaussianKernel::windowed(settings.kernel);
        let shape = FootprintShape::new(
            linear * linear.transpose() * kernel.sigma.powi(2),
            1.0,
            kernel.cut(),
        );
        let per_voxel = shape.depth_sigma / kernel.sigma;
        let camera_from_lattice = camera_from_voxel * DAffine3::from_translation(first_point);
        let corners = corners(grid, margin, camera_from_lattice);
        let reach = kernel.radius * per_voxel;
        let stack = match sampling {
            // A slab per voxel tells enough of depth.
            Sampling::Rays => Planes::covering(&corners, 0.0, per_voxel, &screen),
            _ => {
                let own = settings.sheet_thickness * per_voxel;
                Planes::covering(&corners, reach, spacing.unwrap_or(own), &screen)
            }
        };
        let groups = match sampling {
            Sampling::Rays => {
                let nearest = corners
                    .iter()
                    .fold(f64::INFINITY, |near, corner| near.min(corner.z));
                // Half a voxel cannot be left out.
                if nearest - reach < stack.spacing {
                    return None;
                }
                1
            }
            _ => {
                let thickness = spacing.map_or(settings.sheet_thickness, |spacing| spacing / per_voxel);
                ((2.0 * kernel.radius / thickness / LANES as f64) - 1e-9).ceil() as usize
            }
        };
        let steepest = if screen.perspective {
            let corner = screen
                .centre
                .max(DVec2::new(settings.size.width() as f64, settings.size.height() as f64) - screen.centre);
            corner.length() / screen.scale
        } else {
            0.0
        };
        let ray_shapes = RayShapes {
            shape,
            screen,
            cell_volume: grid.cell_volume(),
        };
        let [xx, xy, yy] = shape.lateral_covariance;
        let drift = shape.lateral_slope.abs().max_element();
        let (shape, covariances, round) = match sampling {
            Sampling::Rays => {
                let (bounding, covariances) = ray_shapes.over(settings.size);
                (bounding, covariances, ray_shapes.is_round())
            }
            _ => {
                let round = xy.abs() < 1e-6 * xx && (xx - yy).abs() < 1e-6 * xx && drift < 1e-6;
                (shape, [shape.lateral_covariance; 9], round)
            }
        };
        let nearest = stack.plane(0)
            - if sampling == Sampling::Rays {
                stack.spacing
            } else {
                0.0
            };
        let raster = raster(
            settings,
            peak(&kernel, sampling),
            &covariances,
            [nearest, stack.plane(stack.count)].map(|z| screen.scale_at(z)),
        )?;
        let changed = raster.step > 1 || raster.low_pass > 0.0 && !raster.matched;
        let cut = match sampling {
            _ if is_exact(settings) => CUT_EXACT,
            Sampling::Rays => CUT.max(kernel.cut()),
            _ if changed || !round => CUT,
            _ => kernel.cut(),
        };
        let ends =
            [nearest, stack.plane(stack.count)].map(|depth| SheetShape::new(&shape, &screen, &raster, depth));
        let reach = if sampling == Sampling::Rays { 0.0 } else { reach };
        let drift_of_centres = (steepest * reach) as f32;
        let within = steepest <= STEEPEST
            && groups <= MAX_GROUPS
            && stack.count <= MAX_SHEETS
            && (round || powers_fit(&ends, drift_of_centres, cut as f32));
        within.then_some(Self {
            camera_from_lattice,
            screen,
            shape,
            kernel,
            stack,
            raster,
            reach,
            spread: 0.5 * steepest * stack.spacing,
            groups,
            round,
            cut,
            margin,
            ray_shapes,
            along_rays: sampling == Sampling::Rays,
        })
    }
}

impl View {
    /// Sheets that a voxel is splatted into.
    pub(crate) fn sheets_per_voxel(&self) -> u64 {
        (self.groups * LANES) as u64
    }

    /// Distance between planes, world length.
    pub(crate) fn spacing(&self) -> f64 {
        self.stack.spacing
    }

    /// Pixels from one raster point to the next.
    pub(crate) fn step(&self) -> usize {
        self.raster.step
    }

    /// Footprints along rays, and how they are rasterised.
    pub(crate) fn along_rays(&self) -> (RayShapes, Raster) {
        (self.ray_shapes, self.raster)
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
        let per_pixel = 1.0 / self.screen.scale as f32;
        Rays {
            principal: self.screen.centre.as_vec2().to_array(),
            per_pixel: if self.screen.perspective { per_pixel } else { 0.0 },
            plane_per_pixel: per_pixel,
        }
    }

    /// Weights of the lattice and shares of the box on planes.
    pub(crate) fn weights(&self, dims: [usize; 3]) -> LatticeWeights {
        let margin = DVec3::from_array(self.margin.map(|m| m as f64));
        let camera_from_voxel = self.camera_from_lattice * DAffine3::from_translation(margin);
        LatticeWeights::new(camera_from_voxel, dims, self.margin, self.kernel.sigma)
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
            spacing: self.stack.spacing as f32,
            background: store.background(),
            principal,
            per_pixel,
            plane_per_pixel,
            termination: settings.termination as f32,
            border: Border::new(camera_from_voxel, dims, self.margin, self.kernel.sigma),
        }
    }
}

/// Whether the powers of ellipses between those of the nearest and the farthest sheet are floats: those of long and thin
/// ones on a fine raster may not be. `drift`: how far centres move within a voxel's sheets, world length; `cut`: standard
/// deviations at which footprints are cut.
fn powers_fit([near, far]: &[SheetShape; 2], drift: f32, cut: f32) -> bool {
    let [xx, xy, yy] = far.exponent;
    let steepest = 0.5 * (xx + yy + libm::hypotf(xx - yy, xy));
    // Centres lie up to a point and a half off the middle of their blocks along both axes.
    let offset = 1.5 * std::f32::consts::SQRT_2 + drift * near.scale;
    let points = blocks_of(near.half_extent(cut)) as f32;
    2.0 * steepest * offset * points < 126.0
}

/// Groups of four sheets that a voxel may reach.
const MAX_GROUPS: usize = 8;
/// Sheets of a frame.
const MAX_SHEETS: usize = 1 << 16;

/// Whether footprints carry analytic gradients.
fn is_exact(settings: &RenderSettings) -> bool {
    settings.gradient == Gradient::Analytic
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

/// How footprints are rasterised between the nearest and the farthest scale, pixels per world length.
fn raster(
    settings: &RenderSettings,
    peak: f64,
    covariances: &[[f64; 3]],
    scales: [f64; 2],
) -> Option<Raster> {
    let (low_pass, matched) = match settings.filter {
        // Footprints that are scaled belong to another engine.
        Filter::None | Filter::Swan | Filter::SwanAlpha => (0.0, false),
        Filter::Ewa { pixel_sigma } => (pixel_sigma * pixel_sigma, false),
        Filter::Matched { pixel_sigma } => (pixel_sigma * pixel_sigma, true),
    };
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for [xx, xy, yy] in covariances {
        let (mean, difference) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
        (least, most) = (least.min(mean - difference), most.max(mean + difference));
    }
    let filtered = |variance: f64| {
        if matched {
            variance.max(low_pass)
        } else {
            variance + low_pass
        }
    };
    let widest = filtered(most * scales[0] * scales[0]).sqrt();
    let narrowest = filtered(least * scales[1] * scales[1]).sqrt();
    // As coarse as the far end allows, but not coarser than the near end wants: then footprints are small.
    let (finest, wanted) = (
        libm::log2(widest / WIDEST).ceil(),
        libm::log2(widest / COMFORTABLE).ceil(),
    );
    let coarsest = |least: f64| libm::log2(narrowest / least).floor();
    let step_of = |least: f64| wanted.min(coarsest(least)).clamp(0.0, 6.0);
    let mut step = step_of(NARROWEST);
    if is_exact(settings) {
        step = step_of(NARROWEST_EXACT).max(finest).min(step);
    }
    if step < finest {
        return None;
    }
    let step = libm::exp2(step);
    // Without low-pass a footprint narrower than this would fall between the pixels.
    if low_pass == 0.0 && narrowest / step < 0.4 {
        return None;
    }
    Some(Raster {
        step: step as usize,
        low_pass,
        matched,
        peak,
    })
}

/// A frame's plan in memory that the next one uses again.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    order: DepthOrder,
    sheets: Vec<SheetShape>,
    projected: Vec<Option<ProjectedBrick>>,
    lists: TileLists,
}

impl Plan {
    /// Plans a frame.
    pub(crate) fn update<'a>(
        &'a mut self,
        view: &View,
        bricks: &'a dyn Bricks,
        settings: &RenderSettings,
        tile_edge: usize,
    ) -> SheetFrame<'a> {
        let View {
            camera_from_lattice,
            screen,
            ref shape,
            kernel,
            stack,
            raster,
            reach,
            spread,
            groups,
            round,
            cut,
            along_rays,
            ..
        } = *view;
        self.sheets.clear();
        // Slabs have the size of their middle.
        let before = if along_rays { 0.5 * stack.spacing } else { 0.0 };
        self.sheets.extend(
            (0..=stack.count).map(|i| SheetShape::new(shape, &screen, &raster, stack.plane(i) - before)),
        );
        let sheets = &self.sheets;
        let half_extent = sheets[0]
            .half_extent(cut as f32)
            .map(|half| half + spread as f32 * sheets[0].scale);
        let projection = BrickProjection {
            camera_from_lattice,
            screen,
            shape,
            stack,
            reach,
            margin: f64::from(pixel_reach(half_extent, raster.step)),
        };
        // Tiles begin at even raster points, as blocks do.
        let tiles = TileGrid::new(settings.size, tile_edge.next_multiple_of(2 * raster.step));
        self.projected.resize(bricks.len(), None);
        let projected = self.projected.par_iter_mut().enumerate().with_min_len(256);
        projected.for_each(|(i, brick)| *brick = projection.project(bricks.first(i), i));
        self.lists.fill(self.projected.iter().flatten().copied(), &tiles);
        self.order.update(camera_from_lattice.matrix3);
        SheetFrame {
            bricks,
            order: &self.order,
            camera_from_lattice,
            stack,
            sheets,
            tiles,
            lists: &self.lists,
            constants: SplatConstants {
                slope: shape.lateral_slope.as_vec2().to_array(),
                principal: ((screen.centre - 0.5) / raster.step as f64).as_vec2().to_array(),
                depth_exponent: (-0.5 * std::f64::consts::LOG2_E / shape.depth_sigma.powi(2)) as f32,
                depth_edge: if along_rays { 0.0 } else { kernel.edge as f32 },
            },
            rays: view.rays(),
            termination: settings.termination as f32,
            step: raster.step,
            depth_reach: reach as f32,
            cut: cut as f32,
            spread: spread as f32,
            ellipses: !round,
            groups,
        }
    }
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

/// Bricks to screen rectangles and front sheets.
struct BrickProjection<'a> {
    camera_from_lattice: DAffine3,
    screen: ScreenFromCamera,
    shape: &'a FootprintShape,
    stack: Planes,
    reach: f64,
    /// Reach of a voxel around the centre of its nearest footprint, pixels.
    margin: f64,
}

impl BrickProjection<'_> {
    fn project(&self, first: [u32; 3], index: usize) -> Option<ProjectedBrick> {
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
        let first = self.stack.plane(0);
        if high.z < first {
            return None;
        }
        let near = low.z.max(first);
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
