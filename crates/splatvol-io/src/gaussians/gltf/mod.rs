//! glTF 2.0 (`.gltf`, `.glb`) with `KHR_gaussian_splatting`, and SPZ inside it (`..._compression_spz_2`).
//!
//! Every primitive with the extension is a cloud in the frame of its node. Clouds are joined in the frame of the first:
//! means, scales, rotations and harmonics of the others are moved there, which similarities allow; a node that shears
//! or scales axes differently from the first is refused. Rotations are x y z w, opacities 0..1. Scales are lengths
//! since the extension was ratified and were logarithms in its drafts: a file with negative scales is one of those,
//! with a warning.
//!
//! `gltf` the crate does not know the extension and drops its attributes, so the document is read as plain JSON.

mod accessor;
mod document;
mod nodes;
mod primitive;

use std::path::Path;

use glam::DAffine3;
use serde_json::Value;

use super::collect::Collector;
use super::frame::{self, RUB};
use super::{LoadedGaussians, transform};
use crate::error::Context;
use crate::{IoError, ReadOptions};
use document::Document;
use primitive::Part;

/// Name of the extension.
const EXTENSION: &str = "KHR_gaussian_splatting";

/// True where the document uses the extension.
///
/// # Errors
/// A file that begins as glTF does but is not glTF.
pub(super) fn is_gaussians(path: &Path) -> Result<bool, IoError> {
    let context = Context::new("glTF", path);
    let (json, _) = document::parse(path, &context)?;
    let used = json.get("extensionsUsed").and_then(Value::as_array);
    Ok(used.is_some_and(|used| used.iter().any(|name| name.as_str() == Some(EXTENSION))))
}

/// Reads all Gaussians of the default scene.
///
/// # Errors
/// Anything that does not fit in the document or its buffers, nodes that cannot be joined, no Gaussians in the scene.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new("glTF", path).following(options);
    let document = &Document::open(path, options, context)?;
    let mut parts = Vec::new();
    let mut count = 0;
    for instance in nodes::instances(&document.json, context)? {
        for primitive in primitive::gaussians_of(document, instance.mesh)? {
            let part = primitive::read(document, primitive, options)?;
            count += part.collector.len();
            // A Gaussian takes at least a byte: only many copies of one mesh exceed this count.
            if count > document.bytes() {
                return Err(context.limit(count as u64, document.bytes() as u64));
            }
            parts.push((instance.scene_from_node, part));
        }
    }
    let logarithms = parts.iter().any(|(_, part)| part.has_negative_scales());
    let (scene_from_local, mut collector) = join(parts, logarithms, options, context)?;
    if logarithms {
        collector.warn("scales are negative, so they are taken as logarithms, as in drafts of the extension");
    }
    collector.description.format = format!("glTF 2.0, {EXTENSION}");
    collector.description.orientation = "y up, turned to z up".to_owned();
    for file in &document.files {
        collector.add_file(file.clone());
    }
    collector.finish(frame::world_from_local(RUB) * scene_from_local, context)
}

/// One cloud in the frame of the first.
fn join(
    parts: Vec<(DAffine3, Part)>,
    logarithms: bool,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(DAffine3, Collector), IoError> {
    let count = parts.iter().map(|(_, part)| part.collector.len() as u64).sum();
    let degree = parts.iter().map(|(_, part)| part.collector.degree()).max();
    let mut joined = Collector::new(count, degree.unwrap_or(0), options, context)?;
    joined.description.stored_type = format!("{} primitives", parts.len());
    let mut first = None;
    for (scene_from_node, mut part) in parts {
        if logarithms {
            part.exponentiate();
        }
        let scene_from_first = *first.get_or_insert(scene_from_node);
        let first_from_node = if scene_from_node == scene_from_first {
            DAffine3::IDENTITY
        } else {
            scene_from_first.inverse() * scene_from_node
        };
        let degree = part.collector.degree();
        if !transform::transform(part.collector.attributes_mut(), degree, &first_from_node) {
            let expected = "a similarity to the first node with Gaussians";
            return Err(context.field("transform of a node", first_from_node.matrix3, None, expected));
        }
        joined.append(part.collector);
    }
    let linear = joined.description.tags.iter().any(|tag| tag == "linear");
    if linear {
        joined.warn("colours are linear (lin_rec709_display) and shown as if they were sRGB");
    }
    Ok((first.unwrap_or(DAffine3::IDENTITY), joined))
}
