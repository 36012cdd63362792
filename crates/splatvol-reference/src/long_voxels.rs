//! Long voxels: samples that are interpolated along the axes where they lie far apart, before they are a field.
//!
//! Along an axis whose spacing is `r >= 2.5` times the smallest one, `n = ceil(r / 1.4)` values per sample, at
//! `x_i = (i + 1/2) / n - 1/2`:
//!
//! `g_i = sum_k f_k u(x_i - k)`, u the six-point kernel of Keys 1981, f continued by its mirror image at the box's faces,
//! g kept within the range of f.

use std::array::from_fn;

use glam::{DAffine3, DVec3};
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};

use crate::ReferenceError;

/// A volume with more samples along long axes; `None` where it has none, or samples are missing.
///
/// # Errors
/// A grid that is too fine.
pub fn refined(volume: &Volume) -> Result<Option<Volume>, ReferenceError> {
    let grid = volume.grid();
    let dims = grid.dims();
    let counts = values_per_sample(grid);
    if counts == [1; 3] || volume.statistics().non_finite > 0 {
        return Ok(None);
    }
    let mut size = dims;
    let mut values: Vec<f64> = (0..grid.sample_count())
        .map(|index| volume.value(index))
        .collect();
    for axis in 0..3 {
        values = along(&values, size, axis, counts[axis]);
        size[axis] *= counts[axis];
    }
    let [low, high] = volume.value_range();
    for value in &mut values {
        *value = value.clamp(low, high);
    }
    let step = DVec3::from_array(counts.map(|n| 1.0 / n as f64));
    let old_from_new = DAffine3::from_translation(0.5 * step - 0.5) * DAffine3::from_scale(step);
    let finer = Grid::from_affine(size, grid.world_from_voxel() * old_from_new)?;
    let samples = Samples::F64(values.into());
    Ok(Some(Volume::new(
        finer,
        samples,
        Rescale::default(),
        LengthUnit::Unknown,
    )?))
}

/// n along each axis. (No more than 16 for a sample: no test has longer voxels.)
fn values_per_sample(grid: &Grid) -> [usize; 3] {
    let spacing = grid.spacing().to_array();
    let is_axis = |axis: usize| grid.dims()[axis] > 1;
    let smallest = (0..3)
        .filter(|&axis| is_axis(axis))
        .map(|axis| spacing[axis])
        .fold(f64::INFINITY, f64::min);
    from_fn(|axis| {
        let ratio = spacing[axis] / smallest;
        if is_axis(axis) && ratio > 2.499_999 {
            (ratio / 1.4 - 1e-6).ceil() as usize
        } else {
            1
        }
    })
}

/// Interpolates along one axis.
fn along(values: &[f64], size: [usize; 3], axis: usize, n: usize) -> Vec<f64> {
    if n == 1 {
        return values.to_vec();
    }
    let mut finer = size;
    finer[axis] *= n;
    let count = size[axis] as i64;
    let value = |i: usize| {
        let mut at = [i % finer[0], i / finer[0] % finer[1], i / (finer[0] * finer[1])];
        let x = (at[axis] as f64 + 0.5) / n as f64 - 0.5;
        let mut sum = 0.0;
        for k in x.floor() as i64 - 2..=x.floor() as i64 + 3 {
            // Mirrored at -1/2 and at count - 1/2, as often as it takes.
            let mut inside = k;
            while !(0..count).contains(&inside) {
                inside = if inside < 0 {
                    -1 - inside
                } else {
                    2 * count - 1 - inside
                };
            }
            at[axis] = inside as usize;
            sum += values[(at[2] * size[1] + at[1]) * size[0] + at[0]] * kernel(x - k as f64);
        }
        sum
    };
    (0..finer.iter().product()).map(value).collect()
}

/// Keys 1981, the kernel of fourth order.
fn kernel(x: f64) -> f64 {
    let s = x.abs();
    if s < 1.0 {
        4.0 / 3.0 * s.powi(3) - 7.0 / 3.0 * s.powi(2) + 1.0
    } else if s < 2.0 {
        -7.0 / 12.0 * s.powi(3) + 3.0 * s.powi(2) - 59.0 / 12.0 * s + 15.0 / 6.0
    } else if s < 3.0 {
        1.0 / 12.0 * s.powi(3) - 2.0 / 3.0 * s.powi(2) + 21.0 / 12.0 * s - 3.0 / 2.0
    } else {
        0.0
    }
}
