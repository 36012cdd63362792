//! Meshes: one scalar on points or cells that do not form a regular grid.
//!
//! Structured blocks (rectilinear and curvilinear grids, one or several) know their neighbours by index;
//! unstructured cells list their points in VTK's order. Coordinates are *local*, in 32 bits, as those of
//! [`crate::Points`].

mod cells;
mod thickness;

use glam::DAffine3;

pub use cells::{CellKind, Cells};

use crate::points::{bounds_of, check_finite, check_frame, check_length};
use crate::volume::histogram;
use crate::{Bounds, SceneError};

/// Whether a mesh has its values at the points or at the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Association {
    /// One value per point; between points it is interpolated.
    Point,
    /// One value per cell.
    Cell,
}

/// Connectivity of the points.
#[derive(Debug, Clone, PartialEq)]
pub enum Topology {
    /// Blocks of points along i, j, k (i fastest), one block after the other. Neighbouring points span hexahedra.
    Structured(Vec<[usize; 3]>),
    /// Cells that list their points.
    Unstructured(Cells),
}

/// The scalar of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshField {
    /// Name, as in the file.
    pub name: String,
    /// Whether the values belong to the points or to the cells.
    pub association: Association,
    /// One value each; NaN where it is missing.
    pub values: Vec<f32>,
}

/// A scalar on an irregular grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    world_from_local: DAffine3,
    positions: Vec<[f32; 3]>,
    topology: Topology,
    blanked: Vec<bool>,
    field: MeshField,
    value_range: [f32; 2],
    bounds: Bounds,
}

impl Mesh {
    /// A mesh of points at local positions. `blanked` marks points that are not part of the grid (IBLANK), or is
    /// empty.
    ///
    /// # Errors
    /// No cells or points; a block with fewer than two points along an axis; numbers of points, values or marks that do
    /// not fit each other; positions that are not finite; a value that is infinite; no finite value; or a
    /// `world_from_local` that cannot be inverted.
    pub fn new(
        positions: Vec<[f32; 3]>,
        topology: Topology,
        blanked: Vec<bool>,
        field: MeshField,
        world_from_local: DAffine3,
    ) -> Result<Self, SceneError> {
        check_frame(&world_from_local)?;
        check_finite("mesh position", &positions)?;
        check_length("blanked points", blanked.len(), positions.len())?;
        let cell_count = topology.check(positions.len())?;
        let expected = match field.association {
            Association::Point => positions.len(),
            Association::Cell => cell_count,
        };
        if field.values.len() != expected {
            let counts = (field.values.len(), expected);
            return Err(SceneError::invalid(
                "mesh values",
                counts,
                "one per point or cell",
            ));
        }
        let value_range = range_of(&field.values)?;
        let bounds = bounds_of(&positions, &world_from_local)?;
        Ok(Self {
            world_from_local,
            positions,
            topology,
            blanked,
            field,
            value_range,
            bounds,
        })
    }

    /// Local space to world.
    pub fn world_from_local(&self) -> &DAffine3 {
        &self.world_from_local
    }

    /// Places of the points, local.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Connectivity of the points.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// True for points that are not part of the grid; empty where all are.
    pub fn blanked(&self) -> &[bool] {
        &self.blanked
    }

    /// The scalar.
    pub fn field(&self) -> &MeshField {
        &self.field
    }

    /// Least and greatest value; missing ones are passed over.
    pub fn value_range(&self) -> [f32; 2] {
        self.value_range
    }

    /// Counts of the values in `bins` equal bins over [`Mesh::value_range`]; missing ones are passed over.
    pub fn histogram(&self, bins: usize) -> Vec<u64> {
        let values = self.field.values.iter().copied().map(f64::from);
        histogram(values, self.value_range.map(f64::from), bins)
    }

    /// Distance of the points if they filled the box evenly, world.
    pub fn mean_spacing(&self) -> f64 {
        let size = self.bounds.max - self.bounds.min;
        libm::cbrt(size.x * size.y * size.z / self.positions.len() as f64)
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        match &self.topology {
            Topology::Structured(blocks) => blocks.iter().map(|dims| cells_of(*dims)).sum(),
            Topology::Unstructured(cells) => cells.len(),
        }
    }

    /// Box of the points, world.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// This mesh with another placement.
    ///
    /// # Errors
    /// A `world_from_local` that cannot be inverted.
    pub fn placed(self, world_from_local: DAffine3) -> Result<Self, SceneError> {
        check_frame(&world_from_local)?;
        let bounds = bounds_of(&self.positions, &world_from_local)?;
        Ok(Self {
            world_from_local,
            bounds,
            ..self
        })
    }
}

impl Topology {
    /// Checks it against a number of points; the number of cells.
    fn check(&self, points: usize) -> Result<usize, SceneError> {
        match self {
            Self::Unstructured(cells) => cells.check(points),
            Self::Structured(blocks) => {
                let mut total = 0usize;
                for dims in blocks {
                    if dims.iter().any(|&size| size < 2) {
                        return Err(SceneError::invalid(
                            "mesh dims",
                            dims,
                            "at least 2 points along each axis",
                        ));
                    }
                    let count = dims
                        .iter()
                        .try_fold(1usize, |product, &size| product.checked_mul(size));
                    total = count
                        .and_then(|count| total.checked_add(count))
                        .filter(|&total| total <= points)
                        .ok_or_else(|| {
                            SceneError::invalid("mesh dims", dims, "as many points as there are")
                        })?;
                }
                if total != points || blocks.is_empty() {
                    let counts = (total, points);
                    return Err(SceneError::invalid(
                        "mesh dims",
                        counts,
                        "as many points as there are",
                    ));
                }
                Ok(blocks.iter().map(|dims| cells_of(*dims)).sum())
            }
        }
    }
}

fn cells_of(dims: [usize; 3]) -> usize {
    dims.iter().map(|size| size - 1).product()
}

fn range_of(values: &[f32]) -> Result<[f32; 2], SceneError> {
    if let Some(value) = values.iter().find(|value| value.is_infinite()) {
        return Err(SceneError::invalid(
            "mesh value",
            value,
            "finite, or NaN where it is missing",
        ));
    }
    let range = values
        .iter()
        .filter(|value| !value.is_nan())
        .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &value| {
            [low.min(value), high.max(value)]
        });
    if range[0] > range[1] {
        return Err(SceneError::NoFiniteSample { count: values.len() });
    }
    Ok(range)
}

#[cfg(test)]
mod tests;
