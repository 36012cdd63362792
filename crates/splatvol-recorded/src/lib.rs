//! Recorded files of the tests, tests that take long, and a word where a test does not run.
//!
//! Test runners hide what passing tests print. So each line `skipped: NAME: why` also goes to the file that the environment
//! variable `SPLATVOL_SKIPPED` names, if it is set: `scripts/test` sets it, and prints the file at the end.
//!
//! The crate has no dependencies, so that the tests of every crate can use it.
#![forbid(unsafe_code)]

use std::io::Write;
use std::path::{Path, PathBuf};

/// The environment variable that names the list of what was skipped.
pub const LIST: &str = "SPLATVOL_SKIPPED";

/// The environment variable by which long tests run too, if it is 1: `scripts/test --long` sets it.
pub const LONG: &str = "SPLATVOL_LONG_TESTS";

/// Whether long tests run. If not, the calling test is [skipped](skip), or its long part.
pub fn long() -> bool {
    let runs = std::env::var_os(LONG).is_some_and(|value| value == "1");
    if !runs {
        skip("a long test: scripts/test --long");
    }
    runs
}

/// The folder of recorded files of a kind, `../shared/data/KIND` beside the repository; an empty kind is all of them. Without
/// the folder the calling test is [skipped](skip), and there is nothing to test with.
pub fn recorded(kind: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(kind);
    if folder.is_dir() {
        return Some(folder);
    }
    skip("no ../shared/data");
    None
}

/// Says that the calling test, or a part of it, cannot run, and why.
pub fn skip(why: &str) {
    skip_in(std::env::var_os(LIST).as_deref().map(Path::new), why);
}

/// Says so on the terminal and, if there is one, in a list.
fn skip_in(list: Option<&Path>, why: &str) {
    let thread = std::thread::current();
    let line = format!("skipped: {}: {why}", thread.name().unwrap_or("a test"));
    println!("{line}");
    if let Some(list) = list {
        note(list, &line);
    }
}

/// Appends a line in one piece: tests run side by side. A list that cannot be written must not fail the test.
fn note(list: &Path, line: &str) {
    let file = std::fs::OpenOptions::new().append(true).create(true).open(list);
    if let Err(error) = file.and_then(|mut file| file.write_all(format!("{line}\n").as_bytes())) {
        println!("{}: {error}", list.display());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skipped_parts_are_named_in_the_list() {
        let list = std::env::temp_dir().join(format!("splatvol-skipped-{}", std::process::id()));
        let path = list.clone();
        let test = std::thread::Builder::new().name("of_scans".to_owned());
        let test = test.spawn(move || {
            for why in ["no scan", "no memory"] {
                skip_in(Some(&path), why);
            }
        });
        assert!(test.is_ok_and(|test| test.join().is_ok()));
        let text = std::fs::read_to_string(&list).unwrap_or_default();
        let _ = std::fs::remove_file(&list);
        assert_eq!(text, "skipped: of_scans: no scan\nskipped: of_scans: no memory\n");
    }

    #[test]
    fn lists_that_cannot_be_written_do_not_fail_the_test() {
        skip_in(Some(&std::env::temp_dir()), "its list is a folder");
    }
}
