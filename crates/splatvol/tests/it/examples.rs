//! The examples run, as a user runs them, and what they write can be read and shows something.

use std::path::{Path, PathBuf};
use std::process::Command;

use splatvol_io::read_image;

/// The folder in which cargo puts examples. A run of all tests builds them; one of `--test it`, or with `--all-targets`, does not.
fn folder() -> PathBuf {
    let test = std::env::current_exe().expect("this test is a program");
    let profile = test.ancestors().nth(2).expect("tests are in PROFILE/deps");
    profile.join("examples")
}

/// Runs an example into a folder, and what it wrote.
fn run(name: &str, output: &str) -> (tempfile::TempDir, PathBuf) {
    let program = folder().join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.exists(),
        "{} is missing: cargo build -p splatvol --examples",
        program.display()
    );
    let target = tempfile::tempdir().expect("a folder for the example's file");
    let path = target.path().join(output);
    let result = Command::new(program)
        .arg(&path)
        .output()
        .expect("the example starts");
    let said = String::from_utf8_lossy(&result.stderr);
    assert!(result.status.success(), "{name}: {said}");
    (target, path)
}

/// The share of pixels with anything on them.
fn covered(path: &Path) -> f64 {
    let image = read_image(path).expect("the example's picture").image;
    let first = image.pixels[0];
    let other = image.pixels.iter().filter(|pixel| **pixel != first).count();
    other as f64 / image.pixels.len() as f64
}

#[test]
fn a_volume_becomes_a_png() {
    let (_folder, path) = run("01_volume_to_png", "head.png");
    assert!(covered(&path) > 0.1);
}

#[test]
fn own_data_become_a_picture() {
    let (_folder, path) = run("02_own_data", "orbital.png");
    assert!(covered(&path) > 0.1);
    let texts = read_image(&path).expect("the example's picture").metadata;
    let title = splatvol_io::image::metadata::find(&texts, "Title");
    assert_eq!(title, Some("3d orbital, m = 0"));
}

#[test]
fn settings_and_cameras_make_six_pictures() {
    let (_folder, path) = run("03_camera_and_settings", "methods.png");
    assert!(covered(&path) > 0.1);
}

#[test]
fn several_things_become_a_scene() {
    let (_folder, path) = run("04_scene", "scene.png");
    assert!(covered(&path) > 0.1);
}

#[test]
fn a_turntable_becomes_an_animation() {
    let (_folder, path) = run("05_turntable", "spin.png");
    assert!(covered(&path) > 0.1);
    let (_folder, path) = run("05_turntable", "spin.gif");
    let gif = std::fs::read(&path).expect("the example's animation");
    assert!(gif.starts_with(b"GIF89a") && gif.len() > 10_000);
}

#[test]
fn a_viewer_gives_views_up_and_shows_the_last() {
    let (_folder, path) = run("06_viewer_loop", "view.png");
    assert!(covered(&path) > 0.1);
}
