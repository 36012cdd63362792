//! Legacy VTK files (.vtk) of structured points, after "VTK file formats" (versions 1.0 to 5.1).
//!
//! Binary data are big-endian. Scalars and the arrays of fields are read; other attributes are skipped.

pub(crate) mod attributes;
pub(crate) mod cursor;

use std::path::Path;

use glam::{DMat3, DVec3};
use splatvol_scene::Samples;

use super::flat::{Flat, Tuple};
#[cfg(not(target_family = "wasm"))]
use super::unpack::{Numbers, unpack_text};
use super::vtk_array::{self, Association, ImageGeometry};
use super::{Description, Draft, Loaded, Opened, ReadOptions, read_whole, sample_count};
use crate::error::Context;
use crate::samples::{SampleBuffer, decode_text};
use crate::source::{START, Source, start_of_file};
use crate::{Endian, IoError, SampleType};
use attributes::{Array, Attributes, Coding, ElementType, Scan};
use cursor::Cursor;

const MAGIC: &str = "# vtk DataFile Version";
/// Eight times what is searched at least, bytes.
const MOST_SEARCHED: u64 = 64 << 20;
/// Warning about text.
const CUT: &str = "the file ends right after the last number, which may be cut short";

/// Reads a .vtk file.
///
/// # Errors
/// A malformed header, a data set other than structured points, geometry that is not a regular grid, an array that
/// is absent or not scalar (see [`ReadOptions::array`]), or too few data.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("legacy VTK", path);
    let (bytes, options) = &read_whole(path, options, context)?;
    let mut cursor = Cursor::new(bytes, context);
    let (version, coding) = header(&mut cursor)?;
    let geometry = geometry(&mut cursor, coding)?;
    let wanted = options.array.as_deref();
    let mut scan = Scan {
        cursor,
        coding,
        counts: geometry.counts(),
        wanted,
        stops_early: true,
        found: Attributes::default(),
    };
    let end = scan.run();
    let mut warnings = Vec::new();
    let Attributes { heads, arrays } = scan.found;
    let choice = vtk_array::choose(&heads, options, context);
    // Cells do not replace points that cannot be read, unless they were requested.
    let doubtful = |index: usize| wanted.is_none() && heads[index].association == Association::Cell;
    let (index, component) = match (choice, end) {
        (Err(_), Err(end)) => return Err(end),
        (Ok((index, _)), Err(end)) if doubtful(index) => return Err(end),
        (choice, Err(end)) => {
            warnings.push(format!("only the first arrays could be found: {end}"));
            choice?
        }
        (choice, Ok(())) => choice?,
    };
    let (head, array) = (&heads[index], &arrays[index]);
    let sample_type = head
        .sample_type
        .ok_or_else(|| context.unsupported("an array without a type"))?;
    let description = Description {
        warnings,
        ..described(&version, sample_type, coding, context)
    };
    let mut draft = geometry.draft(head.association, description, context)?;
    let count = sample_count(draft.dims, head.components, sample_type, options, context)?;
    let (samples, warning) = decode(array, bytes, (sample_type, count), coding, context)?;
    draft.description.warnings.extend(warning);
    draft.finish(vtk_array::pick(samples, head.components, component), context)
}

/// Opens a binary file, or text that may be unpacked; `None` for arrays that lie behind others, which take more than an eighth of
/// the memory, and where the header is wrong, which [`read`] says.
///
/// # Errors
/// Files that cannot be read.
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    let context = &Context::new("legacy VTK", path);
    let Some((array, draft)) = search(path, options, context)? else {
        return Ok(None);
    };
    match array.coding {
        Coding::Ascii => unpacked(array, options, (draft, context)),
        Coding::Binary => {
            let flat = Flat {
                path: path.to_owned(),
                position: array.start,
                sample_type: array.sample_type,
                half: false,
                tuple: array.tuple,
                endian: Endian::Big,
            };
            flat.open(draft, context).map(Some)
        }
    }
}

/// The numbers of a text, unpacked beside the output of a conversion, if that is allowed.
#[cfg(not(target_family = "wasm"))]
fn unpacked(
    array: Located,
    options: &ReadOptions,
    (draft, context): (Draft, &Context<'_>),
) -> Result<Option<Opened>, IoError> {
    let Some(folder) = &options.unpack_in else {
        return Ok(None);
    };
    let mut source = Source::open(context.path)?;
    source.skip(array.start, context)?;
    let numbers = Numbers {
        sample_type: array.sample_type,
        tuple: array.tuple,
        start: array.start,
        may_be_followed: true,
        cut: Some(CUT),
    };
    unpack_text(source, numbers, folder, (draft, context)).map(Some)
}

/// Nothing is unpacked where there are no files.
#[cfg(target_family = "wasm")]
fn unpacked(_: Located, _: &ReadOptions, _: (Draft, &Context<'_>)) -> Result<Option<Opened>, IoError> {
    Ok(None)
}

/// Where an array's numbers are.
struct Located {
    start: u64,
    sample_type: SampleType,
    tuple: Tuple,
    coding: Coding,
}

/// The array that is read, searched in the file's first bytes; in more and more of them where it need not fit into memory.
fn search(
    path: &Path,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Option<(Located, Draft)>, IoError> {
    let mut length = START;
    loop {
        let bytes = start_of_file(path, length, context)?;
        let found = located(&bytes, options, context);
        let is_last = bytes.len() < length || options.unpack_in.is_none();
        length = length.saturating_mul(8);
        if found.is_some() || is_last || length as u64 > options.max_bytes.max(MOST_SEARCHED) / 8 {
            return Ok(found);
        }
    }
}

/// The array that is read, if it is the last of those that the file's first bytes have.
fn located(bytes: &[u8], options: &ReadOptions, context: &Context<'_>) -> Option<(Located, Draft)> {
    let mut cursor = Cursor::new(bytes, context);
    let (version, coding) = header(&mut cursor).ok()?;
    let geometry = geometry(&mut cursor, coding).ok()?;
    let mut scan = Scan {
        cursor,
        coding,
        counts: geometry.counts(),
        wanted: options.array.as_deref(),
        stops_early: true,
        found: Attributes::default(),
    };
    scan.run().ok()?;
    let Attributes { heads, arrays } = scan.found;
    let (index, component) = vtk_array::choose(&heads, options, context).ok()?;
    let (head, array) = (&heads[index], &arrays[index]);
    let ElementType::Number(sample_type) = array.element else {
        return None;
    };
    let draft = geometry
        .draft(
            head.association,
            described(&version, sample_type, coding, context),
            context,
        )
        .ok()?;
    let located = Located {
        start: array.start as u64,
        sample_type,
        tuple: Tuple {
            components: head.components,
            component,
        },
        coding,
    };
    Some((located, draft))
}

fn described(version: &str, sample_type: SampleType, coding: Coding, context: &Context<'_>) -> Description {
    let coding = match coding {
        Coding::Ascii => "ascii",
        Coding::Binary => "big-endian",
    };
    Description {
        format: format!("legacy VTK {version}"),
        stored_type: format!("{}, {coding}", sample_type.name()),
        files: vec![context.path.to_owned()],
        ..Description::default()
    }
}

/// Version and coding: the first three lines.
pub(crate) fn header(cursor: &mut Cursor<'_>) -> Result<(String, Coding), IoError> {
    let start = *cursor;
    let magic = cursor.line("magic")?;
    let version = magic
        .strip_prefix(MAGIC)
        .map(str::trim)
        .unwrap_or_default()
        .to_owned();
    let major = version
        .split('.')
        .next()
        .and_then(|major| major.parse::<u32>().ok());
    if !major.is_some_and(|major| (1..=5).contains(&major)) {
        return Err(start.error("magic", &magic, format!("`{MAGIC} 1.0` to `5.1`")));
    }
    cursor.line("title")?;
    cursor.skip_blanks();
    let start = *cursor;
    let coding = cursor.word().unwrap_or_default();
    match coding.to_ascii_uppercase().as_str() {
        "ASCII" => Ok((version, Coding::Ascii)),
        "BINARY" => Ok((version, Coding::Binary)),
        _ => Err(start.error("coding", &coding, "ASCII or BINARY")),
    }
}

/// Reads the geometry between the header and the attributes.
fn geometry(cursor: &mut Cursor<'_>, coding: Coding) -> Result<ImageGeometry, IoError> {
    let mut dims = None;
    let (mut origin, mut spacing, mut is_image) = ([0.0; 3], [1.0; 3], false);
    loop {
        cursor.skip_blanks();
        let start = *cursor;
        let Some(keyword) = cursor.word() else { break };
        match keyword.to_ascii_uppercase().as_str() {
            "DATASET" => {
                structured_points(cursor)?;
                is_image = true;
            }
            "DIMENSIONS" => dims = Some(cursor.numbers::<i64, 3>("DIMENSIONS")?),
            "ORIGIN" => origin = cursor.numbers("ORIGIN")?,
            "SPACING" | "ASPECT_RATIO" => spacing = cursor.numbers("SPACING")?,
            "METADATA" => cursor.skip_metadata()?,
            "FIELD" => {
                cursor.word();
                let count = cursor.number("FIELD")?;
                attributes::skip_field(cursor, coding, count)?;
            }
            "POINT_DATA" | "CELL_DATA" => {
                *cursor = start;
                break;
            }
            _ => return Err(start.error("keyword", &keyword, "DIMENSIONS, ORIGIN, SPACING or POINT_DATA")),
        }
    }
    let dims = dims
        .filter(|_| is_image)
        .ok_or_else(|| cursor.error("DIMENSIONS", "", "DATASET STRUCTURED_POINTS with DIMENSIONS"))?;
    if dims.iter().any(|&size| size < 1) {
        return Err(cursor.error("DIMENSIONS", &format!("{dims:?}"), "at least 1 along each axis"));
    }
    Ok(ImageGeometry {
        extent: dims.map(|size| [0, size - 1]),
        origin: DVec3::from_array(origin),
        spacing: DVec3::from_array(spacing),
        direction: DMat3::IDENTITY,
    })
}

fn structured_points(cursor: &mut Cursor<'_>) -> Result<(), IoError> {
    let kind = cursor.word().unwrap_or_default();
    if kind.eq_ignore_ascii_case("STRUCTURED_POINTS") {
        return Ok(());
    }
    let known = [
        "STRUCTURED_GRID",
        "UNSTRUCTURED_GRID",
        "POLYDATA",
        "RECTILINEAR_GRID",
        "FIELD",
        "TABLE",
        "DIRECTED_GRAPH",
    ];
    if known.iter().any(|known| kind.eq_ignore_ascii_case(known)) {
        let what = format!(
            "data set {kind}; only STRUCTURED_POINTS is a regular grid (`read_mesh` reads other grids)"
        );
        return Err(cursor.context().unsupported(what));
    }
    Err(cursor.error("DATASET", &kind, "STRUCTURED_POINTS"))
}

/// The byte that VTK makes of a part of 255; what lies outside is the nearest one.
fn byte(share: &f32) -> u8 {
    (share * 255.0 + 0.5) as u8
}

/// The numbers of an array, and a warning about them.
pub(crate) fn decode(
    array: &Array,
    bytes: &[u8],
    (sample_type, count): (SampleType, usize),
    coding: Coding,
    context: &Context<'_>,
) -> Result<(Samples, Option<String>), IoError> {
    let data = &bytes[array.start.min(bytes.len())..];
    match (coding, array.element) {
        (Coding::Ascii, element) => {
            let written = match element {
                ElementType::Share => SampleType::F32,
                _ => sample_type,
            };
            let (samples, warning, used) = decode_text(data, written, count, array.start as u64, context)?;
            let samples = match (element, samples) {
                (ElementType::Share, Samples::F32(shares)) => Samples::U8(shares.iter().map(byte).collect()),
                (_, samples) => samples,
            };
            let cut = (used == data.len()).then(|| CUT.to_owned());
            Ok((samples, warning.or(cut)))
        }
        (Coding::Binary, ElementType::Bit) => {
            let length = count.div_ceil(8);
            let packed = data
                .get(..length)
                .ok_or_else(|| context.truncated("bits", length as u64, data.len() as u64))?;
            let bit = |index: usize| packed[index / 8] >> (7 - index % 8) & 1;
            Ok((Samples::U8((0..count).map(bit).collect()), None))
        }
        (Coding::Binary, _) => {
            let mut buffer = SampleBuffer::new(sample_type, Endian::Big);
            buffer.read(&mut Source::from_bytes(data), count, context)?;
            Ok(buffer.finish())
        }
    }
}
