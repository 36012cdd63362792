//! Every flag is a key, and every key a flag, except those that are named here.

use std::collections::{BTreeMap, BTreeSet};

use clap::{Arg, CommandFactory, FromArgMatches, Parser};
use serde_json::Value;
use splatvol_document::Document;

use crate::args::{Cli, Command};
use crate::failure::flag;

/// Flags that say nothing about the picture, only where it goes, where it comes from and how the work is
/// done.
const NO_KEYS: &str = "input second_input output depth overwrite like list_methods threads memory missing_chunks recipe partial engine stats strict allow_outside max_memory no_metadata no_effects resume quiet verbose help version";

/// Keys that are not flags: parts of a scene file, what `--like`, `--tf`, `--tf2d` and `--path` read from a file, and what an
/// animation records of a frame.
const NO_FLAGS: [&str; 10] = [
    "version",
    "name",
    "item.file",
    "item.visible",
    "item.transfer-function",
    "effects.regions",
    "motion.camera",
    "motion.sub-frames",
    "animation.key",
    "item",
];

/// Flags that exclude others given in this test, or need another: with those that they need.
const NEEDED: [(&str, &str); 7] = [
    ("spacing", "--dims 2x2x2 --type u8"),
    ("endian", "--dims 2x2x2 --type u8"),
    ("offset", "--dims 2x2x2 --type u8"),
    ("spin_axis", "--spin 3"),
    ("spin_centre", "--spin 3"),
    ("clip_inside", "--clip-box 0,1,0,1,0,1"),
    ("clip_outside", "--clip-box 0,1,0,1,0,1"),
];

fn keys(flags: &str) -> BTreeMap<String, Value> {
    keys_of(&document(&format!("animate sample:ball -o a.gif {flags}")))
}

/// The document of a command line.
fn document(line: &str) -> Document {
    let words = std::iter::once("splatvol").chain(line.split_whitespace());
    let parsed = Cli::try_parse_from(words);
    let command = parsed.unwrap_or_else(|error| panic!("{line}: {error}")).command;
    let file = Some("sample:ball");
    match command {
        Command::Animate(args) => args.document(file),
        Command::Render(args) => args.document(file),
        Command::Bench(args) => args.picture.document(args.size, file),
        _ => panic!("{line}"),
    }
}

fn keys_of(document: &Document) -> BTreeMap<String, Value> {
    let tree = serde_json::to_value(document).unwrap();
    let mut keys = BTreeMap::new();
    for (name, table) in tree.as_object().unwrap() {
        let table = if table.is_array() { &table[0] } else { table };
        match table.as_object() {
            Some(entries) => {
                keys.extend(
                    entries
                        .iter()
                        .map(|(key, value)| (format!("{name}.{key}"), value.clone())),
                );
            }
            None => _ = keys.insert(name.clone(), table.clone()),
        }
    }
    keys
}

/// A value that the flag takes.
fn sample(arg: &Arg) -> Option<String> {
    if !arg.get_action().takes_values() {
        return None;
    }
    if let Some(value) = arg.get_possible_values().last() {
        return Some(value.get_name().to_owned());
    }
    let value_name = arg.get_value_names().and_then(|names| names.first());
    let value = match (arg.get_id().as_str(), value_name.map(|name| name.as_str())) {
        ("cmap", _) => "viridis",
        ("opacity", _) => "linear",
        ("sample_type", _) => "u8",
        ("kind", _) => "volume",
        ("endian", _) => "big",
        ("gradient_opacity", _) => "0:0,9:1",
        ("clip_plane", _) => "0,0,0:0,0,1",
        ("clip_box", _) => "0,1,0,1,0,1",
        ("rotate", _) => "z:30",
        ("background", _) => "white",
        ("dims", _) => "2x2x2",
        ("posts" | "size", _) => "20x30",
        ("bits", _) => "16",
        ("clim" | "extract_density", _) => "1,2",
        (_, Some("X,Y,Z" | "R,G,B")) => "0.5,0.25,1",
        ("shutter", _) => "0.5",
        (_, Some("FILE" | "PICTURE" | "SERIES")) => "a.json",
        _ => "3",
    };
    Some(value.to_owned())
}

fn flags() -> Vec<Arg> {
    flags_of("animate")
}

/// Flags of a command that say something about the picture.
fn flags_of(command: &str) -> Vec<Arg> {
    let commands = Cli::command();
    let command = commands.find_subcommand(command).unwrap();
    let said = |arg: &&Arg| !NO_KEYS.split(' ').any(|name| arg.get_id() == name);
    command.get_arguments().filter(said).cloned().collect()
}

/// A flag as it is given, and those that it needs.
fn given(arg: &Arg) -> (String, &'static str) {
    let (id, long) = (arg.get_id().as_str(), arg.get_long().unwrap());
    let needed = NEEDED.iter().find(|(name, _)| *name == id);
    let needed = needed.map_or("", |(_, flags)| flags);
    let flag = match sample(arg) {
        // These two go together.
        _ if id == "dims" || id == "sample_type" => "--dims 2x2x2 --type u8".to_owned(),
        Some(value) => format!("--{long}={value}"),
        None => format!("--{long}"),
    };
    (format!("{flag} {needed}"), needed)
}

#[test]
fn every_flag_has_a_key_of_its_name() {
    for arg in flags() {
        let id = arg.get_id().as_str();
        let long = arg.get_long().unwrap();
        let (given, needed) = given(&arg);
        if id == "dims" || id == "sample_type" {
            let both = keys(&given);
            assert!(both.contains_key(&format!("item.{long}")), "{both:?}");
            continue;
        }
        let (without, with) = (keys(needed), keys(&given));
        let new: Vec<_> = with
            .iter()
            .filter(|(key, value)| without.get(*key) != Some(value))
            .collect();
        let [(key, _)] = &new[..] else {
            panic!("--{long} says {new:?}")
        };
        let positive = long.strip_prefix("no-").unwrap_or(long);
        let positive = positive
            .replace("clip-outside", "clip-inside")
            .replace("point-opacity", "opacity");
        assert_eq!(flag(key), format!("--{positive}"), "{key}");
    }
}

#[test]
fn every_key_has_a_flag() {
    let spoken: BTreeSet<String> = flags()
        .iter()
        .map(|arg| format!("--{}", arg.get_long().unwrap()))
        .collect();
    let root = serde_json::to_value(splatvol_document::schema()).unwrap();
    for (name, of_name) in root["properties"].as_object().unwrap() {
        let table = of_name["items"]["$ref"].as_str().or(of_name["$ref"].as_str());
        let table = table.and_then(|name| root.pointer(name.strip_prefix('#')?));
        let keys: Vec<String> = match table.and_then(|table| table["properties"].as_object()) {
            Some(keys) => keys.keys().map(|key| format!("{name}.{key}")).collect(),
            None => vec![name.clone()],
        };
        for key in keys.iter().filter(|key| !NO_FLAGS.contains(&key.as_str())) {
            assert!(spoken.contains(&flag(key)), "{key} has no {}", flag(key));
        }
    }
}

#[test]
fn flags_that_are_not_given_say_nothing() {
    let cli = Cli::command().get_matches_from(["splatvol", "render", "a.nrrd"]);
    let Command::Render(args) = Cli::from_arg_matches(&cli).unwrap().command else {
        panic!()
    };
    assert_eq!(args.document(None), Document::default());
}

#[test]
fn bench_takes_all_flags_of_render_that_say_something_about_the_picture() {
    let of_bench = flags_of("bench");
    for arg in flags_of("render") {
        let id = arg.get_id();
        let same = of_bench.iter().find(|other| other.get_id() == id);
        let same = same.unwrap_or_else(|| panic!("bench has no {id}"));
        assert_eq!(same.get_long(), arg.get_long());
        let (given, _) = given(&arg);
        let [shown, measured] =
            ["render", "bench"].map(|command| document(&format!("{command} sample:ball {given}")));
        assert_eq!(shown, measured, "{given}");
        let bare = document("bench sample:ball");
        assert!(bare != measured, "{given} says nothing");
    }
    // What an input is and how it is read says nothing about the picture, but bench must take it as well.
    let commands = Cli::command();
    let bench = commands.find_subcommand("bench").unwrap();
    for id in "like strict allow_outside max_memory no_effects".split(' ') {
        let has = bench.get_arguments().any(|arg| arg.get_id() == id);
        assert!(has, "bench has no {id}");
    }
}
