//! `splatvol info`, `sample`, `convert` and `compare`, end to end.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::sandbox::Sandbox;

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn help_has_examples_for_every_command() {
    let sandbox = Sandbox::new();
    for command in [
        "render", "animate", "info", "sample", "convert", "export", "compare", "bench",
    ] {
        let text = sandbox.run(&format!("{command} --help")).succeeds().stdout();
        assert!(
            text.contains("Examples:") && text.contains(&format!("splatvol {command}")),
            "{text}"
        );
    }
    assert!(
        sandbox
            .run("--version")
            .succeeds()
            .stdout()
            .starts_with("splatvol ")
    );
    sandbox.run("").exits(2);
    sandbox.run("dance").fails(2, &["dance"]);
}

#[test]
fn info_describes_a_volume() {
    let sandbox = Sandbox::new();
    let text = sandbox.run("info sample:head:32").succeeds().stdout();
    for words in ["32 x 32 x 32", "8, 8, 8 mm", "RAS", "histogram", "64 KiB", "none"] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
    let report = json(
        &sandbox
            .run("info sample:slab:16 --json --bins 4")
            .succeeds()
            .stdout(),
    );
    assert_eq!(report["dims"], serde_json::json!([16, 8, 8]));
    assert_eq!(report["histogram"].as_array().unwrap().len(), 4);
    assert_eq!(
        (report["min"].as_f64(), report["max"].as_f64()),
        (Some(0.0), Some(1.0))
    );
    assert!(report["transfer-function"]["opacities"].is_array());
}

#[test]
fn info_counts_missing_samples_and_repeats_warnings() {
    let sandbox = Sandbox::new();
    let mut bytes = Vec::new();
    for i in 0..4 * 4 * 4 {
        bytes.extend(if i < 16 { f32::NAN } else { i as f32 }.to_le_bytes());
    }
    sandbox.write("a.raw", &bytes);
    let text = sandbox
        .run("info a.raw --dims 4x4x4 --type f32")
        .succeeds()
        .stdout();
    assert!(text.contains("16 (25.00 %)"), "{text}");
}

#[test]
fn samples_are_listed_and_written() {
    let sandbox = Sandbox::new();
    let list = sandbox.run("sample").succeeds().stdout();
    for name in [
        "head",
        "marschner-lobb",
        "checker-sheet",
        "tunnel",
        "zebra",
        "shells",
        "ball",
        "slab",
        "terrain",
        "microtubules",
        "nerve",
        "tomato",
    ] {
        assert!(
            list.lines().any(|line| line.starts_with(name)),
            "no {name} in\n{list}"
        );
    }
    sandbox.run("sample ball --size 9x8x7 -o ball.nrrd").succeeds();
    let report = json(&sandbox.run("info ball.nrrd --json").succeeds().stdout());
    assert_eq!(report["dims"], serde_json::json!([9, 8, 7]));
    sandbox
        .run("sample ball --size 9x8x7 -o ball.nrrd")
        .fails(5, &["already exists"]);
    sandbox
        .run("sample bal -o b.nrrd")
        .fails(2, &["did you mean \"ball\""]);
    sandbox.run("sample ball -o b.tiff").fails(2, &[".nrrd or .npy"]);
    sandbox.run("sample ball").fails(2, &["--output"]);
    assert_eq!(sandbox.files(), ["ball.nrrd"]);
}

#[test]
fn volumes_survive_conversion() {
    let sandbox = Sandbox::new();
    sandbox.run("convert sample:head:24 a.nrrd").succeeds();
    let equal = |other: &str| {
        let run = sandbox
            .run(&format!("compare sample:head:24 {other} --json"))
            .succeeds();
        let difference = json(&run.stdout());
        assert_eq!(difference["differing-samples"], 0, "{difference}");
        difference["max-displacement"].as_f64().unwrap()
    };
    assert!(equal("a.nrrd") < 1e-9);
    let run = sandbox.run("convert a.nrrd b.npy").succeeds();
    assert!(run.stderr().contains("spacing"), "{}", run.stderr());
    // NumPy has no spacing: the grid moves, the samples do not.
    assert!(equal("b.npy") > 1.0);
    sandbox
        .run("convert a.nrrd c.mha")
        .fails(2, &["c.mha", ".nrrd or .npy"]);
    sandbox
        .run("convert absent.nrrd c.npy")
        .fails(3, &["absent.nrrd"]);
}

#[test]
fn volumes_become_ome_zarr_with_levels() {
    let sandbox = Sandbox::new();
    let convert = "convert sample:head:40 a.ome.zarr --chunk 16";
    sandbox.run(convert).succeeds();
    let run = sandbox.run("compare sample:head:40 a.ome.zarr --json").succeeds();
    let difference = json(&run.stdout());
    assert_eq!(difference["differing-samples"], 0, "{difference}");
    // Samples lie at the middles of the boxes that they cover.
    let half = json(
        &sandbox
            .run("info a.ome.zarr --level 1 --json")
            .succeeds()
            .stdout(),
    );
    assert_eq!(half["dims"], serde_json::json!([20, 20, 20]));
    sandbox
        .run("render a.ome.zarr --level 2 --size 16 -o a.png")
        .succeeds();
    sandbox.run(convert).fails(5, &["already exists", "-w"]);
    sandbox
        .run(&format!("{convert} -w --ome-version 0.4 --compression zlib"))
        .succeeds();
    sandbox
        .run("convert a.ome.zarr b.ome.zarr --memory 20M --levels 1")
        .succeeds();
    let run = sandbox.run("compare sample:head:40 b.ome.zarr --json").succeeds();
    assert_eq!(json(&run.stdout())["differing-samples"], 0);
    sandbox
        .run("convert a.ome.zarr c.ome.zarr --memory 100K")
        .fails(5, &["c.ome.zarr", "limit"]);
    sandbox
        .run("convert a.ome.zarr c.nrrd --levels 2")
        .fails(2, &["--levels", ".ome.zarr"]);
}

/// Files of a folder and those below, with their contents.
fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(at) = folders.pop() {
        for entry in std::fs::read_dir(&at).expect("the folder is there") {
            let path = entry.expect("entries can be read").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("it lies below").to_owned();
                found.insert(name, std::fs::read(&path).expect("files can be read"));
            }
        }
    }
    found
}

#[test]
fn conversions_that_were_killed_are_continued_to_the_same_bytes() {
    let sandbox = Sandbox::new();
    sandbox
        .run("convert sample:head:160 in.ome.zarr --chunk 16 --levels 1")
        .succeeds();
    let start = Instant::now();
    sandbox
        .run("convert in.ome.zarr whole.ome.zarr --chunk 16")
        .succeeds();
    let whole = start.elapsed();
    let continued = "convert in.ome.zarr killed.ome.zarr --chunk 16";
    let mut killed = 0;
    // Places of a sequence that fills 0 to 1 evenly.
    for i in 1..=10 {
        let after = whole.mul_f64(0.02 + 0.5 * (f64::from(i) * 0.618).fract());
        killed += u32::from(sandbox.kill(continued, after));
        if sandbox.path("killed.ome.zarr").exists() {
            break;
        }
    }
    assert!(killed > 0, "{whole:?}");
    if !sandbox.path("killed.ome.zarr").exists() {
        sandbox.run(continued).succeeds();
    }
    let [whole, killed] = ["whole", "killed"].map(|name| tree(&sandbox.path(&format!("{name}.ome.zarr"))));
    assert!(whole == killed);
    // Whoever is killed after the output took its place leaves an empty workshop.
    assert!(!sandbox.path("killed.ome.zarr.partial").join("store").exists());
    let mut files = sandbox.files();
    files.retain(|name| name != "killed.ome.zarr.partial");
    assert_eq!(files, ["in.ome.zarr", "killed.ome.zarr", "whole.ome.zarr"]);
}

#[test]
fn pictures_survive_conversion() {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:ball:16 --size 12 --background none -o a.png")
        .succeeds();
    sandbox.run("convert a.png b.exr").succeeds();
    sandbox.run("convert b.exr c.png").succeeds();
    let difference = json(&sandbox.run("compare a.png c.png --json").succeeds().stdout());
    assert_eq!(difference["psnr"], serde_json::Value::Null);
    // The settings are copied along.
    sandbox.run("render --like c.png -o d.png").succeeds();
    assert_eq!(sandbox.bytes("a.png"), sandbox.bytes("d.png"));
}

#[test]
fn transfer_functions_survive_conversion() {
    let sandbox = Sandbox::new();
    let tf = r#"[{"Name":"t","ColorSpace":"RGB","RGBPoints":[-100,1,0,0,300,0,0,1],"Points":[-100,0,0.5,0,300,0.8,0.5,0]}]"#;
    sandbox.write("a.json", tf);
    sandbox
        .run("convert a.json b.vp.json")
        .fails(5, &["unit distance"]);
    sandbox
        .run("convert a.json b.vp.json --unit-distance 1.5")
        .succeeds();
    sandbox.run("convert b.vp.json c.json").succeeds();
    let points = |name: &str| json(&String::from_utf8(sandbox.bytes(name)).unwrap())[0]["Points"].clone();
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_f64().unwrap())
            .collect()
    };
    assert_eq!(numbers(&points("c.json")), numbers(&points("a.json")));
}

#[test]
fn comparison_measures_and_shows_differences() {
    let sandbox = Sandbox::new();
    let render = "render sample:ball:16 --size 12";
    sandbox.run(&format!("{render} -o a.png")).succeeds();
    sandbox.run(&format!("{render} --no-shade -o b.png")).succeeds();
    let text = sandbox
        .run("compare a.png b.png -o difference.png")
        .succeeds()
        .stdout();
    assert!(text.contains("PSNR") && text.contains("SSIM"), "{text}");
    let difference = json(&sandbox.run("compare a.png b.png --json").succeeds().stdout());
    assert!(difference["psnr"].as_f64().unwrap() < 60.0 && difference["ssim"].as_f64().unwrap() < 1.0);
    sandbox
        .run("compare a.png b.png -o difference.png")
        .fails(5, &["already exists"]);
    sandbox.run(&format!("{render} --size 10 -o c.png")).exits(2);
    sandbox.run("render sample:ball:16 --size 10 -o c.png").succeeds();
    sandbox.run("compare a.png c.png").fails(2, &["12x12", "10x10"]);
    sandbox
        .run("compare a.png sample:ball:16")
        .fails(2, &["cannot be compared"]);
    sandbox
        .run("compare sample:ball:16 sample:ball:17")
        .fails(2, &["dims differ"]);
    sandbox.write("broken.png", b"\x89PNG\r\n\x1a\nno");
    sandbox.run("compare a.png broken.png").fails(3, &["broken.png"]);
}

#[test]
fn refusals_say_what_was_typed_and_what_is_expected() {
    let sandbox = Sandbox::new();
    sandbox.run("sample ball --size 8 -o a.nrrd").succeeds();
    sandbox.write("points.txt", "0 0 0\n1 1 1\n2 0 1\n");
    for (arguments, code, words) in [
        ("render a.nrrd --iso nan", 2, &["--iso", "expected a number"][..]),
        ("render a.nrrd --rotate 0,0,0:3", 2, &["other than 0,0,0"]),
        (
            "render a.nrrd --gradient-opacity 0:-1,5:1",
            2,
            &["0:-1: expected a gradient"],
        ),
        (
            "render a.nrrd --gradient-opacity 5:0,1:1",
            2,
            &["gradients that ascend"],
        ),
        ("render a.nrrd --level-bias -3", 2, &["level bias"]),
        ("render a.nrrd --zoom -1", 2, &["zoom"]),
        ("render a.nrrd --threads -1", 2, &["--threads"]),
        ("render a.nrrd --level 3", 3, &["level 3 was asked for", "NRRD"]),
        (
            "render sample:ball:8 --kind points",
            2,
            &["--kind", "a built-in sample is a volume"],
        ),
        (
            "convert a.nrrd b.npy --clim 1,2",
            2,
            &["--clim has no meaning for b.npy"],
        ),
        ("convert points.txt b.nrrd", 3, &["points; convert takes volumes"]),
        (
            "convert points.txt b.ome.zarr",
            3,
            &["points; convert takes volumes"],
        ),
        ("compare points.txt a.nrrd", 3, &["points; compare takes volumes"]),
    ] {
        let run = sandbox.run(&format!("{arguments} -w")).fails(code, words);
        let said = run.stderr();
        for clumsy in ["unexpected argument", " { ", "Some(", "Axis("] {
            assert!(!said.contains(clumsy), "{arguments}: {said}");
        }
    }
}

#[test]
fn pictures_that_show_nothing_say_so() {
    let sandbox = Sandbox::new();
    let run = sandbox
        .run("render sample:ball:8 --iso 5000 --size 16 -o a.png")
        .succeeds();
    let said = "nothing is visible: --iso 5000 lies outside the values";
    assert!(run.stderr().contains(said), "{}", run.stderr());
    let run = sandbox
        .run("animate sample:ball:8 --iso 5000 --size 16 --frames 2 -o a.gif")
        .succeeds();
    assert_eq!(run.stderr().matches(said).count(), 1, "{}", run.stderr());
    let run = sandbox.run("render sample:ball:8 --size 16 -o b.png").succeeds();
    assert!(!run.stderr().contains("visible"), "{}", run.stderr());
}

#[test]
fn a_picture_whose_data_are_elsewhere_says_how_to_name_them() {
    let sandbox = Sandbox::new();
    sandbox.run("sample ball --size 8 -o a.nrrd").succeeds();
    sandbox.run("render a.nrrd --size 16 -o p.png").succeeds();
    std::fs::remove_file(sandbox.path("a.nrrd")).unwrap();
    sandbox
        .run("render --like p.png -o q.png")
        .fails(3, &["a.nrrd", "hint:", "--like PICTURE"]);
}
