//! Samples of all structured blocks of a mesh, and data shared by blocks.

use std::collections::HashMap;
use std::ops::Range;

use splatvol_scene::{Association, Mesh};

use super::Sample;
use super::resample::{Resampled, Resampling};
use super::structured::BlockLattice;

/// The samples of all blocks, in the order of the values, pieces in place of their sample.
pub(super) fn samples(mesh: &Mesh, blocks: &[[usize; 3]], sigma: f64) -> (Vec<Sample>, Resampling) {
    let of_cells = mesh.field().association == Association::Cell;
    let values = &mesh.field().values;
    let (mut all, mut resampled, mut first_point, mut first_value) = (Vec::new(), Vec::new(), 0, 0);
    for &dims in blocks {
        let points = first_point..first_point + dims.iter().product::<usize>();
        let lattice = match of_cells {
            true => BlockLattice::of_cells(mesh, dims, points.start),
            false => BlockLattice::of_points(mesh, dims, points.start),
        };
        let own = first_value..first_value + lattice.positions.len();
        let mut samples = lattice.samples(&values[own.clone()], sigma);
        if let Some(found) = lattice.normalise(&mut samples, sigma) {
            resampled.push((own.clone(), found));
        }
        all.extend(samples);
        (first_point, first_value) = (points.end, own.end);
    }
    let shares = match of_cells {
        true => Vec::new(),
        false => share_coincident(&mut all),
    };
    replaced(all, &shares, &resampled)
}

/// The samples, with some ranges replaced by their resampled ones.
fn replaced(
    samples: Vec<Sample>,
    shares: &[f64],
    resampled: &[(Range<usize>, Resampled)],
) -> (Vec<Sample>, Resampling) {
    let mut report = Resampling::default();
    if resampled.is_empty() {
        return (samples, report);
    }
    let (mut joined, mut next) = (Vec::new(), 0);
    for (range, found) in resampled {
        joined.extend_from_slice(&samples[next..range.start]);
        joined.extend(found.samples.iter().zip(&found.owners).map(|(sample, &owner)| {
            let share = shares.get(range.start + owner as usize).copied().unwrap_or(1.0);
            Sample {
                mass: sample.mass * share,
                ..*sample
            }
        }));
        report.join(&found.report);
        next = range.end;
    }
    joined.extend_from_slice(&samples[next..]);
    (joined, report)
}

/// Points that lie in one place - where blocks meet, where a block closes upon itself - share one mass; the share
/// of each.
fn share_coincident(samples: &mut [Sample]) -> Vec<f64> {
    let key = |sample: &Sample| sample.position.as_vec3().to_array().map(|c| (c + 0.0).to_bits());
    let mut counts: HashMap<[u32; 3], u32> = HashMap::with_capacity(samples.len());
    for sample in samples.iter().filter(|sample| sample.valid) {
        *counts.entry(key(sample)).or_default() += 1;
    }
    let share = |sample: &Sample| match counts.get(&key(sample)) {
        Some(&count) if sample.valid => f64::from(count).recip(),
        _ => 1.0,
    };
    let shares: Vec<f64> = samples.iter().map(share).collect();
    for (sample, share) in samples.iter_mut().zip(&shares) {
        sample.mass *= share;
    }
    shares
}
