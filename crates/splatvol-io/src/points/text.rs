//! Tables of numbers: XYZ, CSV, PTS and their kin.
//!
//! One point per line; numbers are separated by white space, commas or semicolons. Lines that begin with `#` or `//`
//! are comments, unless they name the columns; a first line of words names them too. Without names, three columns are
//! `x y z`, four have an intensity, six a colour or a unit normal (the numbers tell which), seven intensity and
//! colour, nine colour and normal in either order. A first line that is one whole number is a count (PTS).

use std::path::Path;

use super::LoadedPoints;
use super::columns::{INTENSITY, NORMAL, RED, ROLES, X, columns_of_roles};
use super::gather::{ColorKind, Gather};
use crate::error::Context;
use crate::source::read_file;
use crate::{Description, IoError, ReadOptions};

/// Lines that decide the roles of unnamed columns.
const PROBED: usize = 1000;

/// Reads a table.
///
/// # Errors
/// Words among the numbers, lines of different lengths, columns that are not understood, or a number of lines other
/// than the file's count.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    let context = &Context::new("table of points", path);
    let bytes = read_file(path, context)?;
    let mut lines = lines(&bytes).peekable();
    let mut names = None;
    let mut count = None;
    // Lines before the first row of numbers.
    while let Some(line) = lines.peek() {
        let comment = line.comment();
        if let Some(numbers) = line.numbers() {
            match numbers.as_slice() {
                [declared] if count.is_none() && declared.fract() == 0.0 => count = Some(*declared),
                _ => break,
            }
        } else {
            let words: Vec<&str> = line.words(comment).collect();
            let columns = columns_of_roles(words.iter().copied());
            let named = columns[X..X + 3].iter().all(Option::is_some);
            if named && names.is_none() {
                names = Some((columns, words.len()));
            } else if comment.is_none() && !words.is_empty() {
                let expected = "names of columns, x, y and z among them, or numbers";
                return Err(context.field("first line", line.text, line.offset, expected));
            }
        }
        lines.next();
    }
    let Some(width) = lines.peek().and_then(Line::numbers).map(|row| row.len()) else {
        return Err(context.field("rows", 0, None, "at least one row of numbers"));
    };
    let columns = match names {
        Some((columns, named)) if named == width => columns,
        Some((_, named)) => {
            let expected = format!("{named} numbers, one for each name");
            return Err(context.field("first row", format!("{width} numbers"), None, expected));
        }
        None => guess(width, lines.clone(), context)?,
    };
    let mut gather = Gather::new(columns.map(|column| column.is_some()), options);
    gather.check_count(bytes.len() as u64 / (2 * width as u64), context)?;
    let whole = fill(&mut gather, lines, &columns, width, context)?;
    let mut description = describe(&columns, path);
    if let Some(declared) = count.filter(|&declared| declared != whole.rows as f64) {
        description.warnings.push(format!(
            "the first line counts {declared} points, there are {}",
            whole.rows
        ));
    }
    let kind = if whole.colors {
        ColorKind::Integer
    } else {
        ColorKind::Float
    };
    gather.finish(kind, description, context)
}

/// Observations made while rows were read.
struct Seen {
    rows: u64,
    /// All colours are whole numbers, and not just 0 and 1.
    colors: bool,
}

fn fill<'a>(
    gather: &mut Gather,
    lines: impl Iterator<Item = Line<'a>>,
    columns: &[Option<usize>; ROLES],
    width: usize,
    context: &Context<'_>,
) -> Result<Seen, IoError> {
    let (mut rows, mut whole, mut largest) = (0, true, 0.0f64);
    for line in lines {
        if line.comment().is_some() {
            continue;
        }
        let numbers = line
            .numbers()
            .filter(|numbers| numbers.len() == width)
            .ok_or_else(|| {
                context.field(
                    format!("row {rows}"),
                    line.text,
                    line.offset,
                    format!("{width} numbers"),
                )
            })?;
        let row = columns.map(|column| column.map_or(f64::NAN, |column| numbers[column]));
        for color in &row[RED..RED + 3] {
            whole &= color.fract() == 0.0;
            largest = largest.max(*color);
        }
        gather.push(&row);
        rows += 1;
    }
    Ok(Seen {
        rows,
        colors: whole && largest > 1.0,
    })
}

/// Guesses the roles of unnamed columns.
fn guess<'a>(
    width: usize,
    lines: impl Iterator<Item = Line<'a>>,
    context: &Context<'_>,
) -> Result<[Option<usize>; ROLES], IoError> {
    let rows: Vec<Vec<f64>> = lines.filter_map(|line| line.numbers()).take(PROBED).collect();
    let unit = |first: usize| {
        rows.iter().filter(|row| row.len() == width).all(|row| {
            let length = row[first..first + 3].iter().map(|c| c * c).sum::<f64>();
            length == 0.0 || (length - 1.0).abs() < 0.01
        })
    };
    let roles: Vec<usize> = match width {
        3 => vec![X],
        4 => vec![X, INTENSITY],
        6 if unit(3) => vec![X, NORMAL],
        6 => vec![X, RED],
        7 => vec![X, INTENSITY, RED],
        9 if unit(3) => vec![X, NORMAL, RED],
        9 if unit(6) => vec![X, RED, NORMAL],
        _ => {
            let expected =
                "3, 4, 6, 7 or 9 columns, or a line that names them (x, y, z, nx, red, intensity, radius)";
            return Err(context.field("columns", width, None, expected));
        }
    };
    let mut columns = [None; ROLES];
    let mut column = 0;
    for role in roles {
        let size = if role == INTENSITY { 1 } else { 3 };
        for part in 0..size {
            columns[role + part] = Some(column);
            column += 1;
        }
    }
    Ok(columns)
}

fn describe(columns: &[Option<usize>; ROLES], path: &Path) -> Description {
    let names = [
        "x",
        "y",
        "z",
        "nx",
        "ny",
        "nz",
        "red",
        "green",
        "blue",
        "alpha",
        "intensity",
        "radius",
    ];
    let mut found: Vec<(usize, &str)> = columns
        .iter()
        .zip(names)
        .filter_map(|(column, name)| Some(((*column)?, name)))
        .collect();
    found.sort_unstable();
    let found: Vec<&str> = found.into_iter().map(|(_, name)| name).collect();
    Description {
        format: "table of points".to_owned(),
        stored_type: format!("text, {}", found.join(" ")),
        files: vec![path.to_owned()],
        ..Description::default()
    }
}

/// A line that is not blank.
#[derive(Clone, Copy)]
struct Line<'a> {
    text: &'a str,
    offset: u64,
}

impl<'a> Line<'a> {
    /// The text after the comment mark.
    fn comment(&self) -> Option<&'a str> {
        self.text
            .strip_prefix('#')
            .or_else(|| self.text.strip_prefix("//"))
    }

    fn words(&self, comment: Option<&'a str>) -> impl Iterator<Item = &'a str> {
        comment
            .unwrap_or(self.text)
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|word| !word.is_empty())
    }

    /// The numbers of a line that has nothing else.
    fn numbers(&self) -> Option<Vec<f64>> {
        let numbers: Vec<f64> = self
            .words(None)
            .map(|word| word.parse().ok())
            .collect::<Option<_>>()?;
        (!numbers.is_empty()).then_some(numbers)
    }
}

/// Lines that are not blank. A line with bytes that are not UTF-8 becomes a single replacement character, which is
/// not a number.
fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> + Clone {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = bytes.as_ptr() as usize;
    bytes
        .split(|&byte| byte == b'\n' || byte == b'\r')
        .map(move |line| Line {
            offset: (line.as_ptr() as usize - start) as u64,
            text: str::from_utf8(line).unwrap_or("\u{fffd}").trim(),
        })
        .filter(|line| !line.text.is_empty())
}
