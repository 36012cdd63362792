//! Arrays of Python's numpy (.npy, versions 1 to 3) and archives of them (.npz).
//!
//! A C-ordered array has axes (z, y, x), x contiguous, as everywhere in scientific Python. An array in Fortran order
//! has its first axis contiguous, and that axis is x: (x, y, z), as in NIfTI libraries. Either way the samples stay in
//! the order of the file. There is no geometry in these files: spacing 1, voxel 0 at the world's origin.

mod archive;
mod header;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use half::f16;
use splatvol_scene::{Rescale, Samples, Volume};

use super::data_files::DataFiles;
use super::flat::{Flat, Tuple};
use super::nrrd::real_values;
use super::stored::{EXCESS, Encoding, Layout, Selection, Stored};
use super::{Description, Draft, Loaded, Opened, ReadOptions, checked_dims, sample_count};
use crate::error::Context;
use crate::samples::{SampleBuffer, for_each_little_endian_chunk};
use crate::source::{Rest, Source};
use crate::{Endian, IoError};
use header::{ElementType, Header};

pub(super) use archive::open as open_npz;
pub use archive::read as read_npz;

/// Reads a .npy file.
///
/// # Errors
/// A malformed header, elements that are not real numbers (objects are never unpickled), no or more than three axes,
/// or too few data.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("NPY", path);
    let mut source = Source::open(path)?;
    let header = Header::read(&mut source, context)?;
    samples(source, &header, npy_format(&header), options, context)
}

/// Opens a .npy file.
pub(super) fn open(path: &Path) -> Result<Option<Opened>, IoError> {
    let context = &Context::new("NPY", path);
    let mut source = Source::open(path)?;
    let header = Header::read(&mut source, context)?;
    let mut draft = draft(&header, npy_format(&header), context)?;
    let Some(position) = source.position() else {
        return Ok(None);
    };
    let flat = Flat {
        path: path.to_owned(),
        position,
        sample_type: header.element.stored(),
        half: header.element == ElementType::Half,
        tuple: Tuple::ONE,
        endian: header.endian,
    };
    let samples = draft.dims.iter().product();
    if source.at_most() > flat.sample_type.byte_count(samples) {
        draft.warn(EXCESS);
    }
    flat.open(draft, context).map(Some)
}

fn npy_format(header: &Header) -> String {
    format!("NPY {}.{}", header.version[0], header.version[1])
}

/// The volume after a header in an archive, unpacked.
fn unpacked(
    source: Source<'_>,
    header: &Header,
    format: String,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Option<Opened>, IoError> {
    let draft = draft(header, format, context)?;
    let stored = Stored {
        layout: Layout {
            sample_type: header.element.stored(),
            half: header.element == ElementType::Half,
            endian: header.endian,
            encoding: Encoding::Raw,
            skip_lines: 0,
            skip_bytes: Some(0),
            start: 0,
        },
        selection: Selection {
            dims: draft.dims,
            components: 1,
            component: 0,
            volumes: 1,
            times: 1,
            volume: 0,
        },
        files: DataFiles::attached("data"),
    };
    stored.open(source, draft, (options, context))
}

/// The volume after a header.
fn samples(
    mut source: Source<'_>,
    header: &Header,
    format: String,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Loaded, IoError> {
    let mut draft = draft(header, format, context)?;
    let stored = header.element.stored();
    let count = sample_count(draft.dims, 1, stored, options, context)?;
    let mut buffer = SampleBuffer::new(stored, header.endian);
    buffer.read(&mut source, count, context)?;
    let (mut samples, warning) = buffer.finish();
    draft.description.warnings.extend(warning);
    if source.rest(context)? == Rest::Excess {
        draft.warn(EXCESS);
    }
    if let (ElementType::Half, Samples::U16(bits)) = (header.element, &samples) {
        samples = Samples::F32(bits.iter().map(|&bits| f16::from_bits(bits).to_f32()).collect());
    }
    draft.finish(samples, context)
}

fn draft(header: &Header, format: String, context: &Context<'_>) -> Result<Draft, IoError> {
    if !(1..=3).contains(&header.shape.len()) {
        let shape = header.shape_text();
        return Err(context.unsupported(format!("an array of shape {shape}; 1 to 3 axes are read")));
    }
    let mut sizes: Vec<i64> = header
        .shape
        .iter()
        .map(|&size| i64::try_from(size).unwrap_or(i64::MAX))
        .collect();
    if !header.fortran_order {
        sizes.reverse();
    }
    let dims = checked_dims(&sizes, "shape", None, context)?;
    let endian = match header.endian {
        _ if header.element.stored().size() == 1 => "",
        Endian::Little => ", little-endian",
        Endian::Big => ", big-endian",
    };
    let axes = if header.fortran_order {
        "Fortran order: axes are (x, y, z)"
    } else {
        "C order: axes are (z, y, x)"
    };
    let description = Description {
        format,
        stored_type: format!("{}{endian}", header.element.name()),
        orientation: format!("{axes}; no geometry in the file, spacing 1"),
        files: vec![context.path.to_owned()],
        ..Description::default()
    };
    Ok(Draft::new(dims, description))
}

/// Writes the samples as a C-ordered array (z, y, x) in their own type; rescaled samples as real values, `f32` for
/// stored types of up to 16 bits and `f64` for others. The format has no place for the geometry.
///
/// # Errors
/// [`IoError::Write`].
pub fn write(path: &Path, volume: &Volume) -> Result<(), IoError> {
    write_to(path, volume).map_err(|source| IoError::Write {
        source,
        path: path.to_owned(),
    })
}

fn write_to(path: &Path, volume: &Volume) -> std::io::Result<()> {
    let real = (volume.rescale() != Rescale::default()).then(|| real_values(volume));
    let samples = real.as_ref().unwrap_or(volume.samples());
    let descr = match samples {
        Samples::U8(_) => "|u1",
        Samples::I8(_) => "|i1",
        Samples::U16(_) => "<u2",
        Samples::I16(_) => "<i2",
        Samples::U32(_) => "<u4",
        Samples::I32(_) => "<i4",
        Samples::F32(_) => "<f4",
        Samples::F64(_) => "<f8",
    };
    let [nx, ny, nz] = volume.grid().dims();
    let dictionary = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({nz}, {ny}, {nx}), }}");
    // Version 1.0: magic, version, a 16-bit length, and blanks up to a multiple of 64 bytes, the last a line end.
    let length = (10 + dictionary.len() + 1).next_multiple_of(64) - 10;
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(b"\x93NUMPY\x01\x00")?;
    file.write_all(&(length as u16).to_le_bytes())?;
    writeln!(file, "{dictionary:<width$}", width = length - 1)?;
    for_each_little_endian_chunk(samples, |bytes| file.write_all(bytes))?;
    file.flush()
}
