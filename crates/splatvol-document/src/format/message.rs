//! Messages about malformed text: line, key and value, and the name that was probably meant.

use std::ops::Range;

use crate::keys::names::nearest;

/// The parser's complaint about TOML.
pub(super) fn of_toml(error: &toml::de::Error, text: &str) -> String {
    let Range { start, end } = error.span().unwrap_or(0..0);
    let line_start = text[..start.min(text.len())].rfind('\n').map_or(0, |at| at + 1);
    let line = text[line_start..].lines().next().unwrap_or_default();
    let number = text[..line_start].matches('\n').count() + 1;
    let (key, value) = line.split_once('=').unwrap_or((line, ""));
    let value = match value.trim() {
        "" => text.get(start..end).unwrap_or_default(),
        value => value,
    };
    let why = suggesting(error.message().trim());
    format!("line {number}: {} = {value:?}: {why}", key.trim())
}

/// The parser's complaint about JSON, which names line and column.
pub(super) fn of_json(error: &serde_json::Error) -> String {
    suggesting(&error.to_string())
}

/// A complaint of serde's about an unknown name, which is followed by those that are expected, with the nearest of
/// them.
fn suggesting(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let (Some(name), true) = (quoted.next(), message.starts_with("unknown")) else {
        return message.to_owned();
    };
    match nearest(name, quoted) {
        Some(meant) => format!("{message}; did you mean `{meant}`?"),
        None => message.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_that_was_probably_meant_is_said() {
        let message = suggesting("unknown field `radios`, expected one of `file`, `radius`");
        assert!(message.ends_with("did you mean `radius`?"), "{message}");
        let plain = "unknown field `qqqq`, expected `file`";
        assert_eq!(suggesting(plain), plain);
        assert_eq!(
            suggesting("invalid type: `x`, expected `y`"),
            "invalid type: `x`, expected `y`"
        );
    }
}
