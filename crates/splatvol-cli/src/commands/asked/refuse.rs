//! Refuses flags that have no meaning for the scene, by name.

use std::path::Path;

use splatvol::{Content, Item, RenderSettings, Scene};
use splatvol_document::Document;
use splatvol_document::format::path_outside;
use splatvol_document::keys::{ItemKeys, SettingKeys};

use crate::args::PictureArgs;
use crate::failure::{Failure, Step};

/// Flags that belong to one of several items are refused.
pub(super) fn no_item_flags(args: &PictureArgs, what: &str) -> Result<(), Failure> {
    if args.item_keys("") != ItemKeys::default() {
        return Err(Failure::usage(format!(
            "flags about reading, place, colour, opacity, radius and orientation have no meaning for {what}"
        )));
    }
    Ok(())
}

/// A picture of several items shows those and no others.
pub(super) fn other_items(
    (input, args): (Option<&str>, &PictureArgs),
    earlier: &Document,
) -> Result<(), Failure> {
    if earlier.items.len() < 2 {
        return Ok(());
    }
    no_item_flags(args, "the scene of an earlier picture")?;
    if input.is_some() {
        return Err(Failure::usage(
            "--like: the picture shows several items and says what is in it, so it takes no other input",
        ));
    }
    Ok(())
}

/// A picture's record names files in the current folder or the picture's, and below. Others are not read unless the
/// user says so: whoever made the picture chose them. `named` is the input that the user names.
pub(super) fn outside(
    (document, earlier): (&Document, &Document),
    picture: Option<&Path>,
    named: Option<&str>,
) -> Result<(), Failure> {
    let recorded = earlier.paths();
    let is_recorded = |path: &&str| recorded.contains(path) && named != Some(*path);
    let read = document.paths().into_iter().filter(is_recorded);
    if let Some(path) = path_outside(read, picture) {
        let refused = format!("{path}, which the picture names, lies outside its folder and this one");
        return Err(Failure::of(Step::Input, anyhow::anyhow!(refused))
            .hint("--allow-outside reads it; or name the input: --like PICTURE INPUT"));
    }
    Ok(())
}

/// Flags about Gaussians need Gaussians; flags about sheets need sheets.
pub(super) fn gaussians(args: &PictureArgs, scene: &Scene, settings: &RenderSettings) -> Result<(), Failure> {
    let has = |item: &Item| matches!(item.content, Content::Gaussians(_));
    if args.item.gaussians.is_some() && !scene.items.iter().any(has) {
        return Err(Failure::usage(match scene.single_volume() {
            Ok(_) => "--gaussians has no meaning for a volume",
            Err(_) => "--gaussians: there are none",
        }));
    }
    let method = args.method.keys(None);
    let method = if scene.is_gaussians() {
        method
    } else {
        method.without_light()
    };
    if scene.is_published(settings) && method != SettingKeys::default() {
        return Err(Failure::usage(
            "Gaussians are composited as published, where methods of sheets have no meaning, and light none but for points and \
             meshes beside them",
        )
        .hint("--gaussians volumetric composites them in sheets"));
    }
    Ok(())
}
