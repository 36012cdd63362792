//! Words, lines and binary blocks of a legacy VTK file.

use crate::IoError;
use crate::error::Context;

/// Longest line or word that a header may have, bytes.
const MAX_LINE: usize = 4096;

/// A position in the file. Reads never go past the end.
#[derive(Clone, Copy)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
    context: &'a Context<'a>,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8], context: &'a Context<'a>) -> Self {
        Self {
            bytes,
            position: 0,
            context,
        }
    }

    pub(crate) fn position(&self) -> usize {
        self.position
    }

    pub(crate) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.position..]
    }

    pub(crate) fn context(&self) -> &'a Context<'a> {
        self.context
    }

    /// A malformed field at this position.
    pub(crate) fn error(&self, field: &str, value: &str, expected: impl Into<String>) -> IoError {
        self.context.field(field, value, self.position as u64, expected)
    }

    /// The rest of the line, without its end.
    pub(crate) fn line(&mut self, field: &str) -> Result<String, IoError> {
        let rest = self.rest();
        let length = rest
            .iter()
            .take(MAX_LINE + 1)
            .position(|&byte| byte == b'\n')
            .unwrap_or(rest.len());
        if length > MAX_LINE {
            return Err(self.error(field, "", format!("a line of at most {MAX_LINE} bytes")));
        }
        self.position += (length + 1).min(rest.len());
        Ok(String::from_utf8_lossy(&rest[..length]).trim().to_owned())
    }

    /// The next word, if there is one; the white space before it may hold line ends.
    pub(crate) fn word(&mut self) -> Option<String> {
        self.skip_blanks();
        let rest = self.rest();
        let length = rest
            .iter()
            .take(MAX_LINE)
            .take_while(|byte| !byte.is_ascii_whitespace())
            .count();
        self.position += length;
        (length > 0).then(|| String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    /// The next word as a number.
    pub(crate) fn number<T: std::str::FromStr>(&mut self, field: &str) -> Result<T, IoError> {
        self.skip_blanks();
        let start = *self;
        let word = self.word().unwrap_or_default();
        word.parse().map_err(|_| start.error(field, &word, "a number"))
    }

    pub(crate) fn numbers<T: std::str::FromStr + Copy + Default, const N: usize>(
        &mut self,
        field: &str,
    ) -> Result<[T; N], IoError> {
        let mut numbers = [T::default(); N];
        for number in &mut numbers {
            *number = self.number(field)?;
        }
        Ok(numbers)
    }

    pub(crate) fn skip_blanks(&mut self) {
        let blank = |byte: &&u8| byte.is_ascii_whitespace();
        self.position += self.rest().iter().take_while(blank).count();
    }

    /// Skips binary data.
    pub(crate) fn skip_bytes(&mut self, count: u64) -> Result<(), IoError> {
        let left = self.rest().len() as u64;
        if count > left {
            return Err(self.context.truncated("binary data", count, left));
        }
        self.position += count as usize;
        Ok(())
    }

    /// Skips words of any length.
    pub(crate) fn skip_words(&mut self, count: u64) -> Result<(), IoError> {
        for skipped in 0..count {
            self.skip_blanks();
            let length = self
                .rest()
                .iter()
                .take_while(|byte| !byte.is_ascii_whitespace())
                .count();
            if length == 0 {
                return Err(self.error("data", &format!("{skipped} numbers"), format!("{count} numbers")));
            }
            self.position += length;
        }
        Ok(())
    }

    /// Skips the block after `METADATA`: lines up to an empty one.
    pub(crate) fn skip_metadata(&mut self) -> Result<(), IoError> {
        self.line("METADATA")?;
        while !self.line("METADATA")?.is_empty() {}
        Ok(())
    }
}
