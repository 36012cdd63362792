//! `splatvol part` and `splatvol assemble`: a picture by many processes.

use std::path::{Path, PathBuf};

use splatvol::{Control, Frame, RenderStatistics, TileRect};
use splatvol_document::format::read_scene;
use splatvol_document::{CameraMotion, Document, Picture, ReadRules, Reading, Record, Resolving};
use splatvol_io::{Assembly, ImageFormat, Part, PartOrigin, PictureBlock, state_of_files};

use super::asked::whole_where_needed;
use super::outputs::encode_with_bits;
use super::render::say_holes;
use super::studio::{Means, engine, threads_within};
use crate::args::{AssembleArgs, EngineName, PartArgs};
use crate::failure::{During, Failure, Step};
use crate::output::{Target, picture_format};
use crate::record;
use crate::terminal::Terminal;

/// Makes a part.
pub(crate) fn run(args: &PartArgs, terminal: &Terminal) -> Result<(), Failure> {
    let document = Document {
        // The file may have any name.
        name: None,
        ..read_scene(&args.recipe)?
    };
    let target = Target::new(&args.output);
    let there = matches!(target, Target::File(_)) && args.output.exists() && !args.write.overwrite;
    if !there {
        target.check(args.write.overwrite)?;
    }
    let rules = ReadRules {
        allow_outside: args.allow_outside,
        chunks: Some(args.chunks.rules()),
        ..ReadRules::default()
    };
    let picture = document
        .resolve(Resolving {
            reading: Reading {
                rules,
                folder: None,
                listener: terminal,
            },
            held: &[],
            moves: CameraMotion::default(),
            keeps_alpha: false,
        })
        .map_err(Failure::of_scene)?;
    let picture = whole_where_needed(picture, EngineName::Cpu, terminal)?;
    let recipe = picture.document.to_json(false)?;
    let files = state_of_files(&picture.files).during(Step::Input)?;
    let size = picture.settings.size;
    let block = args.key.block(size).ok_or_else(|| {
        let [width, height] = <[u32; 2]>::from(size);
        Failure::usage(format!("a picture of {width}x{height} has no such block"))
    })?;
    if there {
        return match is_there(&args.output, (&recipe, &files), block) {
            true => {
                terminal.note(format!("{} is there and complete", args.output.display()));
                Ok(())
            }
            false => target.check(false),
        };
    }
    let (frame, statistics) = draw(&picture, block, args, terminal)?;
    say_holes(&statistics, terminal);
    let origin = PartOrigin {
        recipe,
        files,
        simd: statistics.simd,
        holes: statistics.chunks.holes,
    };
    let part = Part::new(&frame, block, origin).during(Step::Usage)?;
    target.write(&part.to_bytes().during(Step::Output)?, args.write.overwrite)
}

/// Whether a file holds a part already.
fn is_there(path: &Path, (recipe, files): (&str, &str), block: PictureBlock) -> bool {
    let read = std::fs::read(path)
        .ok()
        .and_then(|bytes| Part::from_bytes(&bytes, path).ok());
    read.is_some_and(|Part { header, .. }| {
        header.recipe == recipe && header.files == files && header.block == block
    })
}

fn draw(
    picture: &Picture,
    block: PictureBlock,
    args: &PartArgs,
    terminal: &Terminal,
) -> Result<(Frame, RenderStatistics), Failure> {
    let mut renderer = engine(Means {
        engine: EngineName::Cpu.into(),
        threads: args.threads.and_then(|asked| threads_within(asked, terminal)),
    })?;
    let bar = terminal.progress("Rendering");
    let report = |share: f64| bar.set(share);
    let [x0, y0] = [block.x, block.y].map(|first| first as usize);
    let control = Control {
        progress: Some(&report),
        part: Some(TileRect {
            x0,
            y0,
            x1: x0 + block.width as usize,
            y1: y0 + block.height as usize,
        }),
        ..Control::default()
    };
    let Picture {
        scene,
        camera,
        settings,
        sub_frames,
        ..
    } = picture;
    let mut frame = Frame::empty(settings.size);
    match &sub_frames[..] {
        [] => renderer.render_with(scene, camera, settings, &mut frame, &control),
        cameras => renderer.expose(scene, cameras, settings, &mut frame, &control),
    }
    .during(Step::Render)?;
    Ok((frame, renderer.statistics().clone()))
}

/// Puts parts together.
pub(crate) fn assemble(args: &AssembleArgs, terminal: &Terminal) -> Result<(), Failure> {
    let target = Target::new(&args.output);
    let format = match &target {
        Target::Stdout => ImageFormat::Png8,
        Target::File(path) => picture_format(path)?,
    };
    target.check(args.write.overwrite)?;
    let mut assembly: Option<Assembly> = None;
    for path in files(&args.parts)? {
        let bytes = std::fs::read(&path).during(Step::Input)?;
        assembly = Some(Assembly::joined(assembly, &bytes, &path).during(Step::Input)?);
    }
    let assembly = assembly.ok_or_else(|| Failure::usage("no parts (files that end in .part)"))?;
    if assembly.holes() > 0 {
        terminal.warn(format!("{} chunks were lost, and are holes", assembly.holes()));
    }
    let document = Document::from_json(assembly.recipe(), "recipe".as_ref())?;
    let frame = assembly.finish().during(Step::Input)?;
    let background = document
        .background
        .and_then(splatvol_document::keys::Background::color);
    let look = (format, document.bits.unwrap_or(8));
    let folder = args.output.parent().unwrap_or(Path::new(""));
    let record: Record = record::of(document, None, folder);
    let bytes = encode_with_bits(&frame, look, background, &record.metadata()?)?;
    target.write(&bytes, args.write.overwrite)?;
    let [width, height] = <[u32; 2]>::from(frame.image.size());
    terminal.note(format!("wrote {} ({width}x{height})", args.output.display()));
    Ok(())
}

/// The files, and those of the folders, in the order of their names.
fn files(parts: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for path in parts {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let mut inside = Vec::new();
        for entry in std::fs::read_dir(path).during(Step::Input)? {
            let path = entry.during(Step::Input)?.path();
            if path.extension().is_some_and(|extension| extension == "part") {
                inside.push(path);
            }
        }
        inside.sort();
        files.extend(inside);
    }
    Ok(files)
}
