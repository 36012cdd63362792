//! Samples to kernel coefficients: normalised to the value range, optionally prefiltered.

use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{Volume, with_samples};

use crate::brick::BrickGrid;
use crate::kernel::GaussianKernel;
use crate::prefilter;

/// Coefficients `c_k` of the field (docs/numerics.md), x fastest; NaN marks samples that are missing.
#[derive(Debug, Clone)]
pub struct Coefficients {
    /// Dimensions x y z.
    pub dims: [usize; 3],
    /// One per sample.
    pub values: Vec<f32>,
}

impl Coefficients {
    /// Coefficients of a volume: `F = (f - lo) / (hi - lo)`, prefiltered where `interpolate` asks for a kernel.
    /// Takes 4 bytes per sample, and nothing near that beside it.
    /// With them come the bricks of the samples.
    pub fn new(volume: &Volume, interpolate: Option<&GaussianKernel>) -> (Self, BrickGrid) {
        let dims = volume.grid().dims();
        let mut values = normalised(volume);
        let bricks = BrickGrid::new(&values, dims, interpolate.is_some());
        if let Some(kernel) = interpolate {
            let missing = fill_missing(&mut values, dims, volume.statistics().non_finite);
            prefilter::solve(&mut values, dims, kernel);
            for index in missing {
                values[index] = f32::NAN;
            }
        }
        (Self { dims, values }, bricks)
    }
}

/// `(f - lo) / (hi - lo)` per sample, NaN where missing; the divisor is 1 for a volume of one value.
fn normalised(volume: &Volume) -> Vec<f32> {
    let [low, high] = volume.value_range();
    let scale = if high > low { 1.0 / (high - low) } else { 1.0 };
    let rescale = volume.rescale();
    with_samples!(volume.samples(), data => data
        .par_iter()
        .with_min_len(1 << 14)
        .map(|&sample| {
            let value = rescale.apply(widen(sample));
            if value.is_finite() { ((value - low) * scale) as f32 } else { f32::NAN }
        })
        .collect())
}

/// Gives missing samples the mean of their finite face neighbours (0 without any), so that the solver sees no jump
/// there, and lists them.
fn fill_missing(values: &mut [f32], [nx, ny, nz]: [usize; 3], count: usize) -> Vec<usize> {
    if count == 0 {
        return Vec::new();
    }
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
            let volume = Volume::new(grid, Samples::F32(data), Rescale::default(), LengthUnit::Unknown);
            Coefficients::new(&volume.unwrap(), Some(&GaussianKernel::new(Kernel::default())))
                .0
                .values
        };
        for (index, (missing, filled)) in coefficients(f32::NAN)
            .into_iter()
            .zip(coefficients(3.0))
            .enumerate()
        {
            assert!(
                if index == 62 {
                    missing.is_nan()
                } else {
                    (missing - filled).abs() < 1e-6
                },
                "{index}"
            );
        }
    }
}
