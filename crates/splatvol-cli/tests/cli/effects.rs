//! Effects, clips and depth maps of `splatvol render`, end to end.

use crate::sandbox::{Sandbox, png};

const BALL: &str = "render sample:ball:24 --size 40x32 --view front";

/// A picture with a transparent border, as a bump map or surroundings.
fn with_picture() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:shells:24 --size 64x32 --background none -o p.png")
        .succeeds();
    sandbox
}

#[test]
fn every_effect_changes_the_picture_and_is_remembered() {
    let sandbox = with_picture();
    sandbox.write(
        "look.json",
        r#"{"regions": [{"value": [0.2, 1.5], "gradient": [0, 9], "rgb": [1, 0, 0], "opacity": 0.4}]}"#,
    );
    sandbox.run(&format!("{BALL} -o plain.png")).succeeds();
    let plain = png(&sandbox.path("plain.png"));
    for (i, flags) in [
        "--texture marble",
        "--texture wood --texture-scale 0.2",
        "--bump p.png --bump-height -0.05",
        "--environment p.png --environment-share 0.8",
        "--gradient-opacity 0:0.1,0.05:1",
        "--tf2d look.json",
        "--clip-plane=0,0,0:0,-1,0.2",
        "--clip-box=-9,0,-30,30,-9,9",
        "--clip-box=-9,0,-30,30,-9,9 --clip-inside",
        "--iso 0.5 --iso-exact",
    ]
    .into_iter()
    .enumerate()
    {
        let (own, again) = (format!("{i}.png"), format!("{i}-again.png"));
        sandbox.run(&format!("{BALL} {flags} -o {own}")).succeeds();
        assert_ne!(png(&sandbox.path(&own)), plain, "{flags}");
        sandbox.run(&format!("render --like {own} -o {again}")).succeeds();
        assert_eq!(sandbox.bytes(&own), sandbox.bytes(&again), "{flags}");
    }
    sandbox
        .run("render --like 0.png --no-effects -o without.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("without.png")), plain);
    sandbox
        .run("render --like 8.png --clip-outside -o outside.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("outside.png")), png(&sandbox.path("7.png")));
}

#[test]
fn regions_of_values_and_gradients_stand_in_a_file_or_in_the_scene() {
    let sandbox = with_picture();
    let regions = r#"[{"value": [0.2, 1.5], "gradient": [0, 9], "rgb": [1, 0, 0], "opacity": 0.4}]"#;
    sandbox.write("look.json", format!(r#"{{"regions": {regions}}}"#));
    sandbox
        .run(&format!("{BALL} --tf2d look.json -o file.png"))
        .succeeds();
    let scene = |effects: &str| format!("size = \"40x32\"\n[[item]]\nfile = \"sample:ball:24\"\n{effects}");
    let region =
        "[[effects.regions]]\nvalue = [0.2, 1.5]\ngradient = [0, 9]\nrgb = [1, 0, 0]\nopacity = 0.4\n";
    sandbox.write("scene.toml", scene(region));
    sandbox
        .run("render scene.toml --view front -o scene.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("scene.png")), png(&sandbox.path("file.png")));
    sandbox.run("render --like scene.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("scene.png"), sandbox.bytes("again.png"));
    // A file in place of the regions, and a look in place of both.
    sandbox
        .run("render --like scene.png --tf2d look.json -o other.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("other.png")), png(&sandbox.path("file.png")));
    sandbox
        .run("render --like scene.png --cmap viridis -o plain.png")
        .succeeds();
    assert_ne!(png(&sandbox.path("plain.png")), png(&sandbox.path("file.png")));
    for (effects, words) in [
        (
            format!("[effects]\ntf2d = \"look.json\"\n{region}"),
            "effects.tf2d",
        ),
        (region.replace("0.2, 1.5", "1.5, 0.2"), "the smaller first"),
        (
            format!("[[item]]\nfile = \"sample:shells:16\"\n{region}"),
            "regions",
        ),
    ] {
        sandbox.write("bad.toml", scene(&effects));
        sandbox.run("render bad.toml -w -o a.png").fails(2, &[words]);
    }
}

#[test]
fn combinations_without_meaning_are_refused() {
    let sandbox = with_picture();
    for (flags, code, words) in [
        ("--texture marble --compositing mip", 2, "one value of a ray"),
        (
            "--environment p.png --compositing xray",
            2,
            "X-rays have no sheets",
        ),
        ("--bump p.png --classification pre", 2, "post-classification"),
        ("--texture wood --preset best", 2, "gradients by differences"),
        (
            "--clip-plane 0,0,0:0,0,1 --compositing mip",
            2,
            "a clip cannot be rendered",
        ),
        ("--texture-scale 0.1", 2, "no meaning without --texture"),
        ("--clip-inside", 2, "no meaning without --clip-box"),
        ("--iso-exact", 2, "no meaning without --iso"),
        ("--clip-plane 0,0,0:0,0,0", 2, "clip plane's normal"),
        ("--clip-box 1,0,0,1,0,1", 2, "the smaller of each pair first"),
        ("--gradient-opacity 3", 2, "GRADIENT:FACTOR"),
        ("--bump absent.png", 3, "absent.png"),
        ("--depth a.txt", 2, "no depth format"),
    ] {
        sandbox
            .run(&format!("{BALL} {flags} -o a.png"))
            .fails(code, &[words]);
    }
    for flags in ["--compositing xray", "--classification pre"] {
        sandbox
            .run(&format!("{BALL} {flags} --clip-plane 0,0,0:1,0,0 -w -o a.png"))
            .succeeds();
    }
}

#[test]
fn depth_maps_agree_in_all_formats() {
    let sandbox = Sandbox::new();
    for name in ["d.npy", "d.png", "d.exr"] {
        sandbox
            .run(&format!("{BALL} --depth {name} -w -o a.png"))
            .succeeds();
    }
    let npy = sandbox.bytes("d.npy");
    let floats: Vec<f64> = npy[npy.len() - 40 * 32 * 4..]
        .chunks_exact(4)
        .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
        .collect();
    let (near, far) = floats
        .iter()
        .filter(|d| d.is_finite())
        .fold((f64::MAX, 0.0f64), |(near, far), &d| (near.min(d), far.max(d)));
    assert!(floats[0].is_infinite() && near > 0.0 && far > near);
    let (width, height, codes) = png(&sandbox.path("d.png"));
    assert_eq!((width, height, codes.len()), (40, 32, 40 * 32 * 2));
    for (pair, depth) in codes.chunks_exact(2).zip(&floats) {
        let code = f64::from(u16::from_be_bytes([pair[0], pair[1]]));
        let expected = if depth.is_finite() {
            1.0 + 65_534.0 * (depth - near) / (far - near)
        } else {
            0.0
        };
        assert!((code - expected).abs() <= 0.51, "{code} {expected}");
    }
    assert!(!sandbox.bytes("d.exr").is_empty());
}

#[test]
fn gradient_opacity_of_slicers_files_is_used() {
    let sandbox = Sandbox::new();
    let property = |factor: f64| {
        format!(
            r#"{{"volumeProperties": [{{"components": [{{
                "disableGradientOpacity": false,
                "rgbTransferFunction": {{"points": [{{"x": 0, "color": [1, 1, 1]}}]}},
                "scalarOpacity": {{"points": [{{"x": 0, "y": 0}}, {{"x": 1, "y": 0.3}}]}},
                "gradientOpacity": {{"points": [{{"x": 0, "y": {factor}}}, {{"x": 1000, "y": 1}}]}}
            }}]}}]}}"#
        )
    };
    sandbox.write("full.vp.json", property(1.0));
    sandbox.write("thin.vp.json", property(0.2));
    for name in ["full", "thin"] {
        let run = sandbox
            .run(&format!("{BALL} --tf {name}.vp.json -o {name}.png"))
            .succeeds();
        assert!(!run.stderr().contains("gradientOpacity"), "{}", run.stderr());
    }
    assert_ne!(png(&sandbox.path("full.png")), png(&sandbox.path("thin.png")));
    // The picture remembers it without the file.
    std::fs::remove_file(sandbox.path("thin.vp.json")).unwrap();
    sandbox.run("render --like thin.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("thin.png"), sandbox.bytes("again.png"));
    let run = sandbox
        .run(&format!(
            "{BALL} --tf full.vp.json --gradient-opacity 0:0.2,1000:1 -o flag.png"
        ))
        .succeeds();
    assert!(run.stderr().contains("wrote"), "{}", run.stderr());
    assert_eq!(png(&sandbox.path("flag.png")), png(&sandbox.path("thin.png")));
}
