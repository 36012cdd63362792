//! USGS DEM (U.S. Geological Survey, Standards for Digital Elevation Models, part 2, 1998): blocks of 1024 characters.
//!
//! Record A gives the distances between posts and the unit of heights; each record B is a profile from south to north
//! with its own start and length, its numbers at fixed columns, six characters each. Profiles of a map sheet that is
//! not square to its grid begin and end at different rows: what lies beyond is a gap.

use std::path::Path;

use glam::DVec2;

use super::HeightField;
use crate::error::Context;
use crate::source::read_file;
use crate::{Description, IoError};

/// Characters of a block.
const BLOCK: usize = 1024;
/// Characters before the heights of a profile.
const PROFILE_HEADER: usize = 144;
/// Heights in the first block of a profile, and in others.
const FIRST: usize = 146;
const OTHERS: usize = 170;
/// The value of gaps.
const MISSING: i64 = -32_767;
/// Metres per degree of latitude.
const DEGREE: f64 = 111_320.0;
/// Metres per foot.
const FOOT: f64 = 0.3048;

/// Profile: column, place, heights from south to north.
struct Profile {
    start: DVec2,
    heights: Vec<f64>,
}

/// Starts of text files of other formats, whose numbers may stand in a DEM's columns by chance.
const OTHER_FORMATS: [&[u8]; 4] = [b"ply", b"# ", b"<?xml", b"NRRD"];

/// True where a file begins with a record A: a resolution and a number of profiles at their columns.
pub(super) fn is_dem(start: &[u8]) -> bool {
    if OTHER_FORMATS.iter().any(|other| start.starts_with(other)) {
        return false;
    }
    let number = |from: usize, to: usize| real(start.get(from..to)?);
    let positive = |value: Option<f64>| value.is_some_and(|value| value > 0.0);
    positive(number(816, 828))
        && positive(number(828, 840))
        && number(858, 864).is_some_and(|count| count >= 1.0)
}

/// A number at fixed columns; exponents may be written with `D`.
fn real(text: &[u8]) -> Option<f64> {
    let text = str::from_utf8(text).ok()?.trim().replace(['D', 'd'], "E");
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

struct Fields<'a> {
    bytes: &'a [u8],
    context: Context<'a>,
}

impl Fields<'_> {
    /// The number in `length` characters from `at`.
    fn number(&self, name: &str, at: usize, length: usize) -> Result<f64, IoError> {
        let text = self.bytes.get(at..at + length).ok_or_else(|| {
            self.context
                .truncated("records", (at + length) as u64, self.bytes.len() as u64)
        })?;
        real(text).ok_or_else(|| {
            self.context
                .field(name, String::from_utf8_lossy(text), at as u64, "a number")
        })
    }

    /// A whole number from 1 to `most`.
    fn count(&self, name: &str, at: usize, most: usize) -> Result<usize, IoError> {
        let number = self.number(name, at, 6)?;
        if number.fract() == 0.0 && number >= 1.0 && number <= most as f64 {
            return Ok(number as usize);
        }
        Err(self.context.field(
            name,
            number,
            at as u64,
            format!("a whole number from 1 to {most}"),
        ))
    }
}

pub(super) fn read(path: &Path) -> Result<(HeightField, Description), IoError> {
    let context = Context::new("USGS DEM", path);
    let bytes = read_file(path, &context)?;
    // Some writers end every block with a line break.
    let bytes: Vec<u8> = bytes
        .into_iter()
        .filter(|byte| !matches!(byte, b'\n' | b'\r'))
        .collect();
    let fields = Fields {
        bytes: &bytes,
        context,
    };
    let spacing = DVec2::new(
        fields.number("x resolution", 816, 12)?,
        fields.number("y resolution", 828, 12)?,
    );
    let step = fields.number("z resolution", 840, 12)?;
    let most = bytes.len() / BLOCK;
    let columns = fields.count("number of profiles", 858, most)?;
    if !(spacing.min_element() > 0.0 && step > 0.0) {
        return Err(context.field("resolution", format!("{spacing} {step}"), 816, "above zero"));
    }
    let geographic = fields.number("reference system", 156, 6)? == 0.0;
    let feet = fields.number("unit of height", 534, 6)? == 1.0;
    let mut profiles = Vec::with_capacity(columns);
    let mut at = BLOCK;
    for _ in 0..columns {
        let profile = read_profile(&fields, &mut at, step)?;
        profiles.push(profile);
    }
    let mut field = assemble(&profiles, spacing, &context)?;
    if feet {
        field.height_scale = FOOT;
    }
    let mut orientation = "x east, y north, metres".to_owned();
    if geographic {
        // Arc seconds: a plane that is true to scale in the middle.
        let second = DEGREE / 3600.0;
        let middle = field.origin.y + field.spacing.y * field.dims[1] as f64 / 2.0;
        let scale = DVec2::new((middle / 3600.0).to_radians().cos() * second, second);
        field.origin *= scale;
        field.spacing *= scale;
        orientation.push_str(" (from arc seconds, true to scale at the middle latitude)");
    }
    let name = String::from_utf8_lossy(&bytes[..40.min(bytes.len())])
        .trim()
        .to_owned();
    let description = Description {
        format: format!("USGS DEM \"{name}\""),
        stored_type: "text".to_owned(),
        orientation,
        files: vec![path.to_owned()],
        ..Description::default()
    };
    Ok((field, description))
}

fn read_profile(fields: &Fields<'_>, at: &mut usize, step: f64) -> Result<Profile, IoError> {
    let start = *at;
    let count = fields.count("posts of a profile", start + 12, fields.bytes.len() / 6)?;
    let place = DVec2::new(
        fields.number("x of a profile", start + 24, 24)?,
        fields.number("y of a profile", start + 48, 24)?,
    );
    let datum = fields.number("datum of a profile", start + 72, 24)?;
    let blocks = 1 + count.saturating_sub(FIRST).div_ceil(OTHERS);
    let needed = start + (blocks - 1) * BLOCK + PROFILE_HEADER;
    if needed > fields.bytes.len() {
        return Err(fields
            .context
            .truncated("profiles", needed as u64, fields.bytes.len() as u64));
    }
    let mut heights = Vec::with_capacity(count);
    for index in 0..count {
        let place = if index < FIRST {
            start + PROFILE_HEADER + 6 * index
        } else {
            let beyond = index - FIRST;
            start + BLOCK * (1 + beyond / OTHERS) + 6 * (beyond % OTHERS)
        };
        let stored = fields.number("height", place, 6)?;
        let missing = stored == MISSING as f64;
        heights.push(if missing { f64::NAN } else { datum + stored * step });
    }
    *at = start + blocks * BLOCK;
    Ok(Profile {
        start: place,
        heights,
    })
}

/// Profiles on one grid of posts.
fn assemble(profiles: &[Profile], spacing: DVec2, context: &Context<'_>) -> Result<HeightField, IoError> {
    let west = profiles.iter().map(|p| p.start.x).fold(f64::INFINITY, f64::min);
    let south = profiles.iter().map(|p| p.start.y).fold(f64::INFINITY, f64::min);
    let row = |p: &Profile| ((p.start.y - south) / spacing.y).round();
    let column = |p: &Profile| ((p.start.x - west) / spacing.x).round();
    let rows = profiles
        .iter()
        .map(|p| row(p) + p.heights.len() as f64)
        .fold(0.0, f64::max);
    let columns = profiles.iter().map(|p| column(p) + 1.0).fold(0.0, f64::max);
    // If profiles are scattered over a large grid, it would take memory that the file does not justify.
    let heights: usize = profiles.iter().map(|p| p.heights.len()).sum();
    if rows * columns > 64.0 * heights as f64 + 4096.0 {
        let expected = "profiles that begin near each other";
        return Err(context.field(
            "places of profiles",
            format!("{columns} x {rows}"),
            None,
            expected,
        ));
    }
    let dims = [columns as usize, rows as usize];
    let mut field = HeightField {
        dims,
        heights: vec![f64::NAN; dims[0] * dims[1]],
        origin: DVec2::new(west, south),
        spacing,
        height_scale: 1.0,
        measured: true,
    };
    for profile in profiles {
        let first = row(profile) as usize * dims[0] + column(profile) as usize;
        for (index, &height) in profile.heights.iter().enumerate() {
            field.heights[first + index * dims[0]] = height;
        }
    }
    Ok(field)
}
