//! Projection: splats to footprints, by one of the papers' alignments and low-pass filters.
//!
//! With u a splat's centre and V' its covariance in camera space, s pixels per world length at its depth and
//!
//! `J = [[s, 0, -s x / z], [0, s, -s y / z], [0, 0, 1]]`   (zwicker2001 eq. 25; depth in place of distance as third
//! coordinate)
//!
//! the *affine* footprint has the screen covariance `V2 = (J V' J^T)_2x2`, plus the low-pass (`low_pass`), and the
//! centre weight `m s^2 l q(0) / sqrt|V2|`: m the kernel's integral, `l = |(x, y, z)| / z` the path per depth. A
//! ray's nearest point to the centre moves by `Q b` in depth per pixel, `b = V_depth,screen`, and the standard
//! deviation in depth left on it is `V_zz - b^T Q b`. The *grid-aligned* footprint leaves the
//! third column of J out, as if all rays were parallel to the axis (mueller1998 table 1, row 5): the integrals that
//! it holds run along the axis, so their path per depth is 1, too. The others whiten camera space (`rays`,
//! `splats::Ray`); *auto* has affine footprints where the estimate of `errors` allows them.
//!
//! Kernels in whitened space that reach before the near plane keep the part behind it. Affine ones, which are
//! linear about their centre, are dropped if the centre is before it.

mod bounds;
mod errors;
mod low_pass;
mod matrix;
mod moved;
mod rays;

pub use bounds::Bounds;
pub use errors::AlignmentErrors;

use glam::{Affine3A, DAffine3, DMat3, DVec2, DVec3, Mat3, Vec3};
use splatvol_scene::{Alignment, Filter, ImageSize, ScreenFromCamera, Stretch};

use self::errors::Sensitivity;
use self::low_pass::Filtered;
use self::matrix::{
    Covariance, add_square, along, determinant, seen_along, singular_values, symmetric, transformed,
};
use super::cloud::{KernelShape, SplatCloud};
use super::footprint::{Footprint, Warp};
use super::profile::Profile;
use super::sweep::Sweep;

/// Tangents beyond this many times the picture's are cut in the derivative of the projection, as in the published
/// renderer of Gaussians: footprints that begin outside the picture would grow without bounds.
const TANGENT_LIMIT: f64 = 1.3;
/// Least steepness of a surface: below, the gradient's direction is rounding.
const LEAST_STEEPNESS: f32 = 1e-7;

/// A camera with its picture.
#[derive(Debug, Clone, Copy)]
pub struct CameraView {
    /// World to camera.
    pub camera_from_world: DAffine3,
    /// Camera to pixels.
    pub screen: ScreenFromCamera,
    /// Pixels.
    pub size: ImageSize,
    /// Near plane, camera depth; nothing nearer is drawn.
    pub near: f64,
}

/// Data shared by all footprints of a frame.
#[derive(Debug, Clone)]
pub struct Projection<'a> {
    cloud: &'a SplatCloud,
    filter: Filter,
    alignment: Alignment,
    stretch: Stretch,
    /// Camera depth from which footprints lie parallel to the picture, where the alignment switches.
    switch: f64,
    perspective: bool,
    /// f in pixels (perspective) or m in pixels per world length (orthographic).
    scale: f64,
    principal: DVec2,
    near: f64,
    camera_from_local: Affine3A,
    /// Its linear part, for covariances.
    linear: DMat3,
    /// Camera covariance of a sphere of the cloud.
    sphere: Covariance,
    /// From gradients per local unit to gradients per mean spacing.
    steepness_from_local: Mat3,
    /// Standard deviation of a sphere, local units.
    sigma: f64,
    /// Integral of the kernel times the profile's peak.
    mass: f64,
    cut: f64,
    sensitivity: Sensitivity,
    /// Largest standard deviation of any splat in any direction, world length.
    reach: f64,
    /// World length per local unit, in the direction of the largest stretch.
    stretch_from_local: f64,
    /// Largest ratio of standard deviations of a sphere of the cloud.
    anisotropy: f64,
    /// Rays' largest x and y per depth, with a margin: the Jacobian of splats farther outside is taken there.
    widest: DVec2,
    /// Motion while the shutter is open.
    sweep: Option<Sweep>,
}

impl<'a> Projection<'a> {
    /// Projection of a cloud whose kernels have this profile; the swan filter stretches them as a box.
    pub fn new(
        cloud: &'a SplatCloud,
        view: &CameraView,
        (filter, alignment): (Filter, Alignment),
        profile: &impl Profile,
    ) -> Self {
        let camera_from_local = view.camera_from_world * cloud.world_from_local;
        let linear = camera_from_local.matrix3;
        let sigma = cloud.shape.sigma();
        let [least, most] = singular_values(linear);
        let screen = view.screen;
        let size = DVec2::new(f64::from(view.size.width()), f64::from(view.size.height()));
        let corner = (size - screen.centre).max(screen.centre) / screen.scale;
        Self {
            cloud,
            filter,
            alignment,
            stretch: Stretch::Box,
            switch: match alignment {
                Alignment::Switch { behind } => cloud.spacing * (screen.scale + behind),
                _ => f64::INFINITY,
            },
            perspective: screen.perspective,
            scale: screen.scale,
            principal: screen.centre,
            near: view.near,
            camera_from_local: Affine3A::from_mat3_translation(
                linear.as_mat3(),
                camera_from_local.translation.as_vec3(),
            ),
            linear,
            sphere: symmetric(linear * linear.transpose() * sigma.powi(2)),
            steepness_from_local: cloud.steepness_from_local().as_mat3(),
            sigma,
            mass: cloud.mass * f64::from(profile.peak()),
            cut: f64::from(profile.cut()),
            sensitivity: Sensitivity::new(profile),
            reach: most * sigma,
            stretch_from_local: most,
            anisotropy: most / least,
            widest: corner * TANGENT_LIMIT,
            sweep: None,
        }
    }

    /// Sets another stretch by the swan filter; for exact alignment only.
    #[must_use]
    pub fn with_stretch(self, stretch: Stretch) -> Self {
        Self { stretch, ..self }
    }

    /// The chunks of the cloud.
    pub fn chunks(&self) -> &[super::Chunk] {
        &self.cloud.chunks
    }

    /// Largest reach of kernels in depth while the shutter is open, world length.
    pub fn depth_reach(&self) -> f32 {
        let change = self.sweep.as_ref().map_or(0.0, |sweep| sweep.depth_change);
        (self.cut * self.reach) as f32 + 0.5 * change
    }

    /// Reach of a splat's kernel in depth while the shutter is open, world length.
    #[inline(always)]
    pub fn reach_of(&self, splat: usize) -> f32 {
        match self.cloud.covariances.get(splat) {
            // Only grids move.
            Some(own) => {
                let depth = along(own.map(f64::from), self.linear.row(2));
                (self.cut * depth.max(0.0).sqrt()) as f32
            }
            None => self.depth_reach(),
        }
    }

    /// Centre of a splat, camera space.
    #[inline(always)]
    pub fn centre(&self, splat: usize) -> Vec3 {
        let local = Vec3::from_array(self.cloud.positions[splat]);
        self.camera_from_local.transform_point3(local)
    }

    /// The footprint of a splat; `None` where it cannot be seen.
    #[inline(always)]
    pub fn project(&self, splat: usize) -> Option<Footprint> {
        let u = self.centre(splat).as_dvec3();
        let covariance = self.covariance(splat);
        let still = self.still(u, covariance)?;
        match &self.sweep {
            None => Some(still),
            Some(sweep) => self.moved(sweep, splat, (still, u, covariance)),
        }
    }

    /// The footprint of a splat at rest.
    #[inline(always)]
    fn still(&self, u: DVec3, covariance: Covariance) -> Option<Footprint> {
        if !self.perspective {
            return Some(self.affine(u, covariance));
        }
        match self.alignment {
            Alignment::Sheet | Alignment::Affine | Alignment::Grid => {
                (u.z > self.near).then(|| self.affine(u, covariance))
            }
            Alignment::Switch { .. } if u.z >= self.switch => Some(self.affine(u, covariance)),
            Alignment::Switch { .. } => self.across_rays(u, self.across_ray(u, covariance)),
            Alignment::Ray => self.across_rays(u, self.across_ray(u, covariance)),
            Alignment::RayIdeal => self.along_rays(u, self.across_ray(u, covariance)),
            Alignment::Exact if self.is_swan() => self.stretched(u, covariance),
            Alignment::Exact => self.along_rays(u, self.in_space(u, covariance)),
            Alignment::Auto { budget } => {
                let filtered = self.in_space(u, covariance);
                if self.is_affine_enough(u, filtered.covariance, budget) {
                    Some(self.linear(u, filtered, u.truncate() / u.z))
                } else {
                    self.along_rays(u, filtered)
                }
            }
        }
    }

    /// Camera covariance of a splat.
    #[inline(always)]
    fn covariance(&self, splat: usize) -> Covariance {
        let (flatness, threshold) = match self.cloud.shape {
            KernelShape::Sphere { .. } => return self.sphere,
            KernelShape::Ellipsoids { .. } => return self.own_covariance(splat),
            KernelShape::Flattened {
                flatness, threshold, ..
            } => (flatness, threshold),
        };
        let gradient = self
            .cloud
            .gradients
            .get(splat)
            .copied()
            .map_or(Vec3::ZERO, Vec3::from_array);
        let steepness = (self.steepness_from_local * gradient).length();
        if steepness <= (threshold as f32).max(LEAST_STEEPNESS) {
            return self.sphere;
        }
        let lost = 1.0 - 1.0 / (flatness * flatness);
        let normal = self.camera_from_local.transform_vector3(gradient.normalize());
        add_square(self.sphere, normal.as_dvec3() * self.sigma, -lost.clamp(0.0, 1.0))
    }

    /// Camera covariance `A C A^T` of a splat that has its own.
    #[inline(always)]
    fn own_covariance(&self, splat: usize) -> Covariance {
        transformed(self.cloud.covariances[splat].map(f64::from), self.linear)
    }

    /// The affine or grid-aligned footprint, filtered on screen.
    #[inline(always)]
    fn affine(&self, u: DVec3, covariance: Covariance) -> Footprint {
        let ray = if self.perspective {
            u.truncate() / u.z
        } else {
            DVec2::ZERO
        };
        let parallel = self.is_grid_aligned(u.z);
        let along = if parallel {
            DVec2::ZERO
        } else {
            ray.clamp(-self.widest, self.widest)
        };
        let scale = self.pixels_per_length(u.z);
        let screen = seen_along(covariance, along).map(|v| v * scale * scale);
        let path = if parallel {
            1.0
        } else {
            (1.0 + ray.length_squared()).sqrt()
        };
        let filtered = self.on_screen(u.z, along, screen);
        self.lean((u, covariance), (along, path), filtered)
    }

    /// Whether footprints at a depth are integrated along the viewing axis.
    #[inline(always)]
    fn is_grid_aligned(&self, depth: f64) -> bool {
        match self.alignment {
            Alignment::Grid => true,
            Alignment::Switch { .. } => !self.perspective || depth >= self.switch,
            _ => false,
        }
    }

    /// Length per depth of the path along which footprints at a depth integrate kernels, for a ray of this x and y per
    /// depth.
    #[inline(always)]
    pub fn path_per_depth(&self, ray: [f32; 2], depth: f32) -> f32 {
        if self.is_grid_aligned(f64::from(depth)) {
            return 1.0;
        }
        let [x, y] = ray;
        (1.0 + x * x + y * y).sqrt()
    }

    /// The affine footprint of a filtered covariance.
    #[inline(always)]
    fn linear(&self, u: DVec3, filtered: Filtered<Covariance>, along: DVec2) -> Footprint {
        let scale = self.pixels_per_length(u.z);
        let screen = seen_along(filtered.covariance, along).map(|v| v * scale * scale);
        let path = (1.0 + along.length_squared()).sqrt();
        let filtered_screen = Filtered {
            covariance: screen,
            widening: 1.0,
        };
        Footprint {
            opacity: self.opacity(filtered.widening),
            ..self.lean((u, filtered.covariance), (along, path), filtered_screen)
        }
    }

    /// A footprint on the screen, with the lean of its kernel in depth.
    #[inline(always)]
    fn lean(
        &self,
        (u, [_, _, xz, _, yz, zz]): (DVec3, Covariance),
        (along, path): (DVec2, f64),
        Filtered {
            covariance: [xx, xy, yy],
            widening,
        }: Filtered<[f64; 3]>,
    ) -> Footprint {
        let scale = self.pixels_per_length(u.z);
        let b = DVec2::new(xz - along.x * zz, yz - along.y * zz) * (scale * widening);
        let inverse = 1.0 / determinant([xx, xy, yy]).max(1e-20);
        let conic = [yy * inverse, -xy * inverse, xx * inverse];
        let slope = DVec2::new(conic[0] * b.x + conic[1] * b.y, conic[1] * b.x + conic[2] * b.y);
        let centre = u.truncate() * scale + self.principal;
        let half = DVec2::new(xx, yy).map(f64::sqrt) * self.cut;
        let (low, high) = ((centre - half).as_vec2(), (centre + half).as_vec2());
        Footprint {
            centre: centre.as_vec2().to_array(),
            bounds: [low.x, low.y, high.x, high.y],
            weight: (self.mass * scale * scale * path * inverse.sqrt()) as f32,
            opacity: self.opacity(widening),
            depth: u.z as f32,
            depth_sigma: (zz - slope.dot(b)).max(0.0).sqrt() as f32,
            clip: f32::NEG_INFINITY,
            warp: Warp::Affine {
                conic: conic.map(|v| v as f32),
                slope: slope.as_vec2().to_array(),
            },
        }
    }
}
