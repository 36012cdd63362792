//! Rows: sums of the old rows of a row of new samples. Each old row is converted once for all new slices of a region.

use splatvol_scene::volume::widen;
use splatvol_scene::{Block, VoxelBox, with_samples};

use super::{NewSample, Resampling};

/// Old rows of new samples that have one y.
#[derive(Debug)]
pub(super) struct Rows {
    /// Of what new samples of a region are made.
    old: VoxelBox,
    /// Real values less the smallest, x fastest, then y, of the rows from `first` on, then z.
    converted: Vec<f32>,
    /// First old row, and their number.
    first: usize,
    count: usize,
    /// Sums along y and z: of values and, where samples may be missing, of weights.
    values: Vec<f32>,
    weights: Vec<f32>,
}

impl Rows {
    pub(super) fn new(old: VoxelBox) -> Self {
        Self {
            old,
            converted: Vec::new(),
            first: 0,
            count: 0,
            values: vec![0.0; old.size[0]],
            weights: vec![0.0; old.size[0]],
        }
    }

    /// Converts the old rows of new ones at a place along y.
    pub(super) fn convert(&mut self, resampling: &Resampling, block: &Block<'_>, y: usize) {
        let rescale = resampling.source.rescale();
        let (slope, offset) = (rescale.slope, rescale.intercept - resampling.range[0]);
        let [first, end] = resampling.taps[1][y].range();
        (self.first, self.count) = (first, end - first);
        let [nx, _, nz] = self.old.size;
        let left = self.old.first[0] - block.of.first[0];
        self.converted.clear();
        self.converted.reserve(nx * self.count * nz);
        with_samples!(block.samples, data => {
            for z in self.old.first[2]..self.old.first[2] + nz {
                for y in first..end {
                    let row = &block.of.row(data, [y, z])[left..left + nx];
                    let real = row.iter().map(|&sample| (widen(sample) * slope + offset) as f32);
                    self.converted.extend(real);
                }
            }
        });
    }

    /// Sums over the rows that a row of new samples covers.
    pub(super) fn add_up(&mut self, resampling: &Resampling, [y, z]: [usize; 2]) {
        let missing = has_missing(resampling);
        self.values.fill(0.0);
        self.weights.fill(0.0);
        let nx = self.old.size[0];
        for (z, of_z) in resampling.taps[2][z].iter() {
            for (y, of_y) in resampling.taps[1][y].iter() {
                let weight = of_z * of_y;
                let number = (z - self.old.first[2]) * self.count + y - self.first;
                let row = &self.converted[number * nx..][..nx];
                if missing {
                    let sums = self.values.iter_mut().zip(&mut self.weights);
                    for ((value, sum), &real) in sums.zip(row) {
                        if real.is_finite() {
                            *value += weight * real;
                            *sum += weight;
                        }
                    }
                } else {
                    for (value, &real) in self.values.iter_mut().zip(row) {
                        *value += weight * real;
                    }
                }
            }
        }
        if !missing {
            self.weights.fill(1.0);
        }
    }

    /// New samples along x, from one on.
    pub(super) fn reduce<T: NewSample>(&self, resampling: &Resampling, row: &mut [T], from: usize) {
        let all = &resampling.taps[0][from..from + row.len()];
        if !has_missing(resampling) && all.iter().all(|taps| taps.weights == [1.0]) {
            for (out, taps) in row.iter_mut().zip(all) {
                *out = T::of(self.values[taps.first - self.old.first[0]], resampling);
            }
            return;
        }
        for (out, taps) in row.iter_mut().zip(all) {
            let (mut value, mut weight) = (0.0, 0.0);
            for (x, of_x) in taps.iter() {
                value += of_x * self.values[x - self.old.first[0]];
                weight += of_x * self.weights[x - self.old.first[0]];
            }
            *out = T::of(if weight > 0.0 { value / weight } else { f32::NAN }, resampling);
        }
    }
}

fn has_missing(resampling: &Resampling) -> bool {
    resampling.source.statistics().non_finite > 0
}
