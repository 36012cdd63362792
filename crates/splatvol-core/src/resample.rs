//! Volumes on another grid in the same box: each new sample is a weighted sum of old ones, axis by axis.
//!
//! `g(i, j, k) = sum_xyz a_i(x) b_j(y) c_k(z) f(x, y, z)`, where the weights along each axis ([`Taps`]) sum to 1. Missing samples
//! are left out, and the weights of the others divided by their sum; a new sample is missing if all its old samples are.
//! Sums are in `f32`, of values less the smallest one.

mod chunks;
mod rows;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, SceneError, Volume, VoxelBox};

use crate::field::SourceLevel;
use rows::Rows;

/// World coordinates of the voxels of a grid of other dims in the same box: cell edges meet at -1/2.
pub(crate) fn world_from_new(own: &Grid, dims: [usize; 3]) -> DAffine3 {
    let ratio = DVec3::from_array(std::array::from_fn(|a| own.dims()[a] as f64 / dims[a] as f64));
    let own_from_new = DAffine3::from_translation(0.5 * (ratio - DVec3::ONE)) * DAffine3::from_scale(ratio);
    own.world_from_voxel() * own_from_new
}

/// Old cells by which the edge of a new one may be off by rounding.
const ROUNDING: f64 = 1e-9;
/// New slices that are made together: most of their old ones are the same.
const SLICES: usize = 8;
/// Weight below which an old cell is only touched, by rounding.
const TOUCHED: f64 = 1e-6;

/// The old samples that a new one is made of, along one axis, and their weights.
#[derive(Debug, Clone)]
pub(crate) struct Taps {
    first: usize,
    weights: Vec<f32>,
}

impl Taps {
    /// Means: of `count` new samples, each of as many of the `own` old ones, partial ones weighted by their length.
    pub(crate) fn of_means(own: usize, count: usize) -> Vec<Self> {
        let ratio = own as f64 / count as f64;
        let taps = |i: usize| {
            let (from, to) = (i as f64 * ratio, (i + 1) as f64 * ratio);
            let first = (from + ROUNDING).floor() as usize;
            let part = |cell: usize| (to.min((cell + 1) as f64) - from.max(cell as f64)).max(0.0) / ratio;
            let parts = (first..own).map(part).take_while(|&part| part >= TOUCHED);
            Self {
                first,
                weights: parts.map(|part| part as f32).collect(),
            }
        };
        (0..count).map(taps).collect()
    }

    /// From the first old sample and the weights.
    pub(crate) fn new(first: usize, weights: Vec<f32>) -> Self {
        Self { first, weights }
    }

    /// Old samples, and their weights.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f32)> {
        (self.first..).zip(self.weights.iter().copied())
    }

    /// The old samples: the first, and one past the last.
    pub(crate) fn range(&self) -> [usize; 2] {
        [self.first, self.first + self.weights.len()]
    }
}

/// A volume's samples on another grid, less the smallest of the value range (so that f32 is precise enough).
#[derive(Debug)]
pub(crate) struct Resampling {
    source: SourceLevel,
    grid: Grid,
    taps: [Vec<Taps>; 3],
    /// Smallest and largest real value; no new sample lies outside.
    range: [f64; 2],
    /// Steps of `u16` per real value; `None` where new samples are `f32`.
    steps: Option<f64>,
}

/// Type of new samples.
trait NewSample: Copy + Send {
    /// A sample, given its value less the smallest.
    fn of(value: f32, resampling: &Resampling) -> Self;
}

impl NewSample for u16 {
    #[inline(always)]
    fn of(value: f32, resampling: &Resampling) -> Self {
        // Negative numbers and those beyond the last step end at the limits of the type.
        (f64::from(value) * resampling.steps.unwrap_or(0.0) + 0.5) as Self
    }
}

impl NewSample for f32 {
    #[inline(always)]
    fn of(value: f32, resampling: &Resampling) -> Self {
        let [low, high] = resampling.range;
        let real = f64::from(value) + low;
        // A missing sample stays what it is.
        (if real < low {
            low
        } else if real > high {
            high
        } else {
            real
        }) as Self
    }
}

impl Resampling {
    /// Of a level whose value range is known, with the taps of the new samples along each axis.
    ///
    /// # Errors
    /// Samples that cannot be read.
    pub(crate) fn new(source: &SourceLevel, grid: Grid, taps: [Vec<Taps>; 3]) -> Result<Self, SceneError> {
        let [low, high] = source.value_range();
        let narrow = is_narrow(source)? && high > low;
        Ok(Self {
            taps,
            source: source.clone(),
            grid,
            range: [low, high],
            steps: narrow.then(|| f64::from(u16::MAX) / (high - low)),
        })
    }

    /// Conversion of new samples to real values.
    pub(crate) fn rescale(&self) -> Rescale {
        let [low, high] = self.range;
        match self.steps {
            Some(_) => Rescale {
                slope: (high - low) / f64::from(u16::MAX),
                intercept: low,
            },
            None => Rescale::default(),
        }
    }

    /// Smallest and largest stored value of new samples whose old ones, stored, lie between these, and which may lie outside by
    /// a share of their range.
    pub(crate) fn ends(&self, old: [f32; 2], outside: f64) -> [f64; 2] {
        let [a, b] = old.map(|end| self.source.rescale().apply(f64::from(end)));
        let (low, high) = (a.min(b), a.max(b));
        let reach = outside * (high - low);
        let real = [
            (low - reach).max(self.range[0]),
            (high + reach).min(self.range[1]),
        ];
        let new = self.rescale();
        let [low, high] = real.map(|end| (end - new.intercept) / new.slope);
        // New samples are rounded.
        match self.steps {
            Some(_) => [low.floor() - 1.0, high.ceil() + 1.0],
            None => [low, high],
        }
    }

    /// All new samples: `u16` that span the value range where the old ones have 8 or 16 bits, `f32` otherwise.
    ///
    /// # Errors
    /// Samples that cannot be read.
    pub(crate) fn volume(self) -> Result<Volume, SceneError> {
        let count = self.grid.sample_count();
        let samples = match self.steps {
            Some(_) => {
                let mut data = vec![0u16; count];
                self.run(&mut data)?;
                Samples::U16(data.into())
            }
            None => {
                let mut data = vec![0.0f32; count];
                self.run(&mut data)?;
                Samples::F32(data.into())
            }
        };
        let rescale = self.rescale();
        Volume::new(self.grid, samples, rescale, LengthUnit::Unknown)
    }

    fn run<T: NewSample>(&self, data: &mut [T]) -> Result<(), SceneError> {
        let [nx, ny, _] = self.grid.dims();
        data.par_chunks_mut(nx * ny * SLICES)
            .enumerate()
            .try_for_each_init(Default::default, |memory, (number, slices)| {
                let region = VoxelBox {
                    first: [0, 0, number * SLICES],
                    size: [nx, ny, slices.len() / (nx * ny)],
                };
                self.region(region, slices, memory)
            })
    }

    /// The new samples of a region, x fastest.
    fn region<T: NewSample>(
        &self,
        region: VoxelBox,
        data: &mut [T],
        memory: &mut Option<Samples>,
    ) -> Result<(), SceneError> {
        let old = self.old_samples(region);
        let block = self.source.read(old, memory)?;
        let mut rows = Rows::new(old);
        let [nx, ny, nz] = region.size;
        for y in 0..ny {
            rows.convert(self, &block, region.first[1] + y);
            for z in 0..nz {
                let first = (z * ny + y) * nx;
                let row = &mut data[first..first + nx];
                rows.add_up(self, [region.first[1] + y, region.first[2] + z]);
                rows.reduce(self, row, region.first[0]);
            }
        }
        Ok(())
    }

    /// The old samples that the new ones of a region are made of.
    pub(crate) fn old_samples(&self, region: VoxelBox) -> VoxelBox {
        let ends: [[usize; 2]; 3] = std::array::from_fn(|axis| {
            let taps = &self.taps[axis][region.first[axis]..region.first[axis] + region.size[axis]];
            let both = |[first, end]: [usize; 2], own: &Taps| {
                let [from, to] = own.range();
                [first.min(from), end.max(to)]
            };
            taps.iter().fold([usize::MAX, 0], both)
        });
        VoxelBox {
            first: ends.map(|[first, _]| first),
            size: ends.map(|[first, end]| end - first),
        }
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
