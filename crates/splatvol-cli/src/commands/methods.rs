//! `splatvol render --list-methods`: every method, with the flag that selects it.
//!
//! The list is made from the command line's own flags, so it cannot name a method that does not exist.

use std::fmt::Write;

use clap::{Arg, Args, Command};

use crate::args::{MethodArgs, MotionArgs};

/// Headings of flags that are not methods.
const NO_METHOD: &str = "Lighting";

/// The methods as a table.
pub(super) fn list() -> String {
    let command = MotionArgs::augment_args(MethodArgs::augment_args(Command::new("render")));
    let mut text = String::new();
    for flag in command.get_arguments() {
        if flag.get_help_heading() != Some(NO_METHOD) {
            describe(flag, &mut text);
        }
    }
    text + "Figures, pictures and when to use what: docs/methods.md. What the figures are by default: splatvol render --help.\n"
}

fn describe(flag: &Arg, text: &mut String) {
    let values = flag.get_possible_values();
    let named: Vec<_> = values
        .iter()
        .filter(|value| value.get_name() != "true" && value.get_name() != "false")
        .collect();
    let (Some(long), false) = (flag.get_long(), named.is_empty()) else {
        return;
    };
    let help = flag.get_help().map(ToString::to_string).unwrap_or_default();
    let _ = writeln!(text, "--{long}: {help}");
    let width = named
        .iter()
        .map(|value| value.get_name().len())
        .max()
        .unwrap_or(0);
    for value in named {
        let help = value.get_help().map(ToString::to_string).unwrap_or_default();
        let _ = writeln!(text, "  {:width$}  {help}", value.get_name());
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_names_methods_of_all_papers() {
        let text = list();
        for method in [
            "per-splat",
            "axis-sheets",
            "swan",
            "ewa",
            "sat",
            "crawfis-max",
            "surface",
            "capsule",
        ] {
            assert!(text.contains(&format!("  {method} ")), "{method}: {text}");
        }
        assert!(!text.contains("--ambient"));
    }
}
