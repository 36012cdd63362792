//! Keys of what is done to material before it is seen, and of what is cut away.

use splatvol_scene::{ClipPlane, GradientOpacityPoint, Region};

use super::names::TextureName;
use super::{ItemKeys, keys};

keys! {
    /// Operators, clips and exact isosurfaces: the table `[effects]`.
    pub struct EffectKeys {
        /// Colours the material as if it were cut from a block of this.
        texture: TextureName,
        /// Distance between veins of marble, share of the volume's diagonal.
        texture_scale: f64,
        /// Picture that embosses surfaces: a file.
        bump: String,
        /// How far the bump raises white, share of the volume's diagonal; negative engraves.
        bump_height: f64,
        /// Surroundings that are mirrored: an equirectangular picture, a file.
        environment: String,
        /// Share of the light that the reflection replaces.
        environment_share: f64,
        /// Factors on opacity by the magnitude of the gradient, data units per world length.
        #[schemars(schema_with = "crate::schema::gradient_opacity")]
        gradient_opacity: Vec<GradientOpacityPoint>,
        /// Transfer function of value and gradient magnitude: a file.
        tf2d: String,
        /// Transfer function of value and gradient magnitude: soft rectangles of both.
        #[schemars(schema_with = "crate::schema::regions")]
        regions: Vec<Region>,
        /// Whether the surface of `iso` is shown at its exact place, infinitely thin.
        iso_exact: bool,
        /// Planes whose normals' side is kept, world.
        #[schemars(schema_with = "crate::schema::clip_planes")]
        clip_plane: Vec<ClipPlane>,
        /// Box that is kept, world: x0, x1, y0, y1, z0, z1.
        clip_box: [f64; 6],
        /// Whether the outside of the box is kept instead.
        clip_inside: bool,
    }
}

impl EffectKeys {
    /// These keys over those of another document; `asked` are the keys laid over its item. A new look does not keep
    /// what the earlier look's file said.
    #[must_use]
    pub fn over(self, below: &Self, asked: &ItemKeys, merged: &ItemKeys) -> Self {
        let mut below = below.clone();
        if asked.tf.is_some() {
            below.gradient_opacity = None;
        }
        if asked.tf.is_some() || asked.cmap.is_some() || asked.opacity.is_some() || asked.iso.is_some() {
            below.tf2d = None;
            below.regions = None;
        }
        if self.tf2d.is_some() {
            below.regions = None;
        }
        if self.regions.is_some() {
            below.tf2d = None;
        }
        if self.tf2d.is_some() || self.regions.is_some() || (asked.has_look() && merged.iso.is_none()) {
            below.iso_exact = None;
        }
        if self.clip_box.is_some() {
            below.clip_inside = None;
        }
        self.or(below)
    }
}
