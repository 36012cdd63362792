//! Rays, clipping and frames.
//!
//! One ray per pixel, through the pixel's centre: `camera = origin + depth * direction`, `direction.z = 1`,
//! `dl = |direction| d depth`. It is clipped to depth > 0 and to the grid's box grown by the reach of the kernel.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use splatvol_scene::{
    Camera, Classification, Compositing, Frame, Image, RenderSettings, Scene, TransferFunction, Volume,
};

use crate::ReferenceError;
use crate::features::Features;
use crate::integral::{Optics, RayIntegral, Segment};
use crate::long_voxels::refined;
use crate::medium::{Medium, MediumSample, ViewGeometry};
use crate::ray_value::{RayValue, maximum, mean, minimum};
use crate::shading::Shading;

/// Sampling of rays that show one value relative to the initial step.
const SAMPLES_OF_VALUES_PER_STEP: f64 = 4.0;

/// Accuracy of the ray integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceSettings {
    /// Accepted difference between an interval and its halves, in optical depth and light reaching the eye; the
    /// error of a pixel is of that order.
    pub tolerance: f64,
    /// Longest interval before halving, voxels.
    pub initial_step: f64,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            initial_step: 0.5,
        }
    }
}

/// One pixel, as in [`Frame`] but in f64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelResult {
    /// Premultiplied linear RGBA, without background.
    pub rgba: [f64; 4],
    /// Mean camera depth that light comes from (see `docs/numerics.md`), world length; infinite where alpha is 0.
    pub depth: f64,
    /// `-ln` of the transmittance.
    pub optical_depth: f64,
}

impl PixelResult {
    const EMPTY: Self = Self {
        rgba: [0.0; 4],
        depth: f64::INFINITY,
        optical_depth: 0.0,
    };
}

/// A scene prepared for one camera and settings; renders any of its pixels.
#[derive(Debug, Clone)]
pub struct Reference {
    geometry: ViewGeometry,
    medium: Medium,
    features: Features,
    mode: Mode,
    settings: RenderSettings,
    options: ReferenceSettings,
    /// Voxel-space box outside of which every sum is 0.
    support: [DVec3; 2],
}

#[derive(Debug, Clone)]
enum Mode {
    Integral(Optics),
    /// One value per ray, in the transfer function's look.
    Value {
        of: ValueOf,
        transfer_function: TransferFunction,
        unit_distance: f64,
    },
}

/// Choice of the value that a ray shows.
#[derive(Debug, Clone, Copy)]
enum ValueOf {
    Largest,
    Smallest,
    Mean,
}

/// The part of a pixel's ray inside the support.
#[derive(Debug, Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
    /// Depths where it enters and leaves.
    depths: [f64; 2],
}

impl Ray {
    fn depth(&self, position: f64) -> f64 {
        self.depths[0] + position * (self.depths[1] - self.depths[0])
    }

    fn camera(&self, position: f64) -> DVec3 {
        self.origin + self.depth(position) * self.direction
    }
}

impl Reference {
    /// Solves the coefficients and classifies voxels, once for all pixels.
    ///
    /// # Errors
    /// Settings outside their domain, or a kernel that the prefilter cannot invert.
    pub fn new(
        scene: &Scene,
        camera: &Camera,
        settings: &RenderSettings,
        options: &ReferenceSettings,
    ) -> Result<Self, ReferenceError> {
        settings.validate()?;
        let single = scene.single_volume()?;
        let placed = single.placed()?;
        let value = |of| Mode::Value {
            of,
            transfer_function: single.transfer_function.clone(),
            unit_distance: single.unit_distance(),
        };
        let mode = match settings.method.compositing() {
            // Whole footprints, however they are composited, approximate the integral.
            Compositing::ImageSheets
            | Compositing::PerSplat
            | Compositing::PerSplatBackToFront
            | Compositing::AxisSheets => Mode::Integral(Optics::Absorbing),
            Compositing::Xray => Mode::Integral(Optics::Additive),
            Compositing::Mip => value(ValueOf::Largest),
            Compositing::MinimumIntensity => value(ValueOf::Smallest),
            Compositing::Mean => value(ValueOf::Mean),
        };
        let pre_shading = match settings.method.compositing() {
            Compositing::Xray => Some(None),
            shown if shown.shows_one_value() => None,
            _ if settings.method.classification() == Classification::Pre => {
                Some(settings.lighting.map(Shading::new))
            }
            _ => None,
        };
        let finer = match pre_shading {
            None if settings.method.prefilter() => refined(&placed)?,
            _ => None,
        };
        let volume: &Volume = finer.as_ref().unwrap_or(&placed);
        let geometry = ViewGeometry::new(volume, placed.grid().mean_spacing(), camera, settings)?;
        let (medium, features) = match pre_shading {
            Some(shading) => (Medium::pre(scene, &geometry, shading)?, Features::none()),
            None => (
                Medium::post(volume, &single, settings)?,
                Features::new(single.transfer_function, single.unit_distance()),
            ),
        };
        Ok(Self {
            support: support(&geometry, volume.grid().dims()),
            geometry,
            medium,
            features,
            mode,
            settings: *settings,
            options: *options,
        })
    }

    /// Renders every pixel, rows in parallel.
    pub fn frame(&self) -> Frame {
        let size = self.settings.size;
        let rows: Vec<Vec<PixelResult>> = (0..size.height())
            .into_par_iter()
            .map(|y| (0..size.width()).map(|x| self.pixel(x, y)).collect())
            .collect();
        let mut frame = Frame {
            image: Image::filled(size, [0.0; 4]),
            depth: vec![0.0; size.pixel_count()],
            optical_depth: vec![0.0; size.pixel_count()],
        };
        for (index, pixel) in rows.iter().flatten().enumerate() {
            frame.image.pixels[index] = pixel.rgba.map(|c| c as f32);
            frame.depth[index] = pixel.depth as f32;
            frame.optical_depth[index] = pixel.optical_depth as f32;
        }
        frame
    }

    /// Renders the pixel of column x and row y (which may lie outside the picture).
    pub fn pixel(&self, x: u32, y: u32) -> PixelResult {
        let screen = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let Some(ray) = self.ray(screen) else {
            return PixelResult::EMPTY;
        };
        let medium = |position: f64| self.medium.sample(&self.geometry, ray.camera(position));
        match &self.mode {
            Mode::Integral(optics) => {
                let integral = RayIntegral {
                    medium,
                    features: &self.features,
                    length: ray.direction.length() * (ray.depths[1] - ray.depths[0]),
                    tolerance: self.options.tolerance,
                    optics: *optics,
                };
                resolve(&integral.integrate(self.steps(&ray, 1.0)), &ray, *optics)
            }
            Mode::Value {
                of,
                transfer_function,
                unit_distance,
            } => {
                let found = self.value(*of, &ray, medium);
                found.map_or(PixelResult::EMPTY, |found| {
                    show_value(found, &ray, transfer_function, *unit_distance)
                })
            }
        }
    }

    fn value(&self, of: ValueOf, ray: &Ray, medium: impl Fn(f64) -> MediumSample) -> Option<RayValue> {
        let steps = self.steps(ray, SAMPLES_OF_VALUES_PER_STEP);
        match of {
            ValueOf::Largest => maximum(medium, steps),
            ValueOf::Smallest => minimum(medium, steps),
            ValueOf::Mean => mean(medium, steps),
        }
    }

    /// The ray of a screen position within the support and in front of the camera.
    fn ray(&self, screen: DVec2) -> Option<Ray> {
        let (origin, direction) = self.geometry.screen_from_camera.ray(screen);
        let voxel_origin = self.geometry.voxel_from_camera.transform_point3(origin);
        let voxel_direction = self.geometry.voxel_from_camera.transform_vector3(direction);
        let [low, high] = self.support;
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (from, along) = (voxel_origin[axis], voxel_direction[axis]);
            if along == 0.0 {
                if from < low[axis] || from > high[axis] {
                    return None;
                }
                continue;
            }
            let [a, b] = [(low[axis] - from) / along, (high[axis] - from) / along];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter < leave).then_some(Ray {
            origin,
            direction,
            depths: [enter, leave],
        })
    }

    fn steps(&self, ray: &Ray, per_step: f64) -> usize {
        let voxels = self
            .geometry
            .voxel_from_camera
            .transform_vector3(ray.direction)
            .length()
            * (ray.depths[1] - ray.depths[0]);
        (per_step * voxels / self.options.initial_step).ceil().max(1.0) as usize
    }
}

/// A value in its colour, as thick as the unit distance.
fn show_value(
    found: RayValue,
    ray: &Ray,
    transfer_function: &TransferFunction,
    unit_distance: f64,
) -> PixelResult {
    let optical_depth = transfer_function.extinction(found.value, unit_distance) * unit_distance;
    let alpha = -(-optical_depth).exp_m1();
    if alpha == 0.0 {
        return PixelResult::EMPTY;
    }
    let [r, g, b] = transfer_function.linear_color(found.value).map(|c| alpha * c);
    PixelResult {
        rgba: [r, g, b, alpha],
        depth: ray.depth(found.position),
        optical_depth,
    }
}

/// Colour, opacity and depth of an integrated ray.
fn resolve(segment: &Segment, ray: &Ray, optics: Optics) -> PixelResult {
    let alpha = -(-segment.tau).exp_m1();
    if alpha <= 0.0 {
        return PixelResult::EMPTY;
    }
    // Without absorption `light` is a plain integral: its mean is shown with the opacity.
    let [r, g, b, position] = match optics {
        Optics::Absorbing => segment.light,
        Optics::Additive => segment.light.map(|c| alpha * c / segment.tau),
    };
    PixelResult {
        rgba: [r, g, b, alpha],
        depth: ray.depth(position / alpha),
        optical_depth: segment.tau,
    }
}

/// The samples' box grown by the kernel's reach, low-passed as at the depth of its farthest corner.
fn support(geometry: &ViewGeometry, dims: [usize; 3]) -> [DVec3; 2] {
    let last = DVec3::from_array(dims.map(|n| n as f64 - 1.0));
    let radius = DVec3::splat(geometry.kernel.radius);
    let corners = splatvol_scene::Bounds {
        min: -radius,
        max: last + radius,
    }
    .corners();
    let depth_of = |voxel: DVec3| geometry.camera_from_voxel.transform_point3(voxel).z;
    // The low-pass acts in planes of constant depth, so that it moves nothing beyond this depth.
    let farthest = corners.into_iter().map(depth_of).fold(0.0, f64::max);
    let reach = match geometry.covariance(farthest) {
        None => radius,
        Some(covariance) => geometry.kernel.with_covariance(covariance).reach,
    };
    [-reach, last + reach]
}

/// Renders a frame.
///
/// # Errors
/// Same as [`Reference::new`].
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
    options: &ReferenceSettings,
) -> Result<Frame, ReferenceError> {
    Ok(Reference::new(scene, camera, settings, options)?.frame())
}

/// Renders some pixels (column, row) of a frame, in parallel.
///
/// # Errors
/// Same as [`Reference::new`].
pub fn render_pixels(
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
    options: &ReferenceSettings,
    pixels: &[(u32, u32)],
) -> Result<Vec<PixelResult>, ReferenceError> {
    let reference = Reference::new(scene, camera, settings, options)?;
    Ok(pixels.par_iter().map(|&(x, y)| reference.pixel(x, y)).collect())
}
