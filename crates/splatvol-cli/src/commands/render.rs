//! `splatvol render`: resolve, render, write.

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use splatvol::{Camera, Control, Frame, ImageSize, Partial, RenderStatistics, Renderer, TileRect};
use splatvol_document::{CameraMotion, Picture};
use splatvol_io::ImageFormat;

use super::asked::{Asked, Delivery, Prepared};
use super::bands::{self, BandedPng, Sheet};
use super::nothing;
use super::outputs::Outputs;
use super::studio::engine;
use crate::args::{EngineName, RenderArgs};
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::terminal::Terminal;

pub(crate) fn run(args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
    if args.list_methods {
        return Target::Stdout.write(super::methods::list().as_bytes(), false);
    }
    let start = Instant::now();
    let asked = Asked::of(args)?;
    if let Some(path) = &args.recipe {
        return recipe(&asked, path, args, terminal);
    }
    let outputs = Outputs::new(args, asked.document.reference())?;
    let delivery = Delivery {
        keeps_alpha: outputs.format() == ImageFormat::Exr,
        in_windows: true,
    };
    let prepared = asked.prepare(args, (CameraMotion::default(), delivery), terminal)?;
    terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));
    let Prepared { picture, record, .. } = &prepared;
    let metadata = if args.no_metadata {
        Vec::new()
    } else {
        record.metadata()?
    };
    let overwrite = args.write.overwrite;
    let size = picture.settings.size;
    let memory = args.chunks.rules().memory;
    if args.partial.is_some() {
        outputs.partial()?;
    }
    let banded = outputs.banded().filter(|_| {
        args.partial.is_none() && bands::are_needed(size, memory) && args.engine == EngineName::Cpu
    });
    let (statistics, is_empty) = if let Some(path) = banded {
        let sheet = Sheet {
            size,
            background: picture.background(),
            bits: picture.bits(),
            metadata: &metadata,
        };
        render_bands(
            &prepared,
            (BandedPng::new(path, sheet)?, memory),
            overwrite,
            terminal,
        )?
    } else {
        picture
            .check_size()
            .map_err(|error| Failure::from(error).hint(bands::HINT))?;
        let look = (picture.background(), picture.bits());
        let between = args.partial.map(|every| Between {
            every: every.get(),
            outputs: &outputs,
            look,
            overwrite,
            failure: Mutex::new(None),
        });
        let (frame, statistics) = render(&prepared, between.as_ref(), terminal)?;
        if let Some(failure) = between.and_then(Between::failure) {
            return Err(failure);
        }
        outputs.write(&frame, look, &metadata, overwrite)?;
        (statistics, nothing::is_empty(&frame))
    };
    nothing::warn(is_empty, picture, terminal);
    terminal.detail(format!("rendered in {:.3} s", statistics.seconds.total));
    say_holes(&statistics, terminal);
    if !statistics.why.is_empty() {
        terminal.note(format!("rendered by the CPU: {}", statistics.why));
    }
    outputs.finish(&statistics, size, (overwrite, start), terminal)
}

/// Renders and writes a picture band by band; true if nothing is visible.
fn render_bands(
    prepared: &Prepared,
    (mut png, memory): (BandedPng, u64),
    overwrite: bool,
    terminal: &Terminal,
) -> Result<(RenderStatistics, bool), Failure> {
    let Prepared { picture, means, .. } = prepared;
    let size = picture.settings.size;
    let mut renderer = engine(*means)?;
    let bar = terminal.progress("Rendering");
    let mut all: Option<RenderStatistics> = None;
    let mut is_empty = true;
    for rows in bands::bands(size, memory) {
        let report = |share: f64| {
            let done = f64::from(rows.start) + share * rows.len() as f64;
            bar.set(done / f64::from(size.height()));
        };
        let window = TileRect {
            y0: rows.start as usize,
            y1: rows.end as usize,
            ..TileRect::of(size)
        };
        let control = Control {
            progress: Some(&report),
            window: Some(window),
            ..Control::default()
        };
        let band = frame_of(picture, &mut renderer, &control)?;
        is_empty = is_empty && nothing::is_empty(&band);
        png.write(&band)?;
        let own = renderer.statistics();
        all = Some(all.map_or_else(|| own.clone(), |before| before.plus(own)));
    }
    png.keep(overwrite)?;
    Ok((all.unwrap_or_default(), is_empty))
}

/// The frame of a picture, or of what a control asks for of it.
pub(super) fn frame_of(
    picture: &Picture,
    renderer: &mut Renderer,
    control: &Control<'_>,
) -> Result<Frame, Failure> {
    let Picture {
        scene,
        camera,
        settings,
        sub_frames,
        ..
    } = picture;
    // The renderer gives it its size.
    let mut frame = Frame::empty(ImageSize::new(1, 1).during(Step::Render)?);
    match &sub_frames[..] {
        [] => renderer.render_with(scene, camera, settings, &mut frame, control),
        cameras => renderer.expose(scene, cameras, settings, &mut frame, control),
    }
    .during(Step::Render)?;
    Ok(frame)
}

/// Writes the scene with nothing left open, and with paths that lead to its files from anywhere.
fn recipe(asked: &Asked, path: &Path, args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
    let target = Target::new(path);
    target.check(args.write.overwrite)?;
    let prepared = asked.prepare(args, (CameraMotion::default(), Delivery::default()), terminal)?;
    let text = prepared.picture.document.absolute().to_json(true)? + "\n";
    target.write(text.as_bytes(), args.write.overwrite)
}

/// Warns of chunks that were lost.
pub(super) fn say_holes(statistics: &RenderStatistics, terminal: &Terminal) {
    let holes = statistics.chunks.holes;
    if holes > 0 {
        terminal.warn(format!("{holes} chunks were lost, and are holes in the picture"));
    }
}

/// Pictures after every so many sheets, written as they come.
struct Between<'a> {
    every: usize,
    outputs: &'a Outputs,
    look: (Option<[f64; 4]>, u8),
    overwrite: bool,
    /// The first picture that could not be written.
    failure: Mutex<Option<Failure>>,
}

impl Between<'_> {
    fn write(&self, sheets: usize, (size, pixels): (ImageSize, &[[f32; 4]])) {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        if failure.is_some() {
            return;
        }
        let mut frame = Frame::empty(size);
        frame.image.pixels.copy_from_slice(pixels);
        *failure = self
            .outputs
            .write_partial(sheets, &frame, self.look, self.overwrite)
            .err();
    }

    fn failure(self) -> Option<Failure> {
        self.failure.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

fn render(
    prepared: &Prepared,
    between: Option<&Between<'_>>,
    terminal: &Terminal,
) -> Result<(Frame, RenderStatistics), Failure> {
    let Prepared { picture, means, .. } = prepared;
    let mut renderer = engine(*means)?;
    let bar = terminal.progress("Rendering");
    let report = |share: f64| bar.set(share);
    let size = picture.settings.size;
    let write = |sheets: usize, pixels: &[[f32; 4]]| {
        if let Some(between) = between {
            between.write(sheets, (size, pixels));
        }
    };
    let control = Control {
        progress: Some(&report),
        partial: between.map(|between| Partial {
            every: between.every,
            picture: &write,
        }),
        ..Control::default()
    };
    let frame = frame_of(picture, &mut renderer, &control)?;
    Ok((frame, renderer.statistics().clone()))
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
