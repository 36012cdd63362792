//! Volumes and second moments of the regions that belong to points and cells.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use splatvol_scene::{CellKind, Cells, Mesh};

use super::reference_cell::{Part, parts};
use super::{outer, position};

/// Volume, first and second moments about its own origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moments {
    pub(super) volume: f64,
    pub(super) first: DVec3,
    pub(super) second: DMat3,
}

impl Moments {
    const ZERO: Self = Self {
        volume: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
    };

    fn add(&mut self, volume: f64, offset: DVec3, spread: DMat3) {
        self.volume += volume;
        self.first += volume * offset;
        self.second += volume * (spread + outer(offset, offset));
    }

    fn join(&mut self, other: &Self) {
        self.volume += other.volume;
        self.first += other.first;
        self.second += other.second;
    }
}

/// Parts of all kinds.
pub(super) struct Tables(Vec<(CellKind, Vec<Part>)>);

impl Tables {
    pub(super) fn of(cells: &Cells) -> Self {
        let used = |kind: &CellKind| cells.kinds().contains(kind);
        Self(
            CellKind::ALL
                .into_iter()
                .filter(used)
                .map(|kind| (kind, parts(kind)))
                .collect(),
        )
    }

    fn parts(&self, kind: CellKind) -> &[Part] {
        let found = self.0.iter().find(|(other, _)| *other == kind);
        found.map_or(&[], |(_, parts)| parts)
    }
}

/// Calls `visit(part, place, volume, spread)` for the parts of a cell. Flat and inside-out cells have positive
/// volumes too.
fn each_part(corners: &[DVec3], parts: &[Part], mut visit: impl FnMut(&Part, DVec3, f64, DMat3)) {
    for part in parts {
        let place = part.place.iter().zip(corners).map(|(&c, &p)| c * p).sum();
        let column = |axis: usize| part.slopes.iter().zip(corners).map(|(s, &p)| s[axis] * p).sum();
        let map = DMat3::from_cols(column(0), column(1), column(2));
        let spread = map * part.spread * map.transpose();
        visit(part, place, part.volume * map.determinant().abs(), spread);
    }
}

fn corners(mesh: &Mesh, cells: &Cells, cell: usize) -> Vec<DVec3> {
    cells
        .points(cell)
        .iter()
        .map(|&point| position(mesh, point as usize))
        .collect()
}

/// Moments of the cells, about their first point.
pub(super) fn of_cells(mesh: &Mesh, cells: &Cells, tables: &Tables) -> Vec<Moments> {
    let moments = |cell: usize| {
        let corners = corners(mesh, cells, cell);
        let mut sum = Moments::ZERO;
        each_part(
            &corners,
            tables.parts(cells.kind(cell)),
            |_, place, volume, spread| {
                sum.add(volume, place - corners[0], spread);
            },
        );
        sum
    };
    (0..cells.len()).into_par_iter().map(moments).collect()
}

/// Moments of the parts nearest to each point, about the point.
pub(super) fn of_points(mesh: &Mesh, cells: &Cells, tables: &Tables) -> Vec<Moments> {
    const BATCH: usize = 1 << 14;
    let of_cell = |cell: usize| {
        let corners = corners(mesh, cells, cell);
        let mut sums = vec![Moments::ZERO; corners.len()];
        each_part(
            &corners,
            tables.parts(cells.kind(cell)),
            |part, place, volume, spread| {
                let share = 1.0 / part.owners.len() as f64;
                for &owner in &part.owners {
                    sums[owner].add(share * volume, place - corners[owner], spread);
                }
            },
        );
        sums
    };
    let mut sums = vec![Moments::ZERO; mesh.positions().len()];
    let mut first = 0;
    while first < cells.len() {
        let batch = first..(first + BATCH).min(cells.len());
        let found: Vec<Vec<Moments>> = batch.clone().into_par_iter().map(of_cell).collect();
        // In the order of the cells, whatever the threads.
        for (cell, moments) in batch.clone().zip(&found) {
            for (&point, moment) in cells.points(cell).iter().zip(moments) {
                sums[point as usize].join(moment);
            }
        }
        first = batch.end;
    }
    sums
}
