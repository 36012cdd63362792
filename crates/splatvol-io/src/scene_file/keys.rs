//! Keys of a scene file.

use serde::{Deserialize, Serialize};
use splatvol_scene::FlatSettings;

/// A scene as its file has it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SceneFile {
    /// Items of the scene, at least one.
    #[serde(rename = "item")]
    pub items: Vec<SceneItem>,
    /// Camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<SceneCamera>,
    /// Render settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settings: Option<FlatSettings>,
    /// Background colour: a name, `#rrggbb`, `r,g,b[,a]` or `none`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub background: Option<String>,
    /// Picture size: `WxH` or `N`. Goes over that of the settings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
}

/// An item of a scene. Absent keys are chosen from the data.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct SceneItem {
    /// File or folder, or `sample:NAME[:SIZE]`.
    pub file: String,
    /// Whether it is in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// Kind of the file: see [`crate::DataKind`].
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
    /// Posts to the east and to the north that heights of terrain are interpolated to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posts: Option<[usize; 2]>,
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
    /// One factor for all axes.
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

/// A camera; absent keys are chosen so that everything is in view.
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
