//! The scalar field: normalised samples, coefficients, and the sums `S` and `W`.
//!
//! `F_k = (f_k - lo) / (hi - lo)`; coefficients `c_k` are `F_k`, or with the interpolating prefilter the solution of
//! `sum_k c_k h(i - k) = F_i W(i)` on the full box. For that system a missing sample is filled with the mean of its
//! finite face neighbours (0 if it has none); afterwards it has no weight in `S` and `W`.
//!
//! The lattice is continued by its outermost sample beyond each face, `F(-1) = F(0)` and `F(n) = F(n - 1)`, along axes
//! of two samples and more; S and W include it, the coverage does not: `B` is the kernel's share on the box.

use std::f64::consts::SQRT_2;

use glam::{DMat3, DVec3};
use splatvol_scene::{Kernel, Volume};

use crate::ReferenceError;
use crate::kernel::GaussianKernel;
use crate::lattice::{Lattice, LatticeSums};
use crate::solve::solve;

/// A volume as a continuous field.
#[derive(Debug, Clone)]
pub struct Reconstruction {
    kernel: GaussianKernel,
    value_range: [f64; 2],
    /// Coefficient, presence (1 or 0) and 1 per lattice point.
    samples: Lattice<3>,
    /// The volume's own samples along x, y, z.
    own_dims: [usize; 3],
    any_missing: bool,
    /// Lattice index of voxel (0, 0, 0).
    first_voxel: DVec3,
}

/// Weighted sums of the samples at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums {
    /// `S = sum_k c_k h(x - k)`.
    pub s: f64,
    /// `W = sum_k h(x - k)`.
    pub w: f64,
    /// `B`, times the share of W in the sum over all of the lattice where samples are missing.
    pub b: f64,
    /// Gradient of S in voxel space, per voxel.
    pub grad_s: DVec3,
}

impl Sums {
    /// `v = S / W`: 0 is the volume's smallest value, 1 its largest. Not finite where W is 0.
    pub fn value(&self) -> f64 {
        self.s / self.w
    }

    /// `q`: 1 inside the volume, falling to 0 across its border.
    pub fn coverage(&self) -> f64 {
        ((self.b - 0.5) / 0.98 + 0.5).clamp(0.0, 1.0)
    }
}

impl Reconstruction {
    /// The field of a volume, with or without the interpolating prefilter.
    ///
    /// # Errors
    /// A kernel that is not a Gaussian; with the prefilter, one that cannot be inverted on this box.
    pub fn new(volume: &Volume, kernel: &Kernel, prefilter: bool) -> Result<Self, ReferenceError> {
        let gaussian = GaussianKernel::new(kernel)?;
        let (dims, samples) = continued(&normalised_samples(volume), volume.grid().dims());
        let coefficients = if prefilter {
            let right = filled(&samples, dims)
                .into_iter()
                .enumerate()
                .map(|(index, f)| f * full_box_weight(&gaussian, dims, index))
                .collect();
            solve(&gaussian, dims, right).map_err(|count| ReferenceError::SingularKernel {
                sigma: gaussian.sigma,
                radius: gaussian.radius,
                count,
            })?
        } else {
            samples.clone()
        };
        let payload = |(sample, coefficient): (&f64, f64)| {
            if sample.is_finite() {
                [coefficient, 1.0, 1.0]
            } else {
                [0.0, 0.0, 1.0]
            }
        };
        Ok(Self {
            kernel: gaussian,
            value_range: volume.value_range(),
            samples: Lattice {
                dims,
                payload: samples.iter().zip(coefficients).map(payload).collect(),
            },
            own_dims: volume.grid().dims(),
            any_missing: volume.statistics().non_finite > 0,
            first_voxel: DVec3::from_array(volume.grid().dims().map(|n| margin(n) as f64)),
        })
    }

    /// `S`, `W`, `B` and the gradient of S at a point in voxel space, without low-pass.
    pub fn sums(&self, x_voxel: DVec3) -> Sums {
        let sums = self.samples.sums(&self.kernel, x_voxel + self.first_voxel);
        self.with_box(sums, x_voxel, DVec3::splat(self.kernel.sigma))
    }

    /// [`Self::sums`] with the kernel's covariance (voxel space) widened by a low-pass.
    pub fn filtered_sums(&self, x_voxel: DVec3, covariance: DMat3) -> Sums {
        let sums = self
            .samples
            .filtered_sums(&self.kernel, covariance, x_voxel + self.first_voxel);
        let variance = DVec3::new(covariance.x_axis.x, covariance.y_axis.y, covariance.z_axis.z);
        self.with_box(sums, x_voxel, variance.map(f64::sqrt))
    }

    /// `B = prod_a Phi((x_a + 1/2) / s_a) - Phi((x_a - n_a + 1/2) / s_a)`, s the kernel's deviations along the axes.
    fn with_box(&self, sums: LatticeSums<3>, x_voxel: DVec3, deviation: DVec3) -> Sums {
        let [s, w, all] = sums.sums;
        let below = |offset: f64, axis: usize| 0.5 * libm::erfc(-offset / (deviation[axis] * SQRT_2));
        let share = |axis: usize| {
            below(x_voxel[axis] + 0.5, axis) - below(x_voxel[axis] + 0.5 - self.own_dims[axis] as f64, axis)
        };
        let b = share(0) * share(1) * share(2);
        Sums {
            s,
            w,
            b: if self.any_missing && all > 0.0 {
                b * w / all
            } else {
                b
            },
            grad_s: sums.gradient,
        }
    }

    /// Reconstructed value in data units; not finite where no sample reaches.
    pub fn value(&self, x_voxel: DVec3) -> f64 {
        self.data_value(&self.sums(x_voxel))
    }

    /// `lo + v (hi - lo)` of sums.
    pub fn data_value(&self, sums: &Sums) -> f64 {
        let [low, high] = self.value_range;
        low + sums.value() * (high - low)
    }

    /// Coefficients `c_k` of the continued lattice (x fastest); 0 at missing samples.
    pub fn coefficients(&self) -> Vec<f64> {
        self.samples.payload.iter().map(|payload| payload[0]).collect()
    }
}

/// `F_k`, NaN where missing.
fn normalised_samples(volume: &Volume) -> Vec<f64> {
    let [low, high] = volume.value_range();
    let width = if high > low { high - low } else { 1.0 };
    (0..volume.grid().sample_count())
        .map(|index| (volume.value(index) - low) / width)
        .map(|f| if f.is_finite() { f } else { f64::NAN })
        .collect()
}

/// Repeated samples beyond each end of an axis.
fn margin(n: usize) -> usize {
    usize::from(n > 1)
}

/// The lattice continued by its outermost samples: dims and samples.
fn continued(samples: &[f64], own: [usize; 3]) -> ([usize; 3], Vec<f64>) {
    let dims = own.map(|n| n + 2 * margin(n));
    let nearest = |axis: usize, position: usize| {
        let voxel = position as i64 - margin(own[axis]) as i64;
        voxel.clamp(0, own[axis] as i64 - 1) as usize
    };
    let mut continued = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let (x, y, z) = (nearest(0, x), nearest(1, y), nearest(2, z));
                continued.push(samples[(z * own[1] + y) * own[0] + x]);
            }
        }
    }
    (dims, continued)
}

/// Missing samples replaced by the mean of their finite face neighbours, or 0.
fn filled(samples: &[f64], dims: [usize; 3]) -> Vec<f64> {
    let fill = |index: usize| {
        let neighbours = face_neighbours(index, dims);
        let finite: Vec<f64> = neighbours
            .into_iter()
            .flatten()
            .flatten()
            .map(|neighbour| samples[neighbour])
            .filter(|f| f.is_finite())
            .collect();
        finite.iter().sum::<f64>() / finite.len().max(1) as f64
    };
    samples
        .iter()
        .enumerate()
        .map(|(index, &f)| if f.is_finite() { f } else { fill(index) })
        .collect()
}

/// Index of the lower and upper neighbour along each axis, where the box has one.
pub(crate) fn face_neighbours(index: usize, dims: [usize; 3]) -> [[Option<usize>; 2]; 3] {
    let strides = [1, dims[0], dims[0] * dims[1]];
    std::array::from_fn(|axis| {
        let position = index / strides[axis] % dims[axis];
        [
            (position > 0).then(|| index - strides[axis]),
            (position + 1 < dims[axis]).then(|| index + strides[axis]),
        ]
    })
}

/// `W(i)` of the full box at a voxel.
fn full_box_weight(kernel: &GaussianKernel, dims: [usize; 3], index: usize) -> f64 {
    let position = [
        index % dims[0],
        index / dims[0] % dims[1],
        index / (dims[0] * dims[1]),
    ];
    let axis_weight = |axis: usize| -> f64 {
        (0..dims[axis])
            .map(|k| kernel.factor(position[axis] as f64 - k as f64))
            .sum()
    };
    axis_weight(0) * axis_weight(1) * axis_weight(2)
}
