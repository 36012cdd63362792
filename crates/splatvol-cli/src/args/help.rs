//! How the help is laid out: groups of flags in one order, and which flags the short help (`-h`) shows.
//!
//! The long help (`--help`) shows all.

use std::ffi::OsString;
use std::path::Path;

use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use clap::{Arg, ArgAction, Command, CommandFactory, FromArgMatches};

use super::Cli;

pub(super) const CASES: &str = "Cases";
pub(super) const MEASUREMENT: &str = "Measurement";
pub(super) const INPUT: &str = "Input";
pub(super) const HEADERLESS: &str = "Files without a header";
pub(super) const DATA: &str = "Points, Gaussians, meshes and terrain";
pub(super) const CAMERA: &str = "Camera and clipping";
pub(super) const MOTION: &str = "Motion of the camera";
pub(super) const LOOK: &str = "Colour and opacity";
pub(super) const LIGHT: &str = "Light";
pub(super) const METHOD: &str = "Method";
pub(super) const QUALITY: &str = "Quality";
pub(super) const KERNEL: &str = "Kernel";
pub(super) const EFFECTS: &str = "Effects";
pub(super) const BLUR: &str = "Motion blur";
pub(super) const OUTPUT: &str = "Output";
pub(super) const SERVER: &str = "Server";
pub(super) const PAPERS: &str = "Methods of the papers";
pub(super) const GENERAL: &str = "General";

/// All groups, as the help orders them.
const GROUPS: [&str; 18] = [
    CASES,
    MEASUREMENT,
    INPUT,
    HEADERLESS,
    DATA,
    CAMERA,
    MOTION,
    LOOK,
    LIGHT,
    METHOD,
    QUALITY,
    KERNEL,
    EFFECTS,
    BLUR,
    OUTPUT,
    SERVER,
    PAPERS,
    GENERAL,
];

/// Place in its group of what belongs at the end.
const LAST: usize = 1000;

/// Widest line of the help, in columns.
const WIDTH: usize = 100;

/// The arguments as typed; help, or what is wrong, where there is nothing to run.
pub(crate) fn parse(arguments: &[OsString]) -> Result<Cli, Error> {
    let matches = command().try_get_matches_from(arguments).map_err(with_tip)?;
    Cli::from_arg_matches(&matches)
}

/// Hints for a file where a command is due, which is to be rendered, and for `lab`, which needs a feature.
fn with_tip(mut error: Error) -> Error {
    let given = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(given)) if error.kind() == ErrorKind::InvalidSubcommand => given,
        _ => return error,
    };
    let tip = if given == "lab" {
        "this program is built without it; with it: cargo run --release --features lab -- lab".to_owned()
    } else if given.starts_with("sample:") || Path::new(given).exists() {
        format!("to make a picture of it: splatvol render {given}")
    } else {
        return error;
    };
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    error
}

/// The whole command with its help laid out.
fn command() -> Command {
    Cli::command()
        .max_term_width(WIDTH)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .arg(help_flag())
        .arg(version_flag())
        .mut_subcommands(|command| match short_flags(command.get_name()) {
            Some(flags) => shortened(grouped(command), flags),
            None => grouped(command),
        })
        .mut_subcommands(|command| command.mut_args(with_negative_numbers))
}

/// Flags take negative numbers, if only to say what they expect instead.
fn with_negative_numbers(arg: Arg) -> Arg {
    match arg.is_positional() || !arg.get_action().takes_values() {
        true => arg,
        false => arg.allow_negative_numbers(true),
    }
}

/// Arguments that the short help of a command shows beside the general ones; `None` shows all.
fn short_flags(command: &str) -> Option<&'static str> {
    match command {
        "render" => Some(
            "input view azimuth elevation zoom cmap opacity clim iso clip_box clip_plane preset compositing \
             output size background like overwrite stats threads",
        ),
        "animate" => Some(
            "input view elevation turntable path frames fps ease shutter cmap opacity clim iso preset output \
             size background overwrite threads",
        ),
        "bench" => Some(
            "inputs scenes quick looks projection threads frames warm_up orbit counts preset size json \
             first_frame overwrite",
        ),
        "export" => Some(
            "input view azimuth elevation zoom cmap opacity clim iso preset output max_size quantize title size overwrite \
             threads",
        ),
        "serve" => Some(
            "input view azimuth elevation zoom cmap opacity clim iso preset port bind host idle title size threads",
        ),
        "info" => Some("input kernel kind time channel series json bins"),
        "convert" => Some("input output clim unit_distance time channel series overwrite"),
        _ => None,
    }
}

/// Sorts a command's arguments by group.
fn grouped(command: Command) -> Command {
    let mut ids: Vec<_> = command
        .get_arguments()
        .map(|arg| (rank(arg), arg.get_id().clone()))
        .collect();
    ids.sort_by_key(|(rank, _)| *rank);
    // The help's groups follow the first argument of each; an argument that is changed becomes the last.
    ids.into_iter()
        .fold(command, |command, (_, id)| command.mut_arg(id, |arg| arg))
}

/// Place of an argument's group; those without one come first, as they do in the help.
fn rank(arg: &Arg) -> usize {
    let heading = arg.get_help_heading();
    heading.map_or(0, |heading| {
        let place = GROUPS.iter().position(|group| *group == heading);
        1 + place.unwrap_or(GROUPS.len())
    })
}

/// Leaves all but `flags` out of the short help, which then says where the others are.
fn shortened(command: Command, flags: &str) -> Command {
    let name = command.get_name();
    let examples = command.get_after_help().map(ToString::to_string);
    let all = format!("splatvol {name} --help shows all flags, by group.");
    let end = format!("{all} {}", examples.unwrap_or_default());
    command.after_help(end).mut_args(|arg| {
        let shown = flags.split_whitespace().any(|flag| arg.get_id() == flag);
        arg.hide_short_help(!shown)
    })
}

fn help_flag() -> Arg {
    Arg::new("help")
        .short('h')
        .long("help")
        .action(ArgAction::Help)
        .global(true)
        .help_heading(GENERAL)
        .display_order(LAST)
        .help("Print this summary; --help prints all")
        .long_help("Print this help; -h prints a summary")
}

fn version_flag() -> Arg {
    Arg::new("version")
        .short('V')
        .long("version")
        .action(ArgAction::Version)
        .global(true)
        .hide_short_help(true)
        .help_heading(GENERAL)
        .display_order(LAST)
        .help("Print the version")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_and_flags_of_the_help_are_known() {
        let command = command();
        command.clone().debug_assert();
        for sub in command.get_subcommands() {
            let ids: Vec<_> = sub.get_arguments().map(|arg| arg.get_id().as_str()).collect();
            for flag in short_flags(sub.get_name())
                .into_iter()
                .flat_map(str::split_whitespace)
            {
                assert!(ids.contains(&flag), "{} has no {flag}", sub.get_name());
            }
            let ranks: Vec<_> = sub.get_arguments().map(rank).collect();
            assert!(
                ranks.is_sorted() && ranks.iter().all(|rank| *rank <= GROUPS.len()),
                "{}",
                sub.get_name()
            );
        }
    }
}
