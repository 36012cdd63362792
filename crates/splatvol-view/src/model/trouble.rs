//! What is said of errors beside their own words: what gives more memory, and what takes less.

use splatvol_document::DocumentError;

/// Words of errors of volumes in chunks for which the memory is too small: of a picture, and of the overview.
const OF_CHUNKS: [&str; 2] = ["of memory are too few", "its overview alone takes"];
/// Words of the error of a picture that the machine has no memory for.
const OF_SIZE: &str = "the machine grants";

/// What the window says of an error.
pub(super) fn of_window(error: &DocumentError) -> String {
    let text = error.to_string();
    match OF_CHUNKS.iter().any(|words| text.contains(words)) {
        true => format!("{text}; splatvol view --memory allows more, half of which is the window's"),
        false => text,
    }
}

/// What is said of a picture that is not saved.
pub(super) fn of_saving(text: String) -> String {
    match text.contains(OF_CHUNKS[0]) || text.contains(OF_SIZE) {
        true => format!(
            "{text}. Saved smaller as A.png, it is made at any size, in bands of rows, by splatvol render --like A.png --size WxH -o B.png"
        ),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_little_memory_has_a_remedy_and_other_errors_have_none() {
        let few = "7 bytes of memory are too few for this picture";
        let said = |text: &str| of_window(&DocumentError::usage(text));
        assert!(said(few).contains("--memory"));
        assert_eq!(said("no such file"), "no such file");
        for text in [few, "9x9: it takes 4 MiB, and the machine grants 2 MiB"] {
            assert!(of_saving(text.to_owned()).contains("render --like"));
        }
        assert_eq!(of_saving("disk full".to_owned()), "disk full");
    }
}
