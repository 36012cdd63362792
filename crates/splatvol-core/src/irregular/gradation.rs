//! Kernels whose size varies no faster than they can follow: gradation of a field of covariances.
//!
//! A covariance is a metric: `V^-1` measures offsets in standard deviations. Between neighbours i and j no direction of i
//! may be wider than `1 + g d_ij` times that of j, with `d_ij` their distance in spacings of j (Borouchaki, Hecht and Frey,
//! Mesh gradation control, 1998, equation 4, whose metrics are these). Where it is, `V_i` is cut: in the frame in which
//! `V_j` is the unit matrix the eigenvalues of `V_i` are brought down to `(1 + g d_ij)^2`. An affine map of the mesh
//! changes nothing: uniform shear and flat cells are as good as cubes.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Sample;
use crate::eigen::eigen;

/// Passes of cutting at most: each takes a change of size one neighbour further.
const PASSES: usize = 32;
/// A cut by less is none.
const SLACK: f64 = 1e-6;

/// Who is beside whom.
pub(super) trait Neighbours: Sync {
    /// Calls `visit` for each neighbour of a sample.
    fn each_neighbour(&self, index: usize, visit: &mut dyn FnMut(usize));
}

/// A metric with what is asked of it again and again.
#[derive(Debug, Clone, Copy)]
struct Metric {
    position: DVec3,
    covariance: DMat3,
    inverse: DMat3,
    valid: bool,
}

impl Metric {
    fn new(sample: &Sample) -> Self {
        let inverse = sample.covariance.inverse();
        Self {
            position: sample.position,
            covariance: sample.covariance,
            inverse,
            valid: sample.valid && inverse.is_finite() && sample.covariance.determinant() > 0.0,
        }
    }

    /// The square of how much wider than this one a neighbour may be.
    fn limit(&self, other: &Self, growth: f64, sigma: f64) -> f64 {
        let offset = other.position - self.position;
        let spacings = sigma * offset.dot(self.inverse * offset).max(0.0).sqrt();
        (1.0 + growth * spacings).powi(2)
    }

    /// False where no direction of another is wider than `limit` allows, by `lambda <= 1 + |lambda - 1|` of all eigenvalues.
    fn may_exceed(&self, other: &Self, limit: f64) -> bool {
        let quotient = self.inverse * other.covariance - DMat3::IDENTITY;
        let squared = quotient * quotient;
        let trace = squared.x_axis.x + squared.y_axis.y + squared.z_axis.z;
        1.0 + trace.max(0.0).sqrt() > limit
    }
}

/// Eigenvalues of a covariance in the frame in which another is the unit matrix, and that frame's columns: `L Q`.
fn relative(one: &DMat3, unit: &DMat3) -> Option<([f64; 3], DMat3)> {
    let (values, vectors) = eigen(*unit);
    if values[0] <= 0.0 {
        return None;
    }
    let root = |exponent: f64| {
        let scaled = std::array::from_fn::<_, 3, _>(|i| vectors[i] * libm::pow(values[i], exponent));
        DMat3::from_cols(scaled[0], scaled[1], scaled[2])
    };
    let (forward, back) = (root(0.5), root(-0.5));
    let (ratios, axes) = eigen(back.transpose() * *one * back);
    Some((ratios, forward * DMat3::from_cols(axes[0], axes[1], axes[2])))
}

/// Growths of a kernel per spacing beyond which there is need for more kernels.
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
                        exceeds(own, other, (growth, sigma)),
                        exceeds(other, own, (growth, sigma)),
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

fn exceeds(own: &Metric, other: &Metric, (growth, sigma): (f64, f64)) -> bool {
    let limit = own.limit(other, growth, sigma);
    own.may_exceed(other, limit)
        && relative(&other.covariance, &own.covariance).is_some_and(|(ratios, _)| ratios[2] > limit)
}

/// Covariances cut until none is wider than its neighbours allow.
pub(super) fn graded(
    samples: &[Sample],
    neighbours: &impl Neighbours,
    (growth, sigma): (f64, f64),
) -> Vec<DMat3> {
    let mut metrics: Vec<Metric> = samples.par_iter().map(Metric::new).collect();
    for _ in 0..PASSES {
        let of = |index: usize| {
            let mut own = metrics[index];
            let mut cut = false;
            if own.valid {
                neighbours.each_neighbour(index, &mut |other| {
                    let other = &metrics[other];
                    if other.valid {
                        let limit = other.limit(&own, growth, sigma) * (1.0 + SLACK);
                        cut |= other.may_exceed(&own, limit) && narrow(&mut own.covariance, other, limit);
                    }
                });
            }
            cut.then(|| Metric {
                inverse: own.covariance.inverse(),
                ..own
            })
        };
        let cut: Vec<Option<Metric>> = (0..samples.len()).into_par_iter().map(of).collect();
        if cut.iter().all(Option::is_none) {
            break;
        }
        for (metric, cut) in metrics.iter_mut().zip(cut) {
            *metric = cut.unwrap_or(*metric);
        }
    }
    metrics.into_iter().map(|metric| metric.covariance).collect()
}

/// Brings a covariance down to `limit` times that of a neighbour in every direction; whether that changed it.
fn narrow(covariance: &mut DMat3, neighbour: &Metric, limit: f64) -> bool {
    match relative(covariance, &neighbour.covariance) {
        Some((ratios, frame)) if ratios[2] > limit => {
            let cut = DMat3::from_diagonal(DVec3::from_array(ratios.map(|ratio| ratio.clamp(0.0, limit))));
            let narrowed = frame * cut * frame.transpose();
            let legal = narrowed.determinant() > 0.0;
            if legal {
                *covariance = narrowed;
            }
            legal
        }
        _ => false,
    }
}
