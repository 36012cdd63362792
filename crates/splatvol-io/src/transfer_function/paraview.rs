//! ParaView's colour presets: a JSON array of `{Name, ColorSpace, RGBPoints, Points, ...}`.
//!
//! `RGBPoints` is a flat list of `x r g b`, `Points` one of `x opacity midpoint sharpness`. The first preset with
//! `RGBPoints` counts. Presets of ParaView's library span 0..1 and are stretched over the data, as ParaView does when
//! it applies them; others keep their data values. Opacities refer to ParaView's own unit distance, which the file
//! does not hold and which by default is about a voxel.

use std::path::Path;

use serde_json::{Value, json};
use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

use super::Draft;
use super::color_space::ColorSpace;
use crate::IoError;
use crate::error::Context;
use crate::json::{Node, parse};

/// Reads a preset from the bytes of a file; `path` is only named in errors. See [`super::read_transfer_function`].
///
/// # Errors
/// [`IoError::Format`] names the malformed field.
pub fn decode(
    bytes: &[u8],
    value_range: [f64; 2],
    path: &Path,
) -> Result<(TransferFunction, Vec<String>), IoError> {
    let context = Context::new("ParaView preset", path);
    let document = parse(bytes, &context)?;
    let presets = Node::root(&document, &context).items()?;
    let mut warnings = Vec::new();
    let with_colors: Vec<_> = presets
        .iter()
        .filter(|preset| preset.get("RGBPoints").is_some())
        .collect();
    let Some(preset) = with_colors.first() else {
        return Err(context.unsupported("no preset has RGBPoints (indexed colours are not supported)"));
    };
    if with_colors.len() > 1 {
        let name = preset
            .get("Name")
            .and_then(|node| node.text())
            .unwrap_or("(unnamed)");
        warnings.push(format!(
            "only the first of {} presets was read: {name}",
            with_colors.len()
        ));
    }
    if preset.get("UseLogScale").is_some_and(|node| node.is_true()) {
        warnings.push(String::from(
            "UseLogScale is not supported: the preset is read as linear",
        ));
    }
    let space_name = preset
        .get("ColorSpace")
        .and_then(|node| node.text())
        .unwrap_or("RGB");
    let space = ColorSpace::from_name(space_name).unwrap_or_else(|| {
        warnings.push(format!(
            "ColorSpace {space_name} is not supported: interpolated as RGB"
        ));
        ColorSpace::Rgb
    });
    let mut colors = color_points(&preset.require("RGBPoints")?)?;
    let mut opacities = preset
        .get("Points")
        .map_or_else(|| Ok(Vec::new()), |points| opacity_points(&points))?;
    colors.sort_by(|a, b| a.value.total_cmp(&b.value));
    colors = space.refine(&colors);
    if opacities.is_empty() {
        warnings.push(String::from(
            "the preset has no opacities: a linear ramp over its colours",
        ));
        let ends = [colors.first(), colors.last()]
            .into_iter()
            .flatten()
            .map(|point| point.value);
        opacities = ends
            .zip([0.0, 1.0])
            .map(|(value, opacity)| OpacityPoint::new(value, opacity))
            .collect();
    }
    stretch(&mut colors, &mut opacities, value_range, &mut warnings);
    let draft = Draft {
        colors,
        opacities,
        unit_distance: None,
        warnings,
    };
    draft.finish(value_range, &context)
}

/// Stretches points that span exactly 0..1 over data that have another range.
fn stretch(
    colors: &mut [ColorPoint],
    opacities: &mut [OpacityPoint],
    [low, high]: [f64; 2],
    warnings: &mut Vec<String>,
) {
    let spans_unit =
        colors.first().is_some_and(|p| p.value == 0.0) && colors.last().is_some_and(|p| p.value == 1.0);
    let opacities_fit = opacities.iter().all(|p| (0.0..=1.0).contains(&p.value));
    let data_in_unit = low >= 0.0 && high <= 1.0;
    if !spans_unit || !opacities_fit || data_in_unit {
        return;
    }
    warnings.push(format!(
        "the preset spans 0 to 1: stretched over the data's range {low} to {high}"
    ));
    let values = colors
        .iter_mut()
        .map(|p| &mut p.value)
        .chain(opacities.iter_mut().map(|p| &mut p.value));
    values.for_each(|value| *value = low + *value * (high - low));
}

/// The quadruples of a flat list.
fn quadruples<'a>(list: &Node<'a>, expected: &str) -> Result<Vec<[Node<'a>; 4]>, IoError> {
    let items = list.items()?;
    if items.is_empty() || !items.len().is_multiple_of(4) {
        return Err(list.error(expected));
    }
    let mut items = items.into_iter();
    let mut quadruples = Vec::new();
    while let (Some(a), Some(b), Some(c), Some(d)) = (items.next(), items.next(), items.next(), items.next())
    {
        quadruples.push([a, b, c, d]);
    }
    Ok(quadruples)
}

fn color_points(list: &Node<'_>) -> Result<Vec<ColorPoint>, IoError> {
    let point =
        |[x, r, g, b]: &[Node<'_>; 4]| Ok(ColorPoint::new(x.number()?, [r.unit()?, g.unit()?, b.unit()?]));
    quadruples(list, "x, r, g, b for every point")?
        .iter()
        .map(point)
        .collect()
}

fn opacity_points(list: &Node<'_>) -> Result<Vec<OpacityPoint>, IoError> {
    let point = |[x, opacity, midpoint, sharpness]: &[Node<'_>; 4]| {
        Ok(OpacityPoint {
            value: x.number()?,
            opacity: opacity.unit()?,
            midpoint: midpoint.unit()?,
            sharpness: sharpness.unit()?,
        })
    };
    quadruples(list, "x, opacity, midpoint, sharpness for every point")?
        .iter()
        .map(point)
        .collect()
}

/// A preset as the text of a file. Colour points with a midpoint or a sharpness, which presets cannot hold, are
/// replaced by finely spaced plain ones. The unit distance is not part of the format.
///
/// # Errors
/// None today; the signature is that of the other writers.
pub fn encode(function: &TransferFunction) -> Result<String, IoError> {
    let colors = plain(function);
    let rgb: Vec<f64> = colors
        .iter()
        .flat_map(|p| [p.value, p.rgb[0], p.rgb[1], p.rgb[2]])
        .collect();
    let opacity = |p: &OpacityPoint| [p.value, p.opacity, p.midpoint, p.sharpness];
    let document = json!([{
        "Name": "splatvol",
        "ColorSpace": "RGB",
        "RGBPoints": rgb,
        "Points": function.opacities().iter().flat_map(opacity).map(Value::from).collect::<Vec<Value>>(),
        "NanColor": [0.0, 0.0, 0.0],
    }]);
    Ok(format!("{document:#}\n"))
}

/// Colour points whose interpolation is linear.
fn plain(function: &TransferFunction) -> Vec<ColorPoint> {
    const PIECES: usize = 64;
    let points = function.colors();
    let mut plain = Vec::new();
    for (index, point) in points.iter().enumerate() {
        plain.push(ColorPoint::new(point.value, point.rgb));
        let is_linear = point.midpoint == 0.5 && point.sharpness < 0.01;
        if let Some(next) = points
            .get(index + 1)
            .filter(|next| !is_linear && next.value > point.value)
        {
            plain.extend((1..PIECES).map(|i| {
                let value = point.value + (next.value - point.value) * i as f64 / PIECES as f64;
                ColorPoint::new(value, function.color(value))
            }));
        }
    }
    plain
}
