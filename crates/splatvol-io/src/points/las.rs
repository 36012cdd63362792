//! LAS 1.0 to 1.4, LAZ and COPC (ASPRS LAS Specification 1.4 R15), by the crate `las`.
//!
//! A COPC file is a LAZ file whose order of points has a meaning of its own; all its points are read. The header's
//! claims are first checked against the file (`check`), because the crate trusts them. Colours have 16 bits by the
//! specification, of which many writers use 8; the largest colour shows which. Without colours, points are coloured
//! by their classes or heights (`shown_as`).

mod check;
mod fenced;
mod laszip;
mod shown_as;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ::las::{PointData, Reader};

use super::LoadedPoints;
use super::columns::{INTENSITY, RED, ROLES, X};
use super::gather::{ColorKind, Gather};
use crate::error::Context;
use crate::source::read_file;
use crate::{Description, IoError, ReadOptions};
use check::Claims;
use fenced::Fenced;

/// Points that are decoded at a time.
const BATCH: u64 = 1 << 16;

/// Reads a LAS, LAZ or COPC file.
///
/// # Errors
/// A header that contradicts itself or the size of the file, or points that cannot be decoded.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    let context = &Context::new("LAS", path);
    let bytes = read_file(path, context)?;
    let claims = Claims::read(&bytes, context)?;
    let mut present = [false; ROLES];
    present[X..X + 3].fill(true);
    present[RED..RED + 3].fill(claims.has_color());
    present[INTENSITY] = true;
    let mut gather = Gather::new(present, options);
    gather.check_count(claims.count, context)?;
    let description = describe(&claims, path);
    // The decoder is not written for hostile files; a panic in it is blamed on the file.
    let mut classes = Vec::new();
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        decode(bytes, claims.end, &mut gather, &mut classes)
    }));
    let count = match decoded {
        Ok(Ok(count)) => count,
        Ok(Err(error)) => return Err(context.field("points", error, None, "what the header describes")),
        Err(_) => return Err(context.field("points", "undecodable", None, "what the header describes")),
    };
    if count < claims.count {
        return Err(context.truncated("points", claims.count, count));
    }
    let loaded = gather.finish(ColorKind::Integer, description, context)?;
    if claims.has_color() {
        return Ok(loaded);
    }
    shown_as::colored(loaded, &classes, context)
}

/// Reads all points before `end`.
fn decode(bytes: Vec<u8>, end: u64, gather: &mut Gather, classes: &mut Vec<u8>) -> ::las::Result<u64> {
    let (file, fence) = Fenced::new(bytes);
    let mut reader = Reader::new(file)?;
    // A table of chunks that lies about their points leads the decoder beyond the last chunk.
    fence.set(end);
    let total = reader.header().number_of_points();
    let mut count = 0;
    while count < total {
        let points = reader.read_points(BATCH.min(total - count))?;
        if points.is_empty() {
            break;
        }
        count += points.len() as u64;
        push(&points, gather);
        classes.extend(points.classification());
    }
    Ok(count)
}

fn push(points: &PointData, gather: &mut Gather) {
    let mut colors = points.rgb();
    for (((x, y), z), intensity) in points.x().zip(points.y()).zip(points.z()).zip(points.intensity()) {
        let mut row = [f64::NAN; ROLES];
        row[X..X + 3].copy_from_slice(&[x, y, z]);
        row[INTENSITY] = f64::from(intensity);
        if let Some((red, green, blue)) = colors.as_mut().and_then(Iterator::next) {
            row[RED..RED + 3].copy_from_slice(&[red, green, blue].map(f64::from));
        }
        gather.push(&row);
    }
}

fn describe(claims: &Claims, path: &Path) -> Description {
    let compression = if claims.compressed { ", LAZ" } else { "" };
    Description {
        format: format!("LAS {}.{}{compression}", claims.version.0, claims.version.1),
        stored_type: format!("point format {}, little-endian", claims.format),
        orientation: "coordinates as in the file's projection".to_owned(),
        files: vec![path.to_owned()],
        ..Description::default()
    }
}
