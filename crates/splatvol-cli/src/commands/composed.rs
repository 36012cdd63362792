//! Subjects other than one volume by its flags: points, Gaussians, meshes, scenes.

mod refuse;
mod scene_camera;

use std::path::{Path, PathBuf};
use std::time::Instant;

use splatvol::transfer_function::linear_from_srgb;
use splatvol::{Camera, Content, FlatSettings, ImageSize, Item, RenderSettings, Scene, View};
use splatvol_document::{CameraKeys, CameraPose, Surroundings, outline};
use splatvol_io::{DataKind, SceneFile, SceneItem, is_scene, read_scene};

use super::render::{self, bits, kept_sub_frames};
use super::shown::{Prepared, Preparing};
use crate::args::{ClassificationName, EffectArgs, LookArgs, RenderArgs, values};
use crate::failure::{During, Failure, Step};
use crate::recipe::{Recipe, Subject, command_line};
use crate::resolve::effects::Effects;
use crate::resolve::item_keys::{self, Source};
use crate::resolve::items::{self, Reading};
use crate::resolve::look::Wishes;
use crate::resolve::motion::{CameraMotion, Earlier, Shot};
use crate::resolve::{effects, method, motion};
use crate::terminal::Terminal;

/// Who says what an item is, by its number.
type SourceOf = fn(usize) -> Source;

/// A scene, and who says what is in it.
pub(super) struct Composed {
    scene: SceneFile,
    source: SourceOf,
    like: Option<Recipe>,
    /// As the output is named after.
    reference: String,
    /// Folder of the picture whose files are meant.
    beside: Option<PathBuf>,
}

/// The scene that the arguments ask for; `None` where it is one volume.
pub(super) fn of(args: &RenderArgs) -> Result<Option<Composed>, Failure> {
    let Some(reference) = args.input.as_deref() else {
        return Ok(None);
    };
    let path = Path::new(reference);
    let (scene, source): (_, SourceOf) = if is_scene(path) {
        of_file(path, args)?
    } else {
        let item = item_keys::of_flags(args, reference);
        match items::kind(&item, None) {
            Ok((DataKind::Volume, _)) => {
                return refuse::no_volume_flags(&args.item, reference).map(|()| None);
            }
            // What cannot be read is for the reader of volumes to say, in its words.
            Err(_) => return Ok(None),
            Ok(_) => {
                let items = vec![item];
                let scene = SceneFile {
                    items,
                    ..SceneFile::default()
                };
                (scene, |_| Source::Flags)
            }
        }
    };
    if args.like.is_some() {
        return Err(Failure::usage(
            "--like: the settings of a picture of one volume cannot be taken for anything else",
        ));
    }
    Ok(Some(Composed {
        scene,
        source,
        like: None,
        reference: reference.to_owned(),
        beside: None,
    }))
}

/// The scene of an earlier picture.
pub(super) fn again(args: &RenderArgs, picture: &Path, like: &Recipe) -> Result<Composed, Failure> {
    if args.input.is_some() {
        return Err(Failure::usage(format!(
            "{} says what is in it: --like takes no other input for it",
            picture.display()
        )));
    }
    refuse::no_item_flags(args, "the scene of an earlier picture")?;
    let Subject::Scene { reference, scene } = &like.subject else {
        return Err(Failure::usage(format!("{} shows no scene", picture.display())));
    };
    Ok(Composed {
        scene: scene.clone(),
        source: Source::Scene,
        reference: reference.clone(),
        like: Some(like.clone()),
        beside: picture.parent().map(Path::to_owned),
    })
}

fn of_file(path: &Path, args: &RenderArgs) -> Result<(SceneFile, SourceOf), Failure> {
    refuse::no_item_flags(args, "a scene, whose items say it themselves")?;
    let scene = read_scene(path).during(Step::Input)?;
    if let Some((index, item)) = scene
        .items
        .iter()
        .enumerate()
        .find(|(_, item)| is_scene(&item.file))
    {
        return Err(Failure::usage(format!(
            "item[{index}].file = {:?} is a scene, and scenes hold no scenes, in {}",
            item.file,
            path.display()
        )));
    }
    Ok((scene, Source::Scene))
}

impl Composed {
    /// The input as typed.
    pub(super) fn reference(&self) -> &str {
        &self.reference
    }

    /// Reads the items and resolves the flags.
    pub(super) fn prepare(&self, preparing: Preparing<'_>) -> Result<Prepared, Failure> {
        let Preparing {
            args,
            moves,
            terminal,
            ..
        } = preparing;
        let start = Instant::now();
        let like = self.like.as_ref();
        let base = like.map(|like| like.settings.into()).or(self.scene.settings);
        let base = base.map(motion::still);
        let mut loaded = self.load(args, base.as_ref(), terminal)?;
        terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));
        let mut settings = method::resolve(&args.method, self.size(args)?, base.as_ref(), loaded.wishes)?;
        if let Some(mode) = args.item.gaussians {
            settings.gaussians = mode.into();
        }
        // Who asks for data to be interpolated gets names interpolated.
        let names = match loaded.scene.single_volume() {
            Ok(_) => method::keeps_names(&args.method, &settings),
            Err(_) => args.method.classification != Some(ClassificationName::Post),
        };
        for item in loaded.scene.items.iter_mut().filter(|_| !names) {
            if let Content::Volume { labels, .. } = &mut item.content {
                *labels = false;
            }
        }
        refuse::gaussians(args, &loaded.scene, &settings)?;
        let effects = like.map_or_else(|| args.effects.clone(), |like| args.effects.or(&like.effects));
        let applied = self.effects(&effects, &loaded.scene)?;
        let plain = applied.is_empty() && loaded.scene.single_volume().is_ok();
        let mut scene = applied.apply(loaded.scene)?;
        let background = self.background(args)?;
        if let Some([r, g, b, a]) = background.filter(|_| !preparing.keeps_alpha) {
            let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
            scene.background = [r, g, b, a as f32];
        }
        let framing = Framing {
            moves,
            preferred: loaded.preferred,
        };
        let camera = self.camera(args, (&scene, &settings), framing)?;
        let shot = Shot {
            camera: &camera,
            centre: scene.bounds().during(Step::Usage)?.centre(),
            plain,
            shutter: moves.shutter,
        };
        let earlier = like.map(|like| Earlier::new(like, args, moves));
        let motion = motion::resolve(&args.motion, earlier, shot, &mut settings)?;
        if let Some(motion) = &motion {
            scene = scene.with_motion(&motion.motion().during(Step::Usage)?);
        }
        let recipe = Recipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command_line(),
            subject: Subject::Scene {
                reference: self.reference.clone(),
                scene: SceneFile {
                    items: self.scene.items.clone(),
                    ..SceneFile::default()
                },
            },
            camera: CameraPose::from(&camera),
            sub_frames: kept_sub_frames(args, like),
            motion,
            effects,
            settings,
            background,
            bits: bits(args, like),
        };
        Ok(Prepared {
            recipe: recipe.or_same(like),
            camera,
            scene,
            files: loaded.files,
            threads: preparing.threads,
        })
    }

    /// Reads the items.
    fn load(
        &self,
        args: &RenderArgs,
        base: Option<&FlatSettings>,
        terminal: &Terminal,
    ) -> Result<Loaded, Failure> {
        let visible = |item: &&SceneItem| item.visible != Some(false);
        let reading = Reading {
            strict: args.read.strict,
            beside: self.beside.as_deref(),
            compositing: method::compositing(&args.method, base),
            alone: self.scene.items.iter().filter(visible).count() == 1,
            terminal,
        };
        let loaded = items::load_all(&self.scene.items, self.source, reading)?;
        // What a single item wants is what its file alone would get; several share one method.
        let (mut wishes, preferred) = match &loaded[..] {
            [] => {
                return Err(Failure::usage(format!(
                    "no item of {} is visible",
                    self.reference
                )));
            }
            [single] => (single.wishes, single.preferred),
            _ => (Wishes::default(), None),
        };
        let files = loaded.iter().flat_map(|loaded| loaded.files.clone()).collect();
        let items: Vec<Item> = loaded.into_iter().map(|loaded| loaded.item).collect();
        wishes.differences = items
            .iter()
            .any(|item| matches!(item.content, Content::Mesh { .. }));
        wishes.unclassified = items
            .iter()
            .all(|item| matches!(item.content, Content::Points { .. } | Content::Gaussians(_)));
        Ok(Loaded {
            scene: Scene::of_items(items).during(Step::Usage)?,
            wishes,
            preferred,
            files,
        })
    }

    /// The effects that the flags ask for.
    fn effects(&self, args: &EffectArgs, scene: &Scene) -> Result<Effects, Failure> {
        let mut visible = self.scene.items.iter().filter(|item| item.visible != Some(false));
        let look = LookArgs {
            iso: visible.next().and_then(|item| item.iso),
            ..LookArgs::default()
        };
        if args.tf2d.is_some() {
            return Err(Failure::usage(
                "--tf2d is of a volume named by itself: items of scenes have the transfer functions that they say",
            ));
        }
        let bounds = scene.bounds().during(Step::Usage)?;
        effects::resolve(args, &look, &bounds, (None, self.beside.as_deref()))
    }

    /// The flags' camera, the earlier picture's, the scene's, or one that shows everything.
    fn camera(
        &self,
        args: &RenderArgs,
        (scene, settings): (&Scene, &RenderSettings),
        framing: Framing,
    ) -> Result<Camera, Failure> {
        let like = self.like.as_ref();
        let own = self.scene.camera.as_ref().filter(|_| like.is_none());
        let flags = CameraKeys::from(&args.camera);
        let keys = match own {
            Some(own) => flags.or(&scene_camera::keys(own)?),
            None => flags,
        };
        let outlines = || {
            let of = |item| outline(item, keys.fit.unwrap_or_default());
            scene.items.iter().flat_map(of).collect()
        };
        let surroundings = Surroundings::of_outline(outlines, settings.size.aspect())
            .preferring(framing.preferred)
            .turning(framing.moves.turns);
        keys.resolve(&surroundings, like.map(|like| &like.camera))
            .during(Step::Usage)
    }

    /// The flag's size, or the scene's; an earlier picture's, or that of the scene's settings, is in the settings.
    fn size(&self, args: &RenderArgs) -> Result<Option<ImageSize>, Failure> {
        let own = self.scene.size.as_deref().map(values::image_size).transpose();
        let own = own.map_err(|why| Failure::usage(format!("size: {why}, in {}", self.reference)))?;
        Ok(args.size.or(own))
    }

    fn background(&self, args: &RenderArgs) -> Result<Option<[f64; 4]>, Failure> {
        let own = self
            .scene
            .background
            .as_deref()
            .map(values::background)
            .transpose();
        let own = own.map_err(|why| Failure::usage(format!("background: {why}, in {}", self.reference)))?;
        Ok(render::background(args.background.or(own), self.like.as_ref()))
    }
}

/// The items, and what they want.
struct Loaded {
    scene: Scene,
    wishes: Wishes,
    preferred: Option<View>,
    files: Vec<PathBuf>,
}

/// Hints for an automatic camera, besides the scene.
#[derive(Clone, Copy)]
struct Framing {
    moves: CameraMotion,
    preferred: Option<View>,
}
