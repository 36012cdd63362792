//! The Gaussians of a primitive.

use serde_json::Value;

use super::super::collect::{Collector, Splat};
use super::super::harmonics::harmonics_count;
use super::super::spz;
use super::EXTENSION;
use super::accessor;
use super::document::Document;
use crate::{IoError, ReadOptions};

const SPZ: &str = "KHR_gaussian_splatting_compression_spz_2";

/// Gaussians with the scales as they are in the file.
pub(super) struct Part {
    pub(super) collector: Collector,
    /// Scales are known to be lengths: they come from SPZ.
    are_lengths: bool,
}

impl Part {
    /// True where the scales can only be logarithms.
    pub(super) fn has_negative_scales(&self) -> bool {
        !self.are_lengths
            && self
                .collector
                .attributes()
                .scales
                .as_flattened()
                .iter()
                .any(|s| *s < 0.0)
    }

    /// Takes the scales, unless they are lengths, as logarithms.
    pub(super) fn exponentiate(&mut self) {
        if self.are_lengths {
            return;
        }
        for scale in self.collector.attributes_mut().scales.as_flattened_mut() {
            *scale = scale.exp();
        }
    }
}

/// The primitives of a mesh that are Gaussians.
pub(super) fn gaussians_of<'a>(document: &'a Document<'_>, mesh: u64) -> Result<Vec<&'a Value>, IoError> {
    let mesh = document.object("meshes", mesh)?;
    let primitives = mesh.get("primitives").and_then(Value::as_array);
    let primitives = primitives.map_or(&[][..], Vec::as_slice);
    Ok(primitives
        .iter()
        .filter(|primitive| extension(primitive).is_some())
        .collect())
}

fn extension(primitive: &Value) -> Option<&Value> {
    primitive.get("extensions")?.get(EXTENSION)
}

/// Reads a primitive that has the extension.
pub(super) fn read(
    document: &Document<'_>,
    primitive: &Value,
    options: &ReadOptions,
) -> Result<Part, IoError> {
    let context = document.context;
    let extension = extension(primitive).unwrap_or(&Value::Null);
    let kernel = extension
        .get("kernel")
        .and_then(Value::as_str)
        .unwrap_or("ellipse");
    if kernel != "ellipse" {
        return Err(context.field("kernel", kernel, None, "ellipse"));
    }
    let linear = extension.get("colorSpace").and_then(Value::as_str) == Some("lin_rec709_display");
    let inside = extension.get("extensions").and_then(|inside| inside.get(SPZ));
    let mut part = match inside {
        Some(inside) => {
            let view = document.whole(inside, "bufferView")?;
            let view = view.ok_or_else(|| context.field(SPZ, inside, None, "a bufferView"))?;
            let packed = spz::from_bytes(document.view(view)?.0.bytes, options, context)?;
            let mut collector = Collector::new(packed.count, packed.degree.min(3), options, context)?;
            packed.unpack(&mut collector);
            Part {
                collector,
                are_lengths: true,
            }
        }
        None => read_attributes(document, primitive, options)?,
    };
    if linear {
        part.collector.description.tags.push("linear".to_owned());
    }
    Ok(part)
}

fn read_attributes(
    document: &Document<'_>,
    primitive: &Value,
    options: &ReadOptions,
) -> Result<Part, IoError> {
    let context = document.context;
    let attributes = primitive.get("attributes").unwrap_or(&Value::Null);
    let find = |name: &str| document.whole(attributes, name);
    let require = |name: &str| {
        find(name)?.ok_or_else(|| context.field(format!("attribute {name}"), "(absent)", None, "an accessor"))
    };
    let own = |name: &str| format!("{EXTENSION}:{name}");
    let means = accessor::read::<3>(document, require("POSITION")?, "POSITION")?;
    let rotations = accessor::read::<4>(document, require(&own("ROTATION"))?, "ROTATION")?;
    let scales = accessor::read::<3>(document, require(&own("SCALE"))?, "SCALE")?;
    let opacities = accessor::read::<1>(document, require(&own("OPACITY"))?, "OPACITY")?;

    let name = |degree: u32, m: u32| own(&format!("SH_DEGREE_{degree}_COEF_{m}"));
    let mut degree = 0;
    while degree < 3 && find(&name(degree + 1, 0))?.is_some() {
        degree += 1;
    }
    let mut coefficients = Vec::with_capacity(harmonics_count(degree));
    for l in 0..=degree {
        for m in 0..=2 * l {
            let name = name(l, m);
            coefficients.push(accessor::read::<3>(document, require(&name)?, &name)?);
        }
    }
    let count = means.len();
    let lengths = [rotations.len(), scales.len(), opacities.len()];
    let lengths = lengths.into_iter().chain(coefficients.iter().map(Vec::len));
    if let Some(length) = lengths.into_iter().find(|length| *length != count) {
        let expected = format!("{count}, as POSITION has");
        return Err(context.field("count of an attribute", length, None, expected));
    }
    let mut collector = Collector::new(count as u64, degree, options, context)?;
    let mut harmonics = vec![[0.0; 3]; coefficients.len()];
    for index in 0..count {
        for (triple, values) in harmonics.iter_mut().zip(&coefficients) {
            *triple = values[index].map(|c| c as f32);
        }
        let splat = Splat {
            mean: means[index],
            scale: scales[index],
            rotation: rotations[index],
            opacity: opacities[index][0],
        };
        collector.push(&splat, &harmonics);
    }
    Ok(Part {
        collector,
        are_lengths: false,
    })
}
