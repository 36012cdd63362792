//! The nearest neighbours of each distinct place.
//!
//! Places are moved and scaled into a unit box, so that squared distances neither overflow nor vanish in 32 bits, and put
//! in Morton order: neighbours in space become neighbours in memory, and places that are the same follow each other.

use std::num::NonZeroUsize;

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

/// Most neighbours that are looked for.
const MOST_NEIGHBORS: usize = 64;
/// Queries of one task.
const BATCH: usize = 1024;

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
    /// Memory: about `60 + 4 k` bytes per position while this runs.
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

    /// What places have, for every position of the cloud.
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
    let bits = |p: &[f32; 3]| p.map(f32::to_bits);
    let mut order: Vec<(u64, u32)> = positions
        .par_iter()
        .enumerate()
        .map(|(index, p)| (morton(local(p)), index as u32))
        .collect();
    order.par_sort_unstable_by_key(|&(code, index)| (code, bits(&local(&positions[index as usize])), index));

    let mut places: Vec<[f32; 3]> = Vec::with_capacity(positions.len());
    let mut place_of = vec![0; positions.len()];
    for &(_, index) in &order {
        let place = local(&positions[index as usize]);
        if places.last().is_none_or(|last| bits(last) != bits(&place)) {
            places.push(place);
        }
        place_of[index as usize] = places.len() as u32 - 1;
    }
    (places, place_of)
}

/// Interleaved bits of the three coordinates, 21 of each.
fn morton(place: [f32; 3]) -> u64 {
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

/// The `k` nearest other places of each.
fn nearest(places: &[[f32; 3]], k: usize) -> Vec<u32> {
    let (Some(wanted), true) = (NonZeroUsize::new(k + 1), k > 0) else {
        return Vec::new();
    };
    let Ok(tree) = ImmutableKdTree::<f32, 3>::new_from_slice(places) else {
        // Places are finite and fewer than 2^32: what the tree could refuse does not occur.
        return vec![0; places.len() * k];
    };
    let mut neighbors = vec![0u32; places.len() * k];
    neighbors
        .par_chunks_mut(k * BATCH)
        .enumerate()
        .for_each(|(batch, rows)| {
            for (row, of) in rows.chunks_exact_mut(k).enumerate() {
                let index = batch * BATCH + row;
                let found = tree
                    .query(&places[index])
                    .nearest_n::<SquaredEuclidean<f32>>(wanted)
                    .execute();
                let others = found
                    .iter()
                    .map(|f| f.item)
                    .filter(|&item| item as usize != index);
                for (slot, item) in of.iter_mut().zip(others) {
                    *slot = item;
                }
            }
        });
    neighbors
}
