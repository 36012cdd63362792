//! Reference cells: 64 small parts of each kind in the cell's own coordinates, each with its nearest point.
//!
//! A part's place in space is `x = sum_n c_n(xi) p_n`, with the linear shape functions `phi` of the corners. Points
//! in the middle of edges add bubbles `4 phi_a phi_b` that pull the edge to them (for tetrahedra these are the
//! quadratic shape functions). A part belongs to its nearest point in the space of the `phi`; ties are shared.

use glam::{DMat3, DVec3};
use splatvol_scene::CellKind;

use super::outer;

/// Parts along each side of a cell.
const SIDE: usize = 4;

/// A small part of a cell.
pub(super) struct Part {
    /// Coefficients of the points in the place of the part's centre.
    pub(super) place: Vec<f64>,
    /// Derivatives of these by the cell's coordinates.
    pub(super) slopes: Vec<DVec3>,
    /// Volume in the cell's coordinates.
    pub(super) volume: f64,
    /// Second moments about the centre, per volume, in the cell's coordinates.
    pub(super) spread: DMat3,
    /// Points that own the part.
    pub(super) owners: Vec<usize>,
}

/// The parts of a kind of cells.
pub(super) fn parts(kind: CellKind) -> Vec<Part> {
    let corners = corners(kind.linear());
    let edges = edges(kind);
    grains(kind.linear())
        .into_iter()
        .map(|grain| {
            let (phi, slopes) = shape(kind.linear(), grain.centre);
            let mut part = Part {
                place: phi.clone(),
                slopes,
                volume: grain.volume,
                spread: grain.spread,
                owners: nearest(&phi, corners, &edges),
            };
            for &[a, b] in &edges {
                let (slope_a, slope_b) = (part.slopes[a], part.slopes[b]);
                let bubble = 4.0 * phi[a] * phi[b];
                let slope = 4.0
                    * (phi[a] * base_slope(kind, grain.centre, b)
                        + phi[b] * base_slope(kind, grain.centre, a));
                for (corner, old) in [(a, slope_a), (b, slope_b)] {
                    part.place[corner] -= 0.5 * bubble;
                    part.slopes[corner] = old - 0.5 * slope;
                }
                part.place.push(bubble);
                part.slopes.push(slope);
            }
            // Points in faces and in the middle add nothing to the place.
            part.place.resize(kind.point_count(), 0.0);
            part.slopes.resize(kind.point_count(), DVec3::ZERO);
            part
        })
        .collect()
}

fn base_slope(kind: CellKind, centre: DVec3, corner: usize) -> DVec3 {
    shape(kind.linear(), centre).1[corner]
}

/// Points nearest in the space of shape functions.
fn nearest(phi: &[f64], corners: usize, edges: &[[usize; 2]]) -> Vec<usize> {
    let ends = (0..corners)
        .map(|corner| [corner, corner])
        .chain(edges.iter().copied());
    let distances: Vec<f64> = ends
        .map(|[a, b]| {
            let at = |n: usize| 0.5 * (f64::from(u8::from(n == a)) + f64::from(u8::from(n == b)));
            phi.iter()
                .enumerate()
                .map(|(n, value)| (value - at(n)).powi(2))
                .sum()
        })
        .collect();
    let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
    (0..distances.len())
        .filter(|&n| distances[n] < least + 1e-9)
        .collect()
}

fn corners(linear: CellKind) -> usize {
    linear.point_count()
}

/// Corners of the edges that have a point in their middle, in VTK's order.
pub(super) fn edges(kind: CellKind) -> Vec<[usize; 2]> {
    match kind {
        CellKind::QuadraticTetra => vec![[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        CellKind::QuadraticPyramid => {
            vec![[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]]
        }
        CellKind::QuadraticWedge => vec![
            [0, 1],
            [1, 2],
            [2, 0],
            [3, 4],
            [4, 5],
            [5, 3],
            [0, 3],
            [1, 4],
            [2, 5],
        ],
        CellKind::QuadraticHexahedron | CellKind::TriquadraticHexahedron => vec![
            [0, 1],
            [1, 2],
            [2, 3],
            [3, 0],
            [4, 5],
            [5, 6],
            [6, 7],
            [7, 4],
            [0, 4],
            [1, 5],
            [2, 6],
            [3, 7],
        ],
        _ => Vec::new(),
    }
}

/// Shape functions of the corners and their derivatives. Cubes and wedges have coordinates 0 to 1; a pyramid is a
/// cube whose top is one point; a tetrahedron is `1 >= x >= y >= z >= 0`.
fn shape(linear: CellKind, at: DVec3) -> (Vec<f64>, Vec<DVec3>) {
    let DVec3 { x, y, z } = at;
    let product = |corner: [bool; 3]| {
        let factor = |one: bool, t: f64| if one { (t, 1.0) } else { (1.0 - t, -1.0) };
        let [(fx, dx), (fy, dy), (fz, dz)] =
            [factor(corner[0], x), factor(corner[1], y), factor(corner[2], z)];
        (fx * fy * fz, DVec3::new(dx * fy * fz, fx * dy * fz, fx * fy * dz))
    };
    let around = [[false, false], [true, false], [true, true], [false, true]];
    let base = |top: bool| around.map(|[a, b]| product([a, b, top]));
    match linear {
        CellKind::Tetra => (
            vec![1.0 - x, x - y, y - z, z],
            vec![-DVec3::X, DVec3::X - DVec3::Y, DVec3::Y - DVec3::Z, DVec3::Z],
        ),
        CellKind::Pyramid => base(false).into_iter().chain([(z, DVec3::Z)]).unzip(),
        CellKind::Wedge => {
            let triangle = [(1.0 - x, -DVec3::X), (x - y, DVec3::X - DVec3::Y), (y, DVec3::Y)];
            let level = |top: bool| {
                let (f, d) = if top { (z, DVec3::Z) } else { (1.0 - z, -DVec3::Z) };
                triangle.map(|(phi, slope)| (phi * f, slope * f + phi * d))
            };
            level(false).into_iter().chain(level(true)).unzip()
        }
        CellKind::Voxel => {
            let corner = |c: usize| product([c & 1 == 1, c >> 1 & 1 == 1, c >> 2 == 1]);
            (0..8).map(corner).unzip()
        }
        _ => base(false).into_iter().chain(base(true)).unzip(),
    }
}

/// A part in the cell's coordinates.
struct Grain {
    centre: DVec3,
    volume: f64,
    spread: DMat3,
}

fn grains(linear: CellKind) -> Vec<Grain> {
    let side = 1.0 / SIDE as f64;
    let cube = (0..SIDE * SIDE * SIDE).map(|n| {
        side * DVec3::new(
            (n % SIDE) as f64,
            (n / SIDE % SIDE) as f64,
            (n / SIDE / SIDE) as f64,
        )
    });
    match linear {
        CellKind::Tetra => cube
            .flat_map(|low| {
                let paths = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
                paths.map(|path| simplex(low, &path, side))
            })
            .filter(|grain| grain.centre.x > grain.centre.y && grain.centre.y > grain.centre.z)
            .collect(),
        CellKind::Wedge => cube
            .flat_map(|low| {
                [[0, 1], [1, 0]].map(|path| {
                    let mut grain = simplex(low, &path, side);
                    grain.centre.z += 0.5 * side;
                    grain.spread.z_axis.z = side * side / 12.0;
                    grain.volume = side.powi(3) / 2.0;
                    grain
                })
            })
            .filter(|grain| grain.centre.x > grain.centre.y)
            .collect(),
        _ => cube
            .map(|low| Grain {
                centre: low + 0.5 * side,
                volume: side.powi(3),
                spread: DMat3::from_diagonal(DVec3::splat(side * side / 12.0)),
            })
            .collect(),
    }
}

/// The simplex that goes from the low corner of a cube along its axes, one after the other.
fn simplex(low: DVec3, path: &[usize], side: f64) -> Grain {
    let mut corners = vec![low];
    for &axis in path {
        let mut next = *corners.last().unwrap_or(&low);
        next[axis] += side;
        corners.push(next);
    }
    let n = corners.len() as f64;
    let centre = corners.iter().sum::<DVec3>() / n;
    // Second moments of a simplex of n corners: the sum over its corners by n (n + 1).
    let spread = corners
        .iter()
        .fold(DMat3::ZERO, |sum, &c| sum + outer(c - centre, c - centre));
    Grain {
        centre,
        volume: side.powi(3) / 6.0,
        spread: spread * (1.0 / (n * (n + 1.0))),
    }
}
