//! VTK XML: the arrays in base64, with their lengths, and compressed blocks.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::Change;
use super::streams::{deflated, inflated};
use crate::random::Random;

/// What stands before an array in base64.
const START: &[u8] = b"format=\"binary\">";

pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    let is_start = |at: &usize| bytes[*at..].starts_with(START);
    let starts: Vec<usize> = (0..bytes.len()).filter(is_start).collect();
    if starts.is_empty() || random.below(2) == 0 {
        return None;
    }
    let start = random.one_of(&starts) + START.len();
    let length = bytes[start..].iter().position(|byte| *byte == b'<')?;
    let text: Vec<u8> = bytes[start..start + length]
        .iter()
        .copied()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    let width = if find(bytes, b"header_type=\"UInt64\"") {
        8
    } else {
        4
    };
    let packed = find(bytes, b"vtkZLibDataCompressor");
    let text = if packed {
        compressed(&text, width, random, change)?
    } else {
        let mut array = STANDARD.decode(&text).ok()?;
        let mut inside = array.split_off(width.min(array.len()));
        change(&mut inside, random);
        STANDARD.encode([words(&[inside.len()], width), inside].concat())
    };
    Some([&bytes[..start], text.as_bytes(), &bytes[start + length..]].concat())
}

/// An array of one compressed block or more becomes one block.
fn compressed(text: &[u8], width: usize, random: &mut Random, change: &mut Change<'_>) -> Option<String> {
    // The header is coded for itself: a count, two sizes, and as many more.
    let count = STANDARD.decode(text.get(..12)?).ok()?;
    let count = usize::from(*count.first()?);
    let header = (width * (3 + count)).div_ceil(3) * 4;
    let blocks = STANDARD.decode(text.get(header..)?).ok()?;
    let mut inside = inflated(&blocks)?;
    change(&mut inside, random);
    let block = deflated(&inside);
    let header = words(&[1, inside.len(), 0, block.len()], width);
    Some(STANDARD.encode(header) + &STANDARD.encode(block))
}

fn words(numbers: &[usize], width: usize) -> Vec<u8> {
    let word = |number: &usize| (*number as u64).to_le_bytes()[..width].to_vec();
    numbers.iter().flat_map(word).collect()
}

fn find(bytes: &[u8], text: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1024)];
    head.windows(text.len()).any(|window| window == text)
}
