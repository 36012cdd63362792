//! `splatvol part` and `splatvol assemble`: a picture by many processes.

use std::ops::Range;
use std::path::{Path, PathBuf};

use splatvol::{Control, Frame, RenderStatistics, TileRect};
use splatvol_document::format::read_scene;
use splatvol_document::{CameraMotion, Document, Picture, ReadRules, Reading, Record, Resolving};
use splatvol_io::{Assembly, ImageFormat, Part, PartHeader, PartOrigin, PictureBlock, state_of_files};

use super::asked::whole_where_needed;
use super::bands::{self, BandedPng, Sheet};
use super::outputs::encode_with_bits;
use super::render::{frame_of, say_holes};
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
            in_windows: true,
        })
        .map_err(|error| Failure::of_scene(error, &args.recipe.to_string_lossy()))?;
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
    let part = Part::new(&frame, (size, block), origin).during(Step::Usage)?;
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
        window: Some(TileRect {
            x0,
            y0,
            x1: x0 + block.width as usize,
            y1: y0 + block.height as usize,
        }),
        ..Control::default()
    };
    let frame = frame_of(picture, &mut renderer, &control)?;
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
    let parts = headers(&args.parts)?;
    let Some((_, first)) = parts.first() else {
        return Err(Failure::usage("no parts (files that end in .part)"));
    };
    let size = first.size;
    let document = Document::from_json(&first.recipe, "recipe".as_ref())?;
    let background = document
        .background
        .and_then(splatvol_document::keys::Background::color);
    let bits = document.bits.unwrap_or(8);
    let folder = args.output.parent().unwrap_or(Path::new(""));
    let record: Record = record::of(document, None, folder);
    let metadata = record.metadata()?;
    let memory = args.memory.unwrap_or(splatvol_io::memory::granted() / 2);
    let file = match &target {
        Target::File(path) if format != ImageFormat::Exr => Some(path),
        _ => None,
    };
    let holes = if let Some(path) = file.filter(|_| bands::are_needed(size, memory)) {
        let sheet = Sheet {
            size,
            background,
            bits,
            metadata: &metadata,
        };
        let mut png = BandedPng::new(path, sheet)?;
        let mut holes = 0;
        for rows in bands::bands(size, memory) {
            let (frame, lost) = rows_of(&parts, rows)?;
            png.write(&frame)?;
            holes += lost;
        }
        png.keep(args.write.overwrite)?;
        holes
    } else {
        let (frame, holes) = rows_of(&parts, 0..size.height())?;
        let bytes = encode_with_bits(&frame, (format, bits), background, &metadata)?;
        target.write(&bytes, args.write.overwrite)?;
        holes
    };
    if holes > 0 {
        terminal.warn(format!("{holes} chunks were lost, and are holes"));
    }
    let [width, height] = <[u32; 2]>::from(size);
    terminal.note(format!("wrote {} ({width}x{height})", args.output.display()));
    Ok(())
}

/// What the parts' files say of themselves.
fn headers(parts: &[PathBuf]) -> Result<Vec<(PathBuf, PartHeader)>, Failure> {
    let read = |path: PathBuf| Ok((path.clone(), PartHeader::read(&path).during(Step::Input)?));
    files(parts)?.into_iter().map(read).collect()
}

/// Some rows of the picture, and the lost chunks of the parts that begin there.
fn rows_of(parts: &[(PathBuf, PartHeader)], rows: Range<u32>) -> Result<(Frame, u64), Failure> {
    let (path, first) = &parts[0];
    let mut assembly = Assembly::of_rows(first, rows.clone(), path).during(Step::Input)?;
    for (path, header) in parts {
        let block = &header.block;
        if header.size != first.size || block.y < rows.end && rows.start < block.y + block.height {
            let bytes = std::fs::read(path).during(Step::Input)?;
            let part = Part::from_bytes(&bytes, path).during(Step::Input)?;
            assembly.add(&part, path).during(Step::Input)?;
        }
    }
    let holes = assembly.holes();
    Ok((assembly.finish().during(Step::Input)?, holes))
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
