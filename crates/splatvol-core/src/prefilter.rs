//! The interpolating prefilter: coefficients whose kernel sum passes through the samples.
//!
//! Per axis the samples at the lattice points are `H c` with the banded Toeplitz matrix `H_ij = tap(|i - j|)`, and
//! the weights `W = H 1` fall off at the border; the 3-D operator is the product of its axes'. We solve `H c = W F`
//! exactly, by a Cholesky factorisation `H = L D L^T` per axis, border included. Recursive filters (Unser 1999)
//! would mirror the data instead.

use rayon::prelude::*;

use crate::kernel::GaussianKernel;

/// `H = L D L^T` of one axis, with the border's weights.
#[derive(Debug, Clone)]
pub(crate) struct AxisSolver {
    /// `lower[i * band + j - 1]` is `L[i][i - j]`, j = 1..=band.
    lower: Vec<f32>,
    inverse_diagonal: Vec<f32>,
    weights: Vec<f32>,
    band: usize,
}

impl AxisSolver {
    /// Factorises the operator of `count` samples.
    pub(crate) fn new(kernel: &GaussianKernel, count: usize) -> Self {
        // A windowed kernel is zero at an integer radius.
        let reach = (1..=kernel.reach())
            .rev()
            .find(|&j| kernel.tap(j) != 0.0)
            .unwrap_or(1);
        let band = reach.min(count - 1).max(1);
        let element = |i: usize, j: usize| kernel.tap(i.abs_diff(j));
        let (mut lower, mut diagonal) = (vec![0.0f64; count * band], vec![0.0f64; count]);
        for i in 0..count {
            for j in i.saturating_sub(band)..i {
                let first = i.saturating_sub(band).max(j.saturating_sub(band));
                let known: f64 = (first..j)
                    .map(|k| lower[i * band + i - k - 1] * lower[j * band + j - k - 1] * diagonal[k])
                    .sum();
                lower[i * band + i - j - 1] = (element(i, j) - known) / diagonal[j];
            }
            let known: f64 = (i.saturating_sub(band)..i)
                .map(|k| lower[i * band + i - k - 1].powi(2) * diagonal[k])
                .sum();
            diagonal[i] = element(i, i) - known;
        }
        let weight = |i: usize| {
            let low = i.saturating_sub(kernel.reach());
            (low..(i + kernel.reach() + 1).min(count))
                .map(|j| element(i, j))
                .sum::<f64>() as f32
        };
        Self {
            lower: lower.into_iter().map(|l| l as f32).collect(),
            inverse_diagonal: diagonal.into_iter().map(|d| (1.0 / d) as f32).collect(),
            weights: (0..count).map(weight).collect(),
            band,
        }
    }

    /// Solves along the first index of `data`: rows of equal length, `stride` apart, all columns at once. The rows
    /// are those of the whole axis from row `first` on. If rows are left out, the solution has an error bounded by
    /// [`halo`](Self::halo), which falls with the distance from the cut.
    #[inline(always)]
    pub(crate) fn solve_rows(&self, data: &mut [f32], first: usize, stride: usize, length: usize) {
        let count = data.len().div_ceil(stride).min(self.weights.len() - first);
        for i in 0..count {
            let (before, row) = data.split_at_mut(i * stride);
            let row = &mut row[..length];
            let own = first + i;
            let known = |j: usize| &before[(i - j) * stride..][..length];
            let lower = |j: usize| self.lower[own * self.band + j - 1];
            if i == 0 {
                row.iter_mut().for_each(|value| *value *= self.weights[own]);
            } else {
                scale_and_subtract(row, self.weights[own], known(1), lower(1));
            }
            for j in 2..=self.band.min(i) {
                subtract(row, known(j), lower(j));
            }
        }
        for i in (0..count).rev() {
            let (rows, after) = data.split_at_mut((i + 1) * stride);
            let row = &mut rows[i * stride..][..length];
            let own = first + i;
            let known = |j: usize| &after[(j - 1) * stride..][..length];
            let lower = |j: usize| self.lower[(own + j) * self.band + j - 1];
            if i + 1 == count {
                row.iter_mut()
                    .for_each(|value| *value *= self.inverse_diagonal[own]);
            } else {
                scale_and_subtract(row, self.inverse_diagonal[own], known(1), lower(1));
            }
            for j in 2..=self.band.min(count - 1 - i) {
                subtract(row, known(j), lower(j));
            }
        }
    }

    /// Number of further rows that a part needs on a cut side, so that the cut's share of the error falls below
    /// `share`.
    pub(crate) fn halo(&self, share: f64) -> usize {
        let count = self.weights.len();
        // Effect of an error of 1 in one row on the rows behind it, at the middle of the axis or beyond.
        let first = count / 2;
        let mut response = vec![1.0f64];
        while response.len() < count {
            let i = response.len();
            let row = (first + i).min(count - 1) * self.band;
            let next: f64 = (1..=self.band.min(i))
                .map(|j| -f64::from(self.lower[row + j - 1]) * response[i - j])
                .sum();
            response.push(next);
            if response[i + 1 - self.band.min(i + 1)..]
                .iter()
                .all(|r| r.abs() < share)
            {
                break;
            }
        }
        response.len()
    }
}

#[inline(always)]
fn subtract(row: &mut [f32], other: &[f32], factor: f32) {
    for (value, known) in row.iter_mut().zip(other) {
        *value -= factor * known;
    }
}

#[inline(always)]
fn scale_and_subtract(row: &mut [f32], scale: f32, other: &[f32], factor: f32) {
    for (value, known) in row.iter_mut().zip(other) {
        *value = *value * scale - factor * known;
    }
}

/// Replaces normalised samples (x fastest, all finite) by their interpolating coefficients, in place.
pub(crate) fn solve(values: &mut [f32], dims: [usize; 3], kernel: &GaussianKernel) {
    let [nx, ny, nz] = dims;
    let [along_x, along_y, along_z] = dims.map(|count| AxisSolver::new(kernel, count));
    values.par_chunks_mut(nx * ny).for_each(|slice| {
        // Lines along x are solved in blocks, transposed so that the inner loop runs over independent lines.
        let mut block = vec![0.0; nx * BLOCK];
        for rows in slice.chunks_mut(nx * BLOCK) {
            let lines = rows.len() / nx;
            transpose(rows, &mut block, nx, lines);
            along_x.solve_rows(&mut block, 0, BLOCK, lines);
            transpose_back(&block, rows, nx, lines);
        }
        along_y.solve_rows(slice, 0, nx, nx);
    });
    solve_along_z(values, [nx, ny, nz], &along_z);
}

pub(crate) const BLOCK: usize = 32;

#[inline(always)]
pub(crate) fn transpose(rows: &[f32], block: &mut [f32], nx: usize, lines: usize) {
    for line in 0..lines {
        for x in 0..nx {
            block[x * BLOCK + line] = rows[line * nx + x];
        }
    }
}

#[inline(always)]
pub(crate) fn transpose_back(block: &[f32], rows: &mut [f32], nx: usize, lines: usize) {
    for line in 0..lines {
        for x in 0..nx {
            rows[line * nx + x] = block[x * BLOCK + line];
        }
    }
}

/// Columns along z do not lie in one piece of memory that a thread could own: each thread copies a bundle of
/// columns out and solves it, and the bundles are copied back slice by slice.
fn solve_along_z(values: &mut [f32], [nx, ny, nz]: [usize; 3], solver: &AxisSolver) {
    let plane = nx * ny;
    // Bundles of columns are kept small, so that the copies stay far below the volume's own size.
    let bundle = (1 << 20) / nz.max(1) / size_of::<f32>();
    let bundle = bundle.clamp(16, plane.max(16));
    let group = bundle * rayon::current_num_threads();
    for start in (0..plane).step_by(group) {
        let length = group.min(plane - start);
        let mut columns: Vec<Vec<f32>> = (0..length)
            .step_by(bundle)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|first| {
                let width = bundle.min(length - first);
                let mut rows = Vec::with_capacity(width * nz);
                for z in 0..nz {
                    rows.extend_from_slice(&values[z * plane + start + first..][..width]);
                }
                solver.solve_rows(&mut rows, 0, width, width);
                rows
            })
            .collect();
        values.par_chunks_mut(plane).enumerate().for_each(|(z, slice)| {
            let mut position = start;
            for rows in &columns {
                let width = rows.len() / nz;
                slice[position..][..width].copy_from_slice(&rows[z * width..][..width]);
                position += width;
            }
        });
        columns.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splatvol_scene::Kernel;

    /// The samples reconstructed from coefficients, straight from the definition.
    fn reconstruct(c: &[f32], [nx, ny, nz]: [usize; 3], kernel: &GaussianKernel, at: [usize; 3]) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let h = kernel.tap(x.abs_diff(at[0]))
                        * kernel.tap(y.abs_diff(at[1]))
                        * kernel.tap(z.abs_diff(at[2]));
                    sum += h * f64::from(c[(z * ny + y) * nx + x]);
                    weight += h;
                }
            }
        }
        sum / weight
    }

    #[test]
    fn coefficients_interpolate_the_samples_up_to_the_border() {
        for (dims, sigma, radius) in [
            ([7, 5, 9], 0.7, 3.0),
            ([1, 40, 2], 0.6, 2.0),
            ([13, 1, 1], 1.0, 4.0),
            ([3, 3, 3], 0.7, 3.5),
        ] {
            let kernel = GaussianKernel::new(Kernel::Gaussian { sigma, radius });
            let count: usize = dims.iter().product();
            let samples: Vec<f32> = (0..count).map(|i| ((i * 7919) % 101) as f32 / 101.0).collect();
            let mut c = samples.clone();
            solve(&mut c, dims, &kernel);
            for (i, &sample) in samples.iter().enumerate() {
                let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                let back = reconstruct(&c, dims, &kernel, at);
                assert!(
                    (back - f64::from(sample)).abs() < 2e-5,
                    "{dims:?} {at:?} {back} {sample}"
                );
            }
        }
    }
}
