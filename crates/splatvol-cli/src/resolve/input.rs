//! The input volume: a file or a built-in sample.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use glam::DVec3;
use splatvol::Volume;
use splatvol_io::{Description, Endian, RawLayout, ReadOptions};
use splatvol_samples::Sample;

use crate::args::{InputArgs, values};
use crate::failure::{During, Failure, Step};
use crate::recipe::{InputRecipe, RawRecipe};
use crate::terminal::Terminal;

/// A volume, and what is known about it.
pub(crate) struct Input {
    pub(crate) volume: Arc<Volume>,
    pub(crate) description: Description,
    /// Which sample it is, if it is one.
    pub(crate) sample: Option<Sample>,
}

/// The input as flags, or an earlier picture, describe it. A reference of its own makes the picture's reading
/// options void: they belong to another file.
pub(crate) fn recipe(
    reference: Option<&str>,
    args: &InputArgs,
    like: Option<&InputRecipe>,
) -> Result<InputRecipe, Failure> {
    let like = like.filter(|like| reference.is_none_or(|own| own == like.reference));
    let Some(reference) = reference.or(like.map(|like| like.reference.as_str())) else {
        return Err(Failure::usage("no input volume").hint("name a file, or sample:head"));
    };
    Ok(InputRecipe {
        reference: reference.to_owned(),
        raw: raw(args).or_else(|| like.and_then(|like| like.raw.clone())),
        array: args
            .array
            .clone()
            .or_else(|| like.and_then(|like| like.array.clone())),
        component: args.component.or(like.and_then(|like| like.component)),
        time: args.time.or(like.map(|like| like.time)).unwrap_or(0),
        channel: args.channel.or(like.and_then(|like| like.channel)),
        level: args.level.or(like.map(|like| like.level)).unwrap_or(0),
        series: args
            .series
            .clone()
            .or_else(|| like.and_then(|like| like.series.clone())),
        up: like.and_then(|like| like.up),
    })
}

fn raw(args: &InputArgs) -> Option<RawRecipe> {
    Some(RawRecipe {
        dims: args.dims?,
        sample_type: args.sample_type?.name().to_owned(),
        spacing: args.spacing.unwrap_or([1.0; 3]),
        big_endian: args.endian == Some(Endian::Big),
        offset: args.offset.unwrap_or(0),
    })
}

/// Reads or generates the volume, and turns it if so said; warnings go to the terminal. `beside` is where a relative path
/// that leads nowhere from here is tried next.
pub(crate) fn load(
    recipe: &InputRecipe,
    strict: bool,
    beside: Option<&Path>,
    terminal: &Terminal,
) -> Result<Input, Failure> {
    let mut input = as_stored(recipe, strict, beside, terminal)?;
    if let Some(axis) = recipe.up {
        input.turn(axis)?;
    }
    Ok(input)
}

fn as_stored(
    recipe: &InputRecipe,
    strict: bool,
    beside: Option<&Path>,
    terminal: &Terminal,
) -> Result<Input, Failure> {
    let _spinner = terminal.spinner(format!("Reading {}", recipe.reference));
    if let Some(name) = recipe.reference.strip_prefix("sample:") {
        return generate(name);
    }
    let path = locate(Path::new(&recipe.reference), beside);
    let loaded = splatvol_io::read_volume(&path, &options(recipe, strict)?)
        .during(Step::Input)
        .map_err(|failure| with_hint(failure, recipe, &path))?;
    for warning in &loaded.description.warnings {
        terminal.warn(format!("{}: {warning}", recipe.reference));
    }
    Ok(Input {
        volume: Arc::new(loaded.volume),
        description: loaded.description,
        sample: None,
    })
}

/// Generates `NAME` or `NAME:SIZE`.
fn generate(text: &str) -> Result<Input, Failure> {
    let (name, size) = match text.split_once(':') {
        Some((name, size)) => (name, Some(size)),
        None => (text, None),
    };
    let size = size
        .map(values::sample_size)
        .transpose()
        .map_err(|expected| Failure::usage(format!("sample:{text}: {expected}")))?;
    let sample = Sample::from_name(name)
        .during(Step::Input)
        .map_err(|failure| failure.hint("splatvol sample lists them"))?;
    let volume = sample.generate(size).during(Step::Input)?;
    let description = Description {
        format: "built-in sample".to_owned(),
        stored_type: volume.samples().type_name().to_owned(),
        orientation: match sample {
            Sample::Head => "RAS+ by construction".to_owned(),
            _ => "none: world axes are the grid's".to_owned(),
        },
        oriented: true,
        ..Description::default()
    };
    Ok(Input {
        volume: Arc::new(volume),
        description,
        sample: Some(sample),
    })
}

/// A path, or if it leads nowhere and one in the folder `beside` does, that.
pub(crate) fn locate(path: &Path, beside: Option<&Path>) -> PathBuf {
    let there = beside
        .map(|folder| folder.join(path))
        .filter(|there| there.exists());
    match there {
        Some(there) if !path.exists() => there,
        _ => path.to_owned(),
    }
}

/// Options for the readers.
pub(crate) fn options(recipe: &InputRecipe, strict: bool) -> Result<ReadOptions, Failure> {
    let raw = match &recipe.raw {
        None => None,
        Some(raw) => Some(RawLayout {
            dims: raw.dims,
            sample_type: values::sample_type(&raw.sample_type)
                .map_err(anyhow::Error::msg)
                .context("settings of the picture given with --like")
                .during(Step::Input)?,
            spacing: DVec3::from_array(raw.spacing),
            endian: if raw.big_endian {
                Endian::Big
            } else {
                Endian::Little
            },
            offset: raw.offset,
        }),
    };
    Ok(ReadOptions {
        raw,
        array: recipe.array.clone(),
        component: recipe.component,
        time: recipe.time,
        channel: recipe.channel,
        level: recipe.level,
        series: recipe.series.clone(),
        strict,
        ..ReadOptions::default()
    })
}

fn with_hint(failure: Failure, recipe: &InputRecipe, path: &Path) -> Failure {
    let named_sample = Sample::ALL.iter().any(|sample| sample.name() == recipe.reference);
    if !path.exists() && named_sample {
        failure.hint(format!(
            "built-in volumes are written sample:{}",
            recipe.reference
        ))
    } else if path.extension().is_some_and(|ext| ext == "raw" || ext == "bin") && recipe.raw.is_none() {
        failure.hint("files without a header need --dims and --type")
    } else {
        failure
    }
}
