//! Errors of the alignments against exact alignment: estimates, and the choice of `auto` based on them.
//!
//! Let `c` and `w_0` be the whitened centre and the whitened ray through it. A ray with the whitened offset
//! `e |w_0|` from that one passes the kernel at `r = |c x e| / |w|` (`splats::Ray`),
//! `|w|^2 = |w_0|^2 ((1 + e_par)^2 + e_perp^2)`. The affine footprint has `rho = |c| e_perp`, so the alignments
//! differ by their denominators only. Within a footprint `|e_par| <= tau rho` and `e_perp = epsilon rho`, where
//! `epsilon = 1 / |c|` is the standard deviation per distance, `tau^2 = t^T V2 t`,
//! `t = (V^-1 d)_xy / (d^T V^-1 d)`, and V2 is the footprint's covariance per depth; the path's length changes by
//! at most `gamma rho`, `gamma^2 = k^T V2 k`, `k = d_xy / |d|^2 - t`. For a sphere `gamma = 0`,
//! `tau = epsilon tan(angle to the axis)`. To first order, with q the profile,
//!
//! | alignment | error, share of the peak |
//! |---|---|
//! | affine | `tau max 2 rho^3 abs(q') + gamma max rho q + epsilon^2 max rho^4 abs(q')` |
//! | ray | the same without tau |
//!
//! so 1.159 tau for a Gaussian: a sphere 60 degrees off axis has `1.00 sigma / z`, which is mueller1998's 1 % at
//! .01. Four times the square of the first order is added, which bounds the terms left out up to errors of a fifth
//! (tested). A footprint along another axis, or stretched in another direction, also errs by the difference of two
//! Gaussians: with `kappa < 1` the ratio of their variances, `(1 - kappa) kappa^(kappa / (1 - kappa))`, plus the
//! difference of their heights.

use glam::{DVec2, DVec3};

use super::Projection;
use super::matrix::{Covariance, Planar, Whitening, determinant, quadratic, seen_along};
use crate::splats::profile::Profile;

/// Largest errors of a splat's footprints against exact alignment, shares of the peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignmentErrors {
    /// Error of the affine footprint.
    pub affine: f64,
    /// Error of the footprint across the ray.
    pub ray: f64,
    /// Error of the footprint across the axis.
    pub grid: f64,
}

/// Sensitivity of a profile q to shifts and stretches of its argument.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sensitivity {
    /// `max 2 rho^3 abs(q')`.
    radial: f64,
    /// `max rho q`.
    path: f64,
    /// `max rho^4 abs(q')`.
    second: f64,
}

impl Sensitivity {
    pub(super) fn new(profile: &impl Profile) -> Self {
        const STEP: f64 = 1.0 / 32.0;
        let q = |rho: f64| f64::from(profile.whole((rho * rho) as f32));
        let count = (f64::from(profile.cut()) / STEP).ceil() as usize;
        (1..=count).fold(Self::default(), |most, i| {
            let rho = i as f64 * STEP;
            // dq / drho = 2 rho q'.
            let slope = ((q(rho + STEP) - q(rho - STEP)) / (2.0 * STEP)).abs();
            Self {
                radial: most.radial.max(rho * rho * slope),
                path: most.path.max(rho * q(rho)),
                second: most.second.max(0.5 * rho * rho * rho * slope),
            }
        })
    }
}

/// Covariances that a footprint may have per depth, and its central path per deviation.
#[derive(Debug, Clone, Copy)]
struct Shape {
    planar: Planar,
    path: f64,
}

impl Shape {
    /// Bound on the difference of two Gaussians with the same mass, relative to the height of this one.
    fn difference(&self, other: &Self) -> f64 {
        let own = determinant(self.planar);
        let theirs = determinant(other.planar);
        let height = other.path / self.path * (own / theirs).sqrt();
        // The eigenvalues of one covariance times the inverse of the other.
        let ([a, b, c], [d, e, f]) = (self.planar, other.planar);
        let half = 0.5 * (a * f - 2.0 * b * e + c * d) / theirs;
        let root = (half * half - own / theirs).max(0.0).sqrt();
        let spread = [half - root, half + root]
            .map(|ratio| width_difference(ratio.min(1.0 / ratio)))
            .into_iter()
            .fold(0.0, f64::max);
        (height - 1.0).abs() + spread
    }
}

/// `max exp(-kappa x) - exp(-x)`.
fn width_difference(kappa: f64) -> f64 {
    if kappa > 1.0 - 1e-9 {
        0.0
    } else {
        (1.0 - kappa) * libm::pow(kappa.max(1e-300), kappa / (1.0 - kappa))
    }
}

impl Projection<'_> {
    /// Estimates of the errors of a splat's footprints; `None` where it has none, where it reaches before the near
    /// plane and is cut there, and in orthographic views, which are exact.
    pub fn errors(&self, splat: usize) -> Option<AlignmentErrors> {
        let u = self.centre(splat).as_dvec3();
        let covariance = self.covariance(splat);
        let filtered = self.in_space(u, covariance).covariance;
        if !self.perspective || self.reaches_near(u, filtered) {
            return None;
        }
        let across = self.across_ray(u, covariance).covariance;
        let along = u.truncate() / u.z;
        let path = (1.0 + along.length_squared()).sqrt();
        let shape = |covariance, along, path| Shape {
            planar: seen_along(covariance, along),
            path,
        };
        let truth = shape(filtered, along, path);
        let affine = self.first_order(u, filtered);
        Some(AlignmentErrors {
            affine: affine.total(true),
            ray: self.first_order(u, across).total(false) + truth.difference(&shape(across, along, path)),
            grid: affine.total(true) + truth.difference(&shape(filtered, DVec2::ZERO, 1.0)),
        })
    }

    /// Whether an affine footprint of this filtered covariance is good enough.
    #[inline(always)]
    pub(super) fn is_affine_enough(&self, u: DVec3, filtered: Covariance, budget: f64) -> bool {
        let along = (u.truncate() / u.z).abs();
        // Farther outside, the Jacobian is not that of the centre.
        along.x <= self.widest.x
            && along.y <= self.widest.y
            && !self.reaches_near(u, filtered)
            && self.first_order(u, filtered).total(true) <= budget
    }

    #[inline(always)]
    pub(super) fn reaches_near(&self, u: DVec3, [.., zz]: Covariance) -> bool {
        u.z - self.cut * zz.sqrt() <= self.near
    }

    #[inline(always)]
    fn first_order(&self, u: DVec3, covariance: Covariance) -> FirstOrder {
        let ray = u / u.z;
        let whitening = Whitening::new(covariance);
        let direction = whitening.apply(ray);
        let squared = direction.length_squared();
        let tilt = whitening.apply_transposed(direction).truncate() / squared;
        let path = ray.truncate() / ray.length_squared() - tilt;
        let planar = seen_along(covariance, ray.truncate()).map(|v| v / (u.z * u.z));
        let (tau, gamma) = (quadratic(planar, tilt).sqrt(), quadratic(planar, path).sqrt());
        let Sensitivity { radial, path, second } = self.sensitivity;
        FirstOrder {
            radial: radial * tau,
            path: path * gamma,
            second: second / (squared * u.z * u.z),
            squared: (tau + gamma).powi(2),
        }
    }
}

/// Terms of an error.
#[derive(Debug, Clone, Copy)]
struct FirstOrder {
    radial: f64,
    path: f64,
    second: f64,
    squared: f64,
}

impl FirstOrder {
    /// `tilted`: with the term in tau, which footprints across the ray do not have.
    #[inline(always)]
    fn total(&self, tilted: bool) -> f64 {
        let radial = if tilted { self.radial } else { 0.0 };
        radial + self.path + self.second + 4.0 * self.squared
    }
}
