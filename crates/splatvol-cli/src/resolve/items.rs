//! From what a scene says of an item, and from the flags that say the same of a single file, to the item.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use splatvol::{
    Compositing, Content, Grid, Item, LengthUnit, Mesh, PointLook, Rescale, Samples, View, Volume,
};
use splatvol_document::standing;
use splatvol_io::scene_file::Opacity;
use splatvol_io::{Data, DataKind, DataOptions, Description, LoadedData, SceneItem, data_kind, read_data};

use super::input::{self, Input, locate};
use super::item_keys::{Source, check, known_keys};
use super::look::{self, Look, Wishes};
use super::upright;
use super::upright::Up;
use crate::args::{LookArgs, UpAxis, values};
use crate::failure::{During, Failure, Step};
use crate::recipe::{InputRecipe, RawRecipe};
use crate::terminal::Terminal;

/// An item, and what its data want.
pub(crate) struct Loaded {
    pub(crate) item: Item,
    pub(crate) wishes: Wishes,
    /// Where to look from unless asked otherwise.
    pub(crate) preferred: Option<View>,
    /// Files that it was read from.
    pub(crate) files: Vec<PathBuf>,
}

/// Where and how items are read.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'a> {
    /// Whether warnings are errors.
    pub(crate) strict: bool,
    /// Folder in which relative paths are tried next.
    pub(crate) beside: Option<&'a Path>,
    /// How the sheets are composited: an automatic look depends on it.
    pub(crate) compositing: Compositing,
    /// Whether there is nothing else in the scene.
    pub(crate) alone: bool,
    pub(crate) terminal: &'a Terminal,
}

/// Kind of an item's file, and its path.
pub(crate) fn kind(item: &SceneItem, beside: Option<&Path>) -> Result<(DataKind, PathBuf), Failure> {
    let path = locate(Path::new(&item.file), beside);
    if item.file.starts_with("sample:") {
        return Ok((DataKind::Volume, path));
    }
    let kind = data_kind(&path, &options(item, false)?).during(Step::Input)?;
    Ok((kind, path))
}

/// Reads an item.
pub(crate) fn load(item: &SceneItem, source: Source, reading: Reading<'_>) -> Result<Loaded, Failure> {
    let (kind, path) = kind(item, reading.beside)?;
    check(item, source, kind.name(), known_keys(kind))?;
    let mut up = item.up.clone();
    // Which way is up is a question of each file, unless something else stands beside it or it was given a place.
    let stands = reading.alone && up.is_none() && !item.is_placed();
    let (mut wishes, mut preferred) = (Wishes::default(), None);
    let files;
    let (content, frame) = if kind == DataKind::Volume {
        let input = input::load(
            &input_recipe(item),
            reading.strict,
            reading.beside,
            reading.terminal,
        )?;
        if stands {
            up = Up::of(&input).said(&item.file, reading.terminal);
        }
        files = input.description.files.clone();
        preferred = input.sample.and_then(|sample| sample.preferred_view());
        let look = look_of(item, &input, reading)?;
        wishes = look.wishes;
        let item = look.item(input.volume);
        (item.content, DAffine3::IDENTITY)
    } else {
        let loaded = {
            let _spinner = reading.terminal.spinner(format!("Reading {}", item.file));
            let mut options = options(item, reading.strict)?;
            options.kind = Some(kind);
            read_data(&path, &options).during(Step::Input)?
        };
        for warning in &loaded.description.warnings {
            reading.terminal.warn(format!("{}: {warning}", item.file));
        }
        files = loaded.description.files.clone();
        let frameless = kind == DataKind::Points && loaded.description.format.starts_with("PLY");
        let (content, frame) = content(item, source, loaded, reading)?;
        if frameless && stands && is_y_up(&content) {
            let note = format!("{}: it stands with y up; --up says otherwise", item.file);
            reading.terminal.detail(note);
            up = Some("y".to_owned());
        }
        (content, frame)
    };
    let placed = SceneItem { up, ..item.clone() };
    let place = item.world_from_file();
    let place = place.map_err(|(key, value)| source.refuse(item, key, &format!("{value} makes no place")))?;
    let world_from_item = place * turn(&placed, source)?.map_or(DAffine3::IDENTITY, |up| up * frame);
    Ok(Loaded {
        item: Item::new(content).at(world_from_item),
        wishes,
        preferred,
        files,
    })
}

/// Whether points stand on y.
fn is_y_up(content: &Content) -> bool {
    match content {
        Content::Points { points, .. } => standing::is_y_up(points.positions()),
        _ => false,
    }
}

/// Content of an item that is no volume, and the map from its world to the frame of its file.
fn content(
    item: &SceneItem,
    source: Source,
    loaded: LoadedData,
    reading: Reading<'_>,
) -> Result<(Content, DAffine3), Failure> {
    Ok(match loaded.data {
        Data::Points(points) => {
            let content = Content::Points {
                points: Arc::new(points),
                look: point_look(item, source)?,
            };
            (content, DAffine3::IDENTITY)
        }
        Data::Gaussians(gaussians) => {
            let frame = gaussians.world_from_local().inverse();
            (Content::Gaussians(Arc::new(gaussians)), frame)
        }
        Data::Mesh(mesh) => {
            let input = values_of(&mesh, loaded.description)?;
            let look = look_of(item, &input, reading)?;
            let item = Item::mesh(mesh, look.transfer_function);
            (item.content, DAffine3::IDENTITY)
        }
        Data::Volume(volume) => {
            let input = Input {
                volume: Arc::new(volume),
                description: loaded.description,
                sample: None,
            };
            let look = look_of(item, &input, reading)?;
            let item = look.item(input.volume);
            (item.content, DAffine3::IDENTITY)
        }
    })
}

fn point_look(item: &SceneItem, source: Source) -> Result<PointLook, Failure> {
    let default = PointLook::default();
    let color = item.color.unwrap_or(default.color);
    let opacity = match item.opacity {
        Some(Opacity::Share(share)) => share,
        _ => default.opacity,
    };
    let unit = |value: &f64| (0.0..=1.0).contains(value);
    if !color.iter().all(unit) {
        return Err(source.refuse(item, "color", &format!("{color:?} is not in 0..1")));
    }
    if !unit(&opacity) {
        return Err(source.refuse(item, "point-opacity", &format!("{opacity} is not in 0..1")));
    }
    if let Some(radius) = item
        .radius
        .filter(|radius| !(radius.is_finite() && *radius > 0.0))
    {
        return Err(source.refuse(item, "radius", &format!("{radius} is not a length above zero")));
    }
    Ok(PointLook {
        color,
        opacity,
        radius: item.radius,
    })
}

/// Samples of a row at most.
const ROW: usize = 32_768;

/// A mesh's values as rows of samples: what a transfer function is chosen by.
fn values_of(mesh: &Mesh, description: Description) -> Result<Input, Failure> {
    let mut values = mesh.field().values.clone();
    // Rows of a grid are not endless; what is missing in the last one does not count.
    let width = values.len().clamp(1, ROW);
    let rows = values.len().div_ceil(width);
    values.resize(rows * width, f32::NAN);
    let volume = Grid::centred([width, rows, 1], DVec3::ONE)
        .and_then(|grid| {
            Volume::new(
                grid,
                Samples::F32(values.into()),
                Rescale::default(),
                LengthUnit::Unknown,
            )
        })
        .during(Step::Input)?;
    Ok(Input {
        volume: Arc::new(volume),
        description,
        sample: None,
    })
}

fn look_of(item: &SceneItem, input: &Input, reading: Reading<'_>) -> Result<Look, Failure> {
    let args = LookArgs {
        tf: item.tf.as_deref().map(|tf| locate(Path::new(tf), reading.beside)),
        cmap: item.cmap.clone(),
        opacity: match &item.opacity {
            Some(Opacity::Curve(name)) => Some(name.clone()),
            _ => None,
        },
        clim: item.clim,
        unit_distance: item.unit_distance,
        iso: item.iso,
    };
    look::resolve(&args, input, reading.compositing, reading.terminal)
}

/// The file of an item as the reader of volumes takes it.
fn input_recipe(item: &SceneItem) -> InputRecipe {
    let raw = item
        .dims
        .zip(item.sample_type.clone())
        .map(|(dims, sample_type)| RawRecipe {
            dims,
            sample_type,
            spacing: item.spacing.unwrap_or([1.0; 3]),
            big_endian: item.endian.as_deref() == Some("big"),
            offset: item.offset.unwrap_or(0),
        });
    InputRecipe {
        reference: item.file.clone(),
        raw,
        array: item.array.clone(),
        component: item.component,
        time: item.time.unwrap_or(0),
        channel: item.channel,
        level: item.level.unwrap_or(0),
        series: item.series.clone(),
        // It is turned when it gets its place.
        up: None,
    }
}

/// How the file of an item is read.
pub(crate) fn options(item: &SceneItem, strict: bool) -> Result<DataOptions, Failure> {
    let usage = |key: &str, why: String| Failure::usage(format!("{}: {key}: {why}", item.file));
    if item.dims.is_some() != item.sample_type.is_some() {
        return Err(usage("dims", "needs type too, and type needs dims".to_owned()));
    }
    if let Some(endian) = &item.endian {
        values::endian(endian).map_err(|why| usage("endian", why))?;
    }
    if let Some(kind) = &item.sample_type {
        values::sample_type(kind).map_err(|why| usage("type", why))?;
    }
    let kind = item.kind.as_deref().map(str::parse::<DataKind>).transpose();
    Ok(DataOptions {
        kind: kind.map_err(|why| usage("kind", why))?,
        read: input::options(&input_recipe(item), strict)?,
        drape: item.drape.as_ref().map(PathBuf::from),
        posts: item.posts,
    })
}

/// Rotation that turns the file's upward axis to z, if one is named.
fn turn(item: &SceneItem, source: Source) -> Result<Option<DAffine3>, Failure> {
    let Some(name) = &item.up else {
        return Ok(None);
    };
    let axis = UpAxis::from_str(name, false)
        .map_err(|_| source.refuse(item, "up", &format!("{name} is none of x, y, z, -x, -y, -z")))?;
    Ok(Some(upright::rotation(axis)))
}

/// Reads all items that are visible.
pub(crate) fn load_all(
    items: &[SceneItem],
    source: impl Fn(usize) -> Source,
    reading: Reading<'_>,
) -> Result<Vec<Loaded>, Failure> {
    items
        .iter()
        .enumerate()
        .filter(|(_, item)| item.visible != Some(false))
        .map(|(index, item)| load(item, source(index), reading))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_named_axis_becomes_z_by_a_rotation() {
        for (name, axis) in [
            ("x", DVec3::X),
            ("-x", DVec3::NEG_X),
            ("y", DVec3::Y),
            ("-y", DVec3::NEG_Y),
            ("z", DVec3::Z),
            ("-z", DVec3::NEG_Z),
        ] {
            let item = SceneItem {
                up: Some(name.to_owned()),
                ..SceneItem::default()
            };
            let up = turn(&item, Source::Flags).unwrap().unwrap();
            assert_eq!(up.transform_vector3(axis), DVec3::Z, "{name}");
            assert_eq!(up.matrix3.determinant(), 1.0, "{name}");
        }
    }
}
