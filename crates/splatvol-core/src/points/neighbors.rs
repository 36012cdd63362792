//! The nearest neighbours of each distinct place.
//!
//! Places are moved and scaled into a unit box, so that squared distances neither overflow nor vanish in 32 bits.
//! They are sorted in Morton order: neighbours in space become neighbours in memory, and identical places become
//! adjacent.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::nearest::{MOST_NEIGHBORS, nearest};

/// A cloud's distinct places, each with its nearest neighbours.
#[derive(Debug, Clone)]
pub struct Neighborhoods {
    /// Distinct places, in Morton order, in a box of side 2 around the origin.
    pub(super) places: Vec<[f32; 3]>,
    /// Length of the positions' space per unit of `places`.
    pub(super) scale: f64,
    /// Position that became the origin of `places`.
    pub(super) center: DVec3,
    /// Neighbours per place.
    pub(super) k: usize,
    /// Indices of `places`, `k` for each, nearest first.
    neighbors: Vec<u32>,
    /// For each of the cloud's positions the index of its place.
    place_of: Vec<u32>,
}

impl Neighborhoods {
    /// Finds the `k` (1 to 64) nearest neighbours of every place; fewer where there are fewer places. Coordinates that
    /// are not finite count as the middle of the cloud.
    ///
    /// Memory: about `40 + 4 k` bytes per position while this runs.
    ///
    /// # Panics
    /// With 2^32 positions or more.
    pub fn new(positions: &[[f32; 3]], k: usize) -> Self {
        assert!(
            u32::try_from(positions.len()).is_ok(),
            "positions must be fewer than 2^32"
        );
        let (center, scale) = frame(positions);
        let (places, place_of) = distinct(positions, center, scale);
        let k = k.clamp(1, MOST_NEIGHBORS).min(places.len().saturating_sub(1));
        let neighbors = nearest(&places, k);
        Self {
            places,
            scale,
            center,
            k,
            neighbors,
            place_of,
        }
    }

    /// Number of distinct places.
    pub fn place_count(&self) -> usize {
        self.places.len()
    }

    /// Neighbours of a place, nearest first.
    #[inline]
    pub(super) fn of(&self, place: usize) -> &[u32] {
        &self.neighbors[place * self.k..(place + 1) * self.k]
    }

    /// All neighbours, `k` per place.
    pub(super) fn flat(&self) -> &[u32] {
        &self.neighbors
    }

    /// A place's coordinates.
    #[inline]
    pub(super) fn place(&self, index: usize) -> DVec3 {
        DVec3::from_array(self.places[index].map(f64::from))
    }

    /// Copies a property of the distinct places to every position of the cloud.
    pub(super) fn spread<T: Copy + Send + Sync>(&self, of_places: &[T]) -> Vec<T> {
        self.place_of
            .par_iter()
            .map(|&place| of_places[place as usize])
            .collect()
    }
}

/// Middle and half the longest side of the box around finite positions; a side of zero counts as 2.
fn frame(positions: &[[f32; 3]]) -> (DVec3, f64) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = positions
        .par_iter()
        .map(|p| DVec3::from_array(p.map(f64::from)))
        .filter(|p| p.is_finite())
        .fold(|| empty, |(min, max), p| (min.min(p), max.max(p)))
        .reduce(|| empty, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    if min.x > max.x {
        return (DVec3::ZERO, 1.0);
    }
    let half = (max - min).max_element() / 2.0;
    ((min + max) / 2.0, if half > 0.0 { half } else { 1.0 })
}

/// Distinct places in Morton order, and the place of each position.
fn distinct(positions: &[[f32; 3]], center: DVec3, scale: f64) -> (Vec<[f32; 3]>, Vec<u32>) {
    let local = |p: &[f32; 3]| {
        let p = DVec3::from_array(p.map(f64::from));
        let local = if p.is_finite() {
            (p - center) / scale
        } else {
            DVec3::ZERO
        };
        // Adding zero turns -0 into 0, which is the same place.
        (local + DVec3::ZERO).to_array().map(|c| c as f32 + 0.0)
    };
    let bits = |p: [f32; 3]| p.map(f32::to_bits);
    let mut order: Vec<(u64, u32)> = positions
        .par_iter()
        .enumerate()
        .map(|(index, p)| (morton(local(p)), index as u32))
        .collect();
    order.par_sort_unstable();
    // Places may differ even if their codes do not.
    let place_at = |index: u32| local(&positions[index as usize]);
    let runs = order.par_chunk_by_mut(|a, b| a.0 == b.0);
    runs.filter(|run| run.len() > 1)
        .for_each(|run| run.sort_by_cached_key(|&(_, index)| (bits(place_at(index)), index)));

    let mut places: Vec<[f32; 3]> = order.par_iter().map(|&(_, index)| place_at(index)).collect();
    let is_new = |n: usize| n == 0 || bits(places[n]) != bits(places[n - 1]);
    let is_new: Vec<bool> = (0..places.len()).into_par_iter().map(is_new).collect();
    let number = |count: &mut u32, &is_new: &bool| {
        *count += u32::from(is_new);
        Some(*count - 1)
    };
    let numbers: Vec<u32> = is_new.iter().scan(0, number).collect();
    let place_of: Vec<AtomicU32> = positions.par_iter().map(|_| AtomicU32::new(0)).collect();
    order.par_iter().zip(numbers).for_each(|(&(_, index), number)| {
        place_of[index as usize].store(number, Ordering::Relaxed);
    });
    let mut is_new = is_new.into_iter();
    places.retain(|_| is_new.next() == Some(true));
    let place_of = place_of.into_iter().map(AtomicU32::into_inner).collect();
    (places, place_of)
}

/// Interleaved bits of the three coordinates, 21 of each.
pub(super) fn morton(place: [f32; 3]) -> u64 {
    let spread = |coordinate: f32| {
        let steps = f64::from(1 << 20);
        let mut bits = ((f64::from(coordinate) + 1.0) * steps).clamp(0.0, 2.0 * steps - 1.0) as u64;
        for (shift, mask) in [
            (32, 0x001f_0000_0000_ffff),
            (16, 0x001f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ] {
            bits = (bits | bits << shift) & mask;
        }
        bits
    };
    spread(place[0]) | spread(place[1]) << 1 | spread(place[2]) << 2
}
