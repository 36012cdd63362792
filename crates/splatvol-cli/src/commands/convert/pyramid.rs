//! Volumes to OME-Zarr with levels of detail.

use std::path::Path;

use splatvol_document::input;
use splatvol_io::{Opened, PyramidOptions, open_volume, write_pyramid};

use super::{labels, volumes_only};
use crate::args::{ConvertArgs, of_input};
use crate::failure::{During, Failure, Step};
use crate::terminal::Terminal;

pub(super) fn run(args: &ConvertArgs, terminal: &Terminal) -> Result<(), Failure> {
    if args.output.exists() && !args.write.overwrite {
        let message = anyhow::anyhow!("{} already exists", args.output.display());
        let exists: Result<(), Failure> = Err(message).during(Step::Output);
        return exists.map_err(|failure| failure.hint("-w overwrites it"));
    }
    let mut options = args.pyramid.options(args.write.overwrite);
    let volume = open(args, &mut options, terminal)?;
    options.labels = match args.pyramid.labels {
        Some(labels) => labels,
        None if volume.description.is_labels => true,
        None => {
            let seen = labels::are_in(&volume);
            if seen {
                terminal
                    .note("label map: levels have the label of most samples; --labels=false averages them");
            }
            seen
        }
    };
    let bar = terminal.progress(format!("Writing {}", args.output.display()));
    let written = write_pyramid(&volume, &args.output, &options, &|share| bar.set(share));
    drop(bar);
    let written = written.during(Step::Output).map_err(|failure| {
        failure.hint(
            "the same command continues what was begun; --memory, --chunk set the memory, -w starts again",
        )
    })?;
    if written.resumed {
        terminal.note("work that was begun before was continued");
    }
    written.warnings.iter().for_each(|warning| terminal.warn(warning));
    for (level, [x, y, z]) in written.levels.iter().enumerate() {
        terminal.detail(format!("level {level}: {x} x {y} x {z}"));
    }
    Ok(())
}

/// The input, chunk by chunk where its format allows that, otherwise in memory, which then counts.
fn open(args: &ConvertArgs, options: &mut PyramidOptions, terminal: &Terminal) -> Result<Opened, Failure> {
    let item = of_input(&args.read, &args.input);
    let mut rules = args.read.rules();
    volumes_only(&item, terminal.reads(rules), "convert")?;
    if !args.input.starts_with("sample:") {
        let mut read = input::options(&item, rules)?;
        // Beside the output there is room for what is not compressed.
        let folder = args
            .output
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        read.unpack_in = Some(folder.unwrap_or(Path::new(".")).to_owned());
        let spinner = terminal.spinner(format!("Reading {}", args.input));
        let opened = open_volume(&args.input, &read).during(Step::Input)?;
        drop(spinner);
        if let Some(opened) = opened {
            opened
                .description
                .warnings
                .iter()
                .for_each(|warning| terminal.warn(warning));
            return Ok(opened);
        }
    }
    let share = options.memory / 4 * 3;
    rules.max_bytes = Some(rules.max_bytes.map_or(share, |most| most.min(share)));
    let loaded = input::load(&item, terminal.reads(rules))?;
    let samples = loaded.volume.samples();
    let bytes = (samples.len() * samples.bytes_per_sample()) as u64;
    options.memory = options.memory.saturating_sub(bytes);
    Ok(Opened {
        unit: loaded.volume.unit(),
        is_divided: false,
        description: loaded.description,
        source: Box::<dyn splatvol::ChunkSource>::from(loaded.volume).into(),
    })
}
