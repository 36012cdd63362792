//! Motion blur of `splatvol render` and `splatvol animate`, end to end.

use crate::sandbox::{Sandbox, png};

const TUNNEL: &str = "render sample:tunnel:20 --size 32 --view iso";
const TURNING: &str = "animate sample:tunnel:20 --size 32 --view iso --frames 12";
/// Classified first. The same engine renders scenes in motion and at rest.
const PRE: &str = "--classification pre --alignment affine";
/// Classified last: the sample's own wish is to be classified first.
const POST: &str = "--classification post";

/// Root mean square difference of two pictures' codes.
fn difference(sandbox: &Sandbox, a: &str, b: &str) -> f64 {
    let [a, b] = [a, b].map(|name| png(&sandbox.path(name)).2);
    assert_eq!(a.len(), b.len());
    let squares = a.iter().zip(&b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// Settings that a picture remembers.
fn remembered(sandbox: &Sandbox, name: &str) -> serde_json::Value {
    let picture = splatvol_io::read_image(sandbox.path(name)).expect("it is there and whole");
    let text = splatvol_io::image::metadata::find(&picture.metadata, splatvol_io::image::metadata::SETTINGS);
    serde_json::from_str(text.expect("splatvol made it")).expect("they are JSON")
}

#[test]
fn motion_changes_the_picture_and_slow_motion_hardly_does() {
    let sandbox = Sandbox::new();
    for look in [POST, PRE, "--compositing xray --alignment affine"] {
        sandbox
            .run(&format!("{TUNNEL} {look} -o still.png -w"))
            .succeeds();
        for (fast, slow) in [
            ("--spin 40", "--spin 0.02"),
            ("--velocity 5,0,-3", "--velocity 0.002,0,-0.002"),
        ] {
            for blur in ["none", "capsule", "exact", "subframes --subframes 5"] {
                if look == POST && (blur == "capsule" || blur == "exact") {
                    continue;
                }
                let moved = |motion: &str| {
                    let flags = format!("{TUNNEL} {look} {motion} --motion-blur {blur} -o moved.png -w");
                    sandbox.run(&flags).succeeds();
                    difference(&sandbox, "still.png", "moved.png")
                };
                let (fast, slow) = (moved(fast), moved(slow));
                println!("{look} {blur}: {fast:.2} {slow:.2}");
                match blur {
                    "none" => assert_eq!((fast, slow), (0.0, 0.0), "{look}"),
                    _ => assert!(
                        fast > 3.0 && slow < 0.3 * fast && slow < 2.0,
                        "{look} {blur}: {fast} {slow}"
                    ),
                }
            }
        }
    }
}

/// A spin of the volume is a turn of the camera the other way.
#[test]
fn a_spin_is_the_mean_of_turned_cameras() {
    let sandbox = Sandbox::new();
    let look = "render sample:tunnel:20 --size 32 --background none --camera-pos=0,-50,0 --camera-target=0,0,0 \
                --camera-up=0,0,1 --camera-fov 30";
    let spin = "--spin 30 --motion-blur subframes --subframes 2";
    sandbox.run(&format!("{look} {spin} -o blurred.exr")).succeeds();
    let read = |name: &str| splatvol_io::read_image(sandbox.path(name)).unwrap().image;
    for (name, azimuth) in [("a.exr", -7.5), ("b.exr", 7.5)] {
        let turned = format!("{look} --azimuth={azimuth} -o {name}");
        sandbox.run(&turned).succeeds();
    }
    let (blurred, a, b) = (read("blurred.exr"), read("a.exr"), read("b.exr"));
    for (i, mean) in blurred.pixels.iter().enumerate() {
        for (c, &value) in mean.iter().enumerate() {
            let expected = 0.5 * (f64::from(a.pixels[i][c]) + f64::from(b.pixels[i][c]));
            let error = (f64::from(value) - expected).abs();
            // The cameras agree except for rounding.
            assert!(error < 1e-3, "pixel {i} channel {c}: off by {error}");
        }
    }
    assert_ne!(a, b);
}

#[test]
fn one_picture_blurs_by_default_where_it_can() {
    let sandbox = Sandbox::new();
    for (flags, expected) in [
        (PRE, None),
        ("--compositing xray", None),
        (POST, Some(16)),
        ("--compositing mip", Some(16)),
        ("--classification pre --subframes 3", Some(3)),
        ("--classification pre --clip-plane 0,0,0:1,0,0", Some(16)),
    ] {
        let flags = format!("{TUNNEL} --spin 5 {flags} -o a.png -w");
        sandbox.run(&flags).succeeds();
        let motion = &remembered(&sandbox, "a.png")["motion"];
        let name = if expected.is_some() { "subframes" } else { "exact" };
        assert_eq!(motion["motion-blur"], name, "{flags}");
        assert_eq!(motion["subframes"].as_u64(), expected, "{flags}");
    }
}

#[test]
fn motion_is_remembered() {
    let sandbox = Sandbox::new();
    for (i, flags) in [
        "--classification pre --fit volume --spin 33.3",
        "--classification pre --velocity=-3.1,0.7,2 --motion-blur capsule",
        "--spin -20 --motion-blur subframes --subframes 3",
    ]
    .into_iter()
    .enumerate()
    {
        let (own, again) = (format!("{i}.png"), format!("{i}-again.png"));
        sandbox.run(&format!("{TUNNEL} {flags} -o {own}")).succeeds();
        sandbox.run(&format!("render --like {own} -o {again}")).succeeds();
        assert_eq!(sandbox.bytes(&own), sandbox.bytes(&again), "{flags}");
    }
    let still = format!("{TUNNEL} --classification pre --fit volume -o still.png");
    sandbox.run(&still).succeeds();
    sandbox
        .run("render --like 0.png --motion-blur none -o none.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("none.png")), png(&sandbox.path("still.png")));
    // It still moves, and can be blurred again.
    sandbox
        .run("render --like none.png --motion-blur exact -o exact.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("exact.png")), png(&sandbox.path("0.png")));
    // Seen from elsewhere, too.
    sandbox
        .run("render --like 0.png --azimuth 9 -o turned.png")
        .succeeds();
    let [own, turned] = ["0.png", "turned.png"].map(|name| remembered(&sandbox, name)["motion"].clone());
    assert!(own["spin"] == 33.3 && own == turned, "{own} {turned}");
}

#[test]
fn frames_blur_footprints_along_the_cameras_motion() {
    let sandbox = Sandbox::new();
    let frames = |blur: &str, name: &str| {
        sandbox
            .run(&format!("{TURNING} {PRE} {blur} -o {name}-##.png"))
            .succeeds();
    };
    frames("", "still");
    frames("--shutter 1 --motion-blur subframes --subframes 24", "mean");
    frames("--shutter 1 --motion-blur exact", "exact");
    frames("--shutter 0.001 --motion-blur exact", "slow");
    let of = |a: &str, b: &str| difference(&sandbox, &format!("{a}-05.png"), &format!("{b}-05.png"));
    let (exact, still, slow) = (of("exact", "mean"), of("still", "mean"), of("slow", "still"));
    println!("exact {exact:.2}, still {still:.2}, slow {slow:.2}");
    assert!(exact < 0.7 * still, "nearer to the mean: {exact} {still}");
    assert!(slow < 2.0 && slow < 0.5 * still, "{slow} {still}");
    sandbox.run("render --like exact-05.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("exact-05.png"), sandbox.bytes("again.png"));
    // The camera's motion is that of its place.
    sandbox
        .run("render --like exact-05.png --azimuth 4 -o turned.png")
        .succeeds();
    let turned = remembered(&sandbox, "turned.png");
    assert!(turned["motion"].is_null(), "{turned}");
    let stats = format!("{TURNING} {PRE} --shutter 1 --motion-blur exact --resume --stats - -o exact-##.png");
    let text = sandbox.run(&stats).succeeds().stdout();
    assert!(text.contains("\"kept\": 12"), "{text}");
}

#[test]
fn refusals_say_why() {
    let sandbox = Sandbox::new();
    for (flags, words) in [
        (
            "--motion-blur exact",
            &["--motion-blur needs a motion", "--spin", "--velocity"][..],
        ),
        ("--motion-blur subframes", &["--motion-blur needs a motion"]),
        ("--subframes 4", &["--subframes needs a motion"]),
        (
            "--classification post --spin 9 --motion-blur exact",
            &["motion blur", "before splatting (pre)"],
        ),
        (
            "--spin 9 --compositing mip --motion-blur capsule",
            &["motion blur", "no sum of footprints"],
        ),
        ("--spin 9 --velocity 1,0,0", &["--velocity"]),
        (
            "--spin 9 --classification pre --motion-blur exact --subframes 4",
            &["--subframes needs --motion-blur subframes"],
        ),
        ("--spin nan", &["--spin", "a number"]),
        ("--velocity 1,2", &["X,Y,Z"]),
        ("--spin 9 --subframes 0", &["--subframes"]),
    ] {
        sandbox.run(&format!("{TUNNEL} {flags} -o a.png")).fails(2, words);
    }
    for (flags, words) in [
        ("--shutter 0.5 --spin 9", &["--shutter", "give one of them"][..]),
        (
            "--classification post --shutter 0.5 --motion-blur exact",
            &["before splatting (pre)"],
        ),
        (
            "--motion-blur exact",
            &["--motion-blur needs a motion", "--shutter"],
        ),
        (
            "--shutter 0.5 --motion-blur capsule --subframes 4",
            &["--subframes needs"],
        ),
    ] {
        sandbox
            .run(&format!("{TURNING} {flags} -o a.gif"))
            .fails(2, words);
    }
    let key = |x: f64, fov: f64| format!("[[key]]\nposition = [{x}, 400, 5]\nfov = {fov}\n");
    sandbox.write("zoom.toml", key(0.0, 20.0) + &key(50.0, 40.0));
    sandbox
        .run(&format!(
            "{TURNING} {PRE} --path zoom.toml --shutter 0.5 --motion-blur exact -o a.gif"
        ))
        .fails(2, &["zooms at frame", "subframes"]);
    assert_eq!(sandbox.files(), ["zoom.toml"]);
}
