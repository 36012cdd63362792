//! Half-resolution volumes, for pictures in which a voxel is smaller than a pixel.
//!
//! Along an axis of n samples the half has `m = ceil(n / 2)` cells of `n / m` old spacings, so that both have the
//! same box in world space. Each new sample is the mean of the old cells within it, partial cells weighted by their
//! length: 1/2, 1/2 where n is even, three weights where it is odd. Constants and the integral over the box are
//! preserved, and linear data stay in place (for odd n up to 1/16 of an old step). Missing samples are left out of
//! the mean; a new sample is missing if all its old samples are.

use splatvol_scene::{ChunkedVolume, Grid, SceneError, Volume};

use crate::field::SourceLevel;
use crate::resample::{Resampling, Taps, world_from_new};

/// A volume of half the samples along each axis (rounded up) in the same box.
///
/// Samples of 8 and 16 bits become `u16` that span the value range (error 8e-6 of it), all others `f32`.
///
/// # Errors
/// A grid whose doubled spacing leaves the domain of [`Grid`], or samples that cannot be read.
pub fn half(source: &SourceLevel) -> Result<Volume, SceneError> {
    halving(source)?.volume()
}

/// The half of a level in chunks, within the budget of these. `number`: of the half, counted from the volume itself.
///
/// # Errors
/// As [`half`].
pub(crate) fn half_in_chunks(
    (source, number): (&SourceLevel, usize),
    chunks: &ChunkedVolume,
) -> Result<SourceLevel, SceneError> {
    let (_, own) = source.of();
    // So that a chunk is made of whole ones.
    let chunk = chunks.layout(own).chunk.map(|edge| edge.div_ceil(2));
    let made = halving(source)?.in_chunks((number, "half"), (chunk, None), chunks)?;
    Ok(SourceLevel::new(made, 0))
}

fn halving(source: &SourceLevel) -> Result<Resampling, SceneError> {
    let own = source.grid();
    let dims = own.dims().map(|n| n.div_ceil(2));
    let grid = Grid::from_affine(dims, world_from_new(own, dims))?;
    let taps = std::array::from_fn(|a| Taps::of_means(own.dims()[a], dims[a]));
    Resampling::new(source, grid, taps)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use splatvol_scene::{LengthUnit, Rescale, Samples};
    use splatvol_testing::random::Random;

    use super::*;

    fn volume(dims: [usize; 3], samples: Samples) -> Volume {
        let grid = Grid::new(
            dims,
            DVec3::new(3.0, -1.0, 2.0),
            DVec3::new(0.5, 1.0, 2.0),
            glam::DMat3::from_rotation_y(0.3),
        )
        .unwrap();
        Volume::new(
            grid,
            samples,
            Rescale {
                slope: -2.0,
                intercept: 7.0,
            },
            LengthUnit::Millimetre,
        )
        .unwrap()
    }

    #[test]
    fn the_box_and_the_integral_stay() {
        for dims in [[8, 6, 4], [7, 5, 9], [1, 3, 2], [1, 1, 1], [2, 33, 1]] {
            let count: usize = dims.iter().product();
            let mut random = Random::new(7);
            let data: Vec<u8> = (0..count).map(|_| (random.unit() * 255.0) as u8).collect();
            let full = volume(dims, Samples::U8(data.into()));
            let half = half(&Arc::new(full.clone()).into()).unwrap();
            for (a, b) in full.grid().corners().iter().zip(half.grid().corners()) {
                assert!((*a - b).length() < 1e-12, "{dims:?} {a} {b}");
            }
            let integral =
                |v: &Volume| v.statistics().mean * v.grid().sample_count() as f64 * v.grid().cell_volume();
            let (a, b) = (integral(&full), integral(&half));
            let range = 510.0 * full.grid().sample_count() as f64 * full.grid().cell_volume();
            assert!((a - b).abs() < 1e-5 * range, "{dims:?} {a} {b}");
        }
    }

    #[test]
    fn ramps_stay_where_they_are_in_the_world() {
        for dims in [[8, 6, 4], [9, 5, 7]] {
            let odd = dims[0] % 2 == 1;
            let steps = [3.0, -1.0, 2.0];
            let value = |voxel: DVec3| DVec3::from_array(steps).dot(voxel);
            let data = (0..dims.iter().product::<usize>())
                .map(|i| {
                    let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                    value(DVec3::from_array(at.map(|c| c as f64))) as f32
                })
                .collect();
            let full = volume(dims, Samples::F32(data));
            let half = half(&Arc::new(full.clone()).into()).unwrap();
            let new = half.grid().dims();
            let own_from_half = full.grid().world_from_voxel().inverse() * half.grid().world_from_voxel();
            for i in 0..half.grid().sample_count() {
                let at = [i % new[0], i / new[0] % new[1], i / (new[0] * new[1])];
                let there = own_from_half.transform_point3(DVec3::from_array(at.map(|c| c as f64)));
                let expected = full.rescale().apply(value(there));
                let tolerance = if odd { 2.0 * 6.0 / 15.0 } else { 1e-4 };
                assert!(
                    (half.value(i) - expected).abs() < tolerance,
                    "{dims:?} {at:?}: {} {expected}",
                    half.value(i)
                );
            }
        }
    }

    #[test]
    fn constants_stay_and_missing_samples_have_no_share() {
        let mut data = vec![4.0f32; 6 * 6 * 6];
        data[0] = f32::NAN;
        for z in 2..4 {
            for y in 2..4 {
                for x in 2..4 {
                    data[(z * 6 + y) * 6 + x] = f32::INFINITY;
                }
            }
        }
        let half = half(&Arc::new(volume([6; 3], Samples::F32(data.into()))).into()).unwrap();
        for i in 0..27 {
            let value = half.value(i);
            assert!(
                if i == 13 { value.is_nan() } else { value == -1.0 },
                "{i} {value}"
            );
        }
    }
}
