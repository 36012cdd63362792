//! Radii from local density.
//!
//! Where `k` neighbours lie within `d_k` on a surface, there are `k / (pi d_k^2)` points per area, and the distance
//! between them is `r = d_k sqrt(pi / k)`. It is used as the radius: on a square grid discs reach `sqrt(2)` times
//! as far as they must to leave no hole. Two measures against outliers: `d_k^2` is the mean of `d_j^2 k / j` over
//! the farther half of the neighbours, each of which estimates it; and a point is at most twice as large as the
//! median of its neighbours.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::Neighborhoods;
use super::nearest::MOST_NEIGHBORS;

/// A radius is at most this many times the median of its neighbours'.
const LARGEST: f64 = 2.0;

impl Neighborhoods {
    /// Radii of all positions; see [`estimate_radii`](super::estimate_radii).
    pub fn radii(&self) -> Vec<f32> {
        let limited = self.place_radii();
        // Also where the unit is so small that 32 bits cannot hold the radius.
        let length = |r: f64| ((r * self.scale) as f32).clamp(f32::MIN_POSITIVE, f32::MAX);
        let lengths: Vec<f32> = limited.into_par_iter().map(length).collect();
        self.spread(&lengths)
    }

    /// Radii of places, in their own unit.
    pub(super) fn place_radii(&self) -> Vec<f64> {
        if self.k == 0 {
            return vec![1.0 / self.scale; self.place_count()];
        }
        let spacing: Vec<f64> = (0..self.place_count())
            .into_par_iter()
            .map(|i| self.spacing(i))
            .collect();
        (0..self.place_count())
            .into_par_iter()
            .map(|i| {
                let mut around = [0.0; MOST_NEIGHBORS];
                let around = &mut around[..self.k];
                for (spacing_there, &j) in around.iter_mut().zip(self.of(i)) {
                    *spacing_there = spacing[j as usize];
                }
                let (_, median, _) = around.select_nth_unstable_by(self.k / 2, f64::total_cmp);
                spacing[i].min(LARGEST * *median)
            })
            .collect()
    }

    /// Distance between points around a place.
    fn spacing(&self, place: usize) -> f64 {
        let at = self.place(place);
        let first = self.k / 2;
        let estimates = self
            .of(place)
            .iter()
            .enumerate()
            .skip(first)
            .map(|(j, &neighbor)| {
                let squared = self.place(neighbor as usize).distance_squared(at);
                squared * PI / (j + 1) as f64
            });
        (estimates.sum::<f64>() / (self.k - first) as f64).sqrt()
    }
}
