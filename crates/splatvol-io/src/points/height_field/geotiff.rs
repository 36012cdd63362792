//! `GeoTIFF` (OGC 19-008r4): one band of heights, and the tags that place it.
//!
//! Places come from `ModelPixelScale` and `ModelTiepoint`; rotated or sheared maps (`ModelTransformation`) are refused.
//! A raster in degrees becomes a plane that is true to scale at its middle latitude.

use std::io::Cursor;
use std::path::Path;

use glam::DVec2;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::{HeightField, RowOrder};
use crate::error::Context;
use crate::source::read_file;
use crate::{Description, IoError};

/// Metres per degree of latitude.
const DEGREE: f64 = 111_320.0;
/// No compression of TIFF packs more bytes into one.
const RATIO: u64 = 1100;
/// Keys: kind of coordinates, whether a pixel is an area or a point.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;

/// Whether a TIFF is georeferenced and has one band: heights, not a photograph.
pub(super) fn is_geotiff(path: &Path) -> bool {
    let Ok(file) = std::fs::File::open(path) else {
        return false;
    };
    let Ok(mut decoder) = Decoder::new(std::io::BufReader::new(file)) else {
        return false;
    };
    let placed = matches!(decoder.find_tag(Tag::ModelPixelScaleTag), Ok(Some(_)))
        || matches!(decoder.find_tag(Tag::ModelTransformationTag), Ok(Some(_)));
    placed && matches!(decoder.colortype(), Ok(ColorType::Gray(_)))
}

pub(super) fn read(path: &Path) -> Result<(HeightField, Description), IoError> {
    let context = &Context::new("TIFF", path);
    let bytes = read_file(path, context)?;
    let length = bytes.len() as u64;
    let malformed = |error: tiff::TiffError| context.field("contents", error, None, "a valid TIFF");
    let mut decoder = Decoder::new(Cursor::new(&bytes)).map_err(malformed)?;
    let (width, height) = decoder.dimensions().map_err(malformed)?;
    let color = decoder.colortype().map_err(malformed)?;
    let ColorType::Gray(bits) = color else {
        return Err(context.unsupported(format!("samples of type {color:?}; heights are one band")));
    };
    let count = u64::from(width).saturating_mul(u64::from(height));
    let needed = count.saturating_mul(u64::from(bits).div_ceil(8));
    let at_most = length.saturating_mul(RATIO);
    if needed > at_most {
        return Err(context.too_small("heights", needed, at_most));
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = usize::try_from(needed).unwrap_or(usize::MAX).saturating_add(1024);
    limits.intermediate_buffer_size = limits.decoding_buffer_size.max(1 << 20);
    let mut decoder = decoder.with_limits(limits);
    let numbers = |decoder: &mut Decoder<_>, tag| decoder.get_tag_f64_vec(tag).unwrap_or_default();
    let scale = numbers(&mut decoder, Tag::ModelPixelScaleTag);
    let tie = numbers(&mut decoder, Tag::ModelTiepointTag);
    let transformation = numbers(&mut decoder, Tag::ModelTransformationTag);
    let keys = decoder
        .get_tag_u16_vec(Tag::GeoKeyDirectoryTag)
        .unwrap_or_default();
    let missing = decoder.get_tag_ascii_string(Tag::GdalNodata).unwrap_or_default();
    let missing: Option<f64> = missing.trim().trim_end_matches('\0').parse().ok();
    if scale.is_empty() && !transformation.is_empty() {
        return Err(context
            .unsupported("a map placed by ModelTransformation; only pixel scale and tie point are read"));
    }
    let mut heights = widen(decoder.read_image().map_err(malformed)?);
    if heights.len() as u64 != count {
        return Err(context.field(
            "heights",
            heights.len(),
            None,
            format!("{count}, width times height"),
        ));
    }
    for height in heights.iter_mut().filter(|height| missing == Some(**height)) {
        *height = f64::NAN;
    }
    let mut field = HeightField {
        dims: [width as usize, height as usize],
        heights,
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
        height_scale: 1.0,
        measured: false,
    };
    field.south_first(RowOrder::NorthFirst);
    let orientation = place(&mut field, &scale, &tie, &keys, context)?;
    let description = Description {
        format: if field.measured { "GeoTIFF" } else { "TIFF" }.to_owned(),
        stored_type: format!("{bits} bits"),
        orientation,
        files: vec![path.to_owned()],
        ..Description::default()
    };
    Ok((field, description))
}

/// Places the posts; returns a description of the placement.
fn place(
    field: &mut HeightField,
    scale: &[f64],
    tie: &[f64],
    keys: &[u16],
    context: &Context<'_>,
) -> Result<String, IoError> {
    let (&[dx, dy, ..], &[i, j, _, x, y, ..]) = (scale, tie) else {
        return Ok("no geometry in the file, spacing 1".to_owned());
    };
    let spacing = DVec2::new(dx, dy);
    let corner = DVec2::new(x - i * dx, y + j * dy);
    if !(spacing.is_finite() && spacing.min_element() > 0.0 && corner.is_finite()) {
        return Err(context.field("ModelPixelScale", spacing, None, "finite and above zero"));
    }
    // Key, where its value is, how many, the value; the first four are the directory's own header.
    let key = |id: u16| {
        keys.chunks_exact(4)
            .skip(1)
            .find(|key| key[0] == id && key[1] == 0)
            .map(|key| key[3])
    };
    let inset = if key(RASTER_TYPE) == Some(2) { 0.0 } else { 0.5 };
    let rows = field.dims[1] as f64;
    field.origin = corner + DVec2::new(inset * dx, -(rows - 1.0 + inset) * dy);
    field.spacing = spacing;
    field.measured = true;
    if key(MODEL_TYPE) != Some(2) {
        return Ok("x east, y north, in the map's unit".to_owned());
    }
    let middle = field.origin.y + rows / 2.0 * dy;
    let degrees = DVec2::new(middle.to_radians().cos().max(1e-3) * DEGREE, DEGREE);
    field.origin *= degrees;
    field.spacing *= degrees;
    Ok("x east, y north, metres (from degrees, true to scale at the middle latitude)".to_owned())
}

fn widen(samples: DecodingResult) -> Vec<f64> {
    fn all<T: Into<f64> + Copy>(samples: &[T]) -> Vec<f64> {
        samples.iter().map(|&sample| sample.into()).collect()
    }
    match samples {
        DecodingResult::U8(s) => all(&s),
        DecodingResult::U16(s) => all(&s),
        DecodingResult::U32(s) => all(&s),
        DecodingResult::I8(s) => all(&s),
        DecodingResult::I16(s) => all(&s),
        DecodingResult::I32(s) => all(&s),
        DecodingResult::F32(s) => all(&s),
        DecodingResult::F64(s) => s,
        DecodingResult::F16(s) => s.iter().map(|h| h.to_f64()).collect(),
        DecodingResult::U64(s) => s.iter().map(|&h| h as f64).collect(),
        DecodingResult::I64(s) => s.iter().map(|&h| h as f64).collect(),
    }
}
