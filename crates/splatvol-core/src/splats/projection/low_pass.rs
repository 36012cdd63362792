//! Low-pass filters: on the screen for affine footprints, in camera space for the others.
//!
//! `ewa` adds `pixel_sigma^2 I` to the screen covariance V2 (zwicker2001 eq. 22). `matched` adds only as much as
//! the narrower axis lacks. `swan` scales V2 by `a^2`, `a = max(1, 1 / (s spacing))`, with the spacing of the
//! narrowest direction of the grid, which is `d / k` of swan1997 eq. 3-4 for a cubic grid. As the weight has
//! `sqrt|V2|` in the denominator, extinction falls by eq. 8 of itself. In orthographic views, where k is not
//! defined, a is the same comparison of voxel and pixel.
//!
//! In camera space the filter has its width at the splat's depth, and swan's scales x and y: the box stretch of
//! mueller1998 figure 7b. For footprints across the ray through the centre u it scales both directions across that
//! ray (figure 8d):

use glam::{DVec2, DVec3};
use splatvol_scene::Filter;

use super::Projection;
use super::matrix::{Covariance, Planar, Whitening, add_square, least_variance, seen_along};

/// A filtered covariance, and the scale factor of its kernel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Filtered<C> {
    pub covariance: C,
    /// `a`, 1 or more.
    pub widening: f64,
}

impl Projection<'_> {
    /// Pixels per world length at a point's depth, or at the near plane.
    #[inline(always)]
    pub(super) fn pixels_per_length(&self, depth: f64) -> f64 {
        if self.perspective {
            self.scale / depth.max(self.near)
        } else {
            self.scale
        }
    }

    /// `1 / (s spacing)`. A standard deviation of the kernel is `sigma` spacings, so the grid's spacings follow
    /// from the covariance of a sphere in it, however flat the splat is.
    #[inline(always)]
    pub(super) fn pixels_between(&self, depth: f64, along: DVec2) -> f64 {
        let variance = least_variance(seen_along(self.sphere, along)).max(1e-300);
        self.sigma / (variance.sqrt() * self.pixels_per_length(depth))
    }

    /// Variance to add on the screen, pixels squared.
    #[inline(always)]
    fn added(&self, screen: Planar) -> f64 {
        match self.filter {
            Filter::None | Filter::Swan | Filter::SwanAlpha => 0.0,
            Filter::Ewa { pixel_sigma } => pixel_sigma * pixel_sigma,
            Filter::Matched { pixel_sigma } => (pixel_sigma * pixel_sigma - least_variance(screen)).max(0.0),
        }
    }

    #[inline(always)]
    pub(super) fn is_swan(&self) -> bool {
        matches!(self.filter, Filter::Swan | Filter::SwanAlpha)
    }

    #[inline(always)]
    fn widening(&self, depth: f64, along: DVec2) -> f64 {
        if self.is_swan() {
            self.pixels_between(depth, along).max(1.0)
        } else {
            1.0
        }
    }

    /// Filters the covariance that a splat has on screen.
    #[inline(always)]
    pub(super) fn on_screen(&self, depth: f64, along: DVec2, screen: Planar) -> Filtered<Planar> {
        let widening = self.widening(depth, along);
        let [xx, xy, yy] = screen.map(|v| v * widening * widening);
        let added = self.added(screen);
        Filtered {
            covariance: [xx + added, xy, yy + added],
            widening,
        }
    }

    /// Filters a covariance in camera space.
    #[inline(always)]
    pub(super) fn in_space(&self, u: DVec3, covariance: Covariance) -> Filtered<Covariance> {
        let scale = self.pixels_per_length(u.z);
        let [xx, xy, xz, yy, yz, zz] = covariance;
        let added = self.added([xx, xy, yy].map(|v| v * scale * scale)) / (scale * scale);
        let a = self.widening(u.z, DVec2::ZERO);
        Filtered {
            covariance: [
                a * a * xx + added,
                a * a * xy,
                a * xz,
                a * a * yy + added,
                a * yz,
                zz,
            ],
            widening: a,
        }
    }

    /// Filters a covariance in camera space, swan's across the ray through the centre.
    #[inline(always)]
    pub(super) fn across_ray(&self, u: DVec3, covariance: Covariance) -> Filtered<Covariance> {
        let widening = self.widening(u.z, DVec2::ZERO);
        if widening <= 1.0 {
            return self.in_space(u, covariance);
        }
        let far = Whitening::new(covariance).apply(u).length_squared().max(1e-300);
        let wide = covariance.map(|v| v * widening * widening);
        Filtered {
            covariance: add_square(wide, u, (1.0 - widening * widening) / far),
            widening,
        }
    }

    /// Factor on a splat's opacity.
    #[inline(always)]
    pub(super) fn opacity(&self, widening: f64) -> f32 {
        if self.filter == Filter::SwanAlpha {
            (1.0 / (widening * widening)) as f32
        } else {
            1.0
        }
    }

    /// Largest increase of a footprint's standard deviation on the screen by a filter, pixels, and its largest
    /// scale factor, up to a depth.
    pub(super) fn widest_filter(&self, depth: f64) -> (f64, f64) {
        match self.filter {
            Filter::None => (0.0, 1.0),
            Filter::Ewa { pixel_sigma } | Filter::Matched { pixel_sigma } => (pixel_sigma, 1.0),
            Filter::Swan | Filter::SwanAlpha => {
                let spacing = self.reach / self.anisotropy / self.sigma;
                let pixels = spacing * self.pixels_per_length(depth);
                (0.0, (1.0 / pixels).max(1.0))
            }
        }
    }
}
