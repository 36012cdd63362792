//! Damage behind checksums and lengths: what wraps the bytes is taken off, what is inside is damaged, and it is wrapped
//! again. The bytes themselves say what wraps them.

mod dicom;
mod png;
mod shard;
pub(crate) use shard::crc32c;
mod spz;
mod streams;
mod vtk;
mod zip;

use crate::mutate;
use crate::random::Random;

/// Damages a file, in three of four cases inside what wraps it.
pub(crate) fn damage(bytes: &mut Vec<u8>, random: &mut Random, dictionary: &[&str], other: &[u8]) {
    let wanted = random.below(4) > 0;
    if wanted && let Some(changed) = inside(bytes, random, dictionary, other) {
        *bytes = changed;
    } else {
        mutate::damage(bytes, random, dictionary, other);
    }
}

/// The file with its inside damaged, if something known wraps it.
fn inside(bytes: &[u8], random: &mut Random, dictionary: &[&str], other: &[u8]) -> Option<Vec<u8>> {
    let mut change =
        |part: &mut Vec<u8>, random: &mut Random| mutate::damage(part, random, dictionary, other);
    let coats: [Coat; 7] = [
        png::damage,
        zip::damage,
        dicom::damage,
        spz::damage,
        vtk::damage,
        shard::damage,
        streams::damage,
    ];
    coats.iter().find_map(|coat| coat(bytes, random, &mut change))
}

/// Damages a part.
type Change<'a> = dyn FnMut(&mut Vec<u8>, &mut Random) + 'a;
/// Takes one wrapping off, changes the inside, and wraps it again; `None` if the bytes are not wrapped so.
type Coat = fn(&[u8], &mut Random, &mut Change<'_>) -> Option<Vec<u8>>;
