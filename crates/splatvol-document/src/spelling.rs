//! Names that are written as text: what is expected, and which of the known ones was probably meant.

use splatvol_io::{DataKind, Endian, SampleType};
use splatvol_samples::SampleSize;
use splatvol_scene::{ColorMap, OpacityCurve};

use crate::keys::names::nearest;

/// Describes the expected names, and suggests the `known` one that is most like `name`.
fn expected<Name: AsRef<str>>(what: &str, name: &str, known: impl IntoIterator<Item = Name>) -> String {
    match nearest(name, known) {
        Some(nearest) => format!("expected {what}; did you mean '{}'?", nearest.as_ref()),
        None => format!("expected {what}"),
    }
}

/// A colour map by matplotlib's name; `_r` at its end reverses it.
///
/// # Errors
/// The expected names, as a message.
pub fn color_map(text: &str) -> Result<ColorMap, String> {
    let known = || ColorMap::names().flat_map(|name| [name.to_owned(), format!("{name}_r")]);
    let what = "a name of matplotlib's, such as viridis, turbo or gray_r";
    ColorMap::from_name(text).map_err(|_| expected(what, text, known()))
}

/// An opacity curve by its name.
///
/// # Errors
/// The expected names, as a message.
pub fn opacity_curve(text: &str) -> Result<OpacityCurve, String> {
    let known = || OpacityCurve::names().flat_map(|name| [format!("{name}_r"), name]);
    let what = "linear, geom, foreground, sigmoid or sigmoid_N (N: 1 to 10, 15, 20), with _r to reverse";
    OpacityCurve::from_name(text).map_err(|_| expected(what, text, known()))
}

/// The type of a sample: `u8`, `i16`...
///
/// # Errors
/// The expected names, as a message.
pub fn sample_type(text: &str) -> Result<SampleType, String> {
    let name = text.to_ascii_lowercase();
    let found = SampleType::ALL.iter().find(|kind| kind.name() == name);
    found.copied().ok_or_else(|| {
        let names: Vec<_> = SampleType::ALL.iter().map(|kind| kind.name()).collect();
        expected(&format!("one of {}", names.join(", ")), &name, &names)
    })
}

/// A kind of data.
///
/// # Errors
/// The expected names, as a message.
pub fn kind(text: &str) -> Result<DataKind, String> {
    text.parse().map_err(|_| {
        let names = DataKind::ALL.map(DataKind::name);
        expected(&format!("one of {}", names.join(", ")), text, names)
    })
}

/// A byte order.
///
/// # Errors
/// The expected names, as a message.
pub fn endian(text: &str) -> Result<Endian, String> {
    match text.to_ascii_lowercase().as_str() {
        "little" | "le" => Ok(Endian::Little),
        "big" | "be" => Ok(Endian::Big),
        name => Err(expected("little or big", name, ["little", "big"])),
    }
}

/// The size of a sample: N along the longest axis, or `XxYxZ`.
///
/// # Errors
/// The expected names, as a message.
pub fn sample_size(text: &str) -> Result<SampleSize, String> {
    if let Ok(longest) = text.parse() {
        return Ok(SampleSize::Longest(longest));
    }
    let sides = text
        .split(['x', 'X', ','])
        .map(|part| part.trim().parse::<usize>());
    let sides: Result<Vec<_>, _> = sides.collect();
    match sides.map(<[usize; 3]>::try_from) {
        Ok(Ok(dims)) if !dims.contains(&0) => Ok(SampleSize::Dims(dims)),
        _ => Err("expected N or XxYxZ, positive integers".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_get_the_nearest_one() {
        let near = |error: String, name: &str| {
            assert!(error.ends_with(&format!("did you mean '{name}'?")), "{error}");
        };
        near(color_map("virids").unwrap_err(), "viridis");
        near(color_map("coolwarn_r").unwrap_err(), "coolwarm_r");
        near(opacity_curve("sigmiod").unwrap_err(), "sigmoid");
        near(opacity_curve("sigmoid_21").unwrap_err(), "sigmoid_2");
        near(kind("gausians").unwrap_err(), "gaussians");
        near(sample_type("uu16").unwrap_err(), "u16");
        near(endian("litle").unwrap_err(), "little");
    }
}
