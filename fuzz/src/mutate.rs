//! Damage to bytes that knows nothing of formats: bits, numbers, cuts, copies, and words of a dictionary.

use crate::random::Random;

/// Longest file that is made.
pub(crate) const LONGEST: usize = 128 << 10;

/// Bytes that mean something in many texts.
const SIGNS: &[u8] = b"\0\xff\x7f\x80-+.,9 \n\t\"'<>()[]{}=:;#/\\eE";

/// Numbers at the edges of types, as texts.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "0.5",
    "1e39",
    "1e-320",
    "-1e308",
    "nan",
    "inf",
    "127",
    "255",
    "256",
    "32768",
    "65535",
    "65536",
    "1000000",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "18446744073709551616",
    "999999999999999999999999999999999999",
];

/// Numbers at the edges of types.
const EDGES: &[u64] = &[
    0,
    1,
    2,
    3,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0x10_0000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fff0,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX - 7,
    u64::MAX,
    // As floats: the largest, infinity, not a number, one, the least.
    0x7f7f_ffff,
    0x7f80_0000,
    0x7fc0_0000,
    0x3f80_0000,
    0x7fef_ffff_ffff_ffff,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    0x3ff0_0000_0000_0000,
];

/// Changes bytes in one to four places. `dictionary` has words of the format, `other` is a file to take parts of.
pub(crate) fn damage(bytes: &mut Vec<u8>, random: &mut Random, dictionary: &[&str], other: &[u8]) {
    let text = is_text(bytes);
    for _ in 0..1 + random.below(4) {
        if text && random.below(3) > 0 {
            damage_text(bytes, random, dictionary);
        } else {
            damage_once(bytes, random, other);
        }
    }
    bytes.truncate(LONGEST);
}

/// Whether the start of a file is text.
fn is_text(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(256)];
    let odd = head.iter().filter(|byte| !(9..127).contains(*byte)).count();
    odd * 16 <= head.len()
}

fn damage_once(bytes: &mut Vec<u8>, random: &mut Random, other: &[u8]) {
    if bytes.is_empty() {
        bytes.push(random.next() as u8);
    }
    let at = place(bytes.len(), random);
    match random.below(12) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.next() as u8,
        2 => bytes[at] = *random.one_of(SIGNS),
        3 if random.below(3) == 0 => bytes.truncate(at),
        3 | 4 => drop(bytes.drain(at..at + random.length(bytes.len() - at))),
        5 => {
            let copy = bytes[at..at + random.length(bytes.len() - at)].to_vec();
            let to = random.below(bytes.len() + 1);
            bytes.splice(to..to, copy);
        }
        6 => {
            let copy = bytes[at..at + random.length(bytes.len() - at)].to_vec();
            let to = random.below(bytes.len() - copy.len() + 1);
            bytes[to..to + copy.len()].copy_from_slice(&copy);
        }
        7 | 8 => overwrite(bytes, at, *random.one_of(EDGES), random),
        9 => {
            let width = 1 << random.below(4);
            step(&mut bytes[at..], width, random);
        }
        10 if !other.is_empty() => {
            let from = random.below(other.len());
            let part = &other[from..from + random.length(other.len() - from)];
            let end = if random.below(2) == 0 {
                at
            } else {
                (at + part.len()).min(bytes.len())
            };
            bytes.splice(at..end, part.iter().copied());
        }
        _ => {
            let end = at + random.length(bytes.len() - at);
            bytes[at..end].fill(*random.one_of(&[0, 0xff, b' ', b'0']));
        }
    }
}

/// A place in a file; starts are more likely, as headers are there.
fn place(length: usize, random: &mut Random) -> usize {
    let range = match random.below(4) {
        0 => length.min(64),
        1 => length.min(1024),
        _ => length,
    };
    random.below(range)
}

/// Writes a number in one of four widths and either order of bytes.
fn overwrite(bytes: &mut [u8], at: usize, value: u64, random: &mut Random) {
    let width = (1usize << random.below(4)).min(bytes.len() - at);
    let little = value.to_le_bytes();
    let target = &mut bytes[at..at + width];
    target.copy_from_slice(&little[..width]);
    if random.below(2) == 0 {
        target.reverse();
    }
}

/// Adds or subtracts a little.
fn step(bytes: &mut [u8], width: usize, random: &mut Random) {
    let width = width.min(bytes.len());
    let mut number = [0; 8];
    let big = random.below(2) == 0;
    let target = &mut bytes[..width];
    if big {
        target.reverse();
    }
    number[..width].copy_from_slice(target);
    let change = random.below(33) as u64;
    let changed = u64::from_le_bytes(number).wrapping_add(change).wrapping_sub(16);
    target.copy_from_slice(&changed.to_le_bytes()[..width]);
    if big {
        target.reverse();
    }
}

/// Replaces numbers and words, or moves lines.
fn damage_text(bytes: &mut Vec<u8>, random: &mut Random, dictionary: &[&str]) {
    match random.below(8) {
        0..=2 => {
            let number = *random.one_of(NUMBERS);
            replace_token(bytes, random, |byte| byte.is_ascii_digit(), number);
        }
        3 | 4 if !dictionary.is_empty() => {
            let word = *random.one_of(dictionary);
            replace_token(
                bytes,
                random,
                |byte| byte.is_ascii_alphanumeric() || *byte == b'_',
                word,
            );
        }
        5 if !dictionary.is_empty() => {
            let at = random.below(bytes.len() + 1);
            bytes.splice(at..at, random.one_of(dictionary).bytes());
        }
        6 => {
            // Swaps two tokens, so that one key has the other's value.
            let first = token(bytes, random, |byte| !byte.is_ascii_whitespace());
            let second = token(bytes, random, |byte| !byte.is_ascii_whitespace());
            if first.end <= second.start {
                let moved = bytes[first.clone()].to_vec();
                let kept = bytes[second.clone()].to_vec();
                bytes.splice(second, moved);
                bytes.splice(first, kept);
            }
        }
        _ => {
            let line = token(bytes, random, |byte| *byte != b'\n');
            let copy = bytes[line.start..(line.end + 1).min(bytes.len())].to_vec();
            if random.below(2) == 0 {
                bytes.drain(line.start..line.start + copy.len());
            } else {
                let to = token(bytes, random, |byte| *byte != b'\n').start;
                bytes.splice(to..to, copy);
            }
        }
    }
}

fn replace_token(bytes: &mut Vec<u8>, random: &mut Random, is_part: impl Fn(&u8) -> bool, by: &str) {
    let token = token(bytes, random, is_part);
    bytes.splice(token, by.bytes());
}

/// The run of bytes of a kind at or behind a random place; empty if there is none.
fn token(bytes: &[u8], random: &mut Random, is_part: impl Fn(&u8) -> bool) -> std::ops::Range<usize> {
    let at = random.below(bytes.len());
    let Some(found) = bytes[at.min(bytes.len())..].iter().position(&is_part) else {
        return at..at;
    };
    let at = at + found;
    let start = bytes[..at]
        .iter()
        .rposition(|byte| !is_part(byte))
        .map_or(0, |before| before + 1);
    let length = bytes[at..].iter().take_while(|byte| is_part(byte)).count();
    start..at + length
}
