//! `splatvol convert`: volumes, transfer functions and pictures, by the output's extension.

mod labels;
mod pyramid;

use std::path::Path;

use splatvol::TransferFunction;
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Reading, input, items};
use splatvol_io::{DataKind, ImageFormat, WriteOptions, encode_image, read_image, write_volume};

use crate::args::{ConvertArgs, of_input};
use crate::failure::{During, Failure, Step};
use crate::output::{Target, replace};
use crate::terminal::Terminal;

pub(crate) fn run(args: &ConvertArgs, terminal: &Terminal) -> Result<(), Failure> {
    if extension(&args.output) == "zarr" {
        refuse_look(args)?;
        pyramid::run(args, terminal)?;
        terminal.note(format!("wrote {}", args.output.display()));
        return Ok(());
    }
    if let Some(flag) = args.pyramid.given() {
        let message = format!("{flag} has no meaning for {}", args.output.display());
        return Err(Failure::usage(message).hint("it is for outputs named .ome.zarr"));
    }
    if extension(&args.output) != "json" {
        refuse_look(args)?;
    }
    Target::File(args.output.clone()).check(args.write.overwrite)?;
    match extension(&args.output).as_str() {
        "json" => transfer_function(args, terminal)?,
        "png" | "exr" => picture(args)?,
        _ => volume(args, terminal)?,
    }
    terminal.note(format!("wrote {}", args.output.display()));
    Ok(())
}

/// Refuses flags about transfer functions where none is written.
fn refuse_look(args: &ConvertArgs) -> Result<(), Failure> {
    let given = [
        ("--clim", args.clim.is_some()),
        ("--unit-distance", args.unit_distance.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((flag, _)) => {
            let message = format!("{flag} has no meaning for {}", args.output.display());
            Err(Failure::usage(message).hint("it is for transfer functions: outputs named .json"))
        }
        None => Ok(()),
    }
}

/// Refuses data other than volumes, by their kind. Files that nothing reads are left to the reader of volumes, which says why.
pub(crate) fn volumes_only(item: &ItemKeys, reading: Reading<'_>, command: &str) -> Result<(), Failure> {
    match items::kind(item, reading) {
        Ok((kind, _)) if kind != DataKind::Volume => {
            let message = format!("{} has {kind}; {command} takes volumes", item.file);
            Err(Failure::of(Step::Input, anyhow::anyhow!(message)))
        }
        _ => Ok(()),
    }
}

/// Refuses extensions that no writer of volumes has, before anything is read.
pub(crate) fn check_volume_extension(path: &Path) -> Result<(), Failure> {
    match extension(path).as_str() {
        "nrrd" | "npy" => Ok(()),
        _ => Err(
            Failure::usage(format!("{}: no output format has this extension", path.display()))
                .hint("volumes are written as .nrrd or .npy; convert writes .ome.zarr, too"),
        ),
    }
}

fn extension(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}

fn volume(args: &ConvertArgs, terminal: &Terminal) -> Result<(), Failure> {
    check_volume_extension(&args.output)?;
    let (item, reading) = (
        of_input(&args.read, &args.input),
        terminal.reads(args.read.rules()),
    );
    volumes_only(&item, reading, "convert")?;
    let input = input::load(&item, reading)?;
    if extension(&args.output) == "npy" {
        terminal.warn("NumPy files hold samples only: spacing, origin, direction and unit are lost");
    }
    replace(&args.output, args.write.overwrite, |path| {
        Ok(write_volume(path, &input.volume, &WriteOptions::default())?)
    })
}

fn transfer_function(args: &ConvertArgs, terminal: &Terminal) -> Result<(), Failure> {
    let range = args.clim.unwrap_or([0.0, 1.0]);
    let (read, warnings) = splatvol_io::read_transfer_function(&args.input, range).during(Step::Input)?;
    for warning in warnings {
        terminal.warn(format!("{}: {warning}", args.input));
    }
    let distance = read.unit_distance.or(args.unit_distance);
    let read = TransferFunction::new(read.colors().to_vec(), read.opacities().to_vec(), distance)
        .during(Step::Usage)?;
    replace(&args.output, args.write.overwrite, |path| {
        Ok(splatvol_io::write_transfer_function(path, &read)?)
    })
}

fn picture(args: &ConvertArgs) -> Result<(), Failure> {
    let read = read_image(&args.input).during(Step::Input)?;
    let format = ImageFormat::from_path(&args.output).unwrap_or_default();
    let depth = read.depth.as_deref().filter(|_| format == ImageFormat::Exr);
    let bytes = encode_image(&read.image, depth, format, &read.metadata).during(Step::Output)?;
    Target::File(args.output.clone()).write(&bytes, args.write.overwrite)
}
