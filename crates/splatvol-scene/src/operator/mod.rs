//! Per-pixel operators: changes of material between classification and lighting.
//!
//! Image-aligned sheets of post-classified splatting hold the value, gradient and position of every pixel, like the
//! fragments of a surface renderer. So operations on fragments can be applied to sheets (huang2000 section 4.3). An
//! operator gets a [`SheetSample`] wherever a pixel's ray meets material between two sheets, and changes its
//! [`Appearance`]; then it is lit and composited. Operators run in the order in which a scene lists them.
//!
//! | operator | does |
//! |---|---|
//! | [`SolidTexture`] | colours material as if cut from marble or wood |
//! | [`BumpMap`] | bends normals by a picture wound around the volume |
//! | [`EnvironmentMap`] | mirrors a picture of the surroundings |
//! | [`GradientOpacity`] | scales extinction by a curve over the gradient's magnitude |
//! | [`TransferFunction2d`] | classifies by value and gradient magnitude together |
//!
//! Operators are applied only to samples that the scene's transfer function shows: an operator may hide or thin
//! material, or make it denser, but cannot make the invisible visible. A user's own operator:
//!
//! ```
//! use splatvol_scene::{Appearance, PixelOperator, SheetSample};
//!
//! /// Colours material by how far up it lies.
//! #[derive(Debug)]
//! struct HeightColors {
//!     low: f32,
//!     high: f32,
//! }
//!
//! impl PixelOperator for HeightColors {
//!     fn apply(&self, sample: &SheetSample, appearance: &mut Appearance) {
//!         let height = (sample.position.z - self.low) / (self.high - self.low);
//!         appearance.color = appearance.color.lerp(glam::Vec3::new(1.0, 0.1, 0.0), height.clamp(0.0, 1.0));
//!     }
//! }
//!
//! let operator = HeightColors { low: 0.0, high: 10.0 };
//! let sample = SheetSample {
//!     position: glam::Vec3::new(3.0, 1.0, 10.0),
//!     ..SheetSample::default()
//! };
//! let mut appearance = Appearance::default();
//! operator.apply(&sample, &mut appearance);
//! assert_eq!(appearance.color, glam::Vec3::new(1.0, 0.1, 0.0));
//! ```
//!
//! A scene takes it with [`Scene::with_operator`](crate::Scene::with_operator).

mod bump;
mod environment;
mod gradient_opacity;
mod marginal;
mod noise;
mod picture;
mod solid_texture;
mod transfer_function_2d;
mod wgsl;

use glam::Vec3;

pub use bump::BumpMap;
pub use environment::EnvironmentMap;
pub use gradient_opacity::{GradientOpacity, GradientOpacityPoint};
pub use noise::gradient_noise;
pub use solid_texture::{SolidTexture, Stuff};
pub use transfer_function_2d::{Region, TransferFunction2d};
pub use wgsl::WgslOperator;

/// Material that a pixel's ray meets between two sheets.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SheetSample {
    /// Value, data units.
    pub value: f32,
    /// Gradient of the value, world axes, data units per world length.
    pub gradient: Vec3,
    /// Position, world space.
    pub position: Vec3,
    /// Towards the viewer, world axes, length 1.
    pub view: Vec3,
    /// Camera depth, world length.
    pub depth: f32,
}

/// Appearance of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// Colour, linear light.
    pub color: Vec3,
    /// Extinction per world length.
    pub extinction: f32,
    /// Normal for lighting, world axes, length 1: out of the material, towards smaller values, or out of a cut.
    pub normal: Vec3,
    /// Share of a surface, 0 to 1: where it is 0, light leaves equally in all directions (see
    /// [`Lighting`](crate::Lighting)).
    pub surfaceness: f32,
    /// Light that is mirrored, linear.
    pub reflection: Vec3,
    /// Share of the lit colour that `reflection` replaces, 0 to 1.
    pub reflectance: f32,
}

impl Default for Appearance {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            extinction: 0.0,
            normal: Vec3::Z,
            surfaceness: 0.0,
            reflection: Vec3::ZERO,
            reflectance: 0.0,
        }
    }
}

/// A per-sample operator that changes the appearance of material.
pub trait PixelOperator: std::fmt::Debug + Send + Sync {
    /// Changes the appearance of a sample. Called from several threads, in any order: its effect may depend on the
    /// sample and nothing else, or pictures depend on the number of threads.
    fn apply(&self, sample: &SheetSample, appearance: &mut Appearance);

    /// Fewest pieces, each of them a sample, into which an interval between two sheets is cut for this operator.
    /// Two are enough for the scene's own classification, which is integrated; an operator's, which is sampled,
    /// needs more.
    fn pieces(&self) -> usize {
        2
    }

    /// The same for the GPU engine. `None`, unless an operator says otherwise: that engine then refuses the scene by name.
    fn wgsl(&self) -> Option<WgslOperator> {
        None
    }
}
