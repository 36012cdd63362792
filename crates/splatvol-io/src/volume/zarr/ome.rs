//! OME's metadata of multi-scale images, versions 0.1 to 0.5 (<https://ngff.openmicroscopy.org/0.5/>).

use std::path::{Component, Path};

use serde_json::Value;

use super::folder::Folder;
use crate::IoError;
use crate::error::Context;

/// Maximum number of levels that are read.
const MAX_LEVELS: usize = 64;

/// Key of an image whose values are labels.
pub(super) const LABELS: &str = "image-label";

/// One axis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Axis {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) unit: String,
}

/// A level of detail: its folder, and the map from samples to world along every axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Level {
    pub(super) path: String,
    pub(super) scale: Vec<f64>,
    pub(super) translation: Vec<f64>,
}

/// A multi-scale image.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Image {
    pub(super) version: String,
    /// Empty if the metadata name none.
    pub(super) axes: Vec<Axis>,
    pub(super) levels: Vec<Level>,
    /// Names of channels.
    pub(super) channels: Vec<String>,
    /// Further images in the same metadata.
    pub(super) others: usize,
    /// Whether values are labels.
    pub(super) is_labels: bool,
}

/// The metadata of a folder, wherever its version keeps them.
pub(super) fn attributes(folder: &Folder) -> Result<Option<Value>, IoError> {
    if let Some(value) = folder.json(".zattrs")? {
        return Ok(Some(value));
    }
    let value = folder.json("zarr.json")?;
    Ok(value.and_then(|value| {
        let attributes = value.get("attributes")?;
        Some(attributes.get("ome").unwrap_or(attributes).clone())
    }))
}

impl Image {
    /// The first image in the metadata, `None` if there is none.
    pub(super) fn new(attributes: &Value, context: &Context<'_>) -> Result<Option<Self>, IoError> {
        let Some(scales) = attributes.get("multiscales").and_then(Value::as_array) else {
            return Ok(None);
        };
        let Some(first) = scales.first() else {
            return Err(context.field("multiscales", "[]", None, "an image"));
        };
        let text = |value: Option<&Value>| value.and_then(Value::as_str).unwrap_or_default().to_owned();
        let list = |key: &str| {
            first
                .get(key)
                .and_then(Value::as_array)
                .map_or(&[][..], Vec::as_slice)
        };
        let axis = |axis: &Value| match axis.as_str() {
            Some(name) => Axis {
                name: name.to_owned(),
                ..Axis::default()
            },
            None => Axis {
                name: text(axis.get("name")),
                kind: text(axis.get("type")),
                unit: text(axis.get("unit")),
            },
        };
        let outer = Transform::new(first.get("coordinateTransformations"), context)?;
        let levels: Result<Vec<Level>, IoError> = list("datasets")
            .iter()
            .take(MAX_LEVELS)
            .map(|level| {
                let path = text(level.get("path"));
                let inside = |part| matches!(part, Component::Normal(_) | Component::CurDir);
                if path.is_empty() || !Path::new(&path).components().all(inside) {
                    return Err(context.field("path", path, None, "a folder inside this one"));
                }
                let inner = Transform::new(level.get("coordinateTransformations"), context)?;
                Ok(inner.then(&outer).level(path))
            })
            .collect();
        let channels = attributes.pointer("/omero/channels").and_then(Value::as_array);
        let channels = channels.map_or(&[][..], Vec::as_slice);
        let version = [attributes.get("version"), first.get("version")]
            .into_iter()
            .flatten()
            .find_map(Value::as_str);
        Ok(Some(Self {
            version: version.unwrap_or("without a version").to_owned(),
            axes: list("axes").iter().map(axis).collect(),
            levels: levels?,
            channels: channels
                .iter()
                .map(|channel| text(channel.get("label")))
                .collect(),
            others: scales.len() - 1,
            is_labels: attributes.get(LABELS).is_some(),
        }))
    }
}

/// `scale .* x + translation`, of as many axes as are given, from the last on.
#[derive(Debug, Default)]
struct Transform {
    scale: Vec<f64>,
    translation: Vec<f64>,
}

impl Transform {
    fn new(list: Option<&Value>, context: &Context<'_>) -> Result<Self, IoError> {
        let mut whole = Self::default();
        for value in list.and_then(Value::as_array).map_or(&[][..], Vec::as_slice) {
            let kind = value.get("type").and_then(Value::as_str).unwrap_or_default();
            let numbers = || {
                let numbers: Option<Vec<f64>> =
                    value.get(kind)?.as_array()?.iter().map(Value::as_f64).collect();
                numbers
                    .filter(|numbers| numbers.len() <= 8 && numbers.iter().all(|number| number.is_finite()))
            };
            let bad = || {
                context.field(
                    "coordinateTransformations",
                    value,
                    None,
                    "a list of finite numbers",
                )
            };
            let step = match kind {
                "scale" => Self {
                    scale: numbers().ok_or_else(bad)?,
                    translation: Vec::new(),
                },
                "translation" => Self {
                    scale: Vec::new(),
                    translation: numbers().ok_or_else(bad)?,
                },
                "identity" => continue,
                other => return Err(context.unsupported(format!("a coordinate transformation \"{other}\""))),
            };
            whole = whole.then(&step);
        }
        Ok(whole)
    }

    /// This, and `next` after it.
    fn then(&self, next: &Self) -> Self {
        let axes = [&self.scale, &self.translation, &next.scale, &next.translation];
        let axes = axes.into_iter().map(Vec::len).max().unwrap_or(0);
        let at = |list: &Vec<f64>, i: usize, default: f64| list.get(i).copied().unwrap_or(default);
        Self {
            scale: (0..axes)
                .map(|i| at(&self.scale, i, 1.0) * at(&next.scale, i, 1.0))
                .collect(),
            translation: (0..axes)
                .map(|i| {
                    at(&self.translation, i, 0.0) * at(&next.scale, i, 1.0) + at(&next.translation, i, 0.0)
                })
                .collect(),
        }
    }

    fn level(self, path: String) -> Level {
        Level {
            path,
            scale: self.scale,
            translation: self.translation,
        }
    }
}
