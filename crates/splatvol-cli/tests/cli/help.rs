//! The help's extent and groups, and hints for misspelt words.

use crate::sandbox::Sandbox;

const COMMANDS: &[&str] = &[
    "render",
    "animate",
    "info",
    "sample",
    "convert",
    "export",
    "compare",
    "bench",
    #[cfg(feature = "lab")]
    "lab",
];

#[test]
fn the_short_help_fits_on_a_screen() {
    let sandbox = Sandbox::new();
    for command in COMMANDS.iter().chain(&[""]) {
        let text = sandbox.run(&format!("{command} -h")).succeeds().stdout();
        assert!(
            text.lines().count() <= 45,
            "{} lines\n{text}",
            text.lines().count()
        );
        assert!(text.contains("Examples:"), "{text}");
        let long = sandbox.run(&format!("{command} --help")).succeeds().stdout();
        for line in text.lines().chain(long.lines()) {
            assert!(line.chars().count() <= 100, "{command}: {line}");
        }
        if long.lines().count() > 80 {
            let all = format!("splatvol {command} --help shows all flags, by group.");
            assert!(text.contains(&all), "{text}");
        }
    }
}

#[test]
fn the_long_help_is_in_groups() {
    let text = Sandbox::new().run("render --help").succeeds().stdout();
    let groups = [
        "Arguments",
        "Input",
        "Files without a header",
        "Points, Gaussians, meshes and terrain",
        "Camera and clipping",
        "Colour and opacity",
        "Light",
        "Method",
        "Quality",
        "Kernel",
        "Effects",
        "Motion blur",
        "Output",
        "Methods of the papers",
        "General",
    ];
    let found: Vec<_> = text
        .lines()
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.strip_suffix(':'))
        .filter(|line| *line != "Examples" && !line.starts_with("A scene"))
        .collect();
    assert_eq!(found, groups);
    let papers = text
        .split("Methods of the papers:")
        .nth(1)
        .and_then(|rest| rest.split("General:").next());
    for flag in [
        "--alignment",
        "--stretch",
        "--rasterizer",
        "--table-entries",
        "--occlusion",
        "--absorption",
    ] {
        assert!(papers.unwrap().contains(flag), "{flag}");
    }
}

#[test]
fn misspelt_words_get_the_nearest_right_one() {
    let sandbox = Sandbox::new();
    sandbox.write("a.nrrd", "");
    for (arguments, nearest) in [
        ("rendr", "'render'"),
        ("a.nrrd", "splatvol render a.nrrd"),
        ("sample:head", "splatvol render sample:head"),
        ("render a.nrrd --azimut 3", "'--azimuth'"),
        ("render a.nrrd --rasteriser rlut", "'--rasterizer'"),
        ("animate a.nrrd --turntabel 3", "'--turntable'"),
        ("render a.nrrd --preset fst", "'fast'"),
        ("render a.nrrd --compositing x-ray", "'xray'"),
        ("render a.nrrd --view frnt", "'front'"),
        ("render a.nrrd --cmap virids", "'viridis'"),
        ("render a.nrrd --opacity sigmid", "'sigmoid'"),
        ("render a.nrrd --background whit", "'white'"),
        ("render a.nrrd --kind volum", "'volume'"),
        ("info a.nrrd --dims 1x1x1 --type uu16", "'u16'"),
        ("bench --looks opak", "'opaque'"),
        ("sample hed -o b.nrrd", "\"head\""),
    ] {
        sandbox.run(arguments).fails(2, &[nearest]);
    }
    if cfg!(feature = "lab") {
        sandbox
            .run("lab swan1997-cheker")
            .fails(2, &["'swan1997-checker'"]);
    } else {
        sandbox.run("lab").fails(2, &["--features lab"]);
    }
    sandbox.run("render sample:heda").fails(3, &["\"head\""]);
}
