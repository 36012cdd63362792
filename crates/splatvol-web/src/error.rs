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
    #[error("item {0} has no transfer function in the document")]
    Item(usize),
    /// A request that opens or renders, where only changes and questions are answered.
    #[error("the request is no change, and no question about a camera")]
    NoChange,
    /// A document that cannot become a picture.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// Files that cannot be read.
    #[error(transparent)]
    File(#[from] splatvol_io::IoError),
    /// Invalid data, cameras or settings.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An engine that cannot start.
    #[error(transparent)]
    Engine(#[from] EngineError),
}
