//! Which engine renders a scene.
//!
//! | scene | engine |
//! |---|---|
//! | one volume, wherever it lies | those for grids (`sheets`, `tile`), or `footprints` where a method needs whole ones |
//! | nothing but Gaussians | the published renderer's way (`splatvol_gaussians`), unless sheets are asked for |
//! | everything else on image sheets | `sheets`: every volume a layer, the rest a cloud, another |
//! | everything else by another method | `footprints`: one cloud of classified splats |
//!
//! A volume is brought to its place by its grid: `world_from_voxel = world_from_item * item_from_voxel`.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DAffine3;
use splatvol_gaussians::Placed;
use splatvol_scene::operator::PixelOperator;
use splatvol_scene::{
    Clip, Compositing, Content, GaussianMode, Gradient, Isosurface, Item, Motion, RenderSettings, Scene,
    SceneError, SingleVolume, TransferFunction, Volume,
};

use crate::plan::splats_color;
use crate::{clouds, footprints, operations};

/// How a scene is rendered.
pub(crate) enum Route<'a> {
    /// By the engines for grids.
    Volume(VolumeScene<'a>),
    /// As the published renderer does.
    Published(Vec<Placed<'a>>),
    /// On sheets, as layers.
    Layers(Parts<'a>),
    /// As a cloud of splats, by the papers' methods.
    Cloud,
}

/// The layers of a scene.
pub(crate) struct Parts<'a> {
    /// A layer each.
    pub volumes: Vec<VolumeScene<'a>>,
    /// What is classified already, and shares a layer.
    pub rest: Scene,
}

/// One volume as engines for grids see it.
#[derive(Debug)]
pub(crate) struct VolumeScene<'a> {
    /// The data, where they lie.
    pub volume: Arc<Volume>,
    /// Colour and opacity of its values.
    pub transfer_function: Cow<'a, TransferFunction>,
    /// What changes the appearance of material, in this order.
    pub operators: &'a [Arc<dyn PixelOperator>],
    /// What is cut away, world.
    pub clips: Cow<'a, [Clip]>,
    /// Surfaces to show instead of material, where there are any.
    pub isosurfaces: &'a [Isosurface],
    /// What moves while the shutter is open.
    pub motion: Option<&'a Motion>,
}

impl VolumeScene<'_> {
    /// World length to which the transfer function's opacities refer.
    pub(crate) fn unit_distance(&self) -> f64 {
        self.transfer_function
            .unit_distance
            .unwrap_or_else(|| self.volume.grid().mean_spacing())
    }
}

/// The volumes last brought to places of their own, so that what engines keep of them stays right.
#[derive(Debug, Default)]
pub(crate) struct PlacedVolumes {
    kept: Vec<(Arc<Volume>, DAffine3, Arc<Volume>)>,
}

impl PlacedVolumes {
    /// Forgets those that a scene does not have: first, so that the memory of both is never needed.
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
    /// The way that a scene goes.
    ///
    /// # Errors
    /// Things besides Gaussians, where the published way is asked for.
    pub(crate) fn of(
        scene: &'a Scene,
        settings: &RenderSettings,
        volumes: &mut PlacedVolumes,
    ) -> Result<Self, SceneError> {
        match settings.gaussians {
            GaussianMode::Published if !scene.is_gaussians() => {
                return Err(SceneError::Combination {
                    what: "the published way to render Gaussians (3dgs)",
                    why: "it sorts whole Gaussians and knows nothing else; use volumetric, which composites them with \
                          everything else sheet by sheet",
                });
            }
            GaussianMode::Auto | GaussianMode::Published if scene.is_gaussians() => {
                return Ok(Self::Published(placed(scene)));
            }
            _ => {}
        }
        volumes.keep(scene);
        match scene.single_volume() {
            Ok(single) => volume_scene(scene, &single, volumes).map(Self::Volume),
            Err(_) if on_planes(settings) => parts(scene, settings, volumes).map(Self::Layers),
            Err(_) => Ok(Self::Cloud),
        }
    }
}

impl Route<'_> {
    /// The settings that this way takes.
    ///
    /// # Errors
    /// Settings outside their domain, or methods that it does not have.
    pub(crate) fn settings(&self, settings: &RenderSettings) -> Result<RenderSettings, SceneError> {
        let settings = match self {
            Self::Volume(_) | Self::Published(_) | Self::Layers(_) => *settings,
            Self::Cloud => clouds::in_sheets(settings)?,
        };
        if !matches!(self, Self::Published(_)) {
            settings.validate()?;
        }
        Ok(settings)
    }

    /// Refuses what is asked of items where this way cannot show it.
    ///
    /// # Errors
    /// Operators, clips, isosurfaces or motion that it does not have.
    pub(crate) fn check(&self, scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
        match self {
            Self::Volume(volume) => operations::check(volume, settings),
            Self::Published(_) => clouds::check(scene, settings, clouds::PUBLISHED),
            Self::Layers(parts) => {
                for volume in &parts.volumes {
                    operations::check(volume, settings)?;
                }
                clouds::check(&parts.rest, settings, clouds::CLOUD)
            }
            Self::Cloud => clouds::check(scene, settings, clouds::CLOUD),
        }
    }
}

/// Whether scenes are splatted on planes: image sheets, and no paper's way to draw footprints.
fn on_planes(settings: &RenderSettings) -> bool {
    settings.compositing == Compositing::ImageSheets && !footprints::is_needed(settings)
}

/// The layers of a scene. Volumes that only the slices render are classified with the rest.
///
/// # Errors
/// Volumes whose place cannot be inverted.
fn parts<'a>(
    scene: &'a Scene,
    settings: &RenderSettings,
    volumes: &mut PlacedVolumes,
) -> Result<Parts<'a>, SceneError> {
    let mut parts = Parts {
        volumes: Vec::new(),
        rest: Scene::default(),
    };
    for item in &scene.items {
        if let Content::Volume {
            volume,
            transfer_function,
            isosurfaces,
        } = &item.content
            && splats_at_once(volume, settings)
        {
            let single = SingleVolume {
                item,
                volume,
                transfer_function,
                isosurfaces,
            };
            parts.volumes.push(volume_scene(scene, &single, volumes)?);
        } else {
            parts.rest.items.push(item.clone());
        }
    }
    Ok(parts)
}

/// Whether the sheet engine renders a volume.
pub(crate) fn splats_at_once(volume: &Volume, settings: &RenderSettings) -> bool {
    settings.gradient == Gradient::Differences
        && (settings.prefilter || splats_color(settings))
        && volume.statistics().non_finite == 0
}

fn placed(scene: &Scene) -> Vec<Placed<'_>> {
    let placed = scene.items.iter().filter_map(|item| match &item.content {
        Content::Gaussians(gaussians) => Some(Placed {
            gaussians,
            world_from_item: item.world_from_item,
        }),
        _ => None,
    });
    placed.collect()
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
        operators: &item.operators,
        clips: clips(scene, item),
        isosurfaces: single.isosurfaces,
        motion: item.motion.as_ref(),
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
