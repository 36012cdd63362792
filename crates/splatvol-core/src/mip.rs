//! Half-resolution volumes, for pictures in which a voxel is smaller than a pixel.
//!
//! Along an axis of n samples the half has `m = ceil(n / 2)` cells of `n / m` old spacings, so that both have the
//! same box in world space. Each new sample is the mean of the old cells within it, partial cells weighted by their
//! length: 1/2, 1/2 where n is even, three weights where it is odd. Constants and the integral over the box are
//! preserved, and linear data stay in place (for odd n up to 1/16 of an old step). Missing samples are left out of
//! the mean; a new sample is missing if all its old samples are.

mod chunks;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use splatvol_scene::volume::widen;
use splatvol_scene::{Block, Grid, LengthUnit, Rescale, Samples, SceneError, Volume, VoxelBox, with_samples};

pub(crate) use chunks::half_in_chunks;

use crate::field::SourceLevel;

/// A volume of half the samples along each axis (rounded up) in the same box.
///
/// Samples of 8 and 16 bits become `u16` that span the value range (error 8e-6 of it), all others `f32`.
///
/// # Errors
/// A grid whose doubled spacing leaves the domain of [`Grid`], or samples that cannot be read.
pub fn half(source: &SourceLevel) -> Result<Volume, SceneError> {
    let reduction = Reduction::new(source)?;
    let grid = reduction.grid.clone();
    let count = grid.sample_count();
    let samples = match reduction.steps {
        Some(_) => {
            let mut data = vec![0u16; count];
            reduction.run(&mut data)?;
            Samples::U16(data.into())
        }
        None => {
            let mut data = vec![0.0f32; count];
            reduction.run(&mut data)?;
            Samples::F32(data.into())
        }
    };
    Volume::new(grid, samples, reduction.rescale(), LengthUnit::Unknown)
}

/// Old voxel coordinates of new ones: cell edges meet at -1/2.
fn half_from_own(own: [usize; 3], dims: [usize; 3]) -> DAffine3 {
    let ratio = DVec3::from_array(std::array::from_fn(|a| own[a] as f64 / dims[a] as f64));
    DAffine3::from_translation(0.5 * (ratio - DVec3::ONE)) * DAffine3::from_scale(ratio)
}

/// Old cells by which the edge of a new one may be off by rounding.
const ROUNDING: f64 = 1e-9;
/// Weight below which an old cell is only touched, by rounding.
const TOUCHED: f64 = 1e-6;

/// The old samples that a new one is the mean of, along one axis.
#[derive(Debug, Clone)]
pub(crate) struct Cover {
    first: usize,
    weights: Vec<f32>,
}

impl Cover {
    /// Covers of `count` new samples, each of as many of the `own` old ones.
    pub(crate) fn all(own: usize, count: usize) -> Vec<Self> {
        let ratio = own as f64 / count as f64;
        let cover = |i: usize| {
            let (from, to) = (i as f64 * ratio, (i + 1) as f64 * ratio);
            let first = (from + ROUNDING).floor() as usize;
            let part = |cell: usize| (to.min((cell + 1) as f64) - from.max(cell as f64)).max(0.0) / ratio;
            let parts = (first..own).map(part).take_while(|&part| part >= TOUCHED);
            Self {
                first,
                weights: parts.map(|part| part as f32).collect(),
            }
        };
        (0..count).map(cover).collect()
    }

    /// Old samples, and their shares of the mean.
    pub(crate) fn taps(&self) -> impl Iterator<Item = (usize, f32)> {
        (self.first..).zip(self.weights.iter().copied())
    }

    /// The old samples: the first, and one past the last.
    pub(crate) fn range(&self) -> [usize; 2] {
        [self.first, self.first + self.weights.len()]
    }
}

/// Means of samples, less the smallest of the value range (so that f32 is precise enough).
#[derive(Debug)]
pub(crate) struct Reduction {
    source: SourceLevel,
    grid: Grid,
    cover: [Vec<Cover>; 3],
    /// Smallest real value.
    low: f64,
    /// Steps of `u16` per real value; `None` where means are `f32`.
    steps: Option<f64>,
}

/// Sums along x of one row of new samples: of values and, where samples may be missing, of weights.
#[derive(Debug, Default)]
struct Sums {
    values: Vec<f32>,
    weights: Vec<f32>,
    /// The old sample at which they begin.
    first: usize,
}

/// Type of means.
pub(crate) trait Mean: Copy + Send {
    /// A mean, less the smallest value.
    fn of(mean: f32, reduction: &Reduction) -> Self;
}

impl Mean for u16 {
    fn of(mean: f32, reduction: &Reduction) -> Self {
        (f64::from(mean) * reduction.steps.unwrap_or(0.0)).round() as Self
    }
}

impl Mean for f32 {
    fn of(mean: f32, reduction: &Reduction) -> Self {
        (f64::from(mean) + reduction.low) as Self
    }
}

impl Reduction {
    /// Of a level whose value range is known.
    ///
    /// # Errors
    /// Same as [`half`].
    pub(crate) fn new(source: &SourceLevel) -> Result<Self, SceneError> {
        let own = source.grid();
        let dims = own.dims().map(|n| n.div_ceil(2));
        let grid = Grid::from_affine(dims, own.world_from_voxel() * half_from_own(own.dims(), dims))?;
        let [low, high] = source.value_range();
        let narrow = is_narrow(source)? && high > low;
        Ok(Self {
            cover: std::array::from_fn(|a| Cover::all(own.dims()[a], dims[a])),
            source: source.clone(),
            grid,
            low,
            steps: narrow.then(|| f64::from(u16::MAX) / (high - low)),
        })
    }

    pub(crate) fn source(&self) -> &SourceLevel {
        &self.source
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Whether means are `u16`; `f32` otherwise.
    pub(crate) fn is_narrow(&self) -> bool {
        self.steps.is_some()
    }

    /// Conversion of means to real values.
    pub(crate) fn rescale(&self) -> Rescale {
        let [low, high] = self.source.value_range();
        match self.steps {
            Some(_) => Rescale {
                slope: (high - low) / f64::from(u16::MAX),
                intercept: low,
            },
            None => Rescale::default(),
        }
    }

    /// All means.
    fn run<T: Mean>(&self, data: &mut [T]) -> Result<(), SceneError> {
        let [nx, ny, _] = self.grid.dims();
        data.par_chunks_mut(nx * ny)
            .enumerate()
            .try_for_each_init(Default::default, |memory, (z, slice)| {
                let region = VoxelBox {
                    first: [0, 0, z],
                    size: [nx, ny, 1],
                };
                self.means(region, slice, memory)
            })
    }

    /// The means of a region, x fastest.
    pub(crate) fn means<T: Mean>(
        &self,
        region: VoxelBox,
        data: &mut [T],
        memory: &mut Option<Samples>,
    ) -> Result<(), SceneError> {
        let ends: [[usize; 2]; 3] = std::array::from_fn(|axis| {
            let cover = &self.cover[axis];
            let (first, last) = (region.first[axis], region.first[axis] + region.size[axis] - 1);
            [cover[first].range()[0], cover[last].range()[1]]
        });
        let covered = VoxelBox {
            first: ends.map(|[first, _]| first),
            size: ends.map(|[first, end]| end - first),
        };
        let block = self.source.read(covered, memory)?;
        let mut sums = Sums {
            values: vec![0.0; covered.size[0]],
            weights: vec![0.0; covered.size[0]],
            first: covered.first[0],
        };
        for (number, row) in data.chunks_mut(region.size[0]).enumerate() {
            let (y, z) = (number % region.size[1], number / region.size[1]);
            sums.gather(self, &block, [region.first[1] + y, region.first[2] + z]);
            sums.reduce(self, row, region.first[0]);
        }
        Ok(())
    }
}

/// Whether samples are of 8 or 16 bits.
fn is_narrow(source: &SourceLevel) -> Result<bool, SceneError> {
    let one = VoxelBox {
        first: [0; 3],
        size: [1; 3],
    };
    let mut memory = None;
    let block = source.read(one, &mut memory)?;
    Ok(block.samples.bytes_per_sample() <= 2)
}

impl Sums {
    /// Sums over the rows that a row of new samples covers.
    fn gather(&mut self, reduction: &Reduction, block: &Block<'_>, [y, z]: [usize; 2]) {
        let rescale = reduction.source.rescale();
        let (slope, offset) = (rescale.slope, rescale.intercept - reduction.low);
        let missing = reduction.source.statistics().non_finite > 0;
        self.values.fill(0.0);
        self.weights.fill(0.0);
        for (z, of_z) in reduction.cover[2][z].taps() {
            for (y, of_y) in reduction.cover[1][y].taps() {
                let weight = of_z * of_y;
                with_samples!(block.samples, data => {
                    let row = &block.of.row(data, [y, z])[self.first - block.of.first[0]..];
                    if missing {
                        let sums = self.values.iter_mut().zip(&mut self.weights);
                        for ((value, sum), sample) in sums.zip(row) {
                            let real = (widen(*sample) * slope + offset) as f32;
                            if real.is_finite() {
                                *value += weight * real;
                                *sum += weight;
                            }
                        }
                    } else {
                        for (value, sample) in self.values.iter_mut().zip(row) {
                            *value += weight * (widen(*sample) * slope + offset) as f32;
                        }
                    }
                });
            }
        }
        if !missing {
            self.weights.fill(1.0);
        }
    }

    /// Means along x, from a new sample on.
    fn reduce<T: Mean>(&self, reduction: &Reduction, row: &mut [T], from: usize) {
        for (out, cover) in row.iter_mut().zip(&reduction.cover[0][from..]) {
            let (mut value, mut weight) = (0.0, 0.0);
            for (x, of_x) in cover.taps() {
                value += of_x * self.values[x - self.first];
                weight += of_x * self.weights[x - self.first];
            }
            *out = T::of(if weight > 0.0 { value / weight } else { f32::NAN }, reduction);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use splatvol_testing::random::Random;

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
