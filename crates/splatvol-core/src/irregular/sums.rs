//! Sums of all kernels at all samples, again and again with other masses.
//!
//! Places and kernels stay, so what a kernel of mass 1 has at a sample is kept: one row of a sparse matrix per sample, until
//! [`MOST_KEPT`] are kept. The remaining rows are found anew each time.

use rayon::prelude::*;

use super::Sample;
use super::normalise::Evaluated;
use super::tree::Tree;

/// Densities that are kept at most: 128 MiB.
const MOST_KEPT: usize = 1 << 24;
/// Rows that are found at once.
const CHUNK: usize = 4096;

/// A kernel and its density at a sample, for mass 1.
type Density = (u32, f32);

/// Which kernels have what at which samples.
pub(super) struct Sums<'a> {
    samples: &'a [Sample],
    kernels: Vec<Evaluated>,
    tree: Tree,
    kept: Vec<Box<[Density]>>,
}

impl<'a> Sums<'a> {
    pub(super) fn new(samples: &'a [Sample]) -> Self {
        let mut sums = Self {
            samples,
            kernels: samples.par_iter().map(Evaluated::new).collect(),
            tree: Tree::new(samples),
            kept: Vec::new(),
        };
        let mut count = 0;
        while sums.kept.len() < samples.len() && count < MOST_KEPT {
            let rows = sums.kept.len()..samples.len().min(sums.kept.len() + CHUNK);
            let found: Vec<_> = rows.into_par_iter().map(|index| sums.row(index)).collect();
            count += found.iter().map(|row| row.len()).sum::<usize>();
            sums.kept.extend(found);
        }
        sums
    }

    pub(super) fn is_legal(&self, index: usize) -> bool {
        self.kernels[index].is_legal()
    }

    /// The sum of all kernels at a sample, for masses.
    pub(super) fn at(&self, index: usize, masses: &[f64]) -> f64 {
        let mut sum = 0.0;
        match self.kept.get(index) {
            Some(row) => {
                for &(kernel, density) in row {
                    sum += masses[kernel as usize] * f64::from(density);
                }
            }
            None => self.each(index, |kernel, density| {
                sum += masses[kernel] * f64::from(density);
            }),
        }
        sum
    }

    fn row(&self, index: usize) -> Box<[Density]> {
        let mut row = Vec::new();
        self.each(index, |kernel, density| row.push((kernel as u32, density)));
        row.into_boxed_slice()
    }

    /// Kernels that reach a sample.
    #[inline(always)]
    fn each(&self, index: usize, mut visit: impl FnMut(usize, f32)) {
        let at = self.samples[index].position;
        self.tree.each(at, |other| {
            let kernel = &self.kernels[other];
            let density = kernel.density(at - kernel.position);
            if density > 0.0 {
                visit(other, density as f32);
            }
        });
    }
}
