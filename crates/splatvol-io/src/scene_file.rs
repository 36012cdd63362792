//! Scenes: what is in one picture, where it lies and how it looks, as TOML.
//!
//! ```toml
//! background = "black"                  # as the command's --background; likewise size = "800x600"
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
//! [settings]                            # any of `splatvol_scene::RenderSettings`
//! sheet-thickness = 0.5
//! ```
//!
//! Unknown keys are refused, so that a misspelt one is not silently left out. Relative names stay inside the file's folder;
//! a name outside of it has to be absolute.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};
use splatvol_scene::RenderSettings;

use crate::IoError;
use crate::error::Context;
use crate::source::read_file;

/// Format, as errors have it.
const FORMAT: &str = "scene";

/// A scene as its file has it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SceneFile {
    /// What is in it, at least one.
    #[serde(rename = "item")]
    pub items: Vec<SceneItem>,
    /// Where it is seen from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<SceneCamera>,
    /// How the picture is made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<RenderSettings>,
    /// What is behind it: a name, `#rrggbb`, `r,g,b[,a]` or `none`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub background: Option<String>,
    /// Picture size: `WxH` or `N`. Goes over that of the settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
}

/// A thing of a scene. What is absent is chosen from the data.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct SceneItem {
    /// File or folder, or `sample:NAME[:SIZE]`.
    pub file: String,
    /// Whether it is in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// What the file is: see [`crate::DataKind`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// Axis of the file that is up: `x`, `y`, `z`, `-x`, `-y`, `-z`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<String>,
    /// Factor on lengths, or one for each axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
    /// Rotation, after the scale.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotate: Option<Rotate>,
    /// Shift, after the rotation, world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translate: Option<[f64; 3]>,
    /// Layout of a headerless file: samples along x, y, z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dims: Option<[usize; 3]>,
    /// Layout of a headerless file: `u8`, `i16`, ...
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub sample_type: Option<String>,
    /// Layout of a headerless file: world length per voxel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<[f64; 3]>,
    /// Layout of a headerless file: `little` or `big`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub endian: Option<String>,
    /// Layout of a headerless file: bytes before the first sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<u64>,
    /// Array of a file that holds several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub array: Option<String>,
    /// Component of vector-valued samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component: Option<usize>,
    /// Channel, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<usize>,
    /// Time point, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<usize>,
    /// Level of detail, 0 being the finest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<usize>,
    /// Series of a folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<String>,
    /// Picture that is laid over terrain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drape: Option<String>,
    /// Transfer function: a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tf: Option<String>,
    /// Colour map, by its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cmap: Option<String>,
    /// Data values at the ends of colour map and opacity curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clim: Option<[f64; 2]>,
    /// Opacity curve of values, by its name; opacity of points, 0..1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
    /// Data value whose surface is shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iso: Option<f64>,
    /// World length to which opacities refer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit_distance: Option<f64>,
    /// sRGB of points without colours, 0..1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<[f64; 3]>,
    /// Radius of points, in the file's lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
}

/// Opacity of values or of points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "the name of an opacity curve, or a number from 0 to 1 for points"
)]
pub enum Opacity {
    /// A curve over values.
    Curve(String),
    /// One number for points.
    Share(f64),
}

/// A scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a factor, or three: [x, y, z]")]
pub enum Scale {
    /// The same along all axes.
    Uniform(f64),
    /// One for each axis.
    Axes([f64; 3]),
}

/// A rotation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "[axis, degrees], where axis is \"x\", \"y\", \"z\" or [x, y, z]; or the three rows of a rotation matrix"
)]
pub enum Rotate {
    /// Axis and degrees, counter-clockwise as seen from the axis' end.
    Axis(Axis, f64),
    /// Rows.
    Matrix([[f64; 3]; 3]),
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Axis {
    /// `x`, `y` or `z`.
    Name(String),
    /// A direction.
    Direction([f64; 3]),
}

/// A camera; what is absent is chosen so that all is in view.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct SceneCamera {
    /// Side to look from: `front`, `iso`...
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// Position, world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Point looked at, world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Up, world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Vertical field of view, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
    /// World height of a parallel projection.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orthographic: Option<f64>,
    /// Degrees around the target, to the camera's right.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth: Option<f64>,
    /// Degrees over the target, upwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation: Option<f64>,
    /// Enlargement of the picture's middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zoom: Option<f64>,
}

/// True where a file is a scene: TOML that does not list frames of depth cameras.
pub fn is_scene(path: impl AsRef<Path>) -> bool {
    let path = path.as_ref();
    if !path.is_file() || !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        return false;
    }
    let Ok(bytes) = read_file(path, &Context::new(FORMAT, path)) else {
        return false;
    };
    let starts = |line: &[u8]| {
        let line = line.trim_ascii();
        line.starts_with(b"[[frame]]") || line.starts_with(b"frame")
    };
    !bytes.split(|byte| *byte == b'\n').any(starts)
}

/// Reads a scene. Names of files become paths that lead there from the current folder.
///
/// # Errors
/// See [`IoError`]: unknown keys, values of the wrong kind, no items, names that lead out of the folder.
pub fn read_scene(path: impl AsRef<Path>) -> Result<SceneFile, IoError> {
    let path = path.as_ref();
    let context = &Context::new(FORMAT, path);
    let bytes = read_file(path, context)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|error| context.field("contents", error, None, "text in UTF-8"))?;
    let mut scene: SceneFile = toml::from_str(text).map_err(|error| refused(&error, text, context))?;
    if scene.items.is_empty() {
        return Err(context.field("item", "none", None, "at least one [[item]]"));
    }
    for (i, item) in scene.items.iter_mut().enumerate() {
        let named = |key: &str| format!("item[{i}].{key}");
        if item.file.is_empty() {
            return Err(context.field(named("file"), "", None, "the name of a file"));
        }
        let checked = item.world_from_file().map_err(|(key, value)| {
            context.field(
                named(key),
                value,
                None,
                "finite numbers that make an invertible place",
            )
        });
        checked?;
        item.file = beside(&item.file, &named("file"), context)?;
        for (key, file) in [("tf", &mut item.tf), ("drape", &mut item.drape)] {
            if let Some(file) = file {
                *file = beside(file, &named(key), context)?;
            }
        }
    }
    Ok(scene)
}

impl SceneItem {
    /// Where the item lies: its scale, rotation and shift. `up` is not among them.
    ///
    /// # Errors
    /// The key and its value, where they make no place.
    pub fn world_from_file(&self) -> Result<DAffine3, (&'static str, String)> {
        let scale = match self.scale {
            None => DVec3::ONE,
            Some(Scale::Uniform(scale)) => DVec3::splat(scale),
            Some(Scale::Axes(axes)) => DVec3::from_array(axes),
        };
        if !(scale.is_finite() && scale.abs().min_element() > 0.0) {
            return Err(("scale", format!("{:?}", scale.to_array())));
        }
        let rotation = match &self.rotate {
            None => DMat3::IDENTITY,
            Some(rotate) => rotate.matrix().ok_or_else(|| ("rotate", format!("{rotate:?}")))?,
        };
        let shift = DVec3::from_array(self.translate.unwrap_or_default());
        if !shift.is_finite() {
            return Err(("translate", format!("{:?}", shift.to_array())));
        }
        Ok(DAffine3::from_mat3_translation(
            rotation * DMat3::from_diagonal(scale),
            shift,
        ))
    }
}

impl Rotate {
    /// The matrix, if it is one of a rotation.
    fn matrix(&self) -> Option<DMat3> {
        match self {
            Self::Axis(axis, degrees) => {
                let direction = match axis {
                    Axis::Name(name) => match name.as_str() {
                        "x" => DVec3::X,
                        "y" => DVec3::Y,
                        "z" => DVec3::Z,
                        _ => return None,
                    },
                    Axis::Direction(direction) => DVec3::from_array(*direction),
                };
                let axis = direction.try_normalize()?;
                degrees
                    .is_finite()
                    .then(|| DMat3::from_axis_angle(axis, degrees.to_radians()))
            }
            Self::Matrix(rows) => {
                let matrix = DMat3::from_cols_array_2d(rows).transpose();
                let product = matrix * matrix.transpose();
                let is_rotation = product.abs_diff_eq(DMat3::IDENTITY, 1e-4) && matrix.determinant() > 0.0;
                is_rotation.then_some(matrix)
            }
        }
    }
}

/// The path of a file that a scene names.
fn beside(name: &str, field: &str, context: &Context<'_>) -> Result<String, IoError> {
    if name.starts_with("sample:") || Path::new(name).is_absolute() {
        return Ok(name.to_owned());
    }
    let inside = |component| matches!(component, Component::Normal(_) | Component::CurDir);
    let refused = |expected: &str| Err(context.field(field, name, None, expected));
    if name.contains('\0') || !Path::new(name).components().all(inside) {
        return refused("a name inside the scene's folder, or an absolute one");
    }
    let folder = match context.path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new(""),
    };
    let path: PathBuf = folder.join(name);
    let Ok(real) = path.canonicalize() else {
        return Err(IoError::MissingDataFile {
            data: path,
            path: context.path.to_owned(),
        });
    };
    let real_folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    if real_folder
        .canonicalize()
        .is_ok_and(|folder| !real.starts_with(folder))
    {
        return refused("a name inside the scene's folder (this is a link that leads out)");
    }
    Ok(path.to_string_lossy().into_owned())
}

/// What TOML's reader said, with the key and the value of the line.
fn refused(error: &toml::de::Error, text: &str, context: &Context<'_>) -> IoError {
    let Range { start, end } = error.span().unwrap_or(0..0);
    let line_start = text[..start.min(text.len())].rfind('\n').map_or(0, |at| at + 1);
    let line = text[line_start..].lines().next().unwrap_or_default();
    let number = text[..line_start].matches('\n').count() + 1;
    let (key, value) = line.split_once('=').unwrap_or((line, ""));
    let key = key.trim();
    let value = match value.trim() {
        "" => text.get(start..end).unwrap_or_default(),
        value => value,
    };
    let expected = format!("otherwise, line {number}: {}", error.message().trim());
    context.field(key, value, start as u64, expected)
}

#[cfg(test)]
mod tests;
