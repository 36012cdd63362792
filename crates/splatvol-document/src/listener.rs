//! Listeners to the choices and warnings of resolving: a terminal, a notebook, a window, or nobody.

use std::any::Any;

/// Hears warnings and choices.
pub trait Listener {
    /// Something odd that did not stop the work.
    fn warn(&self, _message: &str) {}

    /// A choice that was made.
    fn detail(&self, _message: &str) {}

    /// A file is being read, until what this returns is dropped.
    fn reading(&self, _file: &str) -> Box<dyn Any> {
        Box::new(())
    }
}

/// Hears nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Listener for Silent {}
