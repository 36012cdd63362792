//! The record that a picture carries: its document, and the command line that made it.

use std::path::Path;

use anyhow::Context;
use splatvol_document::{Document, Record};

use crate::failure::{During, Failure, Step};

/// The record of an earlier picture.
pub(crate) fn of_picture(path: &Path) -> Result<Record, Failure> {
    Record::of_picture(path)
        .with_context(|| format!("cannot take settings from {}", path.display()))
        .during(Step::Input)
}

/// The record of a picture of this process. One made by `--like` alone is the same picture, and says the same.
pub(crate) fn of(document: Document, earlier: Option<&Record>) -> Record {
    match earlier.filter(|earlier| earlier.document == document) {
        Some(earlier) => earlier.clone(),
        None => Record {
            document,
            command: command_line(),
        },
    }
}

/// This process's command line, quoted so that a POSIX shell gives it back.
fn command_line() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@%#".contains(c);
    let quote = |arg: String| {
        if !arg.is_empty() && arg.chars().all(plain) {
            arg
        } else {
            format!("'{}'", arg.replace('\'', "'\\''"))
        }
    };
    let args = std::env::args_os()
        .skip(1)
        .map(|arg| quote(arg.to_string_lossy().into_owned()));
    std::iter::once("splatvol".to_owned())
        .chain(args)
        .collect::<Vec<_>>()
        .join(" ")
}
