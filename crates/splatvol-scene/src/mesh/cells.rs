//! Cells of an unstructured mesh, in the point order of VTK's file formats.

use crate::SceneError;

/// The solid cells. Quadratic ones list the midpoints of their edges after their corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CellKind {
    /// Four corners.
    Tetra,
    /// Four corners of the base, the apex.
    Pyramid,
    /// A triangle, and the opposite one.
    Wedge,
    /// A quadrilateral, and the opposite one.
    Hexahedron,
    /// A box, x fastest.
    Voxel,
    /// Ten points.
    QuadraticTetra,
    /// Thirteen points.
    QuadraticPyramid,
    /// Fifteen points.
    QuadraticWedge,
    /// Twenty points.
    QuadraticHexahedron,
    /// Twenty-seven points: also in the middle of the faces and of the cell.
    TriquadraticHexahedron,
}

impl CellKind {
    /// All kinds of cells.
    pub const ALL: [Self; 10] = [
        Self::Tetra,
        Self::Pyramid,
        Self::Wedge,
        Self::Hexahedron,
        Self::Voxel,
        Self::QuadraticTetra,
        Self::QuadraticPyramid,
        Self::QuadraticWedge,
        Self::QuadraticHexahedron,
        Self::TriquadraticHexahedron,
    ];

    /// The kind of a VTK cell type; `None` for cells that are not solid, or not known.
    pub fn from_vtk(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.vtk_code() == code)
    }

    /// VTK's number for it.
    pub fn vtk_code(self) -> u8 {
        match self {
            Self::Tetra => 10,
            Self::Voxel => 11,
            Self::Hexahedron => 12,
            Self::Wedge => 13,
            Self::Pyramid => 14,
            Self::QuadraticTetra => 24,
            Self::QuadraticHexahedron => 25,
            Self::QuadraticWedge => 26,
            Self::QuadraticPyramid => 27,
            Self::TriquadraticHexahedron => 29,
        }
    }

    /// Points of such a cell.
    pub fn point_count(self) -> usize {
        match self {
            Self::Tetra => 4,
            Self::Pyramid => 5,
            Self::Wedge => 6,
            Self::Hexahedron | Self::Voxel => 8,
            Self::QuadraticTetra => 10,
            Self::QuadraticPyramid => 13,
            Self::QuadraticWedge => 15,
            Self::QuadraticHexahedron => 20,
            Self::TriquadraticHexahedron => 27,
        }
    }

    /// The kind of its corners alone.
    pub fn linear(self) -> Self {
        match self {
            Self::QuadraticTetra => Self::Tetra,
            Self::QuadraticPyramid => Self::Pyramid,
            Self::QuadraticWedge => Self::Wedge,
            Self::QuadraticHexahedron | Self::TriquadraticHexahedron => Self::Hexahedron,
            other => other,
        }
    }

    /// `tetra`, `quadratic hexahedron`...
    pub fn name(self) -> &'static str {
        match self {
            Self::Tetra => "tetra",
            Self::Pyramid => "pyramid",
            Self::Wedge => "wedge",
            Self::Hexahedron => "hexahedron",
            Self::Voxel => "voxel",
            Self::QuadraticTetra => "quadratic tetra",
            Self::QuadraticPyramid => "quadratic pyramid",
            Self::QuadraticWedge => "quadratic wedge",
            Self::QuadraticHexahedron => "quadratic hexahedron",
            Self::TriquadraticHexahedron => "triquadratic hexahedron",
        }
    }
}

/// Cells and the indices of their points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cells {
    kinds: Vec<CellKind>,
    /// Offset of each cell's first point; one more entry than cells.
    offsets: Vec<u32>,
    connectivity: Vec<u32>,
}

impl Cells {
    /// Adds a cell.
    ///
    /// # Errors
    /// A number of points that is not that of its kind, or more points in all than 32 bits can count.
    pub fn push(&mut self, kind: CellKind, points: &[u32]) -> Result<(), SceneError> {
        if points.len() != kind.point_count() {
            let found = (kind.name(), points.len());
            return Err(SceneError::invalid(
                "points of a cell",
                found,
                "the number that its kind has",
            ));
        }
        let end = u32::try_from(self.connectivity.len() + points.len())
            .map_err(|_| SceneError::invalid("cells", self.kinds.len(), "fewer than 2^32 points of cells"))?;
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.kinds.push(kind);
        self.offsets.push(end);
        self.connectivity.extend_from_slice(points);
        Ok(())
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// True where there are none.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Kind of cell `index`.
    pub fn kind(&self, index: usize) -> CellKind {
        self.kinds[index]
    }

    /// Kinds of all cells.
    pub fn kinds(&self) -> &[CellKind] {
        &self.kinds
    }

    /// Points of cell `index`.
    pub fn points(&self, index: usize) -> &[u32] {
        &self.connectivity[self.offsets[index] as usize..self.offsets[index + 1] as usize]
    }

    /// Refuses indices beyond a number of points; the number of cells.
    pub(super) fn check(&self, points: usize) -> Result<usize, SceneError> {
        if self.is_empty() {
            return Err(SceneError::invalid("cells", 0, "at least one solid cell"));
        }
        match self.connectivity.iter().find(|&&index| index as usize >= points) {
            Some(index) => Err(SceneError::invalid(
                "point of a cell",
                (index, points),
                "an index below the number of points",
            )),
            None => Ok(self.len()),
        }
    }
}
