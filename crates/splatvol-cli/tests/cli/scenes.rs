//! Scenes of several things, end to end.

use crate::data::{gaussian, pixels, sphere};
use crate::sandbox::{Sandbox, png as picture};

const RED: fn([u8; 3]) -> bool = |[r, g, b]| r > 60 && u16::from(r) > 2 * u16::from(g.max(b));
const GREEN: fn([u8; 3]) -> bool = |[r, g, b]| g > 60 && u16::from(g) > 2 * u16::from(r.max(b));

/// A red and a green sphere, the second moved; `more` is appended to its keys.
fn two(sandbox: &Sandbox, more: &str) {
    sandbox.write("red.txt", sphere(2000, [0.0; 3], Some([255, 0, 0])));
    sandbox.write("bare.txt", sphere(2000, [0.0; 3], None));
    let scene = format!(
        "background = 'black'\nsize = '96x64'\n\
         [camera]\nview = 'front'\n\
         [[item]]\nfile = 'red.txt'\n\
         [[item]]\nfile = 'bare.txt'\ncolor = [0, 1, 0]\n{more}\n"
    );
    sandbox.write("scene.toml", scene);
}

/// The document in a picture, as text.
fn text(sandbox: &Sandbox, name: &str) -> String {
    let picture = splatvol_io::read_image(sandbox.path(name)).expect("it is there and whole");
    let text = splatvol_io::image::metadata::find(&picture.metadata, splatvol_io::image::metadata::SETTINGS);
    text.expect("splatvol made it").to_owned()
}

#[test]
fn items_lie_where_the_scene_says() {
    let sandbox = Sandbox::new();
    two(&sandbox, "translate = [4, 0, 0]");
    sandbox.run("render scene.toml").succeeds();
    assert_eq!(picture(&sandbox.path("scene.png")).0, 96);
    let ((red, [width, _]), (green, _)) = (
        pixels(&sandbox, "scene.png", RED),
        pixels(&sandbox, "scene.png", GREEN),
    );
    assert!(red > 400 && red.abs_diff(green) < red / 10, "{red} {green}");
    assert!(width < 40, "{width}");

    two(&sandbox, "translate = [4, 0, 0]\nvisible = false");
    sandbox.run("render scene.toml -w").succeeds();
    assert_eq!(pixels(&sandbox, "scene.png", GREEN).0, 0);
    assert!(pixels(&sandbox, "scene.png", RED).0 > 2 * red);

    // Within the red one, and then around it.
    two(&sandbox, "scale = 0.5");
    sandbox.run("render scene.toml -w").succeeds();
    assert_eq!(pixels(&sandbox, "scene.png", GREEN).0, 0);
    two(&sandbox, "scale = 1.5\nrotate = ['x', 90]");
    sandbox.run("render scene.toml -w").succeeds();
    assert_eq!(pixels(&sandbox, "scene.png", RED).0, 0);
    two(&sandbox, "scale = 1.5\nopacity = 0.3");
    sandbox.run("render scene.toml -w").succeeds();
    let reddish = |[r, g, _]: [u8; 3]| r > 40 && g > 20;
    assert!(pixels(&sandbox, "scene.png", reddish).0 > 300);
}

#[test]
fn flags_go_over_the_scene_and_pictures_are_made_again() {
    let sandbox = Sandbox::new();
    two(
        &sandbox,
        "translate = [4, 0, 0]\n[settings]\nsheet-thickness = 0.5",
    );
    sandbox
        .run("render scene.toml --size 50x40 --background white --view left --zoom 1.2")
        .succeeds();
    let (width, height, codes) = picture(&sandbox.path("scene.png"));
    assert_eq!((width, height), (50, 40));
    assert_eq!(codes[..3], [255; 3]);
    // Seen along the way from one to the other, red hides green or the other way round.
    assert!(
        pixels(&sandbox, "scene.png", RED)
            .0
            .min(pixels(&sandbox, "scene.png", GREEN).0)
            < 5
    );
    sandbox.run("render --like scene.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("scene.png"), sandbox.bytes("again.png"));
    let settings = text(&sandbox, "scene.png");
    assert!(settings.contains("\"sheet-thickness\":0.5"), "{settings}");
    for flags in ["--radius 1", "--cmap gray", "--array a", "--up y"] {
        sandbox
            .run(&format!("render scene.toml -w {flags}"))
            .fails(2, &["no meaning for a scene"]);
    }
}

#[test]
fn volumes_points_and_gaussians_share_a_picture() {
    let sandbox = Sandbox::new();
    sandbox.write("red.txt", sphere(1000, [0.0; 3], Some([255, 0, 0])));
    sandbox.write("green.ply", gaussian([0.0, 1.0, 0.0]));
    sandbox.write(
        "scene.toml",
        "background = 'black'\nsize = '96x48'\n[camera]\nview = 'front'\n\
         [[item]]\nfile = 'sample:marschner-lobb:16'\niso = 0.5\nscale = 0.1\n\
         [[item]]\nfile = 'red.txt'\ntranslate = [4, 0, 0]\n\
         [[item]]\nfile = 'green.ply'\nscale = 3\ntranslate = [-4, 0, 0]\n",
    );
    sandbox.run("render scene.toml").succeeds();
    let gray = |[r, g, b]: [u8; 3]| r > 60 && r.abs_diff(g) < 30 && g.abs_diff(b) < 60;
    for (what, count) in [
        ("red", pixels(&sandbox, "scene.png", RED).0),
        ("green", pixels(&sandbox, "scene.png", GREEN).0),
        ("gray", pixels(&sandbox, "scene.png", gray).0),
    ] {
        assert!(count > 40, "{what}: {count}");
    }
    sandbox
        .run("render scene.toml --gaussians 3dgs -w")
        .fails(2, &["3dgs", "volumetric"]);
    let text = sandbox.run("info scene.toml").succeeds().stdout();
    for words in [
        "sample:marschner-lobb:16 (volume)",
        "red.txt (points)",
        "green.ply (gaussians)",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
}

/// A scene of one item is the picture that its file gives alone: the same look, method, camera and bytes.
#[test]
fn a_scene_of_one_item_is_the_item() {
    let sandbox = Sandbox::new();
    sandbox.run("sample head -o head.npy --size 24").succeeds();
    sandbox.write("points.txt", sphere(500, [0.0; 3], Some([255, 0, 0])));
    for (file, flags, keys) in [
        ("head.npy", "", ""),
        ("head.npy", "--up=-x --iso 300", "up = '-x'\niso = 300"),
        ("sample:zebra:24", "", ""),
        ("points.txt", "", ""),
    ] {
        sandbox.write("one.toml", format!("[[item]]\nfile = '{file}'\n{keys}\n"));
        sandbox
            .run(&format!(
                "render {file} {flags} --size 64x48 --bits 16 -w -o alone.png"
            ))
            .succeeds();
        sandbox
            .run("render one.toml --size 64x48 --bits 16 -w -o item.png")
            .succeeds();
        assert!(
            picture(&sandbox.path("alone.png")) == picture(&sandbox.path("item.png")),
            "{file} {flags}"
        );
    }
}

/// Frames of an animation are the pictures of its cameras, and scenes are cut and moved as volumes are.
#[test]
fn scenes_are_animated_cut_and_moved() {
    let sandbox = Sandbox::new();
    two(&sandbox, "translate = [4, 0, 0]");
    sandbox
        .run("animate scene.toml --frames 2 --turntable 90 --size 40x30 -o f-#.png")
        .succeeds();
    sandbox.run("render --like f-1.png -o again.png").succeeds();
    assert_eq!(
        picture(&sandbox.path("f-1.png")),
        picture(&sandbox.path("again.png"))
    );
    sandbox
        .run("animate scene.toml --frames 2 --turntable 90 --size 40x30 -o f-#.png --resume")
        .succeeds();
    sandbox
        .run("render scene.toml --velocity 2,0,0 -o moved.png")
        .succeeds();
    sandbox
        .run("render --like moved.png -o moved-again.png")
        .succeeds();
    assert_eq!(sandbox.bytes("moved.png"), sandbox.bytes("moved-again.png"));
    sandbox.run("render scene.toml -o still.png").succeeds();
    assert_ne!(
        picture(&sandbox.path("moved.png")),
        picture(&sandbox.path("still.png"))
    );

    sandbox.write(
        "one.toml",
        "[[item]]\nfile = 'sample:head:24'\niso = 300\nup = 'z'\n",
    );
    for flags in [
        "--clip-plane 0,0,0:0,0,-1",
        "--texture marble",
        "--iso-exact",
        "--spin 20",
    ] {
        let flags = format!("{flags} --size 40x30 ");
        sandbox
            .run(&format!(
                "render sample:head:24 --iso 300 {flags} -o alone.png -w"
            ))
            .succeeds();
        sandbox
            .run(&format!("render one.toml {flags} -o item.png -w"))
            .succeeds();
        assert!(
            picture(&sandbox.path("alone.png")) == picture(&sandbox.path("item.png")),
            "{flags}"
        );
    }
    sandbox
        .run("render scene.toml --texture marble -w")
        .fails(2, &["one volume or one mesh alone"]);
    sandbox
        .run("render scene.toml --clip-plane 0,0,0:0,0,1 -o cut.png")
        .succeeds();
    let red = |name| pixels(&sandbox, name, RED).0;
    assert!(4 * red("cut.png") < 3 * red("still.png"));
}

#[test]
fn scenes_that_make_no_sense_say_why() {
    let sandbox = Sandbox::new();
    for (more, code, words) in [
        ("radios = 3", 3, vec!["radios", "scene.toml", "line"]),
        ("radius = 'x'", 3, vec!["radius", "scene.toml"]),
        ("radius = -1", 3, vec!["scene.toml", "item[1].radius", "-1"]),
        ("color = [2, 0, 0]", 3, vec!["color"]),
        ("iso = 3", 2, vec!["item[1].iso", "points"]),
        ("up = 'w'", 3, vec!["up", "'w'", "-x", "line"]),
        ("kind = 'cloud'", 3, vec!["item[1].kind", "terrain"]),
        ("[[item]]\nfile = 'missing.ply'", 3, vec!["missing.ply"]),
        (
            "[[item]]\nfile = '../red.txt'",
            3,
            vec!["item[2].file", "../red.txt"],
        ),
        (
            "[[item]]\nfile = 'scene.toml'",
            2,
            vec!["item[2].file", "scenes hold no scenes"],
        ),
        ("[[item]]\nfile = 'sample:nothing'", 3, vec!["nothing"]),
        ("[settings]\nsheets = 1", 3, vec!["sheets", "scene.toml"]),
        ("[settings]\nsheet-thickness = -1", 2, vec!["thickness"]),
        ("[camera]\nview = 'side'", 3, vec!["camera"]),
        (
            "[motion]\nspin = 3\nvelocity = [1, 0, 0]",
            2,
            vec!["motion.spin and motion.velocity"],
        ),
        (
            "[motion]\nspin = 3\nsubframes = 4000000000",
            2,
            vec!["motion.subframes", "4000000000"],
        ),
    ] {
        two(&sandbox, more);
        sandbox.run("render scene.toml -w").fails(code, &words);
    }
    for (scene, code, words) in [
        (
            "background = 'mauve'\n[[item]]\nfile = 'red.txt'",
            3,
            vec!["background", "charcoal", "line 1"],
        ),
        ("size = 'big'\n[[item]]\nfile = 'red.txt'", 3, vec!["size", "WxH"]),
        (
            "[camera]\nview = 'side'\n[[item]]\nfile = 'red.txt'",
            3,
            vec!["view", "side", "front"],
        ),
        (
            "[camera]\nview = 'front'\nposition = [1, 2, 3]\n[[item]]\nfile = 'red.txt'",
            2,
            vec!["camera.view and camera.position exclude each other"],
        ),
        (
            "[[item]]\nfile = 'red.txt'\nvisible = false",
            2,
            vec!["no item", "visible"],
        ),
    ] {
        sandbox.write("scene.toml", scene);
        sandbox.run("render scene.toml -w").fails(code, &words);
    }
}

/// Two channels of one file, each with a transfer function of its own.
#[test]
fn channels_have_transfer_functions_of_their_own() {
    let sandbox = Sandbox::new();
    let mut file =
        b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 12 12 12\nkinds: vector domain domain domain\n\
                     encoding: raw\n\n"
            .to_vec();
    let within = |range: std::ops::Range<usize>, at: usize| if range.contains(&at) { 255 } else { 0 };
    for voxel in 0..12 * 12 * 12 {
        let x = voxel % 12;
        file.extend([within(1..5, x), within(7..11, x)]);
    }
    sandbox.write("cells.nrrd", file);
    let item = |channel: usize, cmap: &str| {
        format!(
            "[[item]]\nfile = 'cells.nrrd'\nchannel = {channel}\ncmap = '{cmap}'\nclim = [0, 600]\nopacity = 'linear'\n"
        )
    };
    let head = "background = 'black'\nsize = '96x96'\n[camera]\nview = 'front'\n";
    let shown = |items: String| {
        sandbox.write("scene.toml", format!("{head}{items}"));
        sandbox.run("render scene.toml --no-shade -w").succeeds();
        let gray = pixels(&sandbox, "scene.png", |[r, g, b]| {
            r > 40 && r.abs_diff(g) < 8 && g.abs_diff(b) < 8
        });
        let warm = pixels(&sandbox, "scene.png", |[r, _, b]| {
            r > 60 && u16::from(r) > 2 * u16::from(b)
        });
        [gray.0, warm.0]
    };
    let both = shown(item(0, "gray") + &item(1, "hot"));
    let first = shown(item(0, "gray"));
    let second = shown(item(1, "hot"));
    assert!(first[0] > 200 && first[1] == 0, "{first:?}");
    assert!(second[1] > 200 && second[0] < 50, "{second:?}");
    assert!(both[0] > first[0] / 2 && both[1] > second[1] / 2, "{both:?}");
}

/// The example of docs/scenes.md runs.
#[test]
fn the_documented_example_renders() {
    let text = include_str!("../../../../docs/scenes.md");
    let example = text
        .split("```toml\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next());
    let sandbox = Sandbox::new();
    sandbox.write("electrodes.txt", sphere(500, [0.0; 3], None));
    sandbox.write("marker.ply", gaussian([0.2, 0.8, 1.0]));
    sandbox.write("scene.toml", example.expect("the page has an example"));
    sandbox.run("render scene.toml --size 64").succeeds();
    let (count, _) = pixels(&sandbox, "scene.png", |[r, g, b]| b > 100 && g > 100 && r < 100);
    assert!(count > 4, "{count}");
}
