//! Scenes that are read, and those that are not.

use glam::DVec3;

use super::*;
use crate::keys::{Axis, Opacity, Rotate};

fn read(text: &str) -> Result<Document, DocumentError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.ply"), "ply").unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    read_scene(&path)
}

#[track_caller]
fn refused(text: &str, words: &[&str]) {
    let error = read(text).unwrap_err().to_string();
    for word in words.iter().chain(&["scene.toml"]) {
        assert!(error.contains(word), "no {word:?} in {error}");
    }
}

#[test]
fn everything_is_read() {
    let scene = read(
        r#"
        background = "black"
        size = "64x32"
        [[item]]
        file = "a.ply"
        kind = "points"
        visible = false
        translate = [1, 2.5, 3]
        rotate = ["z", 90]
        scale = 2
        color = [1, 0.5, 0]
        opacity = 0.5
        radius = 0.1
        [[item]]
        file = "sample:head:32"
        cmap = "viridis"
        clim = [0, 10]
        opacity = "linear"
        rotate = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        scale = [1, 1, -1]
        [camera]
        view = "front"
        fov = 20
        [settings]
        sheet-thickness = 0.5
        gaussians = "volumetric"
        "#,
    )
    .unwrap();
    let [points, head] = &scene.items[..] else {
        panic!("{scene:?}")
    };
    assert!(points.file.ends_with("a.ply") && Path::new(&points.file).is_absolute());
    assert_eq!(points.visible, Some(false));
    assert_eq!(points.opacity, Some(Opacity::Share(0.5)));
    let place = points.world_from_file().unwrap();
    let moved = place.transform_point3(DVec3::X);
    assert!((moved - DVec3::new(1.0, 4.5, 3.0)).length() < 1e-12, "{moved}");
    assert_eq!(head.opacity, Some(Opacity::Curve("linear".to_owned())));
    let turned = head
        .world_from_file()
        .unwrap()
        .transform_point3(DVec3::new(1.0, 0.0, 1.0));
    assert!((turned - DVec3::new(0.0, 1.0, -1.0)).length() < 1e-12, "{turned}");
    assert_eq!(scene.settings.sheet_thickness, Some(0.5));
    assert_eq!(scene.camera.fov, Some(20.0));
    assert!(scene.name.is_some_and(|name| name.ends_with("scene.toml")));
}

#[test]
fn scenes_come_back_from_json_as_they_were() {
    let scene =
        read("[[item]]\nfile = 'a.ply'\nrotate = [[1, 1, 0], 30]\nscale = 0.1\nopacity = 0.3\n").unwrap();
    let json = scene.to_json(false).unwrap();
    assert_eq!(Document::from_json(&json, "a.json".as_ref()).unwrap(), scene);
    let axis = Axis::Direction([1.0, 1.0, 0.0]);
    assert_eq!(scene.items[0].rotate, Some(Rotate::Axis(axis, 30.0)));
}

#[test]
fn what_is_wrong_is_named() {
    refused(
        "[[item]]\nfile = 'a.ply'\nradios = 3\n",
        &["radios", "\"3\"", "line 3", "radius"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\nradius = 'big'\n",
        &["radius", "big", "line 3"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\nrotate = ['w', 3]\n",
        &["item[0].rotate", "w"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\nrotate = 3\n",
        &["rotate", "axis, degrees"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\nrotate = [[2,0,0],[0,2,0],[0,0,2]]\n",
        &["item[0].rotate"],
    );
    refused("[[item]]\nfile = 'a.ply'\nscale = 0\n", &["item[0].scale"]);
    refused(
        "[[item]]\nfile = 'a.ply'\ntranslate = [nan, 0, 0]\n",
        &["item[0].translate"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\n[settings]\nsheets = 3\n",
        &["sheets", "line 4"],
    );
    refused("[[item]]\nvisible = true\n", &["item[0].file"]);
    refused("item = []\n", &["item", "at least one"]);
    refused("background = 'black'\n", &["item"]);
    refused("[[item]\n", &["line 1"]);
    refused("[[item]]\nfile = 'b.ply'\n", &["b.ply", "does not exist"]);
    refused(
        "[[item]]\nfile = '../b.ply'\n",
        &["item[0].file", "../b.ply", "inside"],
    );
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_are_not_followed() {
    let (folder, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let secret = outside.path().join("a.ply");
    std::fs::write(&secret, "ply").unwrap();
    std::os::unix::fs::symlink(&secret, folder.path().join("a.ply")).unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, "[[item]]\nfile = 'a.ply'\n").unwrap();
    assert!(read_scene(&path).unwrap_err().to_string().contains("leads out"));
    std::fs::write(&path, format!("[[item]]\nfile = '{}'\n", secret.display())).unwrap();
    assert!(read_scene(&path).is_ok());
}

#[test]
fn scenes_of_version_1_are_read_and_later_ones_are_not() {
    let parts = "[[item]]\nfile = 'a.ply'\n[settings]\nfilter = { ewa = { pixel_sigma = 0.7 } }\n";
    let scene = read(parts).unwrap();
    assert_eq!((scene.version, scene.settings.pixel_sigma), (2, Some(0.7)));
    assert!(read(&format!("version = 1\n{parts}")).is_ok());
    let flat = "[[item]]\nfile = 'a.ply'\n[settings]\nfilter = 'ewa'\npixel-sigma = 0.7\n";
    let settings = |text: &str| read(text).unwrap().settings;
    assert_eq!(settings(&format!("version = 2\n{flat}")), settings(flat));
    refused(&format!("version = 2\n{parts}"), &["filter", "line"]);
    refused(&format!("version = 3\n{flat}"), &["version = 3", "later"]);
}

#[test]
fn endless_numbers_are_refused_with_their_key() {
    refused(
        "version = 2\n[camera]\nfov = nan\n",
        &["camera.fov = NaN", "finite"],
    );
    // Text without a version could be of either.
    refused(
        "[[item]]\nfile = 'a.ply'\n[camera]\nfov = -nan\n",
        &["camera.fov = NaN"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\ntranslate = [1.0, -inf, 0.0]\n",
        &["translate = -inf", "finite"],
    );
}

#[test]
fn misspelt_keys_and_names_are_guessed() {
    refused(
        "[[item]]\nfile = 'a.ply'\nradios = 3\n",
        &["did you mean `radius`"],
    );
    refused(
        "[[item]]\nfile = 'a.ply'\n[settings]\nfilter = 'matchd'\n",
        &["did you mean `matched`"],
    );
    refused(
        "background = 'whte'\n[[item]]\nfile = 'a.ply'\n",
        &["did you mean 'white'"],
    );
}

#[test]
fn lists_of_depth_images_are_no_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    for (text, expected) in [
        ("[[item]]\nfile = 'a'\n[animation]\nframes = 3\n", true),
        ("[[frame]]\ndepth = 'a.png'\n", false),
        ("frame = []\n", false),
    ] {
        std::fs::write(&path, text).unwrap();
        assert_eq!(is_scene(&path), expected, "{text}");
    }
}

#[test]
fn values_that_no_data_have_name_the_scene() {
    for (line, words) in [
        ("clim = [5, 1]", &["item[0].clim", "[5, 1]"][..]),
        ("clim = [5, 5]", &["item[0].clim", "[5, 5]"]),
        ("kind = 'zzz'", &["item[0].kind", "zzz"]),
        ("cmap = 'virids'", &["item[0].cmap", "did you mean 'viridis'?"]),
        (
            "opacity = 'liner'",
            &["item[0].opacity", "did you mean 'linear'?"],
        ),
        ("opacity = 2", &["item[0].opacity", "2"]),
        ("color = [2, 0, 0]", &["item[0].color"]),
        ("radius = -1", &["item[0].radius", "-1"]),
        ("rotate = ['w', 30]", &["item[0].rotate", "[\"w\", 30]"]),
    ] {
        refused(&format!("[[item]]\nfile = 'sample:head:32'\n{line}\n"), words);
    }
}
