//! PLOT3D as text: the numbers of the binary files, separated by blanks, ends of lines or commas.
//!
//! A file is its own proof: it begins with whole numbers, its dimensions, and has exactly as many numbers as they ask for.

use super::layout::{Content, Layout};
use crate::error::Context;
use crate::{Endian, IoError};

/// Bytes that show whether a file is text.
const PROBE: usize = 4096;
/// Most bytes of a number and what separates it from the next one.
const LONGEST: u64 = 64;

/// True for text that begins with a digit.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(PROBE)];
    let first = start.iter().find(|byte| !byte.is_ascii_whitespace());
    first.is_some_and(u8::is_ascii_digit)
        && start
            .iter()
            .all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
}

/// True where the dimensions at the start agree roughly with the length of the file.
pub(super) fn is_plausible(start: &[u8], length: u64) -> bool {
    let most = length / 2 + 1;
    let contents = [Content::Grid, Content::Solution].into_iter();
    let mut layouts = contents.flat_map(|content| all(start, content).map(move |layout| (content, layout)));
    layouts.any(|(content, layout)| {
        let count = numbers(&layout, content);
        count.is_some_and(|count| (length / LONGEST..=most).contains(&count))
    })
}

/// True where all lines have equally many words, as tables have.
pub(super) fn is_table(bytes: &[u8]) -> bool {
    let lines = bytes.split(|&byte| byte == b'\n').map(|line| words(line).count());
    let mut counts = lines.filter(|&count| count > 0);
    let first = counts.next();
    counts.all(|count| Some(count) == first)
}

/// The layout of a whole file, if it has one.
pub(super) fn layout(bytes: &[u8], content: Content) -> Option<Layout> {
    let count = words(bytes).count() as u64;
    all(bytes, content).find(|layout| numbers(layout, content) == Some(count))
}

/// The layout of a whole file, and its numbers as a binary file of that layout has them.
pub(super) fn read(
    bytes: &[u8],
    content: Content,
    context: &Context<'_>,
) -> Result<(Layout, Vec<u8>), IoError> {
    let layout = layout(bytes, content).ok_or_else(|| {
        let found = words(bytes).count();
        let expected = match content {
            Content::Grid => "dimensions, then x, y, z (or x, y) and perhaps IBLANK of every point",
            Content::Solution => "dimensions, then 4 numbers and 5 (or 4) of every point",
        };
        context.field("numbers", found, None, expected)
    })?;
    let mut words = words(bytes);
    let mut binary = Vec::new();
    for _ in 0..header(&layout) {
        binary.extend(whole(&mut words, context)?);
    }
    let reals = |block: usize| match content {
        Content::Grid => layout.axes() * layout.points(block),
        Content::Solution => 4 + layout.variables() * layout.points(block),
    };
    for block in 0..layout.blocks.len() {
        for _ in 0..reals(block) {
            binary.extend(real(&mut words, context)?);
        }
        if layout.blanked {
            for _ in 0..layout.points(block) {
                binary.extend(whole(&mut words, context)?);
            }
        }
    }
    Ok((layout, binary))
}

/// The words of a text.
fn words(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = bytes.split(|byte| byte.is_ascii_whitespace() || *byte == b',');
    words.filter(|word| !word.is_empty())
}

fn whole<'a>(words: &mut impl Iterator<Item = &'a [u8]>, context: &Context<'_>) -> Result<[u8; 4], IoError> {
    let word = words.next().unwrap_or_default();
    let number = str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse::<i32>().ok());
    let refused = || context.field("whole number", String::from_utf8_lossy(word), None, "digits");
    Ok(number.ok_or_else(refused)?.to_be_bytes())
}

/// A real number; Fortran writes exponents with E or D.
fn real<'a>(words: &mut impl Iterator<Item = &'a [u8]>, context: &Context<'_>) -> Result<[u8; 8], IoError> {
    let word = String::from_utf8_lossy(words.next().unwrap_or_default());
    let number = word
        .parse::<f64>()
        .or_else(|_| word.replace(['d', 'D'], "e").parse());
    let refused = |_| context.field("number", &word, None, "digits, a point, perhaps an exponent");
    Ok(number.map_err(refused)?.to_be_bytes())
}

/// The layouts whose dimensions can be read.
fn all(start: &[u8], content: Content) -> impl Iterator<Item = Layout> {
    let choices = (0..8u8).map(|bits| [0, 1, 2].map(|bit| bits >> bit & 1 == 1));
    choices
        .filter(move |&[blanked, ..]| !blanked || content == Content::Grid)
        .filter_map(move |[blanked, several, plane]| {
            let layout = Layout {
                endian: Endian::Big,
                records: false,
                several,
                plane,
                text: true,
                wide: true,
                blanked,
                blocks: Vec::new(),
                before: Vec::new(),
            };
            let grids = match several {
                true => words(start)
                    .next()
                    .and_then(|word| str::from_utf8(word).ok()?.parse().ok())?,
                false => 1usize,
            };
            let wanted = grids
                .checked_mul(layout.axes())?
                .checked_add(usize::from(several))?;
            let mut head = Vec::new();
            for word in words(start).take(wanted) {
                let number: i32 = str::from_utf8(word).ok()?.parse().ok()?;
                head.extend(number.to_be_bytes());
            }
            layout.with_blocks(&head)?.with_places(content)
        })
}

/// Numbers before the first block.
fn header(layout: &Layout) -> usize {
    usize::from(layout.several) + layout.axes() * layout.blocks.len()
}

/// Numbers of a whole file.
fn numbers(layout: &Layout, content: Content) -> Option<u64> {
    let mut count = header(layout) as u64;
    for block in 0..layout.blocks.len() {
        let points = layout.blocks[block]
            .iter()
            .try_fold(1u64, |n, &size| n.checked_mul(size as u64))?;
        let each = match content {
            Content::Grid => layout.axes() + usize::from(layout.blanked),
            Content::Solution => layout.variables(),
        };
        count = count.checked_add(points.checked_mul(each as u64)?)?;
        if content == Content::Solution {
            count = count.checked_add(4)?;
        }
    }
    Some(count)
}
