//! Items whose look is chosen from their values.

use std::sync::Arc;

use crate::{Content, Item, Mesh, SceneError, TransferFunction, ValueKind, Volume};

impl Item {
    /// A volume with the transfer function of [`TransferFunction::automatic`]; label maps are taken as
    /// [`Item::labels`].
    pub fn automatic(volume: impl Into<Arc<Volume>>) -> Self {
        let volume = volume.into();
        let (transfer_function, choice) = TransferFunction::automatic(&volume, None);
        match choice.kind {
            ValueKind::Labels => Self::labels(volume, transfer_function),
            _ => Self::volume(volume, transfer_function),
        }
    }

    /// A mesh with the transfer function of [`TransferFunction::automatic_mesh`].
    ///
    /// # Errors
    /// More values than a [`Grid`](crate::Grid) can have rows for: some two thousand million.
    pub fn automatic_mesh(mesh: impl Into<Arc<Mesh>>) -> Result<Self, SceneError> {
        let mesh = mesh.into();
        let (transfer_function, _) = TransferFunction::automatic_mesh(&mesh, None)?;
        Ok(Self::new(Content::Mesh {
            mesh,
            transfer_function,
            isosurfaces: Vec::new(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{Association, Grid, LengthUnit, MeshField, Rescale, Samples, Topology};

    fn volume(value: impl Fn([usize; 3]) -> u8) -> Volume {
        let dims = [16; 3];
        let at = |i: usize| [i % 16, i / 16 % 16, i / 256];
        Volume::new(
            Grid::centred(dims, [1.0; 3]).unwrap(),
            Samples::U8((0..4096).map(|i| value(at(i))).collect()),
            Rescale::default(),
            LengthUnit::Unknown,
        )
        .unwrap()
    }

    fn is_labels(item: &Item) -> bool {
        matches!(item.content, Content::Volume { labels: true, .. })
    }

    #[test]
    fn names_become_labels_and_numbers_do_not() {
        let names = volume(|[x, y, _]| 3 * u8::from(x > 7) + u8::from(y > 7));
        assert!(is_labels(&Item::automatic(names)));
        let numbers = volume(|[x, y, z]| (x * 7 + y * 5 + z * 3) as u8);
        assert!(!is_labels(&Item::automatic(numbers)));
    }

    #[test]
    fn a_mesh_is_surveyed_by_its_values() {
        let positions = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|at| at as f32));
        let field = MeshField {
            name: "height".to_owned(),
            association: Association::Point,
            values: (0..27).map(|i| 0.37 * i as f32).collect(),
        };
        let blocks = Topology::Structured(vec![[3; 3]]);
        let mesh = Mesh::new(positions.collect(), blocks, Vec::new(), field, DAffine3::IDENTITY);
        let item = Item::automatic_mesh(mesh.unwrap()).unwrap();
        item.validate().unwrap();
        let Content::Mesh {
            transfer_function, ..
        } = item.content
        else {
            panic!("no mesh");
        };
        let opacities = transfer_function.opacities();
        assert!(opacities.iter().any(|point| point.opacity > 0.0));
    }
}
