//! Layout: data as shaders read them. Sizes and offsets are those of `shaders/frame.wgsl`; a test compares them.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use splatvol_core::level::{Level, Wanted};
use splatvol_core::plan::{GridView, Rays};
use splatvol_scene::{Lighting, RenderSettings, SheetSettings};

use crate::effects::Effects;

/// Pixels of a tile, along x and y.
pub(crate) const TILE: [u32; 2] = [16, 16];

/// View-dependent and sample-independent data of a frame: `Frame` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct FrameData {
    pub size: [u32; 2],
    pub tiles: [u32; 2],
    pub principal: [f32; 2],
    pub per_pixel: f32,
    pub plane_per_pixel: f32,
    pub dims: [i32; 3],
    pub planes: u32,
    pub pages: [i32; 3],
    pub words: u32,
    pub margin: [f32; 3],
    pub sigma: f32,
    pub samples: [f32; 3],
    pub radius: f32,
    pub slots: [u32; 2],
    pub per_texel: [f32; 2],
    pub spacing: f32,
    pub background: f32,
    pub termination: f32,
    pub densest: f32,
    pub hull: [f32; 2],
    pub shows_background: u32,
    pub lit: u32,
    pub towards_light: [f32; 3],
    pub ambient: f32,
    pub half_way: [f32; 3],
    pub diffuse: f32,
    pub specular: f32,
    pub power: f32,
    pub floor_squared: f32,
    pub voxel: f32,
    pub from_interval: u32,
    pub to_interval: u32,
    pub first_plane: f32,
    pub unit_distance: f32,
    pub camera_from_lattice: [[f32; 4]; 4],
    pub bodies: u32,
    pub isosurfaces: u32,
    pub first_isosurface: u32,
    pub channel_layers: u32,
    pub first_tile_row: u32,
    pub gather_offset: i32,
    pub band_pixels: u32,
    pub gathered_intervals: u32,
    pub gradient_from_lattice: [[f32; 4]; 3],
    pub falls: [f32; 4],
    pub middle: [f32; 3],
    pub share: f32,
    pub interior: [f32; 3],
    pub share_step: f32,
}

/// A plane: `Sheet` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SheetData {
    pub cell: [i32; 3],
    pub depth: f32,
    pub rest: [f32; 3],
    pub scale: f32,
    pub step_x: [f32; 3],
    pub low_pass: f32,
    pub step_y: [f32; 3],
    pub low_pass_points: u32,
    pub low_pass_pixels: [f32; 4],
}

impl FrameData {
    /// Picture, rays and light alone.
    pub(crate) fn seen(settings: &RenderSettings<SheetSettings>, rays: &Rays) -> Self {
        let size = [settings.size.width(), settings.size.height()];
        let light = Light::new(settings.lighting.as_ref());
        Self {
            size,
            tiles: [size[0].div_ceil(TILE[0]), size[1].div_ceil(TILE[1])],
            principal: rays.principal,
            per_pixel: rays.per_pixel,
            plane_per_pixel: rays.plane_per_pixel,
            termination: settings.termination as f32,
            lit: u32::from(settings.lighting.is_some()),
            towards_light: light.towards,
            ambient: light.ambient,
            half_way: light.half_way,
            diffuse: light.diffuse,
            specular: light.specular,
            power: light.power,
            floor_squared: light.floor_squared,
            share: 1.0,
            ..Self::zeroed()
        }
    }
}

/// A picture of one level of a volume.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Picture<'a> {
    pub view: &'a GridView,
    pub level: &'a Level,
    pub settings: &'a RenderSettings<SheetSettings>,
    /// Mean distance of the volume's voxels, world length, at any level.
    pub voxel: f64,
    /// World length over which the opacity of a value that is shown by itself is taken.
    pub unit_distance: f64,
    pub effects: &'a Effects,
}

impl Picture<'_> {
    /// The frame's data; pages and atlas are the volume's.
    pub(crate) fn frame(&self) -> FrameData {
        let Self {
            view,
            level,
            settings,
            voxel,
            unit_distance,
            effects,
        } = *self;
        let planes = view.planes();
        let before = self.planes_at_eye();
        let count = planes.count + 1 + before;
        let kernel = view.kernel();
        // The CPU's kernels of classified voxels are whole Gaussians.
        let sigma = match Wanted::of(settings) {
            Wanted::Classified => kernel.sigma_before_cut(),
            _ => kernel.sigma,
        };
        let store = &level.field;
        FrameData {
            dims: store.dims().map(|n| n as i32),
            planes: count as u32,
            words: (count as u32).div_ceil(32),
            margin: store.margin().map(|n| n as f32),
            sigma: sigma as f32,
            samples: store.source().grid().dims().map(|n| n as f32),
            radius: kernel.radius as f32,
            spacing: planes.spacing as f32,
            background: store.background(),
            densest: level.table.densest,
            shows_background: u32::from(level.table.shows_background),
            voxel: voxel as f32,
            from_interval: view.first_shown() as u32,
            to_interval: (view.end_shown() + before) as u32,
            first_plane: self.first_plane() as f32,
            unit_distance: unit_distance as f32,
            camera_from_lattice: columns(&view.camera_from_lattice()),
            bodies: effects.bodies,
            isosurfaces: effects.isosurfaces,
            first_isosurface: effects.first_isosurface,
            gradient_from_lattice: gradients(&view.camera_from_lattice()),
            falls: falls(sigma),
            middle: store.dims().map(|n| 0.5 * (n as f32 - 1.0)),
            interior: interior(store.dims(), store.margin(), sigma),
            ..FrameData::seen(settings, &view.rays())
        }
    }

    /// Number of the first plane: its depth over the spacing.
    pub(crate) fn first_plane(&self) -> i64 {
        self.view.planes().first - self.planes_at_eye() as i64
    }

    /// Planes before those of the CPU, which begin at a depth of one spacing where rays diverge: the one at the eye, if the
    /// camera is within the volume.
    fn planes_at_eye(&self) -> usize {
        usize::from(self.view.rays().per_pixel > 0.0 && self.view.holds_eye())
    }

    /// The planes, front to back.
    pub(crate) fn sheets(&self) -> Vec<SheetData> {
        let lattice_from_camera = self.view.camera_from_lattice().inverse();
        let planes = self.view.planes();
        let at_eye = (self.planes_at_eye() > 0).then(|| unscaled(&lattice_from_camera, (0.0, 0.0)));
        let others = (0..=planes.count).map(|plane| self.sheet(&lattice_from_camera, plane));
        at_eye.into_iter().chain(others).collect()
    }

    /// Points of the widest low-pass along an axis.
    pub(crate) fn most_low_pass_points(&self) -> u32 {
        let points = self.sheets().iter().map(|sheet| sheet.low_pass_points).max();
        points.unwrap_or(1)
    }

    fn sheet(&self, lattice_from_camera: &DAffine3, plane: usize) -> SheetData {
        let depth = self.view.planes().plane(plane);
        let rays = self.view.rays();
        let pixel = if rays.per_pixel > 0.0 {
            f64::from(rays.per_pixel) * depth
        } else {
            f64::from(rays.plane_per_pixel)
        };
        let low_pass = f64::from(self.view.footprint_on(plane).low_pass);
        let [xx, xy, yy] = self.view.shape().lateral_covariance;
        let narrowest = 0.5 * (xx + yy - libm::hypot(xx - yy, 2.0 * xy));
        let [variance, narrowest_in_pixels] = [low_pass, narrowest].map(|own| own / (pixel * pixel));
        SheetData {
            scale: (1.0 / pixel) as f32,
            low_pass: variance.sqrt() as f32,
            low_pass_points: low_pass_points(low_pass / narrowest),
            low_pass_pixels: low_pass_pixels(variance, narrowest_in_pixels),
            ..unscaled(lattice_from_camera, (depth, pixel))
        }
    }
}

/// Points along an axis for a low-pass whose variance is so many times that of a footprint. The product of both has a
/// deviation of `1 / sqrt(1 + ratio)` of the low-pass, and equal steps of 1.3 of these are exact to rounding.
fn low_pass_points(ratio: f64) -> u32 {
    match ratio {
        0.0 => 1,
        small if small < 0.1 => 3,
        small if small < 0.4 => 5,
        _ => (4.5 * (1.0 + ratio).sqrt()).ceil() as u32 | 1,
    }
}

/// Variances of a kernel, squared pixels, above which sums at whole pixels say enough for a low-pass, and of the low-pass
/// relative to it.
const WIDE: f64 = 1.0;
const NARROW: f64 = 0.3;

/// Weights of pixels at distances of 0 to 3, whose sum over a row is one, for a low-pass of this variance over a kernel of
/// that one, squared pixels: those of the smallest squared error for a Gaussian kernel. At the bounds above, a single voxel's
/// peak errs by 6e-4. All zero beyond them.
fn low_pass_pixels(variance: f64, kernel: f64) -> [f32; 4] {
    if variance == 0.0 || kernel < WIDE || variance > NARROW * kernel {
        return [0.0; 4];
    }
    // Products of two Gaussians integrate to one of the sum of their variances, at their distance.
    let product =
        |distance: f64, variance: f64| (-0.5 * distance * distance / variance).exp() / variance.sqrt();
    // A basis function is a pair of kernels at a distance, less two in the middle.
    let own = |i: f64, j: f64| {
        let at = |distance: f64| product(distance, 2.0 * kernel);
        2.0 * (at(i - j) + at(i + j)) - 4.0 * (at(i) + at(j)) + 4.0 * at(0.0)
    };
    let wanted = |i: f64| {
        let at = |distance: f64| product(distance, 2.0 * kernel + variance) - product(distance, 2.0 * kernel);
        2.0 * (at(i) - at(0.0))
    };
    let columns = [1.0, 2.0, 3.0].map(|j| DVec3::new(own(1.0, j), own(2.0, j), own(3.0, j)));
    let normal = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let [one, two, three] = (normal.inverse() * DVec3::new(wanted(1.0), wanted(2.0), wanted(3.0))).to_array();
    [1.0 - 2.0 * (one + two + three), one, two, three].map(|weight| weight as f32)
}

/// Places on a plane of a depth, with pixels of this size; world length.
fn unscaled(lattice_from_camera: &DAffine3, (depth, pixel): (f64, f64)) -> SheetData {
    let at = lattice_from_camera.transform_point3(DVec3::Z * depth);
    let step = |along: DVec2| {
        lattice_from_camera
            .transform_vector3((along * pixel).extend(0.0))
            .as_vec3()
            .to_array()
    };
    SheetData {
        cell: at.floor().as_ivec3().to_array(),
        depth: depth as f32,
        rest: (at - at.floor()).as_vec3().to_array(),
        step_x: step(DVec2::X),
        step_y: step(DVec2::Y),
        low_pass_points: 1,
        ..SheetData::zeroed()
    }
}

/// The Phong model, as `splatvol_cpu` has it.
struct Light {
    towards: [f32; 3],
    half_way: [f32; 3],
    ambient: f32,
    diffuse: f32,
    specular: f32,
    power: f32,
    floor_squared: f32,
}

impl Light {
    fn new(lighting: Option<&Lighting>) -> Self {
        let lighting = lighting.copied().unwrap_or_default();
        let towards = DVec3::from_array(lighting.direction).normalize();
        let half_way = (towards - DVec3::Z).normalize();
        Self {
            towards: towards.as_vec3().to_array(),
            half_way: half_way.as_vec3().to_array(),
            ambient: lighting.ambient as f32,
            diffuse: lighting.diffuse as f32,
            specular: lighting.specular as f32,
            power: lighting.specular_power as f32,
            floor_squared: lighting.gradient_floor.powi(2) as f32,
        }
    }
}

pub(crate) fn columns(map: &DAffine3) -> [[f32; 4]; 4] {
    let column = |v: DVec3, w: f64| v.extend(w).as_vec4().to_array();
    let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
    [
        column(x, 0.0),
        column(y, 0.0),
        column(z, 0.0),
        column(map.translation, 1.0),
    ]
}

/// A Gaussian's `log2(e) / sigma^2`, and its values at distances of 1, 2 and 3 voxels.
fn falls(sigma: f64) -> [f32; 4] {
    let per_voxel = 1.0 / (sigma * sigma);
    let at = |distance: f64| (-0.5 * distance * distance * per_voxel).exp();
    [std::f64::consts::LOG2_E * per_voxel, at(1.0), at(2.0), at(3.0)].map(|number| number as f32)
}

/// Voxels from the lattice's first and last within which some weights lie beyond it.
const BESIDE: f64 = 2.0;
/// Deviations of the kernel from a face within which it takes coverage away: `FAR` in WGSL.
const FAR: f64 = 3.4;

/// Distances from the lattice's middle within which all weights lie on the lattice, and coverage is one, less rounding.
fn interior(dims: [usize; 3], margin: [usize; 3], sigma: f64) -> [f32; 3] {
    std::array::from_fn(|axis| {
        let from_face = BESIDE.max(margin[axis] as f64 - 0.5 + FAR * sigma);
        (0.5 * (dims[axis] as f64 - 1.0) - from_face - 0.01) as f32
    })
}

/// Columns of the map of gradients from the space of a map's input to that of its output.
pub(crate) fn gradients(map: &DAffine3) -> [[f32; 4]; 3] {
    let transposed = map.matrix3.inverse().transpose();
    [transposed.x_axis, transposed.y_axis, transposed.z_axis].map(|v| v.extend(0.0).as_vec4().to_array())
}

#[cfg(test)]
mod tests {
    use super::low_pass_pixels;

    #[test]
    fn pixels_stand_for_a_low_pass() {
        let gaussian = |x: f64, variance: f64| (-0.5 * x * x / variance).exp() / variance.sqrt();
        for (variance, kernel, most) in [
            (0.3, 1.0, 6e-4),
            (0.3, 2.0, 7e-5),
            (0.3, 4.0, 3e-6),
            (1.0, 4.0, 2e-4),
        ] {
            let [zero, one, two, three] = low_pass_pixels(variance, kernel).map(f64::from);
            assert!((zero + 2.0 * (one + two + three) - 1.0).abs() < 1e-6);
            for step in 0..400 {
                let x = f64::from(step) * 0.02;
                let pair = |at: f64| gaussian(x - at, kernel) + gaussian(x + at, kernel);
                let found =
                    zero * gaussian(x, kernel) + one * pair(1.0) + two * pair(2.0) + three * pair(3.0);
                let error = (found - gaussian(x, kernel + variance)).abs() * kernel.sqrt();
                assert!(error < most, "{variance} {kernel}, {x}: {error:e}");
            }
        }
        for beyond in [(0.0, 4.0), (0.3, 0.9), (1.5, 4.0)] {
            assert_eq!(low_pass_pixels(beyond.0, beyond.1), [0.0; 4]);
        }
    }
}
