//! Which way a volume is up: as it is said, as its file says, or as its data suggest; turned so that z is.
//!
//! An explicit axis overrides the file, as it does for other data: many programs write axes that they do not know. Axes are those
//! of the world as the file has it, in which `info` gives origin and directions.

use std::sync::Arc;

use clap::ValueEnum;
use glam::{DAffine3, DMat3, DVec3};
use serde::Serialize;
use splatvol_document::standing;

use super::input::Input;
use crate::args::UpAxis;
use crate::failure::{During, Failure, Step};
use crate::recipe::InputRecipe;
use crate::terminal::Terminal;

/// The axis that is up, and how it is known.
#[derive(Debug, Serialize)]
pub(crate) struct Up {
    pub(crate) axis: UpAxis,
    pub(crate) reason: String,
}

impl Up {
    /// That of a volume as it was stored, unless something else is said.
    pub(crate) fn of(input: &Input) -> Self {
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

    /// As `--up` takes it, where it is not z; says so.
    pub(super) fn said(&self, reference: &str, terminal: &Terminal) -> Option<String> {
        if self.axis == UpAxis::Z {
            return None;
        }
        terminal.detail(format!("{reference}: {} is up: {}", self.name(), self.reason));
        Some(self.name())
    }

    /// As `--up` takes it.
    pub(crate) fn name(&self) -> String {
        name(self.axis)
    }
}

impl Input {
    /// Turns the volume so that this axis becomes z.
    pub(crate) fn turn(&mut self, axis: UpAxis) -> Result<(), Failure> {
        Arc::make_mut(&mut self.volume)
            .transform(rotation(axis))
            .during(Step::Input)
    }

    /// Turns a volume of which nobody said which way is up, if its data do, and notes it in its recipe.
    pub(crate) fn stand_up(&mut self, recipe: &mut InputRecipe, terminal: &Terminal) -> Result<(), Failure> {
        if recipe.up.is_some() {
            return Ok(());
        }
        let up = Up::of(self);
        if up.said(&recipe.reference, terminal).is_some() {
            self.turn(up.axis)?;
            recipe.up = Some(up.axis);
        }
        Ok(())
    }
}

fn name(axis: UpAxis) -> String {
    axis.to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned())
}

/// The rotation that turns an axis to z.
pub(super) fn rotation(axis: UpAxis) -> DAffine3 {
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
