//! Templates with slots, `{{name}}`. Every slot is filled, by text that is escaped or by code and data that are checked;
//! everything else is an error, so that no page is written that a browser would read otherwise than meant.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::PageError;

/// What fills a slot.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Slot<'a> {
    /// Text, in an element or an attribute between double quotes.
    Text(&'a str),
    /// JSON, in a script element that is not run.
    Json(&'a serde_json::Value),
    /// Bytes, in base64.
    Bytes(&'a [u8]),
    /// A script or a style of our own: it must not end its element.
    Code(&'a str),
}

impl Slot<'_> {
    fn text(self) -> Result<String, PageError> {
        Ok(match self {
            Self::Text(text) => escaped(text),
            Self::Json(value) => json(value)?,
            Self::Bytes(bytes) => STANDARD.encode(bytes),
            Self::Code(code) => {
                let lower = code.to_ascii_lowercase();
                match ["</script", "</style", "<!--"]
                    .iter()
                    .find(|end| lower.contains(**end))
                {
                    Some(end) => return Err(PageError::Template(format!("code has {end}"))),
                    None => code.to_owned(),
                }
            }
        })
    }
}

/// Text between tags or double quotes. Characters that HTML does not allow become U+FFFD.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\n' | '\t' => escaped.push(character),
            character if character.is_control() => escaped.push('\u{fffd}'),
            character => escaped.push(character),
        }
    }
    escaped
}

/// JSON in which no character means anything to HTML.
fn json(value: &serde_json::Value) -> Result<String, PageError> {
    let text = serde_json::to_string(value)?;
    Ok(text
        .replace('<', "\\u003c")
        .replace('>', "\\u003e")
        .replace('&', "\\u0026"))
}

/// Fills the slots of a template: each of those given has to be there, and there have to be no others.
pub(crate) fn fill(template: &str, slots: &[(&str, Slot<'_>)]) -> Result<String, PageError> {
    let refused = |why: String| Err(PageError::Template(why));
    let mut used = vec![false; slots.len()];
    let mut pieces = template.split("{{");
    let mut page = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let Some((name, after)) = piece.split_once("}}") else {
            return refused(format!(
                "a slot does not end: {:?}",
                piece.get(..20).unwrap_or(piece)
            ));
        };
        let Some(at) = slots.iter().position(|(known, _)| *known == name) else {
            return refused(format!("nothing fills the slot {name:?}"));
        };
        used[at] = true;
        page.push_str(&slots[at].1.text()?);
        page.push_str(after);
    }
    match used.iter().position(|used| !used) {
        Some(at) => refused(format!("there is no slot {:?}", slots[at].0)),
        None => Ok(page),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_are_filled_and_their_text_is_escaped() {
        let nasty = serde_json::json!({ "name": "</script><script>alert('&')" });
        let page = fill(
            "<a title=\"{{t}}\">{{t}}</a>{{j}}{{b}}{{c}}",
            &[
                ("t", Slot::Text("<b a=\"'\">&\u{1}{{j}}")),
                ("j", Slot::Json(&nasty)),
                ("b", Slot::Bytes(b"\xff\x00<")),
                ("c", Slot::Code("a < b")),
            ],
        )
        .unwrap();
        let text = "&lt;b a=&quot;&#39;&quot;&gt;&amp;\u{fffd}{{j}}";
        assert_eq!(
            page,
            format!(
                "<a title=\"{text}\">{text}</a>{{\"name\":\"\\u003c/script\\u003e\\u003cscript\\u003ealert('\\u0026')\"}}/wA8a < b"
            )
        );
        // What is read back is what was written.
        let written = page.split("</a>").nth(1).unwrap().split("/wA8").next().unwrap();
        assert_eq!(serde_json::from_str::<serde_json::Value>(written).unwrap(), nasty);
    }

    #[test]
    fn slots_that_do_not_fit_are_errors() {
        let why = |template: &str, slots: &[(&str, Slot<'_>)]| fill(template, slots).unwrap_err().to_string();
        assert!(why("{{a}}", &[]).contains("nothing fills the slot \"a\""));
        assert!(why("", &[("a", Slot::Text(""))]).contains("no slot \"a\""));
        assert!(why("{{a", &[("a", Slot::Text(""))]).contains("does not end"));
        for code in ["'</SCRIPT>'", "a</style", "<!-- b"] {
            assert!(
                why("{{a}}", &[("a", Slot::Code(code))]).contains("code has"),
                "{code}"
            );
        }
    }
}
