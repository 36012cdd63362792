//! Operators, clips and exact isosurfaces, from their flags.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use splatvol::{
    Bounds, BumpMap, Clip, Content, EnvironmentMap, GradientOpacity, Image, Isosurface, Item, Keep,
    PixelOperator, Scene, SolidTexture, Stuff, TransferFunction, TransferFunction2d,
};

use super::input::locate;
use crate::args::{EffectArgs, LookArgs, TextureName};
use crate::failure::{During, Failure, Step};

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

/// The two-dimensional transfer function that is asked for, of a volume whose voxels are `spacing` apart; `beside` is where a relative path that leads nowhere from here
/// is tried next.
pub(crate) fn transfer_function_2d(
    args: &EffectArgs,
    look: &LookArgs,
    spacing: f64,
    beside: Option<&Path>,
) -> Result<Option<TransferFunction2d>, Failure> {
    let Some(path) = &args.tf2d else { return Ok(None) };
    let unit_distance = look.unit_distance.unwrap_or(spacing);
    splatvol_io::read_transfer_function_2d(locate(path, beside), unit_distance)
        .map(Some)
        .during(Step::Input)
}

/// Everything but the two-dimensional transfer function's file. `bounds`: what textures and pictures span, world.
pub(crate) fn resolve(
    args: &EffectArgs,
    look: &LookArgs,
    bounds: &Bounds,
    (tf2d, beside): (Option<TransferFunction2d>, Option<&Path>),
) -> Result<Effects, Failure> {
    check(args, look)?;
    let mut effects = Effects {
        isosurface: look.iso.filter(|_| args.iso_exact),
        clips: clips(args)?,
        ..Effects::default()
    };
    if let Some(function) = tf2d {
        effects.push(function);
    }
    if let Some(curve) = &args.gradient_opacity {
        effects.push(GradientOpacity::new(&curve.0).during(Step::Usage)?);
    }
    if let Some(name) = args.texture {
        let stuff = match name {
            TextureName::Marble => Stuff::Marble,
            TextureName::Wood => Stuff::Wood,
        };
        let scale = args.texture_scale.unwrap_or(TEXTURE_SCALE);
        effects.push(SolidTexture::new(stuff, bounds, scale).during(Step::Usage)?);
    }
    if let Some(path) = &args.bump {
        let height = args.bump_height.unwrap_or(BUMP_HEIGHT);
        effects.push(BumpMap::new(&picture(path, beside)?, bounds, height).during(Step::Usage)?);
    }
    if let Some(path) = &args.environment {
        let share = args.environment_share.unwrap_or(ENVIRONMENT_SHARE);
        effects.push(EnvironmentMap::new(&picture(path, beside)?, share).during(Step::Usage)?);
    }
    Ok(effects)
}

/// Flags that mean nothing without another.
fn check(args: &EffectArgs, look: &LookArgs) -> Result<(), Failure> {
    let lone = [
        (
            args.texture_scale.is_some() && args.texture.is_none(),
            "--texture-scale",
            "--texture",
        ),
        (
            args.bump_height.is_some() && args.bump.is_none(),
            "--bump-height",
            "--bump",
        ),
        (
            args.environment_share.is_some() && args.environment.is_none(),
            "--environment-share",
            "--environment",
        ),
        (args.iso_exact && look.iso.is_none(), "--iso-exact", "--iso"),
        (
            args.clip_inside && args.clip_box.is_none(),
            "--clip-inside",
            "--clip-box",
        ),
    ];
    match lone.into_iter().find(|(alone, ..)| *alone) {
        Some((_, flag, needed)) => Err(Failure::usage(format!("{flag} has no meaning without {needed}"))),
        None => Ok(()),
    }
}

fn clips(args: &EffectArgs) -> Result<Vec<Clip>, Failure> {
    let planes = args.clip_plane.iter().map(|&plane| Clip {
        planes: vec![plane],
        keep: Keep::Inside,
    });
    let mut clips: Vec<Clip> = planes.collect();
    if let Some([x0, x1, y0, y1, z0, z1]) = args.clip_box {
        let bounds = Bounds {
            min: DVec3::new(x0, y0, z0),
            max: DVec3::new(x1, y1, z1),
        };
        let keep = if args.clip_inside {
            Keep::Outside
        } else {
            Keep::Inside
        };
        clips.push(Clip::of_box(&bounds, keep).during(Step::Usage)?);
    }
    Ok(clips)
}

fn picture(path: &Path, beside: Option<&Path>) -> Result<Image, Failure> {
    let picture = splatvol_io::read_image(locate(path, beside)).during(Step::Input)?;
    Ok(picture.image)
}

impl Effects {
    fn push(&mut self, operator: impl PixelOperator + 'static) {
        self.operators.push(Arc::new(operator));
    }

    /// Whether nothing is done.
    pub(crate) fn is_empty(&self) -> bool {
        self.operators.is_empty() && self.clips.is_empty() && self.isosurface.is_none()
    }

    /// Does it to a scene: clips cut all of it, everything else is of a volume or a mesh alone.
    pub(crate) fn apply(self, mut scene: Scene) -> Result<Scene, Failure> {
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
fn show_surface(item: &mut Item, value: f64) -> Result<(), Failure> {
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
    item.content = shown.during(Step::Usage)?.content;
    Ok(())
}

/// Why effects are refused.
pub(crate) fn of_data() -> Failure {
    Failure::usage(
        "effects (textures, bumps, mirrors, gradient opacity, --tf2d, --iso-exact) are of one volume or one mesh alone",
    )
}
