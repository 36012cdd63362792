//! Tests that measure their process: its peak memory, its allocations, its threads.
//!
//! `cargo nextest` runs every test in a process of its own. `cargo test` runs all tests of a program side by side in one,
//! where such a test would measure the others too.

use std::process::Command;

/// Set in the processes that [`ran_alone`] starts.
const ALONE: &str = "SPLATVOL_TEST_ALONE";

/// Begins a test that needs a process of its own: where it shares one, runs it again in another, and returns.
#[macro_export]
macro_rules! alone {
    () => {{
        fn here() {}
        if $crate::process::ran_alone(std::any::type_name_of_val(&here)) {
            return;
        }
    }};
}

/// Runs a test again as the only one of its program, unless this process is already its own. `here` is the path of a function in
/// the test, with the crate's name. For [`alone!`](crate::alone).
///
/// # Panics
/// If the test fails there, or cannot be run.
pub fn ran_alone(here: &str) -> bool {
    let nextest = std::env::var_os("NEXTEST_EXECUTION_MODE").is_some_and(|mode| mode == "process-per-test");
    if nextest || std::env::var_os(ALONE).is_some() {
        return false;
    }
    let test = here
        .split_once("::")
        .and_then(|(_, path)| path.strip_suffix("::here"))
        .unwrap_or_else(|| panic!("{here} is in no test"));
    let program = std::env::current_exe().unwrap_or_else(|error| panic!("{test}: {error}"));
    let output = Command::new(program)
        .args([test, "--exact", "--nocapture"])
        .env(ALONE, "1")
        .output()
        .unwrap_or_else(|error| panic!("{test}: {error}"));
    let (said, errors) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    println!("{said}");
    assert!(
        output.status.success() && said.contains("\nrunning 1 test\n"),
        "{test}, in a process of its own: {}\n{errors}",
        output.status
    );
    true
}

#[cfg(test)]
mod tests {
    /// Runs once in each of two processes under `cargo test`, and finds none but its own threads in the second.
    #[test]
    fn a_test_can_have_a_process_of_its_own() {
        crate::alone!();
        assert!(
            std::env::var_os(super::ALONE).is_some() || std::env::var_os("NEXTEST_EXECUTION_MODE").is_some()
        );
    }

    #[test]
    #[should_panic(expected = "in a process of its own")]
    fn a_test_that_is_not_there_fails() {
        if !super::ran_alone("splatvol_testing::process::no_such_test::here") {
            panic!("in a process of its own, by nextest");
        }
    }
}
