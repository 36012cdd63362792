//! Recipes in PNGs of splatvol before the document.

use serde::Deserialize;
use splatvol_scene::{FlatSettings, TransferFunction};

use super::SceneFile;
use crate::Document;
use crate::camera::CameraPose;
use crate::format::Record;
use crate::keys::names::{ClassificationName, UpAxis};
use crate::keys::{
    Background, CameraKeys, CameraSweep, EffectKeys, ItemKeys, MotionKeys, Opacity, PictureSize, SettingKeys,
};
use crate::motion::named_blur;
use crate::settings::written;

/// Everything about a picture except its pixels.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Recipe {
    /// Version of the program.
    #[serde(rename = "version")]
    _version: String,
    command: String,
    #[serde(flatten)]
    subject: Subject,
    camera: CameraPose,
    #[serde(default)]
    sub_frames: Vec<CameraPose>,
    #[serde(default)]
    motion: Option<Motion>,
    #[serde(default)]
    effects: EffectKeys,
    settings: FlatSettings,
    background: Option<[f64; 4]>,
    bits: u8,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, rename_all_fields = "kebab-case")]
enum Subject {
    Scene {
        reference: String,
        scene: SceneFile,
    },
    Volume {
        input: Input,
        look: Look,
        transfer_function: TransferFunction,
        #[serde(default)]
        labels: bool,
    },
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Input {
    reference: String,
    #[serde(default)]
    raw: Option<Raw>,
    #[serde(default)]
    array: Option<String>,
    #[serde(default)]
    component: Option<usize>,
    #[serde(default)]
    time: usize,
    #[serde(default)]
    channel: Option<usize>,
    #[serde(default)]
    level: usize,
    #[serde(default)]
    series: Option<String>,
    #[serde(default)]
    up: Option<UpAxis>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Raw {
    dims: [usize; 3],
    #[serde(rename = "type")]
    sample_type: String,
    spacing: [f64; 3],
    big_endian: bool,
    offset: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct Look {
    tf: Option<String>,
    cmap: Option<String>,
    opacity: Option<String>,
    clim: Option<[f64; 2]>,
    unit_distance: Option<f64>,
    iso: Option<f64>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Motion {
    Linear {
        velocity: [f64; 3],
    },
    Spin {
        axis: [f64; 3],
        centre: [f64; 3],
        degrees: f64,
    },
    Camera {
        opening: CameraPose,
        closing: CameraPose,
    },
}

/// The record of such a text; `None` if it is not a recipe.
pub(crate) fn recipe(text: &str) -> Option<Result<Record, String>> {
    let tree: serde_json::Value = serde_json::from_str(text).ok()?;
    tree.get("version")?.as_str()?;
    let recipe = serde_json::from_value::<Recipe>(tree);
    Some(match recipe {
        Ok(recipe) => Ok(record(recipe)),
        Err(error) => Err(format!("its settings are malformed: {error}")),
    })
}

fn record(recipe: Recipe) -> Record {
    let blur = recipe.settings.motion_blur;
    let motion = recipe.motion.map(|motion| with_blur(motion.keys(), blur));
    let sub_frames = Some(recipe.sub_frames).filter(|frames| !frames.is_empty());
    let settings = written(&recipe.settings);
    let (name, items, settings) = match recipe.subject {
        Subject::Scene { reference, scene } => {
            let settings = of_scene(settings, &scene.items);
            (Some(reference), scene.items, settings)
        }
        Subject::Volume {
            input,
            look,
            transfer_function,
            labels,
        } => {
            let item = ItemKeys {
                transfer_function: Some(transfer_function),
                labels: labels.then_some(true),
                ..item(input, look)
            };
            (None, vec![item], settings)
        }
    };
    let document = Document {
        name,
        size: Some(PictureSize(recipe.settings.size)),
        background: Some(recipe.background.map_or(Background::None, Background::Color)),
        bits: Some(recipe.bits),
        items,
        camera: CameraKeys::from(&recipe.camera),
        settings,
        effects: effects(recipe.effects),
        motion: MotionKeys {
            sub_frames,
            ..motion.unwrap_or_default()
        },
        ..Document::default()
    };
    Record {
        document,
        command: recipe.command,
    }
}

/// Looks of a scene's items were chosen from the data every time; among several items, names of kinds were
/// kept.
fn of_scene(settings: SettingKeys, items: &[ItemKeys]) -> SettingKeys {
    let post = settings.classification == Some(ClassificationName::Post);
    SettingKeys {
        classification: settings.classification.filter(|_| !post || items.len() == 1),
        ..settings
    }
}

/// False is what an absent key means.
fn effects(keys: EffectKeys) -> EffectKeys {
    EffectKeys {
        iso_exact: keys.iso_exact.filter(|exact| *exact),
        clip_inside: keys.clip_inside.filter(|inside| *inside),
        clip_plane: keys.clip_plane.filter(|planes| !planes.is_empty()),
        ..keys
    }
}

fn item(input: Input, look: Look) -> ItemKeys {
    let raw = input.raw;
    let endian = |raw: &Raw| if raw.big_endian { "big" } else { "little" };
    ItemKeys {
        dims: raw.as_ref().map(|raw| raw.dims),
        sample_type: raw.as_ref().map(|raw| raw.sample_type.clone()),
        spacing: raw.as_ref().map(|raw| raw.spacing),
        endian: raw.as_ref().map(|raw| endian(raw).to_owned()),
        offset: raw.as_ref().map(|raw| raw.offset),
        array: input.array,
        component: input.component,
        time: Some(input.time).filter(|time| *time > 0),
        channel: input.channel,
        level: Some(input.level).filter(|level| *level > 0),
        series: input.series,
        up: input.up,
        tf: look.tf,
        cmap: look.cmap,
        opacity: look.opacity.map(Opacity::Curve),
        clim: look.clim,
        unit_distance: look.unit_distance,
        iso: look.iso,
        ..ItemKeys::of_file(input.reference)
    }
}

impl Motion {
    fn keys(self) -> MotionKeys {
        let still = MotionKeys::default();
        match self {
            Self::Linear { velocity } => MotionKeys {
                velocity: Some(velocity),
                ..still
            },
            Self::Spin {
                axis,
                centre,
                degrees,
            } => MotionKeys {
                spin: Some(degrees),
                spin_axis: Some(axis),
                spin_centre: Some(centre),
                ..still
            },
            Self::Camera { opening, closing } => MotionKeys {
                camera: Some(CameraSweep { opening, closing }),
                ..still
            },
        }
    }
}

fn with_blur(motion: MotionKeys, blur: splatvol_scene::MotionBlur) -> MotionKeys {
    let (name, subframes) = named_blur(blur);
    MotionKeys {
        motion_blur: Some(name),
        subframes,
        ..motion
    }
}
