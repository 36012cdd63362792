//! `splatvol render` of what is not one volume: points, Gaussians, meshes, scenes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use splatvol::transfer_function::linear_from_srgb;
use splatvol::{Camera, Composition, Frame, GaussianMode, ImageSize, RenderSettings, RenderStatistics};
use splatvol_io::{DataKind, ImageFormat, SceneCamera, SceneFile, is_scene, read_scene};

use super::outputs::Outputs;
use super::render::describe;
use super::studio::engine;
use crate::args::{
    Background, CameraArgs, EffectArgs, ItemArgs, LookArgs, MethodArgs, MotionArgs, RenderArgs, ViewName,
    values,
};
use crate::failure::{During, Failure, Step};
use crate::recipe::{CameraRecipe, SceneRecipe, command_line};
use crate::resolve::camera::Surroundings;
use crate::resolve::items::{self, Reading, Source};
use crate::resolve::look::Wishes;
use crate::resolve::outline::outline;
use crate::resolve::{camera, method};
use crate::terminal::Terminal;

/// A scene, and who says what is in it.
pub(super) struct Composed {
    scene: SceneFile,
    source: fn(usize) -> Source,
    like: Option<SceneRecipe>,
    /// As the output is named after.
    reference: String,
    /// Folder of the picture whose files are meant.
    beside: Option<PathBuf>,
}

/// The scene that the arguments ask for; `None` where it is one volume.
pub(super) fn of(args: &RenderArgs) -> Result<Option<Composed>, Failure> {
    if let Some(picture) = args.like.as_deref()
        && let Some(like) = SceneRecipe::of_picture(picture)?
    {
        return again(args, picture, like).map(Some);
    }
    let Some(reference) = args.input.as_deref() else {
        return Ok(None);
    };
    let path = Path::new(reference);
    let (scene, source): (_, fn(usize) -> Source) = if is_scene(path) {
        of_file(path, args)?
    } else {
        let item = items::of_flags(args, reference);
        match items::kind(&item, None) {
            // What cannot be read is for the reader of volumes to say, in its words.
            Ok((DataKind::Volume, _)) | Err(_) => {
                return no_volume_flags(&args.item, reference).map(|()| None);
            }
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
    no_item_flags(args, "the scene of an earlier picture")?;
    Ok(Composed {
        scene: like.scene.clone(),
        source: Source::Scene,
        reference: like.reference.clone(),
        like: Some(like),
        beside: picture.parent().map(Path::to_owned),
    })
}

fn of_file(path: &Path, args: &RenderArgs) -> Result<(SceneFile, fn(usize) -> Source), Failure> {
    no_item_flags(args, "a scene, whose items say it themselves")?;
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

/// Flags that belong to one of several items are refused.
fn no_item_flags(args: &RenderArgs, what: &str) -> Result<(), Failure> {
    let (given, read) = (&args.item, &args.read);
    let of_item = ItemArgs {
        gaussians: None,
        ..given.clone()
    } != ItemArgs::default();
    let of_file = read.dims.is_some()
        || read.array.is_some()
        || read.component.is_some()
        || read.channel.is_some()
        || read.time.is_some()
        || read.level.is_some()
        || read.series.is_some();
    if of_item || of_file || args.look != LookArgs::default() {
        return Err(Failure::usage(format!(
            "flags about reading, colour, opacity, radius and orientation have no meaning for {what}"
        )));
    }
    Ok(())
}

/// Flags of other data are refused for a volume.
fn no_volume_flags(args: &ItemArgs, reference: &str) -> Result<(), Failure> {
    let given = [
        ("--up", args.up.is_some()),
        ("--gaussians", args.gaussians.is_some()),
        ("--radius", args.radius.is_some()),
        ("--point-color", args.point_color.is_some()),
        ("--point-opacity", args.point_opacity.is_some()),
        ("--drape", args.drape.is_some()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some(("--up", _)) => Err(
            Failure::usage(format!("--up has no meaning for a volume ({reference})"))
                .hint("--camera-up turns the camera"),
        ),
        Some((flag, _)) => Err(Failure::usage(format!(
            "{flag} has no meaning for a volume ({reference})"
        ))),
        None => Ok(()),
    }
}

impl Composed {
    /// Renders and writes the picture.
    pub(super) fn run(&self, args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
        let start = Instant::now();
        refuse_effects(args)?;
        let outputs = Outputs::new(args, &self.reference)?;
        let threads = args.threads.filter(|&n| n > 0);
        if let Some(threads) = threads {
            // The global pool exists already only if this ran before.
            let _ = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global();
        }
        let (composition, camera, recipe) = self.prepare(args, outputs.format(), terminal)?;
        terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));
        terminal.detail(format!("camera: {}", describe(&camera)));
        let (frame, statistics) = render(&composition, (&camera, &recipe.settings), threads, terminal)?;
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
    ) -> Result<(Composition, Camera, SceneRecipe), Failure> {
        let like = self.like.as_ref();
        let base = like.map(|like| like.settings).or(self.scene.settings);
        let mut settings = method::resolve(&args.method, self.size(args)?, base.as_ref(), Wishes::default())?;
        if let Some(mode) = args.item.gaussians {
            settings.gaussians = mode.into();
        }
        let reading = Reading {
            strict: args.read.strict,
            beside: self.beside.as_deref(),
            compositing: settings.compositing,
            terminal,
        };
        let items = items::load_all(&self.scene.items, self.source, reading)?;
        if items.is_empty() {
            return Err(Failure::usage(format!(
                "no item of {} is visible",
                self.reference
            )));
        }
        let mut composition = Composition::new(items).during(Step::Usage)?;
        check_gaussians(args, &composition, settings.gaussians)?;
        let background = self.background(args)?;
        // An EXR keeps its alpha.
        if let Some([r, g, b, a]) = background.filter(|_| format != ImageFormat::Exr) {
            let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
            composition.background = [r, g, b, a as f32];
        }
        let own = self.scene.camera.as_ref().filter(|_| like.is_none());
        let flags = match own {
            Some(own) => args.camera.or(&camera_args(own)?),
            None => args.camera.clone(),
        };
        let outlines = || {
            let items = &composition.items;
            items
                .iter()
                .flat_map(|item| outline(item, flags.fit.unwrap_or_default()))
                .collect()
        };
        let camera = camera::resolve(
            &flags,
            &Surroundings::of_outline(outlines, settings.size.aspect()),
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
        Ok((composition, camera, recipe))
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
    composition: &Composition,
    (camera, settings): (&Camera, &RenderSettings),
    threads: Option<usize>,
    terminal: &Terminal,
) -> Result<(Frame, RenderStatistics), Failure> {
    let mut renderer = engine(threads)?;
    let bar = terminal.progress("Rendering");
    let frame = renderer
        .render_composition(composition, camera, settings, &|share| bar.set(share))
        .during(Step::Render)?;
    Ok((frame, renderer.statistics().clone()))
}

/// Effects, clips and motion are of one volume.
fn refuse_effects(args: &RenderArgs) -> Result<(), Failure> {
    let what = if args.effects != EffectArgs::default() {
        "effects and clips"
    } else if args.motion != MotionArgs::default() {
        "motion blur"
    } else {
        return Ok(());
    };
    Err(Failure::usage(format!(
        "{what} are of one volume; points, Gaussians, meshes and scenes are rendered without"
    )))
}

/// Flags about Gaussians need Gaussians; flags about sheets need sheets.
fn check_gaussians(args: &RenderArgs, composition: &Composition, mode: GaussianMode) -> Result<(), Failure> {
    let has = |item: &splatvol::Item| matches!(item.content, splatvol::Content::Gaussians(_));
    if args.item.gaussians.is_some() && !composition.items.iter().any(has) {
        return Err(Failure::usage("--gaussians: there are none"));
    }
    let sorted = composition.is_gaussians() && mode != GaussianMode::Volumetric;
    if sorted && args.method != MethodArgs::default() {
        return Err(Failure::usage(
            "Gaussians are composited as published, where methods and lighting of sheets have no meaning",
        )
        .hint("--gaussians volumetric composites them in sheets"));
    }
    Ok(())
}

/// A scene's camera as flags.
fn camera_args(camera: &SceneCamera) -> Result<CameraArgs, Failure> {
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let triples = [camera.position, camera.target, camera.up];
    let numbers = [
        camera.fov,
        camera.orthographic,
        camera.azimuth,
        camera.elevation,
        camera.zoom,
    ];
    if !triples.iter().flatten().all(|triple| finite(triple))
        || !numbers.iter().flatten().all(|n| n.is_finite())
    {
        return Err(Failure::usage("camera: numbers have to be finite"));
    }
    let view = camera.view.as_deref().map(|name| {
        ViewName::from_str(name, false).map_err(|_| {
            let names = "front, back, left, right, top, bottom, iso";
            Failure::usage(format!("camera.view = {name:?}: expected one of {names}"))
        })
    });
    let both = |a: bool, b: bool, what| match a && b {
        true => Err(Failure::usage(format!("camera: {what} exclude each other"))),
        false => Ok(()),
    };
    both(
        camera.view.is_some(),
        camera.position.is_some(),
        "view and position",
    )?;
    both(
        camera.fov.is_some(),
        camera.orthographic.is_some(),
        "fov and orthographic",
    )?;
    Ok(CameraArgs {
        view: view.transpose()?,
        fit: None,
        camera_pos: camera.position,
        camera_target: camera.target,
        camera_up: camera.up,
        camera_fov: camera.fov,
        orthographic: camera.orthographic.map(Some),
        azimuth: camera.azimuth,
        elevation: camera.elevation,
        zoom: camera.zoom,
    })
}
