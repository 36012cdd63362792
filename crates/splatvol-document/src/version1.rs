//! Version 1 of the document: scene files whose settings have parts, and the recipes in PNGs of splatvol before it.

mod recipe;
mod scene;

pub(crate) use recipe::recipe;
pub(crate) use scene::{SceneFile, scene};
