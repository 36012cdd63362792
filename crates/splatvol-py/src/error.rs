//! Rust's errors as the exceptions of the package, which Python defines: their message, and path, field and value apart.

use std::io::ErrorKind;
use std::path::Path;

use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use splatvol::{EngineError, SceneError};
use splatvol_document::DocumentError;
use splatvol_io::IoError;
use splatvol_page::PageError;

/// An exception of the package, by its name, with what is known about it as attributes.
struct Exception {
    class: &'static str,
    message: String,
    fields: Vec<(&'static str, String)>,
}

impl Exception {
    fn new(class: &'static str, message: impl ToString) -> Self {
        Self {
            class,
            message: message.to_string(),
            fields: Vec::new(),
        }
    }

    fn with(mut self, field: &'static str, value: impl ToString) -> Self {
        self.fields.push((field, value.to_string()));
        self
    }

    fn at(self, path: &Path) -> Self {
        self.with("path", path.display())
    }

    fn raised(self) -> PyErr {
        let made = |py: Python<'_>| {
            let class = py.import("splatvol._errors")?.getattr(self.class)?;
            let fields = PyDict::new(py);
            for (name, value) in &self.fields {
                fields.set_item(name, value)?;
            }
            Ok(PyErr::from_value(class.call((&self.message,), Some(&fields))?))
        };
        Python::attach(|py| made(py).unwrap_or_else(|error: PyErr| error))
    }
}

/// What can become an exception of the package.
pub(crate) trait Raise {
    /// The exception.
    fn raised(self) -> PyErr;
}

impl Raise for DocumentError {
    fn raised(self) -> PyErr {
        let message = self.to_string();
        match self {
            Self::Refused {
                message: marked,
                hint,
                ..
            } => {
                let text = match hint {
                    Some(hint) => format!("{message}; {hint}"),
                    None => message,
                };
                let error = Exception::new("InvalidValue", text);
                match marked.split('`').nth(1) {
                    Some(key) => error.with("field", key).raised(),
                    None => error.raised(),
                }
            }
            Self::Malformed { path, .. } => Exception::new("FormatError", message).at(&path).raised(),
            Self::Input { error, hint } => match (*error, hint) {
                (IoError::Unsupported { path, .. }, Some(hint)) => {
                    Exception::new("FormatError", format!("{message}; {hint}"))
                        .at(&path)
                        .raised()
                }
                (error, _) => error.raised(),
            },
            Self::Sample(_) => Exception::new("InvalidValue", message)
                .with("field", "item.file")
                .raised(),
            Self::Scene(error) => error.raised(),
        }
    }
}

impl Raise for IoError {
    fn raised(self) -> PyErr {
        let message = self.to_string();
        let number = |error: &std::io::Error| error.raw_os_error().unwrap_or_default();
        match self {
            Self::Open { source, path } => {
                let arguments = (number(&source), source.to_string(), path);
                match source.kind() {
                    ErrorKind::NotFound => PyFileNotFoundError::new_err(arguments),
                    _ => PyOSError::new_err(arguments),
                }
            }
            Self::Write { source, path } => PyOSError::new_err((number(&source), source.to_string(), path)),
            Self::Format(error) => {
                let raised = Exception::new("FormatError", message)
                    .at(&error.path)
                    .with("field", &error.field)
                    .with("value", &error.value)
                    .with("expected", &error.expected);
                match error.offset {
                    Some(offset) => raised.with("offset", offset).raised(),
                    None => raised.raised(),
                }
            }
            Self::Limit { path, .. } => Exception::new("LimitError", message).at(&path).raised(),
            Self::Encode { .. } => Exception::new("InvalidValue", message).raised(),
            Self::MissingDataFile { path, .. }
            | Self::Truncated { path, .. }
            | Self::Corrupt { path, .. }
            | Self::Unsupported { path, .. }
            | Self::Scene { path, .. }
            | Self::Strict { path, .. } => Exception::new("FormatError", message).at(&path).raised(),
            error => Exception::new("FormatError", error).raised(),
        }
    }
}

impl Raise for SceneError {
    fn raised(self) -> PyErr {
        let message = self.to_string();
        match self {
            Self::InvalidField { field, value, .. } => Exception::new("InvalidValue", message)
                .with("field", field)
                .with("value", value)
                .raised(),
            Self::Stopped => Exception::new("Cancelled", message).raised(),
            Self::Combination { .. } => Exception::new("Combination", message).raised(),
            _ => Exception::new("InvalidValue", message).raised(),
        }
    }
}

impl Raise for EngineError {
    fn raised(self) -> PyErr {
        Exception::new("InvalidValue", self).raised()
    }
}

impl Raise for PageError {
    fn raised(self) -> PyErr {
        Exception::new("InvalidValue", self).raised()
    }
}

impl Raise for serde_json::Error {
    fn raised(self) -> PyErr {
        Exception::new("InvalidValue", self).raised()
    }
}

/// A value that is refused, by the name that users know.
pub(crate) fn refused(field: &'static str, message: impl ToString) -> PyErr {
    Exception::new("InvalidValue", message)
        .with("field", field)
        .raised()
}

/// A panic, which is a bug here: an exception that `except Exception` sees.
pub(crate) fn panicked(reason: &(dyn std::any::Any + Send)) -> PyErr {
    let text = reason.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| reason.downcast_ref::<&str>().copied());
    match text {
        Some(text) => Exception::new("InternalError", text).raised(),
        None => PyRuntimeError::new_err("splatvol failed"),
    }
}
