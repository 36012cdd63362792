//! `splatvol render`: resolve, render, write.

use std::path::Path;
use std::time::Instant;

use splatvol::{Camera, Frame, RenderStatistics};
use splatvol_document::CameraMotion;
use splatvol_io::ImageFormat;

use super::asked::{Asked, Prepared};
use super::outputs::Outputs;
use super::studio::{Studio, engine};
use crate::args::RenderArgs;
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
    let keeps_alpha = outputs.format() == ImageFormat::Exr;
    let prepared = asked.prepare(args, (CameraMotion::default(), keeps_alpha), terminal)?;
    terminal.detail(format!("read in {:.2} s", start.elapsed().as_secs_f64()));
    let (frame, statistics) = render(&prepared, terminal)?;
    terminal.detail(format!("rendered in {:.3} s", statistics.seconds.total));
    say_holes(&statistics, terminal);
    if !statistics.why.is_empty() {
        terminal.note(format!("rendered by the CPU: {}", statistics.why));
    }

    let Prepared { picture, record, .. } = &prepared;
    let overwrite = args.write.overwrite;
    let look = (picture.background(), picture.bits());
    let metadata = if args.no_metadata {
        Vec::new()
    } else {
        record.metadata()?
    };
    outputs.write(&frame, look, &metadata, overwrite)?;
    outputs.finish(&statistics, picture.settings.size, (overwrite, start), terminal)
}

/// Writes the scene with nothing left open, and with paths that lead to its files from anywhere.
fn recipe(asked: &Asked, path: &Path, args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
    let target = Target::new(path);
    target.check(args.write.overwrite)?;
    let prepared = asked.prepare(args, (CameraMotion::default(), false), terminal)?;
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

fn render(prepared: &Prepared, terminal: &Terminal) -> Result<(Frame, RenderStatistics), Failure> {
    let Prepared { picture, means, .. } = prepared;
    if !picture.sub_frames.is_empty() {
        let mut studio = Studio::new(&picture.scene, picture.settings, *means)?;
        let frame = studio.expose(&picture.sub_frames)?.clone();
        return Ok((frame, studio.renderer().statistics().clone()));
    }
    let mut renderer = engine(*means)?;
    let bar = terminal.progress("Rendering");
    let frame = renderer
        .render_with_progress(&picture.scene, &picture.camera, &picture.settings, &|share| {
            bar.set(share);
        })
        .during(Step::Render)?;
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
