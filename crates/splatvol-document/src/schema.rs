//! The JSON schema of the document, for editors that check and complete scene files.

use schemars::generate::SchemaSettings;
use schemars::{Schema, SchemaGenerator, json_schema};

use crate::Document;

/// The schema (JSON Schema, draft 2020-12) of a document's JSON; a TOML file has the same keys.
pub fn schema() -> Schema {
    let generator = SchemaSettings::draft2020_12().into_generator();
    generator.into_root_schema_for::<Document>()
}

fn points(key: &str, of: serde_json::Value, is_function: bool) -> serde_json::Value {
    let mut properties = serde_json::json!({ "value": { "type": "number" }, key: of });
    if is_function {
        properties["midpoint"] = serde_json::json!({ "type": "number", "minimum": 0, "maximum": 1 });
        properties["sharpness"] = serde_json::json!({ "type": "number", "minimum": 0, "maximum": 1 });
    }
    serde_json::json!({
        "type": "array",
        "minItems": 1,
        "items": {
            "type": "object",
            "required": ["value", key],
            "additionalProperties": false,
            "properties": properties,
        },
    })
}

fn numbers(count: usize) -> serde_json::Value {
    serde_json::json!({
        "type": "array",
        "items": { "type": "number" },
        "minItems": count,
        "maxItems": count,
    })
}

/// Schema of a transfer function: colours (sRGB) and opacities over data values.
pub(crate) fn transfer_function(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "description": "The transfer function itself: what the keys above led to. It goes over them.",
        "type": "object",
        "required": ["colors", "opacities"],
        "additionalProperties": false,
        "properties": {
            "colors": points("rgb", numbers(3), true),
            "opacities": points("opacity", serde_json::json!({ "type": "number" }), true),
            "unit_distance": { "type": ["number", "null"] },
        },
    })
}

/// Schema of a curve of gradient opacity.
pub(crate) fn gradient_opacity(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array",
        "items": {
            "type": "object",
            "required": ["gradient", "factor"],
            "additionalProperties": false,
            "properties": { "gradient": { "type": "number" }, "factor": { "type": "number" } },
        },
    })
}

/// Schema of regions of values and gradient magnitudes.
pub(crate) fn regions(_: &mut SchemaGenerator) -> Schema {
    let share = serde_json::json!({ "type": "number", "minimum": 0, "maximum": 1 });
    json_schema!({
        "type": "array",
        "minItems": 1,
        "items": {
            "type": "object",
            "required": ["value", "gradient", "rgb", "opacity"],
            "additionalProperties": false,
            "properties": {
                "value": numbers(2),
                "gradient": numbers(2),
                "rgb": numbers(3),
                "opacity": share,
                "softness": share,
            },
        },
    })
}

/// Schema of clipping planes: a point and a normal each.
pub(crate) fn clip_planes(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array",
        "items": {
            "type": "object",
            "required": ["point", "normal"],
            "additionalProperties": false,
            "properties": { "point": numbers(3), "normal": numbers(3) },
        },
    })
}

/// Schema of a projection.
pub(crate) fn projection(_: &mut SchemaGenerator) -> Schema {
    let one = |name: &str, key: &str| {
        serde_json::json!({
            "type": "object",
            "required": [name],
            "additionalProperties": false,
            "properties": {
                name: {
                    "type": "object",
                    "required": [key],
                    "additionalProperties": false,
                    "properties": { key: { "type": "number" } },
                },
            },
        })
    };
    json_schema!({ "oneOf": [one("perspective", "fov_degrees"), one("orthographic", "height")] })
}
