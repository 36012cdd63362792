//! Data of items as bytes, packed so that they compress well.
//!
//! | module | holds |
//! |---|---|
//! | `planes` | numbers as planes of bytes: first the lowest byte of each, then the next |
//! | `volume` | samples of volumes, as they are |
//! | `column` | numbers of clouds, rounded to so many bits |
//! | `points`, `gaussians`, `mesh` | clouds, a column for each component of an attribute |

mod column;
mod gaussians;
mod mesh;
mod planes;
mod points;
mod volume;

use serde::{Deserialize, Serialize};
use splatvol::SceneError;
use splatvol_document::{Held, HeldContent};
use splatvol_io::{Data, Description};

use crate::message::Described;

pub use column::{Column, Precision};
pub use gaussians::GaussiansData;
pub use mesh::{CellsData, MeshData};
pub use points::PointsData;
pub use volume::VolumeData;

/// The data of an item without their numbers, and how these are packed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ItemData {
    /// Samples on a regular grid.
    Volume(VolumeData),
    /// Samples of surfaces.
    Points(PointsData),
    /// 3-D Gaussians.
    Gaussians(GaussiansData),
    /// Samples on an irregular grid.
    Mesh(MeshData),
}

impl ItemData {
    /// Packs data, clouds in a precision, volumes as they are; returns their bytes, too.
    pub fn pack(content: &HeldContent, precision: Precision) -> (Self, Vec<u8>) {
        match content {
            HeldContent::Volume(volume) => {
                let data = VolumeData::of(volume, false);
                let bytes = data.pack(volume);
                (Self::Volume(data), bytes)
            }
            HeldContent::Points(points) => {
                let (data, bytes) = PointsData::pack(points, precision);
                (Self::Points(data), bytes)
            }
            HeldContent::Gaussians(gaussians) => {
                let (data, bytes) = GaussiansData::pack(gaussians, precision);
                (Self::Gaussians(data), bytes)
            }
            HeldContent::Mesh(mesh) => {
                let (data, bytes) = MeshData::pack(mesh, precision);
                (Self::Mesh(data), bytes)
            }
        }
    }

    /// Takes what belongs to it from the front of packed numbers, and makes the data of them.
    ///
    /// # Errors
    /// Bytes that are too few, and numbers that are no such data.
    pub fn unpack(&self, bytes: &mut &[u8]) -> Result<Data, SceneError> {
        match self {
            Self::Volume(data) => {
                let count = data.byte_count().and_then(|count| bytes.split_off(..count));
                let own = count.ok_or_else(|| planes::too_few("samples", bytes.len()))?;
                data.unpack(own).map(Data::Volume)
            }
            Self::Points(data) => data.unpack(bytes).map(Data::Points),
            Self::Gaussians(data) => data.unpack(bytes).map(Data::Gaussians),
            Self::Mesh(data) => data.unpack(bytes).map(Data::Mesh),
        }
    }
}

/// Data for a document whose items are in memory: they stand as they are, whatever it leaves open.
pub fn held(content: HeldContent) -> Held {
    held_as(
        content,
        Described {
            format: "memory".to_owned(),
            oriented: true,
        },
    )
}

/// The same of data that stand as their file says.
pub(crate) fn held_as(content: HeldContent, described: Described) -> Held {
    let Described { format, oriented } = described;
    let description = Description {
        format,
        oriented,
        ..Description::default()
    };
    Held::sharing(content, description)
}

/// What data are, and how much of them: `64 × 64 × 40 samples`, `34820 points`.
pub fn size_of(content: &HeldContent) -> String {
    match content {
        HeldContent::Volume(volume) => {
            let [x, y, z] = volume.finest_grid().dims();
            format!("{x} × {y} × {z} samples")
        }
        HeldContent::Mesh(mesh) => format!("{} cells, {} points", mesh.cell_count(), mesh.positions().len()),
        HeldContent::Points(points) => format!("{} points", points.len()),
        HeldContent::Gaussians(gaussians) => {
            format!(
                "{} Gaussians, harmonics of degree {}",
                gaussians.len(),
                gaussians.degree()
            )
        }
    }
}
