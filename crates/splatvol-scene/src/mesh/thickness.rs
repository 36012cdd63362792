//! Thickness of the body that a mesh fills: a solid, a plate, the sheet of a can.
//!
//! By Cauchy's theorem rays cross a convex body on a mean chord of `4 V / S`, V its volume and S its surface; for a
//! plate or a shell of thickness t, `V / S = t / 2`, whatever its curvature.

use glam::DVec3;

use super::{CellKind, Mesh, Topology};

/// Most cells that are looked at; a mesh of more is not measured.
const MOST_CELLS: usize = 2_000_000;
/// Thickness, relative to the diagonal of the mesh's box, below which a mesh is a shell or plate.
const THIN: f64 = 1.0 / 32.0;

const TETRA: [&[usize]; 4] = [&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]];
const PYRAMID: [&[usize]; 5] = [&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
const WEDGE: [&[usize]; 5] = [
    &[0, 1, 2],
    &[3, 5, 4],
    &[0, 3, 4, 1],
    &[1, 4, 5, 2],
    &[2, 5, 3, 0],
];
const HEXAHEDRON: [&[usize]; 6] = [
    &[0, 4, 7, 3],
    &[1, 2, 6, 5],
    &[0, 1, 5, 4],
    &[3, 7, 6, 2],
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
];
const VOXEL: [&[usize]; 6] = [
    &[0, 2, 6, 4],
    &[1, 3, 7, 5],
    &[0, 1, 5, 4],
    &[2, 3, 7, 6],
    &[0, 1, 3, 2],
    &[4, 5, 7, 6],
];

/// Corners of each face of a cell, in order around it.
fn faces(kind: CellKind) -> &'static [&'static [usize]] {
    match kind.linear() {
        CellKind::Tetra => &TETRA,
        CellKind::Pyramid => &PYRAMID,
        CellKind::Wedge => &WEDGE,
        CellKind::Voxel => &VOXEL,
        _ => &HEXAHEDRON,
    }
}

impl Mesh {
    /// Mean thickness of a mesh that is a shell or a plate, world length; `None` for solids, and for meshes of
    /// millions of cells, which are not measured.
    pub fn shell_thickness(&self) -> Option<f64> {
        if self.cell_count() > MOST_CELLS {
            return None;
        }
        let mut measured = Measured::default();
        self.for_each_cell(|kind, corners| measured.add(kind, corners));
        let thickness = 2.0 * measured.volume / measured.surface();
        let bounds = self.bounds();
        let thin = thickness > 0.0 && thickness < THIN * (bounds.max - bounds.min).length();
        thin.then_some(thickness)
    }

    /// Calls with the kind and the points (world) of each cell that is not blanked.
    fn for_each_cell(&self, mut call: impl FnMut(CellKind, &[DVec3])) {
        let mut corners = Vec::new();
        let mut cell = |kind: CellKind, points: &mut dyn Iterator<Item = usize>| {
            corners.clear();
            let mut blanked = false;
            for point in points {
                blanked |= self.blanked.get(point) == Some(&true);
                let local = DVec3::from_array(self.positions[point].map(f64::from));
                corners.push(self.world_from_local.transform_point3(local));
            }
            if !blanked {
                call(kind, &corners);
            }
        };
        match &self.topology {
            Topology::Unstructured(cells) => {
                for (index, &kind) in cells.kinds().iter().enumerate() {
                    cell(kind, &mut cells.points(index).iter().map(|&point| point as usize));
                }
            }
            Topology::Structured(blocks) => {
                let mut first = 0;
                for &[nx, ny, nz] in blocks {
                    let steps = [1, nx, nx * ny];
                    for index in 0..(nx - 1) * (ny - 1) * (nz - 1) {
                        let [i, j, k] = [
                            index % (nx - 1),
                            index / (nx - 1) % (ny - 1),
                            index / (nx - 1) / (ny - 1),
                        ];
                        let base = first + i + nx * (j + ny * k);
                        let corner =
                            |n: usize| base + (0..3).map(|axis| (n >> axis & 1) * steps[axis]).sum::<usize>();
                        cell(CellKind::Voxel, &mut (0..8).map(corner));
                    }
                    first += nx * ny * nz;
                }
            }
        }
    }
}

/// Volume and faces of the cells so far.
#[derive(Default)]
struct Measured {
    volume: f64,
    /// Where a face is, and its area. Faces at the same place have the same key, whatever the numbers of their
    /// points: some files give each cell points of its own.
    faces: Vec<(u64, f32)>,
}

impl Measured {
    fn add(&mut self, kind: CellKind, points: &[DVec3]) {
        let count = kind.linear().point_count();
        let middle = points[..count].iter().sum::<DVec3>() / count as f64;
        for face in faces(kind) {
            let corners = face.iter().map(|&corner| points[corner]);
            let [a, b, c] = [0, 1, 2].map(|n| points[face[n]]);
            let d = points[face[face.len() - 1]];
            let area = 0.5 * (c - a).cross(d - b);
            let centre = corners.clone().sum::<DVec3>() / face.len() as f64;
            self.volume += (centre - middle).dot(area).abs() / 3.0;
            // A sum does not depend on the order of the corners.
            let key = corners.fold(0u64, |sum, corner| sum.wrapping_add(hash(corner)));
            self.faces.push((key, area.length() as f32));
        }
    }

    /// Area of the faces that belong to one cell only.
    fn surface(&mut self) -> f64 {
        self.faces
            .sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let alone = self
            .faces
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|same| same.len() == 1);
        alone.flatten().map(|&(_, area)| f64::from(area)).sum()
    }
}

/// A number for a place, by rounds of splitmix64.
fn hash(place: DVec3) -> u64 {
    place.to_array().into_iter().fold(0, |seed, coordinate| {
        let z = (seed ^ (coordinate + 0.0).to_bits()).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    })
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{Association, Cells, MeshField};

    fn mesh(positions: Vec<[f32; 3]>, topology: Topology) -> Mesh {
        let field = MeshField {
            name: "values".to_owned(),
            association: Association::Point,
            values: vec![1.0; positions.len()],
        };
        Mesh::new(positions, topology, Vec::new(), field, DAffine3::IDENTITY).unwrap()
    }

    fn block(dims: [usize; 3], spacing: [f32; 3]) -> Mesh {
        let positions = (0..dims.iter().product())
            .map(|i: usize| {
                let at = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
                std::array::from_fn(|axis| at[axis] as f32 * spacing[axis])
            })
            .collect();
        mesh(positions, Topology::Structured(vec![dims]))
    }

    #[test]
    fn a_plate_has_its_thickness_and_a_solid_has_none() {
        let thickness = block([21, 21, 4], [1.0, 1.0, 0.1]).shell_thickness().unwrap();
        // Its narrow sides count a little.
        assert!((thickness - 0.3).abs() < 0.02, "{thickness}");
        assert_eq!(block([5; 3], [1.0; 3]).shell_thickness(), None);
        assert_eq!(block([2; 3], [1.0; 3]).shell_thickness(), None);
    }

    #[test]
    fn a_tube_of_cells_with_points_of_their_own_is_a_shell() {
        let (mut positions, mut cells) = (Vec::new(), Cells::default());
        let ring = |step: usize, radius: f32, z: f32| {
            let angle = (step % 40) as f32 * std::f32::consts::TAU / 40.0;
            [radius * angle.cos(), radius * angle.sin(), z]
        };
        for step in 0..40 {
            for layer in 0..10 {
                let first = positions.len() as u32;
                for z in [layer, layer + 1].map(|z| z as f32) {
                    positions.extend([
                        ring(step, 5.0, z),
                        ring(step, 5.1, z),
                        ring(step + 1, 5.1, z),
                        ring(step + 1, 5.0, z),
                    ]);
                }
                let points: Vec<u32> = (first..first + 8).collect();
                cells.push(CellKind::Hexahedron, &points).unwrap();
            }
        }
        let thickness = mesh(positions, Topology::Unstructured(cells))
            .shell_thickness()
            .unwrap();
        assert!((thickness - 0.1).abs() < 0.005, "{thickness}");
    }

    #[test]
    fn every_kind_of_cell_is_measured_as_what_it_is() {
        let corner = [0.0, 1.0];
        let cube = |order: [usize; 8]| {
            order
                .map(|n| DVec3::new(corner[n & 1], corner[n >> 1 & 1], corner[n >> 2]))
                .to_vec()
        };
        let cases = [
            (CellKind::Voxel, cube([0, 1, 2, 3, 4, 5, 6, 7]), 1.0, 6.0),
            (CellKind::Hexahedron, cube([0, 1, 3, 2, 4, 5, 7, 6]), 1.0, 6.0),
            (
                CellKind::Wedge,
                cube([0, 1, 2, 4, 5, 6, 0, 0]),
                0.5,
                3.0 + 2f64.sqrt(),
            ),
            (
                CellKind::Pyramid,
                cube([0, 1, 3, 2, 4, 0, 0, 0]),
                1.0 / 3.0,
                2.0 + 2f64.sqrt(),
            ),
            (
                CellKind::Tetra,
                cube([0, 1, 2, 4, 0, 0, 0, 0]),
                1.0 / 6.0,
                1.5 + 0.75f64.sqrt(),
            ),
        ];
        for (kind, points, volume, surface) in cases {
            let mut measured = Measured::default();
            measured.add(kind, &points);
            assert!(
                (measured.volume - volume).abs() < 1e-12,
                "{kind:?} {}",
                measured.volume
            );
            assert!((measured.surface() - surface).abs() < 1e-6, "{kind:?}");
        }
    }
}
