//! Errors of the server.

use splatvol::{EngineError, SceneError};
use splatvol_web::WebError;

/// Why there is no server, or a message is not answered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// A connection that cannot be made, or fails.
    #[error(transparent)]
    Connection(#[from] std::io::Error),
    /// More pixels than are drawn for a page.
    #[error("a picture for a page has at most {0} pixels")]
    TooLarge(u64),
    /// A key that a page may not change.
    #[error("a page changes no key but effects.clip-box, and visible and opacity of items")]
    Fixed,
    /// A message that is not understood.
    #[error("the message is not understood: {0}")]
    Message(#[from] serde_json::Error),
    /// A message that cannot be answered.
    #[error(transparent)]
    Answer(#[from] WebError),
    /// A size that no picture has.
    #[error(transparent)]
    Size(#[from] SceneError),
    /// An engine that cannot start.
    #[error(transparent)]
    Engine(#[from] EngineError),
}
