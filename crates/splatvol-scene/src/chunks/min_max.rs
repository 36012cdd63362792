//! Min-max index: the smallest and the largest sample of every block of a level, from which follows what cannot be
//! visible, without reading it (the min-max blocks of Wilhelms and Van Gelder 1992, in one layer).

use crate::VoxelBox;
use crate::volume::widen;

/// Blocks that an index holds at most, so that it takes 8 MiB; larger levels have larger blocks.
const MOST_BLOCKS: usize = 1 << 20;
/// Ends of a block of which nothing is known yet, and of one of which nothing can be said.
const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];
const ANYTHING: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];

/// Smallest and largest stored samples of the blocks of a level. Missing samples (NaN) make a block's ends unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct MinMaxIndex {
    /// Samples of a block along x, y, z.
    block: [usize; 3],
    /// Blocks along x, y, z.
    counts: [usize; 3],
    /// Samples around a block, in each direction, that its ends are about as well.
    border: usize,
    /// Blocks that were joined to one, along each axis, as a power of two.
    octaves: u32,
    /// Ends rounded outwards, x fastest.
    ends: Vec<[f32; 2]>,
    /// Exact ends of all; NaN where any is unknown.
    whole: [f64; 2],
}

impl MinMaxIndex {
    /// An index that knows nothing yet, of a level with `dims` samples in blocks of `block`, whose ends are also about
    /// `border` samples in each direction. If there were too many, 2, 4, 8... blocks along each axis are one.
    pub fn new(dims: [usize; 3], block: [usize; 3], border: usize) -> Self {
        let fine: [usize; 3] = std::array::from_fn(|axis| dims[axis].div_ceil(block[axis]));
        let counts = |octaves: u32| fine.map(|count| count.div_ceil(1 << octaves));
        let few = |octaves: &u32| counts(*octaves).iter().product::<usize>() <= MOST_BLOCKS;
        let octaves = (0..usize::BITS).find(few).unwrap_or(0);
        Self {
            // Files may say anything of their blocks.
            block: block.map(|edge| edge.saturating_mul(1 << octaves)),
            counts: counts(octaves),
            border,
            octaves,
            ends: vec![NOTHING; counts(octaves).iter().product()],
            whole: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// Says what the smallest and the largest sample of a part of a block are; NaN if one is missing.
    pub fn join(&mut self, block: [usize; 3], [low, high]: [f64; 2]) {
        let [x, y, z] = block.map(|at| at >> self.octaves);
        let known = &mut self.ends[(z * self.counts[1] + y) * self.counts[0] + x];
        if low <= high {
            *known = [
                known[0].min(rounded_down(low)),
                known[1].max(-rounded_down(-high)),
            ];
            // NaN stays.
            let [least, most] = self.whole;
            self.whole = [
                if low < least { low } else { least },
                if high > most { high } else { most },
            ];
        } else {
            *known = ANYTHING;
            self.whole = [f64::NAN; 2];
        }
    }

    /// Smallest and largest sample of all, exact.
    pub fn whole(&self) -> Option<[f64; 2]> {
        let [low, high] = self.whole;
        (low <= high).then_some(self.whole)
    }

    /// Smallest and largest sample of a region, or less and more.
    #[inline]
    pub fn within(&self, region: VoxelBox) -> Option<[f32; 2]> {
        let range: [[usize; 2]; 3] = std::array::from_fn(|axis| {
            let (first, end) = (region.first[axis], region.first[axis] + region.size[axis]);
            let last = self.counts[axis] - 1;
            let from = ((first + self.border) / self.block[axis]).min(last);
            let to = (end.saturating_sub(1 + self.border) / self.block[axis]).min(last);
            [from, to.max(from)]
        });
        let [x, y, z] = range;
        let mut all = NOTHING;
        for z in z[0]..=z[1] {
            for y in y[0]..=y[1] {
                let row = &self.ends[(z * self.counts[1] + y) * self.counts[0]..];
                for [low, high] in &row[x[0]..=x[1]] {
                    all = [all[0].min(*low), all[1].max(*high)];
                }
            }
        }
        (all[0].is_finite() && all[0] <= all[1]).then_some(all)
    }
}

/// The largest number of 32 bits that is not above this one.
fn rounded_down(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) > value {
        near.next_down()
    } else {
        near
    }
}

/// Tells the smallest and the largest sample of every block that meets the box `own`, x fastest: of the samples of
/// `data` within the block and so many around it. NaN if any of those is no finite number. `of` is the box of `data`.
pub fn block_ends<T: Copy + PartialOrd + Into<f64>>(
    (data, of): (&[T], VoxelBox),
    own: VoxelBox,
    (block, border): ([usize; 3], usize),
    mut tell: impl FnMut([usize; 3], [f64; 2]),
) {
    if own.is_empty() {
        return;
    }
    let blocks: [std::ops::Range<usize>; 3] = std::array::from_fn(|axis| {
        let end = own.first[axis] + own.size[axis];
        own.first[axis] / block[axis]..end.div_ceil(block[axis])
    });
    // Samples of a block along an axis, counted from the first of `of`.
    let samples = |at: usize, axis: usize| {
        let (first, end) = (of.first[axis], of.first[axis] + of.size[axis]);
        let from = (at * block[axis]).saturating_sub(border).max(first);
        let to = ((at + 1) * block[axis] + border).min(end);
        from - first..to - first
    };
    let [nx, ny, _] = of.size;
    let mut least = vec![data[0]; nx];
    let mut most = vec![data[0]; nx];
    let mut finite = vec![true; nx];
    for z in blocks[2].clone() {
        for y in blocks[1].clone() {
            finite.fill(true);
            for (row, at) in samples(z, 2)
                .flat_map(|z| samples(y, 1).map(move |y| (z * ny + y) * nx))
                .enumerate()
            {
                let values = &data[at..at + nx];
                if row == 0 {
                    least.copy_from_slice(values);
                    most.copy_from_slice(values);
                }
                let ends = least.iter_mut().zip(&mut most).zip(&mut finite);
                for (((least, most), finite), &value) in ends.zip(values) {
                    *least = if value < *least { value } else { *least };
                    *most = if value > *most { value } else { *most };
                    *finite &= widen(value).is_finite();
                }
            }
            for x in blocks[0].clone() {
                let columns = samples(x, 0);
                let ends = match finite[columns.clone()].contains(&false) {
                    true => [f64::NAN; 2],
                    false => [
                        smallest(&least[columns.clone()], |value, least| value < least),
                        smallest(&most[columns], |value, most| value > most),
                    ],
                };
                tell([x, y, z], ends);
            }
        }
    }
}

/// The first of the values in an order.
fn smallest<T: Copy + Into<f64>>(values: &[T], before: impl Fn(T, T) -> bool) -> f64 {
    let first = values
        .iter()
        .copied()
        .reduce(|a, b| if before(b, a) { b } else { a });
    first.map_or(f64::NAN, widen)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMS: [usize; 3] = [37, 21, 18];

    fn whole() -> VoxelBox {
        VoxelBox {
            first: [0; 3],
            size: DIMS,
        }
    }

    /// Values without a pattern, the same on every run.
    fn data() -> Vec<f64> {
        let mut state = 7u64;
        let next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / 1e3
        };
        (0..DIMS.iter().product::<usize>()).map(next).collect()
    }

    fn index(data: &[f64], border: usize) -> MinMaxIndex {
        let block = [8, 5, 16];
        let mut index = MinMaxIndex::new(DIMS, block, border);
        block_ends((data, whole()), whole(), (block, border), |at, ends| {
            index.join(at, ends);
        });
        index
    }

    fn ends(data: &[f64], region: VoxelBox) -> [f64; 2] {
        let [x, y, z] = region.size;
        let mut all = [f64::INFINITY, f64::NEG_INFINITY];
        for at in 0..x * y * z {
            let at = [at % x, at / x % y, at / (x * y)];
            let [x, y, z]: [usize; 3] = std::array::from_fn(|axis| region.first[axis] + at[axis]);
            let value = data[(z * DIMS[1] + y) * DIMS[0] + x];
            all = [all[0].min(value), all[1].max(value)];
        }
        all
    }

    #[test]
    fn every_sample_of_a_region_lies_between_its_ends() {
        let data = data();
        for border in [0, 1] {
            let index = index(&data, border);
            assert_eq!(index.whole(), Some(ends(&data, whole())));
            let mut narrower = 0;
            for i in 0..2000usize {
                let first: [usize; 3] =
                    std::array::from_fn(|axis| (i * [7, 5, 3][axis] + i / 11) % DIMS[axis]);
                let size = std::array::from_fn(|axis| {
                    1 + (i * [1, 3, 2][axis] + i / 7) % (DIMS[axis] - first[axis])
                });
                let region = VoxelBox { first, size };
                let [low, high] = index.within(region).unwrap().map(f64::from);
                let exact = ends(&data, region);
                assert!(low <= exact[0] && exact[1] <= high, "{region:?}");
                let known = index.whole().unwrap();
                narrower += usize::from(low > known[0] && high < known[1]);
            }
            assert!(narrower > 500, "{narrower}");
        }
    }

    #[test]
    fn blocks_of_parts_are_those_of_the_whole() {
        let data = data();
        let block = [8, 5, 16];
        let mut parts = MinMaxIndex::new(DIMS, block, 0);
        for (first, size) in [
            ([0; 3], [20, 21, 18]),
            ([20, 0, 0], [17, 7, 18]),
            ([20, 7, 0], [17, 14, 18]),
        ] {
            let own = VoxelBox { first, size };
            let part: Vec<f64> = (0..own.len())
                .map(|at| {
                    let at = [at % size[0], at / size[0] % size[1], at / (size[0] * size[1])];
                    let [x, y, z]: [usize; 3] = std::array::from_fn(|axis| first[axis] + at[axis]);
                    data[(z * DIMS[1] + y) * DIMS[0] + x]
                })
                .collect();
            block_ends((&part, own), own, (block, 0), |at, ends| parts.join(at, ends));
        }
        assert_eq!(parts, index(&data, 0));
    }

    #[test]
    fn nothing_is_said_of_blocks_with_missing_samples() {
        let mut data = data();
        data[DIMS[0] * DIMS[1] * 17 + 3] = f64::NAN;
        let index = index(&data, 1);
        assert_eq!(index.whole(), None);
        let at = |first| index.within(VoxelBox { first, size: [1; 3] });
        assert_eq!(at([3, 0, 17]), None);
        assert!(at([30, 15, 3]).is_some());
    }

    #[test]
    fn large_levels_have_larger_blocks() {
        let mut index = MinMaxIndex::new([40_000, 3, 900], [4, 3, 1], 1);
        assert!(index.ends.len() <= MOST_BLOCKS);
        for x in 0..10_000 {
            for z in 0..900 {
                index.join([x, 0, z], [x as f64, z as f64 + 1e6]);
            }
        }
        assert_eq!(index.whole(), Some([0.0, 1e6 + 899.0]));
        let region = VoxelBox {
            first: [20_000, 1, 450],
            size: [16, 1, 2],
        };
        let [low, high] = index.within(region).unwrap();
        assert!(low <= 5000.0 && low > 4960.0 && (1e6 + 451.0..1e6 + 480.0).contains(&high));
    }

    #[test]
    fn blocks_longer_than_any_level_are_one() {
        let mut index = MinMaxIndex::new([3, 4000, 4000], [1 << (usize::BITS - 1), 1, 1], 1);
        index.join([0, 3999, 3999], [1.0, 2.0]);
        let last = VoxelBox {
            first: [2, 3999, 3999],
            size: [1; 3],
        };
        assert_eq!(index.within(last), Some([1.0, 2.0]));
    }

    #[test]
    fn ends_are_rounded_outwards() {
        for value in [0.1, -0.1, 16_777_217.0, -16_777_217.0, 1e300, -1e300, 3.0] {
            assert!(f64::from(rounded_down(value)) <= value);
            assert!(f64::from(-rounded_down(-value)) >= value);
        }
        assert_eq!(rounded_down(3.0), 3.0);
    }
}
