//! Headerless raw samples (.raw, .raw.gz), x fastest.
//!
//! The layout comes from the caller, or from a name such as `tooth_103x94x161_uint8.raw` (the convention of the open
//! scientific visualization data sets: name, dims, type; little-endian).

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::Grid;

use super::flat::{Flat, Tuple};
use super::{Description, Draft, Loaded, Opened, RawLayout, ReadOptions, checked_dims, detect, sample_count};
use crate::error::Context;
use crate::samples::SampleBuffer;
use crate::source::{Codec, Rest, Source};
use crate::{Endian, IoError, SampleType};

/// Reads a file without a header.
///
/// # Errors
/// No layout given or in the file's name, dims that are not a grid, or a file whose size does not match the
/// layout; the message then says which layouts would fit.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("raw", path);
    let (layout, mut draft) = layout(path, options, context)?;
    let count = sample_count(draft.dims, 1, layout.sample_type, options, context)?;
    let mut source = Source::open(path)?;
    if is_gzip(path) {
        source = source.inflate(Codec::Gzip);
        draft.description.stored_type.push_str(", gzip");
    } else {
        check_size(source.at_most(), &layout, context)?;
    }
    source.skip(layout.offset, context)?;
    let mut buffer = SampleBuffer::new(layout.sample_type, layout.endian);
    buffer.read(&mut source, count, context)?;
    if source.rest(context)? == Rest::Excess {
        let expected = format!("{} bytes, for {}", wanted_size(&layout), describe(&layout));
        return Err(context.field("decompressed size", "more", None, expected));
    }
    let (samples, warning) = buffer.finish();
    draft.description.warnings.extend(warning);
    draft.finish(samples, context)
}

/// Opens a file that is not compressed.
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    let context = &Context::new("raw", path);
    if is_gzip(path) {
        return Ok(None);
    }
    let (layout, draft) = layout(path, options, context)?;
    check_size(Source::open(path)?.at_most(), &layout, context)?;
    let flat = Flat {
        path: path.to_owned(),
        position: layout.offset,
        sample_type: layout.sample_type,
        half: false,
        tuple: Tuple::ONE,
        endian: layout.endian,
    };
    flat.open(draft, context).map(Some)
}

fn is_gzip(path: &Path) -> bool {
    detect::extension(path).ends_with("gz")
}

/// The layout that is given, or in the file's name, and the volume that it describes.
fn layout(path: &Path, options: &ReadOptions, context: &Context<'_>) -> Result<(RawLayout, Draft), IoError> {
    let given = options.raw.clone().map(|layout| (layout, None));
    let (layout, warning) = match given {
        Some(given) => given,
        None => {
            let layout = layout_from_name(path).ok_or_else(|| {
                let expected = "its dims and type, as options or in the name (`NAME_256x256x128_uint8.raw`)";
                context.field("layout", "unknown", None, expected)
            })?;
            let warning = format!(
                "dims and type are taken from the file name: {}",
                describe(&layout)
            );
            (layout, Some(warning))
        }
    };
    let mut draft = draft(&layout, context)?;
    draft.description.warnings.extend(warning);
    Ok((layout, draft))
}

fn draft(layout: &RawLayout, context: &Context<'_>) -> Result<Draft, IoError> {
    let sizes = layout.dims.map(|size| i64::try_from(size).unwrap_or(i64::MAX));
    let dims = checked_dims(&sizes, "dims", None, context)?;
    let endian = match layout.endian {
        _ if layout.sample_type.size() == 1 => "",
        Endian::Little => ", little-endian",
        Endian::Big => ", big-endian",
    };
    let description = Description {
        format: "raw".to_owned(),
        stored_type: format!("{}{endian}", layout.sample_type.name()),
        orientation: "no geometry in the file; spacing as given".to_owned(),
        files: vec![context.path.to_owned()],
        ..Description::default()
    };
    let mut draft = Draft::new(dims, description);
    draft.world_from_voxel = DAffine3::from_mat3(DMat3::from_diagonal(layout.spacing));
    draft.grid(context)?;
    Ok(draft)
}

fn describe(layout: &RawLayout) -> String {
    let [nx, ny, nz] = layout.dims;
    format!("{nx}x{ny}x{nz} {}", layout.sample_type.name())
}

fn wanted_size(layout: &RawLayout) -> u64 {
    let bytes = |count: u64, size: usize| count.saturating_mul(size as u64);
    layout
        .dims
        .into_iter()
        .fold(layout.sample_type.size() as u64, bytes)
        .saturating_add(layout.offset)
}

fn check_size(found: u64, layout: &RawLayout, context: &Context<'_>) -> Result<(), IoError> {
    let wanted = wanted_size(layout);
    if found == wanted {
        return Ok(());
    }
    let skipped = match layout.offset {
        0 => String::new(),
        offset => format!(" after {offset} bytes"),
    };
    let fits = match fitting(found, layout) {
        fits if fits.is_empty() => String::new(),
        fits => format!(" (the file would fit {})", fits.join(" or ")),
    };
    let expected = format!("{wanted}, for {}{skipped}{fits}", describe(layout));
    Err(context.field("size in bytes", found, None, expected))
}

/// Layouts near to the given one that a file of `size` bytes would fit.
fn fitting(size: u64, layout: &RawLayout) -> Vec<String> {
    let mut fits = Vec::new();
    let mut add = |candidate: RawLayout| {
        let text = describe(&candidate);
        if wanted_size(&candidate) == size && !fits.contains(&text) {
            fits.push(text);
        }
    };
    let types = [SampleType::U8, SampleType::U16, SampleType::F32, SampleType::F64];
    for sample_type in types {
        add(RawLayout {
            sample_type,
            ..layout.clone()
        });
    }
    let [nx, ny, _] = layout.dims;
    let slice = (nx as u64).saturating_mul(ny as u64);
    for sample_type in [layout.sample_type].into_iter().chain(types) {
        let data = size.saturating_sub(layout.offset) / sample_type.size() as u64;
        let slices = data.checked_div(slice).unwrap_or(0);
        let side = (data as f64).cbrt().round() as u64;
        for dims in [[nx as u64, ny as u64, slices], [side; 3]] {
            if dims.iter().all(|size| (1..=Grid::MAX_DIM as u64).contains(size)) {
                add(RawLayout {
                    dims: dims.map(|size| size as usize),
                    sample_type,
                    ..layout.clone()
                });
            }
        }
    }
    let wanted = wanted_size(layout);
    if size > wanted {
        fits.push(format!(
            "{} after a header of {} bytes",
            describe(layout),
            size - wanted + layout.offset
        ));
    }
    fits
}

/// Dims, and after them the type, from the parts of the file name.
fn layout_from_name(path: &Path) -> Option<RawLayout> {
    let name = path.file_name()?.to_str()?.to_ascii_lowercase();
    let mut parts = name.split(['_', '-', '.', ' ']);
    let dims = parts.by_ref().find_map(dims_from_name)?;
    let sample_type = parts.find_map(SampleType::from_name)?;
    Some(RawLayout {
        dims,
        sample_type,
        spacing: DVec3::ONE,
        endian: Endian::Little,
        offset: 0,
    })
}

fn dims_from_name(part: &str) -> Option<[usize; 3]> {
    let numbers: Option<Vec<usize>> = part.split('x').map(|number| number.parse().ok()).collect();
    numbers?.try_into().ok()
}
