//! Visibility: the voxels that a reconstruction needs, within the kernel's reach of a visible cell.
//!
//! A *cell* is the cube between eight neighbouring samples. It can be visible if extinction is non-zero somewhere
//! in the range of its corners, widened by the overshoot of an interpolating kernel. Voxels beyond the kernel's
//! reach of every such cell change no pixel. With the field written as `b + sum_k (c_k - b) h(x - k)`, b an
//! invisible value, voxels of value b contribute nothing wherever they are. So in the outer half of the reach,
//! where kernel weights are below a tenth, only voxels that differ from b are needed, and surfaces in air need two
//! layers of voxels less.

use splatvol_scene::Rescale;

use crate::brick::BRICK;
use crate::classification::ClassificationTable;

/// Voxels of a brick.
pub const BRICK_VOXELS: usize = BRICK * BRICK * BRICK;

/// Differences from the background (normalised values) that the outer half of a kernel may leave out.
pub(crate) const TOLERANCE: f32 = 0.006;

/// Number of levels of values; visibility does not distinguish values within a level.
pub(crate) const LEVELS: usize = 2048;
const FIRST: f32 = -0.5;
const PER_VALUE: f32 = LEVELS as f32 / 2.0;

/// Subtracted before rounding to the nearest whole number, to round down: not a half, which would round a whole level
/// to either side.
const NEARLY_HALF: f32 = 0.49;

/// The level of a normalised value, up to a hundredth of a level; a missing value's is 0.
#[inline(always)]
pub(crate) fn level_of(value: f32) -> i16 {
    // A float of 2^23 holds no fraction, and the low bits of its pattern are an integer: a conversion that, unlike
    // `as`, is one addition in vectors.
    const WHOLE: f32 = (1 << 23) as f32;
    // Nothing below that is subtracted: under 2^23, bits are those of halves, and 0 would become -1.
    let level = ((value - FIRST) * PER_VALUE)
        .max(NEARLY_HALF)
        .min((LEVELS - 1) as f32);
    (level - NEARLY_HALF + WHOLE).to_bits() as i16
}

/// Number of visible levels below each level: a single difference tells whether a range of values contains a
/// visible one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VisibleLevels {
    below: Vec<u16>,
}

impl VisibleLevels {
    /// Levels of a transfer function.
    pub fn new(table: &ClassificationTable) -> Self {
        let edge = |i: usize| FIRST + i as f32 / PER_VALUE;
        let mut below = vec![0u16; LEVELS + 1];
        for i in 0..LEVELS {
            below[i + 1] = below[i] + u16::from(table.is_visible(edge(i), edge(i + 1)));
        }
        Self { below }
    }

    /// Whether any value from `low` to `high` is visible.
    #[inline(always)]
    pub fn any(&self, low: f32, high: f32) -> bool {
        let level = |v: f32| (((v - FIRST) * PER_VALUE) as i32).clamp(0, LEVELS as i32 - 1) as usize;
        self.below[level(high) + 1] > self.below[level(low)]
    }

    /// The smallest and largest visible value, widened to levels; `None` where nothing is visible.
    pub fn hull(&self) -> Option<[f32; 2]> {
        let total = self.below[LEVELS];
        if total == 0 {
            return None;
        }
        let first = self.below.partition_point(|&n| n == 0) - 1;
        let last = self.below.partition_point(|&n| n < total);
        let low = if first == 0 {
            f32::NEG_INFINITY
        } else {
            FIRST + first as f32 / PER_VALUE
        };
        let high = if last == LEVELS {
            f32::INFINITY
        } else {
            FIRST + last as f32 / PER_VALUE
        };
        Some([low, high])
    }

    /// These levels and all above the lowest of them, which matter to the largest value along a ray.
    pub fn and_larger(&self) -> Self {
        let mut below = vec![0u16; LEVELS + 1];
        for i in 0..LEVELS {
            below[i + 1] = below[i] + u16::from(self.below[i + 1] > 0);
        }
        Self { below }
    }

    /// These levels and all below the highest of them, which matter to the smallest value along a ray.
    pub fn and_smaller(&self) -> Self {
        let total = self.below[LEVELS];
        let mut below = vec![0u16; LEVELS + 1];
        for i in 0..LEVELS {
            below[i + 1] = below[i] + u16::from(self.below[i] < total);
        }
        Self { below }
    }

    /// All levels, which matter to the mean value along a ray.
    pub fn all() -> Self {
        Self {
            below: (0..=LEVELS as u16).collect(),
        }
    }

    fn is_visible(&self, value: f32) -> bool {
        self.any(value, value)
    }

    /// Whether any level from `low` to `high` is visible.
    #[inline(always)]
    pub(crate) fn any_of(&self, [low, high]: [i16; 2]) -> bool {
        self.below[high as usize + 1] > self.below[low as usize]
    }

    /// Whether all levels from `low` to `high` are visible.
    #[inline(always)]
    pub(crate) fn all_of(&self, [low, high]: [i16; 2]) -> bool {
        usize::from(self.below[high as usize + 1] - self.below[low as usize]) == (high - low + 1) as usize
    }

    /// Levels that are visible in one and not in the other.
    pub(crate) fn difference(&self, other: &Self) -> Self {
        let mut below = vec![0u16; LEVELS + 1];
        for i in 0..LEVELS {
            let differs = self.below[i + 1] - self.below[i] != other.below[i + 1] - other.below[i];
            below[i + 1] = below[i] + u16::from(differs);
        }
        Self { below }
    }

    /// Levels that a reconstruction over the background must keep: all but those reachable from the background
    /// without passing a visible one. No value beyond a visible band may be left out, since the sum would fall
    /// through the band.
    pub(crate) fn beyond(&self, background: f32) -> Self {
        let start = level_of(background);
        let mut held = vec![true; LEVELS];
        if !self.any_of([start; 2]) {
            let free = |level: &i16| !self.any_of([*level; 2]);
            for level in (start..LEVELS as i16)
                .take_while(free)
                .chain((0..start).rev().take_while(free))
            {
                held[level as usize] = false;
            }
        }
        let mut below = vec![0u16; LEVELS + 1];
        for (level, held) in held.into_iter().enumerate() {
            below[level + 1] = below[level] + u16::from(held);
        }
        Self { below }
    }

    /// Runs of visible levels, ascending: first and last of each.
    pub(crate) fn intervals(&self) -> Vec<[i16; 2]> {
        let mut intervals: Vec<[i16; 2]> = Vec::new();
        for level in (0..LEVELS as i16).filter(|&level| self.any_of([level; 2])) {
            match intervals.last_mut() {
                Some(last) if last[1] + 1 == level => last[1] = level,
                _ => intervals.push([level; 2]),
            }
        }
        intervals
    }
}

/// Histogram of the values of a volume.
#[derive(Debug, Clone)]
pub struct Histogram {
    counts: Vec<u32>,
    low: f64,
    scale: f64,
    rescale: Rescale,
}

impl Histogram {
    const BINS: usize = 256;

    /// An empty histogram for samples in a range of real values.
    pub fn new([low, high]: [f64; 2], rescale: Rescale) -> Self {
        Self {
            counts: vec![0; Self::BINS],
            low,
            scale: if high > low { 1.0 / (high - low) } else { 1.0 },
            rescale,
        }
    }

    /// Samples from one that is counted to the next, given their number.
    pub fn step(samples: usize) -> usize {
        splatvol_scene::chunks::spread_step(samples)
    }

    /// Adds a stored sample, unless it is missing.
    pub fn add(&mut self, stored: f64) {
        let value = (self.rescale.apply(stored) - self.low) * self.scale;
        if value.is_finite() {
            let bin = (value * (Self::BINS - 1) as f64).round() as usize;
            self.counts[bin.min(Self::BINS - 1)] += 1;
        }
    }

    /// The most common invisible value, normalised; where all values are visible, 0.
    pub fn background(&self, levels: &VisibleLevels) -> f32 {
        let value = |bin: usize| bin as f32 / (Self::BINS - 1) as f32;
        let most = (0..Self::BINS)
            .filter(|&bin| self.counts[bin] > 0 && !levels.is_visible(value(bin)))
            .max_by_key(|&bin| (self.counts[bin], Self::BINS - bin));
        most.map_or(0.0, value)
    }
}

#[cfg(test)]
mod tests {
    use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

    use super::*;

    #[test]
    fn every_value_has_a_level_and_larger_ones_no_lower() {
        let ends = [f32::NAN, f32::NEG_INFINITY, -1e30, -0.5, -0.499_9, -0.499_7];
        assert_eq!(ends.map(level_of), [0; 6]);
        let mut last = 0;
        for i in -40_000..40_000 {
            let level = level_of(i as f32 / 20_000.0);
            assert!(
                (last..LEVELS as i16).contains(&level),
                "{i}: {level} after {last}"
            );
            last = level;
        }
        assert_eq!(level_of(f32::INFINITY), LEVELS as i16 - 1);
    }

    #[test]
    fn levels_are_widened_to_what_a_ray_must_know() {
        // Visible between 0.4 and 0.6 of the range.
        let opacities = [(0.4, 0.0), (0.45, 0.5), (0.55, 0.5), (0.6, 0.0)];
        let look = TransferFunction::new(
            vec![ColorPoint::new(0.0, [1.0; 3])],
            opacities
                .map(|(value, opacity)| OpacityPoint::new(value, opacity))
                .to_vec(),
            None,
        );
        let table = ClassificationTable::new(&look.expect("ascending"), [0.0, 1.0], 1.0);
        let band = VisibleLevels::new(&table);
        for (levels, seen) in [
            (&band, [false, true, false]),
            (&band.and_larger(), [false, true, true]),
            (&band.and_smaller(), [true, true, false]),
            (&VisibleLevels::all(), [true, true, true]),
        ] {
            let found = [0.1, 0.5, 0.9].map(|value| levels.any(value, value));
            assert_eq!(found, seen);
        }
        let nothing = band.difference(&band);
        assert!(!nothing.and_smaller().any(-1.0, 2.0) && !nothing.and_larger().any(-1.0, 2.0));
    }
}
