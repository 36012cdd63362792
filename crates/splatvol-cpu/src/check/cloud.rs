//! Checks of scenes rendered as clouds of splats: several items, meshes, points, Gaussians.

use splatvol_core::scene_cloud::is_post_classified;
use splatvol_scene::{
    Absorption, Alignment, Compositing, Content, Filter, Gradient, Item, Method, Occlusion, Rasterizer,
    Reconstruction, RenderSettings, Scene, SceneError, SheetContent, SheetSettings, SplatCompositing,
    SplatSettings,
};

use super::{ONE_VALUE, asked, asked_of, volume};
use crate::route::own_layer;

const WHOLE_SPLATS: &str =
    "whole splats are drawn one by one, classified first, without it; use image sheets";

/// Rejects settings that the published Gaussian renderer does not support.
pub(super) fn published(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
    let refuse = |why| {
        Err(SceneError::Combination {
            what: "the published way to render Gaussians (3dgs)",
            why,
        })
    };
    let any = |of: fn(&Item) -> bool| scene.items.iter().any(of);
    if any(|item| matches!(item.content, Content::Volume { .. })) {
        return refuse(
            "it sorts whole splats, and a volume is a field that only sheets classify and light; use volumetric, which \
             composites all of it sheet by sheet",
        );
    }
    if any(|item| matches!(item.content, Content::Mesh { .. }))
        && settings.method.kernel().gaussian().is_none()
    {
        return refuse("the kernels of a mesh's samples are Gaussians here; use the gaussian kernel");
    }
    let compositing = settings.method.compositing();
    if compositing != Compositing::ImageSheets {
        return Err(SceneError::invalid(
            "compositing",
            compositing,
            "image-sheets, or Gaussians volumetric: as published they are composited over each other, one by one",
        ));
    }
    if let Method::Splats(splats) = &settings.method {
        one_volume(splats)?;
    }
    footprints_in_motion(scene, settings)?;
    nothing_asked(
        scene,
        "Gaussians, and what is splatted among them, are drawn whole, one by one, without it",
    )
}

/// Rejects settings that layers do not support. Volumes and meshes keep what they support alone; the scene's clips
/// cut a cloud.
pub(super) fn layers(scene: &Scene, sheets: &SheetSettings) -> Result<(), SceneError> {
    for item in &scene.items {
        if let Some(single) = own_layer(item) {
            volume::on_sheets(scene, &single, &sheets.of_labels(single.labels))?;
        } else if is_post_classified(item, sheets) {
            mesh(scene, item, sheets)?;
        } else if let Some(what) = asked_of(std::slice::from_ref(item), &[]) {
            return Err(SceneError::Combination {
                what,
                why: "it is of volumes and meshes that are classified after splatting; points, Gaussians and what is classified \
                      first are splatted without it",
            });
        }
    }
    Ok(())
}

/// Rejects settings that a mesh's planes of values do not support. Their gradients are differences, whatever the
/// settings.
fn mesh(scene: &Scene, item: &Item, sheets: &SheetSettings) -> Result<(), SceneError> {
    if sheets.gradient != Gradient::Differences {
        return Err(SceneError::invalid(
            "gradient",
            sheets.gradient,
            "differences: analytic gradients are of the kernels of grids, and the samples of meshes have kernels of their own",
        ));
    }
    match asked_of(std::slice::from_ref(item), &scene.clips) {
        Some(what) if sheets.shows_one_value() => Err(SceneError::Combination { what, why: ONE_VALUE }),
        _ => Ok(()),
    }
}

/// Rejects settings that X-rays of volumes among others do not support. Volumes keep what they support alone.
pub(super) fn integrals(
    scene: &Scene,
    (settings, sheets): (&RenderSettings, &SheetSettings),
) -> Result<(), SceneError> {
    footprints_in_motion(scene, settings)?;
    for item in &scene.items {
        if let Some(single) = own_layer(item) {
            volume::on_sheets(scene, &single, &sheets.of_labels(single.labels))?;
        } else if let Some(what) = asked_of(std::slice::from_ref(item), &scene.clips) {
            let why = WHOLE_SPLATS;
            return Err(SceneError::Combination { what, why });
        }
    }
    Ok(())
}

/// Rejects settings that whole splats do not support.
pub(super) fn splats(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
    let compositing = settings.method.compositing();
    match compositing {
        Compositing::PerSplat | Compositing::Xray => {}
        Compositing::PerSplatBackToFront => {
            return Err(SceneError::invalid(
                "compositing",
                compositing,
                "per-splat, the same picture front to back: the other order is of one volume alone",
            ));
        }
        Compositing::Mip | Compositing::MinimumIntensity | Compositing::Mean => return Err(no_values(scene)),
        Compositing::ImageSheets => return Err(no_sections(scene, settings)),
        Compositing::AxisSheets => {
            return Err(SceneError::Combination {
                what: "anything but one volume",
                why: "the slices of a grid are of one volume; use image sheets, per-splat or X-ray",
            });
        }
    }
    settings.validate()?;
    if let Method::Splats(splats) = &settings.method {
        one_volume(splats)?;
    }
    footprints_in_motion(scene, settings)?;
    nothing_asked(scene, WHOLE_SPLATS)
}

/// Error for a scene of several items whose settings need sections of footprints; names the first such setting.
fn no_sections(scene: &Scene, settings: &RenderSettings) -> SceneError {
    let asked_for = match &settings.method {
        Method::Splats(splats) => one_volume(splats).and_then(|()| footprints_in_motion(scene, settings)),
        Method::Sheets(_) => Ok(()),
    };
    asked_for.err().unwrap_or_else(|| {
        SceneError::invalid(
            "sheet",
            SheetContent::Section,
            "sample: sections are of the footprints of one volume alone",
        )
    })
}

/// Error for a scene whose rays have no largest, smallest or mean value.
fn no_values(scene: &Scene) -> SceneError {
    let has_values = |item: &Item| matches!(item.content, Content::Volume { .. } | Content::Mesh { .. });
    let has_gaussians = |item: &Item| matches!(item.content, Content::Gaussians(_));
    if scene.items.iter().any(has_values) {
        SceneError::Combination {
            what: "a maximum, minimum or mean of several things",
            why: "points and Gaussians have no values, and those of different fields do not compare; show one volume or mesh, or use \
                  image sheets, per-splat or X-ray",
        }
    } else if scene.items.iter().any(has_gaussians) {
        SceneError::Combination {
            what: "a maximum, minimum or mean of Gaussians",
            why: "they have densities and colours, but no values; use image sheets, per-splat or X-ray",
        }
    } else {
        SceneError::Combination {
            what: "a maximum, minimum or mean of points",
            why: "they have colours, but no values, and are surfaces; use image sheets, per-splat or X-ray",
        }
    }
}

/// Rejects the methods that need the voxels of one grid.
fn one_volume(settings: &SplatSettings) -> Result<(), SceneError> {
    let whole = matches!(
        settings.compositing,
        SplatCompositing::FrontToBack | SplatCompositing::Xray
    );
    let refuse =
        |field, value: &dyn std::fmt::Debug, expected| Err(SceneError::invalid(field, value, expected));
    if matches!(settings.filter, Filter::Swan | Filter::SwanAlpha) {
        return refuse(
            "filter",
            &settings.filter,
            "ewa or matched: swan's filter compares the voxels of one grid with pixels",
        );
    }
    match settings.alignment {
        Alignment::Sheet => {}
        Alignment::Affine if whole => {}
        _ => {
            return refuse(
                "alignment",
                &settings.alignment,
                "sheet: other footprints are of the voxels of one volume alone",
            );
        }
    }
    if settings.rasterizer != Rasterizer::Auto {
        return refuse(
            "rasterizer",
            &settings.rasterizer.name(),
            "auto: tables hold the footprints of one kernel, and each splat here has its own",
        );
    }
    if settings.occlusion != Occlusion::Auto {
        return refuse(
            "occlusion",
            &settings.occlusion,
            "auto: the others are of one volume alone",
        );
    }
    if settings.absorption != Absorption::Exp {
        return refuse(
            "absorption",
            &settings.absorption,
            "exp: the papers' approximation is of one volume alone",
        );
    }
    if settings.kernel.gaussian().is_none() {
        return refuse(
            "kernel",
            &settings.kernel.name(),
            "gaussian: kernels of ellipsoids are Gaussians",
        );
    }
    if settings.reconstruction != Reconstruction::Volume {
        return refuse(
            "reconstruction",
            &settings.reconstruction,
            "volume: flattening is of one volume alone",
        );
    }
    if settings.extraction.is_some() {
        return refuse(
            "extraction",
            &settings.extraction,
            "none: ranges of interest are of one volume alone",
        );
    }
    Ok(())
}

fn nothing_asked(scene: &Scene, why: &'static str) -> Result<(), SceneError> {
    match asked(scene) {
        None => Ok(()),
        Some(what) => Err(SceneError::Combination { what, why }),
    }
}

fn footprints_in_motion(scene: &Scene, settings: &RenderSettings) -> Result<(), SceneError> {
    if settings.motion_blur.moves_footprints() && scene.items.iter().any(|item| item.motion.is_some()) {
        return Err(SceneError::invalid(
            "motion blur",
            settings.motion_blur,
            "subframes: footprints are blurred one by one in pictures of one volume alone",
        ));
    }
    Ok(())
}
