//! MetaImage, `.mha` (header and data) and `.mhd` (header of data files)
//! (<https://itk.org/Wiki/ITK/MetaIO/Documentation>).
//!
//! Physical space is LPS, as in ITK: `p = Offset + sum_i index_i ElementSpacing_i TransformMatrix_row_i`; each row of
//! `TransformMatrix` is the direction of one index axis. `AnatomicalOrientation` and `CenterOfRotation` are ignored,
//! as in ITK. Not read: arrays, vectors as a whole, `ElementToIntensityFunction...` (values are as stored).

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::data_files::DataFiles;
use super::fields::{Field, Fields, HeaderLines, Line, normalised};
use super::stored::{Encoding, FromStored, Layout, Selection, Stored};
use super::{
    Description, Draft, ReadOptions, checked_dims, choose_component, choose_time, complete_axes, length_unit,
    ras_from_lps,
};
use crate::IoError;
use crate::error::{Context, excerpt};
use crate::files;
use crate::samples::{Endian, SampleType};
use crate::source::Source;

/// Axes that are read: three of space and one of time.
const MAX_AXES: usize = 4;
/// Names of the field with the axes' directions.
const DIRECTION: [&str; 3] = ["transformmatrix", "rotation", "orientation"];

/// A parsed header; `source` was left behind its last line.
struct Header {
    fields: Fields,
    /// Names that follow `ElementDataFile = LIST`.
    list: Vec<Line>,
    /// Length of the header.
    length: u64,
    warnings: Vec<String>,
}

/// Reads a `.mha` or `.mhd` file.
///
/// # Errors
/// See [`IoError`].
pub(super) fn read<T: FromStored>(path: &Path, options: &ReadOptions) -> Result<T, IoError> {
    let context = Context::new("MetaImage header", path).following(options);
    let mut source = Source::open(path)?;
    let mut header = Header::read(&mut source, &context)?;
    let selection = header.selection(options, &context)?;
    let world_from_voxel = header.geometry(&context)?;
    let layout = header.layout(&context)?;
    let description = Description {
        format: "MetaImage".to_owned(),
        stored_type: layout.describe(),
        orientation: header.orientation(),
        oriented: header.is_oriented(),
        files: vec![path.to_owned()],
        warnings: std::mem::take(&mut header.warnings),
        ..Description::default()
    };
    let mut draft = Draft::new(selection.dims, description);
    draft.world_from_voxel = world_from_voxel;
    if let Some(field) = header.fields.get("distanceunits") {
        match length_unit(&field.value) {
            Some(unit) => draft.unit = unit,
            None => draft.warn(format!("length units are not kept: {}", excerpt(&field.value))),
        }
    }
    draft.set_times(selection.times, options);
    draft.grid(&context)?;
    let stored = Stored {
        layout,
        selection,
        files: header.files(&context)?,
    };
    let context = Context::new("MetaImage data", path).following(options);
    header.check_compressed_size(&stored.files, &mut draft, &context);
    T::from_stored(&stored, source, draft, (options, &context))
}

impl Header {
    fn read(source: &mut Source<'_>, context: &Context<'_>) -> Result<Self, IoError> {
        let mut lines = HeaderLines::new(source);
        let mut fields = Fields::default();
        let mut list = Vec::new();
        loop {
            let Some(line) = lines.next(context)? else {
                let expected = "this field, which ends the header";
                return Err(context.field("ElementDataFile", "", lines.offset(), expected));
            };
            if line.text.trim().is_empty() {
                continue;
            }
            let field = parse_line(&line, context)?;
            let last = normalised(&field.name) == "elementdatafile";
            let is_list = last && is_list(&field);
            fields.insert(field, context)?;
            if is_list {
                while let Some(mut line) = lines.next(context)? {
                    line.text = line.text.trim().to_owned();
                    if !line.text.is_empty() {
                        list.push(line);
                    }
                }
            }
            if last {
                break;
            }
        }
        let length = lines.offset();
        if let Some(field) = fields
            .get("objecttype")
            .filter(|field| !field.value.eq_ignore_ascii_case("image"))
        {
            return Err(field.error("Image", context));
        }
        let warnings = ignored(&fields);
        Ok(Self {
            fields,
            list,
            length,
            warnings,
        })
    }

    fn selection(&self, options: &ReadOptions, context: &Context<'_>) -> Result<Selection, IoError> {
        let axes = self.axes(context)?;
        let field = self.fields.required("dimsize", context)?;
        let sizes: Vec<i64> = field.exactly(axes, "positive integers", context)?;
        let dims = checked_dims(&sizes[..axes.min(3)], "DimSize", field.offset, context)?;
        let volumes = match sizes.get(3) {
            Some(&size) => usize::try_from(size).ok().filter(|&size| size > 0),
            None => Some(1),
        };
        let volumes = volumes.ok_or_else(|| field.error("positive integers", context))?;
        let (components, component) = self.components(options, context)?;
        Ok(Selection {
            dims,
            components,
            component,
            volumes,
            times: volumes,
            volume: choose_time(volumes, options, context)?,
        })
    }

    fn axes(&self, context: &Context<'_>) -> Result<usize, IoError> {
        let field = self.fields.required("ndims", context)?;
        let expected = "a number of axes from 1 to 4";
        let axes = field.number(expected, context)?;
        if !(1..=MAX_AXES).contains(&axes) {
            return Err(field.error(expected, context));
        }
        Ok(axes)
    }

    fn components(&self, options: &ReadOptions, context: &Context<'_>) -> Result<(usize, usize), IoError> {
        let Some(field) = self.fields.get("elementnumberofchannels") else {
            return Ok((1, choose_component(1, "numbers", options, context)?));
        };
        let expected = "a positive number of channels";
        let count: usize = field.number(expected, context)?;
        if count == 0 {
            return Err(field.error(expected, context));
        }
        Ok((count, choose_component(count, "vectors", options, context)?))
    }

    fn geometry(&self, context: &Context<'_>) -> Result<DAffine3, IoError> {
        let axes = self.axes(context)?;
        let numbers = |keys: &[&str], count| match self.fields.any(keys) {
            Some(field) => finite(field, count, context).map(Some),
            None => Ok(None),
        };
        let spacing = numbers(&["elementspacing", "elementsize"], axes)?.unwrap_or_else(|| vec![1.0; axes]);
        let offset = numbers(&["offset", "position", "origin"], axes)?.unwrap_or_else(|| vec![0.0; axes]);
        let matrix = numbers(&DIRECTION, axes * axes)?;
        if let Some(field) = self.fields.any(&["elementspacing", "elementsize"])
            && spacing.iter().any(|&step| step <= 0.0)
        {
            return Err(field.error(format!("{axes} positive numbers"), context));
        }
        // Space has at most three axes; the fourth row and column are time's.
        let space = axes.min(3);
        let step = |axis: usize| {
            let direction = |i: usize| match &matrix {
                _ if i >= space => 0.0,
                Some(matrix) => matrix[axis * axes + i],
                None => f64::from(u8::from(i == axis)),
            };
            Some(DVec3::new(direction(0), direction(1), direction(2)) * spacing[axis])
        };
        let steps: Vec<Option<DVec3>> = (0..space).map(step).collect();
        let at = |i: usize| if i < space { offset[i] } else { 0.0 };
        let origin = DVec3::new(at(0), at(1), at(2));
        Ok(ras_from_lps() * DAffine3::from_mat3_translation(complete_axes(&steps), origin))
    }

    /// Whether the header specifies more than the anatomical axes of the format's world.
    fn is_oriented(&self) -> bool {
        self.fields.any(&DIRECTION).is_some() || self.fields.get("anatomicalorientation").is_some()
    }

    fn orientation(&self) -> String {
        let matrix = match self.fields.any(&DIRECTION) {
            Some(field) => field.name.as_str(),
            None => "no direction, axes along the space's",
        };
        let anatomical = match self.fields.get("anatomicalorientation") {
            Some(field) => format!(", AnatomicalOrientation {}", excerpt(&field.value)),
            None => String::new(),
        };
        format!("left-posterior-superior ({matrix}{anatomical}); x and y negated to make RAS+")
    }

    fn layout(&mut self, context: &Context<'_>) -> Result<Layout, IoError> {
        let flag = |keys: &[&str]| match self.fields.any(keys) {
            Some(field) => boolean(field, context).map(Some),
            None => Ok(None),
        };
        let compressed = flag(&["compresseddata"])?.unwrap_or(false);
        let binary = flag(&["binarydata"])?.unwrap_or(true);
        let big = flag(&["elementbyteordermsb", "binarydatabyteordermsb"])?;
        let encoding = match (binary, compressed) {
            (true, false) => Encoding::Raw,
            (true, true) => Encoding::Zlib,
            (false, false) => Encoding::Text,
            (false, true) => return Err(context.unsupported("compressed text")),
        };
        let sample_type = sample_type(self.fields.required("elementtype", context)?, context)?;
        if big.is_none() && sample_type.size() > 1 && binary {
            let warning = "no byte order (ElementByteOrderMSB): little-endian is assumed";
            self.warnings.push(warning.to_owned());
        }
        let attached = self.fields.get("elementdatafile").is_some_and(is_local);
        Ok(Layout {
            half: false,
            sample_type,
            endian: if big == Some(true) {
                Endian::Big
            } else {
                Endian::Little
            },
            encoding,
            skip_lines: 0,
            skip_bytes: skip_bytes(&self.fields, encoding, context)?,
            start: if attached { self.length } else { 0 },
        })
    }

    /// `CompressedDataSize` is known to be wrong in practice: the stream itself marks its end.
    fn check_compressed_size(&self, data: &DataFiles<'_>, draft: &mut Draft, context: &Context<'_>) {
        let Some(field) = self.fields.get("compresseddatasize") else {
            return;
        };
        let (file, before) = match data.only(context) {
            Some(file) => (file, 0),
            None if data.is_attached() => (context.path.to_owned(), self.length),
            None => return,
        };
        // A file that cannot be read is reported by whoever reads it.
        let Ok(metadata) = files::metadata(&file) else {
            return;
        };
        let found = metadata.len().saturating_sub(before);
        if field.value.parse() != Ok(found) {
            let declared = excerpt(&field.value);
            draft.warn(format!(
                "CompressedDataSize is {declared}, there are {found} bytes; all were used"
            ));
        }
    }

    fn files(&self, context: &Context<'_>) -> Result<DataFiles<'_>, IoError> {
        const FIELD: &str = "ElementDataFile";
        let field = self.fields.required("elementdatafile", context)?;
        match () {
            () if is_local(field) => Ok(DataFiles::attached(FIELD)),
            () if is_list(field) => Ok(DataFiles::list(FIELD, &self.list)),
            () => DataFiles::named(FIELD, field, context),
        }
    }
}

fn parse_line(line: &Line, context: &Context<'_>) -> Result<Field, IoError> {
    let Some((name, value)) = line.text.split_once('=').or_else(|| line.text.split_once(':')) else {
        return Err(context.field("line", &line.text, line.offset, "\"Name = value\""));
    };
    Ok(Field {
        name: name.trim().to_owned(),
        value: value.trim().to_owned(),
        offset: line.offset,
    })
}

fn is_local(data_file: &Field) -> bool {
    data_file.value.eq_ignore_ascii_case("local")
}

fn is_list(data_file: &Field) -> bool {
    data_file.value.split_whitespace().next() == Some("LIST")
}

/// `MetaIO` goes by the first letter.
fn boolean(field: &Field, context: &Context<'_>) -> Result<bool, IoError> {
    match field.value.chars().next() {
        Some('T' | 't' | '1' | 'Y' | 'y') => Ok(true),
        Some('F' | 'f' | '0' | 'N' | 'n') => Ok(false),
        _ => Err(field.error("True or False", context)),
    }
}

fn finite(field: &Field, count: usize, context: &Context<'_>) -> Result<Vec<f64>, IoError> {
    let numbers: Vec<f64> = field.exactly(count, "finite numbers", context)?;
    if numbers.iter().all(|number| number.is_finite()) {
        Ok(numbers)
    } else {
        Err(field.error(format!("{count} finite numbers"), context))
    }
}

/// In `MetaIO`, LONG has 4 bytes on every machine.
fn sample_type(field: &Field, context: &Context<'_>) -> Result<SampleType, IoError> {
    Ok(match field.value.to_ascii_uppercase().as_str() {
        "MET_CHAR" | "MET_ASCII_CHAR" => SampleType::I8,
        "MET_UCHAR" => SampleType::U8,
        "MET_SHORT" => SampleType::I16,
        "MET_USHORT" => SampleType::U16,
        "MET_INT" | "MET_LONG" => SampleType::I32,
        "MET_UINT" | "MET_ULONG" => SampleType::U32,
        "MET_LONG_LONG" => SampleType::I64,
        "MET_ULONG_LONG" => SampleType::U64,
        "MET_FLOAT" => SampleType::F32,
        "MET_DOUBLE" => SampleType::F64,
        _ => return Err(field.error("a scalar type such as MET_UCHAR or MET_FLOAT", context)),
    })
}

/// `HeaderSize`, bytes before the data of a data file; `None` stands for -1, "the data end the file".
fn skip_bytes(fields: &Fields, encoding: Encoding, context: &Context<'_>) -> Result<Option<u64>, IoError> {
    let Some(field) = fields.get("headersize") else {
        return Ok(Some(0));
    };
    let expected = "a number of bytes, or (uncompressed data only) -1";
    match field.number::<i64>(expected, context)? {
        0 => Ok(Some(0)),
        -1 if encoding == Encoding::Raw => Ok(None),
        // A compressed stream starts at once; skipping within it is not defined.
        count => match u64::try_from(count) {
            Ok(count) if encoding == Encoding::Raw => Ok(Some(count)),
            _ => Err(field.error(expected, context)),
        },
    }
}

fn ignored(fields: &Fields) -> Vec<String> {
    let mut warnings = Vec::new();
    if fields.any(&["elementspacing", "elementsize"]).is_none() {
        warnings.push("no spacing: 1 is used".to_owned());
    }
    let differs = |key, neutral: f64| {
        fields.get(key).is_some_and(|field| {
            field
                .value
                .split_whitespace()
                .any(|word| word.parse::<f64>().is_ok_and(|value| value != neutral))
        })
    };
    if differs("elementtointensityfunctionslope", 1.0) || differs("elementtointensityfunctionoffset", 0.0) {
        warnings.push("ElementToIntensityFunction is not applied: values are as stored".to_owned());
    }
    if differs("centerofrotation", 0.0) {
        warnings.push("CenterOfRotation is not applied".to_owned());
    }
    warnings
}
