//! The nearest neighbours found so far for sixteen places, each list sorted.
//!
//! A neighbour is a key: its squared distance in the upper bits, which order as the numbers do, and its index in
//! the lower bits. Keys are held as the f64 numbers with these bits. None of these is negative or NaN, so they have
//! the order of the keys, and vector minimum and maximum apply. A new key `v` is inserted into a sorted list `r` by
//! `r_i = min(r_i, max(r_(i - 1), v))`, without branches or sorting.

use fearless_simd::{f32x16, f64x8, prelude::*, u32x16};

use super::tree::LANES;

/// Up to `K` neighbours of each of sixteen places, nearest first.
pub(super) struct Found<S: Simd, const K: usize> {
    /// Number of neighbours to find.
    k: usize,
    keys: [[f64x8<S>; 2]; K],
    /// Squared distances of the last neighbour; infinite while there are fewer than `k`.
    pub(super) farthest: f32x16<S>,
}

impl<S: Simd, const K: usize> Found<S, K> {
    #[inline(always)]
    pub(super) fn new(simd: S, k: usize) -> Self {
        let none = f64::from_bits((f32::INFINITY.to_bits() as u64) << 32 | u32::MAX as u64);
        Self {
            k,
            keys: [[f64x8::splat(simd, none); 2]; K],
            farthest: f32x16::splat(simd, f32::INFINITY),
        }
    }

    /// Inserts the place `index`, with these squared distances, where it is among the nearest.
    #[inline(always)]
    pub(super) fn take(&mut self, simd: S, squared: f32x16<S>, index: u32) {
        let distance: u32x16<S> = squared.bitcast();
        let (first, second) = u32x16::splat(simd, index).interleave(distance);
        let new: [f64x8<S>; 2] = [first.bitcast(), second.bitcast()];
        for (half, new) in new.into_iter().enumerate() {
            for n in (1..self.k).rev() {
                let before = self.keys[n - 1][half].max(new);
                self.keys[n][half] = self.keys[n][half].min(before);
            }
            self.keys[0][half] = self.keys[0][half].min(new);
        }
        let [first, second] = self.keys[self.k - 1];
        let first: u32x16<S> = first.bitcast();
        self.farthest = first.deinterleave(second.bitcast::<u32x16<S>>()).1.bitcast();
    }

    /// Writes the indices of the first `k` of each place.
    #[inline(always)]
    pub(super) fn write(&self, k: usize, rows: &mut [u32]) {
        for (n, keys) in self.keys.iter().enumerate().take(k) {
            for (lane, row) in rows.chunks_exact_mut(k).enumerate().take(LANES) {
                row[n] = keys[lane / 8][lane % 8].to_bits() as u32;
            }
        }
    }
}
