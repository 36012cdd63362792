//! The selected item as it is shown, if it is a volume; of one that is read in chunks its overview.

use splatvol::glam::DAffine3;
use splatvol::{Item, TransferFunction, Volume};
use splatvol_document::keys::ItemKeys;

use super::{Model, store};

/// A volume that is shown.
#[derive(Clone, Copy)]
pub struct ShownVolume<'a> {
    item: &'a Item,
    keys: &'a ItemKeys,
    /// Its samples, or an overview of them.
    pub volume: &'a Volume,
    /// Its look.
    pub function: &'a TransferFunction,
}

impl<'a> ShownVolume<'a> {
    /// The item with this number, if it is a volume that is shown.
    pub fn of(model: &'a Model, index: usize) -> Option<Self> {
        let items = &model.document().items;
        let keys = items.get(index).filter(|keys| keys.is_visible())?;
        let before = items[..index].iter().filter(|keys| keys.is_visible()).count();
        let item = model.shown()?.scene.items.get(before)?;
        let shown = item.as_volume()?;
        Some(Self {
            item,
            keys,
            volume: shown.volume,
            function: shown.transfer_function,
        })
    }

    /// The keys by which it was read: equal keys, equal samples.
    pub fn source(&self) -> ItemKeys {
        store::reading_keys(self.keys)
    }

    /// From voxels to the world.
    pub fn world_from_voxel(&self) -> DAffine3 {
        self.item.world_from_item * self.volume.grid().world_from_voxel()
    }

    /// The sample of a voxel.
    ///
    /// # Panics
    /// Voxels outside the grid.
    pub fn value(&self, voxel: [usize; 3]) -> f64 {
        value(self.volume, voxel)
    }
}

/// The sample of a voxel.
pub(super) fn value(volume: &Volume, [x, y, z]: [usize; 3]) -> f64 {
    let dims = volume.grid().dims();
    volume.value((z * dims[1] + y) * dims[0] + x)
}
