//! Flags about what data are and which way they are up; and about data other than volumes: points, Gaussians, meshes,
//! terrain.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use splatvol::GaussianMode;
use splatvol_io::DataKind;

use super::input::READING;
use super::values::{self, Triple};

const DATA: &str = "Points, Gaussians, meshes, terrain";

/// What the data are, and what only data other than volumes have.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct ItemArgs {
    /// What the input is: volume, points, terrain, depth-images, gaussians, mesh [default: what its contents say]
    #[arg(long, value_name = "KIND", value_parser = values::kind, help_heading = DATA)]
    pub(crate) kind: Option<DataKind>,
    /// Axis of the file that is up: it is turned to z. For volumes of the world as info gives it, whatever the file says; for Gaussians of the frame they were trained in [default: z, or y where a volume without orientation or a PLY file's points stand on it; Gaussians: -y]
    #[arg(long, value_name = "AXIS", help_heading = READING, allow_hyphen_values = true)]
    pub(crate) up: Option<UpAxis>,
    /// How Gaussians are composited [default: auto]
    #[arg(long, value_name = "MODE", help_heading = DATA)]
    pub(crate) gaussians: Option<GaussianModeName>,
    /// Radius of points, in the file's lengths [default: the file's, or what lies between neighbours]
    #[arg(long, value_name = "LENGTH", value_parser = values::finite, help_heading = DATA)]
    pub(crate) radius: Option<f64>,
    /// Colour of points that have none, sRGB 0..1 [default: 0.8,0.8,0.8]
    #[arg(long, value_name = "R,G,B", value_parser = values::triple, help_heading = DATA)]
    pub(crate) point_color: Option<Triple>,
    /// Opacity of points, 0..1 [default: 1]
    #[arg(long, value_name = "SHARE", value_parser = values::finite, help_heading = DATA, conflicts_with = "opacity")]
    pub(crate) point_opacity: Option<f64>,
    /// Picture of the same area, north at its top, that is laid over terrain
    #[arg(long, value_name = "PICTURE", help_heading = DATA)]
    pub(crate) drape: Option<std::path::PathBuf>,
    /// Posts to the east and to the north that heights of terrain are interpolated to, so that a finer picture keeps its detail [default: the file's]
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
    /// 3dgs where there are Gaussians, alone or with points; else volumetric
    Auto,
    /// As the published renderer: whole Gaussians, and points and meshes among them, sorted by their centres
    #[value(name = "3dgs")]
    Published,
    /// In sheets, with everything else: no popping, linear light
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
