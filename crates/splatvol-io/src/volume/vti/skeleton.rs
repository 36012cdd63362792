//! The XML part of a file of any size: its tags and short texts, read once from start to end. Long texts, the numbers of arrays,
//! are passed over, and found again by their place.

use std::io::BufRead;
use std::ops::Range;

use crate::IoError;
use crate::error::Context;
use crate::source::Source;

/// Longest text that is kept, bytes.
const SHORT: usize = 1 << 12;
/// Most bytes of tags and short texts.
const MOST: usize = 64 << 20;
const APPENDED: &[u8] = b"<AppendedData";

/// A file without its long texts.
pub(super) struct Skeleton {
    /// A whole XML document.
    pub(super) xml: String,
    texts: Vec<PassedOver>,
    /// Where the appended data begin, behind their underscore.
    pub(super) appended: Option<u64>,
}

/// A text that is not in memory.
struct PassedOver {
    /// Where it would stand in the document.
    at: usize,
    /// Where it is in the file.
    bytes: Range<u64>,
}

impl Skeleton {
    /// Reads a file up to its appended data, or its end.
    ///
    /// # Errors
    /// A file that cannot be read; more than 64 MiB of tags and short texts.
    pub(super) fn read(mut source: Source<'_>, context: &Context<'_>) -> Result<Self, IoError> {
        let mut kept = Vec::new();
        let mut texts = Vec::new();
        let mut appended = None;
        loop {
            let start = kept.len();
            let text = copy_text(&mut source, &mut kept, context)?;
            if text.end - text.start > SHORT as u64 {
                kept.truncate(start);
                texts.push(PassedOver {
                    at: start,
                    bytes: text,
                });
            }
            let tag = kept.len();
            copy_tag(&mut source, &mut kept, context)?;
            if kept.len() > MOST {
                return Err(context.limit(kept.len() as u64, MOST as u64));
            }
            if kept.len() == tag {
                break;
            }
            if kept[tag..].starts_with(APPENDED) {
                appended = Some(start_of_appended(&mut source, context)?);
                close(&mut kept);
                break;
            }
        }
        Ok(Self {
            xml: String::from_utf8(kept)
                .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned()),
            texts,
            appended,
        })
    }

    /// Where the long texts within a part of the document are in the file.
    pub(super) fn texts(&self, part: Range<usize>) -> impl Iterator<Item = Range<u64>> {
        let inside = self.texts.iter().filter(move |text| part.contains(&text.at));
        inside.map(|text| text.bytes.clone())
    }
}

/// The end of a document whose last tag begins the appended data.
fn close(kept: &mut Vec<u8>) {
    kept.pop();
    while kept.last() == Some(&b'/') {
        kept.pop();
    }
    kept.extend_from_slice(b"/></VTKFile>");
}

/// Copies up to the next tag, but not much more than is kept; where that is in the file.
fn copy_text(
    source: &mut Source<'_>,
    kept: &mut Vec<u8>,
    context: &Context<'_>,
) -> Result<Range<u64>, IoError> {
    let start = position(source);
    let most = kept.len() + SHORT + 1;
    loop {
        let bytes = source.peek(context)?;
        let length = bytes.iter().position(|&byte| byte == b'<').unwrap_or(bytes.len());
        if length == 0 {
            return Ok(start..position(source));
        }
        kept.extend_from_slice(&bytes[..length.min(most - kept.len())]);
        source.consume(length);
    }
}

/// Copies a tag, a comment or the like; nothing at the end.
fn copy_tag(source: &mut Source<'_>, kept: &mut Vec<u8>, context: &Context<'_>) -> Result<(), IoError> {
    let start = kept.len();
    let mut quote = None;
    while kept.len() <= MOST {
        let bytes = source.peek(context)?;
        if bytes.is_empty() {
            return Ok(());
        }
        let (mut used, mut is_whole) = (0, false);
        for &byte in bytes {
            used += 1;
            kept.push(byte);
            let tag = &kept[start..];
            let end: Option<&[u8]> = match tag {
                [b'<', b'!', b'-', b'-', ..] => Some(b"-->"),
                [b'<', b'!', b'[', ..] => Some(b"]]>"),
                _ => None,
            };
            is_whole = match (end, quote, byte) {
                (Some(end), ..) => tag.len() >= 4 + end.len() && tag.ends_with(end),
                (None, None, b'"' | b'\'') => {
                    quote = Some(byte);
                    false
                }
                (None, Some(open), _) => {
                    quote = quote.filter(|_| open != byte);
                    false
                }
                (None, None, _) => byte == b'>',
            };
            if is_whole {
                break;
            }
        }
        source.consume(used);
        if is_whole {
            return Ok(());
        }
    }
    Ok(())
}

/// Passes over the blanks and the underscore in front of appended data.
fn start_of_appended(source: &mut Source<'_>, context: &Context<'_>) -> Result<u64, IoError> {
    loop {
        let at = position(source);
        let byte = source.peek(context)?.first().copied();
        source.consume(usize::from(byte.is_some()));
        match byte {
            Some(b'_') => return Ok(position(source)),
            Some(byte) if byte.is_ascii_whitespace() => (),
            other => {
                let found = char::from(other.unwrap_or_default());
                return Err(context.field("AppendedData", found, at, "content that starts with `_`"));
            }
        }
    }
}

/// Bytes before the next one of a file.
fn position(source: &Source<'_>) -> u64 {
    source.position().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn skeleton(bytes: &[u8]) -> Result<Skeleton, IoError> {
        let context = Context::new("VTI", Path::new("a.vti"));
        Skeleton::read(Source::from_bytes(bytes), &context)
    }

    #[test]
    fn long_texts_are_found_by_their_place() {
        let numbers = "1 2 3 ".repeat(SHORT);
        let before = r#"<?xml version="1.0"?><!-- a > "b --><VTKFile><A n='x > y'>"#;
        let text = format!("{before}{numbers}</A><B>7</B></VTKFile>");
        let found = skeleton(text.as_bytes()).unwrap();
        assert_eq!(found.xml, format!("{before}</A><B>7</B></VTKFile>"));
        let start = before.len() as u64;
        let mut within = found.texts(before.len() - 3..before.len() + 1);
        assert_eq!(within.next(), Some(start..start + numbers.len() as u64));
        assert!(within.next().is_none());
        assert_eq!(found.texts(0..before.len()).count(), 0);
        assert!(found.appended.is_none());
    }

    #[test]
    fn appended_data_are_not_read() {
        let before = b"<VTKFile><AppendedData encoding=\"raw\">\n  _";
        let found = skeleton(&[&before[..], b"<\xff>\"'<!--"].concat()).unwrap();
        assert_eq!(found.xml, "<VTKFile><AppendedData encoding=\"raw\"/></VTKFile>");
        assert_eq!(found.appended, Some(before.len() as u64));
        let error = skeleton(b"<VTKFile><AppendedData>x").err().unwrap();
        assert!(error.to_string().contains("starts with `_`"), "{error}");
    }

    #[test]
    fn what_ends_early_is_kept_as_it_is() {
        for text in ["", "<", "<a b='", "<!-- x", "<![CDATA[ ]]", "<a>x"] {
            assert_eq!(skeleton(text.as_bytes()).unwrap().xml, text);
        }
    }
}
