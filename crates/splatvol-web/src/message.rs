//! What may be asked of an instance, and what it answers: the headers of messages, JSON.
//!
//! | `do` | bytes | the answer's header | the answer's bytes |
//! |---|---|---|---|
//! | `open` | the packed data of all items, one after the other | [`Opened`] | - |
//! | `edit` | - | [`Edited`] | - |
//! | `look` | - | [`Edited`] | - |
//! | `camera` | - | a [`CameraPose`] | - |
//! | `render` | - | [`Rendered`] | the tiles' pixels, one tile after the other: RGBA, sRGB of 8 bits, straight alpha |
//!
//! What cannot be answered has the header `{"error": "..."}`, and changes nothing.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use splatvol::{Bounds, TransferFunction};
use splatvol_document::CameraPose;
use splatvol_document::keys::CameraKeys;

use crate::{ItemData, LookEdit};

/// A question.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// Takes a document with its data, in place of an earlier one.
    Open {
        /// The document, as a scene file has it in JSON.
        document: Value,
        /// What the bytes are, for each item.
        data: Vec<ItemData>,
        /// What the file of each item says about it; absent where all is in the document.
        #[serde(default)]
        described: Option<Vec<Described>>,
    },
    /// Changes keys of the document: all of them, or none if one is refused.
    Edit {
        /// The changes, in this order.
        edits: Vec<KeyEdit>,
    },
    /// Changes the transfer function of an item, as it was opened.
    Look {
        /// Number of the item.
        item: usize,
        /// The changes.
        look: LookEdit,
    },
    /// The camera of keys over those of the document, for a picture of a size.
    Camera {
        /// The keys.
        camera: CameraKeys,
        /// Width and height, pixels.
        size: [u32; 2],
    },
    /// Renders tiles of the picture.
    Render {
        /// Width and height, pixels; the document's if absent.
        size: Option<[u32; 2]>,
        /// Keys over those of the document's camera.
        camera: Option<CameraKeys>,
        /// Which share of how many: `[0, 1]`, or absent, is the whole picture.
        share: Option<[usize; 2]>,
    },
}

/// What a file says about its data, on which depends how they are shown where the document leaves that open.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Described {
    /// Its format.
    pub format: String,
    /// Whether it says how the data lie in the world.
    pub oriented: bool,
}

/// A change of a key.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyEdit {
    /// Path of the key: `effects.clip-box`, `item[0].visible`.
    pub path: String,
    /// Its value; `null` leaves it open again.
    pub value: Value,
}

/// A document that was opened.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Opened {
    /// Version of the engine.
    pub version: &'static str,
    /// The document with nothing left open.
    pub document: Value,
    /// What its items are.
    pub items: Vec<ItemFacts>,
    /// Box around the scene, world.
    pub bounds: Bounds,
    /// Names of colour maps.
    pub color_maps: Vec<&'static str>,
    /// Names of opacity curves.
    pub opacity_curves: Vec<String>,
    /// What was chosen, and warnings.
    pub notes: Vec<String>,
}

/// What is known about an item.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ItemFacts {
    /// Its name: a file's, without the folder.
    pub name: String,
    /// What it is, and how much of it: `64 × 64 × 40 samples`, `34820 points`.
    pub size: String,
    /// Unit of lengths, or nothing.
    pub unit: &'static str,
    /// Opacity of points, 0..1; nothing of what has none of its own.
    pub opacity: Option<f64>,
    /// Its values and their transfer function; nothing for points and Gaussians, which have neither.
    pub values: Option<ValueFacts>,
}

/// What is known about the values of an item.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ValueFacts {
    /// Least and largest value.
    pub extremes: [f64; 2],
    /// Counts of samples in equal bins between these.
    pub histogram: Vec<u64>,
    /// Its transfer function, as it was opened.
    pub transfer_function: TransferFunction,
    /// Least and largest value of the transfer function's points.
    pub range: [f64; 2],
}

/// A document that was changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Edited {
    /// The document with nothing left open.
    pub document: Value,
}

/// Tiles that were rendered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rendered {
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// Camera of the picture.
    pub camera: CameraPose,
    /// Rectangles of the tiles: x0, y0, x1, y1, ends excluded.
    pub tiles: Vec<[usize; 4]>,
}
