//! Location of the samples that a text header describes: behind the header, in a file beside it, or spread evenly over
//! several (a numbered series such as `slice.%03d 1 93 1`, or a list).

use std::ops::Range;
use std::path::PathBuf;

use super::Description;
use super::fields::{Field, Line};
use crate::IoError;
use crate::error::Context;
use crate::source::{Source, companion};

/// Data files, each of which holds the same number of samples.
pub(super) struct DataFiles<'a> {
    /// The field that names them.
    field: &'static str,
    kind: Kind<'a>,
    /// Whether other data may follow the samples.
    is_followed: bool,
}

enum Kind<'a> {
    Attached,
    One(&'a Field),
    List(&'a [Line]),
    Series(&'a Field, Series),
}

/// A file name with a running number.
struct Series {
    before: String,
    after: String,
    width: usize,
    first: i64,
    step: i64,
    count: usize,
}

/// The samples of one file: their number, and which are wanted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    /// Number of the file.
    pub(super) file: usize,
    pub(super) holds: usize,
    pub(super) skip: usize,
    pub(super) take: usize,
}

impl Piece {
    /// True where the last sample of the file is taken.
    pub(super) fn ends_file(&self) -> bool {
        self.skip + self.take == self.holds
    }
}

impl<'a> DataFiles<'a> {
    /// Data behind the header.
    pub(super) fn attached(field: &'static str) -> Self {
        Self {
            field,
            kind: Kind::Attached,
            is_followed: false,
        }
    }

    /// The same, where other data may follow the samples.
    pub(super) fn followed(self) -> Self {
        Self {
            is_followed: true,
            ..self
        }
    }

    /// Whether other data may follow the samples.
    pub(super) fn is_followed(&self) -> bool {
        self.is_followed
    }

    /// Files listed line by line.
    pub(super) fn list(field: &'static str, lines: &'a [Line]) -> Self {
        Self {
            field,
            kind: Kind::List(lines),
            is_followed: false,
        }
    }

    /// The file or the series that the value of `named` is.
    pub(super) fn named(
        field: &'static str,
        named: &'a Field,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        let kind = match series(named, context)? {
            Some(series) => Kind::Series(named, series),
            None => Kind::One(named),
        };
        Ok(Self {
            field,
            kind,
            is_followed: false,
        })
    }

    /// Whether the samples lie behind the header.
    pub(super) fn is_attached(&self) -> bool {
        matches!(self.kind, Kind::Attached)
    }

    /// The file beside the header, where one holds all samples.
    pub(super) fn only(&self, context: &Context<'_>) -> Option<PathBuf> {
        match &self.kind {
            Kind::One(field) => companion(&field.value, self.field, field.offset, context).ok(),
            Kind::Attached | Kind::List(_) | Kind::Series(..) => None,
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        match &self.kind {
            Kind::Attached | Kind::One(_) => 1,
            Kind::List(lines) => lines.len(),
            Kind::Series(_, series) => series.count,
        }
    }

    /// The pieces that make up the samples `wanted` out of `total`, in order.
    pub(super) fn pieces(
        &self,
        total: usize,
        wanted: Range<usize>,
        context: &Context<'_>,
    ) -> Result<impl Iterator<Item = Piece> + use<>, IoError> {
        let count = self.count();
        if count == 0 || !total.is_multiple_of(count) {
            let expected = format!("a number of files that {total} samples can be divided by");
            return Err(context.field(self.field, format!("{count} files"), None, expected));
        }
        let holds = total / count;
        Ok(
            (wanted.start / holds..wanted.end.div_ceil(holds)).map(move |file| {
                let begin = file * holds;
                let skip = wanted.start.saturating_sub(begin);
                Piece {
                    file,
                    holds,
                    skip,
                    take: (wanted.end - begin).min(holds) - skip,
                }
            }),
        )
    }

    /// The data file of this number, noted in `description`; `None` where the data are attached.
    pub(super) fn open(
        &self,
        index: usize,
        description: &mut Description,
        context: &Context<'_>,
    ) -> Result<Option<Source<'static>>, IoError> {
        let (name, offset) = match &self.kind {
            Kind::Attached => return Ok(None),
            Kind::One(field) => (field.value.clone(), field.offset),
            Kind::List(lines) => (lines[index].text.clone(), lines[index].offset),
            Kind::Series(field, series) => (series.name(index), field.offset),
        };
        let path = companion(&name, self.field, offset, context)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn field(value: &str) -> Field {
        Field {
            name: "data file".to_owned(),
            value: value.to_owned(),
            offset: 0,
        }
    }

    #[test]
    fn a_series_needs_a_pattern_and_three_numbers() {
        let context = Context::new("test", Path::new("a"));
        let names = |value: &str| {
            let series = series(&field(value), &context)?;
            Ok::<_, IoError>(
                series.map(|series| (0..series.count).map(|i| series.name(i)).collect::<Vec<_>>()),
            )
        };
        assert_eq!(
            names("a b.%02d.raw 8 12 2").unwrap().unwrap(),
            ["a b.08.raw", "a b.10.raw", "a b.12.raw"]
        );
        assert_eq!(names("a%d 2 1 -1 2").unwrap().unwrap(), ["a2", "a1"]);
        assert_eq!(names("100%.raw").unwrap(), None);
        assert_eq!(names("a 1 2 3").unwrap(), None);
        assert!(names("a%s 1 2 3").is_err());
        assert!(names("a%d 2 1 1").is_err());
    }

    #[test]
    fn pieces_cover_exactly_what_is_wanted() {
        let context = Context::new("test", Path::new("a"));
        let lines = ["a", "b", "c"].map(|text| Line {
            text: text.to_owned(),
            offset: 0,
        });
        let files = DataFiles::list("data file", &lines);
        let pieces: Vec<Piece> = files.pieces(12, 3..9, &context).unwrap().collect();
        let piece = |file, skip, take| Piece {
            file,
            holds: 4,
            skip,
            take,
        };
        assert_eq!(pieces, [piece(0, 3, 1), piece(1, 0, 4), piece(2, 0, 1)]);
        assert!(files.pieces(13, 0..13, &context).is_err());
    }
}
