//! The camera of a volume named by itself.

use splatvol::{Camera, TransferFunction};
use splatvol_document::visible::visible_outline;
use splatvol_document::{CameraKeys, CameraPose, Fit, Surroundings};

use super::input::Input;
use crate::args::CameraArgs;
use crate::failure::{During, Failure, Step};

/// Surroundings of a volume as it looks.
pub(crate) fn surroundings<'a>(
    args: &CameraArgs,
    input: &'a Input,
    transfer_function: &'a TransferFunction,
    aspect: f64,
) -> Surroundings<'a> {
    let fit = CameraKeys::from(args).fit.unwrap_or_default();
    let outline = move || match fit {
        Fit::Visible => visible_outline(&input.volume, transfer_function),
        Fit::Volume => input.volume.grid().corners().to_vec(),
    };
    let preferred = input.sample.and_then(|sample| sample.preferred_view());
    Surroundings::of_outline(outline, aspect).preferring(preferred)
}

/// The camera that the flags ask for; see [`CameraKeys::resolve`].
pub(crate) fn resolve(
    args: &CameraArgs,
    surroundings: &Surroundings<'_>,
    like: Option<&CameraPose>,
) -> Result<Camera, Failure> {
    CameraKeys::from(args)
        .resolve(surroundings, like)
        .during(Step::Usage)
}
