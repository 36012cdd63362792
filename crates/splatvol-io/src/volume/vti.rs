//! VTK XML image data (.vti), after VTK's `vtkXMLImageDataReader` and "VTK XML file formats".
//!
//! All codings are read: ascii, inline base64, appended base64 and appended raw, header words of 32 and 64 bits,
//! both byte orders, plain, zlib and LZ4. Other compressors, and images in several pieces, are refused.

pub(crate) mod document;
pub(crate) mod payload;

use std::path::Path;

use super::{Description, Loaded, ReadOptions, sample_count, vtk_array};
use crate::IoError;
use crate::error::Context;
use crate::samples::Endian;
use crate::source::read_file;
use document::{Coding, Compressor, ImageFile, Place};

/// Reads a .vti file.
///
/// # Errors
/// Malformed XML, a data set other than one image in one piece, or geometry that is not a regular grid. An array
/// that is absent or not scalar (see [`ReadOptions::array`]), or data that do not fit their declaration.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("VTI", path);
    let bytes = read_file(path, context)?;
    let parts = document::split(&bytes, context)?;
    let document = document::parse(&parts, context)?;
    let file = ImageFile::from_xml(&document, context)?;
    let (index, component) = vtk_array::choose(&file.arrays.heads, options, context)?;
    let head = &file.arrays.heads[index];
    let sample_type = head
        .sample_type
        .ok_or_else(|| context.unsupported("an array without a type"))?;
    let place = file.arrays.place(index, context)?;
    let description = Description {
        format: "VTI".to_owned(),
        stored_type: format!("{}{}", sample_type.name(), describe(&place, file.coding)),
        files: vec![path.to_owned()],
        ..Description::default()
    };
    let mut draft = file.geometry.draft(head.association, description, context)?;
    let count = sample_count(draft.dims, head.components, sample_type, options, context)?;
    let (samples, warning) =
        payload::samples(&place, (sample_type, count), file.coding, parts.appended, context)?;
    draft.description.warnings.extend(warning);
    draft.finish(vtk_array::pick(samples, head.components, component), context)
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
