//! Requests that this engine refuses, by name; and the layers of those that it draws.

use std::sync::Arc;

use splatvol_core::engine::Shot;
use splatvol_core::scene_cloud::is_post_classified;
use splatvol_scene::{
    Classification, Content, Gradient, Isosurface, Item, Mesh, Method, Scene, SceneError, SheetSettings,
    Shows, SingleVolume, TransferFunction,
};

use crate::gaussians::published;

/// Largest radius of a kernel, voxels.
const MOST_RADIUS: f64 = 3.0;

/// The layers of a shot.
pub(crate) struct Drawn<'a> {
    /// A layer each.
    pub volumes: Vec<SingleVolume<'a>>,
    /// Post-classified, a layer each.
    pub meshes: Vec<DrawnMesh<'a>>,
    /// Everything that is classified before it is splatted: one layer.
    pub rest: Scene,
    /// Settings of the planes.
    pub sheets: SheetSettings,
}

/// A post-classified mesh.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DrawnMesh<'a> {
    pub item: &'a Item,
    pub mesh: &'a Arc<Mesh>,
    pub transfer_function: &'a TransferFunction,
    pub isosurfaces: &'a [Isosurface],
}

/// Checks that the GPU engine draws a shot, whatever the device.
///
/// # Errors
/// What it does not draw, by name.
pub fn check(shot: Shot<'_>) -> Result<(), SceneError> {
    match published(&shot)? {
        Some(_) => Ok(()),
        None => supported(&shot).map(|_| ()),
    }
}

/// The layers of a shot.
///
/// # Errors
/// What the GPU does not draw.
pub(crate) fn supported<'a>(shot: &Shot<'a>) -> Result<Drawn<'a>, SceneError> {
    let Method::Sheets(sheets) = shot.settings.method else {
        return refuse(
            "on the GPU, a method other than sheets",
            "the papers' methods are drawn by the engine cpu",
        );
    };
    if sheets.kernel.radius > MOST_RADIUS {
        return Err(SceneError::invalid(
            "kernel radius",
            sheets.kernel.radius,
            "at most 3 voxels on the GPU",
        ));
    }
    if shot.settings.motion_blur.moves_footprints()
        && shot.scene.items.iter().any(|item| item.motion.is_some())
    {
        return refuse(
            "on the GPU, footprints in motion",
            "motion is drawn by sub-frames, or by the engine cpu",
        );
    }
    if shot.scene.items.is_empty() {
        return Err(SceneError::invalid("items", 0, "at least one"));
    }
    let mut drawn = Drawn {
        volumes: Vec::new(),
        meshes: Vec::new(),
        rest: Scene::default(),
        sheets,
    };
    for item in &shot.scene.items {
        add(&mut drawn, shot.scene, item)?;
    }
    let fields = drawn.volumes.len() + drawn.meshes.len();
    if sheets.shows_one_value() && (fields != 1 || !drawn.rest.items.is_empty()) {
        return refuse(
            "maxima, minima or means of anything but one volume or mesh",
            "points and Gaussians have no values, and those of different fields do not compare",
        );
    }
    if sheets.shows == Shows::Xray && !drawn.rest.items.is_empty() && !shot.scene.clips.is_empty() {
        return refuse(
            "a clip in X-rays of anything but volumes",
            "whole splats are drawn one by one, classified first, without it; use image sheets",
        );
    }
    Ok(drawn)
}

/// Adds an item to the layers.
fn add<'a>(drawn: &mut Drawn<'a>, scene: &Scene, item: &'a Item) -> Result<(), SceneError> {
    let sheets = drawn.sheets;
    if item.operators.iter().any(|operator| operator.wgsl().is_none()) {
        return refuse(
            "on the GPU, an operator without WGSL",
            "its author wrote it in Rust alone; it is applied by the engine cpu",
        );
    }
    if let Some(single) = item.as_volume() {
        check_volume(scene, &single, &sheets.of_labels(single.labels))?;
        drawn.volumes.push(single);
        return Ok(());
    }
    if let Content::Mesh {
        mesh,
        transfer_function,
        isosurfaces,
    } = &item.content
        && is_post_classified(item, &sheets)
    {
        if sheets.gradient != Gradient::Differences {
            return Err(SceneError::invalid(
                "gradient",
                sheets.gradient,
                "differences: analytic gradients are of the kernels of grids, and the samples of meshes have kernels of their own",
            ));
        }
        if sheets.shows_one_value() {
            check_untouched(scene, item)?;
        }
        drawn.meshes.push(DrawnMesh {
            item,
            mesh,
            transfer_function,
            isosurfaces,
        });
        return Ok(());
    }
    if !item.clips.is_empty() || !item.operators.is_empty() || item.shows_isosurfaces() {
        return refuse(
            "an isosurface, an operator, or a clip of an item",
            "it is of volumes and meshes that are classified after splatting; points, Gaussians and what is classified first are \
             splatted without it",
        );
    }
    drawn.rest.items.push(item.clone());
    Ok(())
}

fn refuse<T>(what: &'static str, why: &'static str) -> Result<T, SceneError> {
    Err(SceneError::Combination { what, why })
}

fn check_volume(scene: &Scene, single: &SingleVolume<'_>, sheets: &SheetSettings) -> Result<(), SceneError> {
    if single.volume.chunks().is_some() {
        check_chunks(sheets)?;
    }
    let has_cut_faces =
        sheets.shows == Shows::Material(Classification::Post) && sheets.gradient == Gradient::Differences;
    let drops_voxels = matches!(sheets.shows, Shows::Xray | Shows::Material(Classification::Pre));
    let is_operated = single.item.shows_isosurfaces() || !single.item.operators.is_empty();
    if has_cut_faces || (drops_voxels && !is_operated) {
        return Ok(());
    }
    check_untouched(scene, single.item)
}

/// Refuses pictures for which all samples of a volume in chunks would have to be read.
fn check_chunks(sheets: &SheetSettings) -> Result<(), SceneError> {
    if sheets.splats_colors() {
        return refuse(
            "on the GPU, voxels of a volume in chunks that are classified first",
            "all samples of their level would have to be on the device; they are drawn by the engine cpu; or read the volume whole",
        );
    }
    if !sheets.prefilter {
        return refuse(
            "a volume that is read in chunks",
            "without the prefilter all samples must be in memory; leave the prefilter on, or read the volume whole",
        );
    }
    Ok(())
}

/// Refuses clips, isosurfaces and operators.
fn check_untouched(scene: &Scene, item: &Item) -> Result<(), SceneError> {
    let is_cut = !scene.clips.is_empty() || !item.clips.is_empty();
    if is_cut || item.shows_isosurfaces() || !item.operators.is_empty() {
        return refuse(
            "on the GPU, clips, isosurfaces or operators with analytic gradients, maxima, minima or means",
            "take the presets default, fast or draft, and composited material",
        );
    }
    Ok(())
}
