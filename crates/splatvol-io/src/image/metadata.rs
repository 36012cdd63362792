//! Text that travels with a picture: pairs of keyword and text, in the order written.
//!
//! PNG holds them as text chunks, EXR as attributes. Keywords follow PNG's stricter rules (PNG 3rd edition, 11.3.3.1),
//! reduced to ASCII: 1 to 79 printable characters, single spaces, none at the ends.

use crate::IoError;

/// Keyword of the program that made a picture (registered by PNG, standard in EXR).
pub const SOFTWARE: &str = "Software";

/// Keyword of the command line that made a picture (registered by PNG).
pub const COMMENT: &str = "Comment";

/// Keyword of the settings that made a picture, as JSON.
pub const SETTINGS: &str = "splatvol.settings";

/// Longest text of one keyword, bytes.
pub const LONGEST_TEXT: usize = 1 << 20;

/// Text of the first pair with this keyword.
pub fn find<'a>(metadata: &'a [(String, String)], keyword: &str) -> Option<&'a str> {
    metadata
        .iter()
        .find(|(key, _)| key == keyword)
        .map(|(_, text)| text.as_str())
}

/// Refuses metadata that could not be read back.
pub(crate) fn check(format: &'static str, metadata: &[(String, String)]) -> Result<(), IoError> {
    for (keyword, text) in metadata {
        let printable = keyword.bytes().all(|byte| (b' '..=b'~').contains(&byte));
        let spaced = keyword.trim() != keyword || keyword.contains("  ");
        if !(1..=79).contains(&keyword.len()) || !printable || spaced {
            let what = format!("metadata keyword {keyword:?} is not 1 to 79 printable ASCII characters");
            return Err(IoError::Encode { format, what });
        }
        if text.len() > LONGEST_TEXT || text.contains('\0') {
            let length = text.len();
            let what = format!("metadata text of {keyword:?} ({length} bytes) holds NUL or exceeds 1 MiB");
            return Err(IoError::Encode { format, what });
        }
    }
    Ok(())
}
