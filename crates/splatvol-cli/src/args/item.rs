//! Flags about what data are and which way they are up; and about data other than volumes: points, Gaussians, meshes,
//! terrain.

use clap::Args;
use splatvol_document::keys::names::{GaussianModeName, UpAxis};
use splatvol_document::keys::{Rotate, Scale};
use splatvol_io::DataKind;

use super::help::{DATA, INPUT};
use super::values::{self, Triple};

/// Kind and place of the data, and the properties of data other than volumes.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct ItemArgs {
    /// Kind of the input: volume, points, terrain, depth-images, gaussians or mesh [default: decided by its contents]
    #[arg(long, value_name = "KIND", value_parser = values::kind, help_heading = INPUT)]
    pub(crate) kind: Option<DataKind>,
    /// Axis of the file that points up [default: decided by the file and its contents]
    ///
    /// It is turned to z. For volumes it is an axis of the world as info prints it, whatever the file says of its
    /// orientation; for Gaussians, of the frame they were trained in. The default is z; -y for Gaussians; and y for
    /// points of a PLY file, and for volumes whose file gives no orientation, if they look as if they stood on it.
    #[arg(long, value_name = "AXIS", help_heading = INPUT, allow_hyphen_values = true)]
    pub(crate) up: Option<UpAxis>,
    /// Factor on lengths: S, or X,Y,Z
    #[arg(long, value_name = "FACTOR", value_parser = values::scale, help_heading = INPUT, allow_hyphen_values = true)]
    pub(crate) scale: Option<Scale>,
    /// Turn after scaling: AXIS:DEGREES, where AXIS is x, y, z or X,Y,Z
    ///
    /// Counter-clockwise as seen from the axis' end, about the world's origin.
    #[arg(long, value_name = "TURN", value_parser = values::rotation, help_heading = INPUT, allow_hyphen_values = true)]
    pub(crate) rotate: Option<Rotate>,
    /// Shift after turning, in world lengths
    #[arg(long, value_name = "X,Y,Z", value_parser = values::triple, help_heading = INPUT, allow_hyphen_values = true)]
    pub(crate) translate: Option<Triple>,
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
