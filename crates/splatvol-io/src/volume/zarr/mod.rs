//! OME-Zarr 0.1 to 0.5 in a local folder, and bare Zarr arrays, of versions 2 and 3.
//!
//! Read: chunks and shards, plain or compressed by Blosc, gzip, zlib, zstd or LZ4; level, channel and time by the
//! options. The reader is our own: the crate for Zarr brings compressors in C and about a hundred other crates. Not
//! read: plates, label images except by their own folder, data types other than real numbers.

mod array;
mod blosc;
mod chunks;
mod codec;
mod ome;

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::LengthUnit;

use super::{
    Description, Draft, Loaded, ReadOptions, checked_dims, choose_channel, choose_time, length_unit,
    sample_count,
};
use crate::IoError;
use crate::error::Context;
use crate::source::check_inside;
use array::Array;
use chunks::Part;
use ome::{Axis, Image, Level};

/// True for the folder of a group or an array.
pub(super) fn is_zarr(folder: &Path) -> bool {
    [".zgroup", ".zarray", ".zattrs", "zarr.json"]
        .iter()
        .any(|name| folder.join(name).is_file())
}

/// Reads an image or an array.
///
/// # Errors
/// See [`IoError`].
pub fn read(folder: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("OME-Zarr", folder).following(options);
    if let Some(array) = Array::open(folder)? {
        let level = Level {
            path: String::new(),
            scale: Vec::new(),
            translation: Vec::new(),
        };
        choose_level(&[[0; 3]], options, context)?;
        return load(&array, &Image::default(), &level, Description::default(), options);
    }
    let attributes = ome::attributes(folder)?.unwrap_or_default();
    let Some(image) = Image::new(&attributes, context)? else {
        return read_series(folder, attributes.get("plate").is_some(), options, context);
    };
    let mut arrays = Vec::new();
    for level in &image.levels {
        let path = folder.join(&level.path);
        check_inside(&path, folder, context)?;
        let array = Array::open(&path)?;
        arrays.push(array.ok_or_else(|| IoError::MissingDataFile {
            data: path,
            path: folder.to_owned(),
        })?);
    }
    let levels: Vec<[usize; 3]> = arrays.iter().map(|array| spatial_sizes(array, &image)).collect();
    let chosen = choose_level(&levels, options, context)?;
    let mut description = Description {
        levels,
        ..Description::default()
    };
    if image.others > 0 {
        let warning = format!("the first of {} multi-scale images is read", image.others + 1);
        description.warnings.push(warning);
    }
    load(
        &arrays[chosen],
        &image,
        &image.levels[chosen],
        description,
        options,
    )
}

/// A folder of several images, as bioformats2raw writes them: `0`, `1`, ...
fn read_series(
    folder: &Path,
    plate: bool,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Loaded, IoError> {
    if plate {
        return Err(context.unsupported("a plate; name the folder of one of its images"));
    }
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .map_err(|error| context.read(error))?
        .flatten()
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()) && is_zarr(&entry.path()))
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort_by(|a, b| super::detect::natural_order(a, b));
    let asked = |name: &&String| options.series.as_ref().is_none_or(|series| series == *name);
    // OME's own metadata are not an image.
    names.retain(|name| name != "OME");
    let Some(name) = names.iter().find(asked) else {
        let what = match &options.series {
            Some(series) => format!(
                "series \"{series}\" was asked for; there are {}",
                names.join(", ")
            ),
            None => "neither multiscales nor an array".to_owned(),
        };
        return Err(context.unsupported(what));
    };
    let inner = folder.join(name);
    check_inside(&inner, folder, context)?;
    if Array::open(&inner)?.is_none()
        && ome::attributes(&inner)?.is_none_or(|value| value.get("multiscales").is_none())
    {
        return Err(context.unsupported(format!("neither multiscales nor an array, here and in {name}")));
    }
    let mut loaded = read(&inner, options)?;
    if names.len() > 1 {
        if options.series.is_none() {
            let warning = format!("series {name} is read; there are {}", names.join(", "));
            loaded.description.warnings.push(warning);
        }
        loaded.description.series = names;
    }
    Ok(loaded)
}

fn choose_level(
    levels: &[[usize; 3]],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    if options.level < levels.len() {
        return Ok(options.level);
    }
    let list: Vec<String> = levels
        .iter()
        .enumerate()
        .map(|(i, [x, y, z])| format!("{i}: {x} x {y} x {z}"))
        .collect();
    let what = format!(
        "level {} was asked for; there are {}",
        options.level,
        list.join(", ")
    );
    Err(context.unsupported(what))
}

/// The axes of an array; without OME's, the last of time, channel, z, y, x.
fn axes(array: &Array, image: &Image) -> Vec<Axis> {
    let count = array.shape.len();
    if image.axes.len() == count {
        return image.axes.clone();
    }
    let names = ["", "", "", "t", "c", "z", "y", "x"];
    let axis = |name: &str| Axis {
        name: name.to_owned(),
        ..Axis::default()
    };
    names[names.len() - count..]
        .iter()
        .map(|name| axis(name))
        .collect()
}

fn is_spatial(axis: &Axis) -> bool {
    axis.kind == "space" || (axis.kind.is_empty() && matches!(axis.name.as_str(), "x" | "y" | "z"))
}

/// Samples along x, y, z of the grid: the fastest axis is x.
fn spatial_sizes(array: &Array, image: &Image) -> [usize; 3] {
    let mut sizes = [1; 3];
    let axes = axes(array, image);
    let spatial = (0..axes.len()).rev().filter(|&i| is_spatial(&axes[i]));
    for (size, axis) in sizes.iter_mut().zip(spatial) {
        *size = array.shape[axis];
    }
    sizes
}

fn load(
    array: &Array,
    image: &Image,
    level: &Level,
    mut description: Description,
    options: &ReadOptions,
) -> Result<Loaded, IoError> {
    let context = &Context::new("Zarr array", &array.folder).following(options);
    let axes = axes(array, image);
    let spatial: Vec<usize> = (0..axes.len()).filter(|&i| is_spatial(&axes[i])).collect();
    if !(1..=3).contains(&spatial.len()) {
        let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
        let what = format!(
            "{} axes of space among {}; 1 to 3 are read",
            spatial.len(),
            names.join(", ")
        );
        return Err(context.unsupported(what));
    }
    let mut place = vec![0; axes.len()];
    let mut times = 0;
    for (i, axis) in axes.iter().enumerate() {
        let size = array.shape[i];
        if spatial.contains(&i) {
        } else if axis.kind == "time" || axis.name == "t" {
            place[i] = choose_time(size, options, context)?;
            times = size;
        } else if axis.kind == "channel" || axis.name == "c" {
            let name = |i: usize| match image.channels.get(i) {
                Some(name) if !name.is_empty() => name.clone(),
                _ => format!("channel {i}"),
            };
            // More than this are not channels, and are not listed.
            let names: Vec<String> = (0..size.min(4096)).map(name).collect();
            let (channel, warning) = choose_channel(&names, options, context)?;
            place[i] = channel;
            description.warnings.extend(warning);
            description.channels = if size > 1 { names } else { Vec::new() };
        } else if size > 1 {
            let what = format!(
                "axis {i} \"{}\" of {size} places, which is neither space, time nor channel",
                axis.name
            );
            return Err(context.unsupported(what));
        }
    }
    description.format = match image.version.as_str() {
        "" => format!("Zarr {}", array.version),
        version => format!("OME-Zarr {version} (Zarr {})", array.version),
    };
    description.stored_type = array.stored_type();
    description.orientation = match level.scale.is_empty() {
        true => "no geometry in the file, spacing 1".to_owned(),
        false => "scale and translation of OME; the file does not say how an object lies".to_owned(),
    };
    description.files = vec![array.folder.clone()];
    let sizes = spatial_sizes(array, image).map(|size| i64::try_from(size).unwrap_or(i64::MAX));
    let mut draft = Draft::new(checked_dims(&sizes, "shape", None, context)?, description);
    draft.set_times(times, options);
    geometry(&mut draft, level, &axes, &spatial);
    draft.grid(context)?;
    sample_count(draft.dims, 1, array.sample_type, options, context)?;
    let samples = chunks::read(array, &Part { place, spatial }, context)?;
    draft.finish(samples, context)
}

/// World axes go by the names x, y, z; voxel axes by the order in memory.
fn geometry(draft: &mut Draft, level: &Level, axes: &[Axis], spatial: &[usize]) {
    let scale = |axis: usize| level.scale.get(axis).copied().unwrap_or(1.0);
    let translation = |axis: usize| level.translation.get(axis).copied().unwrap_or(0.0);
    let mut columns = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut free = vec![DVec3::X, DVec3::Y, DVec3::Z];
    let mut origin = DVec3::ZERO;
    let mut absent = vec![0, 1, 2];
    for (voxel, &axis) in spatial.iter().rev().enumerate() {
        let direction = match axes[axis].name.as_str() {
            "x" => DVec3::X,
            "y" => DVec3::Y,
            "z" => DVec3::Z,
            _ => columns[voxel],
        };
        free.retain(|other| *other != direction);
        absent.retain(|&other| other != voxel);
        columns[voxel] = direction * scale(axis);
        origin += direction * translation(axis);
    }
    // Flat axes take the remaining directions and the first axis's spacing.
    let length = columns[0].length();
    for (voxel, direction) in absent.into_iter().zip(free) {
        columns[voxel] = direction * length;
    }
    draft.world_from_voxel =
        DAffine3::from_mat3_translation(DMat3::from_cols(columns[0], columns[1], columns[2]), origin);
    let units: Vec<&str> = spatial.iter().map(|&axis| axes[axis].unit.as_str()).collect();
    let unit = units.first().copied().unwrap_or_default();
    draft.unit = match length_unit(unit).filter(|_| units.iter().all(|other| *other == unit)) {
        Some(unit) => unit,
        None => {
            draft.warn(format!("units are not kept: {}", units.join(", ")));
            LengthUnit::Unknown
        }
    };
}
