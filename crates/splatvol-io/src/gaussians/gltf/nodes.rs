//! The nodes of the default scene and where they are.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::Value;

use crate::IoError;
use crate::error::Context;

/// A mesh in the scene.
pub(super) struct Instance {
    pub(super) mesh: u64,
    pub(super) scene_from_node: DAffine3,
}

/// All meshes of the default scene, or of the document if it has no scene.
pub(super) fn instances(json: &Value, context: &Context<'_>) -> Result<Vec<Instance>, IoError> {
    let array = |key: &str| {
        json.get(key)
            .and_then(Value::as_array)
            .map_or(&[][..], Vec::as_slice)
    };
    let (scenes, nodes) = (array("scenes"), array("nodes"));
    let Some(scene) = json.get("scene").map_or(Some(0), Value::as_u64) else {
        return Err(context.field("scene", &json["scene"], None, "an index"));
    };
    let Some(scene) = scenes.get(scene as usize) else {
        let meshes = 0..array("meshes").len() as u64;
        let instance = |mesh| Instance {
            mesh,
            scene_from_node: DAffine3::IDENTITY,
        };
        return Ok(meshes.map(instance).collect());
    };
    let mut seen = vec![false; nodes.len()];
    let mut open = indices(scene.get("nodes"), DAffine3::IDENTITY);
    open.reverse();
    let mut instances = Vec::new();
    while let Some((index, scene_from_parent)) = open.pop() {
        let Some(node) = nodes.get(index) else {
            return Err(context.field("nodes", index, None, "an index of a node"));
        };
        if std::mem::replace(&mut seen[index], true) {
            return Err(context.field(
                format!("nodes[{index}]"),
                "met twice",
                None,
                "nodes that form a tree",
            ));
        }
        let parent_from_node = transform(node).ok_or_else(|| {
            context.field(
                format!("nodes[{index}]"),
                "transform",
                None,
                "16, or 3, 4 and 3 numbers",
            )
        })?;
        let scene_from_node = scene_from_parent * parent_from_node;
        if let Some(mesh) = node.get("mesh").and_then(Value::as_u64) {
            instances.push(Instance {
                mesh,
                scene_from_node,
            });
        }
        let mut children = indices(node.get("children"), scene_from_node);
        children.reverse();
        open.append(&mut children);
    }
    Ok(instances)
}

fn indices(array: Option<&Value>, frame: DAffine3) -> Vec<(usize, DAffine3)> {
    let items = array.and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let index = |item: &Value| (item.as_u64().map_or(usize::MAX, |index| index as usize), frame);
    items.iter().map(index).collect()
}

fn numbers<const N: usize>(node: &Value, key: &str, default: [f64; N]) -> Option<[f64; N]> {
    let Some(value) = node.get(key) else {
        return Some(default);
    };
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

fn transform(node: &Value) -> Option<DAffine3> {
    if node.get("matrix").is_some() {
        let matrix = DMat4::from_cols_array(&numbers(node, "matrix", [0.0; 16])?);
        return Some(DAffine3::from_mat4(matrix));
    }
    let scale = DVec3::from_array(numbers(node, "scale", [1.0; 3])?);
    let rotation = DQuat::from_array(numbers(node, "rotation", [0.0, 0.0, 0.0, 1.0])?);
    let translation = DVec3::from_array(numbers(node, "translation", [0.0; 3])?);
    let rotation = if rotation.length() > 0.0 {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    };
    Some(DAffine3::from_scale_rotation_translation(
        scale,
        rotation,
        translation,
    ))
}
