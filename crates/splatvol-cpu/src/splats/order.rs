//! Order: sorts 64-bit keys, depth above index, by depth; equal depths stay in the order of their indices.
//!
//! A least-significant-digit radix sort (Knuth, The Art of Computer Programming 3, 5.2.5) of the bits in which
//! depths differ. Parts count their digits and scatter their keys in parallel. The place of a key depends on the
//! keys alone, not on the number of parts. Keys are atomics, since parts write anywhere; relaxed stores cost
//! nothing.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::room::grow;

/// Most bits that keys are sorted by at once.
const DIGIT_BITS: u32 = 12;
/// Fewest keys per part.
const PART: usize = 1 << 13;

/// Keys, and as many again to sort them.
#[derive(Debug, Default)]
pub(crate) struct Keys {
    pub keys: Vec<AtomicU64>,
    other: Vec<AtomicU64>,
}

/// The index in a key.
pub(crate) fn index(key: &AtomicU64) -> usize {
    (key.load(Ordering::Relaxed) & u64::from(u32::MAX)) as usize
}

impl Keys {
    /// Room for `count` keys; `None` once `stop` is set.
    pub(crate) fn resize(&mut self, count: usize, stop: &AtomicBool) -> Option<()> {
        grow(&mut self.keys, count, stop)?;
        grow(&mut self.other, count, stop)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        (self.keys.capacity() + self.other.capacity()) * size_of::<AtomicU64>()
    }

    /// Sorts the keys that lie in `ranges` (ascending, apart); returns them without gaps, or `None` once `stop` is set.
    pub(crate) fn sort(
        &mut self,
        ranges: &[Range<usize>],
        parts: usize,
        stop: &AtomicBool,
    ) -> Option<&[AtomicU64]> {
        let count = ranges.iter().map(Range::len).sum::<usize>();
        let (least, differing) = depth_bits(&self.keys, ranges);
        let bits = 32 - differing.leading_zeros();
        // One pass at least, which closes the gaps.
        let passes = bits.div_ceil(DIGIT_BITS).max(1);
        let digit_bits = bits.div_ceil(passes);
        let whole = even(0..count, parts);
        for pass in 0..passes {
            let digits = Digits {
                least,
                shift: 32 + pass * digit_bits,
                count: 1 << digit_bits,
            };
            if pass == 0 {
                let groups: Vec<&[Range<usize>]> =
                    ranges.chunks(ranges.len().div_ceil(parts).max(1)).collect();
                digits.sort(&self.keys, &self.other, &groups, stop)?;
            } else {
                let groups: Vec<&[Range<usize>]> = whole.chunks(1).collect();
                digits.sort(&self.keys, &self.other, &groups, stop)?;
            }
            std::mem::swap(&mut self.keys, &mut self.other);
        }
        Some(&self.keys[..count])
    }
}

/// A range, split into up to `parts` ranges of similar length.
pub(crate) fn even(range: Range<usize>, parts: usize) -> Vec<Range<usize>> {
    let step = range.len().div_ceil(parts.max(1)).max(PART);
    let starts = range.clone().step_by(step);
    starts.map(|start| start..(start + step).min(range.end)).collect()
}

/// Smallest depth, and the bits of the largest difference to it.
fn depth_bits(keys: &[AtomicU64], ranges: &[Range<usize>]) -> (u32, u32) {
    let bounds = ranges.par_iter().map(|range| {
        keys[range.clone()]
            .iter()
            .fold((u32::MAX, 0), |(least, most), key| {
                let depth = (key.load(Ordering::Relaxed) >> 32) as u32;
                (depth.min(least), depth.max(most))
            })
    });
    let (least, most) = bounds.reduce(|| (u32::MAX, 0), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    (least, most.saturating_sub(least))
}

/// One digit of the differences to the smallest depth.
struct Digits {
    least: u32,
    shift: u32,
    count: usize,
}

impl Digits {
    #[inline(always)]
    fn of(&self, key: u64) -> usize {
        ((key - (u64::from(self.least) << 32)) >> self.shift) as usize & (self.count - 1)
    }

    /// Sorts by the digit, stably, from `source` to `target`; `None` once `stop` is set.
    fn sort(
        &self,
        source: &[AtomicU64],
        target: &[AtomicU64],
        groups: &[&[Range<usize>]],
        stop: &AtomicBool,
    ) -> Option<()> {
        let go_on = || (!stop.load(Ordering::Relaxed)).then_some(());
        let count = |group: &&[Range<usize>]| {
            go_on()?;
            let mut counts = vec![0u32; self.count];
            for key in group.iter().flat_map(|range| &source[range.clone()]) {
                counts[self.of(key.load(Ordering::Relaxed))] += 1;
            }
            Some(counts)
        };
        let mut places: Vec<Vec<u32>> = groups
            .par_iter()
            .with_max_len(1)
            .map(count)
            .collect::<Option<_>>()?;
        starts(&mut places, 0..self.count);
        groups
            .par_iter()
            .zip(&mut places)
            .with_max_len(1)
            .map(|(group, places)| {
                go_on()?;
                for key in group.iter().flat_map(|range| &source[range.clone()]) {
                    let key = key.load(Ordering::Relaxed);
                    let place = &mut places[self.of(key)];
                    target[*place as usize].store(key, Ordering::Relaxed);
                    *place += 1;
                }
                Some(())
            })
            .collect()
    }
}

/// Turns counts per part and bucket into where each begins: buckets in order, parts in order within a bucket.
/// Returns the sum.
pub(crate) fn starts(counts: &mut [Vec<u32>], buckets: Range<usize>) -> usize {
    let mut sum = 0u32;
    for bucket in buckets {
        for part in &mut *counts {
            let count = part[bucket];
            part[bucket] = sum;
            sum += count;
        }
    }
    sum as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_sorted_by_depth_and_stay_in_order_within_one() {
        let mut state = 7u64;
        for (count, spread) in [(1, 1), (100, 3), (50_000, 900), (70_000, u32::MAX - 5)] {
            let mut keys = Keys::default();
            keys.resize(count, &AtomicBool::new(false)).unwrap();
            for (index, key) in keys.keys.iter_mut().enumerate() {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let depth = 5 + ((state >> 32) % u64::from(spread));
                *key.get_mut() = depth << 32 | index as u64;
            }
            // Every seventh key is left out.
            let ranges: Vec<_> = (0..count).step_by(7).map(|i| i..(i + 6).min(count)).collect();
            let mut expected: Vec<u64> = ranges
                .iter()
                .flat_map(|range| {
                    keys.keys[range.clone()]
                        .iter()
                        .map(|key| key.load(Ordering::Relaxed))
                })
                .collect();
            expected.sort_unstable();
            let found: Vec<u64> = keys
                .sort(&ranges, 3, &AtomicBool::new(false))
                .expect("nobody stops it")
                .iter()
                .map(|key| key.load(Ordering::Relaxed))
                .collect();
            assert!(found == expected, "{count} {spread}");
        }
    }
}
