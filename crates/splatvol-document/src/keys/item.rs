//! Keys of an item: its file, how that is read, its place and its look.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use splatvol_scene::TransferFunction;

use super::names::UpAxis;
use super::place::{Rotate, Scale};

/// An item of a scene: a table `[[item]]`. Absent keys are chosen from the data.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct ItemKeys {
    /// File or folder, or `sample:NAME[:SIZE]`.
    pub file: String,
    /// Whether it is in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visible: Option<bool>,
    /// Kind of the file: volume, points, terrain, depth-images, gaussians or mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// Axis of the file that is up: it is turned to z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
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
    /// Solution of a PLOT3D grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solution: Option<String>,
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
    /// Whether values are names of kinds, which are never interpolated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub labels: Option<bool>,
    /// sRGB of points without colours, 0..1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<[f64; 3]>,
    /// Radius of points, in the file's lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// The transfer function itself: what the keys above led to. It goes over them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "crate::schema::transfer_function")]
    pub transfer_function: Option<TransferFunction>,
}

/// Opacity of values or of points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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

impl ItemKeys {
    /// An item that is a file, or `sample:NAME`.
    pub fn of_file(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            ..Self::default()
        }
    }

    /// Whether it is in the picture.
    pub fn is_visible(&self) -> bool {
        self.visible != Some(false)
    }

    /// Whether any key gives its look.
    pub fn has_look(&self) -> bool {
        let Self {
            tf,
            cmap,
            clim,
            opacity,
            iso,
            unit_distance,
            ..
        } = self;
        tf.is_some()
            || cmap.is_some()
            || clim.is_some()
            || opacity.is_some()
            || iso.is_some()
            || unit_distance.is_some()
    }

    /// These keys over those of an earlier item: another file is read in its own way, and a look that is asked for is
    /// chosen again.
    #[must_use]
    pub fn over(self, below: &Self) -> Self {
        let mut below = match self.file.is_empty() || self.file == below.file {
            true => below.clone(),
            false => below.look_only(),
        };
        if self.has_look() {
            below.transfer_function = None;
            below.labels = None;
        }
        if self.tf.is_some() || self.iso.is_some() {
            below = below.without_look();
        }
        if self.cmap.is_some() || self.opacity.is_some() {
            below.tf = None;
        }
        if self.opacity.is_some() {
            below.iso = None;
        }
        self.or(below)
    }

    /// The keys that make another file look the same.
    fn look_only(&self) -> Self {
        Self {
            tf: self.tf.clone(),
            cmap: self.cmap.clone(),
            clim: self.clim,
            opacity: self.opacity.clone(),
            iso: self.iso,
            unit_distance: self.unit_distance,
            color: self.color,
            radius: self.radius,
            ..Self::default()
        }
    }

    fn without_look(&self) -> Self {
        Self {
            tf: None,
            cmap: None,
            clim: None,
            opacity: None,
            iso: None,
            unit_distance: None,
            ..self.clone()
        }
    }

    fn or(self, below: Self) -> Self {
        Self {
            file: match self.file.is_empty() {
                true => below.file,
                false => self.file,
            },
            visible: self.visible.or(below.visible),
            kind: self.kind.or(below.kind),
            up: self.up.or(below.up),
            scale: self.scale.or(below.scale),
            rotate: self.rotate.or(below.rotate),
            translate: self.translate.or(below.translate),
            dims: self.dims.or(below.dims),
            sample_type: self.sample_type.or(below.sample_type),
            spacing: self.spacing.or(below.spacing),
            endian: self.endian.or(below.endian),
            offset: self.offset.or(below.offset),
            array: self.array.or(below.array),
            component: self.component.or(below.component),
            channel: self.channel.or(below.channel),
            time: self.time.or(below.time),
            level: self.level.or(below.level),
            series: self.series.or(below.series),
            solution: self.solution.or(below.solution),
            drape: self.drape.or(below.drape),
            posts: self.posts.or(below.posts),
            tf: self.tf.or(below.tf),
            cmap: self.cmap.or(below.cmap),
            clim: self.clim.or(below.clim),
            opacity: self.opacity.or(below.opacity),
            iso: self.iso.or(below.iso),
            unit_distance: self.unit_distance.or(below.unit_distance),
            labels: self.labels.or(below.labels),
            color: self.color.or(below.color),
            radius: self.radius.or(below.radius),
            transfer_function: self.transfer_function.or(below.transfer_function),
        }
    }
}
