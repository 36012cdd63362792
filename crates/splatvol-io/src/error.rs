//! The one error type of this crate, and the small context that parsers use to fill it.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use splatvol_scene::{SceneError, SourceError};

use crate::ReadOptions;

/// Longest excerpt of a bad value that a message repeats.
const SHOWN: usize = 80;

/// Why a file cannot be read or written. The text names the field, its value, its offset, and last the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The file cannot be opened or read at all.
    #[error("cannot read: {source}, in {path}", path = path.display())]
    Open {
        /// Error of the operating system.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
    /// A field of the file is malformed or contradicts another.
    #[error(transparent)]
    Format(#[from] Box<FormatError>),
    /// A link leads out of the folder of the file or folder that is read.
    #[error("{link} leads out of its folder, to {target}, in {path}",
            link = link.display(), target = target.display(), path = path.display())]
    Outside {
        /// The link.
        link: PathBuf,
        /// Where it leads.
        target: PathBuf,
        /// The folder, or the header that names the link.
        path: PathBuf,
    },
    /// A header names a data file that does not exist.
    #[error("data file {data} does not exist, named in {path}", data = data.display(), path = path.display())]
    MissingDataFile {
        /// The absent file.
        data: PathBuf,
        /// The header that names it.
        path: PathBuf,
    },
    /// The file holds fewer data than its header declares.
    #[error("{format}: {what} need {expected} bytes, found {qualifier}{found}, in {path}",
            qualifier = if *at_most { "at most " } else { "" }, path = path.display())]
    Truncated {
        /// Format of the file.
        format: &'static str,
        /// The truncated part: "data", "header".
        what: &'static str,
        /// Bytes that the header declares.
        expected: u64,
        /// Bytes that are there.
        found: u64,
        /// True where `found` is the most that compressed data of this length could hold.
        at_most: bool,
        /// The file.
        path: PathBuf,
    },
    /// Compressed data are corrupt.
    #[error("{format}: corrupt compressed data ({source}), in {path}", path = path.display())]
    Corrupt {
        /// Format of the file.
        format: &'static str,
        /// Error of the decoder.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
    /// A chunk of a volume cannot be read.
    #[error("{format}: {source}, in {path}", path = path.display())]
    Chunk {
        /// Format of the file.
        format: &'static str,
        /// Place and cause.
        source: SourceError,
        /// The file, or the folder.
        path: PathBuf,
    },
    /// A legal file that this crate does not read, or a volume that a format cannot hold.
    #[error("{format}: {what}, in {path}", path = path.display())]
    Unsupported {
        /// Format of the file.
        format: &'static str,
        /// The unsupported feature, and what to do instead.
        what: String,
        /// The file.
        path: PathBuf,
    },
    /// The contents are well-formed but do not make a valid scene part.
    #[error("{source}, in {path}", path = path.display())]
    Scene {
        /// The field that is wrong.
        source: SceneError,
        /// The file.
        path: PathBuf,
    },
    /// More memory is needed than allowed or available.
    #[error("{expected} bytes are needed, the limit is {limit}, in {path}", path = path.display())]
    Limit {
        /// Bytes that the contents need.
        expected: u64,
        /// Bytes allowed, or free.
        limit: u64,
        /// The file.
        path: PathBuf,
    },
    /// Reading was strict and the file gave rise to a warning.
    #[error("strict reading: {warning}, in {path}", path = path.display())]
    Strict {
        /// All warnings, joined by "; ".
        warning: String,
        /// The file.
        path: PathBuf,
    },
    /// The data to be written do not fit the format.
    #[error("cannot encode {format}: {what}")]
    Encode {
        /// Format of the file.
        format: &'static str,
        /// The data that do not fit, or the encoder's message.
        what: String,
    },
    /// The output cannot be written.
    #[error("cannot write: {source}, to {path}", path = path.display())]
    Write {
        /// Error of the operating system or of the encoder.
        source: std::io::Error,
        /// The file.
        path: PathBuf,
    },
}

/// A malformed field: `NRRD header, field "sizes" = "10 x 3" (byte 57): expected 3 positive integers, in a.nrrd`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{format}, field \"{field}\" = \"{value}\"{at}: expected {expected}, in {path}",
        at = offset.map_or_else(String::new, |offset| format!(" (byte {offset})")), path = path.display())]
pub struct FormatError {
    /// Format and part: "NRRD header".
    pub format: &'static str,
    /// Name of the field, as the format's specification has it.
    pub field: String,
    /// The offending value (its start, where it is long).
    pub value: String,
    /// Accepted values.
    pub expected: String,
    /// Position of the field or its line in the (decompressed) file, bytes.
    pub offset: Option<u64>,
    /// The file.
    pub path: PathBuf,
}

/// Context of a parser: its errors name format and path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Context<'a> {
    /// Format and part: "NRRD header".
    pub(crate) format: &'static str,
    /// The file.
    pub(crate) path: &'a Path,
    /// Whether links that lead out of the file's folder are followed.
    pub(crate) allow_outside: bool,
}

impl<'a> Context<'a> {
    /// Links that lead out of the file's folder are refused.
    pub(crate) fn new(format: &'static str, path: &'a Path) -> Self {
        Self {
            format,
            path,
            allow_outside: false,
        }
    }

    /// Links that lead out of the file's folder are followed where the options say so.
    pub(crate) fn following(self, options: &ReadOptions) -> Self {
        Self {
            allow_outside: options.allow_outside,
            ..self
        }
    }

    /// A malformed field. `expected` completes "expected ...".
    pub(crate) fn field(
        &self,
        field: impl Into<String>,
        value: impl Display,
        offset: impl Into<Option<u64>>,
        expected: impl Into<String>,
    ) -> IoError {
        Box::new(FormatError {
            format: self.format,
            field: field.into(),
            value: excerpt(&value.to_string()),
            expected: expected.into(),
            offset: offset.into(),
            path: self.path.to_owned(),
        })
        .into()
    }

    pub(crate) fn unsupported(&self, what: impl Into<String>) -> IoError {
        IoError::Unsupported {
            format: self.format,
            what: what.into(),
            path: self.path.to_owned(),
        }
    }

    pub(crate) fn truncated(&self, what: &'static str, expected: u64, found: u64) -> IoError {
        IoError::Truncated {
            format: self.format,
            what,
            expected,
            found,
            at_most: false,
            path: self.path.to_owned(),
        }
    }

    /// Compressed data that are too short to hold what the header declares.
    pub(crate) fn too_small(&self, what: &'static str, expected: u64, at_most: u64) -> IoError {
        IoError::Truncated {
            format: self.format,
            what,
            expected,
            found: at_most,
            at_most: true,
            path: self.path.to_owned(),
        }
    }

    pub(crate) fn scene(&self, source: SceneError) -> IoError {
        IoError::Scene {
            source,
            path: self.path.to_owned(),
        }
    }

    pub(crate) fn chunk(&self, source: SourceError) -> IoError {
        IoError::Chunk {
            format: self.format,
            source,
            path: self.path.to_owned(),
        }
    }

    pub(crate) fn limit(&self, expected: u64, limit: u64) -> IoError {
        IoError::Limit {
            expected,
            limit,
            path: self.path.to_owned(),
        }
    }

    /// An error while bytes were read: from the decoder (corrupt data) or from the operating system.
    pub(crate) fn read(&self, source: std::io::Error) -> IoError {
        let path = self.path.to_owned();
        if source.raw_os_error().is_some() {
            IoError::Open { source, path }
        } else {
            let format = self.format;
            IoError::Corrupt { format, source, path }
        }
    }
}

/// The start of a value, with control characters escaped, for messages.
pub(crate) fn excerpt(value: &str) -> String {
    let mut shown: String = value.chars().take(SHOWN).flat_map(char::escape_debug).collect();
    if value.chars().nth(SHOWN).is_some() {
        shown.push_str("...");
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_names_field_value_offset_and_path_last() {
        let context = Context::new("NRRD header", Path::new("/data/a.nrrd"));
        let error = context.field("sizes", "10 x 3", 57, "3 positive integers");
        assert_eq!(
            error.to_string(),
            "NRRD header, field \"sizes\" = \"10 x 3\" (byte 57): expected 3 positive integers, in /data/a.nrrd"
        );
        let error = context.truncated("data", 100, 7);
        assert_eq!(
            error.to_string(),
            "NRRD header: data need 100 bytes, found 7, in /data/a.nrrd"
        );
    }

    #[test]
    fn long_values_are_cut() {
        assert_eq!(excerpt(&"x".repeat(100)), format!("{}...", "x".repeat(80)));
        assert_eq!(excerpt("a\nb\u{0}"), "a\\nb\\0");
    }
}
