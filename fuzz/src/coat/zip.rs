//! Zip archives: one member is changed, dropped or doubled.

use std::io::{Cursor, Read, Write};

use zip::write::SimpleFileOptions;

use super::Change;
use crate::mutate::LONGEST;
use crate::random::Random;

pub(super) fn damage(bytes: &[u8], random: &mut Random, change: &mut Change<'_>) -> Option<Vec<u8>> {
    if !bytes.starts_with(b"PK\x03\x04") {
        return None;
    }
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut members = Vec::new();
    for index in 0..archive.len().min(64) {
        let mut member = archive.by_index(index).ok()?;
        let mut inside = Vec::new();
        let name = member.name().ok()?.into_owned();
        member
            .by_ref()
            .take(LONGEST as u64)
            .read_to_end(&mut inside)
            .ok()?;
        members.push((name, inside));
    }
    if members.is_empty() {
        return None;
    }
    let chosen = random.below(members.len());
    match random.below(12) {
        0 => drop(members.remove(chosen)),
        1 => {
            let other = random.below(members.len());
            members[chosen].1 = members[other].1.clone();
        }
        _ => change(&mut members.get_mut(chosen)?.1, random),
    }
    let method = match random.below(2) {
        0 => zip::CompressionMethod::Stored,
        _ => zip::CompressionMethod::Deflated,
    };
    let options = SimpleFileOptions::default().compression_method(method);
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, inside) in &members {
        writer.start_file(name.as_str(), options).ok()?;
        writer.write_all(inside).ok()?;
    }
    Some(writer.finish().ok()?.into_inner())
}
