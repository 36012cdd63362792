//! VTK XML image data (.vti), after VTK's `vtkXMLImageDataReader` and "VTK XML file formats".
//!
//! All codings are read: ascii, inline base64, appended base64 and appended raw, header words of 32 and 64 bits,
//! both byte orders, plain, zlib and LZ4. Other compressors, and images in several pieces, are refused.

mod base64_text;
pub(crate) mod document;
pub(crate) mod payload;
#[cfg(not(target_family = "wasm"))]
mod skeleton;
#[cfg(not(target_family = "wasm"))]
mod unpack;

use std::path::Path;

use super::flat::{Flat, Tuple};
use super::vtk_array::Component;
use super::{Description, Draft, Loaded, Opened, ReadOptions, read_whole, sample_count, vtk_array};
use crate::error::Context;
use crate::files::{File, read_at};
use crate::samples::Endian;
use crate::source::{START, Source, start_of_file};
use crate::{IoError, SampleType};
use document::{Coding, Compressor, ImageFile, Place};
#[cfg(not(target_family = "wasm"))]
use unpack::unpacked;

/// Reads a .vti file.
///
/// # Errors
/// Malformed XML, a data set other than one image in one piece, or geometry that is not a regular grid. An array
/// that is absent or not scalar (see [`ReadOptions::array`]), or data that do not fit their declaration.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("VTI", path);
    let (bytes, options) = &read_whole(path, options, context)?;
    let parts = document::split(bytes, context)?;
    let document = document::parse(&parts, context)?;
    let file = ImageFile::from_xml(&document, context)?;
    let chosen = Chosen::new(&file, options, context)?;
    let mut draft = chosen.draft;
    let count = sample_count(
        draft.dims,
        chosen.components,
        chosen.sample_type,
        options,
        context,
    )?;
    let (samples, warning) = payload::samples(
        &chosen.place,
        (chosen.sample_type, count),
        file.coding,
        parts.appended,
        context,
    )?;
    draft.description.warnings.extend(warning);
    draft.finish(
        vtk_array::pick(samples, chosen.components, chosen.component),
        context,
    )
}

/// Opens a file whose samples lie in it as they are, or may be unpacked; `None` for all others.
///
/// # Errors
/// Files that cannot be read; those that are unpacked, as [`read`].
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    let context = &Context::new("VTI", path);
    let bytes = start_of_file(path, START, context)?;
    match located(&bytes, options, context) {
        Some((flat, draft)) => flat.open(draft, context).map(Some),
        None => unpacked(options, context),
    }
}

/// Nothing is unpacked where there are no files.
#[cfg(target_family = "wasm")]
fn unpacked(_: &ReadOptions, _: &Context<'_>) -> Result<Option<Opened>, IoError> {
    Ok(None)
}

/// The samples of an array that is appended as it is, given the file's first bytes.
fn located(bytes: &[u8], options: &ReadOptions, context: &Context<'_>) -> Option<(Flat, Draft)> {
    let parts = document::split(bytes, context).ok()?;
    let document = document::parse(&parts, context).ok()?;
    let file = ImageFile::from_xml(&document, context).ok()?;
    let chosen = Chosen::new(&file, options, context).ok()?;
    let Place::Appended { offset, .. } = chosen.place else {
        return None;
    };
    let coding = file.coding;
    if coding.appended_base64 || coding.compressor.is_some() {
        return None;
    }
    let start = (bytes.len() - parts.appended?.len()) as u64;
    let position = start.checked_add(offset)?;
    let mut word = vec![0; coding.header_word];
    read_at(&File::open(context.path).ok()?, &mut word, position).ok()?;
    let samples = chosen.draft.grid(context).ok()?.sample_count();
    let count = samples.checked_mul(chosen.components)?;
    let flat = Flat {
        path: context.path.to_owned(),
        position: position.checked_add(coding.header_word as u64)?,
        sample_type: chosen.sample_type,
        half: false,
        tuple: chosen.tuple(),
        endian: coding.endian,
    };
    let declared = payload::number(&mut Source::from_bytes(&word), coding, context).ok()?;
    (declared == chosen.sample_type.byte_count(count)).then_some((flat, chosen.draft))
}

/// The array to read, and the volume that it makes.
struct Chosen<'a> {
    place: Place<'a>,
    sample_type: SampleType,
    components: usize,
    component: Component,
    draft: Draft,
}

impl<'a> Chosen<'a> {
    fn tuple(&self) -> Tuple {
        Tuple {
            components: self.components,
            component: self.component,
        }
    }

    fn new(file: &ImageFile<'a>, options: &ReadOptions, context: &Context<'_>) -> Result<Self, IoError> {
        let (index, component) = vtk_array::choose(&file.arrays.heads, options, context)?;
        let head = &file.arrays.heads[index];
        let sample_type = head
            .sample_type
            .ok_or_else(|| context.unsupported("an array without a type"))?;
        let place = file.arrays.place(index, context)?;
        let description = Description {
            format: "VTI".to_owned(),
            stored_type: format!("{}{}", sample_type.name(), describe(&place, file.coding)),
            files: vec![context.path.to_owned()],
            ..Description::default()
        };
        Ok(Self {
            place,
            sample_type,
            components: head.components,
            component,
            draft: file.geometry.draft(head.association, description, context)?,
        })
    }
}

pub(crate) fn describe(place: &Place<'_>, coding: Coding) -> String {
    let place = match place {
        Place::Ascii(_) => return ", ascii".to_owned(),
        Place::Base64(_) => "inline base64",
        Place::Appended { .. } if coding.appended_base64 => "appended base64",
        Place::Appended { .. } => "appended raw",
    };
    let endian = match coding.endian {
        Endian::Little => "little-endian",
        Endian::Big => "big-endian",
    };
    let compressor = match coding.compressor {
        None => "",
        Some(Compressor::Zlib) => ", zlib",
        Some(Compressor::Lz4) => ", LZ4",
    };
    format!(", {endian}, {place}{compressor}")
}
