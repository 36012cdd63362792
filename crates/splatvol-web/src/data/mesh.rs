//! Meshes as bytes.

use serde::{Deserialize, Serialize};
use splatvol::SceneError;
use splatvol::mesh::{Association, CellKind, Cells, Mesh, MeshField, Topology};

use super::column::{Column, Packer, Precision};
use super::points::{affine, columns, counted};

/// The columns of a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct MeshData {
    /// Number of points.
    pub count: usize,
    /// World from local: images of the three axes, and of the origin.
    pub world_from_local: [[f64; 3]; 4],
    positions: [Column; 3],
    /// How points are connected.
    pub cells: CellsData,
    /// One for each point: 1 for those that are not part of the grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    blanked: Option<Column>,
    /// Name of the values.
    name: String,
    of_cells: bool,
    value_count: usize,
    values: Column,
}

/// How points are connected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum CellsData {
    /// Points of blocks along i, j, k.
    Blocks(Vec<[usize; 3]>),
    /// Cells that list their points.
    #[serde(rename_all = "kebab-case")]
    Listed {
        /// Number of cells.
        count: usize,
        /// VTK's numbers of their kinds.
        kinds: Column,
        /// Points of all cells, one after the other.
        point_count: usize,
        /// Their numbers.
        points: Column,
    },
}

impl MeshData {
    /// Packs a mesh; returns its bytes, too.
    pub fn pack(mesh: &Mesh, precision: Precision) -> (Self, Vec<u8>) {
        let mut packer = Packer::default();
        let MeshField {
            name,
            association,
            values,
        } = mesh.field();
        let blanked = mesh.blanked();
        let some_are_missing = values.iter().any(|value| value.is_nan());
        let data = Self {
            count: mesh.positions().len(),
            world_from_local: columns(mesh.world_from_local()),
            positions: packer.vectors(mesh.positions(), |packer, values| {
                packer.even(values, precision.places)
            }),
            cells: CellsData::pack(mesh.topology(), &mut packer),
            blanked: (!blanked.is_empty()).then(|| packer.whole(blanked.iter().map(|&is| u32::from(is)))),
            name: name.clone(),
            of_cells: *association == Association::Cell,
            value_count: values.len(),
            values: match some_are_missing {
                true => packer.bits(values.iter().copied()),
                false => packer.even(values.iter().copied(), precision.rest),
            },
        };
        (data, packer.bytes)
    }

    /// Takes a mesh from the front of bytes.
    ///
    /// # Errors
    /// Too few bytes, and numbers that are no mesh.
    pub fn unpack(&self, bytes: &mut &[u8]) -> Result<Mesh, SceneError> {
        let count = counted(self.count, bytes)?;
        let positions = Column::vectors(&self.positions, count, bytes)?;
        let topology = self.cells.unpack(bytes)?;
        let blanked = match &self.blanked {
            Some(column) => column
                .whole(count, bytes)?
                .into_iter()
                .map(|is| is != 0)
                .collect(),
            None => Vec::new(),
        };
        let most = match &topology {
            Topology::Unstructured(cells) => cells.len().max(count),
            Topology::Structured(_) => count,
        };
        if self.value_count > most {
            let counts = (self.value_count, most);
            return Err(SceneError::invalid(
                "values",
                counts,
                "one for each point or cell",
            ));
        }
        let field = MeshField {
            name: self.name.clone(),
            association: if self.of_cells {
                Association::Cell
            } else {
                Association::Point
            },
            values: self.values.numbers(self.value_count, bytes)?,
        };
        Mesh::new(positions, topology, blanked, field, affine(self.world_from_local))
    }
}

impl CellsData {
    fn pack(topology: &Topology, packer: &mut Packer) -> Self {
        let cells = match topology {
            Topology::Structured(blocks) => return Self::Blocks(blocks.clone()),
            Topology::Unstructured(cells) => cells,
        };
        let kinds = cells.kinds().iter().map(|kind| u32::from(kind.vtk_code()));
        let points: Vec<u32> = (0..cells.len())
            .flat_map(|cell| cells.points(cell))
            .copied()
            .collect();
        Self::Listed {
            count: cells.len(),
            kinds: packer.whole(kinds),
            point_count: points.len(),
            points: packer.whole(points.iter().copied()),
        }
    }

    fn unpack(&self, bytes: &mut &[u8]) -> Result<Topology, SceneError> {
        let (count, kinds, point_count, points) = match self {
            Self::Blocks(blocks) => return Ok(Topology::Structured(blocks.clone())),
            Self::Listed {
                count,
                kinds,
                point_count,
                points,
            } => (*count, kinds, *point_count, points),
        };
        // A cell has points, and these take bytes.
        let kinds = kinds.whole(counted(count, bytes)?, bytes)?;
        let points = points.whole(counted(point_count, bytes)?, bytes)?;
        let mut cells = Cells::default();
        let mut rest = &points[..];
        for code in kinds {
            let kind = u8::try_from(code).ok().and_then(CellKind::from_vtk);
            let kind =
                kind.ok_or_else(|| SceneError::invalid("kind of a cell", code, "one of VTK's solids"))?;
            let own = rest.split_off(..kind.point_count());
            let own =
                own.ok_or_else(|| SceneError::invalid("points of cells", point_count, "more of them"))?;
            cells.push(kind, own)?;
        }
        Ok(Topology::Unstructured(cells))
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    const FINE: Precision = Precision { places: 24, rest: 16 };

    fn positions(count: usize) -> Vec<[f32; 3]> {
        (0..count)
            .map(|i| [(i % 4) as f32, (i / 4 % 3) as f32, (i / 12) as f32 * 0.5])
            .collect()
    }

    fn blocks() -> Mesh {
        let field = MeshField {
            name: "p".to_owned(),
            association: Association::Point,
            values: (0..48)
                .map(|i| if i == 9 { f32::NAN } else { i as f32 * 0.3 })
                .collect(),
        };
        let blanked = (0..48).map(|i| i == 5).collect();
        let topology = Topology::Structured(vec![[4, 3, 2], [4, 3, 2]]);
        Mesh::new(positions(48), topology, blanked, field, DAffine3::IDENTITY).unwrap()
    }

    fn listed() -> Mesh {
        let mut cells = Cells::default();
        cells.push(CellKind::Tetra, &[0, 1, 4, 12]).unwrap();
        cells.push(CellKind::Wedge, &[1, 2, 5, 13, 14, 17]).unwrap();
        let field = MeshField {
            name: "q".to_owned(),
            association: Association::Cell,
            values: vec![-2.0, 9.0],
        };
        let topology = Topology::Unstructured(cells);
        Mesh::new(
            positions(24),
            topology,
            Vec::new(),
            field,
            DAffine3::from_scale([2.0; 3].into()),
        )
        .unwrap()
    }

    #[test]
    fn meshes_come_back() {
        for mesh in [blocks(), listed()] {
            let (data, bytes) = MeshData::pack(&mesh, FINE);
            let data: MeshData = serde_json::from_str(&serde_json::to_string(&data).unwrap()).unwrap();
            let mut rest = &bytes[..];
            let again = data.unpack(&mut rest).unwrap();
            assert!(rest.is_empty());
            assert_eq!(
                (again.topology(), again.blanked(), again.world_from_local()),
                (mesh.topology(), mesh.blanked(), mesh.world_from_local())
            );
            assert_eq!(
                (&again.field().name, again.field().association),
                (&mesh.field().name, mesh.field().association)
            );
            let values = again.field().values.iter().zip(&mesh.field().values);
            assert!(
                values
                    .clone()
                    .all(|(a, b)| (a - b).abs() < 2e-4 || a.is_nan() && b.is_nan())
            );
            let places = again
                .positions()
                .iter()
                .flatten()
                .zip(mesh.positions().iter().flatten());
            assert!(places.clone().all(|(a, b)| (a - b).abs() < 1e-6));
        }
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        for mesh in [blocks(), listed()] {
            let (data, bytes) = MeshData::pack(&mesh, FINE);
            for short in 0..bytes.len() {
                assert!(data.unpack(&mut &bytes[..short]).is_err());
            }
            let refused = |change: fn(&mut MeshData)| {
                let mut data = data.clone();
                change(&mut data);
                data.unpack(&mut &bytes[..]).is_err()
            };
            assert!(refused(|data| data.value_count = usize::MAX));
            assert!(refused(|data| data.count = usize::MAX));
            assert!(refused(|data| match &mut data.cells {
                CellsData::Blocks(blocks) => blocks[0] = [usize::MAX; 3],
                CellsData::Listed { point_count, .. } => *point_count = usize::MAX,
            }));
        }
    }
}
