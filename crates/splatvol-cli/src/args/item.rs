//! Flags about what data are and which way they are up; and about data other than volumes: points, Gaussians, meshes,
//! terrain.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use splatvol::GaussianMode;
use splatvol_io::DataKind;

use super::help::{DATA, INPUT};
use super::values::{self, Triple};

/// What the data are, and what only data other than volumes have.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct ItemArgs {
    /// What the input is: volume, points, terrain, depth-images, gaussians or mesh [default: decided by its contents]
    #[arg(long, value_name = "KIND", value_parser = values::kind, help_heading = INPUT)]
    pub(crate) kind: Option<DataKind>,
    /// Axis of the file that points up [default: decided by the file and its contents]
    ///
    /// It is turned to z. For volumes it is an axis of the world as info prints it, whatever the file says of its
    /// orientation; for Gaussians, of the frame they were trained in. The default is z; -y for Gaussians; and y for
    /// points of a PLY file, and for volumes whose file gives no orientation, if they look as if they stood on it.
    #[arg(long, value_name = "AXIS", help_heading = INPUT, allow_hyphen_values = true)]
    pub(crate) up: Option<UpAxis>,
    /// How Gaussians are composited [default: auto]
    #[arg(long, value_name = "NAME", help_heading = DATA)]
    pub(crate) gaussians: Option<GaussianModeName>,
    /// Radius of points, in the file's lengths [default: the file's, or from distances between points]
    #[arg(long, value_name = "LENGTH", value_parser = values::finite, help_heading = DATA)]
    pub(crate) radius: Option<f64>,
    /// Colour of points that have none, sRGB 0..1 [default: 0.8,0.8,0.8]
    #[arg(long, value_name = "R,G,B", value_parser = values::triple, help_heading = DATA)]
    pub(crate) point_color: Option<Triple>,
    /// Opacity of points, 0..1 [default: 1]
    #[arg(long, value_name = "SHARE", value_parser = values::finite, help_heading = DATA, conflicts_with = "opacity")]
    pub(crate) point_opacity: Option<f64>,
    /// Picture to lay over terrain: of the same area, north at its top
    #[arg(long, value_name = "PICTURE", help_heading = DATA)]
    pub(crate) drape: Option<std::path::PathBuf>,
    /// Finer grid for terrain: posts to the east and to the north [default: the file's]
    ///
    /// Heights are interpolated to these posts, so that a picture that is finer than the heights keeps its detail.
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = values::posts, help_heading = DATA)]
    pub(crate) posts: Option<[usize; 2]>,
}

/// Axes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UpAxis {
    X,
    Y,
    Z,
    #[value(name = "-x")]
    #[serde(rename = "-x")]
    MinusX,
    #[value(name = "-y")]
    #[serde(rename = "-y")]
    MinusY,
    #[value(name = "-z")]
    #[serde(rename = "-z")]
    MinusZ,
}

/// How Gaussians are composited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum GaussianModeName {
    /// 3dgs for Gaussians alone or with points; volumetric with anything else
    Auto,
    /// As published: whole Gaussians, with points and meshes, sorted by their centres
    #[value(name = "3dgs")]
    Published,
    /// In sheets, together with everything else: no popping, linear light
    Volumetric,
}

impl From<GaussianModeName> for GaussianMode {
    fn from(name: GaussianModeName) -> Self {
        match name {
            GaussianModeName::Auto => Self::Auto,
            GaussianModeName::Published => Self::Published,
            GaussianModeName::Volumetric => Self::Volumetric,
        }
    }
}
