use glam::DVec3;

use super::*;

fn tetra() -> (Vec<[f32; 3]>, Cells) {
    let mut cells = Cells::default();
    cells.push(CellKind::Tetra, &[0, 1, 2, 3]).unwrap();
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
    (corners, cells)
}

fn field(association: Association, values: Vec<f32>) -> MeshField {
    MeshField {
        name: "T".to_owned(),
        association,
        values,
    }
}

#[test]
fn a_mesh_knows_its_range_bounds_and_cells() {
    let (positions, cells) = tetra();
    let values = field(Association::Point, vec![3.0, f32::NAN, -1.0, 2.0]);
    let frame = DAffine3::from_translation(DVec3::new(1e6, 0.0, 0.0));
    let mesh = Mesh::new(positions, Topology::Unstructured(cells), vec![], values, frame).unwrap();
    assert_eq!(mesh.value_range(), [-1.0, 3.0]);
    assert_eq!(mesh.bounds().max, DVec3::new(1_000_001.0, 1.0, 2.0));
    assert_eq!(mesh.cell_count(), 1);
    let lattice: Vec<[f32; 3]> = (0..24).map(|i| [i as f32, 0.0, 0.0]).collect();
    let values = field(Association::Cell, (0..7).map(|i| i as f32).collect());
    let topology = Topology::Structured(vec![[2, 2, 2], [2, 2, 4]]);
    let refused = Mesh::new(lattice.clone(), topology, vec![], values, DAffine3::IDENTITY).unwrap_err();
    assert!(refused.to_string().contains("(7, 4)"), "{refused}");
    let values = field(Association::Cell, vec![0.0; 4]);
    let topology = Topology::Structured(vec![[2, 2, 2], [2, 2, 4]]);
    let mesh = Mesh::new(lattice, topology, vec![], values, DAffine3::IDENTITY).unwrap();
    assert_eq!(mesh.cell_count(), 4);
}

#[test]
fn what_cannot_be_a_mesh_is_refused_by_name() {
    let refused = |topology: Topology, values: Vec<f32>, words: &str| {
        let (positions, _) = tetra();
        let values = field(Association::Point, values);
        let text = Mesh::new(positions, topology, vec![], values, DAffine3::IDENTITY)
            .unwrap_err()
            .to_string();
        assert!(text.contains(words), "{text}");
    };
    let solid = || Topology::Unstructured(tetra().1);
    refused(solid(), vec![0.0; 3], "mesh values");
    refused(solid(), vec![f32::INFINITY; 4], "mesh value");
    refused(solid(), vec![f32::NAN; 4], "no finite sample");
    refused(Topology::Unstructured(Cells::default()), vec![0.0; 4], "cells");
    let mut far = Cells::default();
    far.push(CellKind::Tetra, &[0, 1, 2, 4]).unwrap();
    refused(Topology::Unstructured(far), vec![0.0; 4], "point of a cell");
    refused(Topology::Structured(vec![[4, 1, 1]]), vec![0.0; 4], "mesh dims");
    refused(Topology::Structured(vec![[2, 2, 2]]), vec![0.0; 4], "mesh dims");
    refused(
        Topology::Structured(vec![[usize::MAX; 3]]),
        vec![0.0; 4],
        "mesh dims",
    );
    assert!(Cells::default().push(CellKind::Wedge, &[0; 5]).is_err());
}

#[test]
fn kinds_and_codes_belong_to_each_other() {
    for kind in CellKind::ALL {
        assert_eq!(CellKind::from_vtk(kind.vtk_code()), Some(kind));
        assert!(kind.linear().point_count() <= kind.point_count());
    }
    assert_eq!(CellKind::from_vtk(5), None);
}
