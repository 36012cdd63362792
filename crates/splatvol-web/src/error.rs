//! Errors of messages.

use splatvol::{EngineError, SceneError};
use splatvol_document::DocumentError;

/// Why a message cannot be answered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WebError {
    /// A header that is no message.
    #[error("the message is not understood: {0}")]
    Header(#[from] serde_json::Error),
    /// Bytes that are not the samples that the header describes.
    #[error("the data of item {item}: {why}")]
    Data {
        /// Number of the item.
        item: usize,
        /// The fault.
        why: String,
    },
    /// A question about a document before one was opened.
    #[error("no document is open")]
    Closed,
    /// An item that is not there, or has no transfer function.
    #[error("item {0} is no volume of the document")]
    Item(usize),
    /// More pixels than are drawn for a page.
    #[error("a picture for a page has at most {0} pixels")]
    TooLarge(u64),
    /// A key that a page may not change.
    #[error("a page changes no key but {0}")]
    Fixed(&'static str),
    /// A connection that cannot be made, or fails.
    #[error(transparent)]
    Connection(#[from] std::io::Error),
    /// A document that cannot become a picture.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// Invalid data, cameras or settings.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An engine that cannot start.
    #[error(transparent)]
    Engine(#[from] EngineError),
}
