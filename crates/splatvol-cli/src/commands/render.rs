//! `splatvol render`: resolve, render, write.

use std::path::Path;
use std::time::Instant;

use splatvol::{
    Camera, Classification, Compositing, Frame, Gradient, RenderSettings, RenderStatistics, Scene,
    SheetSettings, Shows,
};
use splatvol_document::CameraPose;
use splatvol_io::ImageFormat;

use super::outputs::{Outputs, encode_with_bits};
use super::shown::{Prepared, Preparing, Shown};
use super::studio::{Studio, engine};
use crate::args::{Background, CameraArgs, EffectArgs, MotionArgs, RenderArgs, values};
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::recipe::{InputRecipe, MotionRecipe, Recipe, Subject, VolumeRecipe, command_line};
use crate::resolve::effects::Effects;
use crate::resolve::input::Input;
use crate::resolve::look::Look;
use crate::resolve::motion::{CameraMotion, Earlier, Shot};
use crate::resolve::{camera, effects, input, look, method, motion};
use crate::terminal::Terminal;

pub(crate) fn run(args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
    if args.list_methods {
        return Target::Stdout.write(super::methods::list().as_bytes(), false);
    }
    let start = Instant::now();
    let shown = Shown::of(args)?;
    let outputs = Outputs::new(args, shown.reference())?;
    let keeps_alpha = outputs.format() == ImageFormat::Exr;
    let prepared = shown.prepare(args, (CameraMotion::default(), keeps_alpha), terminal)?;
    let (frame, statistics) = render(&prepared, terminal)?;
    terminal.detail(format!("rendered in {:.3} s", statistics.seconds.total));

    let recipe = &prepared.recipe;
    let overwrite = args.write.overwrite;
    outputs.write(
        &frame,
        (recipe.background, recipe.bits),
        &recipe.metadata()?,
        overwrite,
    )?;
    outputs.finish(&statistics, recipe.settings.size, (overwrite, start), terminal)
}

/// One volume by its flags.
pub(super) struct VolumeShown {
    /// The earlier picture that the flags name, if they do.
    like: Option<Like>,
    pub(super) input: InputRecipe,
}

/// An earlier picture of a volume.
struct Like {
    recipe: Recipe,
    volume: VolumeRecipe,
}

impl VolumeShown {
    /// The volume that the arguments name, or that of the earlier picture.
    pub(super) fn new(args: &RenderArgs, like: Option<Recipe>) -> Result<Self, Failure> {
        let like = like.and_then(|recipe| {
            let volume = recipe.volume()?.clone();
            Some(Like { recipe, volume })
        });
        let mut input = input::recipe(
            args.input.as_deref(),
            &args.read,
            like.as_ref().map(|like| &like.volume.input),
        )?;
        input.up = args.item.up.or(input.up);
        Ok(Self { like, input })
    }
}

/// Reads the volume and resolves the flags.
pub(super) fn prepare(shown: VolumeShown, preparing: Preparing<'_>) -> Result<Prepared, Failure> {
    let Preparing {
        args,
        moves,
        threads,
        terminal,
        ..
    } = preparing;
    let start = Instant::now();
    let VolumeShown {
        like,
        input: mut reference,
    } = shown;
    let like = like.as_ref();
    let beside = args
        .like
        .as_deref()
        .and_then(Path::parent)
        .filter(|_| args.input.is_none());
    let mut loaded = input::load(&reference, args.read.strict, beside, terminal)?;
    // An earlier picture of this volume has decided which way is up.
    if like.is_none_or(|like| like.volume.input.reference != reference.reference) {
        loaded.stand_up(&mut reference, terminal)?;
    }
    terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));

    let resolved = Resolved::new((args, like), (&loaded, moves), beside, terminal)?;
    let recipe = resolved.recipe(args, like, reference);
    let scene = Scene::from(resolved.look.item(loaded.volume));
    let mut scene = resolved.applied.apply(scene)?;
    if let Some(motion) = &resolved.motion {
        scene = scene.with_motion(&motion.motion().during(Step::Usage)?);
    }
    Ok(Prepared {
        recipe,
        camera: resolved.camera,
        scene,
        files: loaded.description.files,
        threads,
    })
}

fn render(prepared: &Prepared, terminal: &Terminal) -> Result<(Frame, RenderStatistics), Failure> {
    let Prepared {
        scene,
        camera,
        recipe,
        threads,
        ..
    } = prepared;
    if !recipe.sub_frames.is_empty() {
        let cameras = recipe.sub_frames.iter().map(CameraPose::camera);
        let cameras: Vec<Camera> = cameras.collect::<Result<_, _>>().during(Step::Input)?;
        let mut studio = Studio::new(scene, recipe.settings, *threads)?;
        let frame = studio.expose(&cameras)?.clone();
        return Ok((frame, studio.renderer().statistics().clone()));
    }
    let mut renderer = engine(*threads)?;
    let bar = terminal.progress("Rendering");
    let frame = renderer
        .render_with_progress(scene, camera, &recipe.settings, &|share| bar.set(share))
        .during(Step::Render)?;
    Ok((frame, renderer.statistics().clone()))
}

/// A frame as a picture file.
pub(super) fn encode(frame: &Frame, format: ImageFormat, recipe: &Recipe) -> Result<Vec<u8>, Failure> {
    encode_with_bits(
        frame,
        (format, recipe.bits),
        recipe.background,
        &recipe.metadata()?,
    )
}

/// All that is rendered.
struct Resolved {
    look: Look,
    settings: RenderSettings,
    camera: Camera,
    /// Effects in the picture's recipe.
    effects: EffectArgs,
    applied: Effects,
    motion: Option<MotionRecipe>,
}

impl Resolved {
    fn new(
        (args, like): (&RenderArgs, Option<&Like>),
        (input, moves): (&Input, CameraMotion),
        beside: Option<&Path>,
        terminal: &Terminal,
    ) -> Result<Self, Failure> {
        let mut effects = like.map_or_else(|| args.effects.clone(), |like| effects_like(args, like));
        let asked = like.map_or_else(|| args.look.clone(), |like| args.look.or(&like.volume.look));
        let function =
            effects::transfer_function_2d(&effects, &asked, input.volume.grid().mean_spacing(), beside)?;
        // Motion is blurred, or refused, when it is known what moves.
        let like_settings = like.map(|like| motion::still(like.recipe.settings.into()));
        let like_settings = like_settings.as_ref();
        let compositing = method::compositing(&args.method, like_settings);
        let mut look = match (&function, like.filter(|like| keeps_look(args, like, compositing))) {
            (Some(function), _) => Look::from(function.marginal().during(Step::Usage)?),
            (None, Some(like)) => like.volume.look(),
            (None, None) => look::resolve(&asked, input, compositing, terminal)?,
        };
        let mut settings = method::resolve(&args.method, args.size, like_settings, look.wishes)?;
        look.wishes.labels &= method::keeps_names(&args.method, &settings);
        if let (None, Some(curve)) = (&effects.gradient_opacity, &look.gradient_opacity) {
            if shows_gradients(&settings) {
                effects.gradient_opacity = Some(curve.clone());
            } else {
                terminal.warn("the transfer function's gradient opacity was left out: only post-classified image sheets with gradients by differences have it");
            }
        }
        let bounds = input.volume.grid().bounds();
        let applied = effects::resolve(&effects, &asked, &bounds, (function, beside))?;
        let camera = camera::resolve(
            &args.camera,
            &camera::surroundings(
                &args.camera,
                input,
                &look.transfer_function,
                settings.size.aspect(),
            )
            .turning(moves.turns),
            like.map(|like| &like.recipe.camera),
        )?;
        let earlier = like.map(|like| Earlier::new(&like.recipe, args, moves));
        let shot = Shot {
            camera: &camera,
            centre: bounds.centre(),
            plain: applied.is_empty(),
            shutter: moves.shutter,
        };
        let motion = motion::resolve(&args.motion, earlier, shot, &mut settings)?;
        Ok(Self {
            look,
            settings,
            camera,
            effects,
            applied,
            motion,
        })
    }

    /// Recipe of the picture. A picture made by `--like` alone is the same picture, and says the same.
    fn recipe(&self, args: &RenderArgs, like: Option<&Like>, input: InputRecipe) -> Recipe {
        let earlier = like.map(|like| &like.recipe);
        let recipe = Recipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command_line(),
            subject: Subject::Volume(VolumeRecipe {
                input,
                look: like.map_or_else(|| args.look.clone(), |like| args.look.or(&like.volume.look)),
                transfer_function: self.look.transfer_function.clone(),
                labels: self.look.wishes.labels,
            }),
            camera: CameraPose::from(&self.camera),
            sub_frames: kept_sub_frames(args, earlier),
            motion: self.motion,
            effects: self.effects.clone(),
            settings: self.settings,
            background: background(args.background, earlier),
            bits: bits(args, earlier),
        };
        recipe.or_same(earlier)
    }
}

/// A frame of an animation is the mean that it was, unless it is seen from elsewhere, or moves otherwise.
pub(super) fn kept_sub_frames(args: &RenderArgs, like: Option<&Recipe>) -> Vec<CameraPose> {
    let still = args.camera == CameraArgs::default() && args.motion == MotionArgs::default();
    like.filter(|_| still)
        .map_or_else(Vec::new, |like| like.sub_frames.clone())
}

/// Background of a picture: as asked, as in the earlier picture, or charcoal.
pub(super) fn background(asked: Option<Background>, like: Option<&Recipe>) -> Option<[f64; 4]> {
    match (asked, like) {
        (Some(Background::None), _) => None,
        (Some(Background::Color(color)), _) => Some(color),
        (None, Some(like)) => like.background,
        (None, None) => Some(values::CHARCOAL),
    }
}

/// Bits per channel.
pub(super) fn bits(args: &RenderArgs, like: Option<&Recipe>) -> u8 {
    args.bits.or(like.map(|like| like.bits)).unwrap_or(8)
}

/// Effects of an earlier picture where flags are silent. Another transfer function than the earlier picture's does not
/// take over what the file of that one, or its two-dimensional one, said.
fn effects_like(args: &RenderArgs, like: &Like) -> EffectArgs {
    let mut old = like.recipe.effects.clone();
    if args.look.tf.is_some() {
        old.gradient_opacity = None;
    }
    let asked = &args.look;
    if asked.tf.is_some() || asked.cmap.is_some() || asked.opacity.is_some() || asked.iso.is_some() {
        old.tf2d = None;
    }
    if args.effects.tf2d.is_some() || asked.or(&like.volume.look).iso.is_none() {
        old.iso_exact = false;
    }
    args.effects.or(&old)
}

/// Whether sheets are classified pixel by pixel, with gradients.
fn shows_gradients(settings: &RenderSettings) -> bool {
    let is_post = |sheets: &SheetSettings| sheets.shows == Shows::Material(Classification::Post);
    let sheets = settings.method.sheets().filter(|sheets| is_post(sheets));
    sheets.is_some_and(|sheets| sheets.gradient == Gradient::Differences)
}

/// Whether the earlier picture's transfer function is taken as it is: nothing was asked about it, and neither the
/// volume nor the compositing that an automatic choice depends on is another.
fn keeps_look(args: &RenderArgs, like: &Like, compositing: Compositing) -> bool {
    let same_input = args
        .input
        .as_ref()
        .is_none_or(|own| *own == like.volume.input.reference);
    args.look.is_empty() && same_input && compositing == like.recipe.settings.method.compositing()
}

/// A camera as flags.
pub(super) fn describe(camera: &Camera) -> String {
    let point = |p: glam::DVec3| format!("{:.6},{:.6},{:.6}", p.x, p.y, p.z);
    let projection = match camera.projection() {
        splatvol::Projection::Perspective { fov_degrees } => format!("--camera-fov {fov_degrees}"),
        splatvol::Projection::Orthographic { height } => format!("--orthographic={height}"),
    };
    format!(
        "--camera-pos={} --camera-target={} --camera-up={} {projection}",
        point(camera.position()),
        point(camera.target()),
        point(camera.up())
    )
}
