//! Text headers made of named fields, one per line: what NRRD and MetaImage share.

use std::collections::HashMap;
use std::io::{BufRead, Read};
use std::str::FromStr;

use crate::IoError;
use crate::error::Context;
use crate::source::Source;

/// Longest header. Real ones are kilobytes long; diffusion gradients and notes may make them megabytes.
const MAX_HEADER: u64 = 16 << 20;

/// The lines at the start of a file whose rest is binary.
pub(super) struct HeaderLines<'s, 'a> {
    source: &'s mut Source<'a>,
    offset: u64,
}

/// One line, without its end, and where it starts.
pub(super) struct Line {
    pub(super) text: String,
    pub(super) offset: u64,
}

impl<'s, 'a> HeaderLines<'s, 'a> {
    pub(super) fn new(source: &'s mut Source<'a>) -> Self {
        Self { source, offset: 0 }
    }

    /// Position of the next line.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// The next line, or `None` at the end of the file.
    pub(super) fn next(&mut self, context: &Context<'_>) -> Result<Option<Line>, IoError> {
        let mut bytes = Vec::new();
        let allowed = MAX_HEADER - self.offset;
        self.source
            .by_ref()
            .take(allowed)
            .read_until(b'\n', &mut bytes)
            .map_err(|error| context.read(error))?;
        let offset = self.offset;
        self.offset += bytes.len() as u64;
        if self.offset >= MAX_HEADER {
            return Err(context.limit(self.offset, MAX_HEADER));
        }
        if bytes.is_empty() {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_end_matches(['\n', '\r']).to_owned();
        Ok(Some(Line { text, offset }))
    }
}

/// A named value.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) value: String,
    pub(super) offset: u64,
}

impl Field {
    /// An error about this field.
    pub(super) fn error(&self, expected: impl Into<String>, context: &Context<'_>) -> IoError {
        context.field(&self.name, &self.value, self.offset, expected)
    }

    /// Numbers separated by white space.
    pub(super) fn numbers<T: FromStr>(
        &self,
        expected: &str,
        context: &Context<'_>,
    ) -> Result<Vec<T>, IoError> {
        let numbers = self
            .value
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<_, _>>();
        numbers.map_err(|_| self.error(expected, context))
    }

    /// Exactly `count` numbers.
    pub(super) fn exactly<T: FromStr>(
        &self,
        count: usize,
        what: &str,
        context: &Context<'_>,
    ) -> Result<Vec<T>, IoError> {
        let expected = format!("{count} {what}");
        let numbers = self.numbers(&expected, context)?;
        if numbers.len() == count {
            Ok(numbers)
        } else {
            Err(self.error(expected, context))
        }
    }

    /// One number.
    pub(super) fn number<T: FromStr>(&self, expected: &str, context: &Context<'_>) -> Result<T, IoError> {
        self.value
            .trim()
            .parse()
            .map_err(|_| self.error(expected, context))
    }
}

/// Fields by normalised name: lower case, no spaces.
#[derive(Debug, Default)]
pub(super) struct Fields(HashMap<String, Field>);

impl Fields {
    /// Adds a field; a duplicate is an error.
    pub(super) fn insert(&mut self, field: Field, context: &Context<'_>) -> Result<(), IoError> {
        let key = normalised(&field.name);
        if self.0.contains_key(&key) {
            return Err(field.error("this field only once", context));
        }
        self.0.insert(key, field);
        Ok(())
    }

    /// The field of this (normalised) name.
    pub(super) fn get(&self, key: &str) -> Option<&Field> {
        self.0.get(key)
    }

    /// The field of the first of these names that exists.
    pub(super) fn any(&self, keys: &[&str]) -> Option<&Field> {
        keys.iter().find_map(|key| self.get(key))
    }

    /// The field of this name, or an error that reports it as missing.
    pub(super) fn required(&self, key: &str, context: &Context<'_>) -> Result<&Field, IoError> {
        self.get(key)
            .ok_or_else(|| context.field(key, "", None, "this field, which is missing"))
    }

    /// Names that are not in `known`, sorted.
    pub(super) fn unknown(&self, known: &[&str]) -> Vec<&str> {
        let mut names: Vec<&str> = self
            .0
            .iter()
            .filter(|(key, _)| !known.contains(&key.as_str()))
            .map(|(_, field)| field.name.as_str())
            .collect();
        names.sort_unstable();
        names
    }
}

/// Lower case without spaces: `Space Origin` and `spaceorigin` are one field.
pub(super) fn normalised(name: &str) -> String {
    let letters = name.chars().filter(|c| !c.is_whitespace());
    letters.flat_map(char::to_lowercase).collect()
}
