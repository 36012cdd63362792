//! Refuses flags that have no meaning for the data, by name.

use splatvol::{Content, Item, RenderSettings, Scene};

use crate::args::{ItemArgs, LookArgs, MethodArgs, RenderArgs};
use crate::failure::Failure;

/// Flags that belong to one of several items are refused.
pub(super) fn no_item_flags(args: &RenderArgs, what: &str) -> Result<(), Failure> {
    let (given, read) = (&args.item, &args.read);
    let of_item = ItemArgs {
        gaussians: None,
        ..given.clone()
    } != ItemArgs::default();
    let of_file = read.dims.is_some()
        || read.array.is_some()
        || read.component.is_some()
        || read.channel.is_some()
        || read.time.is_some()
        || read.level.is_some()
        || read.series.is_some();
    if of_item || of_file || args.look != LookArgs::default() {
        return Err(Failure::usage(format!(
            "flags about reading, colour, opacity, radius and orientation have no meaning for {what}"
        )));
    }
    Ok(())
}

/// Flags of other data are refused for a volume.
pub(super) fn no_volume_flags(args: &ItemArgs, reference: &str) -> Result<(), Failure> {
    let given = [
        ("--gaussians", args.gaussians.is_some()),
        ("--radius", args.radius.is_some()),
        ("--point-color", args.point_color.is_some()),
        ("--point-opacity", args.point_opacity.is_some()),
        ("--drape", args.drape.is_some()),
        ("--posts", args.posts.is_some()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((flag, _)) => Err(Failure::usage(format!(
            "{flag} has no meaning for a volume ({reference})"
        ))),
        None => Ok(()),
    }
}

/// Flags about Gaussians need Gaussians; flags about sheets need sheets.
pub(super) fn gaussians(args: &RenderArgs, scene: &Scene, settings: &RenderSettings) -> Result<(), Failure> {
    let has = |item: &Item| matches!(item.content, Content::Gaussians(_));
    if args.item.gaussians.is_some() && !scene.items.iter().any(has) {
        return Err(Failure::usage("--gaussians: there are none"));
    }
    let method = if scene.is_gaussians() {
        args.method.clone()
    } else {
        args.method.without_light()
    };
    if scene.is_published(settings) && method != MethodArgs::default() {
        return Err(Failure::usage(
            "Gaussians are composited as published, where methods of sheets have no meaning, and light none but for points and \
             meshes beside them",
        )
        .hint("--gaussians volumetric composites them in sheets"));
    }
    Ok(())
}
