//! Warnings of pictures that show nothing, and of surfaces of values that no sample has.

use splatvol::{Content, Frame};
use splatvol_document::Picture;

use super::info::tidy;
use crate::terminal::Terminal;

/// Whether no pixel shows anything. The first that does ends the search.
pub(super) fn is_empty(frame: &Frame) -> bool {
    frame.image.pixels.iter().all(|[.., alpha]| *alpha <= 0.0)
}

/// Warns where nothing is visible, and where the value of a surface lies outside the data's.
pub(super) fn warn(is_empty: bool, picture: &Picture, terminal: &Terminal) {
    let outside = values_outside(picture, is_empty);
    match (is_empty, outside.is_empty()) {
        (true, true) => terminal.warn("nothing is visible"),
        (true, false) => terminal.warn(format!("nothing is visible: {}", outside.join("; "))),
        (false, false) => terminal.warn(outside.join("; ")),
        (false, true) => {}
    }
}

/// Which values of surfaces lie outside the data's. The range of a volume in chunks is that of its overview, which tells
/// something only where nothing is visible.
fn values_outside(picture: &Picture, is_empty: bool) -> Vec<String> {
    let keys = picture.document.items.iter().enumerate();
    let visible = keys.filter(|(_, item)| item.is_visible());
    let several = picture.document.items.len() > 1 || picture.document.name.is_some();
    let outside = visible
        .zip(&picture.scene.items)
        .filter_map(|((index, keys), item)| {
            let [low, high] = match &item.content {
                Content::Volume { volume, .. } if is_empty || volume.chunks().is_none() => {
                    volume.value_range()
                }
                Content::Mesh { mesh, .. } => mesh.value_range().map(f64::from),
                _ => return None,
            };
            let value = keys.iso.filter(|value| !(low..=high).contains(value))?;
            let name = match several {
                true => format!("item[{index}].iso"),
                false => "--iso".to_owned(),
            };
            Some(format!(
                "{name} {} lies outside the values, {} to {}",
                tidy(value),
                tidy(low),
                tidy(high)
            ))
        });
    outside.collect()
}
