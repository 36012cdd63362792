//! Sums of all kernels at samples, again and again with other masses.
//!
//! Places and kernels stay, so what a kernel of mass 1 has at a sample is kept: one row of a sparse matrix per place, until
//! [`MOST_KEPT`] are kept. The remaining rows are found anew each time.

use rayon::prelude::*;

use super::Sample;
use super::normalise::Evaluated;
use super::tree::Tree;

/// Densities that are kept at most: 256 MiB.
const MOST_KEPT: usize = 1 << 25;
/// Rows that are found at once.
const CHUNK: usize = 4096;

/// A kernel and its density at a sample, for mass 1.
type Density = (u32, f32);

/// Which kernels have what at some of the samples, the places.
pub(super) struct Sums<'a> {
    samples: &'a [Sample],
    places: Vec<u32>,
    kernels: &'a [Evaluated],
    tree: &'a Tree,
    kept: Vec<Box<[Density]>>,
}

impl<'a> Sums<'a> {
    /// Sums at `places`, numbers of samples, of which as many rows are kept as may be, or none.
    pub(super) fn new(
        samples: &'a [Sample],
        (kernels, tree): (&'a [Evaluated], &'a Tree),
        places: Vec<u32>,
    ) -> Self {
        Self {
            samples,
            places,
            kernels,
            tree,
            kept: Vec::new(),
        }
    }

    /// Keeps rows, as many as may be, where they are asked for more than once.
    pub(super) fn kept(mut self, times: usize) -> Self {
        let mut count = if times > 1 { 0 } else { MOST_KEPT };
        while self.kept.len() < self.places.len() && count < MOST_KEPT {
            let rows = self.kept.len()..self.places.len().min(self.kept.len() + CHUNK);
            let found: Vec<_> = rows.into_par_iter().map(|place| self.row(place)).collect();
            count += found.iter().map(|row| row.len()).sum::<usize>();
            self.kept.extend(found);
        }
        self
    }

    /// The samples at which sums are.
    pub(super) fn places(&self) -> &[u32] {
        &self.places
    }

    /// The sums of all kernels at the places, for masses.
    pub(super) fn all(&self, masses: &[f64]) -> Vec<f64> {
        (0..self.places.len())
            .into_par_iter()
            .map(|place| self.at(place, masses))
            .collect()
    }

    fn at(&self, place: usize, masses: &[f64]) -> f64 {
        let mut sum = 0.0;
        match self.kept.get(place) {
            Some(row) => {
                for &(kernel, density) in row {
                    sum += masses[kernel as usize] * f64::from(density);
                }
            }
            None => self.each(place, |kernel, density| {
                sum += masses[kernel] * f64::from(density);
            }),
        }
        sum
    }

    fn row(&self, place: usize) -> Box<[Density]> {
        let mut row = Vec::new();
        self.each(place, |kernel, density| row.push((kernel as u32, density)));
        row.into_boxed_slice()
    }

    /// Kernels that reach a place.
    #[inline(always)]
    fn each(&self, place: usize, mut visit: impl FnMut(usize, f32)) {
        let at = self.samples[self.places[place] as usize].position;
        self.tree.each(at, |other| {
            let kernel = &self.kernels[other];
            let density = kernel.density(at - kernel.position);
            if density > 0.0 {
                visit(other, density as f32);
            }
        });
    }
}
