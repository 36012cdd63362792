//! Built-in, generated sample volumes.
