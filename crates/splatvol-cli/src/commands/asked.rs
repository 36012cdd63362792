//! The document that `render` and `animate` ask for: flags over a scene file or an earlier picture.

mod refuse;

use std::path::{Path, PathBuf};

use splatvol::SceneError;
use splatvol_document::format::{is_scene, read_scene};
use splatvol_document::motion::CameraMotion;
use splatvol_document::{Document, DocumentError, Picture, Reading, Record, Resolving};
use splatvol_io::{IoError, is_plot3d_pair};

use super::render::describe;
use super::studio::{Means, threads_within};
use crate::args::{AnimateArgs, BenchArgs, EngineName, PageArgs, PictureArgs, RenderArgs};
use crate::failure::{During, Failure, Step};
use crate::record;
use crate::terminal::Terminal;

/// A document that is complete except for what the data decide.
pub(super) struct Asked {
    pub(super) document: Document,
    /// The scene file that says what is shown, if one does.
    scene: Option<String>,
    /// The earlier picture, if one is named.
    earlier: Option<Record>,
    /// Folder of the earlier picture, whose files are meant.
    folder: Option<PathBuf>,
}

/// What becomes of pictures.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Delivery {
    /// Whether the output keeps its alpha, whatever the background.
    pub(super) keeps_alpha: bool,
    /// Whether it may be written window by window.
    pub(super) in_windows: bool,
}

/// A picture that can be rendered, and the record for its file.
pub(super) struct Prepared {
    pub(super) picture: Picture,
    pub(super) record: Record,
    pub(super) means: Means,
}

impl Asked {
    /// The document that `render` asks for.
    pub(super) fn of(args: &RenderArgs) -> Result<Self, Failure> {
        let (input, solution) = inputs(args)?;
        Self::over((input, &args.picture), |file| {
            with_solution(args.document(file), solution)
        })
    }

    /// The document that `animate` asks for.
    pub(super) fn of_animation(args: &AnimateArgs) -> Result<Self, Failure> {
        let (input, solution) = inputs(&args.render)?;
        Self::over((input, &args.render.picture), |file| {
            with_solution(args.document(file), solution)
        })
    }

    /// The document that `bench` asks for of one of its inputs.
    pub(super) fn of_bench(args: &BenchArgs, input: Option<&str>) -> Result<Self, Failure> {
        Self::over((input, &args.picture), |file| {
            args.picture.document(args.size, file)
        })
    }

    /// The document that a page of a size asks for.
    pub(super) fn of_page(args: &PageArgs) -> Result<Self, Failure> {
        Self::over((args.input.as_deref(), &args.picture), |file| {
            args.picture.document(args.size, file)
        })
    }

    /// Flags over what the input or the earlier picture says.
    fn over(
        (input, args): (Option<&str>, &PictureArgs),
        flags: impl Fn(Option<&str>) -> Document,
    ) -> Result<Self, Failure> {
        let earlier = args.like.as_deref().map(record::of_picture).transpose()?;
        let scene = input.filter(|input| is_scene(Path::new(input)));
        let below = match (scene, &earlier) {
            (Some(_), Some(_)) => {
                return Err(Failure::usage(
                    "--like: a scene says itself what is in it, and how it looks",
                ));
            }
            (Some(scene), None) => of_file(scene, args)?,
            (None, Some(earlier)) => {
                refuse::other_items((input, args), &earlier.document)?;
                match args.effects.no_effects {
                    true => earlier.document.clone().without_effects(),
                    false => earlier.document.clone(),
                }
            }
            (None, None) => Document::default(),
        };
        let file = input.filter(|_| scene.is_none());
        let document = flags(file).over(&below);
        if document.items.is_empty() {
            return Err(Failure::usage("no input").hint("name a file, or sample:head"));
        }
        let folder = args.like.as_deref().filter(|_| input.is_none());
        if let (Some(earlier), false) = (&earlier, args.read.allow_outside) {
            refuse::outside((&document, &earlier.document), folder, file)?;
        }
        Ok(Self {
            document,
            scene: scene.map(str::to_owned),
            earlier,
            folder: folder.and_then(Path::parent).map(Path::to_owned),
        })
    }

    /// Drops the camera motion of an earlier frame: in an animation, frames have their own.
    pub(super) fn leave_motion_of_camera(&mut self) {
        self.document.motion.camera = None;
        self.document.motion.sub_frames = None;
    }

    /// The places and the way in which files are read.
    pub(super) fn reading<'a>(&'a self, args: &PictureArgs, terminal: &'a Terminal) -> Reading<'a> {
        Reading {
            rules: args.read.rules(),
            folder: self.folder.as_deref(),
            listener: terminal,
        }
    }

    /// Reads the items, and decides everything that is left open.
    pub(super) fn prepare(
        &self,
        args: &RenderArgs,
        (moves, delivery): (CameraMotion, Delivery),
        terminal: &Terminal,
    ) -> Result<Prepared, Failure> {
        let threads = threads(args.threads, terminal);
        let mut reading = self.reading(&args.picture, terminal);
        reading.rules.chunks = Some(args.chunks.rules());
        let resolving = Resolving {
            reading,
            held: &[],
            moves,
            keeps_alpha: delivery.keeps_alpha,
            in_windows: delivery.in_windows,
        };
        let picture = self.picture(&self.document, &args.picture, resolving)?;
        let picture = whole_where_needed(picture, args.engine, terminal)?;
        terminal.detail(format!("camera: {}", describe(&picture.camera)));
        let folder = args
            .output
            .as_deref()
            .and_then(Path::parent)
            .unwrap_or(Path::new(""));
        Ok(Prepared {
            record: record::of(picture.document.clone(), self.earlier.as_ref(), folder),
            picture,
            means: Means {
                engine: args.engine.into(),
                threads,
            },
        })
    }

    /// A picture of the document, or of a variation of it; refuses flags that have no meaning for it.
    pub(super) fn picture(
        &self,
        document: &Document,
        args: &PictureArgs,
        resolving: Resolving<'_>,
    ) -> Result<Picture, Failure> {
        let picture = document.resolve(resolving).map_err(|error| self.failure(error))?;
        refuse::gaussians(args, &picture.scene, &picture.settings)?;
        if !picture.scene.reads_chunks() {
            splatvol::check(&picture.scene, &picture.camera, &picture.settings).during(Step::Usage)?;
        }
        Ok(picture)
    }

    /// An error as that of the scene file or of the flags.
    pub(super) fn failure(&self, error: DocumentError) -> Failure {
        match &self.scene {
            Some(file) => Failure::of_scene(error, file),
            None if self.earlier.is_some() && is_absent(&error) => Failure::from(error).hint(
                "the picture names it from the folder that it was made in: give its place, \
                 splatvol render PLACE/OF/THE/FILE --like PICTURE, or run it in that folder",
            ),
            None => error.into(),
        }
    }
}

/// Whether a file is not there.
fn is_absent(error: &DocumentError) -> bool {
    let DocumentError::Input { error, .. } = error else {
        return false;
    };
    matches!(&**error, IoError::Open { source, .. } if source.kind() == std::io::ErrorKind::NotFound)
}

/// The threads asked for, of which reading and generating make use as well.
pub(super) fn threads(asked: Option<usize>, terminal: &Terminal) -> Option<usize> {
    let threads = asked.and_then(|asked| threads_within(asked, terminal));
    if let Some(threads) = threads {
        // They use the global pool; it exists already only if this ran before.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global();
    }
    threads
}

/// The picture with its volumes in memory, where they are read in chunks and the method or the engine needs all samples.
pub(super) fn whole_where_needed(
    mut picture: Picture,
    engine: EngineName,
    terminal: &Terminal,
) -> Result<Picture, Failure> {
    let check = |picture: &Picture| splatvol::check(&picture.scene, &picture.camera, &picture.settings);
    if !picture.scene.reads_chunks() {
        check(&picture).during(Step::Usage)?;
        return Ok(picture);
    }
    if check(&picture).and_then(|()| draws(engine, &picture)).is_err() {
        terminal.detail("volumes are read whole: the method, or the engine, needs all samples");
        picture.scene = picture.scene.in_memory().during(Step::Input)?;
        check(&picture).during(Step::Usage)?;
    }
    Ok(picture)
}

/// Checks that an engine draws a picture. Where there is a choice, the CPU's draws what the GPU's does not.
#[cfg(feature = "gpu")]
fn draws(engine: EngineName, picture: &Picture) -> Result<(), SceneError> {
    match engine {
        EngineName::Cpu | EngineName::Auto => Ok(()),
        EngineName::Gpu => splatvol::gpu::check(splatvol::Shot {
            scene: &picture.scene,
            camera: &picture.camera,
            settings: &picture.settings,
        }),
    }
}

/// Without the GPU's engine there is nothing to check: a program that is asked for it says so when it starts it.
#[cfg(not(feature = "gpu"))]
fn draws(_: EngineName, _: &Picture) -> Result<(), SceneError> {
    Ok(())
}

/// The input and, if there are two, its solution: a grid and a solution of PLOT3D, in either order.
fn inputs(args: &RenderArgs) -> Result<(Option<&str>, Option<&str>), Failure> {
    let (Some(first), Some(second)) = (args.input.as_deref(), args.second_input.as_deref()) else {
        return Ok((args.input.as_deref(), None));
    };
    for (grid, solution) in [(first, second), (second, first)] {
        if is_plot3d_pair(grid, solution) {
            return Ok((Some(grid), Some(solution)));
        }
    }
    let what = format!("two inputs, {first} and {second}, which are no grid and solution of PLOT3D");
    Err(Failure::usage(what).hint("a scene shows several files (scene.toml); -o names the picture"))
}

/// The document of flags, with the solution that is the second input.
fn with_solution(mut flags: Document, solution: Option<&str>) -> Document {
    if let (Some(item), Some(solution)) = (flags.items.first_mut(), solution) {
        item.solution = Some(solution.to_owned());
    }
    flags
}

fn of_file(scene: &str, args: &PictureArgs) -> Result<Document, Failure> {
    refuse::no_item_flags(args, "a scene, whose items say it themselves")?;
    let document = read_scene(scene)?;
    let nested = document.items.iter().position(|item| is_scene(&item.file));
    match nested {
        Some(index) => Err(Failure::usage(format!(
            "item[{index}].file = {:?} is a scene, and scenes hold no scenes, in {scene}",
            document.items[index].file
        ))),
        None => Ok(document),
    }
}
