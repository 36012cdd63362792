//! Scene files of version 1.

use serde::Deserialize;
use splatvol_scene::FlatSettings;

use crate::Document;
use crate::keys::{Background, CameraKeys, ItemKeys, PictureSize};
use crate::settings::written;

/// A scene as its file had it.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct SceneFile {
    #[serde(default)]
    version: Option<u32>,
    #[serde(rename = "item")]
    pub(super) items: Vec<ItemKeys>,
    #[serde(default)]
    camera: CameraKeys,
    #[serde(default)]
    settings: Option<FlatSettings>,
    #[serde(default)]
    background: Option<Background>,
    #[serde(default)]
    size: Option<PictureSize>,
}

/// The document of such a file.
pub(crate) fn scene(file: SceneFile) -> Option<Document> {
    if file.version.is_some_and(|version| version != 1) {
        return None;
    }
    let size = file
        .size
        .or(file.settings.map(|settings| PictureSize(settings.size)));
    Some(Document {
        size,
        background: file.background,
        items: file.items,
        camera: file.camera,
        settings: file.settings.as_ref().map(written).unwrap_or_default(),
        ..Document::default()
    })
}
