//! The document: everything about a picture except its data and its pixels.
//!
//! ```toml
//! version = 2
//! size = "800x600"
//! background = "black"
//!
//! [[item]]
//! file = "scan.nii.gz"                  # beside this file; or sample:NAME
//! cmap = "gray"                         # tf, cmap, opacity, clim, iso, unit-distance: as the flags
//! clim = [100, 900]
//!
//! [[item]]
//! file = "electrodes.ply"
//! color = [1, 0.8, 0.2]                 # points without colours of their own
//! rotate = ["z", 30]                    # axis and degrees, or the rows of a matrix
//! translate = [10, 0, 5]                # world = translate + rotate * scale * (what the file says)
//!
//! [camera]                              # all of it optional, as the flags
//! view = "front"
//!
//! [settings]                            # the method; likewise [effects], [motion], [animation]
//! sheet-thickness = 0.5
//! ```
//!
//! A user's document says little, and the rest is chosen when it is resolved ([`crate::resolve`]). A picture's
//! document, which is in its PNG, says everything, so that the same picture can be made again. They are one type.
//! Documents can be laid over each other ([`Document::over`]), as the command's flags are laid over a scene file or an
//! earlier picture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::keys::names::ClassificationName;
use crate::keys::{
    AnimationKeys, Background, CameraKeys, EffectKeys, ItemKeys, MotionKeys, PictureSize, SettingKeys,
};

/// The version that is written; [`crate::format`] reads earlier ones too.
pub const VERSION: u32 = 2;

/// A picture, or an animation, as it is asked for or as it was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Document {
    /// Version of this form.
    #[schemars(range(min = 2, max = 2))]
    pub version: u32,
    /// Name that pictures are called by unless asked otherwise: a path, of which the last part counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Size of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<PictureSize>,
    /// Background of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<Background>,
    /// Bits per channel of a PNG: 8 or 16.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bits: Option<u8>,
    /// Items of the scene.
    #[serde(rename = "item", skip_serializing_if = "Vec::is_empty")]
    pub items: Vec<ItemKeys>,
    /// Camera.
    #[serde(skip_serializing_if = "CameraKeys::is_empty")]
    pub camera: CameraKeys,
    /// Method.
    #[serde(skip_serializing_if = "SettingKeys::is_empty")]
    pub settings: SettingKeys,
    /// Operators, clips and exact isosurfaces.
    #[serde(skip_serializing_if = "EffectKeys::is_empty")]
    pub effects: EffectKeys,
    /// Motion while the shutter is open.
    #[serde(skip_serializing_if = "MotionKeys::is_empty")]
    pub motion: MotionKeys,
    /// Motion of the camera from frame to frame.
    #[serde(skip_serializing_if = "AnimationKeys::is_empty")]
    pub animation: AnimationKeys,
}

impl Default for Document {
    fn default() -> Self {
        Self {
            version: VERSION,
            name: None,
            size: None,
            background: None,
            bits: None,
            items: Vec::new(),
            camera: CameraKeys::default(),
            settings: SettingKeys::default(),
            effects: EffectKeys::default(),
            motion: MotionKeys::default(),
            animation: AnimationKeys::default(),
        }
    }
}

impl Document {
    /// A picture of these items.
    pub fn of_items(items: impl IntoIterator<Item = ItemKeys>) -> Self {
        Self {
            items: items.into_iter().collect(),
            ..Self::default()
        }
    }

    /// The name that pictures are called by: the document's, or the file of a single item.
    pub fn reference(&self) -> &str {
        match (&self.name, &self.items[..]) {
            (Some(name), _) => name,
            (None, [item]) => &item.file,
            (None, _) => "scene",
        }
    }

    /// This document over an earlier one: its own keys, and elsewhere those of the earlier one. If the earlier
    /// document has one item, this document's item is laid over it; if it has several, it replaces all of them.
    #[must_use]
    pub fn over(self, below: &Self) -> Self {
        let asked = self.items.first().cloned().unwrap_or_default();
        let same_items =
            asked.file.is_empty() || matches!(&below.items[..], [item] if item.file == asked.file);
        let mut items = match (&self.items[..], &below.items[..]) {
            ([], items) => items.to_vec(),
            ([_], [item]) => vec![asked.clone().over(item)],
            (own, _) => own.to_vec(),
        };
        let settings = self.settings.clone().over(&below.settings);
        if settings.compositing != below.settings.compositing {
            // An automatic look depends on how it is composited.
            for item in &mut items {
                item.transfer_function = None;
            }
        }
        if self.settings.classification == Some(ClassificationName::Post) {
            // A request to interpolate data also interpolates names.
            for item in &mut items {
                item.labels = item.labels.map(|_| false);
            }
        }
        let merged = items.first().cloned().unwrap_or_default();
        let same_camera = self.camera.is_empty() && self.animation.is_empty();
        Self {
            version: VERSION,
            name: self.name.or(below.name.clone().filter(|_| same_items)),
            size: self.size.or(below.size),
            background: self.background.or(below.background),
            bits: self.bits.or(below.bits),
            items,
            camera: self.camera.over(&below.camera),
            settings,
            effects: self.effects.over(&below.effects, &asked, &merged),
            motion: self.motion.over(&below.motion, same_camera, same_items),
            animation: self.animation.over(&below.animation),
        }
    }

    /// The document without effects and clips.
    #[must_use]
    pub fn without_effects(self) -> Self {
        Self {
            effects: EffectKeys::default(),
            ..self
        }
    }
}
