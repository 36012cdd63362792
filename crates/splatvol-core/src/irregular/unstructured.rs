//! Kernels of unstructured cells: moments for covariances, neighbours by shared cells.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use splatvol_scene::{Association, Cells, Mesh};

use super::adjacency::{self, Lists};
use super::corners::CornerRegions;
use super::gradation::Trigger;
use super::moments::{self, Moments, Tables};
use super::normalise::{Correction, sweep};
use super::resample::{Resampling, resample};
use super::tree::Tree;
use super::{Sample, gradient, outer, position};

/// Width of the kernels of irregular cells relative to a voxel's. Their spacing varies from cell to cell, and
/// kernels of the regular grid's width would show it. Tetrahedra of a lattice whose points are moved by up to 0.25
/// of it ripple by 3.8 % with 1, and by 1.9 % with 1.15.
const WIDENING: f64 = 1.15;
/// Passes of smoothing the covariances: without them these tetrahedra ripple by 4.5 %, and by 14 % with values on
/// cells.
const PASSES_OF_POINTS: usize = 2;
const PASSES_OF_CELLS: usize = 3;
/// Steps of normalisation: Chebyshev's for eigenvalues from 0.2 to 1, in an order that never amplifies. Ten steps
/// of length 1 do no better.
const STEPS_OF_POINTS: [f64; 4] = [1.03, 4.34, 1.33, 2.24];
/// Steps for eigenvalues from 0.15 to 1: cells differ more.
const STEPS_OF_CELLS: [f64; 6] = [1.015, 6.08, 1.46, 2.15, 1.142, 3.65];

/// Growth of a kernel per spacing that needs no more kernels.
const TRIGGER_OF_POINTS: Trigger = Trigger {
    alone: 0.6,
    through: 0.6,
};
const TRIGGER_OF_CELLS: Trigger = Trigger {
    alone: 1.0,
    through: 1.0,
};

/// The samples of points or cells, in the order of the values.
pub(super) fn samples(mesh: &Mesh, cells: &Cells, sigma: f64) -> (Vec<Sample>, Resampling) {
    let tables = Tables::of(cells);
    let points = mesh.positions().len();
    let cells_of_points = adjacency::cells_of_points(cells, points);
    let scale = 12.0 * (WIDENING * sigma).powi(2);
    let blanked = |point: usize| mesh.blanked().get(point).copied().unwrap_or(false);
    let (mut samples, neighbours): (Vec<Sample>, Lists) = match mesh.field().association {
        Association::Point => {
            let moments = moments::of_points(mesh, cells, &tables);
            let sample = |point: usize| about(&moments[point], position(mesh, point), scale, !blanked(point));
            let samples = (0..points).into_par_iter().map(sample).collect();
            (samples, adjacency::of_points(cells, &cells_of_points, points))
        }
        Association::Cell => {
            let moments = moments::of_cells(mesh, cells, &tables);
            let sample = |cell: usize| {
                let own = cells.points(cell);
                let shown = !own.iter().any(|&point| blanked(point as usize));
                centred(&moments[cell], position(mesh, own[0] as usize), scale, shown)
            };
            let samples = (0..cells.len()).into_par_iter().map(sample).collect();
            (samples, adjacency::of_cells(cells, &cells_of_points))
        }
    };
    add_values(&mut samples, &mesh.field().values, &neighbours);
    let (passes, steps, trigger): (usize, &[f64], Trigger) = match mesh.field().association {
        Association::Point => (PASSES_OF_POINTS, &STEPS_OF_POINTS, TRIGGER_OF_POINTS),
        Association::Cell => (PASSES_OF_CELLS, &STEPS_OF_CELLS, TRIGGER_OF_CELLS),
    };
    for _ in 0..passes {
        smooth_covariances(&mut samples, &neighbours);
    }
    let inner = inner_samples(mesh, cells, &cells_of_points, &neighbours);
    let regions = CornerRegions::new(mesh, cells, &samples, (&cells_of_points, &neighbours), &inner);
    if let Some(found) = resample(&samples, &regions, (trigger, WIDENING * sigma), |_| true) {
        return (found.samples, found.report);
    }
    normalise(&mut samples, &inner, steps);
    (samples, Resampling::default())
}

/// A kernel at a point, from the moments about it.
fn about(moments: &Moments, position: DVec3, scale: f64, shown: bool) -> Sample {
    Sample {
        position,
        covariance: moments.second * (scale / moments.volume),
        mass: moments.volume,
        gradient: DVec3::ZERO,
        value: f32::NAN,
        valid: shown && moments.volume.is_normal(),
    }
}

/// A kernel at the centre of mass.
fn centred(moments: &Moments, origin: DVec3, scale: f64, shown: bool) -> Sample {
    let offset = moments.first / moments.volume;
    Sample {
        position: origin + offset,
        covariance: (moments.second * moments.volume.recip() - outer(offset, offset)) * scale,
        ..about(moments, origin, scale, shown)
    }
}

fn add_values(samples: &mut [Sample], values: &[f32], neighbours: &Lists) {
    let of = |index: usize, samples: &[Sample]| {
        let ring = neighbours.of(index).iter().copied();
        // Cells have few neighbours at a border: take theirs too.
        let mut near: Vec<u32> = ring.collect();
        if near.len() < 6 {
            let second = near
                .iter()
                .flat_map(|&other| neighbours.of(other as usize).iter().copied());
            near = near
                .iter()
                .copied()
                .chain(second)
                .filter(|&other| other as usize != index)
                .collect();
            near.sort_unstable();
            near.dedup();
        }
        gradient::least_squares(near.into_iter().map(|other| {
            let other = other as usize;
            let offset = samples[other].position - samples[index].position;
            (offset, f64::from(values[other]) - f64::from(values[index]))
        }))
    };
    let shared: &[Sample] = samples;
    let found: Vec<DVec3> = (0..samples.len())
        .into_par_iter()
        .map(|index| of(index, shared))
        .collect();
    for ((sample, gradient), &value) in samples.iter_mut().zip(found).zip(values) {
        sample.gradient = gradient;
        sample.value = value;
    }
}

/// Replaces covariances by their mean over a sample and its neighbours, weighted by mass: shapes that differ from
/// sample to sample do not tile space, but slowly varying ones do.
fn smooth_covariances(samples: &mut [Sample], neighbours: &Lists) {
    let of = |index: usize, samples: &[Sample]| {
        let near = neighbours.of(index).iter().map(|&other| &samples[other as usize]);
        let own = &samples[index];
        let (sum, mass) = near
            .chain([own])
            .filter(|sample| sample.valid)
            .fold((DMat3::ZERO, 0.0), |(sum, mass), sample| {
                (sum + sample.mass * sample.covariance, mass + sample.mass)
            });
        if mass > 0.0 {
            sum * mass.recip()
        } else {
            own.covariance
        }
    };
    let shared: &[Sample] = samples;
    let found: Vec<DMat3> = (0..samples.len())
        .into_par_iter()
        .map(|index| of(index, shared))
        .collect();
    for (sample, covariance) in samples.iter_mut().zip(found) {
        sample.covariance = covariance;
    }
}

/// True for samples that are two rings of cells or more from the border.
fn inner_samples(mesh: &Mesh, cells: &Cells, cells_of_points: &Lists, neighbours: &Lists) -> Vec<bool> {
    let faces = adjacency::of_cells(cells, cells_of_points);
    let open: Vec<bool> = (0..cells.len())
        .map(|cell| faces.of(cell).len() < adjacency::face_count(cells, cell))
        .collect();
    let mut outer: Vec<bool> = match mesh.field().association {
        Association::Cell => open,
        Association::Point => {
            let beside = |point| cells_of_points.of(point).iter().any(|&cell| open[cell as usize]);
            (0..mesh.positions().len()).map(beside).collect()
        }
    };
    let rings = if mesh.field().association == Association::Cell {
        3
    } else {
        1
    };
    for _ in 0..rings {
        let beside =
            |index: usize| outer[index] || neighbours.of(index).iter().any(|&other| outer[other as usize]);
        outer = (0..outer.len()).into_par_iter().map(beside).collect();
    }
    outer.into_iter().map(|outer| !outer).collect()
}

/// Normalises masses, so that a constant field stays constant, unless cells are so degenerate that all kernels overlap.
fn normalise(samples: &mut [Sample], inner: &[bool], steps: &[f64]) {
    let mut masses: Vec<f64> = samples.iter().map(|sample| sample.mass).collect();
    let tree = Tree::new(samples);
    if !tree.is_affordable() {
        return;
    }
    let places = tree.places(|_| true);
    sweep(&mut masses, &places, steps, |masses| {
        let sums = tree.sums(&places, masses).into_iter().zip(&places);
        sums.map(|(sum, &place)| Correction::beside(!inner[place as usize]).plus(sum))
            .collect()
    });
    for (sample, mass) in samples.iter_mut().zip(masses) {
        sample.mass = mass;
    }
}
