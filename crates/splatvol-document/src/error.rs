//! Errors of documents: which key, which file, and why.

use std::path::PathBuf;

use splatvol_io::IoError;
use splatvol_samples::SampleError;
use splatvol_scene::SceneError;

/// Why a document cannot become a picture.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    /// A key that has no meaning, or a value outside its domain. Keys in the message are between backquotes, with the
    /// table that they are in: `` `settings.filter` ``.
    #[error("{}{}", .message.replace('`', ""), .context.as_ref().map_or_else(String::new, |of| format!(" ({of})")))]
    Refused {
        /// The message.
        message: String,
        /// Item or file that it is about.
        context: Option<String>,
        /// A remedy.
        hint: Option<String>,
    },
    /// Text that is not a document.
    #[error("{}: {message}", path.display())]
    Malformed {
        /// The file that holds it.
        path: PathBuf,
        /// The fault, and its line.
        message: String,
    },
    /// A file that cannot be read.
    #[error("{error}")]
    Input {
        /// Why.
        error: Box<IoError>,
        /// A remedy.
        hint: Option<String>,
    },
    /// A built-in sample that does not exist, or not in this size.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// Invalid data, cameras or settings.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl From<IoError> for DocumentError {
    fn from(error: IoError) -> Self {
        Self::Input {
            error: Box::new(error),
            hint: None,
        }
    }
}

impl DocumentError {
    /// A message that names keys between backquotes.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Refused {
            message: message.into(),
            context: None,
            hint: None,
        }
    }

    /// A key, with its table, and why it is refused: the rest of a sentence that begins with the key, or one after a colon.
    pub fn refused(key: &str, why: impl AsRef<str>) -> Self {
        let why = why.as_ref();
        let gap = if why.starts_with(':') { "" } else { " " };
        Self::usage(format!("`{key}`{gap}{why}"))
    }

    /// The same, of an item's file.
    #[must_use]
    pub fn of_item(self, file: &str) -> Self {
        match self {
            Self::Refused { message, hint, .. } => Self::Refused {
                message,
                context: Some(file.to_owned()),
                hint,
            },
            other => other,
        }
    }

    /// The same, with what to do about it.
    #[must_use]
    pub fn hinting(self, hint: impl Into<String>) -> Self {
        match self {
            Self::Refused { message, context, .. } => Self::Refused {
                message,
                context,
                hint: Some(hint.into()),
            },
            Self::Input { error, .. } => Self::Input {
                error,
                hint: Some(hint.into()),
            },
            other => other,
        }
    }

    /// The same, of the item with this number: `item.` becomes `item[3].`.
    #[must_use]
    pub fn of_index(self, index: usize) -> Self {
        match self {
            Self::Refused {
                message,
                context,
                hint,
            } => Self::Refused {
                message: message
                    .replace("`item.point-opacity`", "`item.opacity`")
                    .replace("`item.", &format!("`item[{index}].")),
                context,
                hint,
            },
            other => other,
        }
    }
}
