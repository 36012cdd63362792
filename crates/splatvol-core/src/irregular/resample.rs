//! Resampling: several kernels per sample where one is not enough.
//!
//! Kernels represent `f(x) = integral of f(y) N(x; y, V(y)) dy` by one point of quadrature per sample. A constant
//! stays constant as long as V varies little within a kernel and points are no further apart than the kernels are
//! wide. Skewed, sheared and flat cells satisfy this as well as cubes; cells beside others of another size or
//! direction do not. There the field is resampled, as in Mao (Splatting of non rectilinear volumes through
//! stochastic resampling, 1996). Covariances are cut until they vary slowly (`gradation`). Regions wider than their
//! kernel are cut into pieces that are not (`pieces`). Each piece has a kernel with the value of the cell's shape
//! functions there, and the covariance of its surroundings. Mao scatters points at random until spheres suffice.
//! Pieces instead follow the cells, so they are few, reproducible, and absent where the mesh is even.
//!
//! At most [`MOST_PER_SAMPLE`] kernels per sample are made, and they may not all overlap. If more are needed,
//! covariances may vary faster; if that is not enough, the samples stay as they are.

use std::ops::Range;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Sample;
use super::gradation::{Neighbours, Trigger, graded, violations};
use super::normalise::{Correction, sweep};
use super::pieces::{Hexahedron, Piece, cut, gather};
use super::tree::Tree;
use super::whitening::whitening;
use crate::eigen::eigen;

/// Sum of weights, six standard deviations away from all kernels, below which a piece has no surroundings.
const LEAST_WEIGHT: f64 = 1e-9;

/// Most kernels per sample of the mesh, on average.
pub const MOST_PER_SAMPLE: usize = 16;
/// Growth limits of covariances; each later one is used if the one before yields too many kernels.
const GROWTHS: [f64; 3] = [0.15, 0.3, 0.6];
/// Steps of normalisation, Chebyshev's for eigenvalues from 0.15 to 1.
const STEPS: [f64; 13] = [
    1.0, 1.015, 6.08, 1.46, 2.15, 1.142, 3.65, 1.015, 6.08, 1.46, 2.15, 1.142, 3.65,
];

/// Steps of each round; samples whose sums are already right are left out of a round.
const ROUNDS: [Range<usize>; 3] = [0..1, 1..7, 7..13];

/// Reach of a kernel along a diagonal, in neighbours: `sqrt(3)` times its four standard deviations of 0.74
/// spacings.
const REACH: usize = 6;

/// Most pieces that are gathered into one, on average.
const MOST_GATHERED: usize = 16;

/// A part of a region, and the number of its pieces along its axes.
pub(super) struct Cut {
    pub(super) nodes: Hexahedron,
    pub(super) counts: [usize; 3],
}

/// Regions of the samples.
pub(super) trait Regions: Neighbours {
    /// Whether pieces, smaller than they need to be where cells are not boxes, are gathered into fewer.
    const GATHERED: bool;

    /// The parts of a sample's region and their numbers of pieces; empty where the whole is no longer than its
    /// kernel allows. `spacings_from_local` measures offsets in spacings of the kernel.
    fn cuts(&self, index: usize, spacings_from_local: &DMat3) -> Vec<Cut>;

    /// Corrections at places in a sample's region: the target of the sums of kernels, and the parts of the sums
    /// that no kernel of the mesh contributes.
    fn beyond(&self, index: usize, places: &[Sample]) -> Vec<Correction>;
}

/// Samples, some of them pieces of original ones.
pub(super) struct Resampled {
    pub(super) samples: Vec<Sample>,
    /// Index of the original sample of each.
    pub(super) owners: Vec<u32>,
    pub(super) report: Resampling,
}

/// Report of resampling where cells change too fast for one kernel per sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Resampling {
    /// Samples that were replaced by several kernels.
    pub replaced: usize,
    /// Number of kernels beyond one per sample.
    pub added: usize,
    /// True where the limit of [`MOST_PER_SAMPLE`] made kernels coarser than they should be.
    pub limited: bool,
}

impl Resampling {
    /// Adds the report of another block.
    pub(super) fn join(&mut self, other: &Self) {
        self.replaced += other.replaced;
        self.added += other.added;
        self.limited |= other.limited;
    }
}

/// Replaces `samples`, not normalised yet, by kernels for which a constant stays constant; `None` if they need no
/// resampling.
pub(super) fn resample(
    samples: &[Sample],
    regions: &impl Regions,
    (trigger, sigma): (Trigger, f64),
    wanted: impl Fn(usize) -> bool + Sync,
) -> Option<Resampled> {
    let mut touched = violations(samples, regions, (trigger, sigma), &wanted);
    if !touched.iter().any(|&touched| touched) {
        return None;
    }
    touched = beside(&touched, regions);
    for (attempt, growth) in GROWTHS.into_iter().enumerate() {
        let around = Surroundings {
            samples,
            covariances: &graded(samples, regions, (growth, sigma)),
            regions,
            sigma,
        };
        let is_touched =
            |index: usize| touched[index] || around.covariances[index] != samples[index].covariance;
        let Some(counts) = around.counts(is_touched) else {
            continue;
        };
        let made: Vec<Vec<Sample>> = counts
            .par_iter()
            .enumerate()
            .map(|(index, &count)| around.kernels(index, count > 0))
            .collect();
        let report = Resampling {
            replaced: counts.iter().filter(|&&count| count > 0).count(),
            added: made.iter().map(Vec::len).sum::<usize>() - samples.len(),
            limited: attempt > 0,
        };
        let uneven = (0..samples.len())
            .map(|index| wanted(index) || is_touched(index))
            .collect();
        let joined = joined(&made, regions, uneven, report);
        if joined.is_some() {
            return joined;
        }
    }
    let whole: Vec<Vec<Sample>> = samples.iter().map(|&sample| vec![sample]).collect();
    let report = Resampling {
        limited: true,
        ..Resampling::default()
    };
    let uneven = (0..samples.len()).map(wanted).collect();
    joined(&whole, regions, uneven, report).or_else(|| {
        Some(Resampled {
            samples: samples.to_vec(),
            owners: (0..samples.len() as u32).collect(),
            report,
        })
    })
}

/// The marked samples and their neighbours.
fn beside(marked: &[bool], neighbours: &impl Neighbours) -> Vec<bool> {
    let near = |index: usize| {
        let mut found = marked[index];
        neighbours.each_neighbour(index, &mut |other| found |= marked[other]);
        found
    };
    (0..marked.len()).into_par_iter().map(near).collect()
}

/// Samples and their target covariances.
struct Surroundings<'a, R> {
    samples: &'a [Sample],
    covariances: &'a [DMat3],
    regions: &'a R,
    sigma: f64,
}

impl<R: Regions> Surroundings<'_, R> {
    /// Number of pieces of each sample, 0 for an unchanged one; `None` if there would be too many.
    fn counts(&self, is_touched: impl Fn(usize) -> bool + Sync) -> Option<Vec<usize>> {
        let limit = MOST_PER_SAMPLE * self.samples.len();
        let raw = |index: usize| {
            if !is_touched(index) {
                return 0;
            }
            self.cuts(index)
                .iter()
                .map(|cut| cut.counts.iter().product::<usize>())
                .sum()
        };
        let mut counts: Vec<usize> = (0..self.samples.len()).into_par_iter().map(raw).collect();
        let total = |counts: &[usize]| counts.iter().map(|&count| count.max(1)).sum::<usize>();
        if R::GATHERED && total(&counts) <= MOST_GATHERED * limit {
            counts.par_iter_mut().enumerate().for_each(|(index, count)| {
                if *count > 0 {
                    *count = self.pieces(index).len();
                }
            });
        }
        (total(&counts) <= limit).then_some(counts)
    }

    /// Offsets in spacings of a kernel: `sigma V^(-1/2)`, up to a rotation.
    fn spacings_from_local(&self, index: usize) -> Option<DMat3> {
        whitening(&self.covariances[index]).map(|whitening| whitening * self.sigma)
    }

    /// Offsets in spacings along the kernel's axes.
    fn axes_from_local(&self, index: usize) -> Option<DMat3> {
        let (values, vectors) = eigen(self.covariances[index]);
        let rows = std::array::from_fn::<_, 3, _>(|i| vectors[i] * (self.sigma / values[i].sqrt()));
        let map = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        (values[0] > 0.0 && map.is_finite()).then_some(map)
    }

    fn cuts(&self, index: usize) -> Vec<Cut> {
        match self.spacings_from_local(index) {
            Some(map) if self.samples[index].valid => self.regions.cuts(index, &map),
            _ => Vec::new(),
        }
    }

    fn pieces(&self, index: usize) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for part in self.cuts(index) {
            cut(&part.nodes, part.counts, &mut pieces);
        }
        if !R::GATHERED {
            return pieces;
        }
        match self.axes_from_local(index) {
            Some(map) => gather(&pieces, self.samples[index].position, &map),
            _ => pieces,
        }
    }

    /// The kernels of a sample: its own, or those of its pieces.
    fn kernels(&self, index: usize, is_cut: bool) -> Vec<Sample> {
        let whole = Sample {
            covariance: self.covariances[index],
            ..self.samples[index]
        };
        if !is_cut {
            return vec![whole];
        }
        let mut near = vec![index];
        self.regions.each_neighbour(index, &mut |other| {
            if self.samples[other].valid {
                near.push(other);
            }
        });
        let near: Vec<(DMat3, usize)> = near
            .into_iter()
            .map(|other| (self.covariances[other].inverse(), other))
            .filter(|(inverse, _)| inverse.is_finite())
            .collect();
        let pieces = self.pieces(index);
        pieces
            .iter()
            .map(|piece| self.kernel(&whole, piece, &near))
            .collect()
    }

    /// A piece's kernel: covariance and gradient are means of the surrounding ones, weighted by their kernels
    /// there.
    fn kernel(&self, whole: &Sample, piece: &Piece, near: &[(DMat3, usize)]) -> Sample {
        let (mut covariance, mut gradient, mut weights) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for (inverse, other) in near {
            let offset = piece.position - self.samples[*other].position;
            let weight = libm::exp(-0.5 * offset.dot(*inverse * offset));
            covariance += weight * self.covariances[*other];
            gradient += weight * self.samples[*other].gradient;
            weights += weight;
        }
        let is_near = weights > LEAST_WEIGHT;
        Sample {
            position: piece.position,
            mass: piece.volume,
            covariance: if is_near {
                covariance * weights.recip()
            } else {
                whole.covariance
            },
            gradient: if is_near {
                gradient / weights
            } else {
                whole.gradient
            },
            value: if piece.value.is_finite() && whole.value.is_finite() {
                piece.value as f32
            } else {
                whole.value
            },
            valid: piece.volume.is_normal(),
        }
    }
}

/// All kernels in one list, normalised; `uneven` marks samples whose kernels differ from an even grid's. `None` where
/// so many kernels overlap that they cannot be normalised.
fn joined(
    made: &[Vec<Sample>],
    regions: &impl Regions,
    uneven: Vec<bool>,
    report: Resampling,
) -> Option<Resampled> {
    let owners: Vec<u32> = made
        .iter()
        .enumerate()
        .flat_map(|(owner, kernels)| std::iter::repeat_n(owner as u32, kernels.len()))
        .collect();
    let samples: Vec<Sample> = made.iter().flatten().copied().collect();
    Some(Resampled {
        samples: normalised(samples, &owners, regions, uneven)?,
        owners,
        report,
    })
}

/// The samples with masses for which a constant stays constant. Only samples within reach of an uneven one are
/// tested; each round continues with those within reach of a sample whose sum is still wrong.
fn normalised(
    samples: Vec<Sample>,
    owners: &[u32],
    regions: &impl Regions,
    uneven: Vec<bool>,
) -> Option<Vec<Sample>> {
    let tree = Tree::new(&samples);
    if !tree.is_affordable() {
        return None;
    }
    let mut beyond = Beyond::new(&samples, owners, regions, uneven.len());
    let mut masses: Vec<f64> = samples.par_iter().map(|sample| sample.mass).collect();
    let corrections = |beyond: &Beyond<'_, _>, places: &[u32], masses: &[f64]| -> Vec<Correction> {
        let sums = tree.sums(places, masses);
        sums.into_par_iter()
            .zip(places)
            .map(|(sum, &place)| beyond.found[place as usize].plus(sum))
            .collect()
    };
    let mut marked = uneven;
    for steps in ROUNDS.map(|steps| &STEPS[steps]) {
        let near = reached(marked, regions);
        beyond.find(&near);
        let places = tree.places(|index| near[owners[index] as usize]);
        marked = vec![false; near.len()];
        for (&place, correction) in places.iter().zip(corrections(&beyond, &places, &masses)) {
            marked[owners[place as usize] as usize] |= !correction.is_right();
        }
        let near = reached(marked.clone(), regions);
        beyond.find(&near);
        let places = tree.places(|index| near[owners[index] as usize]);
        sweep(&mut masses, &places, steps, |masses| {
            corrections(&beyond, &places, masses)
        });
    }
    let own = samples.into_par_iter().zip(masses);
    Some(own.map(|(sample, mass)| Sample { mass, ..sample }).collect())
}

/// Corrections that apply to the sums, computed once for each requested sample.
struct Beyond<'a, R> {
    samples: &'a [Sample],
    regions: &'a R,
    /// First kernel of each sample, and the number of kernels at the end.
    first: Vec<usize>,
    is_known: Vec<bool>,
    found: Vec<Correction>,
}

impl<'a, R: Regions> Beyond<'a, R> {
    fn new(samples: &'a [Sample], owners: &[u32], regions: &'a R, count: usize) -> Self {
        let first = |owner: usize| owners.partition_point(|&other| (other as usize) < owner);
        Self {
            samples,
            regions,
            first: (0..=count).into_par_iter().map(first).collect(),
            is_known: vec![false; count],
            found: vec![Correction::Full(0.0); samples.len()],
        }
    }

    /// Finds it for the marked samples.
    fn find(&mut self, marked: &[bool]) {
        let is_wanted = |&owner: &usize| marked[owner] && !self.is_known[owner];
        let wanted: Vec<usize> = (0..marked.len()).filter(is_wanted).collect();
        let of = |&owner: &usize| {
            let own = &self.samples[self.first[owner]..self.first[owner + 1]];
            self.regions.beyond(owner, own)
        };
        let found: Vec<Vec<Correction>> = wanted.par_iter().map(of).collect();
        for (owner, found) in wanted.into_iter().zip(found) {
            self.is_known[owner] = true;
            self.found[self.first[owner]..][..found.len()].copy_from_slice(&found);
        }
    }
}

/// The marked samples and all samples within reach of their kernels.
fn reached(mut marked: Vec<bool>, neighbours: &impl Neighbours) -> Vec<bool> {
    for _ in 0..REACH {
        marked = beside(&marked, neighbours);
    }
    marked
}
