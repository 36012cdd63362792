//! ImageJ's lookup tables: 256 colours, no values and no opacities.
//!
//! Four forms, as ImageJ's own loader tells them apart: an NIH Image header of 32 bytes that begins with `ICOL`, then
//! reds, greens and blues; 768 raw bytes in the same order (also the first 768 of 970); or text, one colour per line,
//! with or without its index before it. Fewer than 256 colours are spread over the whole range.
//! The colours are laid over the data's range, with a linear ramp of opacity.

use std::path::Path;

use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};

use super::Draft;
use crate::IoError;
use crate::error::Context;

/// Length of the NIH Image header, bytes.
const HEADER: usize = 32;

/// Longest file that ImageJ accepts as a lookup table, bytes.
const LONGEST: usize = 10_000;

/// Reads a lookup table from the bytes of a file; `path` is only named in errors. See
/// [`super::read_transfer_function`].
///
/// # Errors
/// [`IoError::Format`] names the malformed line or field.
pub fn decode(
    bytes: &[u8],
    value_range: [f64; 2],
    path: &Path,
) -> Result<(TransferFunction, Vec<String>), IoError> {
    let context = Context::new("ImageJ lookup table", path);
    let colors = if bytes.starts_with(b"ICOL") {
        let count = match bytes.get(6..8) {
            Some(&[high, low]) => usize::from(u16::from_be_bytes([high, low])),
            _ => return Err(context.truncated("header", HEADER as u64, bytes.len() as u64)),
        };
        if !(2..=256).contains(&count) {
            return Err(context.field("number of colors", count, 6, "2 to 256"));
        }
        planes(bytes.get(HEADER..).unwrap_or_default(), count, &context)?
    } else if matches!(bytes.len(), 768 | 970) {
        planes(bytes, 256, &context)?
    } else if bytes.len() > LONGEST {
        return Err(context.unsupported("longer than any lookup table"));
    } else {
        lines(bytes, &context)?
    };
    let [low, high] = value_range;
    let last = (colors.len() - 1) as f64;
    let value = |index: usize| low + (high - low) * index as f64 / last;
    let point =
        |(index, rgb): (usize, &[u8; 3])| ColorPoint::new(value(index), rgb.map(|c| f64::from(c) / 255.0));
    let draft = Draft {
        colors: colors.iter().enumerate().map(point).collect(),
        opacities: vec![OpacityPoint::new(low, 0.0), OpacityPoint::new(high, 1.0)],
        unit_distance: None,
        warnings: vec![format!(
            "lookup tables have no opacities: a linear ramp from {low} to {high}"
        )],
    };
    draft.finish(value_range, &context)
}

/// Colours from a plane each of reds, greens and blues.
fn planes(bytes: &[u8], count: usize, context: &Context<'_>) -> Result<Vec<[u8; 3]>, IoError> {
    let Some(planes) = bytes.get(..3 * count) else {
        return Err(context.truncated("colors", 3 * count as u64, bytes.len() as u64));
    };
    Ok((0..count)
        .map(|i| [planes[i], planes[count + i], planes[2 * count + i]])
        .collect())
}

/// Colours from lines of three or four numbers; a first line of words is a heading.
fn lines(bytes: &[u8], context: &Context<'_>) -> Result<Vec<[u8; 3]>, IoError> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| context.unsupported("neither 768 bytes, nor an ICOL header, nor text"))?;
    let mut colors = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let fields: Vec<&str> = line
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|field| !field.is_empty())
            .collect();
        let heading = index == 0
            && fields
                .iter()
                .any(|field| field.starts_with(|c: char| c.is_ascii_alphabetic()));
        if fields.is_empty() || heading {
            continue;
        }
        // ImageJ reads real numbers and cuts them to bytes.
        let bytes: Option<Vec<u8>> = fields
            .iter()
            .map(|field| {
                field
                    .parse::<f64>()
                    .ok()
                    .filter(|v| (0.0..256.0).contains(v))
                    .map(|v| v as u8)
            })
            .collect();
        match bytes.as_deref() {
            Some(&[r, g, b] | &[_, r, g, b]) => colors.push([r, g, b]),
            _ => {
                return Err(context.field(
                    format!("line {}", index + 1),
                    line,
                    None,
                    "three or four numbers from 0 to 255",
                ));
            }
        }
    }
    if (2..=256).contains(&colors.len()) {
        Ok(colors)
    } else {
        Err(context.field("lines", colors.len(), None, "2 to 256 colors"))
    }
}
