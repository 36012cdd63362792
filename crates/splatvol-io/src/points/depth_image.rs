//! Frames of depth cameras: layered depth images and RGB-D recordings, back-projected to points.
//!
//! A TOML or JSON file lists frames:
//!
//! ```toml
//! depth_unit = 0.001                     # world length per unit of the depth pictures; 1 if absent
//! intrinsics = { fx = 525, fy = 525, cx = 319.5, cy = 239.5 }   # pixels; frames may have their own
//!
//! [[frame]]
//! depth = "depth/0001.png"               # PNG of 16 bits, .npy (rows, columns) or EXR (channel Z)
//! color = "color/0001.png"               # optional: PNG, JPEG or EXR of the same size
//! world_from_camera = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]   # rows; identity if absent
//! ```
//!
//! Camera space is that of computer vision: x to the right, y down, z forward; centres of pixels have whole
//! coordinates. With depth `d` along z, pixel (u, v) lies at `((u - cx) / fx, (v - cy) / fy, 1) d`. Its radius is the
//! distance to the next pixel's point, `d / f`; its normal is perpendicular to the differences to its neighbours and
//! faces the camera. Pixels of depth 0 or less, NaN or infinity are empty. Pictures of several layers are frames of the
//! same pose.

mod frame;

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use serde_json::Value;
use splatvol_scene::{PointAttributes, Points};

use super::LoadedPoints;
use crate::camera_keys::parse_toml;
use crate::error::Context;
use crate::json::{Node, parse};
use crate::source::{companion, read_file};
use crate::{Description, IoError, ReadOptions};
use frame::Frame;

/// Bytes of a point in memory.
const BYTES: u64 = 32;

/// Options for reading frames.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImageOptions {
    /// Neighbours whose depths differ by more than this share of the nearer one are on another surface.
    pub depth_jump: f64,
    /// Turn warnings into errors.
    pub strict: bool,
    /// Follow links that lead out of the folder of the list.
    pub allow_outside: bool,
    /// Most bytes that the points may take in memory.
    pub max_bytes: u64,
}

impl Default for DepthImageOptions {
    fn default() -> Self {
        Self {
            depth_jump: 0.05,
            strict: false,
            allow_outside: false,
            max_bytes: ReadOptions::default().max_bytes,
        }
    }
}

/// A pinhole camera, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Intrinsics {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

/// A frame as the list has it.
struct Entry {
    depth: PathBuf,
    color: Option<PathBuf>,
    intrinsics: Intrinsics,
    world_from_camera: DAffine3,
    depth_unit: f64,
}

/// Reads the frames that a TOML or JSON file lists, as one cloud.
///
/// # Errors
/// See [`IoError`]; fields are named `frame[2].intrinsics.fx`, frames counting from 0.
pub fn read_depth_images(
    path: impl AsRef<Path>,
    options: &DepthImageOptions,
) -> Result<LoadedPoints, IoError> {
    let path = path.as_ref();
    let context = &Context {
        allow_outside: options.allow_outside,
        ..Context::new("list of depth images", path)
    };
    let bytes = read_file(path, context)?;
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let document = match extension.to_str() {
        Some("toml") => parse_toml(&bytes, context)?,
        Some("json") => parse(&bytes, context)?,
        _ => return Err(context.unsupported("depth images are listed in .toml or .json files")),
    };
    let entries = entries(&document, context)?;
    let mut description = Description {
        format: format!("{} depth images", entries.len()),
        orientation: "world_from_camera of each frame; camera x right, y down, z forward".to_owned(),
        files: vec![path.to_owned()],
        ..Description::default()
    };
    let mut cloud = Cloud::new(&entries, options.max_bytes);
    for entry in &entries {
        let frame = Frame::read(entry)?;
        description.stored_type = format!("{}, {} x {}", frame.stored_type, frame.size[0], frame.size[1]);
        description.files.push(entry.depth.clone());
        description.files.extend(entry.color.clone());
        let before = cloud.positions.len();
        cloud.add(&frame, entry, options.depth_jump, context)?;
        if cloud.positions.len() == before {
            let name = entry.depth.display();
            description.warnings.push(format!("{name} is empty"));
        }
    }
    let viewpoint = entries
        .first()
        .filter(|_| entries.len() == 1)
        .map(|entry| entry.world_from_camera.translation);
    let points = Points::new(
        cloud.positions,
        cloud.attributes,
        DAffine3::from_translation(cloud.origin),
    )
    .map_err(|error| context.scene(error))?;
    let loaded = LoadedPoints {
        points,
        description,
        viewpoint,
    };
    loaded.checked(options.strict, path)
}

/// Points of all frames so far.
struct Cloud {
    /// World place of the local origin: where the first camera stands.
    origin: DVec3,
    positions: Vec<[f32; 3]>,
    attributes: PointAttributes,
    colored: bool,
    max_bytes: u64,
}

impl Cloud {
    fn new(entries: &[Entry], max_bytes: u64) -> Self {
        Self {
            origin: entries
                .first()
                .map_or(DVec3::ZERO, |entry| entry.world_from_camera.translation),
            positions: Vec::new(),
            attributes: PointAttributes::default(),
            // If one frame has colours, all of them get some.
            colored: entries.iter().any(|entry| entry.color.is_some()),
            max_bytes,
        }
    }

    fn add(&mut self, frame: &Frame, entry: &Entry, jump: f64, context: &Context<'_>) -> Result<(), IoError> {
        let bytes = (self.positions.len() + frame.depths.len()) as u64 * BYTES;
        if bytes > self.max_bytes {
            return Err(context.limit(bytes, self.max_bytes));
        }
        let camera = entry.intrinsics;
        let rotation = entry.world_from_camera.matrix3;
        // A pose may have a scale.
        let scale = rotation.determinant().abs().cbrt();
        for pixel in 0..frame.depths.len() {
            let Some(place) = frame.place(pixel, &camera) else {
                continue;
            };
            let world = entry.world_from_camera.transform_point3(place) - self.origin;
            let normal = frame.normal(pixel, &camera, jump);
            self.positions.push(world.as_vec3().to_array());
            self.attributes
                .normals
                .push((rotation * normal).as_vec3().to_array());
            let radius = scale * place.z / camera.fx.min(camera.fy);
            self.attributes.radii.push(radius as f32);
            if self.colored {
                let color = frame.colors.get(pixel).copied().unwrap_or([128, 128, 128, 255]);
                self.attributes.colors.push(color);
            }
        }
        Ok(())
    }
}

fn entries(document: &Value, context: &Context<'_>) -> Result<Vec<Entry>, IoError> {
    let root = Node::root(document, context);
    root.only(&["frame", "intrinsics", "depth_unit"])?;
    let shared = root.get("intrinsics").map(|node| intrinsics(&node)).transpose()?;
    let depth_unit = match root.get("depth_unit") {
        None => 1.0,
        Some(node) => positive(&node)?,
    };
    let frames = root.require("frame")?.items()?;
    if frames.is_empty() {
        return Err(root.require("frame")?.error("at least one frame"));
    }
    let entry = |node: &Node<'_>| {
        node.only(&["depth", "color", "intrinsics", "world_from_camera"])?;
        let file = |name: &str| -> Result<Option<PathBuf>, IoError> {
            let Some(node) = node.get(name) else {
                return Ok(None);
            };
            let text = node.text().ok_or_else(|| node.error("the name of a file"))?;
            let field = if name == "depth" { "depth" } else { "color" };
            companion(text, field, None, context).map(Some)
        };
        let own = node.get("intrinsics").map(|node| intrinsics(&node)).transpose()?;
        Ok(Entry {
            depth: file("depth")?.ok_or_else(|| node.error("a field \"depth\""))?,
            color: file("color")?,
            intrinsics: match own.or(shared) {
                Some(intrinsics) => intrinsics,
                None => return Err(node.error("intrinsics, here or for all frames")),
            },
            world_from_camera: match node.get("world_from_camera") {
                None => DAffine3::IDENTITY,
                Some(node) => pose(&node)?,
            },
            depth_unit,
        })
    };
    frames.iter().map(entry).collect()
}

fn finite(node: &Node<'_>) -> Result<f64, IoError> {
    let number = node.number()?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(node.error("a finite number"))
    }
}

fn positive(node: &Node<'_>) -> Result<f64, IoError> {
    let number = finite(node)?;
    if number > 0.0 {
        Ok(number)
    } else {
        Err(node.error("a number above zero"))
    }
}

fn intrinsics(node: &Node<'_>) -> Result<Intrinsics, IoError> {
    node.only(&["fx", "fy", "cx", "cy"])?;
    Ok(Intrinsics {
        fx: positive(&node.require("fx")?)?,
        fy: positive(&node.require("fy")?)?,
        cx: finite(&node.require("cx")?)?,
        cy: finite(&node.require("cy")?)?,
    })
}

/// Three or four rows of four numbers, the fourth `0 0 0 1`.
fn pose(node: &Node<'_>) -> Result<DAffine3, IoError> {
    let expected = "three rows of four numbers that make an invertible map (a fourth is 0 0 0 1)";
    let mut rows = [[0.0; 4]; 4];
    rows[3] = [0.0, 0.0, 0.0, 1.0];
    let items = node.items()?;
    if !(3..=4).contains(&items.len()) {
        return Err(node.error(expected));
    }
    for (row, item) in rows.iter_mut().zip(&items) {
        let numbers = item.items()?.iter().map(finite).collect::<Result<Vec<_>, _>>()?;
        *row = numbers.try_into().map_err(|_| item.error("four numbers"))?;
    }
    let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
    let pose = DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3));
    if rows[3] != [0.0, 0.0, 0.0, 1.0] || !pose.matrix3.determinant().is_normal() {
        return Err(node.error(expected));
    }
    Ok(pose)
}
