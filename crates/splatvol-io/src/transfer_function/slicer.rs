//! 3D Slicer's volume property (schema `volume-property-schema-v1.0.0`), a JSON form of VTK's `vtkVolumeProperty`.
//!
//! `volumeProperties[].components[]` hold `rgbTransferFunction` and `scalarOpacity` with points
//! `{x, color | y, midpoint, sharpness}` and `scalarOpacityUnitDistance` (world length, 1 where it is absent). The
//! first component of the first property counts. Points of equal `x` are a step, as in Slicer.

use std::path::Path;

use serde_json::{Value, json};
use splatvol_scene::{ColorPoint, GradientOpacityPoint, OpacityPoint, TransferFunction};

use super::Draft;
use crate::IoError;
use crate::error::Context;
use crate::json::{Node, parse};

/// The schema as Slicer itself writes it.
const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#";

/// Reads a volume property from the bytes of a file; `path` is only named in errors. See
/// [`super::read_transfer_function`].
///
/// # Errors
/// [`IoError::Format`] names the malformed field.
pub fn decode(
    bytes: &[u8],
    value_range: [f64; 2],
    path: &Path,
) -> Result<(TransferFunction, Vec<String>), IoError> {
    let context = Context::new("Slicer volume property", path);
    let document = parse(bytes, &context)?;
    let root = Node::root(&document, &context);
    let mut warnings = Vec::new();
    let property = first(&root.require("volumeProperties")?, &mut warnings)?;
    let component = first(&property.require("components")?, &mut warnings)?;
    if !gradient_points(&component)?.is_empty() {
        warnings.push(String::from(super::GRADIENT_OPACITY_LEFT_OUT));
    }
    let colors = match (
        component.get("rgbTransferFunction"),
        component.get("grayTransferFunction"),
    ) {
        (None, Some(gray)) => opacity_points(&gray)?.into_iter().map(gray_point).collect(),
        _ => color_points(&component.require("rgbTransferFunction")?)?,
    };
    let distance = component.get("scalarOpacityUnitDistance");
    let draft = Draft {
        colors,
        opacities: opacity_points(&component.require("scalarOpacity")?)?,
        unit_distance: Some(distance.map_or(Ok(1.0), |node| node.number())?),
        warnings,
    };
    draft.finish(value_range, &context)
}

/// The gradient opacity of the bytes of a file, if it has one that changes anything; see
/// [`super::read_gradient_opacity`].
///
/// # Errors
/// Same as [`decode`].
pub fn decode_gradient_opacity(
    bytes: &[u8],
    path: &Path,
) -> Result<Option<Vec<GradientOpacityPoint>>, IoError> {
    let context = Context::new("Slicer volume property", path);
    let document = parse(bytes, &context)?;
    let property = first(
        &Node::root(&document, &context).require("volumeProperties")?,
        &mut Vec::new(),
    )?;
    let component = first(&property.require("components")?, &mut Vec::new())?;
    let points = gradient_points(&component)?;
    Ok((!points.is_empty()).then_some(points))
}

/// Points of a component's gradient opacity; `None` if it changes nothing. Midpoints other than a half are treated as a
/// half, as in Slicer's own presets.
fn gradient_points(component: &Node<'_>) -> Result<Vec<GradientOpacityPoint>, IoError> {
    let disabled = component
        .get("disableGradientOpacity")
        .is_some_and(|node| node.is_true());
    let Some(gradient) = component.get("gradientOpacity").filter(|_| !disabled) else {
        return Ok(Vec::new());
    };
    let points = opacity_points(&gradient)?;
    if points.iter().all(|point| point.opacity == 1.0) {
        return Ok(Vec::new());
    }
    // Curves may begin below zero, where there are no magnitudes.
    let points = points.iter().map(|point| GradientOpacityPoint {
        gradient: point.value.max(0.0),
        factor: point.opacity,
    });
    Ok(points.collect())
}

/// The first element of an array that should have one.
fn first<'a>(list: &Node<'a>, warnings: &mut Vec<String>) -> Result<Node<'a>, IoError> {
    let items = list.items()?;
    if items.len() > 1 {
        warnings.push(format!(
            "only the first of {} {} was read",
            items.len(),
            list.name()
        ));
    }
    items
        .into_iter()
        .next()
        .ok_or_else(|| list.error("at least one element"))
}

fn gray_point(point: OpacityPoint) -> ColorPoint {
    ColorPoint {
        value: point.value,
        rgb: [point.opacity; 3],
        midpoint: point.midpoint,
        sharpness: point.sharpness,
    }
}

fn color_points(function: &Node<'_>) -> Result<Vec<ColorPoint>, IoError> {
    let point = |node: Node<'_>| -> Result<ColorPoint, IoError> {
        let color = node.require("color")?;
        let channels = color.items()?;
        let [r, g, b] = channels.as_slice() else {
            return Err(color.error("three numbers"));
        };
        Ok(ColorPoint {
            value: node.require("x")?.number()?,
            rgb: [r.unit()?, g.unit()?, b.unit()?],
            midpoint: optional(&node, "midpoint", 0.5)?,
            sharpness: optional(&node, "sharpness", 0.0)?,
        })
    };
    function
        .require("points")?
        .items()?
        .into_iter()
        .map(point)
        .collect()
}

fn opacity_points(function: &Node<'_>) -> Result<Vec<OpacityPoint>, IoError> {
    let point = |node: Node<'_>| -> Result<OpacityPoint, IoError> {
        Ok(OpacityPoint {
            value: node.require("x")?.number()?,
            opacity: node.require("y")?.unit()?,
            midpoint: optional(&node, "midpoint", 0.5)?,
            sharpness: optional(&node, "sharpness", 0.0)?,
        })
    };
    function
        .require("points")?
        .items()?
        .into_iter()
        .map(point)
        .collect()
}

fn optional(node: &Node<'_>, key: &str, default: f64) -> Result<f64, IoError> {
    node.get(key).map_or(Ok(default), |node| node.unit())
}

/// A volume property as the text of a file. Slicer's own lighting defaults are written with it.
///
/// # Errors
/// [`IoError::Encode`] where the function has no unit distance of its own: Slicer would take 1 for it, whatever the
/// voxel spacing is. Set it to the scene's beforehand.
pub fn encode(function: &TransferFunction) -> Result<String, IoError> {
    let format = "Slicer volume property";
    let Some(unit_distance) = function.unit_distance else {
        let what =
            String::from("the transfer function has no unit distance (set it to the volume's mean spacing)");
        return Err(IoError::Encode { format, what });
    };
    let color = |p: &ColorPoint| json!({"x": p.value, "color": p.rgb, "midpoint": p.midpoint, "sharpness": p.sharpness});
    let opacity = |p: &OpacityPoint| json!({"x": p.value, "y": p.opacity, "midpoint": p.midpoint, "sharpness": p.sharpness});
    let (colors, opacities) = (function.colors(), function.opacities());
    let values = || {
        colors
            .iter()
            .map(|p| p.value)
            .chain(opacities.iter().map(|p| p.value))
    };
    let range = [
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    ];
    let document = json!({
        "@schema": SCHEMA,
        "volumeProperties": [{
            "effectiveRange": range,
            "isoSurfaceValues": [],
            "independentComponents": true,
            "interpolationType": "linear",
            "useClippedVoxelIntensity": false,
            "clippedVoxelIntensity": 0.0,
            "scatteringAnisotropy": 0.0,
            "components": [{
                "componentWeight": 1.0,
                "shade": true,
                "lighting": {"diffuse": 0.7, "ambient": 0.1, "specular": 0.2, "specularPower": 10.0},
                "disableGradientOpacity": true,
                "scalarOpacityUnitDistance": unit_distance,
                "rgbTransferFunction": {
                    "type": "colorTransferFunction",
                    "points": colors.iter().map(color).collect::<Vec<Value>>(),
                },
                "scalarOpacity": {
                    "type": "piecewiseLinearFunction",
                    "points": opacities.iter().map(opacity).collect::<Vec<Value>>(),
                },
            }],
        }],
    });
    Ok(format!("{document:#}\n"))
}
