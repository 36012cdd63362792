//! What is skipped stands in the list, by the name of its test.

use std::process::Command;

use splatvol_recorded::{LIST, recorded, skip};

/// Not a test of its own: the test below runs it with a list.
#[test]
#[ignore = "run by the other test"]
fn part_that_cannot_run() {
    skip("for this test");
    assert_eq!(recorded("no such kind"), None);
}

#[test]
fn skipped_parts_are_named_in_the_list() {
    let list = std::env::temp_dir().join(format!("splatvol-skipped-{}", std::process::id()));
    let program = std::env::current_exe().unwrap();
    let arguments = ["--ignored", "--exact", "part_that_cannot_run"];
    let ran = Command::new(program)
        .args(arguments)
        .env(LIST, &list)
        .output()
        .unwrap();
    let text = std::fs::read_to_string(&list).unwrap_or_default();
    let _ = std::fs::remove_file(&list);
    assert!(ran.status.success());
    let of = |why: &str| format!("skipped: part_that_cannot_run: {why}\n");
    assert_eq!(text, of("for this test") + &of("no ../shared/data"));
}
