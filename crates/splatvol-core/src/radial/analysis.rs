//! Quality of a kernel: the ripple of its sum over the lattice, and its frequency response.
//!
//! The ripple is the peak-to-peak difference of `sum_k h(x - k)` over the unit cell, sampled on a fine lattice. The sum
//! has the symmetries of the cube, so `0 <= z <= y <= x <= 1/2` is enough.

use super::{Profile, RadialKernel};

/// Frequencies of [`KernelAnalysis::response`], cycles per voxel: zero, half of the voxels' Nyquist frequency, that
/// frequency, one and a half of it, and the sampling frequency, where the first alias of a constant lies.
pub const RESPONSE_FREQUENCIES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Sums of kernel values that an analysis may cost.
const BUDGET: usize = 20_000_000;

/// The properties of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelAnalysis {
    /// Radius, voxels.
    pub support: f64,
    /// Standard deviation along an axis, voxels.
    pub sigma: f64,
    /// Mean of the sum over the lattice, measured on the samples of the cell.
    pub mean: f64,
    /// Smallest and largest sum over the lattice.
    pub range: [f64; 2],
    /// Frequency response at [`RESPONSE_FREQUENCIES`].
    pub response: [f64; RESPONSE_FREQUENCIES.len()],
    /// Largest absolute response at the other points of the reciprocal lattice near the origin, (1, 0, 0) to (2, 2, 2):
    /// each of these aliases is a part of the ripple.
    pub alias: f64,
    /// The centre's value, per cubic voxel.
    pub peak: f64,
    /// The footprint's value at its centre, per square voxel.
    pub footprint_peak: f64,
    /// The step at the support, as a share of the peak.
    pub edge: f64,
    /// Share of the kernel's integral that the cut-off has taken away (and the normalisation has given back).
    pub cut_off_mass: f64,
}

impl KernelAnalysis {
    /// Peak to peak, as a share of the mean.
    pub fn ripple(&self) -> f64 {
        (self.range[1] - self.range[0]) / self.mean
    }
}

/// Measures a kernel.
pub fn analyse(kernel: &RadialKernel) -> KernelAnalysis {
    let (mean, range) = lattice_sums(kernel);
    let aliases = [1, 2, 3, 4, 5, 6, 8, 9, 12].map(|square| kernel.response(f64::from(square).sqrt()).abs());
    KernelAnalysis {
        support: kernel.support(),
        sigma: kernel.sigma(),
        mean,
        range,
        response: RESPONSE_FREQUENCIES.map(|frequency| kernel.response(frequency)),
        alias: aliases.into_iter().fold(0.0, f64::max),
        peak: kernel.value(0.0),
        footprint_peak: kernel.line_integral(0.0),
        edge: kernel.uncut(kernel.support()) / kernel.value(0.0),
        cut_off_mass: cut_off_mass(kernel),
    }
}

/// Cut-off mass of the Gaussian: `1 - erf(u) + 2 u exp(-u^2) / sqrt(pi)`, u the radius over `sqrt(2) sigma`. It is
/// zero for the other kernels, which end by themselves.
fn cut_off_mass(kernel: &RadialKernel) -> f64 {
    match kernel.profile {
        Profile::Gaussian { sigma } => {
            let u = kernel.support / (std::f64::consts::SQRT_2 * sigma);
            libm::erfc(u) + 2.0 * u * libm::exp(-u * u) / std::f64::consts::PI.sqrt()
        }
        Profile::Piecewise(_) | Profile::Blob(_) => 0.0,
    }
}

/// Mean and range of the sum over the lattice.
fn lattice_sums(kernel: &RadialKernel) -> (f64, [f64; 2]) {
    let reach = kernel.support().ceil() as i32;
    let neighbours = (2 * reach as usize + 1).pow(3);
    let steps = (4..=32)
        .rev()
        .find(|n| (n + 1) * (n + 2) * (n + 3) / 6 * neighbours <= BUDGET)
        .unwrap_or(4);
    let (mut sum, mut weights) = (0.0, 0.0);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for x in 0..=steps {
        for y in 0..=x {
            for z in 0..=y {
                let at = [x, y, z].map(|i| 0.5 * i as f64 / steps as f64);
                let value = lattice_sum(kernel, at, reach);
                let weight = multiplicity([x, y, z], steps);
                sum += weight * value;
                weights += weight;
                range = [range[0].min(value), range[1].max(value)];
            }
        }
    }
    (sum / weights, range)
}

fn lattice_sum(kernel: &RadialKernel, at: [f64; 3], reach: i32) -> f64 {
    let squares = |a: usize| (-reach..=reach).map(move |k| at[a] - f64::from(k)).map(|d| d * d);
    squares(0)
        .flat_map(|x2| squares(1).map(move |y2| x2 + y2))
        .flat_map(|xy2| squares(2).map(move |z2| xy2 + z2))
        .filter(|r2| *r2 < kernel.support() * kernel.support())
        .map(|r2| kernel.value(r2.sqrt()))
        .sum()
}

/// Multiplicity of an ordered triple in the whole cell: its permutations, and twice along each axis where it is
/// neither on the face nor in the middle.
fn multiplicity([x, y, z]: [usize; 3], steps: usize) -> f64 {
    let permutations = match (x == y, y == z) {
        (true, true) => 1.0,
        (true, false) | (false, true) => 3.0,
        (false, false) => 6.0,
    };
    [x, y, z]
        .into_iter()
        .filter(|&i| i != 0 && i != steps)
        .fold(permutations, |weight, _| 2.0 * weight)
}
