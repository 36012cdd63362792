//! The document as text: TOML, JSON, and the text in a PNG, which is JSON.
//!
//! All three hold the same keys, and numbers come back bit for bit. Unknown keys are refused, so that a misspelt one is
//! not silently ignored. Version 1 is still read: scene files whose `[settings]` have values with parts, and pictures
//! of splatvol before the document.

mod files;
mod message;
mod paths;

use std::path::Path;

use serde::Deserialize;
use splatvol_io::image::metadata;

use crate::{Document, DocumentError, VERSION, version1};
pub use files::{is_scene, read_scene};
pub use paths::{path_outside, shortened};

/// A document, and the command line that made its picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// The document, with nothing left open.
    pub document: Document,
    /// The command line, or another program's description of itself.
    pub command: String,
}

impl Document {
    /// The document as TOML, with its version first.
    ///
    /// # Errors
    /// Numbers that TOML cannot hold: integers above 2^63 - 1.
    pub fn to_toml(&self) -> Result<String, DocumentError> {
        toml::to_string_pretty(self)
            .map_err(|error| DocumentError::usage(format!("the document is no TOML: {error}")))
    }

    /// The document as JSON; if `pretty`, in lines for a person to read.
    ///
    /// # Errors
    /// Never for documents whose numbers are finite.
    pub fn to_json(&self, pretty: bool) -> Result<String, DocumentError> {
        let text = match pretty {
            true => serde_json::to_string_pretty(self),
            false => serde_json::to_string(self),
        };
        text.map_err(|error| DocumentError::usage(format!("the document is no JSON: {error}")))
    }

    /// Reads TOML; `path` is named in errors.
    ///
    /// # Errors
    /// Malformed text, unknown keys, wrong values, with their line; later versions.
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, DocumentError> {
        // TOML has infinities and NaN. No key takes them, and JSON could not hold them.
        if let Some(key) = toml::from_str(text).ok().and_then(|table| endless_number(&table)) {
            return Err(DocumentError::Malformed {
                path: path.to_owned(),
                message: format!("{key}: expected a finite number"),
            });
        }
        let read = |text| toml::from_str::<Self>(text).map_err(|error| message::of_toml(&error, text));
        let old = |text| version1::scene(toml::from_str(text).ok()?);
        Self::versioned(path, toml::from_str(text).ok(), || read(text), || old(text))
    }

    /// Reads JSON; `path` is named in errors.
    ///
    /// # Errors
    /// See [`Document::from_toml`].
    pub fn from_json(text: &str, path: &Path) -> Result<Self, DocumentError> {
        let read = |text| serde_json::from_str::<Self>(text).map_err(|error| message::of_json(&error));
        let old = |text| version1::scene(serde_json::from_str(text).ok()?);
        Self::versioned(path, serde_json::from_str(text).ok(), || read(text), || old(text))
    }

    /// Reads text of this version in one form or the other. Text without a version has the current form unless only the
    /// former one fits.
    fn versioned(
        path: &Path,
        version: Option<Version>,
        read: impl Fn() -> Result<Self, String>,
        old: impl Fn() -> Option<Self>,
    ) -> Result<Self, DocumentError> {
        let malformed = |message| DocumentError::Malformed {
            path: path.to_owned(),
            message,
        };
        match version.and_then(|found| found.version) {
            Some(later) if later > VERSION => Err(malformed(format!(
                "version = {later}: expected 1 or {VERSION}; a later splatvol made it"
            ))),
            Some(VERSION) => read().map_err(malformed),
            _ => match read() {
                Ok(document) => Ok(Self {
                    version: VERSION,
                    ..document
                }),
                Err(message) => old().ok_or_else(|| malformed(message)),
            },
        }
    }
}

/// The first key whose number is not finite, with that number: `item[0].translate = NaN`.
fn endless_number(table: &toml::Table) -> Option<String> {
    fn of_value(value: &toml::Value) -> Option<String> {
        match value {
            toml::Value::Float(number) if !number.is_finite() => Some(format!(" = {number}")),
            toml::Value::Array(values) => values.iter().enumerate().find_map(|(i, value)| match value {
                toml::Value::Table(_) => of_value(value).map(|rest| format!("[{i}]{rest}")),
                _ => of_value(value),
            }),
            toml::Value::Table(table) => endless_number(table).map(|key| format!(".{key}")),
            _ => None,
        }
    }
    table
        .iter()
        .find_map(|(key, value)| of_value(value).map(|rest| format!("{key}{rest}")))
}

/// The version that a text names, whatever else it holds.
#[derive(Deserialize)]
struct Version {
    version: Option<u32>,
}

impl Record {
    /// Keywords and texts for a picture's file.
    ///
    /// # Errors
    /// See [`Document::to_json`].
    pub fn metadata(&self) -> Result<Vec<(String, String)>, DocumentError> {
        let settings = self.document.to_json(false)?;
        Ok(vec![
            (
                metadata::SOFTWARE.to_owned(),
                concat!("splatvol ", env!("CARGO_PKG_VERSION")).to_owned(),
            ),
            (metadata::COMMENT.to_owned(), self.command.clone()),
            (metadata::SETTINGS.to_owned(), settings),
        ])
    }

    /// The record that a picture carries.
    ///
    /// # Errors
    /// Pictures that cannot be read, that say nothing, or that a later version made.
    pub fn of_picture(path: &Path) -> Result<Self, DocumentError> {
        Self::of_metadata(&crate::files::read_image_metadata(path)?, path)
    }

    /// The record in a picture's texts.
    ///
    /// # Errors
    /// See [`Record::of_picture`].
    pub fn of_metadata(texts: &[(String, String)], path: &Path) -> Result<Self, DocumentError> {
        let malformed = |message: String| DocumentError::Malformed {
            path: path.to_owned(),
            message,
        };
        let Some(text) = metadata::find(texts, metadata::SETTINGS) else {
            return Err(malformed(
                "the picture does not say how it was made (splatvol did not write it, or another program saved it again)"
                    .to_owned(),
            ));
        };
        if let Some(record) = version1::recipe(text) {
            return record.map_err(malformed);
        }
        Ok(Self {
            document: Document::from_json(text, path)?,
            command: metadata::find(texts, metadata::COMMENT)
                .unwrap_or_default()
                .to_owned(),
        })
    }
}
