//! A file as a thing of a scene.

use std::path::Path;

use splatvol_scene::{Item, PointLook};

use crate::error::Context;
use crate::{Data, DataOptions, IoError, read_data};

/// Reads a file or folder of any supported format as a thing to look at: volumes and meshes get a transfer function
/// that is chosen from their values ([`Item::automatic`]), points their own colours.
///
/// [`read_data`] also reports oddities of the file, and can choose among its contents.
///
/// # Errors
/// See [`IoError`].
pub fn read_item(path: impl AsRef<Path>) -> Result<Item, IoError> {
    let path = path.as_ref();
    Ok(match read_data(path, &DataOptions::default())?.data {
        Data::Volume(volume) => Item::automatic(volume),
        Data::Points(points) => Item::points(points, PointLook::default()),
        Data::Gaussians(gaussians) => Item::gaussians(gaussians),
        Data::Mesh(mesh) => {
            let item = Item::automatic_mesh(mesh);
            item.map_err(|source| Context::new("mesh", path).scene(source))?
        }
    })
}

#[cfg(test)]
mod tests {
    use splatvol_scene::Content;

    use super::*;

    #[test]
    fn any_file_becomes_an_item() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.txt");
        std::fs::write(&path, "0 0 0\n1 2 3\n").unwrap();
        let item = read_item(&path).unwrap();
        item.validate().unwrap();
        assert!(matches!(item.content, Content::Points { points, .. } if points.len() == 2));
        let error = read_item(folder.path().join("none.nrrd")).unwrap_err();
        assert!(error.to_string().ends_with("none.nrrd"), "{error}");
    }
}
