//! Archives of arrays (.npz): a zip file with one .npy file per array, stored or deflated.

use std::borrow::Cow;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use zip::ZipArchive;
use zip::result::ZipError;

use super::header::Header;
use crate::IoError;
use crate::error::Context;
use crate::files::File;
use crate::source::Source;
use crate::volume::{Loaded, Opened, ReadOptions};

/// Reads one array of a .npz file: [`ReadOptions::array`], else the first with three axes, else the only one.
///
/// # Errors
/// A corrupt archive, no such array, or as for a .npy file.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    with(path, options, |source, header, context| {
        super::samples(source, header, "NPZ".to_owned(), options, context)
    })
}

/// Unpacks the array that [`read`] reads, if that is allowed.
///
/// # Errors
/// As [`read`].
pub(in crate::volume) fn open(path: &Path, options: &ReadOptions) -> Result<Option<Opened>, IoError> {
    with(path, options, |source, header, context| {
        super::unpacked(source, header, "NPZ".to_owned(), options, context)
    })
}

/// Passes the bytes of an array on, which follow its header.
fn with<T>(
    path: &Path,
    options: &ReadOptions,
    then: impl FnOnce(Source<'_>, &Header, &Context<'_>) -> Result<T, IoError>,
) -> Result<T, IoError> {
    let context = &Context::new("NPZ", path);
    // Refuses anything but a regular file.
    Source::open(path)?;
    let file = File::open(path).map_err(|source| IoError::Open {
        source,
        path: path.to_owned(),
    })?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|error| corrupt(error, context))?;
    let index = choose(&mut archive, options.array.as_deref(), context)?;
    let mut source = entry(&mut archive, index, context)?;
    let header = Header::read(&mut source, context)?;
    then(source, &header, context)
}

/// The decompressed bytes of an entry; its length and checksum are checked against the archive's directory.
fn entry<'a, R: Read + Seek>(
    archive: &'a mut ZipArchive<R>,
    index: usize,
    context: &Context<'_>,
) -> Result<Source<'a>, IoError> {
    let entry = archive.by_index(index).map_err(|error| corrupt(error, context))?;
    let (compressed, size) = (entry.compressed_size(), entry.size());
    Ok(Source::from_decoder(entry, compressed, size))
}

fn choose<R: Read + Seek>(
    archive: &mut ZipArchive<R>,
    wanted: Option<&str>,
    context: &Context<'_>,
) -> Result<usize, IoError> {
    let mut arrays = Vec::new();
    for index in 0..archive.len() {
        let file = archive
            .by_index_data(index)
            .map_err(|error| corrupt(error, context))?;
        let name = file.name().unwrap_or(Cow::Borrowed("")).into_owned();
        if let Some(array) = name.strip_suffix(".npy") {
            arrays.push((index, array.to_owned()));
        }
    }
    if let Some(wanted) = wanted {
        let wanted = wanted.strip_suffix(".npy").unwrap_or(wanted);
        let found = arrays.iter().find(|(_, name)| name == wanted);
        return found.map(|(index, _)| *index).ok_or_else(|| {
            let names = arrays.iter().map(|(_, name)| name.clone());
            context.unsupported(format!("no array `{wanted}`; there is {}", list(names)))
        });
    }
    if let [(index, _)] = arrays[..] {
        return Ok(index);
    }
    let mut shapes = Vec::new();
    for (index, name) in &arrays {
        match entry(archive, *index, context).and_then(|mut source| Header::read(&mut source, context)) {
            Ok(header) if header.shape.len() == 3 => return Ok(*index),
            Ok(header) => shapes.push(format!("{name} {}", header.shape_text())),
            Err(_) => shapes.push(format!("{name} (not readable)")),
        }
    }
    let shapes = list(shapes.into_iter());
    Err(context.unsupported(format!("no array with three axes; there is {shapes}")))
}

fn list(mut names: impl Iterator<Item = String>) -> String {
    const SHOWN: usize = 20;
    let shown: Vec<String> = names.by_ref().take(SHOWN).collect();
    match (shown.is_empty(), names.count()) {
        (true, _) => "none".to_owned(),
        (_, 0) => shown.join(", "),
        (_, more) => format!("{}, {more} more", shown.join(", ")),
    }
}

fn corrupt(error: ZipError, context: &Context<'_>) -> IoError {
    match error {
        ZipError::Io(error) => context.read(error),
        ZipError::UnsupportedArchive(what) => context.unsupported(what),
        other => context.field("zip archive", other, None, "an intact zip archive"),
    }
}
