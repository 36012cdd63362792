//! DICOM images: a folder of slices, or a single file of one or many frames (<https://www.dicomstandard.org>).
//!
//! A folder's images are grouped by series, and within a series by orientation, spacing and form of samples; the
//! largest group is read unless [`ReadOptions::series`] names another. Real values are `slope * stored + intercept`,
//! per slice where slices differ. Patient space is LPS and becomes RAS+. MONOCHROME1, where low values are bright, is
//! inverted.
//!
//! Read: 8, 16 and 32 bits; implicit, explicit, big-endian and deflated coding; RLE, JPEG baseline and lossless,
//! JPEG-LS, JPEG 2000. Not read: colours, samples of one bit, JPEG of 12 bits, videos, modality look-up tables.

mod arrange;
mod colors;
mod contents;
mod element;
mod image;
mod jpeg_12;
mod jpeg_12_bits;
mod jpeg_ls;
mod jpeg_ls_bits;
mod jpeg_ls_context;
mod jpeg_ls_header;
mod jpeg_ls_scan;
mod pixels;
mod series;
mod syntax;
mod uneven;

use std::path::{Path, PathBuf};

use splatvol_scene::LengthUnit;

use super::planes::component_names;
use super::stack::{self, Slices};
use super::{
    Description, Draft, Loaded, Opened, ReadOptions, checked_dims, choose_channel, detect, ras_from_lps,
    sample_count,
};
use crate::error::Context;
use crate::files;
use crate::samples::SampleType;
use crate::source::Source;
use crate::{IoError, axis_codes};
use contents::Contents;
use image::{Elements, Form, FrameHead, ImageHead, Series};
use series::{SeriesSlices, Slice};

/// Directions and spacing of slices of one volume agree up to this.
const ALIKE: f64 = 1e-3;

/// True where the file's word stands behind its preamble (PS3.10, section 7.1), whatever the preamble holds: in dual-purpose
/// files the header of a TIFF.
pub(crate) fn says_dicm(start: &[u8]) -> bool {
    start.get(128..132) == Some(b"DICM")
}

/// True where the first bytes (132 at least, if there are as many) are those of a DICOM file.
pub(super) fn starts_dicom(start: &[u8]) -> bool {
    let representation = || {
        start
            .get(4..6)
            .is_some_and(|letters| matches!(letters, b"UL" | b"CS" | b"UI" | b"OB"))
    };
    says_dicm(start)
        || ((start.starts_with(&[2, 0, 0, 0]) || matches!(start, [8, 0, _, 0, ..])) && representation())
}

/// True for a DICOM file.
pub(super) fn is_dicom(path: &Path) -> bool {
    let context = Context::new("DICOM", path);
    let mut start = [0; 132];
    let read = Source::open(path).and_then(|mut source| source.fill(&mut start, &context));
    read.is_ok_and(|length| starts_dicom(&start[..length])) || detect::extension(path) == "dcm"
}

/// Reads a folder or a file.
///
/// # Errors
/// See [`IoError`]; also slices that do not follow one line, and a transfer syntax that is not covered.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("DICOM", path).following(options);
    let (series, draft) = SeriesSlices::choose(path, options, context)?;
    sample_count(draft.dims, 1, SampleType::F32, options, context)?;
    let samples = series.all(context)?;
    draft.finish(samples, context)
}

/// Opens a folder or a file, whose slices are read when they are asked for.
///
/// # Errors
/// As [`read`].
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Opened, IoError> {
    let context = &Context::new("DICOM", path).following(options);
    let (series, draft) = SeriesSlices::choose(path, options, context)?;
    let element = series.slice(0)?.element_type();
    stack::open(series, element, (draft, context))
}

impl SeriesSlices {
    /// The slices to read, and the volume that they make.
    fn choose(path: &Path, options: &ReadOptions, context: &Context<'_>) -> Result<(Self, Draft), IoError> {
        let mut files = vec![path.to_owned()];
        if files::is_dir(path) {
            files = detect::files_of(path, context)?;
            files.retain(|file| is_dicom(file));
        }
        let images = heads(files, context)?;
        let stacks = stacks(&images);
        let (chosen, mut warnings) = choose(&stacks, &images, options, context)?;
        let series = match stacks.len() {
            1 => Vec::new(),
            _ => stacks.iter().map(|stack| stack.describe(&images)).collect(),
        };
        let slices = &stacks[chosen].slices;
        let heads: Vec<FrameHead> = slices.iter().map(|slice| slice.head).collect();
        let placed = arrange::stack(&heads, options, context)?;
        let first = &images[slices[0].image];
        let form = &first.form;
        let count = placed
            .uneven
            .as_ref()
            .map_or(placed.order.len(), |uneven| uneven.count);
        let sizes = [form.columns, form.rows, count].map(|size| size as i64);
        let mut draft = Draft::new(
            checked_dims(&sizes, "dims", None, context)?,
            Description::default(),
        );
        draft.world_from_voxel = ras_from_lps() * placed.patient_from_voxel;
        draft.unit = match first.frames[0].spacing {
            Some(_) => LengthUnit::Millimetre,
            None => LengthUnit::Unknown,
        };
        warnings.extend(placed.warnings);
        let (channels, channel) = channels(form, options, &mut warnings, context)?;
        warnings.extend(first.warnings());
        draft.description = Description {
            format: "DICOM".to_owned(),
            stored_type: format!(
                "{}{} ({} bits), {}",
                if form.signed { "i" } else { "u" },
                form.allocated,
                form.stored,
                first.syntax
            ),
            series,
            channels,
            warnings,
            ..Description::default()
        };
        let codes = axis_codes(&draft.grid(context)?);
        draft.description.oriented = placed.placed;
        draft.description.orientation = orientation(placed.placed, &codes, placed.tilt);
        draft.set_times(placed.times, options);
        let ordered = placed.order.iter().map(|&i| slices[i].clone()).collect();
        let series = Self::new(images, ordered, (channel, placed.uneven));
        series.describe(&mut draft);
        Ok((series, draft))
    }
}

/// Names of the channels of a coloured image, and the one to read; it is none of them for grey values.
fn channels(
    form: &Form,
    options: &ReadOptions,
    warnings: &mut Vec<String>,
    context: &Context<'_>,
) -> Result<(Vec<String>, usize), IoError> {
    if !form.colors.is_colored() {
        return Ok((Vec::new(), 0));
    }
    let names = component_names(3);
    let (channel, warning) = choose_channel(&names, options, context)?;
    warnings.extend(warning);
    Ok((names, channel))
}

fn orientation(placed: bool, codes: &str, tilt: f64) -> String {
    let tilted = match tilt {
        tilt if tilt > 0.1 => format!(", gantry tilt {tilt:.1} degrees"),
        _ => String::new(),
    };
    match placed {
        true => format!("patient space (LPS) to RAS+; voxel axes {codes}{tilted}"),
        false => "not in the files".to_owned(),
    }
}

fn heads(files: Vec<PathBuf>, folder: &Context<'_>) -> Result<Vec<ImageHead>, IoError> {
    let mut images = Vec::new();
    for path in files {
        let context = &Context::new("DICOM", &path);
        let head = |_: &_, elements: &Elements<'_, '_, '_>, syntax: &_| elements.image(&path, syntax);
        let (_, _, image) = Contents::open(&path, context, head)?;
        images.extend(image);
    }
    match images.is_empty() {
        true => Err(folder.unsupported("no image (element (7FE0,0010) is missing)")),
        false => Ok(images),
    }
}

/// Slices that may make a volume.
struct SliceStack {
    slices: Vec<Slice>,
}

impl SliceStack {
    fn series<'a>(&self, images: &'a [ImageHead]) -> &'a Series {
        &images[self.slices[0].image].series
    }

    fn takes(&self, slice: &Slice, images: &[ImageHead]) -> bool {
        let (first, image) = (&self.slices[0], &images[slice.image]);
        let own = &images[first.image];
        let near = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .all(|(a, b)| (a - b).abs() <= ALIKE * b.abs().max(1.0))
        };
        let turned = match (first.head.orientation, slice.head.orientation) {
            (Some(a), Some(b)) => a.iter().zip(&b).any(|(a, b)| a.distance(*b) > ALIKE),
            (None, None) => false,
            _ => true,
        };
        let scaled = match (first.head.spacing, slice.head.spacing) {
            (Some(a), Some(b)) => !near(&a, &b),
            (None, None) => false,
            _ => true,
        };
        own.series.uid == image.series.uid && own.form == image.form && !turned && !scaled
    }

    /// `2: head 5 mm, 512x512x28, UID`.
    fn describe(&self, images: &[ImageHead]) -> String {
        let Series {
            uid,
            number,
            description,
        } = self.series(images);
        let form = &images[self.slices[0].image].form;
        format!(
            "{number}: {description}, {} slices of {} x {}, {uid}",
            self.slices.len(),
            form.columns,
            form.rows
        )
    }
}

fn stacks(images: &[ImageHead]) -> Vec<SliceStack> {
    let mut stacks: Vec<SliceStack> = Vec::new();
    for (image, head) in images.iter().enumerate() {
        for (frame, &head) in head.frames.iter().enumerate() {
            let slice = Slice { image, frame, head };
            // Slices mostly belong to the same stack as the one before.
            match stacks.iter_mut().rev().find(|stack| stack.takes(&slice, images)) {
                Some(stack) => stack.slices.push(slice),
                None => stacks.push(SliceStack { slices: vec![slice] }),
            }
        }
    }
    stacks
}

/// The stack to read, and a warning about the others.
fn choose(
    stacks: &[SliceStack],
    images: &[ImageHead],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(usize, Vec<String>), IoError> {
    let list = |indices: &mut dyn Iterator<Item = usize>| {
        const SHOWN: usize = 10;
        let mut names: Vec<String> = indices
            .take(SHOWN + 1)
            .map(|i| stacks[i].describe(images))
            .collect();
        if names.len() > SHOWN {
            names[SHOWN] = "and others".to_owned();
        }
        names.join("; ")
    };
    let asked = |i: &usize| {
        let series = stacks[*i].series(images);
        options
            .series
            .as_ref()
            .is_none_or(|name| [&series.uid, &series.number, &series.description].contains(&name))
    };
    let candidates: Vec<usize> = (0..stacks.len()).filter(asked).collect();
    // The first of the largest.
    let chosen = candidates
        .iter()
        .copied()
        .rev()
        .max_by_key(|&i| stacks[i].slices.len());
    let Some(chosen) = chosen else {
        let name = options.series.as_deref().unwrap_or_default();
        let all = list(&mut (0..stacks.len()));
        return Err(context.unsupported(format!("series \"{name}\" was asked for; to choose from: {all}")));
    };
    let mut warnings = Vec::new();
    if candidates.len() > 1 {
        let others = list(&mut candidates.into_iter().filter(|&i| i != chosen));
        let own = stacks[chosen].describe(images);
        warnings.push(format!(
            "the largest of several series is read ({own}); also there: {others}"
        ));
    }
    Ok((chosen, warnings))
}
