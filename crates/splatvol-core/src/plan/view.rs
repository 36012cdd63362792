//! View: a grid's kernel in camera space, with its planes and footprints; independent of the samples.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Camera, Gradient, Grid, RenderSettings, SheetSettings};

use super::distance::{finer_rays, finer_sheets, thinner_where_steep, whole_groups};
use super::extents::{Extents, STEEP, Widths, low_pass, steepest, variances};
use super::raster::SheetShape;
use super::ray_shapes::{NEARLY_ROUND, RayShapes};
use super::zones::{Cutting, GridKernel, Sheets};
use super::{GROUP, Rays, Room};
use crate::footprint::FootprintShape;
use crate::kernel::GaussianKernel;
use crate::sheets::Planes;

/// Cut of kernels in depth for analytic gradients, standard deviations: there, voxels that appear and vanish by
/// rounding matter.
const DEPTH_CUT_EXACT: f64 = 4.7;

/// Sampling of voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// On planes, coefficients of a field: weights sum to one on the lattice.
    Field,
    /// On planes, classified voxels: a kernel of unit integral.
    Planes,
    /// Along rays, classified voxels: a kernel of unit integral.
    Rays,
}

/// Largest difference of the rays' tangents within a tile whose footprints along rays are those of its middle.
const WIDEST_TILE: f64 = 0.25;
/// Smallest edge of such tiles, pixels.
const LEAST_TILE: usize = 4;

/// View-dependent state of a frame, independent of the samples.
#[derive(Debug, Clone)]
pub struct GridView {
    camera_from_lattice: DAffine3,
    shape: FootprintShape,
    kernel: GaussianKernel,
    sheets: Sheets,
    extents: Extents,
    /// Reach of a voxel in depth, world length.
    reach: f64,
    groups: usize,
    round: bool,
    margin: [usize; 3],
    ray_shapes: RayShapes,
}

impl GridView {
    /// `spacing`: of the planes, world length, where other layers demand one.
    pub fn new(
        grid: &Grid,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        sampling: Sampling,
        spacing: Option<f64>,
    ) -> Self {
        let margin = grid.dims().map(|n| usize::from(n > 1));
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
        let first_point = -DVec3::from_array(margin.map(|m| m as f64));
        let linear = camera_from_voxel.matrix3;
        let kernel = match GaussianKernel::windowed(settings.method.kernel.into()) {
            kernel if settings.method.gradient == Gradient::Analytic => {
                kernel.without_tails_cut(DEPTH_CUT_EXACT)
            }
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
                None => settings.method.thickness * thinner_where_steep(steepest),
            };
            let groups = 2.0 * kernel.radius / thickness / GROUP as f64;
            match spacing {
                Some(spacing) => (spacing, whole_groups(groups)),
                None => {
                    let (finer, groups) = finer_sheets(groups, finer_rays(&shape, &screen, settings.size));
                    (thickness * per_voxel / finer, groups)
                }
            }
        };
        let ray_shapes = RayShapes {
            shape,
            screen,
            cell_volume: grid.cell_volume(),
        };
        let between = if along_rays {
            0.0
        } else {
            0.5 * (groups * GROUP - 1) as f64 * spacing
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
                low_pass: low_pass(settings.method.filter.into()),
                widths: Widths::of(settings),
                peak: peak(&kernel, reach_of_groups(groups, spacing) / per_voxel),
                steepest,
                along_rays,
                reach,
                shear: (shape.lateral_slope.abs() * between).to_array(),
                between,
                is_round: round,
            },
            reach,
            groups,
            round,
            margin,
            ray_shapes,
        }
    }
}

impl GridView {
    /// Shows only some of the intervals between planes, counted from depth 0; another level shows the others.
    pub(super) fn between(self, shown: &std::ops::Range<i64>) -> Self {
        Self {
            sheets: self.sheets.between(shown),
            ..self
        }
    }

    /// The intervals that it shows, counted from depth 0.
    pub(super) fn shown(&self) -> std::ops::Range<i64> {
        let Sheets {
            planes,
            first_shown,
            end,
            ..
        } = self.sheets;
        planes.first + first_shown as i64..planes.first + end as i64
    }
}

/// Views of several grids on common planes, at the distance of those that lie closest.
pub fn on_common_planes(
    grids: &[(&Grid, RenderSettings<SheetSettings>, Sampling)],
    camera: &Camera,
) -> Vec<GridView> {
    let view = |(grid, settings, sampling): &(&Grid, _, _), spacing| {
        GridView::new(grid, (camera, settings), *sampling, spacing)
    };
    let own: Vec<GridView> = grids.iter().map(|grid| view(grid, None)).collect();
    let closest = own.iter().map(GridView::spacing).fold(f64::INFINITY, f64::min);
    own.into_iter()
        .zip(grids)
        .map(|(own, grid)| {
            if own.spacing() == closest {
                own
            } else {
                view(grid, Some(closest))
            }
        })
        .collect()
}

/// Slabs of X-rays per voxel. One resolves depth well enough. But the footprints of voxels half a slab in front of
/// its middle or behind it are too small or too large, by the relative difference of their distances from the eye.
fn slabs_per_voxel(settings: &RenderSettings<SheetSettings>) -> f64 {
    match settings.method.gradient {
        Gradient::Analytic => 8.0,
        Gradient::Differences => 1.0,
    }
}

/// Depth at which X-rays in perspective begin, voxels.
const XRAY_FROM: f64 = 0.5;

/// Whether footprints are circles, and each sheet's lie behind each other.
fn is_round(shape: &FootprintShape) -> bool {
    let [xx, xy, yy] = shape.lateral_covariance;
    let drift = shape.lateral_slope.abs().max_element();
    xy.abs() < NEARLY_ROUND * xx && (xx - yy).abs() < NEARLY_ROUND * xx && drift < NEARLY_ROUND
}

impl GridView {
    /// Sheets that a voxel is splatted into.
    pub fn sheets_per_voxel(&self) -> u64 {
        (self.groups * GROUP) as u64
    }

    /// Groups of [`GROUP`] sheets that a voxel is splatted into.
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Room for footprints of neighbouring sheets.
    pub fn room(&self) -> Room {
        self.extents.room_of_footprints(self.sheets.planes.spacing)
    }

    /// Reach of a voxel's sheets in depth, world length; 0 where it is integrated along rays.
    pub fn reach_of_sheets(&self) -> f32 {
        if self.extents.along_rays {
            0.0
        } else {
            self.reach as f32
        }
    }

    /// Distance between planes, world length.
    pub fn spacing(&self) -> f64 {
        self.sheets.planes.spacing
    }

    /// Reach of a voxel in depth, world length.
    pub fn depth_reach(&self) -> f64 {
        self.reach
    }

    /// Distance in depth within which a voxel meets planes, world length.
    pub fn planes_reach(&self) -> f64 {
        reach_of_groups(self.groups, self.spacing())
    }

    /// Planes before, within and behind the grid.
    pub fn planes(&self) -> Planes {
        self.sheets.planes
    }

    /// The footprint on a plane with a raster point per pixel: its scale there, and the filter's low-pass.
    pub fn footprint_on(&self, plane: usize) -> SheetShape {
        let raster = self.extents.raster(0.0);
        SheetShape::new(
            &self.shape,
            &self.extents.screen,
            &raster,
            self.sheets.planes.plane(plane),
        )
    }

    /// The first visible interval between planes.
    pub fn first_shown(&self) -> usize {
        self.sheets.first_shown
    }

    /// One past the last visible interval between planes.
    pub fn end_shown(&self) -> usize {
        self.sheets.end
    }

    /// Whether the grid, grown by the reach of its kernel, extends behind a camera in perspective, or beyond the
    /// plane of parallel rays' origins.
    pub fn holds_eye(&self) -> bool {
        self.sheets.eye.is_some()
    }

    /// Footprints along rays.
    pub fn ray_shapes(&self) -> RayShapes {
        self.ray_shapes
    }

    /// Edge of tiles whose footprints along rays are those of the middle. It does not depend on the configured tile
    /// edge, which thus changes no picture; it is smaller at wide angles, where rays differ more.
    pub fn ray_tile_edge(&self, usual: usize) -> usize {
        if self.extents.steepest <= STEEP {
            return usual;
        }
        let pixels = WIDEST_TILE * self.extents.screen.scale;
        (pixels as usize / LEAST_TILE * LEAST_TILE).clamp(LEAST_TILE, usual)
    }

    fn kernels(&self) -> GridKernel {
        GridKernel {
            shape: self.shape,
            round: self.round,
            sheets: self.groups * GROUP,
            cut: self.kernel.cut(),
        }
    }

    /// Matrix of camera from voxel.
    pub fn camera_from_voxel(&self) -> DMat3 {
        self.camera_from_lattice.matrix3
    }

    /// Lattice points before the first sample along each axis.
    pub fn margin(&self) -> [usize; 3] {
        self.margin
    }

    /// Transformation to camera space from the lattice of a field, whose first point lies a margin before the first
    /// sample.
    pub fn camera_from_lattice(&self) -> DAffine3 {
        self.camera_from_lattice
    }

    /// The kernel on the grid.
    pub fn kernel(&self) -> &GaussianKernel {
        &self.kernel
    }

    /// The kernel in camera space.
    pub fn shape(&self) -> &FootprintShape {
        &self.shape
    }

    /// Rays of the pixels.
    pub fn rays(&self) -> Rays {
        Rays::new(&self.extents.screen)
    }

    pub(super) fn extents(&self) -> &Extents {
        &self.extents
    }

    pub(super) fn cutting(&self) -> Cutting<'_> {
        Cutting {
            extents: &self.extents,
            sheets: &self.sheets,
            kernels: self.kernels(),
        }
    }
}

/// Peak of a kernel of unit integral over the planes within a reach in depth, voxels: sums of weights have the mean one.
fn peak(kernel: &GaussianKernel, reach: f64) -> f64 {
    let lateral = 2.0 * std::f64::consts::PI * kernel.sigma * kernel.sigma;
    1.0 / (lateral * kernel.integral_within(reach))
}

/// Distance in depth within which so many groups of planes lie around a voxel, in the unit of their spacing.
fn reach_of_groups(groups: usize, spacing: f64) -> f64 {
    0.5 * (groups * GROUP) as f64 * spacing
}

/// Corners of a grid's whole lattice, camera space; unlike those of its needed part, they do not depend on the
/// transfer function.
fn corners(grid: &Grid, margin: [usize; 3], camera_from_lattice: DAffine3) -> [DVec3; 8] {
    let dims = grid.dims();
    std::array::from_fn(|i| {
        let last = |a: usize| (dims[a] + 2 * margin[a] - 1) as f64;
        let point = DVec3::from_array(std::array::from_fn(|a| (i >> a & 1) as f64 * last(a)));
        camera_from_lattice.transform_point3(point)
    })
}
