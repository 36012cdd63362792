//! The place of an item: scale, rotation and shift.

use glam::{DAffine3, DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use splatvol_scene::rotation::about;

use super::ItemKeys;
use crate::DocumentError;

/// Factor on lengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a factor, or three: [x, y, z]")]
pub enum Scale {
    /// One factor for all axes.
    Uniform(f64),
    /// One for each axis.
    Axes([f64; 3]),
}

/// A rotation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "[axis, degrees], where axis is \"x\", \"y\", \"z\" or [x, y, z]; or the three rows of a rotation matrix"
)]
pub enum Rotate {
    /// Axis and degrees, counter-clockwise as seen from the axis' end.
    Axis(Axis, f64),
    /// Rows of a matrix.
    Matrix([[f64; 3]; 3]),
}

/// Axis of a rotation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Axis {
    /// `x`, `y` or `z`.
    Name(String),
    /// A direction.
    Direction([f64; 3]),
}

impl ItemKeys {
    /// Whether the document places the item.
    pub fn is_placed(&self) -> bool {
        self.scale.is_some() || self.rotate.is_some() || self.translate.is_some()
    }

    /// Placement of the item: `translate + rotate * scale`, without `up`.
    ///
    /// # Errors
    /// Keys that do not make an invertible place, by name.
    pub fn world_from_file(&self) -> Result<DAffine3, DocumentError> {
        let refused = |key: &str, value: String| {
            let path = format!("item.{key}");
            DocumentError::refused(&path, format!("{value} makes no place")).of_item(&self.file)
        };
        let scale = match self.scale {
            None => DVec3::ONE,
            Some(Scale::Uniform(scale)) => DVec3::splat(scale),
            Some(Scale::Axes(axes)) => DVec3::from_array(axes),
        };
        if !(scale.is_finite() && scale.abs().min_element() > 0.0) {
            return Err(refused("scale", format!("{:?}", scale.to_array())));
        }
        let rotation = match &self.rotate {
            None => DMat3::IDENTITY,
            Some(rotate) => rotate.matrix().ok_or_else(|| refused("rotate", rotate.shown()))?,
        };
        let shift = DVec3::from_array(self.translate.unwrap_or_default());
        if !shift.is_finite() {
            return Err(refused("translate", format!("{:?}", shift.to_array())));
        }
        let linear = rotation * DMat3::from_diagonal(scale);
        Ok(DAffine3::from_mat3_translation(linear, shift))
    }
}

impl Rotate {
    /// As a scene file has it.
    fn shown(&self) -> String {
        let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Self::Axis(Axis::Name(name), degrees) => format!("[\"{name}\", {degrees}]"),
            Self::Axis(Axis::Direction(axis), degrees) => format!("[[{}], {degrees}]", list(axis)),
            Self::Matrix(rows) => format!("[{}]", rows.map(|row| format!("[{}]", list(&row))).join(", ")),
        }
    }

    /// The matrix, if it is a rotation.
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
                    .then(|| DMat3::from_quat(about(axis, degrees.to_radians())))
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
