//! Flags about what is done to material before it is seen, and about what is cut away.

use std::path::PathBuf;

use clap::Args;
use splatvol::{ClipPlane, GradientOpacityPoint};
use splatvol_document::keys::names::TextureName;

use super::help::{CAMERA, EFFECTS, LOOK};
use super::values;

/// Corners of a box: x0, x1, y0, y1, z0, z1, world.
pub(crate) type BoxSides = [f64; 6];

/// A curve over gradient magnitudes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GradientCurve(pub(crate) Vec<GradientOpacityPoint>);

/// Operators, clips and exact isosurfaces.
#[derive(Debug, Clone, Default, PartialEq, Args)]
pub(crate) struct EffectArgs {
    /// Colour the material as if it were cut from a block of this
    #[arg(long, value_name = "NAME", help_heading = EFFECTS)]
    pub(crate) texture: Option<TextureName>,
    /// Distance between veins of marble, share of the volume's diagonal [default: 0.08]
    ///
    /// Rings of wood are a third of it apart.
    #[arg(long, value_name = "SHARE", value_parser = values::finite, help_heading = EFFECTS)]
    pub(crate) texture_scale: Option<f64>,
    /// Emboss surfaces with a picture (PNG, EXR)
    ///
    /// Bright parts of the picture are raised, by bending the normals. It is wound around the volume's z axis, its
    /// middle in front (+y).
    #[arg(long, value_name = "PICTURE", help_heading = EFFECTS)]
    pub(crate) bump: Option<PathBuf>,
    /// How far --bump raises white, share of the volume's diagonal; negative engraves [default: 0.01]
    #[arg(long, value_name = "SHARE", value_parser = values::finite, help_heading = EFFECTS, allow_negative_numbers = true)]
    pub(crate) bump_height: Option<f64>,
    /// Mirror the surroundings, given as an equirectangular picture (PNG, EXR)
    #[arg(long, value_name = "PICTURE", help_heading = EFFECTS)]
    pub(crate) environment: Option<PathBuf>,
    /// Share of the light that the reflection of --environment replaces [default: 0.5]
    #[arg(long, value_name = "SHARE", value_parser = values::finite, help_heading = EFFECTS)]
    pub(crate) environment_share: Option<f64>,
    /// Factors on opacity by the magnitude of the gradient: GRADIENT:FACTOR,GRADIENT:FACTOR,...
    ///
    /// Between the gradients, which are in data units per world length, the factor on extinction is linear.
    #[arg(long, value_name = "CURVE", value_parser = values::gradient_curve, help_heading = LOOK)]
    pub(crate) gradient_opacity: Option<GradientCurve>,
    /// Transfer function of value and gradient magnitude: JSON with regions or with a picture
    #[arg(long, value_name = "FILE", help_heading = LOOK, conflicts_with_all = ["tf", "cmap", "opacity", "iso", "clim"])]
    pub(crate) tf2d: Option<PathBuf>,
    /// Show the surface of --iso at its exact place, infinitely thin, hollow where it is cut
    #[arg(long, help_heading = EFFECTS)]
    pub(crate) iso_exact: bool,
    /// Keep one side of a plane, the normal's: X,Y,Z:NX,NY,NZ (point, normal)
    ///
    /// In world coordinates. Can be given more than once: what all planes keep is shown.
    #[arg(long, value_name = "PLANE", value_parser = values::clip_plane, help_heading = CAMERA,
          allow_hyphen_values = true)]
    pub(crate) clip_plane: Vec<ClipPlane>,
    /// Keep the inside of a box: X0,X1,Y0,Y1,Z0,Z1 in world coordinates
    #[arg(long, value_name = "BOX", value_parser = values::box_sides, help_heading = CAMERA,
          allow_hyphen_values = true)]
    pub(crate) clip_box: Option<BoxSides>,
    /// Keep the outside of the box of --clip-box instead
    #[arg(long, help_heading = CAMERA)]
    pub(crate) clip_inside: bool,
    /// Keep the inside of the box (undoes --clip-inside of a picture given with --like)
    #[arg(long, help_heading = CAMERA, conflicts_with = "clip_inside")]
    pub(crate) clip_outside: bool,
    /// Take no effects and no clipping from the picture given with --like
    #[arg(long, help_heading = EFFECTS)]
    pub(crate) no_effects: bool,
}
