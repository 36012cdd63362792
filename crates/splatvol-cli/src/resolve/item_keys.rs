//! Keys of an item, from flags or from a scene, and the kinds of data that they apply to.

use std::path::PathBuf;

use clap::ValueEnum;
use splatvol_io::scene_file::Opacity;
use splatvol_io::{DataKind, Endian, SceneItem};

use crate::args::{InputArgs, RenderArgs};
use crate::failure::Failure;

/// Who says what an item is: it is blamed for what makes no sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// Flags of the command line.
    Flags,
    /// Item of a scene, from 0.
    Scene(usize),
}

/// The flags of a single file as keys of a scene.
pub(crate) fn of_flags(args: &RenderArgs, reference: &str) -> SceneItem {
    let (look, item) = (&args.look, &args.item);
    let text = |path: &PathBuf| path.to_string_lossy().into_owned();
    let share = item.point_opacity.map(Opacity::Share);
    SceneItem {
        kind: item.kind.map(|kind| kind.name().to_owned()),
        up: item
            .up
            .and_then(|up| Some(up.to_possible_value()?.get_name().to_owned())),
        drape: item.drape.as_ref().map(text),
        posts: item.posts,
        tf: look.tf.as_ref().map(text),
        cmap: look.cmap.clone(),
        clim: look.clim,
        opacity: look.opacity.clone().map(Opacity::Curve).or(share),
        iso: look.iso,
        unit_distance: look.unit_distance,
        color: item.point_color,
        radius: item.radius,
        ..of_input(&args.read, reference)
    }
}

/// The flags of reading as keys of a scene.
pub(crate) fn of_input(read: &InputArgs, reference: &str) -> SceneItem {
    SceneItem {
        file: reference.to_owned(),
        dims: read.dims,
        sample_type: read.sample_type.map(|kind| kind.name().to_owned()),
        spacing: read.spacing,
        endian: read.endian.map(|endian| match endian {
            Endian::Little => "little".to_owned(),
            Endian::Big => "big".to_owned(),
        }),
        offset: read.offset,
        array: read.array.clone(),
        component: read.component,
        channel: read.channel,
        time: read.time,
        level: read.level,
        series: read.series.clone(),
        ..SceneItem::default()
    }
}

/// Refuses what says how to read an item that is not read so.
pub(crate) fn check_reading(item: &SceneItem, kind: DataKind) -> Result<(), Failure> {
    check(item, Source::Flags, kind.name(), known_keys(kind))
}

/// Keys that data have.
pub(super) fn known_keys(kind: DataKind) -> &'static [&'static str] {
    match kind {
        DataKind::Volume => &VOLUMES,
        DataKind::Points | DataKind::DepthImages => &POINTS,
        DataKind::Terrain => &TERRAIN,
        DataKind::Gaussians => &[],
        DataKind::Mesh => &MESHES,
    }
}

/// Keys of volumes.
const VOLUMES: [&str; 17] = [
    "dims",
    "type",
    "spacing",
    "endian",
    "offset",
    "array",
    "component",
    "channel",
    "time",
    "level",
    "series",
    "tf",
    "cmap",
    "clim",
    "opacity",
    "iso",
    "unit-distance",
];
/// Keys of meshes.
const MESHES: [&str; 7] = ["array", "tf", "cmap", "clim", "opacity", "iso", "unit-distance"];
/// Keys of points.
const POINTS: [&str; 3] = ["color", "point-opacity", "radius"];
/// Keys of terrain.
const TERRAIN: [&str; 10] = [
    "dims",
    "type",
    "spacing",
    "endian",
    "offset",
    "drape",
    "posts",
    "color",
    "point-opacity",
    "radius",
];

/// Refuses what cannot apply to the kind of data.
pub(super) fn check(item: &SceneItem, source: Source, what: &str, known: &[&str]) -> Result<(), Failure> {
    let given = [
        ("dims", item.dims.is_some()),
        ("type", item.sample_type.is_some()),
        ("spacing", item.spacing.is_some()),
        ("endian", item.endian.is_some()),
        ("offset", item.offset.is_some()),
        ("array", item.array.is_some()),
        ("component", item.component.is_some()),
        ("channel", item.channel.is_some()),
        ("time", item.time.is_some()),
        ("level", item.level.is_some()),
        ("series", item.series.is_some()),
        ("drape", item.drape.is_some()),
        ("posts", item.posts.is_some()),
        ("tf", item.tf.is_some()),
        ("cmap", item.cmap.is_some()),
        ("clim", item.clim.is_some()),
        ("opacity", matches!(item.opacity, Some(Opacity::Curve(_)))),
        ("point-opacity", matches!(item.opacity, Some(Opacity::Share(_)))),
        ("iso", item.iso.is_some()),
        ("unit-distance", item.unit_distance.is_some()),
        ("color", item.color.is_some()),
        ("radius", item.radius.is_some()),
    ];
    match given.iter().find(|(key, given)| *given && !known.contains(key)) {
        Some((key, _)) => Err(source.refuse(
            item,
            key,
            &format!("has no meaning for data of this kind: {what}"),
        )),
        None => Ok(()),
    }
}

impl Source {
    /// A failure that names the key as it was said.
    pub(super) fn refuse(self, item: &SceneItem, key: &str, why: &str) -> Failure {
        match self {
            Self::Flags => {
                let flag = match key {
                    "color" => "point-color",
                    key => key,
                };
                Failure::usage(format!("--{flag} {why} ({})", item.file))
            }
            Self::Scene(index) => {
                let key = key.strip_prefix("point-").unwrap_or(key);
                Failure::usage(format!("item[{index}].{key} {why} ({})", item.file))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_meaning_is_named_as_it_was_said() {
        let item = SceneItem {
            file: "a.ply".to_owned(),
            opacity: Some(Opacity::Share(0.5)),
            ..SceneItem::default()
        };
        let text = |source| format!("{:?}", check(&item, source, "volume", &VOLUMES).unwrap_err());
        assert!(
            text(Source::Flags)
                .contains("--point-opacity has no meaning for data of this kind: volume (a.ply)")
        );
        assert!(text(Source::Scene(2)).contains("item[2].opacity has no meaning"));
        assert!(check(&item, Source::Flags, "points", &POINTS).is_ok());
    }
}
