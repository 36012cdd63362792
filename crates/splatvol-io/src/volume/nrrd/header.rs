//! The text header: magic line, `field: value` lines, `key:=value` lines, comments, and the end of the
//! header.

use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleType};
use crate::source::Source;
use crate::volume::data_files::DataFiles;
use crate::volume::fields::{Field, Fields, HeaderLines, Line, normalised};
use crate::volume::stored::{Encoding, Layout};

/// Fields that this reader uses, and those that do not affect the picture.
const KNOWN: &[&str] = &[
    "dimension",
    "type",
    "sizes",
    "encoding",
    "endian",
    "spacings",
    "kinds",
    "units",
    "space",
    "spacedimension",
    "spaceunits",
    "spaceorigin",
    "spacedirections",
    "byteskip",
    "lineskip",
    "datafile",
    // Not used:
    "content",
    "number",
    "min",
    "max",
    "sampleunits",
    "blocksize",
    "labels",
    "thicknesses",
    "centers",
    "centerings",
    "measurementframe",
];

/// Largest number of axes that the format allows.
const MAX_AXES: usize = 16;

/// A parsed header.
pub(super) struct Header {
    pub(super) version: char,
    pub(super) fields: Fields,
    pub(super) sizes: Vec<usize>,
    /// Storage layout of the samples.
    pub(super) layout: Layout,
    /// Names that follow `data file: LIST`.
    pub(super) list: Vec<Line>,
    /// True where a blank line ended the header (attached data may follow).
    pub(super) terminated: bool,
    pub(super) warnings: Vec<String>,
}

impl Header {
    /// The data files.
    pub(super) fn files(&self, context: &Context<'_>) -> Result<DataFiles<'_>, IoError> {
        const FIELD: &str = "data file";
        match self.fields.get("datafile") {
            Some(field) if is_list(field) => Ok(DataFiles::list(FIELD, &self.list)),
            Some(field) => DataFiles::named(FIELD, field, context),
            None if self.terminated => Ok(DataFiles::attached(FIELD)),
            None => {
                let expected = "this field, or a blank line and the data";
                Err(context.field(FIELD, "", self.layout.start, expected))
            }
        }
    }

    /// Parses the header; `source` is left at the first byte after it.
    pub(super) fn read(source: &mut Source<'_>, context: &Context<'_>) -> Result<Self, IoError> {
        let mut lines = HeaderLines::new(source);
        let version = read_magic(&mut lines, context)?;
        let mut fields = Fields::default();
        let (mut list, mut terminated) = (Vec::new(), false);
        while let Some(line) = lines.next(context)? {
            if line.text.is_empty() {
                terminated = true;
                break;
            }
            let Some(field) = parse_line(&line, context)? else {
                continue;
            };
            let is_list = normalised(&field.name) == "datafile" && is_list(&field);
            fields.insert(field, context)?;
            if is_list {
                list = read_list(&mut lines, context)?;
                break;
            }
        }
        let lines_read = lines.offset();
        let sizes = sizes(&fields, context)?;
        let sample_type = sample_type(&fields, context)?;
        let encoding = encoding(&fields, context)?;
        let endian = endian(&fields, sample_type, encoding, context)?;
        let skip_lines = match fields.get("lineskip") {
            Some(field) => field.number("a number of lines", context)?,
            None => 0,
        };
        let layout = Layout {
            half: false,
            sample_type,
            endian,
            encoding,
            skip_lines,
            skip_bytes: skip_bytes(&fields, encoding, context)?,
            start: if fields.get("datafile").is_none() {
                lines_read
            } else {
                0
            },
        };
        let warnings = unused(&fields);
        Ok(Self {
            version,
            fields,
            sizes,
            layout,
            list,
            terminated,
            warnings,
        })
    }
}

fn read_magic(lines: &mut HeaderLines<'_, '_>, context: &Context<'_>) -> Result<char, IoError> {
    let first = lines.next(context)?;
    let text = first.as_ref().map_or("", |line| line.text.as_str());
    match text.strip_prefix("NRRD000").map(str::trim_end) {
        Some(version @ ("1" | "2" | "3" | "4" | "5")) => Ok(version.chars().next().unwrap_or('1')),
        _ => Err(context.field("magic", text, 0, "NRRD0001 to NRRD0005")),
    }
}

/// A field; nothing for comments and `key:=value` pairs.
fn parse_line(line: &Line, context: &Context<'_>) -> Result<Option<Field>, IoError> {
    if line.text.starts_with('#') {
        return Ok(None);
    }
    let Some((name, value)) = line.text.split_once(':') else {
        return Err(context.field(
            "line",
            &line.text,
            line.offset,
            "\"field: value\" or \"key:=value\"",
        ));
    };
    if value.starts_with('=') {
        return Ok(None);
    }
    Ok(Some(Field {
        name: name.trim().to_owned(),
        value: value.trim().to_owned(),
        offset: line.offset,
    }))
}

fn is_list(data_file: &Field) -> bool {
    data_file.value.split_whitespace().next() == Some("LIST")
}

fn read_list(lines: &mut HeaderLines<'_, '_>, context: &Context<'_>) -> Result<Vec<Line>, IoError> {
    let mut list = Vec::new();
    while let Some(mut line) = lines.next(context)? {
        line.text = line.text.trim().to_owned();
        if !line.text.is_empty() {
            list.push(line);
        }
    }
    Ok(list)
}

fn sizes(fields: &Fields, context: &Context<'_>) -> Result<Vec<usize>, IoError> {
    let dimension = fields.required("dimension", context)?;
    let expected = "a number of axes from 1 to 16";
    let axes: usize = dimension.number(expected, context)?;
    if !(1..=MAX_AXES).contains(&axes) {
        return Err(dimension.error(expected, context));
    }
    let field = fields.required("sizes", context)?;
    let sizes: Vec<usize> = field.exactly(axes, "positive integers", context)?;
    if sizes.contains(&0) {
        return Err(field.error(format!("{axes} positive integers"), context));
    }
    Ok(sizes)
}

fn sample_type(fields: &Fields, context: &Context<'_>) -> Result<SampleType, IoError> {
    let field = fields.required("type", context)?;
    if field.value.eq_ignore_ascii_case("block") {
        return Err(context.unsupported("samples of type \"block\" have no numeric value"));
    }
    SampleType::from_name(&field.value)
        .ok_or_else(|| field.error("a sample type such as \"unsigned char\", int16 or float", context))
}

fn encoding(fields: &Fields, context: &Context<'_>) -> Result<Encoding, IoError> {
    let field = fields.required("encoding", context)?;
    match field.value.to_ascii_lowercase().as_str() {
        "raw" => Ok(Encoding::Raw),
        "gz" | "gzip" => Ok(Encoding::Gzip),
        "txt" | "text" | "ascii" => Ok(Encoding::Text),
        "hex" => Ok(Encoding::Hex),
        "bz2" | "bzip2" | "zrl" => Err(context.unsupported(format!(
            "encoding \"{}\" is not read; convert the data to gzip or raw",
            field.value
        ))),
        _ => Err(field.error("raw, gzip, ascii or hex", context)),
    }
}

fn endian(
    fields: &Fields,
    sample_type: SampleType,
    encoding: Encoding,
    context: &Context<'_>,
) -> Result<Endian, IoError> {
    match fields.get("endian") {
        Some(field) => match field.value.to_ascii_lowercase().as_str() {
            "little" => Ok(Endian::Little),
            "big" => Ok(Endian::Big),
            _ => Err(field.error("little or big", context)),
        },
        None if sample_type.size() == 1 || encoding == Encoding::Text => Ok(Endian::NATIVE),
        None => Err(context.field(
            "endian",
            "",
            None,
            "this field, which samples of several bytes need",
        )),
    }
}

/// `byte skip`; `None` stands for -1, "the data end the file".
fn skip_bytes(fields: &Fields, encoding: Encoding, context: &Context<'_>) -> Result<Option<u64>, IoError> {
    let Some(field) = fields.get("byteskip") else {
        return Ok(Some(0));
    };
    let expected = "a number of bytes, or (raw encoding only) -1";
    match field.number::<i64>(expected, context)? {
        -1 if encoding == Encoding::Raw => Ok(None),
        count => match u64::try_from(count) {
            Ok(count) => Ok(Some(count)),
            Err(_) => Err(field.error(expected, context)),
        },
    }
}

fn unused(fields: &Fields) -> Vec<String> {
    let mut warnings = Vec::new();
    let unknown = fields.unknown(KNOWN);
    let ranges = ["oldmin", "oldmax"].iter().any(|key| fields.get(key).is_some());
    if ranges {
        warnings.push("\"old min\" and \"old max\" are not applied: values are as stored".to_owned());
    }
    let unknown: Vec<_> = unknown
        .into_iter()
        .filter(|name| !name.to_lowercase().starts_with("old"))
        .collect();
    if !unknown.is_empty() {
        warnings.push(format!(
            "fields not used: {}",
            crate::error::excerpt(&unknown.join(", "))
        ));
    }
    warnings
}
