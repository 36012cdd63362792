//! Regions of the samples of unstructured cells: the parts of cells around a point, or a cell.

use glam::DMat3;
use splatvol_scene::{Association, CellKind, Cells, Mesh};

use super::adjacency::Lists;
use super::gradation::Neighbours;
use super::normalise::Correction;
use super::pieces::{Hexahedron, LONGEST, Region, UNCUT, count, hexahedron, lengths, regions};
use super::resample::{Cut, Regions};
use super::{Sample, position};

/// Side of pieces before they are gathered, relative to the side afterwards.
const FINE: f64 = 0.6;

/// A mesh with its samples before normalisation.
pub(super) struct CornerRegions<'a> {
    mesh: &'a Mesh,
    cells: &'a Cells,
    samples: &'a [Sample],
    cells_of_points: &'a Lists,
    neighbours: &'a Lists,
    inner: &'a [bool],
    tables: Vec<(CellKind, Vec<(usize, Region)>)>,
}

impl<'a> CornerRegions<'a> {
    pub(super) fn new(
        mesh: &'a Mesh,
        cells: &'a Cells,
        samples: &'a [Sample],
        (cells_of_points, neighbours): (&'a Lists, &'a Lists),
        inner: &'a [bool],
    ) -> Self {
        let used = |kind: &CellKind| cells.kinds().contains(kind);
        Self {
            mesh,
            cells,
            samples,
            cells_of_points,
            neighbours,
            inner,
            tables: CellKind::ALL
                .into_iter()
                .filter(used)
                .map(|kind| (kind, regions(kind)))
                .collect(),
        }
    }

    fn regions(&self, kind: CellKind) -> &[(usize, Region)] {
        let found = self.tables.iter().find(|(other, _)| *other == kind);
        found.map_or(&[], |(_, regions)| regions)
    }

    /// The parts of cells around a point, with the values of the cells' points.
    fn around_point(&self, point: usize) -> Vec<Hexahedron> {
        let mut found = Vec::new();
        for &cell in self.cells_of_points.of(point) {
            let own = self.cells.points(cell as usize);
            let of_kind = self.regions(self.cells.kind(cell as usize)).iter();
            for (_, region) in of_kind.filter(|(corner, _)| own[*corner] as usize == point) {
                found.push(hexahedron(region, |n| {
                    let n = own[n] as usize;
                    (position(self.mesh, n), f64::from(self.samples[n].value))
                }));
            }
        }
        found
    }

    /// The parts of a cell, with values from its gradient, limited to the range of its neighbours.
    fn of_cell(&self, cell: usize) -> Vec<Hexahedron> {
        let points = self.cells.points(cell);
        let own = &self.samples[cell];
        let mut range = [own.value; 2];
        for &other in self.neighbours.of(cell) {
            let value = self.samples[other as usize].value;
            range = [range[0].min(value), range[1].max(value)];
        }
        let point = |n: usize| {
            let place = position(self.mesh, points[n] as usize);
            (place, own.value_at(place, range))
        };
        let all = self.regions(self.cells.kind(cell)).iter();
        all.map(|(_, region)| hexahedron(region, point)).collect()
    }
}

impl Neighbours for CornerRegions<'_> {
    fn each_neighbour(&self, index: usize, visit: &mut dyn FnMut(usize)) {
        for &other in self.neighbours.of(index) {
            visit(other as usize);
        }
    }
}

impl Regions for CornerRegions<'_> {
    const GATHERED: bool = true;

    fn cuts(&self, index: usize, spacings_from_local: &DMat3) -> Vec<Cut> {
        let parts = match self.mesh.field().association {
            Association::Point => self.around_point(index),
            Association::Cell => self.of_cell(index),
        };
        let sides: Vec<[f64; 3]> = parts
            .iter()
            .map(|nodes| lengths(nodes, spacings_from_local))
            .collect();
        // A part is half a cell wide.
        if !sides.iter().flatten().any(|&side| 2.0 * side > UNCUT) {
            return Vec::new();
        }
        let cut = |(nodes, sides): (Hexahedron, [f64; 3])| Cut {
            nodes,
            counts: sides.map(|side| count(side, FINE * LONGEST)),
        };
        parts.into_iter().zip(sides).map(cut).collect()
    }

    fn beyond(&self, index: usize, places: &[Sample]) -> Vec<Correction> {
        vec![Correction::beside(!self.inner[index]); places.len()]
    }
}
