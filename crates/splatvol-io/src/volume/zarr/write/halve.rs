//! Means of boxes of samples, as in `splatvol_core::mip`: along an axis of n samples the next level has `m = ceil(n / 2)`,
//! and each is the mean of the old cells within it, parts of cells by their length.
//!
//! Lengths are whole numbers of `1 / m`-ths of a cell, so that the means of integers are exact sums, rounded once, to the
//! nearest (halves to the even one, which keeps the mean of all). Levels made in memory have the same boxes, but weights
//! in 32-bit floats and samples in 16 bits of the range: pictures hang on their bits, so the two do not share code.
//!
//! Of labels, which have no mean, the one with the largest part of each box.

use splatvol_scene::{Samples, VoxelBox};

/// The old samples that a new one is the mean of, along one axis: at most three.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cover {
    first: usize,
    count: usize,
    weights: [u32; 3],
}

/// Covers along an axis, for new samples from `first` on, and the sum of each one's weights.
fn covers(old: usize, first: usize, count: usize) -> (Vec<Cover>, u32) {
    let new = old.div_ceil(2);
    // Ends of cells in parts that both kinds of cells are whole multiples of.
    let (of_new, of_old) = match old.is_multiple_of(2) {
        true => (2, 1),
        false => (old, new),
    };
    let cover = |i: usize| {
        let (from, to) = (i * of_new, (i + 1) * of_new);
        let first = from / of_old;
        let end = to.div_ceil(of_old);
        let part = |k: usize| {
            let cell = first + k;
            to.min((cell + 1) * of_old)
                .saturating_sub(from.max(cell * of_old)) as u32
        };
        Cover {
            first,
            count: end - first,
            weights: [part(0), part(1), part(2)],
        }
    };
    ((first..first + count).map(cover).collect(), of_new as u32)
}

impl Cover {
    fn taps(&self) -> impl Iterator<Item = (usize, u32)> {
        (self.first..).zip(self.weights).take(self.count)
    }
}

/// Work on one box of new samples.
struct Halving {
    /// Region of the old samples.
    of: VoxelBox,
    /// Covers along x, y, z, and the sums of their weights.
    covers: [Vec<Cover>; 3],
    totals: [u32; 3],
}

/// Means that make the region `to` of the next level, from the samples of a region of a level of `dims`. All samples that
/// the new ones cover must be in it.
pub(super) fn halve((samples, of): (&Samples, VoxelBox), dims: [usize; 3], to: VoxelBox, into: &mut Samples) {
    let halving = Halving::new(of, dims, to);
    into.refill(samples.element_type(), to.len(), 0.0);
    macro_rules! by_type {
        ($($variant:ident $method:ident;)*) => {
            match (samples, into) {
                $((Samples::$variant(old), Samples::$variant(new)) => halving.$method(old, new.to_mut()),)*
                // `into` has just been given the type of `samples`.
                _ => (),
            }
        };
    }
    by_type! {
        U8 integers;
        I8 integers;
        U16 integers;
        I16 integers;
        U32 integers;
        I32 integers;
        F32 floats;
        F64 floats;
    }
}

/// As [`halve`], with the sample that has the largest part of each box; of those with equal parts, the smallest. Missing samples
/// have no part.
pub(super) fn majorities(
    (samples, of): (&Samples, VoxelBox),
    dims: [usize; 3],
    to: VoxelBox,
    into: &mut Samples,
) {
    let halving = Halving::new(of, dims, to);
    into.refill(samples.element_type(), to.len(), f64::NAN);
    macro_rules! by_type {
        ($($variant:ident)*) => {
            match (samples, into) {
                $((Samples::$variant(old), Samples::$variant(new)) => halving.majorities(old, new.to_mut()),)*
                // `into` has just been given the type of `samples`.
                _ => (),
            }
        };
    }
    by_type!(U8 I8 U16 I16 U32 I32 F32 F64);
}

/// Whole numbers, sums of which are exact.
trait Sum: Copy + Default {
    fn of(value: i64) -> Self;
    fn add(&mut self, weight: Self, value: Self);
    /// The nearest whole number of `self / total`; halves go to the even one.
    fn mean(self, total: Self) -> i64;
}

macro_rules! sums {
    ($($type:ty)*) => {$(
        impl Sum for $type {
            #[inline(always)]
            fn of(value: i64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn add(&mut self, weight: Self, value: Self) {
                *self += weight * value;
            }

            #[inline(always)]
            fn mean(self, total: Self) -> i64 {
                let (floor, rest) = (self.div_euclid(total), self.rem_euclid(total));
                let up = rest > total - rest || (rest == total - rest && floor & 1 == 1);
                (floor + Self::from(up)) as i64
            }
        }
    )*};
}

sums!(i32 i64 i128);

/// Integers of up to 32 bits.
trait Integer: Copy + Into<i64> {
    fn narrow(value: i64) -> Self;
}

macro_rules! integers {
    ($($type:ty)*) => {$(
        impl Integer for $type {
            #[inline(always)]
            fn narrow(value: i64) -> Self {
                value as Self
            }
        }
    )*};
}

integers!(u8 i8 u16 i16 u32 i32);

/// Floats, means of which are made in 64 bits.
trait Float: Copy + Into<f64> {
    fn narrow(value: f64) -> Self;
}

impl Float for f32 {
    fn narrow(value: f64) -> Self {
        value as Self
    }
}

impl Float for f64 {
    fn narrow(value: f64) -> Self {
        value
    }
}

impl Halving {
    /// Work on the region `to` of the next level, from a region of a level of `dims`.
    fn new(of: VoxelBox, dims: [usize; 3], to: VoxelBox) -> Self {
        let axes = [0, 1, 2].map(|axis| covers(dims[axis], to.first[axis], to.size[axis]));
        Self {
            of,
            totals: [axes[0].1, axes[1].1, axes[2].1],
            covers: axes.map(|(covers, _)| covers),
        }
    }

    /// Calls `row` with every row of new samples and the old rows that it covers, with their weights.
    fn rows<'a, T>(
        &'a self,
        old: &'a [T],
        new: &'a mut [T],
        mut row: impl FnMut(&mut dyn Iterator<Item = (&'a [T], [u32; 2])>, &mut [T]),
    ) {
        let [x, y, _] = &self.covers;
        let places = self.covers[2].iter().flat_map(|z| y.iter().map(move |y| (z, y)));
        for (into, (z, y)) in new.chunks_exact_mut(x.len()).zip(places) {
            let taps = z
                .taps()
                .flat_map(|(z, of_z)| y.taps().map(move |(y, of_y)| ([y, z], [of_y, of_z])));
            let mut taps = taps.map(|(at, weights)| (self.of.row(old, at), weights));
            row(&mut taps, into);
        }
    }

    fn integers<T: Integer>(&self, old: &[T], new: &mut [T]) {
        let total: i128 = self.totals.iter().map(|&total| i128::from(total)).product();
        let most = total << (8 * size_of::<T>());
        if most <= i128::from(i32::MAX) {
            self.sums::<T, i32>(old, new);
        } else if most <= i128::from(i64::MAX) {
            self.sums::<T, i64>(old, new);
        } else {
            self.sums::<T, i128>(old, new);
        }
    }

    fn sums<T: Integer, S: Sum>(&self, old: &[T], new: &mut [T]) {
        let factor = |weight: u32| S::of(i64::from(weight));
        let total = self.totals.iter().fold(S::of(1), |product, &total| {
            let mut next = S::default();
            next.add(product, factor(total));
            next
        });
        let mut sums = vec![S::default(); self.of.size[0]];
        self.rows(old, new, |rows, into| {
            sums.fill(S::default());
            for (row, [y, z]) in rows {
                let mut weight = S::default();
                weight.add(factor(y), factor(z));
                for (sum, &value) in sums.iter_mut().zip(row) {
                    sum.add(weight, S::of(value.into()));
                }
            }
            for (to, cover) in into.iter_mut().zip(&self.covers[0]) {
                let mut sum = S::default();
                for (x, weight) in cover.taps() {
                    sum.add(factor(weight), sums[x - self.of.first[0]]);
                }
                *to = T::narrow(sum.mean(total));
            }
        });
    }

    fn majorities<T: Copy + PartialOrd>(&self, old: &[T], new: &mut [T]) {
        // At most three samples along each axis.
        let mut met: Vec<(T, u64)> = Vec::with_capacity(27);
        let mut around = Vec::with_capacity(9);
        self.rows(old, new, |rows, into| {
            around.clear();
            around.extend(rows.map(|(row, [y, z])| (row, u64::from(y) * u64::from(z))));
            for (to, cover) in into.iter_mut().zip(&self.covers[0]) {
                met.clear();
                for &(row, of_row) in &around {
                    for (x, weight) in cover.taps() {
                        let (label, part) = (row[x - self.of.first[0]], of_row * u64::from(weight));
                        match met.iter_mut().find(|(known, _)| *known == label) {
                            Some((_, sum)) => *sum += part,
                            None => met.push((label, part)),
                        }
                    }
                }
                // A missing sample is not equal to itself.
                let labels = met
                    .iter()
                    .copied()
                    .filter(|(label, _)| label.partial_cmp(label).is_some());
                let larger = |a: (T, u64), b: (T, u64)| match b.1 > a.1 || (b.1 == a.1 && b.0 < a.0) {
                    true => b,
                    false => a,
                };
                if let Some((label, _)) = labels.reduce(larger) {
                    *to = label;
                }
            }
        });
    }

    /// Missing samples have no share; a mean of nothing else is missing.
    fn floats<T: Float>(&self, old: &[T], new: &mut [T]) {
        let [of_x, of_y, of_z] = self.totals.map(f64::from);
        let mut sums = vec![[0.0; 2]; self.of.size[0]];
        self.rows(old, new, |rows, into| {
            sums.fill([0.0; 2]);
            for (row, [y, z]) in rows {
                let weight = f64::from(y) / of_y * (f64::from(z) / of_z);
                for (sum, &value) in sums.iter_mut().zip(row) {
                    let value: f64 = value.into();
                    if value.is_finite() {
                        *sum = [sum[0] + weight * value, sum[1] + weight];
                    }
                }
            }
            for (to, cover) in into.iter_mut().zip(&self.covers[0]) {
                let [mut value, mut share] = [0.0; 2];
                for (x, weight) in cover.taps() {
                    let [of_row, share_of_row] = sums[x - self.of.first[0]];
                    let weight = f64::from(weight) / of_x;
                    value += weight * of_row;
                    share += weight * share_of_row;
                }
                *to = T::narrow(if share > 0.0 { value / share } else { f64::NAN });
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(dims: [usize; 3]) -> VoxelBox {
        VoxelBox {
            first: [0; 3],
            size: dims,
        }
    }

    fn halved(samples: Samples, dims: [usize; 3]) -> Samples {
        let mut new = Samples::U8(Vec::new().into());
        halve(
            (&samples, whole(dims)),
            dims,
            whole(dims.map(|n| n.div_ceil(2))),
            &mut new,
        );
        new
    }

    #[test]
    fn labels_are_those_that_most_of_a_box_have() {
        let most = |samples: Samples, dims: [usize; 3]| {
            let mut new = Samples::U8(Vec::new().into());
            let to = whole(dims.map(|n| n.div_ceil(2)));
            majorities((&samples, whole(dims)), dims, to, &mut new);
            new
        };
        // Of equal parts the smallest; never a value between them.
        let labels = Samples::U16(vec![9, 9, 3, 9, 7, 2, 5, 5].into());
        assert_eq!(most(labels, [4, 2, 1]), Samples::U16(vec![9, 5].into()));
        let labels = Samples::I8(vec![4, -4].into());
        assert_eq!(most(labels, [2, 1, 1]), Samples::I8(vec![-4].into()));
        // Five cells on three: 3 2 | 1 3 1 | 2 3 fifths.
        let labels = Samples::U32(vec![1, 8, 2, 8, 6].into());
        assert_eq!(most(labels, [5, 1, 1]), Samples::U32(vec![1, 2, 6].into()));
        let Samples::F32(found) = most(
            Samples::F32(vec![f32::NAN, 3.0, f32::NAN, f32::NAN].into()),
            [4, 1, 1],
        ) else {
            panic!()
        };
        assert!(found[0] == 3.0 && found[1].is_nan(), "{found:?}");
    }

    #[test]
    fn means_are_exact_and_halves_go_to_even() {
        let samples = |values: &[u16]| Samples::U16(values.to_vec().into());
        assert_eq!(
            halved(samples(&[1, 2, 3, 4, 5, 7]), [6, 1, 1]),
            samples(&[2, 4, 6])
        );
        // Five cells on three: 3 2 | 1 3 1 | 2 3 fifths.
        assert_eq!(
            halved(samples(&[10, 0, 0, 0, 10]), [5, 1, 1]),
            samples(&[6, 0, 6])
        );
        assert_eq!(halved(samples(&[7]), [1, 1, 1]), samples(&[7]));
        let signed = Samples::I8(vec![-128, -127, -3, -2].into());
        assert_eq!(halved(signed, [4, 1, 1]), Samples::I8(vec![-128, -2].into()));
        let full = Samples::U32(vec![u32::MAX; 27].into());
        assert_eq!(halved(full, [3, 3, 3]), Samples::U32(vec![u32::MAX; 8].into()));
    }

    #[test]
    fn wide_sums_do_not_overflow() {
        let dims = [65_535, 3, 1];
        let full = Samples::I32(vec![i32::MIN; 3 * 65_535].into());
        assert_eq!(
            halved(full, dims),
            Samples::I32(vec![i32::MIN; 2 * 32_768].into())
        );
    }

    #[test]
    fn missing_samples_have_no_share() {
        let samples = Samples::F32(vec![4.0, f32::NAN, f32::INFINITY, f32::NAN, 1.0, 2.0].into());
        let Samples::F32(found) = halved(samples, [6, 1, 1]) else {
            panic!()
        };
        assert_eq!((found[0], found[2]), (4.0, 1.5));
        assert!(found[1].is_nan());
        let large = Samples::F64(vec![f64::MAX; 8].into());
        assert_eq!(halved(large, [2, 2, 2]), Samples::F64(vec![f64::MAX].into()));
    }

    #[test]
    fn parts_are_those_of_the_whole() {
        let dims = [21, 14, 9];
        let values: Vec<i16> = (0..dims.iter().product::<usize>())
            .map(|i| (i * 7919 % 4001) as i16 - 2000)
            .collect();
        let samples = Samples::I16(values.into());
        let new_dims = dims.map(|n: usize| n.div_ceil(2));
        let expected = halved(samples.clone(), dims);
        let to = VoxelBox {
            first: [4, 2, 1],
            size: [5, 3, 4],
        };
        let of = VoxelBox {
            first: [7, 3, 1],
            size: [12, 8, 8],
        };
        let (mut part, mut new) = (samples.element_type().filled(of.len(), 0.0), samples.clone());
        assert!(splatvol_scene::chunks::copy_box(
            &samples,
            whole(dims),
            &mut part,
            of
        ));
        halve((&part, of), dims, to, &mut new);
        let mut cut = samples.element_type().filled(to.len(), 0.0);
        splatvol_scene::chunks::copy_box(&expected, whole(new_dims), &mut cut, to);
        assert_eq!(new, cut);
    }
}
