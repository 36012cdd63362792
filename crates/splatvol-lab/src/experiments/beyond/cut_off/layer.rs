//! Footprints that are cut, and layers of equal voxels made of them, in f64.

use std::f64::consts::TAU;

use splatvol_core::radial::RadialKernel;

use super::ZOOM;
use crate::measure::mean;

/// Share of a kernel's footprint beyond a radius, voxels: the integral of `2 pi rho q` by the midpoint rule.
pub(super) fn beyond(kernel: &RadialKernel, radius: f64) -> f64 {
    const STEPS: u32 = 4000;
    let step = (kernel.support() - radius).max(0.0) / f64::from(STEPS);
    let at = |i: u32| radius + (f64::from(i) + 0.5) * step;
    let ring = |rho: f64| TAU * rho * kernel.line_integral(rho * rho) * step;
    (0..STEPS).map(at).map(ring).sum()
}

/// Truncation of a Gaussian.
#[derive(Clone, Copy)]
pub(super) enum Edge {
    /// Truncated with a step, as in zwicker2001.
    Step,
    /// Minus its value there, with all its mass, as in the engine.
    Subtracted,
}

/// A Gaussian's footprint at a squared distance, voxels.
pub(super) fn footprint(sigma: f64, cut: f64, edge: Edge, square: f64) -> f64 {
    let unit = square / (sigma * sigma);
    if unit >= cut * cut {
        return 0.0;
    }
    let area = TAU * sigma * sigma;
    let e = (-0.5 * cut * cut).exp();
    match edge {
        Edge::Step => (-0.5 * unit).exp() / area,
        Edge::Subtracted => ((-0.5 * unit).exp() - e) / (area * (1.0 - e - 0.5 * e * cut * cut)),
    }
}

/// `sum_k q(x - k)` at the pixels of a picture of one cell, rows of [`ZOOM`].
pub(super) fn layer(footprint: impl Fn(f64) -> f64, reach: f64) -> Vec<f64> {
    let last = reach.ceil() as i32 + 1;
    let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(ZOOM);
    let lattice = || (-last..=last).map(f64::from);
    let sum = |x: f64, y: f64| {
        let squares = lattice().flat_map(|j| lattice().map(move |i| (x - i).powi(2) + (y - j).powi(2)));
        squares.map(&footprint).sum::<f64>()
    };
    (0..ZOOM * ZOOM)
        .map(|index| sum(at(index % ZOOM), at(index / ZOOM)))
        .collect()
}

/// Peak to peak as a share of the mean.
pub(super) fn ripple(values: &[f64]) -> f64 {
    let [low, high] = values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| {
            [low.min(v), high.max(v)]
        });
    (high - low) / mean(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn footprints_keep_their_mass_less_what_is_cut() {
        let mass = |edge| {
            let step = 0.01;
            let at = |i: u32| (f64::from(i) + 0.5) * step;
            let ring = |r: f64| TAU * r * footprint(0.8, 2.0, edge, r * r) * step;
            (0..200).map(at).map(ring).sum::<f64>()
        };
        assert!(
            (mass(Edge::Subtracted) - 1.0).abs() < 1e-3,
            "{}",
            mass(Edge::Subtracted)
        );
        assert!((mass(Edge::Step) - (1.0 - (-2.0f64).exp())).abs() < 3e-3);
    }
}
