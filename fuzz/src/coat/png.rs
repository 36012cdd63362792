//! PNG: chunks with their lengths and sums, and the stream of the pixels.

use super::Change;
use super::streams::{deflated, inflated};
use crate::random::Random;

const START: &[u8] = b"\x89PNG\r\n\x1a\n";

pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    let mut rest = bytes.strip_prefix(START)?;
    let mut chunks = Vec::new();
    while let Some((head, tail)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let data = tail.get(..length)?;
        chunks.push(([head[4], head[5], head[6], head[7]], data.to_vec()));
        rest = tail.get(length + 4..)?;
    }
    if chunks.is_empty() {
        return None;
    }
    let chosen = random.below(chunks.len());
    match random.below(8) {
        0 => drop(chunks.remove(chosen)),
        1 => chunks.insert(random.below(chunks.len()), chunks[chosen].clone()),
        _ => {
            let (name, data) = chunks.get_mut(chosen)?;
            match inflated(data) {
                Some(mut pixels) if &*name == b"IDAT" || &*name == b"fdAT" => {
                    change(&mut pixels, random);
                    *data = deflated(&pixels);
                }
                _ => change(data, random),
            }
        }
    }
    Some(joined(&chunks))
}

fn joined(chunks: &[([u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut file = START.to_vec();
    for (name, data) in chunks {
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(name);
        file.extend(data);
        let mut sum = flate2::Crc::new();
        sum.update(name);
        sum.update(data);
        file.extend(sum.sum().to_be_bytes());
    }
    file
}
