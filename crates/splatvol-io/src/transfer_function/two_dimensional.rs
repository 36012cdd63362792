//! Transfer functions of value and gradient magnitude, as JSON: soft regions, or a picture.
//!
//! ```json
//! { "unit-distance": 1.0,
//!   "regions": [ { "value": [200, 900], "gradient": [80, 400], "rgb": [0.9, 0.8, 0.7], "opacity": 0.5, "softness": 0.3 } ] }
//! { "image": "boundaries.png", "value": [-1000, 2000], "gradient": [0, 500] }
//! ```
//!
//! Values are data units, gradients data units per world length, colours sRGB, opacities per unit distance (world
//! length; the caller's default where it is absent). A picture's path is relative to the file's folder; its left and
//! right edge are the range of values, its bottom and top that of gradients.

use std::path::Path;

use serde::Deserialize;
use splatvol_scene::{Region, TransferFunction2d};

use crate::error::Context;
use crate::source::{companion, read_file};
use crate::{IoError, read_image};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct File {
    unit_distance: Option<f64>,
    #[serde(default)]
    regions: Vec<Region>,
    image: Option<String>,
    value: Option<[f64; 2]>,
    gradient: Option<[f64; 2]>,
}

/// Reads a two-dimensional transfer function. `unit_distance`: reference length of the opacities if the file has none.
///
/// # Errors
/// [`IoError::Format`] names the malformed field; a picture outside the file's folder; anything that [`read_image`]
/// refuses.
pub fn read_transfer_function_2d(
    path: impl AsRef<Path>,
    unit_distance: f64,
) -> Result<TransferFunction2d, IoError> {
    let path = path.as_ref();
    let context = Context::new("2-D transfer function", path);
    let bytes = read_file(path, &context)?;
    let file: File = serde_json::from_slice(&bytes).map_err(|error| {
        context.field(
            "contents",
            error,
            None,
            "regions, or an image with value and gradient",
        )
    })?;
    let unit_distance = file.unit_distance.unwrap_or(unit_distance);
    let (Some(name), true) = (&file.image, file.regions.is_empty()) else {
        if file.image.is_some() || file.value.is_some() || file.gradient.is_some() {
            return Err(context.field(
                "regions",
                file.regions.len(),
                None,
                "either regions, or an image with value and gradient",
            ));
        }
        return TransferFunction2d::new(&file.regions, unit_distance).map_err(|error| context.scene(error));
    };
    let (Some(value), Some(gradient)) = (file.value, file.gradient) else {
        return Err(context.field("image", name, None, "with the ranges value and gradient"));
    };
    let picture = read_image(companion(name, "image", None, &context)?)?;
    TransferFunction2d::from_image(&picture.image, value, gradient, unit_distance)
        .map_err(|error| context.scene(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<TransferFunction2d, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("look.json");
        std::fs::write(&path, text).unwrap();
        read_transfer_function_2d(&path, 2.0).map_err(|error| error.to_string())
    }

    #[test]
    fn regions_are_read_and_mistakes_are_named() {
        let region = r#"{"value": [0, 10], "gradient": [0, 4], "rgb": [1, 1, 1], "opacity": 0.5}"#;
        let own = read(&format!(r#"{{"regions": [{region}], "unit-distance": 1}}"#)).unwrap();
        let default = read(&format!(r#"{{"regions": [{region}]}}"#)).unwrap();
        let ln_2 = std::f32::consts::LN_2;
        assert!((own.classify(5.0, 2.0).1 - ln_2).abs() < 1e-6);
        assert!((default.classify(5.0, 2.0).1 - 0.5 * ln_2).abs() < 1e-6);
        for (text, words) in [
            ("{}", "at least one region"),
            (r#"{"regions": [{"value": [1, 0]}]}"#, "missing field"),
            (r#"{"image": "a.png"}"#, "value and gradient"),
            (
                r#"{"image": "../a.png", "value": [0, 1], "gradient": [0, 1]}"#,
                "inside the header's folder",
            ),
            (r#"{"opacity": 3}"#, "unknown field"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
