//! `splatvol render` of what is not one volume: points, Gaussians, meshes, scenes.

mod refuse;
mod scene_camera;

use std::path::{Path, PathBuf};
use std::time::Instant;

use splatvol::transfer_function::linear_from_srgb;
use splatvol::{Camera, Frame, ImageSize, RenderSettings, RenderStatistics, Scene};
use splatvol_io::{DataKind, ImageFormat, SceneFile, is_scene, read_scene};

use super::outputs::Outputs;
use super::render::describe;
use super::studio::engine;
use crate::args::{Background, RenderArgs, values};
use crate::failure::{During, Failure, Step};
use crate::recipe::{CameraRecipe, SceneRecipe, command_line};
use crate::resolve::camera::Surroundings;
use crate::resolve::item_keys::{self, Source};
use crate::resolve::items::{self, Reading};
use crate::resolve::look::Wishes;
use crate::resolve::outline::outline;
use crate::resolve::{camera, method};
use crate::terminal::Terminal;

/// Who says what an item is, by its number.
type SourceOf = fn(usize) -> Source;

/// A scene, and who says what is in it.
pub(in crate::commands) struct Composed {
    scene: SceneFile,
    source: SourceOf,
    like: Option<SceneRecipe>,
    /// As the output is named after.
    reference: String,
    /// Folder of the picture whose files are meant.
    beside: Option<PathBuf>,
}

/// The scene that the arguments ask for; `None` where it is one volume.
pub(in crate::commands) fn of(args: &RenderArgs) -> Result<Option<Composed>, Failure> {
    if let Some(picture) = args.like.as_deref()
        && let Some(like) = SceneRecipe::of_picture(picture)?
    {
        return again(args, picture, like).map(Some);
    }
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
fn again(args: &RenderArgs, picture: &Path, like: SceneRecipe) -> Result<Composed, Failure> {
    if args.input.is_some() {
        return Err(Failure::usage(format!(
            "{} says what is in it: --like takes no other input for it",
            picture.display()
        )));
    }
    refuse::no_item_flags(args, "the scene of an earlier picture")?;
    Ok(Composed {
        scene: like.scene.clone(),
        source: Source::Scene,
        reference: like.reference.clone(),
        like: Some(like),
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
    /// Renders and writes the picture.
    pub(super) fn run(&self, args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
        let start = Instant::now();
        refuse::effects(args)?;
        let outputs = Outputs::new(args, &self.reference)?;
        let threads = args.threads.filter(|&n| n > 0);
        if let Some(threads) = threads {
            // The global pool exists already only if this ran before.
            let _ = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global();
        }
        let (scene, camera, recipe) = self.prepare(args, outputs.format(), terminal)?;
        terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));
        terminal.detail(format!("camera: {}", describe(&camera)));
        let (frame, statistics) = render(&scene, (&camera, &recipe.settings), threads, terminal)?;
        terminal.detail(format!("rendered in {:.3} s", statistics.seconds.total));
        outputs.write(
            &frame,
            (recipe.background, recipe.bits),
            &recipe.metadata()?,
            args.write.overwrite,
        )?;
        outputs.finish(
            &statistics,
            recipe.settings.size,
            (args.write.overwrite, start),
            terminal,
        )
    }

    fn prepare(
        &self,
        args: &RenderArgs,
        format: ImageFormat,
        terminal: &Terminal,
    ) -> Result<(Scene, Camera, SceneRecipe), Failure> {
        let like = self.like.as_ref();
        let base = like.map(|like| like.settings).or(self.scene.settings);
        let reading = Reading {
            strict: args.read.strict,
            beside: self.beside.as_deref(),
            compositing: method::compositing(&args.method, base.as_ref()),
            alone: self
                .scene
                .items
                .iter()
                .filter(|item| item.visible != Some(false))
                .count()
                == 1,
            terminal,
        };
        let loaded = items::load_all(&self.scene.items, self.source, reading)?;
        // What a single item wants is what its file alone would get; several share one method.
        let (wishes, preferred) = match &loaded[..] {
            [] => {
                return Err(Failure::usage(format!(
                    "no item of {} is visible",
                    self.reference
                )));
            }
            [single] => (single.wishes, single.preferred),
            _ => (Wishes::default(), None),
        };
        let mut settings = method::resolve(&args.method, self.size(args)?, base.as_ref(), wishes)?;
        if let Some(mode) = args.item.gaussians {
            settings.gaussians = mode.into();
        }
        let items = loaded.into_iter().map(|loaded| loaded.item).collect();
        let mut scene = Scene::of_items(items).during(Step::Usage)?;
        refuse::gaussians(args, &scene, settings.gaussians)?;
        let background = self.background(args)?;
        // An EXR keeps its alpha.
        if let Some([r, g, b, a]) = background.filter(|_| format != ImageFormat::Exr) {
            let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
            scene.background = [r, g, b, a as f32];
        }
        let own = self.scene.camera.as_ref().filter(|_| like.is_none());
        let flags = match own {
            Some(own) => args.camera.or(&scene_camera::as_flags(own)?),
            None => args.camera.clone(),
        };
        let outlines = || {
            let items = &scene.items;
            items
                .iter()
                .flat_map(|item| outline(item, flags.fit.unwrap_or_default()))
                .collect()
        };
        let camera = camera::resolve(
            &flags,
            &Surroundings::of_outline(outlines, settings.size.aspect()).preferring(preferred),
            like.map(|like| &like.camera),
        )?;
        let recipe = SceneRecipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command_line(),
            reference: self.reference.clone(),
            scene: SceneFile {
                items: self.scene.items.clone(),
                ..SceneFile::default()
            },
            camera: CameraRecipe::from(&camera),
            settings,
            background,
            bits: args.bits.or(like.map(|like| like.bits)).unwrap_or(8),
        };
        let recipe = match like {
            Some(like) if like.is_same_picture(&recipe) => like.clone(),
            _ => recipe,
        };
        Ok((scene, camera, recipe))
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
        Ok(match (args.background.or(own), &self.like) {
            (Some(Background::None), _) => None,
            (Some(Background::Color(color)), _) => Some(color),
            (None, Some(like)) => like.background,
            (None, None) => Some(values::CHARCOAL),
        })
    }
}

fn render(
    scene: &Scene,
    (camera, settings): (&Camera, &RenderSettings),
    threads: Option<usize>,
    terminal: &Terminal,
) -> Result<(Frame, RenderStatistics), Failure> {
    let mut renderer = engine(threads)?;
    let bar = terminal.progress("Rendering");
    let frame = renderer
        .render_with_progress(scene, camera, settings, &|share| bar.set(share))
        .during(Step::Render)?;
    Ok((frame, renderer.statistics().clone()))
}
