//! Base64 that is decoded while it is read (RFC 4648, section 4), with blanks anywhere, and padding between its parts.

use std::io::{BufRead, Error, ErrorKind, Read, Result};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::source::Source;

/// Letters that are decoded at once: whole groups of four.
const LETTERS: usize = 1 << 14;

/// The bytes of a text, which ends with its source or before a tag.
pub(super) struct Base64Reader<'a> {
    text: Source<'a>,
    /// Letters of less than a group.
    letters: Vec<u8>,
    bytes: Vec<u8>,
    /// Those that were taken.
    taken: usize,
}

impl<'a> Base64Reader<'a> {
    pub(super) fn new(text: Source<'a>) -> Self {
        Self {
            text,
            letters: Vec::with_capacity(LETTERS),
            bytes: Vec::with_capacity(LETTERS / 4 * 3),
            taken: 0,
        }
    }

    /// Reads letters until there are enough of them, or no more.
    fn gather(&mut self) -> Result<()> {
        while self.letters.len() < LETTERS {
            let text = self.text.fill_buf()?;
            let end = text.iter().position(|&byte| byte == b'<').unwrap_or(text.len());
            if end == 0 {
                break;
            }
            let text = &text[..end];
            let mut used = 0;
            for &byte in text {
                used += 1;
                if !byte.is_ascii_whitespace() {
                    self.letters.push(byte);
                    if self.letters.len() == LETTERS {
                        break;
                    }
                }
            }
            self.text.consume(used);
        }
        Ok(())
    }

    /// Decodes the gathered letters; a padded group ends a part, and another may follow.
    fn decode(&mut self) -> Result<()> {
        let mut rest = self.letters.as_slice();
        while !rest.is_empty() {
            let padded = rest.chunks(4).position(|group| group.contains(&b'='));
            let end = padded.map_or(rest.len(), |group| rest.len().min(4 * (group + 1)));
            let (part, after) = rest.split_at(end);
            STANDARD
                .decode_vec(part, &mut self.bytes)
                .map_err(|error| Error::new(ErrorKind::InvalidData, format!("invalid base64: {error}")))?;
            rest = after;
        }
        self.letters.clear();
        Ok(())
    }
}

impl Read for Base64Reader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.taken == self.bytes.len() {
            self.bytes.clear();
            self.taken = 0;
            self.gather()?;
            self.decode()?;
        }
        let read = (&self.bytes[self.taken..]).read(buffer)?;
        self.taken += read;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(text: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Base64Reader::new(Source::from_bytes(text.as_bytes())).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    #[test]
    fn parts_blanks_and_tags_are_told_apart() {
        let header = STANDARD.encode([1, 2, 3, 4]);
        let data: Vec<u8> = (0..100_000u32).map(|i| (i * 31) as u8).collect();
        let text = STANDARD.encode(&data);
        let (start, end) = text.split_at(LETTERS + 1);
        let joined = format!("{header}\n {start}\t{end} </DataArray>");
        assert_eq!(decoded(&joined).unwrap(), [&[1, 2, 3, 4], &data[..]].concat());
        assert!(decoded("").unwrap().is_empty());
    }

    #[test]
    fn what_is_no_base64_is_an_error() {
        for wrong in ["AAA", "A=AA", "AA=A", "AA*A", "AAAAB", "===="] {
            let error = decoded(wrong).unwrap_err();
            assert!(error.to_string().contains("invalid base64"), "{wrong}: {error}");
        }
    }
}
