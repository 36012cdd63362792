//! Scenes that are read, and those that are not.

use super::*;

fn read(text: &str) -> Result<SceneFile, IoError> {
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
    assert_eq!(scene.settings.unwrap().sheet_thickness, 0.5);
    assert_eq!(scene.camera.unwrap().fov, Some(20.0));
}

#[test]
fn scenes_come_back_from_json_as_they_were() {
    let scene =
        read("[[item]]\nfile = 'a.ply'\nrotate = [[1, 1, 0], 30]\nscale = 0.1\nopacity = 0.3\n").unwrap();
    let json = serde_json::to_string(&scene).unwrap();
    assert_eq!(serde_json::from_str::<SceneFile>(&json).unwrap(), scene);
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
