//! Errors of pages.

use splatvol::SceneError;

use crate::Absent;

/// Why a page cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// No engine for browsers.
    #[error(transparent)]
    Engine(#[from] Absent),
    /// Data that do not fit, whatever is left out.
    #[error("{most} bytes: the page takes {least} bytes and more: {why}")]
    TooLarge {
        /// Bytes allowed.
        most: u64,
        /// Bytes of the smallest page that was tried, or a lower bound of them.
        least: u64,
        /// What takes them.
        why: String,
    },
    /// A template whose slots are not those that are filled.
    #[error("the page's template: {0}")]
    Template(String),
    /// Compression that failed.
    #[error("the data cannot be compressed: {0}")]
    Compression(#[from] std::io::Error),
    /// A document that is no JSON.
    #[error("the document is no JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Invalid data.
    #[error(transparent)]
    Scene(#[from] SceneError),
}
