//! Transfer functions of other programs.
//!
//! | format | read | written | data values | opacity per |
//! |---|---|---|---|---|
//! | 3D Slicer volume property `.vp.json` | yes | yes | as stored | `scalarOpacityUnitDistance` |
//! | ParaView preset `.json` | yes | yes | as stored; 0..1 is stretched over the data | mean voxel spacing |
//! | Inviwo `.itf` | yes | no | 0..1 of the data's range, or as stored | mean voxel spacing |
//! | ImageJ `.lut` | yes | no | the data's range | mean voxel spacing, a linear ramp |
//!
//! Contents decide, not names, except for headerless `.lut` files. Anything beyond colour and opacity (light, further
//! components) is left out, with a warning if it would change the picture. Gradient opacity, which is not part of a
//! [`TransferFunction`], also gives a warning; [`read_gradient_opacity`] reads it. [`two_dimensional`] has a format of
//! our own.

mod color_space;
pub mod imagej;
pub mod inviwo;
pub mod paraview;
pub mod slicer;
pub mod two_dimensional;

use std::path::Path;

use splatvol_scene::{ColorPoint, GradientOpacityPoint, OpacityPoint, TransferFunction};
pub use two_dimensional::read_transfer_function_2d;

use crate::IoError;
use crate::error::Context;
use crate::source::read_file;

/// Reads a transfer function of any supported format, for data whose values span `value_range`. The second part lists
/// oddities.
///
/// # Errors
/// See [`IoError`]; malformed points are named by their place in the file.
pub fn read_transfer_function(
    path: impl AsRef<Path>,
    value_range: [f64; 2],
) -> Result<(TransferFunction, Vec<String>), IoError> {
    let path = path.as_ref();
    let bytes = read_file(path, &Context::new("transfer function", path))?;
    let is_lut = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("lut"));
    let start = bytes
        .iter()
        .find(|byte| !byte.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(byte));
    match start {
        _ if is_lut => imagej::decode(&bytes, value_range, path),
        Some(b'{') => slicer::decode(&bytes, value_range, path),
        Some(b'[') => paraview::decode(&bytes, value_range, path),
        Some(b'<') => inviwo::decode(&bytes, value_range, path),
        _ => Err(Context::new("transfer function", path)
            .unsupported("neither Slicer's or ParaView's JSON, nor Inviwo's XML, nor an ImageJ .lut")),
    }
}

/// The warning of [`read_transfer_function`] if [`read_gradient_opacity`] would find something.
pub const GRADIENT_OPACITY_LEFT_OUT: &str =
    "gradientOpacity is no part of the transfer function and was left out";

/// Reads the gradient opacity of a 3D Slicer volume property: magnitudes in data units per world length. `None` where
/// the file has none, has switched it off, or it is 1 everywhere, and for files of other formats.
///
/// # Errors
/// Same as [`read_transfer_function`].
pub fn read_gradient_opacity(path: impl AsRef<Path>) -> Result<Option<Vec<GradientOpacityPoint>>, IoError> {
    let path = path.as_ref();
    let bytes = read_file(path, &Context::new("transfer function", path))?;
    let is_json = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let start = bytes
        .iter()
        .find(|byte| !byte.is_ascii_whitespace() && !b"\xef\xbb\xbf".contains(byte));
    if is_json && start == Some(&b'{') {
        slicer::decode_gradient_opacity(&bytes, path)
    } else {
        Ok(None)
    }
}

/// Writes a transfer function: `.vp.json` for 3D Slicer, any other `.json` for ParaView.
///
/// # Errors
/// [`IoError::Unsupported`] for other names, [`IoError::Encode`] where the format needs what the function lacks,
/// [`IoError::Write`].
pub fn write_transfer_function(path: impl AsRef<Path>, function: &TransferFunction) -> Result<(), IoError> {
    let path = path.as_ref();
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default()
        .to_ascii_lowercase();
    let text = if name.ends_with(".vp.json") {
        slicer::encode(function)?
    } else if name.ends_with(".json") {
        paraview::encode(function)?
    } else {
        return Err(Context::new("transfer function", path).unsupported("names end in .vp.json or .json"));
    };
    std::fs::write(path, text).map_err(|source| IoError::Write {
        source,
        path: path.to_owned(),
    })
}

/// Contents of a file before validation.
struct Draft {
    colors: Vec<ColorPoint>,
    opacities: Vec<OpacityPoint>,
    unit_distance: Option<f64>,
    warnings: Vec<String>,
}

impl Draft {
    /// The validated function; points that are out of order or useless give warnings.
    fn finish(
        mut self,
        value_range: [f64; 2],
        context: &Context<'_>,
    ) -> Result<(TransferFunction, Vec<String>), IoError> {
        let colors: Vec<f64> = self.colors.iter().map(|point| point.value).collect();
        let opacities: Vec<f64> = self.opacities.iter().map(|point| point.value).collect();
        for (what, values) in [("color", colors), ("opacity", opacities)] {
            check_order(what, &values, &mut self.warnings);
            check_overlap(what, &values, value_range, &mut self.warnings);
        }
        let function = TransferFunction::new(self.colors, self.opacities, self.unit_distance)
            .map_err(|error| context.scene(error))?;
        Ok((function, self.warnings))
    }
}

fn check_order(what: &str, values: &[f64], warnings: &mut Vec<String>) {
    if let Some(index) = values.windows(2).position(|pair| pair[1] < pair[0]) {
        let next = index + 1;
        warnings.push(format!(
            "{what} point {next} ({}) lies before its predecessor ({}): points were sorted",
            values[next], values[index]
        ));
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if let Some(run) = sorted.chunk_by(|a, b| a == b).find(|run| run.len() > 2) {
        warnings.push(format!(
            "{} {what} points share the value {}: those between first and last have no effect",
            run.len(),
            run[0]
        ));
    }
}

fn check_overlap(what: &str, values: &[f64], [low, high]: [f64; 2], warnings: &mut Vec<String>) {
    let (first, last) = (
        values.iter().copied().fold(f64::INFINITY, f64::min),
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    );
    if last < low || first > high {
        warnings.push(format!(
            "all {what} points ({first} to {last}) lie outside the data's range {low} to {high}: it is constant"
        ));
    }
}
