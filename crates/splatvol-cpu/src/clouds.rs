//! Scenes of whole splats: which items form which cloud, and the constants that they are rendered with.
//!
//! As published (`3dgs`), Gaussians keep their trained colours and opacities, and points and samples of meshes are
//! kernels among them. Otherwise everything, Gaussians included, is one cloud of optical depths.

use splatvol_core::cloud_view::{cut_of, near_of_depths};
use splatvol_scene::{Compositing, Content, Item, RenderSettings, Scene};

use crate::splats::{BlendMode, Cloud, CloudSettings, LowPass, Near};

/// A scene whose splats are composited one by one.
pub(crate) struct SplatScene<'a> {
    /// Gaussians as they were trained.
    pub gaussians: Vec<Cloud<'a>>,
    /// All other content as one cloud of kernels, with the Gaussians or alone.
    pub rest: Scene,
    published: bool,
}

impl<'a> SplatScene<'a> {
    /// As published.
    pub(crate) fn published(scene: &'a Scene) -> Self {
        let mut gaussians = Vec::new();
        let mut rest = Vec::new();
        for item in &scene.items {
            match &item.content {
                Content::Gaussians(own) => gaussians.push(Cloud::Gaussians(own, item.world_from_item)),
                _ => rest.push(item.clone()),
            }
        }
        Self {
            gaussians,
            rest: scene_of(rest),
            published: true,
        }
    }

    /// By optical depths.
    pub(crate) fn of_depths(scene: &Scene) -> Self {
        Self {
            gaussians: Vec::new(),
            rest: scene_of(scene.items.clone()),
            published: false,
        }
    }

    /// Settings of the splat loop, from the scene and the render settings. `spacing`: of the rest, world length.
    pub(crate) fn settings(&self, scene: &Scene, settings: &RenderSettings, spacing: f64) -> CloudSettings {
        if self.published {
            return CloudSettings {
                lighting: settings.lighting,
                blend_mode: BlendMode::Published {
                    background: scene.background,
                },
                ..CloudSettings::published(settings.size)
            };
        }
        let cut = cut_of(settings);
        let integral = settings.method.compositing() == Compositing::Xray;
        CloudSettings {
            size: settings.size,
            low_pass: LowPass::of(settings.method.filter()),
            near: Near::World(near_of_depths(settings, spacing)),
            lighting: settings.lighting.filter(|_| !integral),
            blend_mode: if integral {
                BlendMode::Integral { cut }
            } else {
                BlendMode::Light {
                    cut,
                    termination: settings.termination as f32,
                }
            },
        }
    }
}

fn scene_of(items: Vec<Item>) -> Scene {
    Scene {
        items,
        ..Scene::default()
    }
}
