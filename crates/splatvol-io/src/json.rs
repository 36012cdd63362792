//! A place in a JSON document that can name itself in errors: `components[0].scalarOpacity.points[2].y`.

use serde_json::Value;

use crate::IoError;
use crate::error::Context;

/// Parses a whole document; the error names line and column.
pub(crate) fn parse(bytes: &[u8], context: &Context<'_>) -> Result<Value, IoError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    serde_json::from_slice(bytes).map_err(|error| context.field("contents", error, None, "valid JSON"))
}

/// A value and the path that leads to it.
#[derive(Clone)]
pub(crate) struct Node<'a> {
    value: &'a Value,
    path: String,
    context: &'a Context<'a>,
}

impl<'a> Node<'a> {
    pub(crate) fn root(value: &'a Value, context: &'a Context<'a>) -> Self {
        let path = String::new();
        Self { value, path, context }
    }

    fn child(&self, value: &'a Value, step: &str) -> Self {
        let dot = if self.path.is_empty() || step.starts_with('[') {
            ""
        } else {
            "."
        };
        Self {
            value,
            path: format!("{}{dot}{step}", self.path),
            context: self.context,
        }
    }

    /// A member of an object, if it is there and not null.
    pub(crate) fn get(&self, key: &str) -> Option<Self> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        Some(self.child(value, key))
    }

    /// A member that must be there.
    pub(crate) fn require(&self, key: &str) -> Result<Self, IoError> {
        self.get(key).ok_or_else(|| {
            let missing = self.child(&Value::Null, key);
            self.context.field(missing.path, "(absent)", None, "a value")
        })
    }

    /// Checks that this is an object without members other than `known`.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), IoError> {
        let Value::Object(members) = self.value else {
            return Err(self.error("an object"));
        };
        match members.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some((name, value)) => Err(self
                .child(value, name)
                .error(&format!("no such field, but {}", known.join(", ")))),
        }
    }

    /// The elements of an array.
    pub(crate) fn items(&self) -> Result<Vec<Self>, IoError> {
        let Value::Array(items) = self.value else {
            return Err(self.error("an array"));
        };
        let item = |(index, value)| self.child(value, &format!("[{index}]"));
        Ok(items.iter().enumerate().map(item).collect())
    }

    /// A number.
    pub(crate) fn number(&self) -> Result<f64, IoError> {
        self.value.as_f64().ok_or_else(|| self.error("a number"))
    }

    /// A number in 0..1.
    pub(crate) fn unit(&self) -> Result<f64, IoError> {
        let number = self.number()?;
        if (0.0..=1.0).contains(&number) {
            Ok(number)
        } else {
            Err(self.error("a number from 0 to 1"))
        }
    }

    /// True for `true` and for numbers that are not 0.
    pub(crate) fn is_true(&self) -> bool {
        self.value
            .as_bool()
            .unwrap_or_else(|| self.value.as_f64().is_some_and(|number| number != 0.0))
    }

    /// The path that leads here.
    pub(crate) fn name(&self) -> &str {
        &self.path
    }

    /// The text of a string, if it is one.
    pub(crate) fn text(&self) -> Option<&'a str> {
        self.value.as_str()
    }

    /// An error: this value is not the expected one.
    pub(crate) fn error(&self, expected: &str) -> IoError {
        self.context.field(self.path.clone(), self.value, None, expected)
    }
}
