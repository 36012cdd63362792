//! Footprints in perspective: whitens camera space about a splat.

use glam::{DVec2, DVec3};
use splatvol_scene::Stretch;

use super::Projection;
use super::low_pass::Filtered;
use super::matrix::{Covariance, Whitening};
use crate::splats::footprint::{Footprint, Warp};
use crate::splats::ray::{Ray, Trapezoid};

/// Rays and kernels in whitened space.
struct Whitened {
    warp: Ray,
    /// Distance of the centre, standard deviations.
    far: f64,
    weight: f32,
    depth_sigma: f32,
}

impl Projection<'_> {
    /// The exact footprint of a kernel of this covariance, clipped at the near plane.
    #[inline(always)]
    pub(super) fn along_rays(&self, u: DVec3, filtered: Filtered<Covariance>) -> Option<Footprint> {
        let covariance = filtered.covariance;
        let area = intersection(
            self.extent(u, covariance, 1.0)?,
            self.silhouettes(u, covariance, self.cut),
        );
        let whitened = self.whiten(u, covariance);
        let warp = Warp::Ray(whitened.warp);
        Some(self.footprint((u, filtered), &whitened, area, warp))
    }

    /// The practical ray-perpendicular footprint.
    #[inline(always)]
    pub(super) fn across_rays(&self, u: DVec3, filtered: Filtered<Covariance>) -> Option<Footprint> {
        if u.z <= self.near {
            return None;
        }
        let covariance = filtered.covariance;
        let whitened = self.whiten(u, covariance);
        // Seen from the eye, the disc is as large as a sphere that is a little smaller.
        let cut = self.cut / (1.0 + (self.cut / whitened.far).powi(2)).sqrt();
        let area = intersection(
            self.extent(u, covariance, 1.0)?,
            self.silhouettes(u, covariance, cut),
        );
        let warp = Warp::Perpendicular(whitened.warp);
        Some(self.footprint((u, filtered), &whitened, area, warp))
    }

    /// The exact footprint of a kernel that the filter stretches at each depth as needed.
    #[inline(always)]
    pub(super) fn stretched(&self, u: DVec3, covariance: Covariance) -> Option<Footprint> {
        let half = self.cut * covariance[5].sqrt();
        let needed = self.pixels_between(u.z, DVec2::ZERO);
        let per_depth = needed / u.z.max(self.near);
        let most = per_depth * (u.z + half);
        let filtered = Filtered {
            covariance,
            widening: needed.max(1.0),
        };
        if self.stretch == Stretch::Box || u.z <= self.near || most <= 1.0 {
            return self.along_rays(u, self.in_space(u, covariance));
        }
        let area = self.extent(u, covariance, most)?;
        let whitened = self.whiten(u, covariance);
        let warp = Warp::Trapezoid(Trapezoid {
            ray: whitened.warp,
            per_depth: per_depth as f32,
            depth: u.z as f32,
            reach: [(u.z - half) as f32, (u.z + half) as f32],
        });
        Some(self.footprint((u, filtered), &whitened, area, warp))
    }

    #[inline(always)]
    fn footprint(
        &self,
        (u, filtered): (DVec3, Filtered<Covariance>),
        whitened: &Whitened,
        [low, high]: [DVec2; 2],
        warp: Warp,
    ) -> Footprint {
        let pixels = |along: DVec2| (along * self.scale + self.principal).as_vec2();
        let (low, high) = (pixels(low), pixels(high));
        Footprint {
            centre: whitened.warp.origin,
            bounds: [low.x, low.y, high.x, high.y],
            weight: whitened.weight,
            opacity: self.opacity(filtered.widening),
            depth: u.z as f32,
            depth_sigma: whitened.depth_sigma,
            clip: if self.reaches_near(u, filtered.covariance) {
                self.near as f32
            } else {
                f32::NEG_INFINITY
            },
            warp,
        }
    }

    #[inline(always)]
    fn whiten(&self, u: DVec3, covariance: Covariance) -> Whitened {
        let whitening = Whitening::new(covariance);
        let centre = whitening.apply(u);
        // Centres beside the eye have no projection.
        let origin = if u.z > self.near {
            u.truncate() / u.z * self.scale + self.principal
        } else {
            self.principal
        };
        // The ray through what the origin is rounded to.
        let origin = origin.as_vec2();
        let along = (origin.as_dvec2() - self.principal) / self.scale;
        let towards = whitening.apply(along.extend(1.0));
        let moment = centre.cross(towards);
        Whitened {
            warp: Ray {
                whitening: whitening.0.map(|v| v as f32),
                centre: centre.as_vec3().to_array(),
                origin: origin.to_array(),
                along: along.as_vec2().to_array(),
                towards: towards.as_vec3().to_array(),
                moment: moment.as_vec3().to_array(),
                per_pixel: (1.0 / self.scale) as f32,
            },
            far: centre.length(),
            weight: (self.mass * whitening.determinant()) as f32,
            depth_sigma: (1.0 / towards.length()) as f32,
        }
    }

    /// Least and greatest x and y per depth of the box about a kernel, as far as it lies behind the near plane;
    /// `None` where no part does.
    #[inline(always)]
    fn extent(&self, u: DVec3, [xx, _, _, yy, _, zz]: Covariance, stretch: f64) -> Option<[DVec2; 2]> {
        let half = DVec3::new(stretch * xx.sqrt(), stretch * yy.sqrt(), zz.sqrt()) * self.cut;
        per_depth([u - half, u + half], self.near)
    }

    /// Least and greatest x and y per depth of an ellipsoid.
    #[inline(always)]
    fn silhouettes(&self, u: DVec3, [xx, _, xz, yy, yz, zz]: Covariance, cut: f64) -> [DVec2; 2] {
        let cut = cut * cut;
        let axis = |position: f64, own: f64, cross: f64| {
            silhouette([
                position * position - cut * own,
                position * u.z - cut * cross,
                u.z * u.z - cut * zz,
            ])
        };
        let ([x0, x1], [y0, y1]) = (axis(u.x, xx, xz), axis(u.y, yy, yz));
        [DVec2::new(x0, y0), DVec2::new(x1, y1)]
    }
}

#[inline(always)]
fn intersection(a: [DVec2; 2], b: [DVec2; 2]) -> [DVec2; 2] {
    [a[0].max(b[0]), a[1].min(b[1])]
}

/// Least and greatest x and y per depth of a box from a depth on.
#[inline(always)]
pub(super) fn per_depth([low, high]: [DVec3; 2], near: f64) -> Option<[DVec2; 2]> {
    if high.z <= near {
        return None;
    }
    let (first, last) = (1.0 / low.z.max(near), 1.0 / high.z);
    let (low, high) = (low.truncate(), high.truncate());
    Some([(low * first).min(low * last), (high * first).max(high * last)])
}

/// Least and greatest `x / z` of an ellipsoid: the roots of `C_zz t^2 - 2 C_xz t + C_xx` of the dual
/// `C = u u^T - cut^2 V'`; everything where it reaches behind the eye.
#[inline(always)]
fn silhouette([xx, xz, zz]: [f64; 3]) -> [f64; 2] {
    if zz <= 0.0 {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    let root = (xz * xz - xx * zz).max(0.0).sqrt();
    [(xz - root) / zz, (xz + root) / zz]
}
