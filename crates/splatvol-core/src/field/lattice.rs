//! Samples as the lattice of a field: normalised, continued by the outermost sample beyond each face.

use fearless_simd::Level;
use splatvol_scene::VoxelBox;

use super::level::SourceLevel;
use crate::coefficients::sample_at;
use crate::visibility::level_of;

/// A sample type.
pub(super) trait StoredSample: Copy + PartialOrd + Send + Sync + Into<f64> {
    /// Distance from a stored value, times a factor: in f64, except in the small integer types, which f32 holds. Values of
    /// f64 need not be within its range, as their normalised ones are.
    fn scaled(self, low: f64, factor: f64) -> f32;
}

macro_rules! small {
    ($($t:ty),*) => {$(
        impl StoredSample for $t {
            #[inline(always)]
            fn scaled(self, low: f64, factor: f64) -> f32 {
                (f32::from(self) - low as f32) * factor as f32
            }
        }
    )*};
}

macro_rules! large {
    ($($t:ty),*) => {$(
        impl StoredSample for $t {
            #[inline(always)]
            fn scaled(self, low: f64, factor: f64) -> f32 {
                ((f64::from(self) - low) * factor) as f32
            }
        }
    )*};
}

small!(u8, i8, u16, i16);
large!(u32, i32, f32, f64);

/// Samples of a box of the grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a, T> {
    samples: &'a [T],
    of: VoxelBox,
}

impl<'a, T: Copy> Block<'a, T> {
    pub(super) fn new(samples: &'a [T], of: VoxelBox) -> Self {
        Self { samples, of }
    }

    /// Any sample.
    #[inline(always)]
    pub(super) fn any(&self) -> T {
        self.samples[0]
    }

    /// The available part of a row of samples.
    #[inline(always)]
    pub(super) fn row(&self, [y, z]: [usize; 2]) -> Row<'a, T> {
        Row {
            samples: self.of.row(self.samples, [y, z]),
            first: self.of.first[0],
        }
    }
}

/// A part of a row of samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<'a, T> {
    samples: &'a [T],
    /// Index of the first available sample.
    first: usize,
}

impl<'a, T: Copy> Row<'a, T> {
    /// A whole row.
    pub(super) fn whole(samples: &'a [T]) -> Self {
        Self { samples, first: 0 }
    }

    /// All available samples.
    #[inline(always)]
    pub(super) fn samples(&self) -> &'a [T] {
        self.samples
    }

    /// A sample.
    #[inline(always)]
    pub(super) fn at(&self, x: usize) -> T {
        self.samples[x - self.first]
    }

    /// N samples from `start` on, if there are as many. A start before the very first sample may have wrapped.
    #[inline(always)]
    pub(super) fn chunk<const N: usize>(&self, start: usize) -> Option<&'a [T; N]> {
        self.samples.get(start.wrapping_sub(self.first)..)?.first_chunk()
    }

    #[inline(always)]
    fn range(&self, from: usize, to: usize) -> &'a [T] {
        &self.samples[from - self.first..to - self.first]
    }
}

/// Points of a row that are read at once.
const PART: usize = 64;

/// Position of a volume's samples on the lattice, and their normalisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// Samples along x, y, z.
    pub own: [usize; 3],
    /// Lattice points along x, y, z.
    pub dims: [usize; 3],
    /// Lattice points before voxel 0.
    pub margin: [usize; 3],
    /// Stored value that is normalised to 0.
    low: f64,
    /// Normalised value per stored value.
    factor: f64,
    pub any_missing: bool,
    /// Instruction set for which loops over rows are compiled.
    pub simd: Level,
}

impl Lattice {
    pub(super) fn new(volume: &SourceLevel) -> Self {
        let own = volume.grid().dims();
        let margin = own.map(|n| usize::from(n > 1));
        let [low, high] = volume.value_range();
        let scale = if high > low {
            (1.0 / (high - low)).min(f64::MAX)
        } else {
            1.0
        };
        let rescale = volume.rescale();
        Self {
            own,
            dims: std::array::from_fn(|a| own[a] + 2 * margin[a]),
            margin,
            low: (low - rescale.intercept) / rescale.slope,
            factor: rescale.slope * scale,
            any_missing: volume.statistics().non_finite > 0,
            simd: Level::new(),
        }
    }

    /// The sample at a lattice point, along one axis.
    #[inline]
    fn sample(&self, axis: usize, point: usize) -> usize {
        sample_at(point, self.margin[axis], self.own[axis])
    }

    /// The samples that determine a range of lattice points (end excluded), and the neighbours of these samples.
    pub(super) fn region(&self, from: [usize; 3], to: [usize; 3]) -> VoxelBox {
        // Missing samples are the means of their neighbours.
        const AROUND: usize = 3;
        let first: [usize; 3] = std::array::from_fn(|a| {
            from[a]
                .saturating_sub(self.margin[a] + AROUND)
                .min(self.own[a] - 1)
        });
        let end = |a: usize| (to[a] + AROUND).clamp(first[a] + 1, self.own[a]);
        VoxelBox {
            first,
            size: std::array::from_fn(|a| end(a) - first[a]),
        }
    }

    /// The samples of a lattice row.
    #[inline(always)]
    pub(super) fn row<'a, T: Copy>(&self, data: &Block<'a, T>, [y, z]: [usize; 2]) -> Row<'a, T> {
        data.row([self.sample(1, y), self.sample(2, z)])
    }

    /// Lattice points `start ..` of a row of samples; beyond the lattice, its last point repeats.
    #[inline(always)]
    pub(super) fn points<T: Copy>(&self, row: Row<'_, T>, start: usize, out: &mut [T]) {
        let (margin, count) = (self.margin[0], self.own[0]);
        let end = start + out.len();
        if start >= margin && end <= margin + count {
            for (out, &sample) in out.iter_mut().zip(row.range(start - margin, end - margin)) {
                *out = sample;
            }
            return;
        }
        let (from, to) = (start.max(margin), end.min(margin + count));
        if from < to {
            out[from - start..to - start].copy_from_slice(row.range(from - margin, to - margin));
        }
        for x in (start..from.min(end)).chain(to.max(start)..end) {
            out[x - start] = row.at(self.sample(0, x.min(self.dims[0] - 1)));
        }
    }

    /// `(f - lo) / (hi - lo)`.
    #[inline(always)]
    pub(super) fn normalised<T: StoredSample>(&self, sample: T) -> f32 {
        sample.scaled(self.low, self.factor)
    }

    #[inline(always)]
    pub(super) fn level<T: StoredSample>(&self, sample: T) -> i16 {
        level_of(self.normalised(sample))
    }

    /// Normalised values of lattice points `start ..` of a row; each missing one is filled.
    #[inline(always)]
    pub(super) fn fill<T: StoredSample>(
        &self,
        data: &Block<'_, T>,
        (start, [y, z]): (usize, [usize; 2]),
        out: &mut [f32],
    ) {
        let row = self.row(data, [y, z]);
        let mut x = start;
        for out in out.chunks_mut(PART) {
            let mut samples = [data.any(); PART];
            let samples = &mut samples[..out.len()];
            self.points(row, x, samples);
            for (value, &sample) in out.iter_mut().zip(&*samples) {
                *value = self.normalised(sample);
            }
            if self.any_missing && !out.iter().fold(true, |all, value| all & value.is_finite()) {
                for (i, value) in out.iter_mut().enumerate() {
                    *value = self.filled(data, [x + i, y, z]);
                }
            }
            x += out.len();
        }
    }

    /// Normalised value of a point; a missing sample is the mean of its finite face neighbours, 0 without any.
    fn filled<T: StoredSample>(&self, data: &Block<'_, T>, [x, y, z]: [usize; 3]) -> f32 {
        let at = |[x, y, z]: [usize; 3]| self.normalised(self.row(data, [y, z]).at(self.sample(0, x)));
        let own = at([x, y, z]);
        if own.is_finite() {
            return own;
        }
        let (mut sum, mut found) = (0.0, 0);
        for axis in 0..3 {
            for forward in [false, true] {
                let mut point = [x, y, z];
                if forward && point[axis] + 1 < self.dims[axis] {
                    point[axis] += 1;
                } else if !forward && point[axis] > 0 {
                    point[axis] -= 1;
                } else {
                    continue;
                }
                let value = at(point);
                if value.is_finite() {
                    sum += value;
                    found += 1;
                }
            }
        }
        if found == 0 { 0.0 } else { sum / found as f32 }
    }
}
