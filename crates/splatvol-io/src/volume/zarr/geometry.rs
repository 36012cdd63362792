//! Axes of an array: which of them are space, which places along the others are taken, and where samples lie.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::LengthUnit;

use super::array::Array;
use super::level::Part;
use super::ome::{Axis, Image, Level};
use crate::IoError;
use crate::error::Context;
use crate::volume::{Description, Draft, ReadOptions, choose_channel, choose_time, length_unit};

/// The axes of an array; without OME's, the last of time, channel, z, y, x.
pub(super) fn axes(array: &Array, image: &Image) -> Vec<Axis> {
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
pub(super) fn spatial_sizes(array: &Array, image: &Image) -> [usize; 3] {
    let mut sizes = [1; 3];
    let axes = axes(array, image);
    let spatial = (0..axes.len()).rev().filter(|&i| is_spatial(&axes[i]));
    for (size, axis) in sizes.iter_mut().zip(spatial) {
        *size = array.shape[axis];
    }
    sizes
}

/// The part of an array to read, and the number of times. Channels are told in `description`.
pub(super) fn part(
    array: &Array,
    (axes, image): (&[Axis], &Image),
    description: &mut Description,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(Part, usize), IoError> {
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
            let names = channel_names(size, image);
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
    Ok((Part { place, spatial }, times))
}

fn channel_names(size: usize, image: &Image) -> Vec<String> {
    let name = |i: usize| match image.channels.get(i) {
        Some(name) if !name.is_empty() => name.clone(),
        _ => format!("channel {i}"),
    };
    // More than this are not channels, and are not listed.
    (0..size.min(4096)).map(name).collect()
}

/// World axes go by the names x, y, z; voxel axes by the order in memory.
pub(super) fn place(draft: &mut Draft, level: &Level, axes: &[Axis], spatial: &[usize]) {
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

/// Voxels of the finest level from those of a coarser one in the same box.
pub(super) fn finest_from_level(finest: [usize; 3], level: [usize; 3]) -> DAffine3 {
    let ratio = DVec3::from_array(std::array::from_fn(|axis| {
        finest[axis] as f64 / level[axis] as f64
    }));
    DAffine3::from_translation(0.5 * (ratio - DVec3::ONE)) * DAffine3::from_scale(ratio)
}
