//! Samples of a whole volume to kernel coefficients: normalised to the value range, optionally prefiltered. Clouds are
//! extracted from these; sheets solve the voxels that they need, region by region ([`crate::field`]).

use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{Volume, with_samples};

use crate::brick::BrickGrid;
use crate::kernel::GaussianKernel;
use crate::prefilter;

/// Coefficients `c_k` of the field (docs/numerics.md), x fastest; NaN for missing samples.
///
/// A lattice to interpolate from is continued by the outermost sample beyond each face (`margin`), so that values near
/// the border have neighbours on both sides.
#[derive(Debug, Clone)]
pub struct Coefficients {
    /// Lattice points along x, y, z.
    pub dims: [usize; 3],
    /// Lattice points before voxel 0 (and behind the last) along x, y, z.
    pub margin: [usize; 3],
    /// One per lattice point.
    pub values: Vec<f32>,
}

impl Coefficients {
    /// Coefficients of a volume, `F = (f - lo) / (hi - lo)`, with the bricks of these samples.
    pub fn new(volume: &Volume, use_as: Use<'_>) -> (Self, BrickGrid) {
        let own = volume.grid().dims();
        let margin = match use_as {
            Use::Samples => [0; 3],
            Use::Field(_) => own.map(|n| usize::from(n > 1)),
        };
        let dims = std::array::from_fn(|a| own[a] + 2 * margin[a]);
        let mut values = normalised(volume, dims, margin);
        let interpolate = match use_as {
            Use::Samples => None,
            Use::Field(kernel) => kernel,
        };
        let bricks = BrickGrid::new(&values, dims, interpolate.is_some());
        if let Some(kernel) = interpolate {
            let missing = if volume.statistics().non_finite > 0 {
                fill_missing(&mut values, dims)
            } else {
                Vec::new()
            };
            prefilter::solve(&mut values, dims, kernel);
            for index in missing {
                values[index] = f32::NAN;
            }
        }
        (Self { dims, margin, values }, bricks)
    }
}

impl Coefficients {
    /// Central differences at a lattice point, per voxel: one-sided at the border, missing neighbours count as the
    /// point itself.
    #[inline(always)]
    pub fn difference(&self, index: usize, position: [usize; 3]) -> [f32; 3] {
        let strides = [1, self.dims[0], self.dims[0] * self.dims[1]];
        let here = self.values[index];
        let value = |inside: bool, other: usize| {
            let value = if inside { self.values[other] } else { here };
            if value.is_nan() { here } else { value }
        };
        std::array::from_fn(|axis| {
            let (left, right) = (position[axis] > 0, position[axis] + 1 < self.dims[axis]);
            let before = value(left, index.wrapping_sub(strides[axis]));
            let after = value(right, index + strides[axis]);
            (after - before) / f32::from(u8::from(left) + u8::from(right)).max(1.0)
        })
    }
}

/// Purpose of the coefficients.
#[derive(Debug, Clone, Copy)]
pub enum Use<'a> {
    /// The unchanged samples, each to be classified.
    Samples,
    /// A continuous field; with a kernel, one that interpolates the samples by it.
    Field(Option<&'a GaussianKernel>),
}

/// `(f - lo) / (hi - lo)` per lattice point, NaN where missing; the divisor is 1 for a volume of one value.
fn normalised(volume: &Volume, dims: [usize; 3], margin: [usize; 3]) -> Vec<f32> {
    let [low, high] = volume.value_range();
    let scale = if high > low { 1.0 / (high - low) } else { 1.0 };
    let rescale = volume.rescale();
    let own = volume.grid().dims();
    let voxel = |axis: usize, point: usize| sample_at(point, margin[axis], own[axis]);
    let mut values = vec![0.0f32; dims.iter().product()];
    values
        .par_chunks_mut(dims[0])
        .enumerate()
        .for_each(|(row, line)| {
            let start = (voxel(2, row / dims[1]) * own[1] + voxel(1, row % dims[1])) * own[0];
            with_samples!(volume.samples(), data => for (x, value) in line.iter_mut().enumerate() {
                let real = rescale.apply(widen(data[start + voxel(0, x)]));
                *value = if real.is_finite() { ((real - low) * scale) as f32 } else { f32::NAN };
            });
        });
    values
}

/// The sample at a lattice point along an axis of `count` samples. The outermost sample continues the lattice, not its
/// neighbour, as a mirror has it: material next to a face of air would show again half a voxel outside.
#[inline(always)]
pub(crate) fn sample_at(point: usize, margin: usize, count: usize) -> usize {
    point.saturating_sub(margin).min(count - 1)
}

/// Replaces missing samples by the mean of their finite face neighbours (0 without any), so that the solver has no
/// jump there, and lists them.
fn fill_missing(values: &mut [f32], [nx, ny, nz]: [usize; 3]) -> Vec<usize> {
    let missing: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_nan()).collect();
    let filled: Vec<f32> = missing
        .iter()
        .map(|&index| {
            let (x, y, z) = (index % nx, index / nx % ny, index / (nx * ny));
            let neighbours = [
                (x > 0, index.wrapping_sub(1)),
                (x + 1 < nx, index + 1),
                (y > 0, index.wrapping_sub(nx)),
                (y + 1 < ny, index + nx),
                (z > 0, index.wrapping_sub(nx * ny)),
                (z + 1 < nz, index + nx * ny),
            ];
            let finite = neighbours
                .iter()
                .filter(|(inside, i)| *inside && values[*i].is_finite());
            let (sum, found) = finite.fold((0.0, 0), |(sum, found), (_, i)| (sum + values[*i], found + 1));
            if found == 0 { 0.0 } else { sum / found as f32 }
        })
        .collect();
    for (&index, value) in missing.iter().zip(filled) {
        values[index] = value;
    }
    missing
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use splatvol_scene::{Grid, Kernel, LengthUnit, Rescale, Samples};

    #[test]
    fn missing_samples_stay_missing_and_do_not_spread() {
        let coefficients = |middle: f32| {
            let grid = Grid::centred([5, 5, 5], DVec3::ONE).unwrap();
            let mut data = vec![3.0f32; 125];
            data[0] = 5.0;
            data[62] = middle;
            let volume = Volume::new(
                grid,
                Samples::F32(data.into()),
                Rescale::default(),
                LengthUnit::Unknown,
            )
            .unwrap();
            let kernel = GaussianKernel::new(Kernel::default());
            Coefficients::new(&volume, Use::Field(Some(&kernel))).0.values
        };
        let middle = (3 * 7 + 3) * 7 + 3;
        for (index, (missing, filled)) in coefficients(f32::NAN)
            .into_iter()
            .zip(coefficients(3.0))
            .enumerate()
        {
            assert!(
                if index == middle {
                    missing.is_nan()
                } else {
                    (missing - filled).abs() < 1e-6
                },
                "{index}"
            );
        }
    }

    #[test]
    fn the_field_continues_by_its_outermost_samples() {
        let grid = Grid::centred([3, 1, 2], DVec3::ONE).unwrap();
        let volume = Volume::new(
            grid,
            Samples::U8(vec![0, 1, 2, 3, 4, 5].into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap();
        let (field, _) = Coefficients::new(&volume, Use::Field(None));
        assert_eq!((field.dims, field.margin), ([5, 1, 4], [1, 0, 1]));
        let fives: Vec<f32> = field.values.iter().map(|v| v * 5.0).collect();
        assert_eq!(fives[..10], [0.0, 0.0, 1.0, 2.0, 2.0, 0.0, 0.0, 1.0, 2.0, 2.0]);
        assert_eq!(Coefficients::new(&volume, Use::Samples).0.dims, [3, 1, 2]);
    }
}
