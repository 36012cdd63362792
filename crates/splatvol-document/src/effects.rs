//! Operators, clips and exact isosurfaces, from their keys.

use std::sync::Arc;

use glam::DVec3;
use splatvol_scene::{
    Bounds, BumpMap, Clip, Content, EnvironmentMap, GradientOpacity, Image, Isosurface, Item, Keep,
    PixelOperator, Scene, SolidTexture, TransferFunction, TransferFunction2d,
};

use crate::input::Reading;
use crate::keys::{EffectKeys, ItemKeys, check_gradient_opacity, check_regions};
use crate::{DocumentError, files};

/// Distance of veins or rings, share of the diagonal.
const TEXTURE_SCALE: f64 = 0.08;
/// Height of white, share of the diagonal.
const BUMP_HEIGHT: f64 = 0.01;
/// Share of mirrored light.
const ENVIRONMENT_SHARE: f64 = 0.5;

/// Operators, clips and isosurfaces of a scene.
#[derive(Debug, Default)]
pub(crate) struct Effects {
    operators: Vec<Arc<dyn PixelOperator>>,
    clips: Vec<Clip>,
    /// Value of a surface to show instead of material.
    isosurface: Option<f64>,
}

/// The requested two-dimensional transfer function of an item whose voxels are `spacing` apart.
pub(crate) fn transfer_function_2d(
    keys: &EffectKeys,
    item: &ItemKeys,
    spacing: f64,
    reading: Reading<'_>,
) -> Result<Option<TransferFunction2d>, DocumentError> {
    let unit_distance = item.unit_distance.unwrap_or(spacing);
    let function = match (&keys.tf2d, &keys.regions) {
        (None, None) => return Ok(None),
        (Some(path), None) => files::read_transfer_function_2d(reading.locate(path), unit_distance)?,
        (None, Some(regions)) => {
            check_regions(regions)?;
            TransferFunction2d::new(regions, unit_distance)
                .map_err(|error| DocumentError::refused("effects.regions", format!(": {error}")))?
        }
        (Some(_), Some(_)) => {
            return Err(DocumentError::refused(
                "effects.regions",
                "has no meaning beside `effects.tf2d`, which is a transfer function of value and gradient, too",
            ));
        }
    };
    Ok(Some(function))
}

/// Everything but the two-dimensional transfer function's file. `bounds`: what textures and pictures span, world.
pub(crate) fn resolve(
    keys: &EffectKeys,
    item: &ItemKeys,
    bounds: &Bounds,
    (tf2d, reading): (Option<TransferFunction2d>, Reading<'_>),
) -> Result<Effects, DocumentError> {
    check(keys, item)?;
    let mut effects = Effects {
        isosurface: item.iso.filter(|_| keys.iso_exact == Some(true)),
        clips: clips(keys)?,
        ..Effects::default()
    };
    if let Some(function) = tf2d {
        effects.push(function);
    }
    if let Some(curve) = &keys.gradient_opacity {
        check_gradient_opacity(curve)
            .map_err(|why| DocumentError::refused("effects.gradient-opacity", why))?;
        effects.push(GradientOpacity::new(curve)?);
    }
    if let Some(name) = keys.texture {
        let scale = keys.texture_scale.unwrap_or(TEXTURE_SCALE);
        effects.push(SolidTexture::new(name.into(), bounds, scale)?);
    }
    if let Some(path) = &keys.bump {
        let height = keys.bump_height.unwrap_or(BUMP_HEIGHT);
        effects.push(BumpMap::new(&picture(path, reading)?, bounds, height)?);
    }
    if let Some(path) = &keys.environment {
        let share = keys.environment_share.unwrap_or(ENVIRONMENT_SHARE);
        effects.push(EnvironmentMap::new(&picture(path, reading)?, share)?);
    }
    Ok(effects)
}

/// Refuses keys that mean nothing without another.
fn check(keys: &EffectKeys, item: &ItemKeys) -> Result<(), DocumentError> {
    let lone = [
        (
            keys.texture_scale.is_some() && keys.texture.is_none(),
            "effects.texture-scale",
            "effects.texture",
        ),
        (
            keys.bump_height.is_some() && keys.bump.is_none(),
            "effects.bump-height",
            "effects.bump",
        ),
        (
            keys.environment_share.is_some() && keys.environment.is_none(),
            "effects.environment-share",
            "effects.environment",
        ),
        (
            keys.iso_exact == Some(true) && item.iso.is_none(),
            "effects.iso-exact",
            "item.iso",
        ),
        (
            keys.clip_inside == Some(true) && keys.clip_box.is_none(),
            "effects.clip-inside",
            "effects.clip-box",
        ),
    ];
    match lone.into_iter().find(|(alone, ..)| *alone) {
        Some((_, key, needed)) => Err(DocumentError::refused(
            key,
            format!("has no meaning without `{needed}`"),
        )),
        None => Ok(()),
    }
}

fn clips(keys: &EffectKeys) -> Result<Vec<Clip>, DocumentError> {
    let planes = keys.clip_plane.iter().flatten().map(|&plane| Clip {
        planes: vec![plane],
        keep: Keep::Inside,
    });
    let mut clips: Vec<Clip> = planes.collect();
    if let Some([x0, x1, y0, y1, z0, z1]) = keys.clip_box {
        let bounds = Bounds {
            min: DVec3::new(x0, y0, z0),
            max: DVec3::new(x1, y1, z1),
        };
        let keep = match keys.clip_inside {
            Some(true) => Keep::Outside,
            _ => Keep::Inside,
        };
        clips.push(Clip::of_box(&bounds, keep)?);
    }
    Ok(clips)
}

fn picture(path: &str, reading: Reading<'_>) -> Result<Image, DocumentError> {
    Ok(files::read_image(reading.locate(path))?.image)
}

impl Effects {
    fn push(&mut self, operator: impl PixelOperator + 'static) {
        self.operators.push(Arc::new(operator));
    }

    /// Whether nothing is done.
    pub(crate) fn is_empty(&self) -> bool {
        self.operators.is_empty() && self.clips.is_empty() && self.isosurface.is_none()
    }

    /// Applies the effects to a scene: clips cut all of it, everything else applies to a single volume or
    /// mesh.
    pub(crate) fn apply(self, mut scene: Scene) -> Result<Scene, DocumentError> {
        scene.clips.extend(self.clips);
        if self.operators.is_empty() && self.isosurface.is_none() {
            return Ok(scene);
        }
        let [item] = &mut scene.items[..] else {
            return Err(of_data());
        };
        if let Some(value) = self.isosurface {
            show_surface(item, value)?;
        }
        match &item.content {
            Content::Volume { .. } | Content::Mesh { .. } => item.operators.extend(self.operators),
            Content::Points { .. } | Content::Gaussians(_) => return Err(of_data()),
        }
        Ok(scene)
    }
}

/// Shows the surface of a value instead of material, in the colour that the value has.
fn show_surface(item: &mut Item, value: f64) -> Result<(), DocumentError> {
    let surface = |look: &TransferFunction| Isosurface {
        value,
        rgb: look.color(value),
        opacity: 1.0,
    };
    let shown = match &item.content {
        Content::Volume {
            volume,
            transfer_function,
            ..
        } => Item::isosurfaces(Arc::clone(volume), &[surface(transfer_function)]),
        Content::Mesh {
            mesh,
            transfer_function,
            ..
        } => Item::mesh_isosurfaces(Arc::clone(mesh), &[surface(transfer_function)]),
        Content::Points { .. } | Content::Gaussians(_) => return Err(of_data()),
    };
    item.content = shown?.content;
    Ok(())
}

/// Why effects are refused.
fn of_data() -> DocumentError {
    DocumentError::usage(
        "effects (textures, bumps, mirrors, gradient opacity, `effects.tf2d`, `effects.regions`, \
         `effects.iso-exact`) are of one volume or one mesh alone",
    )
}
