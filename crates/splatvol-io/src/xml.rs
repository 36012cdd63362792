//! XML documents of files, checked before they are parsed.
//!
//! The parser compares every attribute of an element with all others of it, and every namespace with all that are known:
//! the time grows with the square of their number. Real elements have a dozen.

use roxmltree::{Document, ParsingOptions};

use crate::IoError;
use crate::error::Context;

/// Attributes that an element may have.
const MOST_ATTRIBUTES: usize = 256;
/// Namespaces that a document may declare.
const MOST_NAMESPACES: usize = 256;
/// Far more elements than any header has.
const MOST_ELEMENTS: u32 = 1 << 20;

/// The document, without document type or entities. `field` names it in errors.
pub(crate) fn parse<'a>(text: &'a str, field: &str, context: &Context<'_>) -> Result<Document<'a>, IoError> {
    if let Some(attributes) = crowded(text.as_bytes()) {
        let found = format!("{attributes} attributes of one element");
        return Err(context.field(field, found, None, format!("at most {MOST_ATTRIBUTES}")));
    }
    let namespaces = text.matches("xmlns").count();
    if namespaces > MOST_NAMESPACES {
        let expected = format!("at most {MOST_NAMESPACES}");
        return Err(context.field(field, format!("{namespaces} namespaces"), None, expected));
    }
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MOST_ELEMENTS,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options)
        .map_err(|error| context.field(field, error, None, "well-formed XML without document type"))
}

/// The number of attributes of the first element that has too many: the quoted values in its tag.
fn crowded(text: &[u8]) -> Option<usize> {
    let (mut values, mut quote) = (0, None);
    let mut in_tag = false;
    for (i, &byte) in text.iter().enumerate() {
        match (quote, byte) {
            (Some(open), _) if byte == open => quote = None,
            (Some(_), _) => (),
            (None, b'"' | b'\'') if in_tag => {
                (values, quote) = (values + 1, Some(byte));
            }
            (None, b'<') => {
                values = 0;
                in_tag = text
                    .get(i + 1)
                    .is_some_and(|next| next.is_ascii_alphabetic() || *next == b'_');
            }
            (None, b'>') => {
                if values > MOST_ATTRIBUTES {
                    return Some(values);
                }
                in_tag = false;
            }
            _ => (),
        }
    }
    // A tag that never ends is no XML, but the parser would only find that out at its end.
    (values > MOST_ATTRIBUTES).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn refusal(text: &str) -> Option<String> {
        let context = Context::new("test", Path::new("a.xml"));
        parse(text, "XML", &context).err().map(|error| error.to_string())
    }

    #[test]
    fn quadratic_documents_are_refused_before_they_are_parsed() {
        let attributes = |count: usize| -> String { (0..count).map(|i| format!(" a{i}='>\"'")).collect() };
        assert_eq!(refusal(&format!("<a{}/>", attributes(MOST_ATTRIBUTES))), None);
        for text in [
            format!("<a{}/>", attributes(60_000)),
            format!("<a{}", attributes(60_000)),
            format!("<!-- it's --><a{}/>", attributes(60_000)),
        ] {
            let error = refusal(&text).unwrap();
            assert!(error.contains("attributes of one element"), "{error}");
        }
        let nested: String = (0..5000).map(|i| format!("<a xmlns:b{i}='c{i}'>")).collect();
        let error = refusal(&nested).unwrap();
        assert!(error.contains("5000 namespaces"), "{error}");
    }

    #[test]
    fn document_types_are_refused() {
        let error = refusal("<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>").unwrap();
        assert!(error.contains("without document type"), "{error}");
    }
}
