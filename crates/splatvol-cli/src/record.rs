//! The record that a picture carries: its document, and the command line that made it.

use std::ffi::OsString;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use splatvol_document::format::shortened;
use splatvol_document::{Document, Record};

use crate::failure::{During, Failure, Step};

/// The record of an earlier picture.
pub(crate) fn of_picture(path: &Path) -> Result<Record, Failure> {
    Record::of_picture(path)
        .with_context(|| format!("cannot take settings from {}", path.display()))
        .during(Step::Input)
}

/// The record of a picture of this process, for a file in a folder. A picture made by `--like` alone is the same picture, with the
/// same record.
pub(crate) fn of(document: Document, earlier: Option<&Record>, folder: &Path) -> Record {
    match earlier.filter(|earlier| earlier.document == document) {
        Some(earlier) => earlier.clone(),
        None => Record {
            document,
            command: command_line(folder),
        }
        .shortened(folder),
    }
}

/// The command line that runs: the process's, or, if another program runs several, the last one.
static COMMAND_LINE: Mutex<Vec<OsString>> = Mutex::new(Vec::new());

/// Remembers the command line that runs; the program's name comes first.
pub(crate) fn set_command_line(arguments: Vec<OsString>) {
    *COMMAND_LINE.lock().unwrap_or_else(PoisonError::into_inner) = arguments;
}

/// An argument, or the value after its equals sign, with an absolute path shortened as in the document.
fn without_root(argument: &str, folder: &Path) -> String {
    match argument
        .split_once('=')
        .filter(|(flag, _)| flag.starts_with("--"))
    {
        Some((flag, value)) => format!("{flag}={}", shortened(value, folder)),
        None => shortened(argument, folder),
    }
}

/// The command line that runs, quoted so that a POSIX shell reproduces it.
pub(crate) fn command_line(folder: &Path) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@%#".contains(c);
    let quote = |arg: String| {
        if !arg.is_empty() && arg.chars().all(plain) {
            arg
        } else {
            format!("'{}'", arg.replace('\'', "'\\''"))
        }
    };
    let arguments = COMMAND_LINE.lock().unwrap_or_else(PoisonError::into_inner);
    let args = arguments
        .iter()
        .skip(1)
        .map(|arg| quote(without_root(&arg.to_string_lossy(), folder)));
    std::iter::once("splatvol".to_owned())
        .chain(args)
        .collect::<Vec<_>>()
        .join(" ")
}
