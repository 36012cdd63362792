//! Which engine renders a scene.
//!
//! | scene | engine |
//! |---|---|
//! | one volume, wherever it lies | those for grids (`sheets`, `tile`), or `footprints` where a method needs whole ones |
//! | nothing but Gaussians | the published renderer's way (`splatvol_gaussians`), unless sheets are asked for |
//! | everything else | `footprints`: one cloud of classified splats |
//!
//! A volume is brought to its place by its grid: `world_from_voxel = world_from_item * item_from_voxel`.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DAffine3;
use splatvol_gaussians::Placed;
use splatvol_scene::operator::PixelOperator;
use splatvol_scene::{
    Clip, Content, GaussianMode, Isosurface, Item, Motion, RenderSettings, Scene, SceneError, SingleVolume,
    TransferFunction, Volume,
};

use crate::clouds;

/// Which way a scene goes.
pub(crate) enum Way<'a> {
    /// To the engines for grids.
    Volume(SingleVolume<'a>),
    /// As the published renderer does.
    Published,
    /// As a cloud of splats.
    Cloud,
}

impl<'a> Way<'a> {
    /// The way of a scene.
    ///
    /// # Errors
    /// Things besides Gaussians, where the published way is asked for.
    pub(crate) fn of(scene: &'a Scene, settings: &RenderSettings) -> Result<Self, SceneError> {
        match (settings.gaussians, scene.is_gaussians()) {
            (GaussianMode::Published, false) => Err(SceneError::Combination {
                what: "the published way to render Gaussians (3dgs)",
                why: "it sorts whole Gaussians and knows nothing else; use volumetric, which composites them with \
                      everything else sheet by sheet",
            }),
            (GaussianMode::Auto | GaussianMode::Published, true) => Ok(Self::Published),
            (GaussianMode::Auto, false) | (GaussianMode::Volumetric, _) => {
                Ok(scene.single_volume().map_or(Self::Cloud, Self::Volume))
            }
        }
    }
}

/// A scene on its way.
pub(crate) enum Route<'a> {
    /// A volume where it lies.
    Volume(VolumeScene<'a>),
    /// Gaussians where they lie.
    Published(Vec<Placed<'a>>),
    /// Everything else.
    Cloud,
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
    /// Whether it has what only sheets of values show.
    pub(crate) fn asks_for_sheets(&self) -> bool {
        !(self.operators.is_empty() && self.isosurfaces.is_empty() && self.clips.is_empty())
    }

    /// World length to which the transfer function's opacities refer.
    pub(crate) fn unit_distance(&self) -> f64 {
        self.transfer_function
            .unit_distance
            .unwrap_or_else(|| self.volume.grid().mean_spacing())
    }
}

/// The volume last brought to a place of its own, so that what engines keep of it stays right.
#[derive(Debug, Default)]
pub(crate) struct PlacedVolume {
    kept: Option<(Arc<Volume>, DAffine3, Arc<Volume>)>,
}

impl PlacedVolume {
    /// The volume where it lies.
    fn place(&mut self, single: &SingleVolume<'_>) -> Result<Arc<Volume>, SceneError> {
        let place = single.item.world_from_item;
        if let Some((own, at, placed)) = &self.kept
            && Arc::ptr_eq(own, single.volume)
            && *at == place
        {
            return Ok(Arc::clone(placed));
        }
        // First, so that the memory of two is never needed.
        self.kept = None;
        let placed = single.placed()?;
        if place != DAffine3::IDENTITY {
            self.kept = Some((Arc::clone(single.volume), place, Arc::clone(&placed)));
        }
        Ok(placed)
    }
}

impl<'a> Route<'a> {
    /// A scene on the way that it goes.
    ///
    /// # Errors
    /// As [`Way::of`], and places that cannot be inverted.
    pub(crate) fn of(
        scene: &'a Scene,
        settings: &RenderSettings,
        volumes: &mut PlacedVolume,
    ) -> Result<Self, SceneError> {
        match Way::of(scene, settings)? {
            Way::Volume(single) => volume_scene(scene, &single, volumes).map(Self::Volume),
            Way::Published => Ok(Self::Published(placed(scene))),
            Way::Cloud => Ok(Self::Cloud),
        }
    }

    /// The settings that this way takes.
    pub(crate) fn settings(&self, settings: &RenderSettings) -> RenderSettings {
        match self {
            Self::Volume(_) | Self::Published(_) => *settings,
            Self::Cloud => clouds::in_sheets(settings),
        }
    }
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
    volumes: &mut PlacedVolume,
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
