//! `GeoTIFF` (OGC 19-008r4): one band of heights, and the tags that place it.
//!
//! Places come from `ModelPixelScale` and `ModelTiepoint`; rotated or sheared maps (`ModelTransformation`) are refused.
//! A raster in degrees becomes a plane that is true to scale at its middle latitude.

use std::path::Path;

use crate::tiff_pages::tag;
use glam::DVec2;
use splatvol_scene::with_samples;

use super::{HeightField, RowOrder};
use crate::error::Context;
use crate::tiff_pages::Pages;
use crate::{Description, IoError};

/// Metres per degree of latitude.
const DEGREE: f64 = 111_320.0;
/// Keys: kind of coordinates, whether a pixel is an area or a point.
const MODEL_TYPE: f64 = 1024.0;
const RASTER_TYPE: f64 = 1025.0;

/// Whether a TIFF is georeferenced and has one band: heights, not a photograph.
pub(super) fn is_geotiff(path: &Path) -> bool {
    let context = &Context::new("TIFF", path);
    let Ok(mut pages) = Pages::open(path, context) else {
        return false;
    };
    let placed = !pages.numbers(tag::MODEL_PIXEL_SCALE, context).is_empty()
        || !pages.numbers(tag::MODEL_TRANSFORMATION, context).is_empty();
    placed
        && pages
            .head(0, context)
            .is_ok_and(|head| head.components == 1 && !head.palette)
}

pub(super) fn read(path: &Path) -> Result<(HeightField, Description), IoError> {
    let context = &Context::new("TIFF", path);
    let mut pages = Pages::open(path, context)?;
    let head = pages.head(0, context)?;
    if head.components != 1 || head.palette {
        let bands = head.components;
        return Err(context.unsupported(format!("{bands} bands or a palette; heights are one band")));
    }
    let scale = pages.numbers(tag::MODEL_PIXEL_SCALE, context);
    let tie = pages.numbers(tag::MODEL_TIEPOINT, context);
    let transformation = pages.numbers(tag::MODEL_TRANSFORMATION, context);
    let keys = pages.numbers(tag::GEO_KEY_DIRECTORY, context);
    let missing = pages.text(tag::GDAL_NODATA, context).unwrap_or_default();
    let missing: Option<f64> = missing.trim().trim_end_matches('\0').parse().ok();
    if scale.is_empty() && !transformation.is_empty() {
        return Err(context
            .unsupported("a map placed by ModelTransformation; only pixel scale and tie point are read"));
    }
    let samples = pages.samples(&head, context)?;
    let mut heights: Vec<f64> = with_samples!(&samples, data => widen(data));
    for height in heights.iter_mut().filter(|height| missing == Some(**height)) {
        *height = f64::NAN;
    }
    let mut field = HeightField {
        dims: head.size,
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
        stored_type: head.stored_type(),
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
    keys: &[f64],
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
    let key = |id: f64| {
        keys.chunks_exact(4)
            .skip(1)
            .find(|key| key[0] == id && key[1] == 0.0)
            .map(|key| key[3])
    };
    let inset = if key(RASTER_TYPE) == Some(2.0) { 0.0 } else { 0.5 };
    let rows = field.dims[1] as f64;
    field.origin = corner + DVec2::new(inset * dx, -(rows - 1.0 + inset) * dy);
    field.spacing = spacing;
    field.measured = true;
    if key(MODEL_TYPE) != Some(2.0) {
        return Ok("x east, y north, in the map's unit".to_owned());
    }
    let middle = field.origin.y + rows / 2.0 * dy;
    let degrees = DVec2::new(middle.to_radians().cos().max(1e-3) * DEGREE, DEGREE);
    field.origin *= degrees;
    field.spacing *= degrees;
    Ok("x east, y north, metres (from degrees, true to scale at the middle latitude)".to_owned())
}

fn widen<T: Copy + Into<f64>>(heights: &[T]) -> Vec<f64> {
    heights.iter().map(|&height| height.into()).collect()
}
