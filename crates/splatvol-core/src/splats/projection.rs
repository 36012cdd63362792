//! Projection: splats to footprints, by one of the papers' alignments and low-pass filters.
//!
//! With u a splat's centre and V' its covariance in camera space, s pixels per world length at its depth and
//!
//! `J = [[s, 0, -s x / z], [0, s, -s y / z], [0, 0, 1]]`   (zwicker2001 eq. 25; depth in place of distance as third coordinate)
//!
//! the *affine* footprint has the screen covariance `V2 = (J V' J^T)_2x2`, plus the low-pass (eq. 22), and the centre weight
//! `m s^2 l q(0) / sqrt|V2|`: m the kernel's integral, `l = |(x, y, z)| / z` the path per depth. A ray's nearest point to the
//! centre moves by `Q b` in depth per pixel, `b = V_depth,screen`, and the standard deviation in depth left on it is
//! `V_zz - b^T Q b` (design section 5). The *grid-aligned* footprint leaves the third column of J out, as if all rays were
//! parallel to the axis (mueller1998 table 1, row 5). The *exact* one whitens camera space (`splats::Ray`).
//!
//! Low-pass filters: `ewa` adds `pixel_sigma^2 I` to V2. `matched` adds what the narrower axis lacks to it. `swan` scales V2
//! by `a^2`, `a = max(1, 1 / (s spacing))`, the spacing being that of the narrowest direction, which is `d / k` of swan1997 eq.
//! 3-4 for a cubic grid; as the weight has `sqrt|V2|` below, extinction falls by eq. 8 of itself. In orthographic views,
//! where k is not defined, a is the same comparison of voxel and pixel.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3};
use splatvol_scene::{Alignment, Filter, ImageSize, ScreenFromCamera};

use super::cloud::{Chunk, KernelShape, SplatCloud};
use super::footprint::{Footprint, Ray, Warp};
use super::profile::Profile;

/// A camera with its picture.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// World to camera.
    pub camera_from_world: DAffine3,
    /// Camera to pixels.
    pub screen: ScreenFromCamera,
    /// Pixels.
    pub size: ImageSize,
    /// What is nearer is not seen, camera depth.
    pub near: f64,
}

/// Symmetric 3 x 3: xx, xy, xz, yy, yz, zz.
type Covariance = [f32; 6];

/// All that footprints of a frame have in common.
#[derive(Debug, Clone)]
pub struct Projection<'a> {
    cloud: &'a SplatCloud,
    filter: Filter,
    alignment: Alignment,
    perspective: bool,
    /// f or m.
    scale: f32,
    principal: Vec2,
    near: f32,
    camera_from_local: Affine3A,
    /// Camera covariance of a sphere of the cloud.
    sphere: Covariance,
    /// From gradients per local unit to gradients per mean spacing.
    steepness_from_local: Mat3,
    /// Standard deviation of a sphere, local units.
    sigma: f32,
    /// Integral of the kernel times the profile's peak.
    mass: f32,
    cut: f32,
    /// Largest standard deviation of any splat in any direction, world length.
    reach: f32,
    /// Largest ratio of standard deviations of a sphere of the cloud.
    anisotropy: f32,
    /// Rays' largest x and y per depth, with some more: the Jacobian of what lies farther outside is taken there.
    widest: Vec2,
}

/// Where a chunk's footprints can lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// x0, y0, x1, y1, pixels.
    pub rect: [f32; 4],
    /// Least and greatest camera depth that kernels reach.
    pub depth: [f32; 2],
}

impl<'a> Projection<'a> {
    /// Projection of a cloud whose kernels have this profile.
    pub fn new(
        cloud: &'a SplatCloud,
        view: &View,
        (filter, alignment): (Filter, Alignment),
        profile: &impl Profile,
    ) -> Self {
        let camera_from_local = view.camera_from_world * cloud.world_from_local;
        let linear = camera_from_local.matrix3;
        let sigma = cloud.shape.sigma();
        let covariance = linear * linear.transpose() * sigma.powi(2);
        let [least, most] = singular_values(linear);
        let screen = view.screen;
        let size = DVec3::new(f64::from(view.size.width()), f64::from(view.size.height()), 0.0).truncate();
        let corner = (size - screen.centre).max(screen.centre) / screen.scale;
        Self {
            cloud,
            filter,
            alignment,
            perspective: screen.perspective,
            scale: screen.scale as f32,
            principal: screen.centre.as_vec2(),
            near: view.near as f32,
            camera_from_local: Affine3A::from_mat3_translation(
                linear.as_mat3(),
                camera_from_local.translation.as_vec3(),
            ),
            sphere: symmetric(covariance),
            steepness_from_local: cloud.steepness_from_local().as_mat3(),
            sigma: sigma as f32,
            mass: (cloud.mass * f64::from(profile.peak())) as f32,
            cut: profile.cut(),
            reach: (most * sigma) as f32,
            anisotropy: (most / least) as f32,
            widest: (corner * 1.3).as_vec2(),
        }
    }

    /// How far kernels reach in depth at most, world length.
    pub fn depth_reach(&self) -> f32 {
        self.cut * self.reach
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
        let centre = self.centre(splat);
        if self.perspective && centre.z <= self.near {
            return None;
        }
        let covariance = self.covariance(splat);
        if self.perspective && self.alignment == Alignment::Exact {
            self.along_rays(centre, covariance)
        } else {
            Some(self.affine(centre, covariance))
        }
    }

    /// Camera covariance of a splat.
    #[inline(always)]
    fn covariance(&self, splat: usize) -> Covariance {
        let KernelShape::Flattened {
            flatness, threshold, ..
        } = self.cloud.shape
        else {
            return self.sphere;
        };
        let gradient = self
            .cloud
            .gradients
            .get(splat)
            .copied()
            .map_or(Vec3::ZERO, Vec3::from_array);
        let steepness = (self.steepness_from_local * gradient).length();
        if steepness <= (threshold as f32).max(1e-7) {
            return self.sphere;
        }
        let lost = 1.0 - 1.0 / (flatness * flatness) as f32;
        let normal = self.camera_from_local.transform_vector3(gradient.normalize())
            * (self.sigma * lost.max(0.0).sqrt());
        let [xx, xy, xz, yy, yz, zz] = self.sphere;
        let Vec3 { x, y, z } = normal;
        [
            xx - x * x,
            xy - x * y,
            xz - x * z,
            yy - y * y,
            yz - y * z,
            zz - z * z,
        ]
    }

    #[inline(always)]
    fn affine(&self, u: Vec3, [vxx, vxy, vxz, vyy, vyz, vzz]: Covariance) -> Footprint {
        let (scale, ray) = self.scale_and_ray(u);
        let along = if self.alignment == Alignment::Grid {
            Vec2::ZERO
        } else {
            ray.clamp(-self.widest, self.widest)
        };
        let area = scale * scale;
        let mut screen = [
            area * (vxx - 2.0 * along.x * vxz + along.x * along.x * vzz),
            area * (vxy - along.x * vyz - along.y * vxz + along.x * along.y * vzz),
            area * (vyy - 2.0 * along.y * vyz + along.y * along.y * vzz),
        ];
        let mut b = Vec2::new(vxz - along.x * vzz, vyz - along.y * vzz) * scale;
        let widening = self.low_pass(&mut screen);
        b *= widening;
        let [xx, xy, yy] = screen;
        let determinant = (xx * yy - xy * xy).max(1e-20);
        let inverse = 1.0 / determinant;
        let conic = [yy * inverse, -xy * inverse, xx * inverse];
        let slope = Vec2::new(conic[0] * b.x + conic[1] * b.y, conic[1] * b.x + conic[2] * b.y);
        let centre = u.truncate() * scale + self.principal;
        let half = Vec2::new(xx, yy).map(f32::sqrt) * self.cut;
        let path = if self.perspective {
            (1.0 + ray.length_squared()).sqrt()
        } else {
            1.0
        };
        Footprint {
            centre: centre.to_array(),
            bounds: box_of(centre - half, centre + half),
            weight: self.mass * area * path * inverse.sqrt(),
            opacity: self.opacity(widening),
            depth: u.z,
            depth_sigma: (vzz - slope.dot(b)).max(0.0).sqrt(),
            warp: Warp::Affine {
                conic,
                slope: slope.to_array(),
            },
        }
    }

    /// Pixels per world length at a point, and its ray's x and y per depth.
    #[inline(always)]
    fn scale_and_ray(&self, u: Vec3) -> (f32, Vec2) {
        if self.perspective {
            let inverse = 1.0 / u.z;
            (self.scale * inverse, u.truncate() * inverse)
        } else {
            (self.scale, Vec2::ZERO)
        }
    }

    /// Filters a screen covariance. Returns by what the footprint was scaled.
    #[inline(always)]
    fn low_pass(&self, screen: &mut [f32; 3]) -> f32 {
        let widened = match self.filter {
            Filter::None => return 1.0,
            Filter::Ewa { pixel_sigma } => pixel_sigma as f32 * pixel_sigma as f32,
            Filter::Matched { pixel_sigma } => {
                (pixel_sigma as f32 * pixel_sigma as f32 - least_variance(*screen)).max(0.0)
            }
            Filter::Swan | Filter::SwanAlpha => {
                let widening = self.widening(*screen);
                *screen = screen.map(|v| v * widening * widening);
                return widening;
            }
        };
        screen[0] += widened;
        screen[2] += widened;
        1.0
    }

    /// `max(1, d / k)`: a standard deviation of the kernel is `sigma` spacings, so spacings are what `V2` says.
    #[inline(always)]
    fn widening(&self, screen: [f32; 3]) -> f32 {
        let spacing = least_variance(screen).max(1e-12).sqrt() / self.sigma;
        (1.0 / spacing).max(1.0)
    }

    #[inline(always)]
    fn opacity(&self, widening: f32) -> f32 {
        if self.filter == Filter::SwanAlpha {
            1.0 / (widening * widening)
        } else {
            1.0
        }
    }

    /// Whitens camera space about a splat, the low-pass being a covariance there, as wide as it is at the splat's depth.
    #[inline(always)]
    fn along_rays(&self, u: Vec3, covariance: Covariance) -> Option<Footprint> {
        let (scale, ray) = self.scale_and_ray(u);
        let [mut xx, mut xy, xz, mut yy, yz, zz] = covariance;
        let mut screen = [xx, xy, yy].map(|v| v * scale * scale);
        let widening = self.low_pass(&mut screen);
        [xx, xy, yy] = screen.map(|v| v / (scale * scale));
        let (xz, yz) = (xz * widening, yz * widening);
        let [l00, l10, l11, l20, l21, l22] = cholesky([xx, xy, xz, yy, yz, zz]);
        let (i00, i11, i22) = (1.0 / l00, 1.0 / l11, 1.0 / l22);
        let i10 = -l10 * i00 * i11;
        let i21 = -l21 * i11 * i22;
        let i20 = -(l20 * i00 + l21 * i10) * i22;
        let whitening = [i00, i10, i11, i20, i21, i22];
        let centre = [
            i00 * u.x,
            i10 * u.x + i11 * u.y,
            i20 * u.x + i21 * u.y + i22 * u.z,
        ];
        let warp = Ray {
            whitening,
            centre,
            principal: self.principal.to_array(),
            per_pixel: 1.0 / self.scale,
        };
        let cut = self.cut * self.cut;
        let axis = |position: f32, own: f32, cross: f32| {
            silhouette([
                position * position - cut * own,
                position * u.z - cut * cross,
                u.z * u.z - cut * zz,
            ])
        };
        let ([x0, x1], [y0, y1]) = (axis(u.x, xx, xz), axis(u.y, yy, yz));
        let (low, high) = (Vec2::new(x0, y0), Vec2::new(x1, y1));
        let at_centre = warp.at((ray * self.scale + self.principal).to_array());
        Some(Footprint {
            centre: (ray * self.scale + self.principal).to_array(),
            bounds: box_of(
                low * self.scale + self.principal,
                high * self.scale + self.principal,
            ),
            weight: self.mass * i00 * i11 * i22,
            opacity: self.opacity(widening),
            depth: u.z,
            depth_sigma: at_centre.depth_sigma,
            warp: Warp::Ray(warp),
        })
    }

    /// Where a chunk's footprints can lie; `None` behind the camera.
    pub fn bounds(&self, chunk: &Chunk) -> Option<Bounds> {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for corner in 0..8 {
            let local = std::array::from_fn(|a| {
                if corner >> a & 1 == 0 {
                    chunk.low[a]
                } else {
                    chunk.high[a]
                }
            });
            let point = self.camera_from_local.transform_point3(Vec3::from_array(local));
            (low, high) = (low.min(point), high.max(point));
        }
        if self.perspective && high.z <= self.near {
            return None;
        }
        let reach = self.depth_reach();
        let depth = [low.z - reach, high.z + reach];
        let near = low.z.max(self.near);
        let scales = if self.perspective {
            [self.scale / near, self.scale / high.z.max(near)]
        } else {
            [self.scale; 2]
        };
        let at = |v: Vec2, pick: fn(Vec2, Vec2) -> Vec2| pick(v * scales[0], v * scales[1]);
        let (first, last) = (at(low.truncate(), Vec2::min), at(high.truncate(), Vec2::max));
        // An oblique footprint is as long as the ray is oblique, and no ray of the picture is more so than this. True rays
        // meet kernels that lie near the eye farther out than their centres say.
        let oblique = if self.perspective {
            (1.0 + self.widest.length_squared()).sqrt()
        } else {
            1.0
        };
        let close = if self.perspective && self.alignment == Alignment::Exact {
            near / (near - oblique * reach).max(0.05 * near)
        } else {
            1.0
        };
        let margin = self.cut * self.pixel_margin() + oblique * oblique * close * reach * scales[0];
        let rect = box_of(first + self.principal - margin, last + self.principal + margin);
        Some(Bounds { rect, depth })
    }

    /// What the filter may add to a footprint's standard deviation, pixels.
    fn pixel_margin(&self) -> f32 {
        match self.filter {
            Filter::None => 0.0,
            Filter::Ewa { pixel_sigma } | Filter::Matched { pixel_sigma } => pixel_sigma as f32,
            Filter::Swan | Filter::SwanAlpha => self.sigma * self.anisotropy * 2.0,
        }
    }
}

fn box_of(low: Vec2, high: Vec2) -> [f32; 4] {
    [low.x, low.y, high.x, high.y]
}

fn symmetric(m: DMat3) -> Covariance {
    [
        m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z,
    ]
    .map(|v| v as f32)
}

/// The smaller eigenvalue of a 2 x 2 covariance.
#[inline(always)]
fn least_variance([xx, xy, yy]: [f32; 3]) -> f32 {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    (mean - (half * half + xy * xy).sqrt()).max(0.0)
}

/// Lower triangle 00, 10, 11, 20, 21, 22 with `L L^T` the covariance; a flat kernel keeps a thousandth of its width.
#[inline(always)]
fn cholesky([xx, xy, xz, yy, yz, zz]: Covariance) -> [f32; 6] {
    let least = 1e-6 * (xx + yy + zz);
    let l00 = xx.max(least).sqrt();
    let (l10, l20) = (xy / l00, xz / l00);
    let l11 = (yy - l10 * l10).max(least).sqrt();
    let l21 = (yz - l20 * l10) / l11;
    let l22 = (zz - l20 * l20 - l21 * l21).max(least).sqrt();
    [l00, l10, l11, l20, l21, l22]
}

/// Least and greatest `x / z` of an ellipsoid: the roots of `C_zz t^2 - 2 C_xz t + C_xx` of the dual `C = u u^T - cut^2 V'`;
/// everything where it reaches behind the eye.
#[inline(always)]
fn silhouette([xx, xz, zz]: [f32; 3]) -> [f32; 2] {
    if zz <= 0.0 {
        return [-1e6, 1e6];
    }
    let root = (xz * xz - xx * zz).max(0.0).sqrt();
    [(xz - root) / zz, (xz + root) / zz]
}

/// Least and greatest singular value.
fn singular_values(m: DMat3) -> [f64; 2] {
    // Of the symmetric 3 x 3 matrix M M^T, by the trigonometric form of Cardano's formula.
    let a = m * m.transpose();
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let b = a - DMat3::from_diagonal(DVec3::splat(mean));
    let norm = (b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared()) / 6.0;
    if norm <= 1e-24 * mean * mean {
        return [mean.sqrt(); 2];
    }
    let p = norm.sqrt();
    let angle = (b.determinant() / (2.0 * p * p * p)).clamp(-1.0, 1.0).acos() / 3.0;
    let most = mean + 2.0 * p * angle.cos();
    let least = mean + 2.0 * p * (angle + 2.0 * std::f64::consts::FRAC_PI_3).cos();
    [least.max(1e-12 * most).sqrt(), most.sqrt()]
}
