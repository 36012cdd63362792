//! Subject that the arguments of `render` and `animate` ask for: one volume by its flags, or anything else as a scene.

use std::path::PathBuf;

use splatvol::{Camera, Scene};

use super::composed::{self, Composed};
use super::render::{self, VolumeShown};
use crate::args::RenderArgs;
use crate::failure::{During, Failure, Step};
use crate::recipe::{Recipe, Subject};
use crate::resolve::motion::CameraMotion;
use crate::terminal::Terminal;

/// Subject of the pictures.
pub(super) enum Shown {
    /// One volume.
    Volume(Box<VolumeShown>),
    /// Points, Gaussians, a mesh, or the items of a scene.
    Scene(Box<Composed>),
}

/// All that rendering needs.
pub(super) struct Prepared {
    pub(super) scene: Scene,
    pub(super) camera: Camera,
    /// Recipe of a picture of it.
    pub(super) recipe: Recipe,
    /// Files that it was read from.
    pub(super) files: Vec<PathBuf>,
    pub(super) threads: Option<usize>,
}

/// How it is prepared.
#[derive(Clone, Copy)]
pub(super) struct Preparing<'a> {
    pub(super) args: &'a RenderArgs,
    /// Motion of the camera from frame to frame.
    pub(super) moves: CameraMotion,
    /// Whether the output keeps its alpha, whatever the background.
    pub(super) keeps_alpha: bool,
    pub(super) threads: Option<usize>,
    pub(super) terminal: &'a Terminal,
}

impl Shown {
    /// The subject that the arguments ask for.
    pub(super) fn of(args: &RenderArgs) -> Result<Self, Failure> {
        let like = args.like.as_deref().map(Recipe::of_picture).transpose()?;
        if let (Some(picture), Some(like)) = (&args.like, &like)
            && let Subject::Scene { .. } = like.subject
        {
            return composed::again(args, picture, like).map(|scene| Self::Scene(Box::new(scene)));
        }
        if let Some(scene) = composed::of(args)? {
            return Ok(Self::Scene(Box::new(scene)));
        }
        VolumeShown::new(args, like).map(|volume| Self::Volume(Box::new(volume)))
    }

    /// The input as typed, after which pictures are named.
    pub(super) fn reference(&self) -> &str {
        match self {
            Self::Volume(volume) => &volume.input.reference,
            Self::Scene(scene) => scene.reference(),
        }
    }

    /// Reads it and resolves the flags.
    pub(super) fn prepare(
        self,
        args: &RenderArgs,
        (moves, keeps_alpha): (CameraMotion, bool),
        terminal: &Terminal,
    ) -> Result<Prepared, Failure> {
        let threads = args.threads.filter(|&n| n > 0);
        if let Some(threads) = threads {
            // Reading and generating use the global pool; it exists already only if this ran before.
            let _ = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global();
        }
        let preparing = Preparing {
            args,
            moves,
            keeps_alpha,
            threads,
            terminal,
        };
        let prepared = match self {
            Self::Volume(volume) => render::prepare(*volume, preparing)?,
            Self::Scene(scene) => scene.prepare(preparing)?,
        };
        terminal.detail(format!("camera: {}", render::describe(&prepared.camera)));
        let Prepared {
            scene,
            camera,
            recipe,
            ..
        } = &prepared;
        splatvol::check(scene, camera, &recipe.settings).during(Step::Usage)?;
        Ok(prepared)
    }
}
