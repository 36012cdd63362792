//! The samples: attached, or in one or several data files, in any of the encodings.

use std::io::BufRead;
use std::io::Read;

use splatvol_scene::Samples;

use super::axes::Selection;
use super::header::{Encoding, Header};
use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleBuffer, TextNumbers, decode_hex, pick_component, remaining_text};
use crate::source::{Codec, Rest, Source, companion};
use crate::volume::fields::Field;
use crate::volume::{Description, ReadOptions, sample_count};

/// Where the data are; every file holds the same number of samples.
enum Files<'a> {
    Attached,
    One(&'a Field),
    List(&'a Header),
    Series { field: &'a Field, series: Series },
}

/// `slice.%03d 1 93 1`.
struct Series {
    before: String,
    after: String,
    width: usize,
    first: i64,
    step: i64,
    count: usize,
}

/// The samples of one file: how many it holds, and which are wanted.
struct Piece {
    holds: usize,
    skip: usize,
    take: usize,
}

/// Reads the selected volume. Files and warnings are added to `description`.
pub(super) fn read(
    source: Source<'_>,
    header: &Header,
    selection: &Selection,
    options: &ReadOptions,
    description: &mut Description,
    context: &Context<'_>,
) -> Result<Samples, IoError> {
    let files = Files::new(header, context)?;
    let per_volume = sample_count(
        selection.dims,
        selection.components,
        header.sample_type,
        options,
        context,
    )?;
    let total = per_volume
        .checked_mul(selection.volumes)
        .ok_or_else(|| context.limit(u64::MAX, options.max_bytes))?;
    let count = files.count();
    if count == 0 || !total.is_multiple_of(count) {
        let field = header.fields.required("datafile", context)?;
        return Err(field.error(
            format!("as many files as slices ({total} samples in {count} files)"),
            context,
        ));
    }
    let holds = total / count;
    let wanted = per_volume * selection.volume..per_volume * (selection.volume + 1);
    // Text is parsed to native numbers.
    let endian = if header.encoding == Encoding::Text {
        Endian::NATIVE
    } else {
        header.endian
    };
    let mut buffer = SampleBuffer::new(header.sample_type, endian);
    let mut attached = Some(source);
    for index in wanted.start / holds..wanted.end.div_ceil(holds) {
        let begin = index * holds;
        let skip = wanted.start.saturating_sub(begin);
        let piece = Piece {
            holds,
            skip,
            take: (wanted.end - begin).min(holds) - skip,
        };
        let source = match files.open(index, description, context)? {
            Some(source) => source,
            None => attached.take().ok_or_else(|| context.truncated("data", 1, 0))?,
        };
        if read_piece(source, header, &piece, &mut buffer, context)? == Rest::Excess {
            description
                .warnings
                .push("there are more data than the header declares".to_owned());
        }
    }
    let (samples, warning) = buffer.finish();
    description.warnings.extend(warning);
    description.warnings.dedup();
    Ok(match selection.components {
        1 => samples,
        components => pick_component(&samples, components, selection.component),
    })
}

fn read_piece(
    mut source: Source<'_>,
    header: &Header,
    piece: &Piece,
    buffer: &mut SampleBuffer,
    context: &Context<'_>,
) -> Result<Rest, IoError> {
    let skips = Skips::new(header, context)?;
    for _ in 0..skips.lines {
        if source.peek(context)?.is_empty() {
            return Err(context.truncated("skipped lines", skips.lines, 0));
        }
        skip_line(&mut source, context)?;
    }
    if header.encoding == Encoding::Gzip {
        source = source.inflate(Codec::Gzip);
    }
    let bytes = |samples: usize| header.sample_type.byte_count(samples);
    match skips.bytes {
        Some(count) => source.skip(count, context)?,
        None => {
            source.check_declared("samples", bytes(piece.holds), context)?;
            source.skip(source.at_most() - bytes(piece.holds), context)?;
        }
    }
    let whole = piece.skip + piece.take == piece.holds;
    let attached = header.fields.get("datafile").is_none();
    let start = if attached { header.length } else { 0 };
    match header.encoding {
        Encoding::Text => {
            let text = remaining_text(&mut source, context)?;
            let numbers = TextNumbers { text: &text, start };
            let used = buffer.read_text(&numbers, piece.skip, piece.take, context)?;
            Ok(if whole && !numbers.ends_at(used) {
                Rest::Excess
            } else {
                Rest::Nothing
            })
        }
        Encoding::Hex => {
            let text = remaining_text(&mut source, context)?;
            let decoded = decode_hex(&text, bytes(piece.skip + piece.take), start, context)?;
            let wanted = &decoded[bytes(piece.skip) as usize..];
            buffer.read(&mut Source::from_bytes(wanted), piece.take, context)?;
            Ok(Rest::Nothing)
        }
        Encoding::Raw | Encoding::Gzip => {
            source.skip(bytes(piece.skip), context)?;
            buffer.read(&mut source, piece.take, context)?;
            if whole {
                source.rest(context)
            } else {
                Ok(Rest::Nothing)
            }
        }
    }
}

fn skip_line(source: &mut Source<'_>, context: &Context<'_>) -> Result<(), IoError> {
    let limit = source.at_most();
    source
        .by_ref()
        .take(limit)
        .skip_until(b'\n')
        .map_err(|error| context.read(error))?;
    Ok(())
}

/// `line skip` and `byte skip`; bytes `None` stands for -1, "the data end the file".
struct Skips {
    lines: u64,
    bytes: Option<u64>,
}

impl Skips {
    fn new(header: &Header, context: &Context<'_>) -> Result<Self, IoError> {
        let lines = match header.fields.get("lineskip") {
            Some(field) => field.number("a number of lines", context)?,
            None => 0,
        };
        let bytes = match header.fields.get("byteskip") {
            None => Some(0),
            Some(field) => match field.number::<i64>("a number of bytes, or -1", context)? {
                -1 if header.encoding == Encoding::Raw => None,
                -1 => return Err(field.error("a number of bytes (-1 is for raw encoding only)", context)),
                count => {
                    Some(u64::try_from(count).map_err(|_| field.error("a number of bytes, or -1", context))?)
                }
            },
        };
        Ok(Self { lines, bytes })
    }
}

impl<'a> Files<'a> {
    fn new(header: &'a Header, context: &Context<'_>) -> Result<Self, IoError> {
        let Some(field) = header.fields.get("datafile") else {
            return match header.terminated {
                true => Ok(Self::Attached),
                false => Err(context.field(
                    "data file",
                    "",
                    header.length,
                    "this field, or a blank line and the data",
                )),
            };
        };
        if field.value.split_whitespace().next() == Some("LIST") {
            return Ok(Self::List(header));
        }
        match series(field, context)? {
            Some(series) => Ok(Self::Series { field, series }),
            None => Ok(Self::One(field)),
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Attached | Self::One(_) => 1,
            Self::List(header) => header.list.len(),
            Self::Series { series, .. } => series.count,
        }
    }

    /// The data file of this number; `None` where the data are attached.
    fn open(
        &self,
        index: usize,
        description: &mut Description,
        context: &Context<'_>,
    ) -> Result<Option<Source<'static>>, IoError> {
        let (name, offset) = match self {
            Self::Attached => return Ok(None),
            Self::One(field) => (field.value.clone(), field.offset),
            Self::List(header) => (header.list[index].text.clone(), header.list[index].offset),
            Self::Series { field, series } => (series.name(index), field.offset),
        };
        let path = companion(&name, "data file", offset, context)?;
        let source = Source::open(&path)?;
        description.files.push(path);
        Ok(Some(source))
    }
}

impl Series {
    fn name(&self, index: usize) -> String {
        // `count` was checked to stay in range.
        let number = self.first.wrapping_add(self.step.wrapping_mul(index as i64));
        format!(
            "{}{number:0width$}{}",
            self.before,
            self.after,
            width = self.width
        )
    }
}

/// A numbered series, where the value ends in three (or, with the dimension of a piece, four) integers.
fn series(field: &Field, context: &Context<'_>) -> Result<Option<Series>, IoError> {
    let words: Vec<&str> = field.value.split_whitespace().collect();
    let trailing = words
        .iter()
        .rev()
        .take(4)
        .map_while(|word| word.parse::<i64>().ok())
        .count();
    if trailing < 3 || !field.value.contains('%') {
        return Ok(None);
    }
    let numbers: Vec<i64> = words[words.len() - trailing..]
        .iter()
        .filter_map(|word| word.parse().ok())
        .take(3)
        .collect();
    let expected = "\"name%03d first last step\" with last reached from first in steps";
    let bad = || field.error(expected, context);
    let mut pattern = field.value.as_str();
    for _ in 0..trailing {
        pattern = pattern.trim_end();
        pattern =
            &pattern[..pattern.len() - pattern.chars().rev().take_while(|c| !c.is_whitespace()).count()];
    }
    let (before, conversion) = pattern.trim_end().split_once('%').ok_or_else(bad)?;
    let (width, after) = conversion.split_once(['d', 'i', 'u']).ok_or_else(bad)?;
    let width = if width.is_empty() {
        0
    } else {
        width.parse::<usize>().map_err(|_| bad())?
    };
    let [first, last, step] = numbers[..] else {
        return Err(bad());
    };
    if width > 20 || after.contains('%') || step == 0 {
        return Err(bad());
    }
    let count = last
        .checked_sub(first)
        .and_then(|span| span.checked_div(step))
        .and_then(|steps| steps.checked_add(1))
        .and_then(|count| usize::try_from(count).ok())
        .filter(|&count| count > 0)
        .ok_or_else(bad)?;
    Ok(Some(Series {
        before: before.to_owned(),
        after: after.to_owned(),
        width,
        first,
        step,
        count,
    }))
}
