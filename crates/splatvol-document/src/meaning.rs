//! Which keys of an item have a meaning for which kind of data.

use splatvol_io::DataKind;

use crate::DocumentError;
use crate::keys::{ItemKeys, Opacity};

/// Refuses keys that cannot apply to the kind of data, by name.
///
/// # Errors
/// The first such key.
pub fn check(item: &ItemKeys, kind: DataKind) -> Result<(), DocumentError> {
    let known = known_keys(kind);
    let given = [
        ("dims", item.dims.is_some()),
        ("type", item.sample_type.is_some()),
        ("spacing", item.spacing.is_some()),
        ("endian", item.endian.is_some()),
        ("offset", item.offset.is_some()),
        ("array", item.array.is_some()),
        ("component", item.component.is_some()),
        ("channel", item.channel.is_some()),
        ("time", item.time.is_some()),
        ("level", item.level.is_some()),
        ("series", item.series.is_some()),
        ("solution", item.solution.is_some()),
        ("drape", item.drape.is_some()),
        ("posts", item.posts.is_some()),
        ("tf", item.tf.is_some()),
        ("transfer-function", item.transfer_function.is_some()),
        ("cmap", item.cmap.is_some()),
        ("clim", item.clim.is_some()),
        ("opacity", matches!(item.opacity, Some(Opacity::Curve(_)))),
        ("point-opacity", matches!(item.opacity, Some(Opacity::Share(_)))),
        ("iso", item.iso.is_some()),
        ("unit-distance", item.unit_distance.is_some()),
        ("labels", item.labels == Some(true)),
        ("color", item.color.is_some()),
        ("radius", item.radius.is_some()),
    ];
    // A built-in sample is one array: no key of a file chooses in it.
    let of_sample = |key: &&str| item.file.starts_with("sample:") && OF_FILES.contains(key);
    let has_meaning = |key: &&str| known.contains(key) && !of_sample(key);
    match given.iter().find(|(key, given)| *given && !has_meaning(key)) {
        Some((key, _)) => {
            let why = match known.contains(key) {
                true => "has no meaning for a built-in sample".to_owned(),
                false => format!("has no meaning for data of this kind: {}", kind.name()),
            };
            Err(DocumentError::refused(&format!("item.{key}"), why).of_item(&item.file))
        }
        None => Ok(()),
    }
}

/// Keys that data have.
fn known_keys(kind: DataKind) -> &'static [&'static str] {
    match kind {
        DataKind::Volume => &VOLUMES,
        DataKind::Points => &POINTS,
        DataKind::DepthImages => &DEPTH_IMAGES,
        DataKind::Terrain => &TERRAIN,
        DataKind::Gaussians => &[],
        DataKind::Mesh => &MESHES,
    }
}

/// Keys that say how a file is read.
const OF_FILES: [&str; 12] = [
    "dims",
    "type",
    "spacing",
    "endian",
    "offset",
    "array",
    "component",
    "channel",
    "time",
    "level",
    "series",
    "solution",
];
/// Keys of volumes.
const VOLUMES: [&str; 19] = [
    "dims",
    "type",
    "spacing",
    "endian",
    "offset",
    "array",
    "component",
    "channel",
    "time",
    "level",
    "series",
    "tf",
    "transfer-function",
    "cmap",
    "clim",
    "opacity",
    "iso",
    "unit-distance",
    "labels",
];
/// Keys of meshes.
const MESHES: [&str; 9] = [
    "array",
    "solution",
    "tf",
    "transfer-function",
    "cmap",
    "clim",
    "opacity",
    "iso",
    "unit-distance",
];
/// Keys of points.
const POINTS: [&str; 4] = ["array", "color", "point-opacity", "radius"];
/// Keys of what depth cameras saw.
const DEPTH_IMAGES: [&str; 3] = ["color", "point-opacity", "radius"];
/// Keys of terrain.
const TERRAIN: [&str; 10] = [
    "dims",
    "type",
    "spacing",
    "endian",
    "offset",
    "drape",
    "posts",
    "color",
    "point-opacity",
    "radius",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_meaning_is_named() {
        let item = ItemKeys {
            opacity: Some(Opacity::Share(0.5)),
            ..ItemKeys::of_file("a.ply")
        };
        let error = check(&item, DataKind::Volume)
            .unwrap_err()
            .of_index(2)
            .to_string();
        let expected = "item[2].opacity has no meaning for data of this kind: volume (a.ply)";
        assert_eq!(error, expected);
        assert!(check(&item, DataKind::Points).is_ok());
    }
}
