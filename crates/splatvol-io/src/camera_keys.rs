//! Key frames of a camera path: TOML or JSON, by the file's extension.
//!
//! ```toml
//! [[key]]
//! time = 0.0                  # seconds; all keys have it, or none
//! position = [0, 400, 0]      # world
//! target = [0, 0, 0]          # optional, as all that follow
//! up = [0, 0, 1]
//! fov = 30                    # degrees; or height, in world units, for a parallel projection
//! ```
//!
//! In JSON the same: `{"key": [{"time": 0, "position": [0, 400, 0]}, ...]}`. Other fields are refused, so that a
//! misspelt one is not silently left out.

use std::path::Path;

use serde_json::Value;
use splatvol_scene::Projection;

use crate::IoError;
use crate::error::Context;
use crate::json::{Node, parse};
use crate::source::read_file;

/// Fields of a key.
const FIELDS: [&str; 6] = ["time", "position", "target", "up", "fov", "height"];

/// A key frame as the file has it; absent keys are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoredCameraKey {
    /// Seconds.
    pub time: Option<f64>,
    /// Position, world.
    pub position: [f64; 3],
    /// Point looked at, world.
    pub target: Option<[f64; 3]>,
    /// Up, world.
    pub up: Option<[f64; 3]>,
    /// Vertical field of view, or height of a parallel projection.
    pub projection: Option<Projection>,
}

/// Reads key frames, at least two. Numbers are finite and times increase; [`splatvol_scene::Camera::new`]
/// decides whether a key makes a camera.
///
/// # Errors
/// See [`IoError`]; fields are named `key[2].position[0]`, keys counting from 0.
pub fn read_camera_keys(path: impl AsRef<Path>) -> Result<Vec<StoredCameraKey>, IoError> {
    let path = path.as_ref();
    let context = Context::new("camera path", path);
    let bytes = read_file(path, &context)?;
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let document = match extension.to_str() {
        Some("toml") => parse_toml(&bytes, &context)?,
        Some("json") => parse(&bytes, &context)?,
        _ => return Err(context.unsupported("camera paths are .toml or .json files")),
    };
    let root = Node::root(&document, &context);
    root.only(&["key"])?;
    let list = root.require("key")?;
    let keys = list
        .items()?
        .iter()
        .map(key)
        .collect::<Result<Vec<_>, IoError>>()?;
    if keys.len() < 2 {
        return Err(context.field("key", format!("{} of them", keys.len()), None, "at least 2"));
    }
    check_times(&keys, &list)?;
    Ok(keys)
}

pub(crate) fn parse_toml(bytes: &[u8], context: &Context<'_>) -> Result<Value, IoError> {
    let text = std::str::from_utf8(bytes)
        .map_err(|error| context.field("contents", error, None, "text in UTF-8"))?;
    toml::from_str(text).map_err(|error| {
        let offset = error.span().map(|span| span.start as u64);
        context.field("contents", error.message(), offset, "valid TOML")
    })
}

fn key(node: &Node<'_>) -> Result<StoredCameraKey, IoError> {
    node.only(&FIELDS)?;
    let triple = |name: &str| node.get(name).map(|node| triple(&node)).transpose();
    let number = |name: &str| node.get(name).map(|node| finite(&node)).transpose();
    let projection = match (number("fov")?, node.get("height")) {
        (Some(_), Some(height)) => return Err(height.error("either fov or height")),
        (Some(fov_degrees), None) => Some(Projection::Perspective { fov_degrees }),
        (None, Some(height)) => Some(Projection::Orthographic {
            height: finite(&height)?,
        }),
        (None, None) => None,
    };
    Ok(StoredCameraKey {
        time: number("time")?,
        position: self::triple(&node.require("position")?)?,
        target: triple("target")?,
        up: triple("up")?,
        projection,
    })
}

fn triple(node: &Node<'_>) -> Result<[f64; 3], IoError> {
    let numbers = node
        .items()?
        .iter()
        .map(finite)
        .collect::<Result<Vec<_>, IoError>>()?;
    numbers
        .try_into()
        .map_err(|_| node.error("three numbers: [x, y, z]"))
}

/// JSON has no other numbers; TOML's infinities and NaN arrive as null.
fn finite(node: &Node<'_>) -> Result<f64, IoError> {
    let number = node.number()?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(node.error("a finite number"))
    }
}

/// Times are there in all keys or none, and increase.
fn check_times(keys: &[StoredCameraKey], list: &Node<'_>) -> Result<(), IoError> {
    let all = keys.iter().all(|key| key.time.is_some());
    let none = keys.iter().all(|key| key.time.is_none());
    if !all && !none {
        return Err(list.error("a time in every key, or in none"));
    }
    for (i, pair) in keys.windows(2).enumerate() {
        if let (Some(before), Some(after)) = (pair[0].time, pair[1].time)
            && after <= before
        {
            let expected = format!("a time after {before}, that of the key before");
            return Err(list.items()?[i + 1].require("time")?.error(&expected));
        }
    }
    Ok(())
}
