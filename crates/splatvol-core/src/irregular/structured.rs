//! Kernels of structured blocks: neighbours by index, Jacobians by differences.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use splatvol_scene::Mesh;

use super::gradation::Trigger;
use super::lattice_kernels::{Around, LatticeKernels, REACH};
use super::lattice_regions::LatticeRegions;
use super::normalise::{Correction, sweep};
use super::resample::{Resampled, resample};
use super::{Sample, position};

/// Steps of normalisation: the error varies slowly, and the first step removes most of it.
const STEPS: [f64; 3] = [1.0; 3];
/// Relative change of the Jacobian within a kernel's reach that needs no normalisation: the sum is off by about the
/// square of a quarter of it.
const EVEN: f64 = 0.08;

/// Growth beyond which more kernels are needed. A cell may be twice as long as the one before, whose centre is one
/// and a half of its lengths away, but not twice as long again.
const TRIGGER: Trigger = Trigger {
    alone: 0.7,
    through: 0.6,
};

/// Samples along i, j, k.
pub(super) struct BlockLattice {
    pub(super) dims: [usize; 3],
    pub(super) positions: Vec<DVec3>,
    pub(super) valid: Vec<bool>,
    /// Edges of the cell around each sample, where samples are cells.
    edges: Vec<DMat3>,
    /// The points of the cells, where samples are cells.
    points: Option<Box<BlockLattice>>,
    /// True where no sample is blanked.
    pub(super) is_whole: bool,
}

impl BlockLattice {
    pub(super) fn of_points(mesh: &Mesh, dims: [usize; 3], first: usize) -> Self {
        let count: usize = dims.iter().product();
        let valid = |point: usize| !mesh.blanked().get(first + point).copied().unwrap_or(false);
        Self {
            dims,
            positions: (0..count).map(|point| position(mesh, first + point)).collect(),
            valid: (0..count).map(valid).collect(),
            is_whole: (0..count).all(valid),
            edges: Vec::new(),
            points: None,
        }
    }

    pub(super) fn of_cells(mesh: &Mesh, dims: [usize; 3], first: usize) -> Self {
        let points = Self::of_points(mesh, dims, first);
        let cells = dims.map(|size| size - 1);
        let count: usize = cells.iter().product();
        let corners = |cell: usize| corners_of(cell, dims);
        let centre = |cell| corners(cell).iter().map(|&p| points.positions[p]).sum::<DVec3>() / 8.0;
        let edges = |cell| {
            let corners = corners(cell).map(|p| points.positions[p]);
            let edge = |axis: usize| {
                let signed = |c: usize| {
                    if c >> axis & 1 == 1 {
                        corners[c]
                    } else {
                        -corners[c]
                    }
                };
                (0..8).map(signed).sum::<DVec3>() / 4.0
            };
            DMat3::from_cols(edge(0), edge(1), edge(2))
        };
        Self {
            dims: cells,
            positions: (0..count).into_par_iter().map(centre).collect(),
            valid: (0..count)
                .map(|cell| corners(cell).iter().all(|&p| points.valid[p]))
                .collect(),
            edges: (0..count).into_par_iter().map(edges).collect(),
            is_whole: points.is_whole,
            points: Some(Box::new(points)),
        }
    }

    /// The corners of a cell, x fastest, where samples are cells.
    pub(super) fn corners_of_cell(&self, cell: usize) -> Option<[DVec3; 8]> {
        let points = self.points.as_ref()?;
        Some(corners_of(cell, points.dims).map(|point| points.positions[point]))
    }

    pub(super) fn samples(&self, values: &[f32], sigma: f64) -> Vec<Sample> {
        (0..self.positions.len())
            .into_par_iter()
            .map(|index| self.sample(index, values, sigma))
            .collect()
    }

    /// Normalises masses, so that a constant field stays constant; returns resampled kernels where that needs more.
    pub(super) fn normalise(&self, samples: &mut [Sample], sigma: f64) -> Option<Resampled> {
        let steps: Vec<DMat3> = (0..samples.len())
            .into_par_iter()
            .map(|index| self.jacobian(index))
            .collect();
        let even: Vec<bool> = (0..samples.len())
            .into_par_iter()
            .map(|index| self.is_even(index, &steps))
            .collect();
        if even.iter().all(|&even| even) {
            return None;
        }
        let kernels = LatticeKernels::new(self, samples, &steps);
        let mut masses: Vec<f64> = samples.iter().map(|sample| sample.mass).collect();
        let regions = LatticeRegions {
            lattice: self,
            samples,
            kernels: &kernels,
            steps: &steps,
            masses: &masses,
        };
        let resampled = resample(samples, &regions, (TRIGGER, sigma), |index| !even[index]);
        if resampled.is_some() {
            return resampled;
        }
        let places: Vec<u32> = (0..samples.len() as u32)
            .filter(|&index| !even[index as usize])
            .collect();
        sweep(&mut masses, &places, &STEPS, |masses| {
            let sum = |around: &mut Around, &index: &u32| {
                Correction::Full(kernels.sum(around, index as usize, masses))
            };
            places.par_iter().map_init(Around::default, sum).collect()
        });
        for (sample, mass) in samples.iter_mut().zip(masses) {
            sample.mass = mass;
        }
        None
    }

    fn sample(&self, index: usize, values: &[f32], sigma: f64) -> Sample {
        let jacobian = self.jacobian(index);
        let covariance = sigma * sigma * jacobian * jacobian.transpose();
        let mass = jacobian.determinant().abs();
        Sample {
            position: self.positions[index],
            covariance,
            mass,
            gradient: self.gradient(index, values),
            value: values[index],
            valid: self.valid[index] && mass.is_normal(),
        }
    }

    /// True where cells are alike as far as a kernel reaches.
    fn is_even(&self, index: usize, steps: &[DMat3]) -> bool {
        let at = index_of(index, self.dims);
        let here = steps[index];
        let alike = |other: usize| {
            (0..3).all(|axis| {
                let column = here.col(axis);
                (steps[other].col(axis) - column).length() <= EVEN * column.length()
            })
        };
        (0..3).all(|axis| {
            let stride: usize = self.dims[..axis].iter().product();
            let low = index - stride * at[axis].min(REACH);
            let high = index + stride * (self.dims[axis] - 1 - at[axis]).min(REACH);
            alike(low) && alike(high)
        })
    }

    /// Derivative of space by the index.
    fn jacobian(&self, index: usize) -> DMat3 {
        if let Some(edges) = self.edges.get(index) {
            return *edges;
        }
        let column = |axis| {
            let own = self.step(index, axis);
            own.or_else(|| self.step_beside(index, axis)).unwrap_or_default()
        };
        DMat3::from_cols(column(0), column(1), column(2))
    }

    /// The difference of space along an axis, per index; none where no neighbour is valid.
    fn step(&self, index: usize, axis: usize) -> Option<DVec3> {
        let (low, high) = self.stencil(index, axis, |other| self.valid[other]);
        (high != low).then(|| (self.positions[high] - self.positions[low]) / self.span(low, high, axis))
    }

    /// The mean of the neighbours' steps, for a sample that has no valid neighbour along this axis.
    fn step_beside(&self, index: usize, axis: usize) -> Option<DVec3> {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for other in (0..3).filter(|&other| other != axis) {
            let (low, high) = self.stencil(index, other, |beside| self.valid[beside]);
            for step in [low, high]
                .into_iter()
                .filter_map(|beside| self.step(beside, axis))
            {
                sum += step;
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    /// Solves `J^T g = df/du` with differences of places and values over the same neighbours: exact for linear fields.
    fn gradient(&self, index: usize, values: &[f32]) -> DVec3 {
        let mut rows = [DVec3::ZERO; 3];
        let mut differences = [0.0; 3];
        for axis in 0..3 {
            let seen = |other: usize| self.valid[other] && values[other].is_finite();
            let (low, high) = self.stencil(index, axis, seen);
            rows[axis] = self.positions[high] - self.positions[low];
            differences[axis] = f64::from(values[high]) - f64::from(values[low]);
            if high == low {
                rows[axis] = self.edges.get(index).map_or(DVec3::ZERO, |edges| edges.col(axis));
                differences[axis] = 0.0;
            }
        }
        let matrix = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        let gradient = matrix.inverse() * DVec3::from_array(differences);
        if gradient.is_finite() {
            gradient
        } else {
            DVec3::ZERO
        }
    }

    /// The neighbours before and after; the sample itself replaces a missing one.
    fn stencil(&self, index: usize, axis: usize, seen: impl Fn(usize) -> bool) -> (usize, usize) {
        let at = index_of(index, self.dims)[axis];
        let stride: usize = self.dims[..axis].iter().product();
        let low = if at > 0 && seen(index - stride) {
            index - stride
        } else {
            index
        };
        let high = match at + 1 < self.dims[axis] && seen(index + stride) {
            true => index + stride,
            false => index,
        };
        (low, high)
    }

    fn span(&self, low: usize, high: usize, axis: usize) -> f64 {
        let stride: usize = self.dims[..axis].iter().product();
        ((high - low) / stride.max(1)) as f64
    }
}

/// The points of a cell of a block of points, x fastest.
fn corners_of(cell: usize, dims: [usize; 3]) -> [usize; 8] {
    let [i, j, k] = index_of(cell, dims.map(|size| size - 1));
    std::array::from_fn(|c| (i + (c & 1)) + dims[0] * ((j + (c >> 1 & 1)) + dims[1] * (k + (c >> 2))))
}

/// i, j, k of a place in a list.
pub(super) fn index_of(index: usize, dims: [usize; 3]) -> [usize; 3] {
    [
        index % dims[0],
        index / dims[0] % dims[1],
        index / (dims[0] * dims[1]),
    ]
}
