//! Which way is up in a volume, or in points: as given, as its file says, or as its data suggest; the volume is turned so
//! that z is up.
//!
//! An explicit axis overrides the file, as it does for other data: many programs write axes that they do not know. Axes
//! are those of the world as the file has it, in which the command `info` gives origin and directions.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;
use splatvol_io::Description;
use splatvol_scene::Points;

use crate::input::Input;
use crate::keys::names::UpAxis;
use crate::{DocumentError, Listener, standing};

/// The axis that is up, and the reason for it.
#[derive(Debug, Serialize)]
pub struct Up {
    /// The axis.
    pub axis: UpAxis,
    /// The reason for it.
    pub reason: String,
}

impl Up {
    /// That of a volume as it was stored, unless an axis is given.
    pub fn of(input: &Input) -> Self {
        let (axis, reason) = if input.sample.is_some() {
            (UpAxis::Z, "by construction")
        } else if input.description.oriented {
            (UpAxis::Z, "as the file says how it lies; --up says otherwise")
        } else if standing::is_volume_y_up(&input.volume) {
            let reason = "the file does not say, and it stands on a heavy base across y; turned to z, --up says otherwise";
            (UpAxis::Y, reason)
        } else {
            let reason = "the file does not say, and it does not stand on y; --up says otherwise";
            (UpAxis::Z, reason)
        };
        Self {
            axis,
            reason: reason.to_owned(),
        }
    }

    /// That of points as they are stored, unless an axis is given: PLY files have no frame.
    pub fn of_points(points: &Points, description: &Description) -> Self {
        let is_frameless = description.format.starts_with("PLY");
        let (axis, reason) = if is_frameless && standing::is_y_up(points.positions()) {
            let reason = "the file does not say, and the points stand on y; turned to z, --up says otherwise";
            (UpAxis::Y, reason)
        } else if is_frameless {
            let reason = "the file does not say, and the points do not stand on y alone; --up says otherwise";
            (UpAxis::Z, reason)
        } else {
            (UpAxis::Z, "the file's own z; --up says otherwise")
        };
        Self {
            axis,
            reason: reason.to_owned(),
        }
    }

    /// The axis if it is not z; tells the listener.
    pub fn said(&self, file: &str, listener: &dyn Listener) -> Option<UpAxis> {
        if self.axis == UpAxis::Z {
            return None;
        }
        listener.detail(&format!("{file}: {} is up: {}", self.axis.name(), self.reason));
        Some(self.axis)
    }
}

impl Input {
    /// Turns the volume so that this axis becomes z.
    ///
    /// # Errors
    /// Never for a rotation by right angles of a valid volume.
    pub fn turn(&mut self, axis: UpAxis) -> Result<(), DocumentError> {
        Arc::make_mut(&mut self.volume).transform(rotation(axis))?;
        Ok(())
    }
}

/// The rotation that turns an axis to z.
pub fn rotation(axis: UpAxis) -> DAffine3 {
    let [x, y, z] = match axis {
        UpAxis::X => [DVec3::Z, DVec3::Y, DVec3::NEG_X],
        UpAxis::MinusX => [DVec3::NEG_Z, DVec3::Y, DVec3::X],
        UpAxis::Y => [DVec3::X, DVec3::Z, DVec3::NEG_Y],
        UpAxis::MinusY => [DVec3::X, DVec3::NEG_Z, DVec3::Y],
        UpAxis::Z => [DVec3::X, DVec3::Y, DVec3::Z],
        UpAxis::MinusZ => [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z],
    };
    DAffine3::from_mat3(DMat3::from_cols(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_named_axis_becomes_z_by_a_rotation() {
        for (axis, direction) in [
            (UpAxis::X, DVec3::X),
            (UpAxis::MinusX, DVec3::NEG_X),
            (UpAxis::Y, DVec3::Y),
            (UpAxis::MinusY, DVec3::NEG_Y),
            (UpAxis::Z, DVec3::Z),
            (UpAxis::MinusZ, DVec3::NEG_Z),
        ] {
            let up = rotation(axis);
            assert_eq!(up.transform_vector3(direction), DVec3::Z, "{axis:?}");
            assert_eq!(up.matrix3.determinant(), 1.0, "{axis:?}");
        }
    }
}
