//! `splatvol render`, end to end.

use crate::sandbox::{Sandbox, png};

const TINY: &str = "render sample:ball:24 --size 40x32";

#[test]
fn the_output_is_named_after_the_input_and_never_overwritten_unasked() {
    let sandbox = Sandbox::new();
    let run = sandbox.run(TINY).succeeds();
    assert!(run.stderr().contains("wrote ball.png (40x32"), "{}", run.stderr());
    let before = sandbox.bytes("ball.png");
    sandbox
        .run(&format!("{TINY} --background white"))
        .fails(5, &["ball.png already exists", "-w"]);
    assert_eq!(sandbox.bytes("ball.png"), before);
    sandbox.run(&format!("{TINY} --background white -w")).succeeds();
    assert_ne!(sandbox.bytes("ball.png"), before);
    assert_eq!(sandbox.files(), ["ball.png"]);
}

#[test]
fn the_picture_shows_the_ball_on_the_background() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&format!("{TINY} --background #ff0000 -o a.png"))
        .succeeds();
    let (width, height, codes) = png(&sandbox.path("a.png"));
    assert_eq!((width, height), (40, 32));
    let channels = codes.len() / (40 * 32);
    assert_eq!(&codes[..3], [255, 0, 0]);
    let middle = (16 * 40 + 20) * channels;
    assert_ne!(&codes[middle..middle + 3], [255, 0, 0]);
}

#[test]
fn threads_do_not_change_a_byte() {
    let sandbox = Sandbox::new();
    let picture = |threads: usize| {
        let arguments = format!("render sample:head:40 --size 70x90 --view front -o - --threads {threads}");
        sandbox.run(&arguments).succeeds().stdout_bytes().to_vec()
    };
    // The command is part of the metadata; only the pixels must agree.
    let pixels = |threads: usize| {
        sandbox.write("t.png", picture(threads));
        png(&sandbox.path("t.png"))
    };
    let one = pixels(1);
    assert_eq!(one, pixels(2));
    assert_eq!(one, pixels(7));
}

#[test]
fn like_makes_the_same_file_again() {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:shells:32 --size 33 --azimuth 17.3 --zoom 1.1 --cmap magma --opacity sigmoid --bits 16 --background 0.1,0.2,0.3,0.4 --pixel-sigma 0.55 --light -0.3,-0.5,-1 -o a.png")
        .succeeds();
    sandbox.run("render --like a.png -o b.png").succeeds();
    assert_eq!(sandbox.bytes("a.png"), sandbox.bytes("b.png"));
    // From another folder, by its own name.
    sandbox
        .run("render sample:shells:32 --like a.png -o c.png")
        .succeeds();
    assert_eq!(sandbox.bytes("a.png"), sandbox.bytes("c.png"));
}

#[test]
fn explicit_flags_beat_like() {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:ball:20 --size 24 --no-shade --view left -o a.png")
        .succeeds();
    sandbox
        .run("render --like a.png --shade --azimuth 30 -o b.png")
        .succeeds();
    sandbox
        .run("render sample:ball:20 --size 24 --view left --azimuth 30 -o c.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("b.png")), png(&sandbox.path("c.png")));
    assert_ne!(png(&sandbox.path("a.png")), png(&sandbox.path("b.png")));
    sandbox
        .run("render --like a.png --size 12x13 -o d.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("d.png")).1, 13);
}

#[test]
fn like_finds_a_file_beside_the_picture() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("data")).unwrap();
    sandbox.run("sample ball --size 16 -o ball.nrrd").succeeds();
    sandbox.run("render ball.nrrd --size 20 -o a.png").succeeds();
    std::fs::rename(sandbox.path("ball.nrrd"), sandbox.path("data/ball.nrrd")).unwrap();
    std::fs::rename(sandbox.path("a.png"), sandbox.path("data/a.png")).unwrap();
    sandbox.run("render --like data/a.png -o b.png").succeeds();
    assert_eq!(sandbox.bytes("data/a.png"), sandbox.bytes("b.png"));
}

#[test]
fn like_refuses_pictures_that_do_not_say_how_they_were_made() {
    let sandbox = Sandbox::new();
    sandbox.run(&format!("{TINY} -o a.png")).succeeds();
    sandbox.run("compare a.png a.png -o difference.png").succeeds();
    sandbox
        .run("render --like difference.png -o b.png")
        .fails(3, &["difference.png", "does not say how it was made"]);
    sandbox.run("render --like absent.png").fails(3, &["absent.png"]);
}

#[test]
fn exr_keeps_alpha_depth_and_the_recipe() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&format!("{TINY} --background none -o a.exr"))
        .succeeds();
    sandbox.run("render --like a.exr -o b.exr").succeeds();
    assert_eq!(sandbox.bytes("a.exr"), sandbox.bytes("b.exr"));
    sandbox
        .run(&format!("{TINY} --background none --bits 16 -o a.png"))
        .succeeds();
    let text = sandbox.run("compare a.exr a.png --json").succeeds().stdout();
    let difference: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(difference["max-error"].as_f64().unwrap() < 2e-4, "{text}");
}

#[test]
fn a_transparent_png_has_alpha() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&format!("{TINY} --background none -o a.png"))
        .succeeds();
    let (width, height, codes) = png(&sandbox.path("a.png"));
    assert_eq!(codes.len(), 4 * (width * height) as usize);
    assert_eq!(codes[3], 0);
    assert!(codes.chunks_exact(4).any(|pixel| pixel[3] > 100));
}

#[test]
fn every_method_renders() {
    let sandbox = Sandbox::new();
    for (i, flags) in [
        "--compositing mip",
        "--compositing minip",
        "--compositing mean --cmap viridis",
        "--gradient-floor 0.1",
        "--compositing xray",
        "--classification pre --sheet-thickness 1",
        "--filter none --no-prefilter --kernel-sigma 1 --kernel-radius 2.5",
        "--no-shade --orthographic --view top",
        "--orthographic=12 --camera-pos 0,40,3 --camera-target 0,0,1",
        "--iso 0.5 --specular 0.4 --specular-power 40",
        "--iso 0.5 --cmap viridis --clim 0,1",
        "--cmap gray_r",
        "--opacity foreground --clim 0,1 --unit-distance 2",
        "--fit volume --elevation -20 --termination 0",
    ]
    .into_iter()
    .enumerate()
    {
        sandbox
            .run(&format!("render sample:ball:20 --size 24 {flags} -o {i}.png"))
            .succeeds();
        let (_, _, codes) = png(&sandbox.path(&format!("{i}.png")));
        assert!(
            codes.iter().any(|&code| code != codes[0]),
            "{flags}: an empty picture"
        );
    }
}

#[test]
fn presets_set_the_method_and_are_remembered() {
    let sandbox = Sandbox::new();
    let picture = |name: &str| png(&sandbox.path(name));
    sandbox.run(&format!("{TINY} -o default.png")).succeeds();
    sandbox
        .run(&format!("{TINY} --preset best -o best.png"))
        .succeeds();
    sandbox
        .run(&format!("{TINY} --preset fast -o fast.png"))
        .succeeds();
    sandbox
        .run(&format!("{TINY} --preset balanced -o balanced.png"))
        .succeeds();
    assert_eq!(picture("default.png"), picture("balanced.png"));
    assert_ne!(picture("default.png"), picture("best.png"));
    assert_ne!(picture("default.png"), picture("fast.png"));
    sandbox.run("render --like fast.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("fast.png"), sandbox.bytes("again.png"));
    sandbox
        .run("render --like fast.png --preset best -o like-best.png")
        .succeeds();
    assert_eq!(picture("best.png"), picture("like-best.png"));
    sandbox
        .run(&format!(
            "{TINY} --preset fast --sheet-thickness 0.25 -o flag.png"
        ))
        .succeeds();
    assert_ne!(picture("fast.png"), picture("flag.png"));
    sandbox
        .run(&format!("{TINY} --preset slow"))
        .fails(2, &["best", "balanced", "fast"]);
}

#[test]
fn the_picture_of_a_file_is_that_of_the_sample() {
    let sandbox = Sandbox::new();
    sandbox.run("sample slab --size 20 -o slab.nrrd").succeeds();
    let flags = "--size 20 --cmap viridis --opacity linear --clim 0,1";
    sandbox
        .run(&format!("render slab.nrrd {flags} -o a.png"))
        .succeeds();
    sandbox
        .run(&format!("render sample:slab:20 {flags} -o b.png"))
        .succeeds();
    assert_eq!(png(&sandbox.path("a.png")), png(&sandbox.path("b.png")));
}

#[test]
fn raw_files_need_dims_and_type() {
    let sandbox = Sandbox::new();
    let values: Vec<u8> = (0..8 * 8 * 8).map(|i| (i % 8 * 30) as u8).collect();
    sandbox.write("a.raw", &values);
    sandbox
        .run("render a.raw --size 16")
        .fails(3, &["--dims and --type"]);
    sandbox
        .run("render a.raw --size 16 --dims 8x8x8")
        .fails(2, &["--type"]);
    sandbox
        .run("render a.raw --size 16 --dims 8x8x9 --type u8")
        .fails(3, &["a.raw"]);
    sandbox
        .run("render a.raw --size 16 --dims 8x8x8 --type u8 --spacing 1,1,2")
        .succeeds();
    sandbox.run("render --like a.png -o b.png").succeeds();
    assert_eq!(sandbox.bytes("a.png"), sandbox.bytes("b.png"));
}

#[test]
fn transfer_functions_are_read_and_may_be_stretched() {
    let sandbox = Sandbox::new();
    let tf =
        r#"[{"Name":"t","ColorSpace":"RGB","RGBPoints":[0,1,0,0,1,0,0,1],"Points":[0,0,0.5,0,1,0.8,0.5,0]}]"#;
    sandbox.write("tf.json", tf);
    sandbox
        .run("render sample:ball:20 --size 16 --tf tf.json -o a.png")
        .succeeds();
    sandbox
        .run("render sample:ball:20 --size 16 --tf tf.json --clim 0.3,0.9 -o b.png")
        .succeeds();
    assert_ne!(png(&sandbox.path("a.png")), png(&sandbox.path("b.png")));
    sandbox
        .run("convert tf.json tf.vp.json --unit-distance 1")
        .succeeds();
    // ParaView's 0..1 is stretched over the data; Slicer's values are data values.
    let slicer = "render sample:ball:20 --size 16 --tf tf.vp.json";
    sandbox.run(&format!("{slicer} -o d.png")).succeeds();
    sandbox
        .run("render sample:ball:20 --size 16 --tf tf.json --clim 0,1 -o e.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("d.png")), png(&sandbox.path("e.png")));
    sandbox
        .run(&format!("{slicer} --clim 0.3,0.9 -o f.png"))
        .succeeds();
    assert_eq!(png(&sandbox.path("b.png")), png(&sandbox.path("f.png")));
    sandbox
        .run("render sample:ball:20 --size 16 --tf absent.json -o c.png")
        .fails(3, &["absent.json"]);
    sandbox
        .run("render sample:ball:20 --size 16 --tf tf.json --cmap gray -o c.png")
        .fails(2, &["cannot be used with"]);
}

#[test]
fn statistics_are_json() {
    let sandbox = Sandbox::new();
    let text = sandbox.run(&format!("{TINY} --stats - -q")).succeeds().stdout();
    let statistics: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(statistics["seconds"]["total"].as_f64().unwrap() > 0.0);
    sandbox
        .run(&format!("{TINY} -o - --stats -"))
        .fails(2, &["stdout"]);
}

#[test]
fn quiet_is_silent() {
    let sandbox = Sandbox::new();
    let run = sandbox.run(&format!("{TINY} -q")).succeeds();
    assert_eq!((run.stdout(), run.stderr()), (String::new(), String::new()));
}

#[test]
fn mistakes_are_named_with_their_exit_code() {
    let sandbox = Sandbox::new();
    for (arguments, code, words) in [
        ("render", 2, &["INPUT"][..]),
        ("render sample:ball --size 0", 2, &["--size"]),
        ("render sample:ball --kernel-sigma 99", 2, &["kernel sigma", "99"]),
        ("render sample:ball --camera-fov 200", 2, &["camera fov", "200"]),
        ("render sample:ball --zoom 0", 2, &["zoom: 0"]),
        ("render sample:ball --cmap nope", 2, &["nope"]),
        (
            "render sample:ball --camera-pos 1,2,3 --camera-target 1,2,3",
            2,
            &["camera target"],
        ),
        ("render sample:ball -o a.gif", 2, &["a.gif", ".png or .exr"]),
        ("render sample:bal", 3, &["\"bal\"", "did you mean \"ball\""]),
        ("render sample:ball:0", 3, &["size 0x0x0"]),
        ("render absent.nrrd", 3, &["absent.nrrd"]),
        ("render head", 3, &["sample:head"]),
        ("render sample:ball -o nowhere/a.png", 5, &["nowhere"]),
    ] {
        sandbox.run(arguments).fails(code, words);
    }
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}
