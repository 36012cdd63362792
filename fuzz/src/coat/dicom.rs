//! DICOM: elements of little-endian data sets. One is changed, its length still right; or it lies about its length,
//! changes its kind or tag, is dropped or doubled.

use super::Change;
use crate::random::Random;

/// Bytes before the first element.
const PREAMBLE: usize = 132;
/// Kinds of values.
const KINDS: [&[u8; 2]; 14] = [
    b"US", b"SS", b"UL", b"FD", b"FL", b"DS", b"IS", b"CS", b"UI", b"LO", b"SQ", b"OB", b"OW", b"UN",
];

struct Element {
    tag: [u8; 4],
    /// `None`: implicit.
    kind: Option<[u8; 2]>,
    /// The length that is written, where it is not the value's.
    length: Option<u32>,
    value: Vec<u8>,
}

impl Element {
    fn is_long(kind: [u8; 2]) -> bool {
        [
            b"OB", b"OW", b"OF", b"OD", b"OL", b"SQ", b"UC", b"UN", b"UR", b"UT",
        ]
        .contains(&&kind)
    }

    /// The element at the start of these bytes, and what is behind it.
    fn split(bytes: &[u8], explicit: bool) -> Option<(Self, &[u8])> {
        let (tag, rest) = bytes.split_first_chunk::<4>()?;
        let is_item = tag[..2] == [0xfe, 0xff];
        let kind = (explicit && !is_item).then(|| rest.first_chunk::<2>().copied());
        let (length, rest) = match kind {
            Some(kind) if Self::is_long(kind?) => long(rest.get(4..)?)?,
            Some(_) => {
                let (length, rest) = rest.get(2..)?.split_first_chunk::<2>()?;
                (u32::from(u16::from_le_bytes(*length)), rest)
            }
            None => long(rest)?,
        };
        // What has no length of its own lasts to the end: its items are inside.
        let end = if length == u32::MAX {
            rest.len()
        } else {
            length as usize
        };
        let element = Self {
            tag: *tag,
            kind: kind.flatten(),
            length: (length == u32::MAX).then_some(length),
            value: rest.get(..end)?.to_vec(),
        };
        Some((element, &rest[end..]))
    }

    fn bytes(&self) -> Vec<u8> {
        let length = self.length.unwrap_or(self.value.len() as u32);
        let mut bytes = self.tag.to_vec();
        match self.kind {
            Some(kind) if Self::is_long(kind) => {
                bytes.extend(kind);
                bytes.extend([0, 0]);
                bytes.extend(length.to_le_bytes());
            }
            Some(kind) => {
                bytes.extend(kind);
                bytes.extend((length as u16).to_le_bytes());
            }
            None => bytes.extend(length.to_le_bytes()),
        }
        bytes.extend(&self.value);
        bytes
    }
}

fn long(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    Some((u32::from_le_bytes(*length), rest))
}

pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    if bytes.get(128..PREAMBLE)? != b"DICM" {
        return None;
    }
    let mut rest = &bytes[PREAMBLE..];
    let mut elements = Vec::new();
    while !rest.is_empty() {
        // Group 2 is always explicit; behind it two capitals tell.
        let explicit = rest.get(4..6)?.iter().all(u8::is_ascii_uppercase);
        let (element, behind) = Element::split(rest, explicit)?;
        elements.push(element);
        rest = behind;
    }
    if elements.is_empty() {
        return None;
    }
    damage_elements(&mut elements, random, change);
    let body: Vec<u8> = elements.iter().flat_map(Element::bytes).collect();
    Some([&bytes[..PREAMBLE], &body].concat())
}

fn damage_elements(elements: &mut Vec<Element>, random: &mut Random, change: &mut Change<'_>) {
    let chosen = random.below(elements.len());
    match random.below(16) {
        0 => drop(elements.remove(chosen)),
        1 => {
            let bytes = elements[chosen].bytes();
            let copy = Element::split(&bytes, elements[chosen].kind.is_some());
            elements.extend(copy.map(|(element, _)| element));
        }
        2 => {
            let other = random.below(elements.len());
            if let Some(tag) = elements.get(other).map(|element| element.tag) {
                elements[chosen].tag = tag;
            }
        }
        what => {
            let Some(element) = elements.get_mut(chosen) else {
                return;
            };
            match what {
                3 => element.length = Some(random.next() as u32 >> random.below(32)),
                4 => element.kind = element.kind.map(|_| **random.one_of(&KINDS)),
                5 => element.value = inside_items(&element.value, random, change),
                6 => change_number(&mut element.value, random),
                _ => change(&mut element.value, random),
            }
            if element.value.len() % 2 == 1 {
                element.value.push(b' ');
            }
        }
    }
}

/// Short values are mostly numbers of 16 bits: one that matters.
fn change_number(value: &mut [u8], random: &mut Random) {
    let number = *random.one_of(&[0u16, 1, 2, 3, 7, 8, 12, 16, 32, 255, 256, 0x7fff, 0xffff]);
    if let Some(word) = value.first_chunk_mut::<2>() {
        *word = number.to_le_bytes();
    }
}

/// Changes the first item of a sequence, and its length with it.
fn inside_items(value: &[u8], random: &mut Random, change: &mut Change<'_>) -> Vec<u8> {
    let Some((mut item, rest)) = Element::split(value, false) else {
        return value.to_vec();
    };
    change(&mut item.value, random);
    [item.bytes(), rest.to_vec()].concat()
}
