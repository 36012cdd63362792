//! Regions of samples as hexahedra, and the pieces they are cut into.
//!
//! The part of a cell at a corner with three edges is a hexahedron: the corner, the midpoints of its edges and
//! faces, and the centre of the cell, mapped trilinearly (for hexahedra an octant of the cell). Values at its nodes
//! are means of the cell's, so that places and values are interpolated with the same weights and a linear field
//! stays linear.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use splatvol_scene::CellKind;

/// Pieces along one side of a hexahedron at most.
pub(super) const MOST_PER_SIDE: usize = 32;

/// Longest side of an uncut region along any axis, in spacings of its kernel.
pub(super) const UNCUT: f64 = 1.25;

/// Sides of pieces at most, in spacings.
pub(super) const LONGEST: f64 = 0.8;

/// A piece of a region.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) position: DVec3,
    pub(super) volume: f64,
    /// Value interpolated there by the cell's shape functions; NaN where one of its points is missing.
    pub(super) value: f64,
}

/// A node: place and value.
pub(super) type Node = (DVec3, f64);

/// A hexahedron: node n is at the upper end of axis a where bit a of n is set.
pub(super) type Hexahedron = [Node; 8];

/// Place, derivatives and value at coordinates from 0 to 1.
pub(super) fn trilinear(nodes: &Hexahedron, at: DVec3) -> (Node, DMat3) {
    let (mut place, mut value, mut columns) = (DVec3::ZERO, 0.0, [DVec3::ZERO; 3]);
    for (n, &(corner, own)) in nodes.iter().enumerate() {
        let factor = |axis: usize| {
            if n >> axis & 1 == 1 {
                at[axis]
            } else {
                1.0 - at[axis]
            }
        };
        let slope = |axis: usize| if n >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let factors = [factor(0), factor(1), factor(2)];
        let weight = factors[0] * factors[1] * factors[2];
        place += weight * corner;
        value += weight * own;
        columns[0] += slope(0) * factors[1] * factors[2] * corner;
        columns[1] += slope(1) * factors[0] * factors[2] * corner;
        columns[2] += slope(2) * factors[0] * factors[1] * corner;
    }
    (
        (place, value),
        DMat3::from_cols(columns[0], columns[1], columns[2]),
    )
}

/// Number of pieces along a side, given the longest allowed piece.
pub(super) fn count(side: f64, longest: f64) -> usize {
    // Lengths that are not finite are capped too.
    (side / longest - 1e-9).ceil().clamp(1.0, MOST_PER_SIDE as f64) as usize
}

/// The greatest length of a hexahedron's edges along each axis.
pub(super) fn lengths(nodes: &Hexahedron, spacings_from_local: &DMat3) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let low = (0..8).filter(|n| n >> axis & 1 == 0);
        low.map(|n| (*spacings_from_local * (nodes[n | 1 << axis].0 - nodes[n].0)).length())
            .fold(0.0, f64::max)
    })
}

/// Cuts a hexahedron into equal parts of its coordinates.
pub(super) fn cut(nodes: &Hexahedron, counts: [usize; 3], pieces: &mut Vec<Piece>) {
    let sizes = DVec3::from_array(counts.map(|count| (count as f64).recip()));
    for n in 0..counts.iter().product() {
        let index = [
            n % counts[0],
            n / counts[0] % counts[1],
            n / counts[0] / counts[1],
        ];
        let at = (DVec3::from_array(index.map(|i| i as f64)) + 0.5) * sizes;
        let ((position, value), map) = trilinear(nodes, at);
        pieces.push(Piece {
            position,
            volume: map.determinant().abs() * sizes.element_product(),
            value,
        });
    }
}

/// Gathers the pieces in each box of a lattice of spacing [`LONGEST`] around a place into one: their mean by
/// volume. If the pieces lie on a linear field, so does the mean.
pub(super) fn gather(pieces: &[Piece], centre: DVec3, spacings_from_local: &DMat3) -> Vec<Piece> {
    let mut boxes: BTreeMap<[i64; 3], Piece> = BTreeMap::new();
    for piece in pieces.iter().filter(|piece| piece.volume > 0.0) {
        let at = *spacings_from_local * (piece.position - centre) / LONGEST;
        let sum = boxes
            .entry(at.round().to_array().map(|c| c as i64))
            .or_insert(Piece {
                position: DVec3::ZERO,
                volume: 0.0,
                value: 0.0,
            });
        sum.position += piece.volume * (piece.position - centre);
        sum.value += piece.volume * piece.value;
        sum.volume += piece.volume;
    }
    let mean = |sum: Piece| Piece {
        position: centre + sum.position / sum.volume,
        value: sum.value / sum.volume,
        ..sum
    };
    boxes.into_values().map(mean).collect()
}

/// The hexahedron of a corner of a cell, as the lists of points whose means its nodes are.
pub(super) type Region = [Vec<usize>; 8];

/// The regions of a cell's points: point, and hexahedron. Tetrahedra are the only quadratic kind that has them, as
/// eight linear ones.
pub(super) fn regions(kind: CellKind) -> Vec<(usize, Region)> {
    match kind {
        CellKind::Tetra => of_tetra([0, 1, 2, 3]),
        CellKind::QuadraticTetra => QUADRATIC_TETRA.into_iter().flat_map(of_tetra).collect(),
        CellKind::Wedge => of_wedge(),
        CellKind::Hexahedron => of_cube([0, 1, 3, 2, 4, 5, 7, 6]),
        CellKind::Voxel => of_cube([0, 1, 2, 3, 4, 5, 6, 7]),
        // A cube whose upper corners are one point.
        CellKind::Pyramid => of_cube([0, 1, 3, 2, 4, 4, 4, 4]),
        _ => Vec::new(),
    }
}

/// Points 4 to 9 are the midpoints of the edges 01, 12, 20, 03, 13, 23; the octahedron between is cut along 4 to 9.
const QUADRATIC_TETRA: [[usize; 4]; 8] = [
    [0, 4, 6, 7],
    [4, 1, 5, 8],
    [6, 5, 2, 9],
    [7, 8, 9, 3],
    [4, 9, 5, 6],
    [4, 9, 6, 7],
    [4, 9, 7, 8],
    [4, 9, 8, 5],
];

fn of_tetra(corners: [usize; 4]) -> Vec<(usize, Region)> {
    let region = |own: usize| {
        let ring: [usize; 3] = std::array::from_fn(|n| corners[(own + 1 + n) % 4]);
        let node = |n: usize| {
            let beside = (0..3).filter(|axis| n >> axis & 1 == 1).map(|axis| ring[axis]);
            std::iter::once(corners[own]).chain(beside).collect()
        };
        (corners[own], std::array::from_fn(node))
    };
    (0..4).map(region).collect()
}

/// The octants of a cube, corners x fastest.
fn of_cube(corners: [usize; 8]) -> Vec<(usize, Region)> {
    let region = |own: usize| {
        let node = |n: usize| {
            let shared = (0..8).filter(|corner| (corner ^ own) & !n == 0);
            shared.map(|corner| corners[corner]).collect()
        };
        (corners[own], std::array::from_fn(node))
    };
    (0..8).map(region).collect()
}

fn of_wedge() -> Vec<(usize, Region)> {
    let region = |own: usize| {
        let (level, corner) = (own / 3 * 3, own % 3);
        let node = |n: usize| {
            let triangle = [true, n & 1 == 1, n >> 1 & 1 == 1];
            let base = (0..3).filter(|&k| triangle[k]).map(|k| (corner + k) % 3);
            let base: Vec<usize> = base.collect();
            let opposite = base.iter().map(|k| k + 3 - level).filter(|_| n >> 2 == 1);
            base.iter().map(|k| k + level).chain(opposite).collect()
        };
        (own, std::array::from_fn(node))
    };
    (0..6).map(region).collect()
}

/// A hexahedron whose nodes are means of points.
pub(super) fn hexahedron(region: &Region, point: impl Fn(usize) -> Node) -> Hexahedron {
    std::array::from_fn(|n| {
        let own = &region[n];
        let sum = own.iter().fold((DVec3::ZERO, 0.0), |(place, value), &index| {
            let (p, v) = point(index);
            (place + p, value + v)
        });
        let share = (own.len() as f64).recip();
        (sum.0 * share, sum.1 * share)
    })
}
