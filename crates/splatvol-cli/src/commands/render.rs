//! `splatvol render`: resolve, render, write.

use std::path::{Path, PathBuf};
use std::time::Instant;

use splatvol::{
    Camera, Classification, Compositing, Frame, Gradient, MotionBlur, RenderSettings, RenderStatistics, Scene,
};
use splatvol_io::ImageFormat;

use super::composed;
use super::outputs::{Outputs, encode_with_bits};
use super::studio::{Studio, engine};
use crate::args::{Background, CameraArgs, EffectArgs, MotionArgs, RenderArgs, values};
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::recipe::{CameraRecipe, InputRecipe, MotionRecipe, Recipe, command_line};
use crate::resolve::camera::Surroundings;
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
    if let Some(composed) = composed::of(args)? {
        return composed.run(args, terminal);
    }
    let start = Instant::now();
    let (like, reference) = sources(args)?;
    let outputs = Outputs::new(args, &reference.reference)?;
    let prepared = prepare(
        args,
        (like.as_ref(), reference),
        CameraMotion::default(),
        terminal,
    )?;
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

/// The earlier picture that the flags name, if they do, and the volume.
pub(super) fn sources(args: &RenderArgs) -> Result<(Option<Recipe>, InputRecipe), Failure> {
    let like = args.like.as_deref().map(Recipe::of_picture).transpose()?;
    let mut reference = input::recipe(
        args.input.as_deref(),
        &args.read,
        like.as_ref().map(|like| &like.input),
    )?;
    reference.up = args.item.up.or(reference.up);
    Ok((like, reference))
}

/// All that rendering needs.
pub(super) struct Prepared {
    pub(super) scene: Scene,
    pub(super) camera: Camera,
    /// What a picture of it remembers.
    pub(super) recipe: Recipe,
    /// Files that the volume was read from.
    pub(super) files: Vec<PathBuf>,
    pub(super) threads: Option<usize>,
}

/// Reads the volume and resolves the flags.
pub(super) fn prepare(
    args: &RenderArgs,
    (like, mut reference): (Option<&Recipe>, InputRecipe),
    moves: CameraMotion,
    terminal: &Terminal,
) -> Result<Prepared, Failure> {
    let start = Instant::now();
    let threads = args.threads.filter(|&n| n > 0);
    if let Some(threads) = threads {
        // Reading and generating use the global pool; it exists already only if this ran before.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global();
    }
    let beside = args
        .like
        .as_deref()
        .and_then(Path::parent)
        .filter(|_| args.input.is_none());
    let mut loaded = input::load(&reference, args.read.strict, beside, terminal)?;
    // An earlier picture of this volume has decided which way is up.
    if like.is_none_or(|like| like.input.reference != reference.reference) {
        loaded.stand_up(&mut reference, terminal)?;
    }
    terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));

    let resolved = Resolved::new((args, like), (&loaded, moves), beside, terminal)?;
    terminal.detail(format!("camera: {}", describe(&resolved.camera)));
    let recipe = resolved.recipe(args, like, reference);
    let mut scene = resolved
        .applied
        .scene(loaded.volume, resolved.look.transfer_function)?;
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
        let cameras = recipe.sub_frames.iter().map(CameraRecipe::camera);
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
    /// What the picture remembers of its effects.
    effects: EffectArgs,
    applied: Effects,
    motion: Option<MotionRecipe>,
}

impl Resolved {
    fn new(
        (args, like): (&RenderArgs, Option<&Recipe>),
        (input, moves): (&Input, CameraMotion),
        beside: Option<&Path>,
        terminal: &Terminal,
    ) -> Result<Self, Failure> {
        let mut effects = like.map_or_else(|| args.effects.clone(), |like| effects_like(args, like));
        let asked = like.map_or_else(|| args.look.clone(), |like| args.look.or(&like.look));
        let function = effects::transfer_function_2d(&effects, &asked, &input.volume, beside)?;
        // Motion is blurred, or refused, when it is known what moves.
        let like_settings = like.map(|like| RenderSettings {
            motion_blur: MotionBlur::None,
            ..like.settings
        });
        let like_settings = like_settings.as_ref();
        let compositing = method::compositing(&args.method, like_settings);
        let look = match (&function, like.filter(|like| keeps_look(args, like, compositing))) {
            (Some(function), _) => Look::from(function.marginal().during(Step::Usage)?),
            (None, Some(like)) => Look::from(like.transfer_function.clone()),
            (None, None) => look::resolve(&asked, input, compositing, terminal)?,
        };
        let mut settings = method::resolve(&args.method, args.size, like_settings, look.wishes)?;
        if let (None, Some(curve)) = (&effects.gradient_opacity, &look.gradient_opacity) {
            if shows_gradients(&settings) {
                effects.gradient_opacity = Some(curve.clone());
            } else {
                terminal.warn("the transfer function's gradient opacity was left out: only post-classified image sheets with gradients by differences have it");
            }
        }
        let applied = effects::resolve(&effects, &asked, &input.volume, (function, beside))?;
        let camera = camera::resolve(
            &args.camera,
            &Surroundings::new(
                &args.camera,
                input,
                &look.transfer_function,
                settings.size.aspect(),
            )
            .turning(moves.turns),
            like.map(|like| &like.camera),
        )?;
        let earlier = like.map(|like| Earlier::new(like, args, moves));
        let shot = Shot {
            camera: &camera,
            volume: &input.volume,
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

    /// What the picture remembers. A picture made by `--like` alone is the same picture, and says the same.
    fn recipe(&self, args: &RenderArgs, like: Option<&Recipe>, input: InputRecipe) -> Recipe {
        let background = match (args.background, like) {
            (Some(Background::None), _) => None,
            (Some(Background::Color(color)), _) => Some(color),
            (None, Some(like)) => like.background,
            (None, None) => Some(values::CHARCOAL),
        };
        let recipe = Recipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command_line(),
            input,
            camera: CameraRecipe::from(&self.camera),
            // A frame of an animation is the mean that it was, unless it is seen from elsewhere, or moves otherwise.
            sub_frames: like
                .filter(|_| args.camera == CameraArgs::default() && args.motion == MotionArgs::default())
                .map_or_else(Vec::new, |like| like.sub_frames.clone()),
            motion: self.motion,
            look: like.map_or_else(|| args.look.clone(), |like| args.look.or(&like.look)),
            transfer_function: self.look.transfer_function.clone(),
            effects: self.effects.clone(),
            settings: self.settings,
            background,
            bits: args.bits.or(like.map(|like| like.bits)).unwrap_or(8),
        };
        like.filter(|like| like.is_same_picture(&recipe))
            .cloned()
            .unwrap_or(recipe)
    }
}

/// Effects of an earlier picture where flags are silent. Another transfer function than the earlier picture's does not
/// take over what the file of that one, or its two-dimensional one, said.
fn effects_like(args: &RenderArgs, like: &Recipe) -> EffectArgs {
    let mut old = like.effects.clone();
    if args.look.tf.is_some() {
        old.gradient_opacity = None;
    }
    let asked = &args.look;
    if asked.tf.is_some() || asked.cmap.is_some() || asked.opacity.is_some() || asked.iso.is_some() {
        old.tf2d = None;
    }
    if args.effects.tf2d.is_some() || asked.or(&like.look).iso.is_none() {
        old.iso_exact = false;
    }
    args.effects.or(&old)
}

/// Whether sheets are classified pixel by pixel, with gradients.
fn shows_gradients(settings: &RenderSettings) -> bool {
    settings.compositing == Compositing::ImageSheets
        && settings.classification == Classification::Post
        && settings.gradient == Gradient::Differences
}

/// Whether the earlier picture's transfer function is taken as it is: nothing was asked about it, and neither the
/// volume nor the compositing that an automatic choice depends on is another.
fn keeps_look(args: &RenderArgs, like: &Recipe, compositing: Compositing) -> bool {
    let same_input = args.input.as_ref().is_none_or(|own| *own == like.input.reference);
    args.look.is_empty() && same_input && compositing == like.settings.compositing
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
