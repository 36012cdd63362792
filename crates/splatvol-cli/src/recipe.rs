//! Recipe of a picture, kept in its PNG: everything that `render --like` needs to make it again.

use std::path::Path;

use anyhow::{Context, bail};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use splatvol::{Motion, RenderSettings, SceneError, TransferFunction};
use splatvol_document::CameraPose;
use splatvol_io::SceneFile;
use splatvol_io::image::metadata;

use crate::args::{EffectArgs, LookArgs, UpAxis};
use crate::failure::{During, Failure, Step};
use crate::resolve::look::Look;

/// Everything about a picture but its pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct Recipe {
    /// Version of splatvol that made it.
    pub(crate) version: String,
    /// The command line, quoted for a shell.
    pub(crate) command: String,
    /// Subject of the picture.
    #[serde(flatten)]
    pub(crate) subject: Subject,
    /// Camera, world.
    pub(crate) camera: CameraPose,
    /// Cameras of the pictures of which this is the mean, where it is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) sub_frames: Vec<CameraPose>,
    /// Motion while the shutter is open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) motion: Option<MotionRecipe>,
    /// Operators and clips.
    #[serde(default)]
    pub(crate) effects: EffectArgs,
    /// The method.
    pub(crate) settings: RenderSettings,
    /// sRGB with straight alpha; absent where the picture keeps its alpha.
    pub(crate) background: Option<[f64; 4]>,
    /// Bits per channel.
    pub(crate) bits: u8,
}

/// Subject of a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, rename_all_fields = "kebab-case")]
pub(crate) enum Subject {
    /// Items of a scene. Their looks come of the data again.
    Scene {
        /// The input as typed, after which pictures are named.
        reference: String,
        /// Its items; camera, settings and background are the picture's.
        scene: SceneFile,
    },
    /// One volume by its flags.
    Volume(VolumeRecipe),
}

/// A volume and its look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct VolumeRecipe {
    /// The volume and how it was read.
    pub(crate) input: InputRecipe,
    /// Flags of colour and opacity.
    pub(crate) look: LookArgs,
    /// The resulting transfer function.
    pub(crate) transfer_function: TransferFunction,
    /// Whether values are names of kinds.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) labels: bool,
}

impl VolumeRecipe {
    /// The look that it had.
    pub(crate) fn look(&self) -> Look {
        let mut look = Look::from(self.transfer_function.clone());
        look.wishes.labels = self.labels;
        look
    }
}

/// A volume by reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct InputRecipe {
    /// As typed: a path or `sample:NAME[:SIZE]`.
    pub(crate) reference: String,
    /// Layout of a headerless file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) raw: Option<RawRecipe>,
    /// Array of a file that holds several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) array: Option<String>,
    /// Component of vector-valued samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) component: Option<usize>,
    /// Time point of a series.
    #[serde(default)]
    pub(crate) time: usize,
    /// Channel of a multi-channel image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) channel: Option<usize>,
    /// Level of detail; 0 is the finest.
    #[serde(default, skip_serializing_if = "is_finest")]
    pub(crate) level: usize,
    /// Series of a folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) series: Option<String>,
    /// Axis that was turned to z, if one was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) up: Option<UpAxis>,
}

fn is_finest(level: &usize) -> bool {
    *level == 0
}

/// Layout of a headerless file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct RawRecipe {
    pub(crate) dims: [usize; 3],
    #[serde(rename = "type")]
    pub(crate) sample_type: String,
    pub(crate) spacing: [f64; 3],
    pub(crate) big_endian: bool,
    pub(crate) offset: u64,
}

/// A motion while the shutter is open, world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum MotionRecipe {
    /// The volume moves.
    Linear {
        /// By this, from opening to closing.
        velocity: [f64; 3],
    },
    /// The volume spins.
    Spin {
        axis: [f64; 3],
        centre: [f64; 3],
        degrees: f64,
    },
    /// The camera moves.
    Camera {
        opening: CameraPose,
        closing: CameraPose,
    },
}

impl MotionRecipe {
    /// The motion.
    pub(crate) fn motion(&self) -> Result<Motion, SceneError> {
        Ok(match self {
            Self::Linear { velocity } => Motion::Linear(DVec3::from_array(*velocity)),
            Self::Spin {
                axis,
                centre,
                degrees,
            } => Motion::Spin {
                axis: DVec3::from_array(*axis),
                centre: DVec3::from_array(*centre),
                angle: degrees.to_radians(),
            },
            Self::Camera { opening, closing } => Motion::Camera {
                opening: opening.camera()?,
                closing: closing.camera()?,
            },
        })
    }
}

impl Recipe {
    /// The recipe that a picture carries.
    pub(crate) fn of_picture(path: &Path) -> Result<Self, Failure> {
        Self::read(path)
            .with_context(|| format!("cannot take settings from {}", path.display()))
            .during(Step::Input)
    }

    fn read(path: &Path) -> anyhow::Result<Self> {
        let text = settings_of(path)?;
        serde_json::from_str(&text).context("its settings are malformed, or from a later version")
    }

    /// Whether pictures of both recipes are the same; the command may say it in other words.
    pub(crate) fn is_same_picture(&self, other: &Self) -> bool {
        let command = other.command.clone();
        *other
            == Self {
                command,
                ..self.clone()
            }
    }

    /// The earlier picture's recipe where it makes the same picture: one made by `--like` alone says the same.
    pub(crate) fn or_same(self, earlier: Option<&Self>) -> Self {
        match earlier {
            Some(earlier) if earlier.is_same_picture(&self) => earlier.clone(),
            _ => self,
        }
    }

    /// Keywords and texts for a picture's file.
    pub(crate) fn metadata(&self) -> Result<Vec<(String, String)>, Failure> {
        let settings = serde_json::to_string(self).during(Step::Output)?;
        Ok(vec![
            (
                metadata::SOFTWARE.to_owned(),
                format!("splatvol {}", self.version),
            ),
            ("Comment".to_owned(), self.command.clone()),
            (metadata::SETTINGS.to_owned(), settings),
        ])
    }

    /// The volume, where it is one by its flags.
    pub(crate) fn volume(&self) -> Option<&VolumeRecipe> {
        match &self.subject {
            Subject::Volume(volume) => Some(volume),
            Subject::Scene { .. } => None,
        }
    }
}

/// The settings in a picture's text.
fn settings_of(path: &Path) -> anyhow::Result<String> {
    let picture = splatvol_io::read_image(path)?;
    match metadata::find(&picture.metadata, metadata::SETTINGS) {
        Some(text) => Ok(text.to_owned()),
        None => bail!(
            "the picture does not say how it was made (splatvol did not write it, or another program saved it again)"
        ),
    }
}

/// This process's command line, quoted so that a POSIX shell gives it back.
pub(crate) fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@%#".contains(c);
    let quote = |arg: String| {
        if !arg.is_empty() && arg.chars().all(plain) {
            arg
        } else {
            format!("'{}'", arg.replace('\'', "'\\''"))
        }
    };
    let args = std::env::args_os()
        .skip(1)
        .map(|arg| quote(arg.to_string_lossy().into_owned()));
    std::iter::once("splatvol".to_owned())
        .chain(args)
        .collect::<Vec<_>>()
        .join(" ")
}
