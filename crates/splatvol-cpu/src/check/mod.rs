//! Checks whether a scene can be rendered, before rendering; the only place that decides.
//!
//! | of | module |
//! |---|---|
//! | settings by themselves | [`splatvol_scene::RenderSettings::validate`] |
//! | a volume alone, with the settings | `volume` |
//! | a rasteriser, with the footprints of a view | `raster` |
//! | layers and clouds: several things, meshes, points, Gaussians | `cloud` |
//! | volumes that are read in chunks | `chunks` |
//!
//! Rendering accepts everything that passes these checks. `docs/scenes.md` tabulates their results.

mod chunks;
mod cloud;
mod raster;
mod volume;

use splatvol_core::engine::Shot;
use splatvol_scene::{Clip, Item, Method, Scene, SceneError};

use crate::route::RenderLoop;

/// Error message for operators, clips or isosurfaces in a picture with one value per ray.
const ONE_VALUE: &str = "maximum, minimum and mean show one value of a ray alone, use image sheets";

/// Checks that a scene can be rendered from a camera with these settings, apart from motion and sampled edges.
///
/// # Errors
/// The offending field, its value and the accepted values; or the feature in use, and the one it cannot be combined
/// with.
pub fn check(shot: Shot<'_>) -> Result<(), SceneError> {
    let Shot {
        scene,
        camera,
        settings,
    } = shot;
    match RenderLoop::of(scene, settings) {
        RenderLoop::Volume(single, own) => {
            own.with(Method::Sheets(own.method)).validate()?;
            volume::on_sheets(scene, &single, &own.method)?;
            chunks::on_sheets(single.item, &own.method)?;
        }
        RenderLoop::Classic(single, own) => {
            own.with(Method::Splats(own.method)).validate()?;
            chunks::whole(&scene.items)?;
            volume::footprints(scene, &single)?;
            raster::check(&single, camera, &own.method)?;
        }
        RenderLoop::Published => cloud::published(scene, settings)?,
        RenderLoop::Layers(own) => {
            settings.validate()?;
            cloud::layers(scene, &own.method)?;
            for item in &scene.items {
                chunks::on_sheets(item, &own.method)?;
            }
        }
        RenderLoop::Integrals(own) => {
            settings.validate()?;
            cloud::integrals(scene, (settings, &own.method))?;
            for item in &scene.items {
                chunks::on_sheets(item, &own.method)?;
            }
        }
        RenderLoop::Splats => {
            chunks::whole(&scene.items)?;
            cloud::splats(scene, settings)?;
        }
    }
    Ok(())
}

/// Names a feature (isosurface, operator or clip) that a scene uses beyond the items' looks; `None` without any.
fn asked(scene: &Scene) -> Option<&'static str> {
    asked_of(&scene.items, &scene.clips)
}

/// As [`asked`], for some of the scene's items and clips.
fn asked_of(items: &[Item], clips: &[Clip]) -> Option<&'static str> {
    let any = |of: fn(&Item) -> bool| items.iter().any(of);
    if any(Item::shows_isosurfaces) {
        Some("an isosurface")
    } else if any(|item| !item.operators.is_empty()) {
        Some("an operator (texture, bump or environment map, gradient opacity, 2-D transfer function)")
    } else if !clips.is_empty() || any(|item| !item.clips.is_empty()) {
        Some("a clip")
    } else {
        None
    }
}
