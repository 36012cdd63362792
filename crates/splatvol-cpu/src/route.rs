//! Which engine renders a scene.
//!
//! | scene | engine |
//! |---|---|
//! | Gaussians, alone or with points | `splats`, as the published renderer does, unless the settings say otherwise |
//! | one volume, wherever it lies | `sheets`; or `classic`, where the method is splats |
//! | everything else on sheets | `sheets`: every volume and mesh a layer, and all the rest one more, a cloud |
//! | one mesh, each ray showing one of its values | `sheets`, as a layer |
//! | X-rays of volumes among others | `sheets`, each volume by itself, and `splats`, all the rest as one cloud: optical depths add up |
//! | everything else splat by splat, and its X-rays | `splats`: one cloud of classified splats |
//!
//! A volume is brought to its place by its grid: `world_from_voxel = world_from_item * item_from_voxel`.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DAffine3;
use splatvol_core::level::VolumeLook;
use splatvol_core::scene_cloud::{self, is_post_classified};
use splatvol_scene::operator::PixelOperator;
use splatvol_scene::{
    Clip, Content, Isosurface, Item, Mesh, Method, Motion, RenderSettings, Scene, SceneError, SheetSettings,
    Shows, SingleVolume, SplatSettings, TransferFunction, Volume,
};

use crate::clouds::SplatScene;

/// Render loop of a scene.
pub(crate) enum RenderLoop<'a> {
    /// To the engine for grids.
    Volume(SingleVolume<'a>, RenderSettings<SheetSettings>),
    /// To the papers' methods.
    Classic(SingleVolume<'a>, RenderSettings<SplatSettings>),
    /// As the published renderer does.
    Published,
    /// To the sheets, as layers.
    Layers(RenderSettings<SheetSettings>),
    /// To the sheets and to the splats, whose X-rays add up.
    Integrals(RenderSettings<SheetSettings>),
    /// Splat by splat, as one cloud.
    Splats,
}

impl<'a> RenderLoop<'a> {
    /// Selects the loop for a scene; `check` decides whether the loop supports it.
    pub(crate) fn of(scene: &'a Scene, settings: &RenderSettings) -> Self {
        if scene.is_published(settings) {
            return Self::Published;
        }
        match (scene.single_volume(), settings.method) {
            (Ok(single), Method::Sheets(sheets)) => {
                let own = settings.with(sheets.of_labels(single.labels));
                Self::Volume(single, own)
            }
            (Ok(single), Method::Splats(splats)) => {
                let own = settings.with(splats.of_labels(single.labels));
                Self::Classic(single, own)
            }
            (Err(_), Method::Sheets(sheets)) => {
                let own = settings.with(sheets);
                match sheets.shows {
                    Shows::Material(_) => Self::Layers(own),
                    Shows::Xray if scene.items.iter().any(|item| own_layer(item).is_some()) => {
                        Self::Integrals(own)
                    }
                    Shows::Mip | Shows::MinimumIntensity | Shows::Mean if is_mesh(scene) => Self::Layers(own),
                    _ => Self::Splats,
                }
            }
            (Err(_), Method::Splats(_)) => Self::Splats,
        }
    }
}

/// A scene prepared for its render loop.
pub(crate) enum Route<'a> {
    /// A volume in world space.
    Volume(VolumeScene<'a>, RenderSettings<SheetSettings>),
    /// A volume in world space, drawn footprint by footprint.
    Classic(VolumeScene<'a>, RenderSettings<SplatSettings>),
    /// Volumes and meshes in world space, and all other items as one cloud.
    Layers(Parts<'a>, RenderSettings<SheetSettings>),
    /// Volumes in world space, and all other items as one cloud, whose X-rays add up.
    Integrals(Parts<'a>, RenderSettings<SheetSettings>),
    /// Whole splats, composited one by one.
    Splats(SplatScene<'a>),
}

/// The layers of a scene.
pub(crate) struct Parts<'a> {
    /// A layer each.
    pub volumes: Vec<VolumeScene<'a>>,
    /// One layer each.
    pub meshes: Vec<MeshScene<'a>>,
    /// Content that is classified already; shares one layer.
    pub rest: Scene,
}

impl Parts<'_> {
    /// The volumes, each once.
    pub(crate) fn distinct_volumes(&self) -> Vec<Arc<Volume>> {
        let mut distinct: Vec<Arc<Volume>> = Vec::new();
        for VolumeScene { volume, .. } in &self.volumes {
            if !distinct.iter().any(|known| Arc::ptr_eq(known, volume)) {
                distinct.push(Arc::clone(volume));
            }
        }
        distinct
    }
}

/// One volume as input of the sheet engine.
#[derive(Debug)]
pub(crate) struct VolumeScene<'a> {
    /// The volume, where it lies.
    pub volume: Arc<Volume>,
    /// Colour and opacity of its values.
    pub transfer_function: Cow<'a, TransferFunction>,
    pub effects: Effects<'a>,
    /// Motion while the shutter is open.
    pub motion: Option<&'a Motion>,
    /// Whether the volume is a label map.
    pub labels: bool,
}

impl VolumeScene<'_> {
    /// Settings for this volume: label maps are classified before they are splatted.
    pub(crate) fn settings(&self, settings: &RenderSettings<SheetSettings>) -> RenderSettings<SheetSettings> {
        settings.with(settings.method.of_labels(self.labels))
    }

    /// How its values are shown.
    pub(crate) fn look(&self) -> VolumeLook<'_> {
        VolumeLook {
            transfer_function: &self.transfer_function,
            unit_distance: self.unit_distance(),
            labels: self.labels,
        }
    }

    /// World length to which the transfer function's opacities refer.
    pub(crate) fn unit_distance(&self) -> f64 {
        self.transfer_function
            .unit_distance
            .unwrap_or_else(|| self.volume.finest_grid().mean_spacing())
    }
}

/// One mesh as input of its layer.
#[derive(Debug)]
pub(crate) struct MeshScene<'a> {
    pub mesh: &'a Arc<Mesh>,
    pub world_from_local: DAffine3,
    /// Distance of neighbouring samples, world length.
    pub spacing: f64,
    /// Colour and opacity of its values.
    pub transfer_function: &'a TransferFunction,
    /// World length to which its opacities refer.
    pub unit_distance: f64,
    pub effects: Effects<'a>,
}

/// Operators, clips and isosurfaces of an item.
#[derive(Debug, Clone)]
pub(crate) struct Effects<'a> {
    /// Operators on the material's appearance, in order of application.
    pub operators: &'a [Arc<dyn PixelOperator>],
    /// Clips, world space.
    pub clips: Cow<'a, [Clip]>,
    /// Isosurfaces; where there are any, they are shown instead of material.
    pub isosurfaces: &'a [Isosurface],
}

/// Cache of volumes moved to places of their own, so that engines recognise them in the next frame.
#[derive(Debug, Default)]
pub(crate) struct PlacedVolumes {
    kept: Vec<(Arc<Volume>, DAffine3, Arc<Volume>)>,
}

impl PlacedVolumes {
    /// Drops volumes that the scene does not have. Runs first, so that old and new volumes never need memory
    /// together.
    fn keep(&mut self, scene: &Scene) {
        self.kept.retain(|(own, at, _)| {
            scene.items.iter().any(|item| match &item.content {
                Content::Volume { volume, .. } => Arc::ptr_eq(own, volume) && *at == item.world_from_item,
                _ => false,
            })
        });
    }

    /// The volume where it lies.
    fn place(&mut self, single: &SingleVolume<'_>) -> Result<Arc<Volume>, SceneError> {
        let place = single.item.world_from_item;
        let same =
            |kept: &&(Arc<Volume>, DAffine3, _)| Arc::ptr_eq(&kept.0, single.volume) && kept.1 == place;
        if let Some((_, _, placed)) = self.kept.iter().find(same) {
            return Ok(Arc::clone(placed));
        }
        let placed = single.placed()?;
        if place != DAffine3::IDENTITY {
            self.kept
                .push((Arc::clone(single.volume), place, Arc::clone(&placed)));
        }
        Ok(placed)
    }
}

impl<'a> Route<'a> {
    /// Prepares a scene for its render loop.
    ///
    /// # Errors
    /// A transformation that cannot be inverted.
    pub(crate) fn of(
        scene: &'a Scene,
        settings: &RenderSettings,
        volumes: &mut PlacedVolumes,
    ) -> Result<Self, SceneError> {
        volumes.keep(scene);
        match RenderLoop::of(scene, settings) {
            RenderLoop::Volume(single, own) => Ok(Self::Volume(volume_scene(scene, &single, volumes)?, own)),
            RenderLoop::Classic(single, own) => {
                Ok(Self::Classic(volume_scene(scene, &single, volumes)?, own))
            }
            RenderLoop::Published => Ok(Self::Splats(SplatScene::published(scene))),
            RenderLoop::Layers(own) => Ok(Self::Layers(parts(scene, &own, volumes)?, own)),
            RenderLoop::Integrals(own) => Ok(Self::Integrals(parts(scene, &own, volumes)?, own)),
            RenderLoop::Splats => Ok(Self::Splats(SplatScene::of_depths(scene))),
        }
    }
}

/// The layers of a scene.
///
/// # Errors
/// A volume's transformation that cannot be inverted.
fn parts<'a>(
    scene: &'a Scene,
    settings: &RenderSettings<SheetSettings>,
    volumes: &mut PlacedVolumes,
) -> Result<Parts<'a>, SceneError> {
    let mut parts = Parts {
        volumes: Vec::new(),
        meshes: Vec::new(),
        rest: Scene::default(),
    };
    for item in &scene.items {
        if let Some(single) = own_layer(item) {
            parts.volumes.push(volume_scene(scene, &single, volumes)?);
        } else if let Some(mesh) = mesh_layer(scene, item, &settings.method) {
            parts.meshes.push(mesh);
        } else {
            parts.rest.items.push(item.clone());
        }
    }
    Ok(parts)
}

/// The volume of an item, if it is a layer of its own.
pub(crate) fn own_layer(item: &Item) -> Option<SingleVolume<'_>> {
    match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            isosurfaces,
            labels,
        } => Some(SingleVolume {
            item,
            volume,
            transfer_function,
            isosurfaces,
            labels: *labels,
        }),
        _ => None,
    }
}

/// Whether a scene is a single mesh.
fn is_mesh(scene: &Scene) -> bool {
    matches!(&scene.items[..], [item] if matches!(item.content, Content::Mesh { .. }))
}

fn mesh_layer<'a>(scene: &'a Scene, item: &'a Item, sheets: &SheetSettings) -> Option<MeshScene<'a>> {
    let Content::Mesh {
        mesh,
        transfer_function,
        isosurfaces,
    } = &item.content
    else {
        return None;
    };
    let spacing = scene_cloud::spacing(item);
    let own = transfer_function.unit_distance;
    is_post_classified(item, sheets).then(|| MeshScene {
        mesh,
        world_from_local: item.world_from_item * *mesh.world_from_local(),
        spacing,
        transfer_function,
        // Opacities refer to lengths of the item's own world.
        unit_distance: own.map_or(spacing, |distance| distance * item.scale()),
        effects: Effects {
            operators: &item.operators,
            clips: clips(scene, item),
            isosurfaces,
        },
    })
}

fn volume_scene<'a>(
    scene: &'a Scene,
    single: &SingleVolume<'a>,
    volumes: &mut PlacedVolumes,
) -> Result<VolumeScene<'a>, SceneError> {
    let item = single.item;
    let own = single.transfer_function;
    let transfer_function = match own.unit_distance {
        // Opacities refer to lengths of the item's own world.
        Some(distance) if item.scale() != 1.0 => {
            let mut placed = own.clone();
            placed.unit_distance = Some(distance * item.scale());
            Cow::Owned(placed)
        }
        _ => Cow::Borrowed(own),
    };
    Ok(VolumeScene {
        volume: volumes.place(single)?,
        transfer_function,
        effects: Effects {
            operators: &item.operators,
            clips: clips(scene, item),
            isosurfaces: single.isosurfaces,
        },
        motion: item.motion.as_ref(),
        labels: single.labels,
    })
}

/// The clips of a scene and of its item, world.
fn clips<'a>(scene: &'a Scene, item: &'a Item) -> Cow<'a, [Clip]> {
    if item.clips.is_empty() {
        return Cow::Borrowed(&scene.clips);
    }
    let place = &item.world_from_item;
    if scene.clips.is_empty() && *place == DAffine3::IDENTITY {
        return Cow::Borrowed(&item.clips);
    }
    let own = item.clips.iter().map(|clip| clip.transformed(place));
    scene.clips.iter().cloned().chain(own).collect()
}
