//! Gradation of a field of covariances: limits the growth of kernels from sample to sample.
//!
//! A covariance is a metric: `V^-1` measures offsets in standard deviations. Between neighbours i and j no
//! direction of i may be wider than `1 + g d_ij` times that of j, with `d_ij` their distance in spacings of j.
//! These are the metrics of Borouchaki, Hecht and Frey, Mesh gradation control, 1998, equation 4. Where a direction
//! is wider, `V_i` is cut: in the frame in which `V_j` is the unit matrix, the eigenvalues of `V_i` are limited to
//! `(1 + g d_ij)^2`. The result is invariant under affine maps of the mesh: uniform shear and flat cells are as
//! good as cubes.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Sample;
use super::whitening::whitening;
use crate::eigen::eigen;

/// Most passes of cutting: each carries a change of size one neighbour further.
const PASSES: usize = 32;
/// Relative cut below which a covariance counts as unchanged.
const SLACK: f64 = 1e-6;

/// Adjacency of samples.
pub(super) trait Neighbours: Sync {
    /// Calls `visit` for each neighbour of a sample.
    fn each_neighbour(&self, index: usize, visit: &mut dyn FnMut(usize));
}

/// A metric with its frequently used derived numbers.
#[derive(Debug, Clone, Copy)]
struct Metric {
    position: DVec3,
    covariance: DMat3,
    /// Offsets in standard deviations; zero where the covariance is none.
    whitening: DMat3,
    valid: bool,
}

impl Metric {
    fn new(sample: &Sample) -> Self {
        let whitening = whitening(&sample.covariance);
        Self {
            position: sample.position,
            covariance: sample.covariance,
            whitening: whitening.unwrap_or(DMat3::ZERO),
            valid: sample.valid && whitening.is_some(),
        }
    }

    /// Square of the largest width of a neighbour relative to this one.
    fn limit(&self, other: &Self, growth: f64, sigma: f64) -> f64 {
        let spacings = sigma * (self.whitening * (other.position - self.position)).length();
        (1.0 + growth * spacings).powi(2)
    }

    /// A covariance in the frame in which this one is the unit matrix.
    fn seen(&self, covariance: &DMat3) -> DMat3 {
        self.whitening * *covariance * self.whitening.transpose()
    }
}

/// True where an eigenvalue of a symmetric matrix is above a limit: `limit I - matrix` is not positive definite, by its
/// leading minors.
fn exceeds(matrix: &DMat3, limit: f64) -> bool {
    let rest = DMat3::from_diagonal(DVec3::splat(limit)) - *matrix;
    let (x, y) = (rest.x_axis, rest.y_axis);
    x.x <= 0.0 || x.x * y.y - x.y * y.x <= 0.0 || rest.determinant() <= 0.0
}

/// Growth of a kernel per spacing beyond which more kernels are needed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trigger {
    /// From one sample to another.
    pub(super) alone: f64,
    /// To a sample and on from it: where cells keep growing.
    pub(super) through: f64,
}

/// Marks samples that are wider or narrower than a neighbour allows.
pub(super) fn violations(
    samples: &[Sample],
    neighbours: &impl Neighbours,
    (trigger, sigma): (Trigger, f64),
    wanted: impl Fn(usize) -> bool + Sync,
) -> Vec<bool> {
    let metrics: Vec<Metric> = samples.par_iter().map(Metric::new).collect();
    let of = |index: usize| {
        let own = &metrics[index];
        let (mut found, mut narrow, mut wide) = (false, false, false);
        if own.valid && wanted(index) {
            neighbours.each_neighbour(index, &mut |other| {
                let other = &metrics[other];
                let either = |growth| {
                    [
                        exceeds(&own.seen(&other.covariance), own.limit(other, growth, sigma)),
                        exceeds(&other.seen(&own.covariance), other.limit(own, growth, sigma)),
                    ]
                };
                if other.valid && !found {
                    let through = either(trigger.through);
                    (narrow, wide) = (narrow | through[0], wide | through[1]);
                    found =
                        (narrow && wide) || (through != [false; 2] && either(trigger.alone) != [false; 2]);
                }
            });
        }
        found
    };
    (0..samples.len()).into_par_iter().map(of).collect()
}

/// Cuts covariances until none is wider than its neighbours allow. After the first pass only the neighbours of cut
/// ones are tested.
pub(super) fn graded(
    samples: &[Sample],
    neighbours: &impl Neighbours,
    (growth, sigma): (f64, f64),
) -> Vec<DMat3> {
    let mut metrics: Vec<Metric> = samples.par_iter().map(Metric::new).collect();
    let mut looked_at: Vec<u32> = (0..samples.len() as u32).collect();
    for _ in 0..PASSES {
        let of = |&index: &u32| {
            let mut own = metrics[index as usize];
            let mut is_cut = false;
            if own.valid {
                neighbours.each_neighbour(index as usize, &mut |other| {
                    let other = &metrics[other];
                    if other.valid {
                        let limit = other.limit(&own, growth, sigma) * (1.0 + SLACK);
                        is_cut |= narrow(&mut own, other, limit);
                    }
                });
            }
            is_cut.then_some((index, own))
        };
        let cut: Vec<(u32, Metric)> = looked_at.par_iter().filter_map(of).collect();
        if cut.is_empty() {
            break;
        }
        let mut is_beside = vec![false; samples.len()];
        for (index, metric) in cut {
            let index = index as usize;
            metrics[index] = metric;
            is_beside[index] = true;
            neighbours.each_neighbour(index, &mut |other| is_beside[other] = true);
        }
        looked_at = (0..samples.len() as u32)
            .filter(|&index| is_beside[index as usize])
            .collect();
    }
    metrics.into_iter().map(|metric| metric.covariance).collect()
}

/// Limits a metric to `limit` times that of a neighbour in every direction; returns whether that changed it.
fn narrow(own: &mut Metric, neighbour: &Metric, limit: f64) -> bool {
    let seen = neighbour.seen(&own.covariance);
    if !exceeds(&seen, limit) {
        return false;
    }
    let (ratios, axes) = eigen(seen);
    // C of the neighbour's covariance C C^T.
    let root = neighbour.covariance * neighbour.whitening.transpose();
    let frame = root * DMat3::from_cols(axes[0], axes[1], axes[2]);
    let cut = DMat3::from_diagonal(DVec3::from_array(ratios.map(|ratio| ratio.clamp(0.0, limit))));
    let narrowed = frame * cut * frame.transpose();
    match whitening(&narrowed) {
        Some(whitening) => {
            (own.covariance, own.whitening) = (narrowed, whitening);
            true
        }
        None => false,
    }
}
