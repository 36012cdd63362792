//! NIfTI-1, NIfTI-2 and Analyze 7.5: `.nii`, `.nii.gz` and `.hdr`/`.img` pairs, in either byte order
//! (<https://nifti.nimh.nih.gov/nifti-1>, <https://nifti.nimh.nih.gov/nifti-2>).
//!
//! Real values are `scl_slope * stored + scl_inter` (a slope of 0 means none). One time point of a series is read;
//! colours, complex numbers and vectors are refused unless a component is chosen. Pairs of Analyze 7.5, which have no magic
//! number and no orientation, are read, too. Not read: 128-bit floats, bits.

mod affine;
mod header;

use std::path::{Path, PathBuf};

use splatvol_scene::{LengthUnit, Rescale};

use super::data_files::DataFiles;
use super::fields::Field;
use super::stored::{Encoding, FromStored, Layout, Selection, Stored};
use super::{Description, Draft, ReadOptions, axis_codes, checked_dims, choose_component, choose_time};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleType};
use crate::source::{Codec, Source};
use header::Header;

/// Reads a `.nii`, `.nii.gz`, `.hdr` or `.img` file; either name of a pair will do.
///
/// # Errors
/// See [`IoError`].
pub(super) fn read<T: FromStored>(path: &Path, options: &ReadOptions) -> Result<T, IoError> {
    let path = &header_path(path);
    let context = Context::new("NIfTI header", path);
    let mut source = Source::open(path)?;
    let compressed = source.peek(&context)?.starts_with(&[0x1f, 0x8b]);
    if compressed {
        source = source.inflate(Codec::Gzip);
    }
    let header = Header::read(&mut source, &context)?;
    let (sample_type, components) = datatype(&header, &context)?;
    let selection = select(&header, components, options, &context)?;
    let orientation = affine::orientation(&header, selection.dims, &context)?;
    let mut draft = Draft::new(selection.dims, Description::default());
    draft.world_from_voxel = orientation.world_from_voxel;
    draft.rescale = rescale(&header, components, &context)?;
    orientation
        .warnings
        .into_iter()
        .for_each(|warning| draft.warn(warning));
    set_unit(&header, &mut draft);
    if i64::from(header.bitpix) != (sample_type.size() * components * 8) as i64 {
        draft.warn(format!(
            "bitpix {} contradicts datatype {}",
            header.bitpix, header.datatype
        ));
    }
    draft.set_times(selection.times, options);
    let codes = axis_codes(&draft.grid(&context)?);
    let mut layout = layout(&header, sample_type, compressed);
    draft.description.format = match header.version {
        0 => "Analyze 7.5".to_owned(),
        version => format!("NIfTI-{version}"),
    };
    draft.description.stored_type = layout.describe();
    draft.description.oriented = orientation.oriented;
    draft.description.orientation = format!("{}; voxel axes {codes}; RAS+ as stored", orientation.source);
    draft.description.files = vec![path.clone()];
    if header.single {
        let skipped = skip_extensions(&mut source, &header, &context)?;
        skipped.into_iter().for_each(|warning| draft.warn(warning));
        // The source is decompressed and at the samples already.
        layout.encoding = Encoding::Raw;
        layout.skip_bytes = Some(0);
    }
    let data_file = data_file(path);
    let stored = Stored {
        layout,
        selection,
        files: match header.single {
            true => DataFiles::attached("data file"),
            false => DataFiles::named("data file", &data_file, &context)?,
        },
    };
    let context = Context::new("NIfTI data", path);
    T::from_stored(&stored, source, draft, (options, &context))
}

/// The header of a pair, given either name.
fn header_path(path: &Path) -> PathBuf {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("img") => path.with_extension("hdr"),
        Some("IMG") => path.with_extension("HDR"),
        _ => path.to_owned(),
    }
}

/// The name of the other half of a pair, as a field of its header.
fn data_file(header: &Path) -> Field {
    let name = header.file_name().unwrap_or_default().to_string_lossy();
    let value = match name.rsplit_once(".hdr") {
        Some((stem, rest)) => format!("{stem}.img{rest}"),
        None => match name.rsplit_once(".HDR") {
            Some((stem, rest)) => format!("{stem}.IMG{rest}"),
            None => format!("{name}.img"),
        },
    };
    Field {
        name: "data file".to_owned(),
        value,
        offset: 0,
    }
}

fn layout(header: &Header, sample_type: SampleType, compressed: bool) -> Layout {
    Layout {
        half: false,
        sample_type,
        endian: header.endian,
        encoding: if compressed { Encoding::Gzip } else { Encoding::Raw },
        skip_lines: 0,
        skip_bytes: Some(header.vox_offset),
        start: header.vox_offset,
    }
}

/// Sample type and interleaved components of a datatype code.
fn datatype(header: &Header, context: &Context<'_>) -> Result<(SampleType, usize), IoError> {
    Ok(match header.datatype {
        2 => (SampleType::U8, 1),
        4 => (SampleType::I16, 1),
        8 => (SampleType::I32, 1),
        16 => (SampleType::F32, 1),
        32 => (SampleType::F32, 2),
        64 => (SampleType::F64, 1),
        128 => (SampleType::U8, 3),
        256 => (SampleType::I8, 1),
        512 => (SampleType::U16, 1),
        768 => (SampleType::U32, 1),
        1024 => (SampleType::I64, 1),
        1280 => (SampleType::U64, 1),
        1792 => (SampleType::F64, 2),
        2304 => (SampleType::U8, 4),
        1 => return Err(context.unsupported("samples of one bit (datatype 1)")),
        1536 | 2048 => return Err(context.unsupported("128-bit floats (datatype 1536 or 2048)")),
        other => {
            let place = header.places.datatype as u64;
            return Err(context.field(
                "datatype",
                other,
                place,
                "a datatype code of NIfTI, such as 2, 4 or 16",
            ));
        }
    })
}

/// Axes 1 to 3 are space, 4 is time, 5 to 7 (slowest) are components.
fn select(
    header: &Header,
    interleaved: usize,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Selection, IoError> {
    let place = header.places.dim as u64;
    let axes = header.dim[0];
    if !(1..=7).contains(&axes) {
        return Err(context.field("dim[0]", axes, place, "1 to 7 axes"));
    }
    let sizes = &header.dim[1..=axes as usize];
    if let Some(index) = sizes.iter().position(|&size| size < 1) {
        return Err(context.field(
            format!("dim[{}]", index + 1),
            sizes[index],
            place,
            "a positive size",
        ));
    }
    let dims = checked_dims(&sizes[..sizes.len().min(3)], "dim", place, context)?;
    let count = |sizes: &[i64]| {
        let sizes = sizes.iter().map(|&size| usize::try_from(size).ok());
        sizes
            .into_iter()
            .try_fold(1usize, |product, size| product.checked_mul(size?))
    };
    let times = count(sizes.get(3..4).unwrap_or(&[]));
    let vector = count(sizes.get(4..).unwrap_or(&[]));
    let volumes = times
        .zip(vector)
        .and_then(|(times, vector)| times.checked_mul(vector));
    let (Some(times), Some(vector), Some(volumes)) = (times, vector, volumes) else {
        return Err(context.limit(u64::MAX, options.max_bytes));
    };
    let time = choose_time(times, options, context)?;
    let kind = match header.datatype {
        128 | 2304 => "colours",
        32 | 1792 => "complex numbers",
        _ => "vectors",
    };
    let component = choose_component(interleaved.saturating_mul(vector), kind, options, context)?;
    Ok(Selection {
        dims,
        components: interleaved,
        component: component % interleaved,
        volumes,
        times,
        volume: component / interleaved * times + time,
    })
}

fn rescale(header: &Header, components: usize, context: &Context<'_>) -> Result<Rescale, IoError> {
    let (slope, intercept) = (header.scl_slope, header.scl_inter);
    if slope == 0.0 || !slope.is_finite() || components > 1 {
        return Ok(Rescale::default());
    }
    if !intercept.is_finite() {
        let place = header.places.scl_inter as u64;
        return Err(context.field("scl_inter", intercept, place, "a finite number"));
    }
    Ok(Rescale { slope, intercept })
}

fn set_unit(header: &Header, draft: &mut Draft) {
    if !header.scl_slope.is_finite() {
        draft.warn(format!("scl_slope {} is not applied", header.scl_slope));
    }
    draft.unit = match header.xyzt_units & 7 {
        1 => LengthUnit::Metre,
        2 => LengthUnit::Millimetre,
        3 => LengthUnit::Micrometre,
        other => {
            if other != 0 {
                draft.warn(format!("xyzt_units {other} is not a length"));
            }
            LengthUnit::Unknown
        }
    };
}

/// Skips from the end of the header to the samples; a warning if the extension flag is wrong.
fn skip_extensions(
    source: &mut Source<'_>,
    header: &Header,
    context: &Context<'_>,
) -> Result<Option<String>, IoError> {
    let start = header.places.length as u64;
    let total = header.vox_offset - start;
    source.check_declared("header and extensions", total, context)?;
    let mut head = [0; 12];
    let wanted = head.len().min(total as usize);
    let found = source.fill(&mut head[..wanted], context)?;
    if found < wanted {
        return Err(context.truncated("header and extensions", total, found as u64));
    }
    source.skip(total - found as u64, context)?;
    if head[0] == 0 {
        return Ok(None);
    }
    let [_, _, _, _, a, b, c, d, ..] = head;
    let length = match header.endian {
        Endian::Little => u32::from_le_bytes([a, b, c, d]),
        Endian::Big => u32::from_be_bytes([a, b, c, d]),
    };
    let sound = found == head.len() && length >= 16 && u64::from(length) <= total - 4;
    Ok((!sound).then(|| "the header announces an extension that is not there".to_owned()))
}
