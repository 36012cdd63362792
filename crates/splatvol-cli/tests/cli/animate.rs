//! `splatvol animate`, end to end.

use std::fs::File;
use std::io::BufReader;

use crate::sandbox::{Sandbox, png};

const TINY: &str = "animate sample:ball:20 --size 24x20 --opacity linear --cmap viridis";

/// Codes (RGBA) and delays, 1/100 s, of a GIF.
fn gif(sandbox: &Sandbox, name: &str) -> (Vec<Vec<u8>>, Vec<u16>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let file = BufReader::new(File::open(sandbox.path(name)).expect("it is there and whole"));
    let mut decoder = options.read_info(file).expect("it is there and whole");
    assert!(matches!(decoder.repeat(), gif::Repeat::Infinite));
    let (mut frames, mut delays) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().expect("it is there and whole") {
        assert_eq!((frame.width, frame.height), (24, 20));
        frames.push(frame.buffer.to_vec());
        delays.push(frame.delay);
    }
    (frames, delays)
}

/// Codes and delays (fractions of a second) of an animated PNG.
fn apng(sandbox: &Sandbox, name: &str) -> (Vec<Vec<u8>>, Vec<[u16; 2]>) {
    let file = BufReader::new(File::open(sandbox.path(name)).expect("it is there and whole"));
    let mut reader = png::Decoder::new(file)
        .read_info()
        .expect("it is there and whole");
    let control = *reader.info().animation_control().expect("it is animated");
    assert_eq!(control.num_plays, 0);
    let (mut frames, mut delays) = (Vec::new(), Vec::new());
    for _ in 0..control.num_frames {
        let mut codes = vec![0; reader.output_buffer_size().expect("it is there and whole")];
        reader.next_frame(&mut codes).expect("it is there and whole");
        let control = reader.info().frame_control().expect("it is there and whole");
        frames.push(codes);
        delays.push([control.delay_num, control.delay_den]);
    }
    (frames, delays)
}

fn frame_codes(sandbox: &Sandbox, count: usize) -> Vec<Vec<u8>> {
    (0..count)
        .map(|i| png(&sandbox.path(&format!("f-{i:02}.png"))).2)
        .collect()
}

/// RGB without alpha.
fn opaque(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4).flat_map(|c| [c[0], c[1], c[2]]).collect()
}

#[test]
fn all_formats_show_the_frames_that_render_makes() {
    let sandbox = Sandbox::new();
    let motion = "--turntable 360 --frames 4 --view front";
    sandbox.run(&format!("{TINY} {motion} -o f-##.png")).succeeds();
    let frames = frame_codes(&sandbox, 4);
    for (i, codes) in frames.iter().enumerate() {
        sandbox
            .run(&format!(
                "render --like f-00.png --azimuth {} -o still.png -w",
                90 * i
            ))
            .succeeds();
        let (_, _, still) = png(&sandbox.path("still.png"));
        let most = still.iter().zip(codes).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(1), "frame {i}: {most:?}");
    }

    sandbox
        .run(&format!("{TINY} {motion} --fps 25 -o a.apng"))
        .succeeds();
    let (codes, delays) = apng(&sandbox, "a.apng");
    assert_eq!(codes, frames);
    assert_eq!(delays, [[1, 25]; 4]);

    sandbox
        .run(&format!("{TINY} {motion} --fps 30 -o a.gif"))
        .succeeds();
    let (codes, delays) = gif(&sandbox, "a.gif");
    assert_eq!(delays, [3, 4, 3, 3]);
    for (i, (gif, png)) in codes.iter().zip(&frames).enumerate() {
        let gif = opaque(gif);
        assert_eq!(gif[..3], png[..3], "frame {i}: the background keeps its colour");
        let off = gif
            .iter()
            .zip(png)
            .map(|(a, b)| f64::from(a.abs_diff(*b)))
            .sum::<f64>()
            / gif.len() as f64;
        assert!(off < 3.0, "frame {i}: off by {off} codes in the mean");
    }
    assert_eq!(codes.len(), 4);
}

#[test]
fn frames_differ_and_a_frame_can_be_made_again() {
    let sandbox = Sandbox::new();
    let flags = "animate sample:head:24 --size 20 --frames 3 --turntable 60 --view front";
    sandbox.run(&format!("{flags} -o f-##.png")).succeeds();
    let frames = frame_codes(&sandbox, 3);
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
    sandbox.run("render --like f-01.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("f-01.png"), sandbox.bytes("again.png"));
    // Blurred, too: the mean of the same pictures.
    sandbox
        .run(&format!("{flags} --shutter 1 --subframes 5 -o b-#.png"))
        .succeeds();
    sandbox.run("render --like b-1.png -o blurred.png").succeeds();
    assert_eq!(sandbox.bytes("b-1.png"), sandbox.bytes("blurred.png"));
    assert_ne!(frames[1], png(&sandbox.path("b-1.png")).2);
    // The first frame stands for the whole file.
    sandbox.run(&format!("{flags} -o a.apng")).succeeds();
    sandbox.run("render --like a.apng -o first.png").succeeds();
    assert_eq!(frames[0], png(&sandbox.path("first.png")).2);
}

#[test]
fn sub_frames_average_linear_premultiplied_light() {
    let sandbox = Sandbox::new();
    let flags = "animate sample:head:24 --size 20 --background none --view front";
    // Closed: frame 0 of 10, the shutter open for all its time, sees -9 and +9 degrees, as frames of 9 degrees do.
    sandbox
        .run(&format!(
            "{flags} --frames 10 --shutter 1 --subframes 2 -o b-#.exr"
        ))
        .succeeds();
    sandbox
        .run(&format!("{flags} --frames 40 -o s-##.exr"))
        .succeeds();
    let read = |name: &str| splatvol_io::read_image(sandbox.path(name)).unwrap();
    let (blurred, before, after) = (
        read("b-0.exr").image,
        read("s-39.exr").image,
        read("s-01.exr").image,
    );
    for (i, mean) in blurred.pixels.iter().enumerate() {
        for (c, &value) in mean.iter().enumerate() {
            let expected = 0.5 * (f64::from(before.pixels[i][c]) + f64::from(after.pixels[i][c]));
            let error = (f64::from(value) - expected).abs();
            // The cameras agree except for rounding.
            assert!(error < 1e-4, "pixel {i} channel {c}: off by {error}");
        }
    }
    assert_ne!(before, after);
}

#[test]
fn a_frames_output_continues_where_it_stopped() {
    let sandbox = Sandbox::new();
    let command = format!("{TINY} --frames 4 -o f-#.png");
    sandbox.run(&command).succeeds();
    let names = ["f-0.png", "f-1.png", "f-2.png", "f-3.png"];
    let whole = names.map(|name| png(&sandbox.path(name)));
    let modified = |name: &str| std::fs::metadata(sandbox.path(name)).unwrap().modified().unwrap();
    let before = names.map(modified);
    // One is missing, one was made by another method, one is not a splatvol picture.
    std::fs::remove_file(sandbox.path("f-3.png")).unwrap();
    sandbox
        .run("render --like f-2.png --no-shade -o f-2.png -w")
        .succeeds();
    sandbox.write("f-1.png", "not a picture");
    let text = sandbox
        .run(&format!("{command} --resume --stats -"))
        .succeeds()
        .stdout();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (report["frames"].as_u64(), report["kept"].as_u64()),
        (Some(4), Some(1)),
        "{text}"
    );
    assert_eq!(names.map(|name| png(&sandbox.path(name))), whole);
    let after = names.map(modified);
    assert_eq!(before[0], after[0]);
    assert!((1..4).all(|i| before[i] < after[i]));
    assert_eq!(sandbox.files(), names);
    // Another motion is another animation.
    let text = sandbox
        .run(&format!("{command} --resume --shutter 0.5 --stats -"))
        .succeeds()
        .stdout();
    assert!(text.contains("\"kept\": 0"), "{text}");
}

#[test]
fn frames_older_than_their_data_are_made_again() {
    let sandbox = Sandbox::new();
    sandbox.run("sample ball --size 16 -o ball.nrrd").succeeds();
    let command = "animate ball.nrrd --size 12 --frames 2 -o f-#.png";
    sandbox.run(command).succeeds();
    let kept = |count: u32| {
        let text = sandbox
            .run(&format!("{command} --resume --stats -"))
            .succeeds()
            .stdout();
        assert!(text.contains(&format!("\"kept\": {count}")), "{text}");
    };
    kept(2);
    sandbox.run("sample shells --size 16 -o ball.nrrd -w").succeeds();
    kept(0);
}

#[test]
fn outputs_that_exist_are_refused_before_the_work() {
    let sandbox = Sandbox::new();
    sandbox.write("f-3.png", "mine");
    sandbox.write("a.gif", "mine");
    sandbox
        .run(&format!("{TINY} --frames 4 -o f-#.png"))
        .fails(5, &["f-3.png already exists", "-w"]);
    sandbox
        .run(&format!("{TINY} --frames 4 -o a.gif"))
        .fails(5, &["a.gif already exists", "-w"]);
    assert_eq!(sandbox.files(), ["a.gif", "f-3.png"]);
    assert_eq!(sandbox.bytes("a.gif"), b"mine");
    sandbox
        .run(&format!("{TINY} --frames 1 -o a.gif -w -q"))
        .succeeds();
    assert_eq!(gif(&sandbox, "a.gif").0.len(), 1);
}

#[test]
fn transparency_is_kept_where_the_format_has_it() {
    let sandbox = Sandbox::new();
    let flags = format!("{TINY} --frames 2 --background none");
    sandbox.run(&format!("{flags} -o a.gif")).succeeds();
    let (frames, _) = gif(&sandbox, "a.gif");
    let alpha = |frame: &[u8]| frame.chunks_exact(4).map(|c| c[3]).collect::<Vec<_>>();
    assert_eq!(frames[1][3], 0);
    assert!(alpha(&frames[1]).contains(&255));
    sandbox.run(&format!("{flags} --bits 16 -o a.apng")).succeeds();
    let (frames, _) = apng(&sandbox, "a.apng");
    sandbox.run(&format!("{flags} --bits 16 -o f-##.png")).succeeds();
    assert_eq!(frames[0].len(), 24 * 20 * 8);
    assert_eq!(frames, frame_codes(&sandbox, 2));
}

#[test]
fn cameras_follow_key_frames() {
    let sandbox = Sandbox::new();
    let key = |x: f64, y: f64| format!("[[key]]\nposition = [{x}, {y}, 5]\ntarget = [0, 0, 0]\n");
    sandbox.write(
        "a.toml",
        [key(40.0, 0.0), key(0.0, 40.0), key(-40.0, 0.0)].concat(),
    );
    sandbox
        .run(&format!("{TINY} --path a.toml --frames 3 -o f-##.png"))
        .succeeds();
    for (i, position) in ["40,0,5", "0,40,5", "-40,0,5"].iter().enumerate() {
        let flags = TINY.replace("animate", "render");
        sandbox
            .run(&format!(
                "{flags} --camera-pos={position} --camera-target 0,0,0 -o still.png -w"
            ))
            .succeeds();
        assert_eq!(
            png(&sandbox.path("still.png")),
            png(&sandbox.path(&format!("f-{i:02}.png"))),
            "{i}"
        );
    }
    // Times determine the number of frames.
    sandbox.write(
        "b.json",
        r#"{"key": [{"time": 1, "position": [40, 0, 0]}, {"time": 1.5, "position": [0, 40, 0], "fov": 20}]}"#,
    );
    sandbox
        .run(&format!("{TINY} --path b.json --fps 8 -o a.apng"))
        .succeeds();
    assert_eq!(apng(&sandbox, "a.apng").0.len(), 5);
}

#[test]
fn malformed_paths_are_refused_by_file_and_key() {
    let sandbox = Sandbox::new();
    let first = "[[key]]\nposition = [40, 0, 0]\n";
    for (second, words) in [
        ("", &["key", "at least 2"][..]),
        ("[[key]]\ntarget = [1, 2, 3]", &["key[1].position", "absent"]),
        ("[[key]]\nposition = [1, 2]", &["key[1].position", "[x, y, z]"]),
        (
            "[[key]]\nposition = [1, \"a\", 2]",
            &["key[1].position[1]", "a number"],
        ),
        ("[[key]]\nposition = [1, nan, 2]", &["key[1].position[1]"]),
        ("[[key]]\nposition = [0, 9, 9]\nfow = 30", &["key[1].fow", "fov"]),
        (
            "[[key]]\nposition = [0, 9, 9]\nfov = 200",
            &["key[1]", "camera fov: 200"],
        ),
        (
            "[[key]]\nposition = [0, 9, 9]\nfov = 20\nheight = 9",
            &["key[1].height", "either"],
        ),
        (
            "[[key]]\nposition = [0, 9, 9]\nheight = 9",
            &["keys make no path", "projection"],
        ),
        (
            "[[key]]\nposition = [0, 9, 9]\ntime = 1",
            &["key", "every key, or in none"],
        ),
        ("[[key]\nposition = [0, 9, 9]", &["contents", "TOML"]),
        (
            "[[key]]\nposition = [-40, 0, 0]\n[light]\na = 1",
            &["light", "no such field"],
        ),
    ] {
        sandbox.write("a.toml", format!("{first}{second}"));
        let run = sandbox.run(&format!("{TINY} --path a.toml --camera-target 0,0,0 -o a.gif"));
        run.fails(3, words).fails(3, &["a.toml"]);
    }
    sandbox.write(
        "b.json",
        r#"{"key": [{"time": 1, "position": [9, 0, 0]}, {"time": 1, "position": [9, 9, 9]}]}"#,
    );
    sandbox
        .run(&format!("{TINY} --path b.json -o a.gif"))
        .fails(3, &["key[1].time", "after 1", "b.json"]);
    sandbox
        .run(&format!("{TINY} --path absent.toml -o a.gif"))
        .fails(3, &["absent.toml"]);
    // Through the target, where a camera has no direction.
    sandbox.write("c.toml", format!("{first}[[key]]\nposition = [-40, 0, 0]\n"));
    sandbox
        .run(&format!(
            "{TINY} --path c.toml --frames 3 --camera-target 0,0,0 -o a.gif"
        ))
        .fails(2, &["frame 1", "camera target"]);
    assert_eq!(sandbox.files(), ["a.toml", "b.json", "c.toml"]);
}

#[test]
fn mistakes_are_named() {
    let sandbox = Sandbox::new();
    for (flags, code, words) in [
        ("-o a.tiff", 2, &["a.tiff", ".gif"][..]),
        ("-o a.png", 2, &["one picture", "-####.png"]),
        ("-o f-#.png --frames 11", 2, &["need 2 #"]),
        ("-o f-#.gif", 2, &[".png or .exr"]),
        ("-o a.gif --resume", 2, &["--resume", "frames"]),
        ("-o a.gif --bits 16", 2, &["--bits 16"]),
        ("-o a.gif --fps 60", 5, &["GIF", "60 frames per second", "50"]),
        ("-o a.gif --fps 0", 2, &["--fps"]),
        ("-o a.gif --frames 0", 2, &["--frames"]),
        ("-o a.gif --shutter 2", 2, &["--shutter", "0 to 1"]),
        (
            "-o a.gif --motion-blur capsule",
            2,
            &["--motion-blur needs a motion", "--shutter"],
        ),
        ("-o a.gif --turntable 9 --path a.toml", 2, &["--path"]),
        ("-o nowhere/a.gif", 5, &["nowhere"]),
        ("--frames 3", 2, &["--output"]),
    ] {
        sandbox.run(&format!("{TINY} {flags}")).fails(code, words);
    }
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}

#[test]
fn films_need_ffmpeg() {
    let sandbox = Sandbox::new();
    sandbox
        .run_with_path(&format!("{TINY} -o a.mp4"), "")
        .fails(5, &["ffmpeg", "PATH", ".gif", ".apng", "####.png"]);
    assert!(sandbox.files().is_empty());
}

/// A program `ffmpeg` in the sandbox that runs this script.
#[cfg(unix)]
fn ffmpeg(sandbox: &Sandbox, script: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let folder = sandbox.path("bin");
    std::fs::create_dir_all(&folder).expect("it is there and whole");
    let program = folder.join("ffmpeg");
    std::fs::write(
        &program,
        format!("#!/bin/sh\n[ \"$1\" = -version ] && exit 0\n{script}\n"),
    )
    .expect("it is there and whole");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755))
        .expect("it is there and whole");
    format!("{}:/usr/bin:/bin", folder.display())
}

#[cfg(unix)]
#[test]
fn films_get_the_frames_as_raw_pictures() {
    let sandbox = Sandbox::new();
    let path = ffmpeg(
        &sandbox,
        "echo \"$@\" > flags\nfor last; do :; done\ncat > \"$last\"",
    );
    let flags = format!("{TINY} --frames 3 --fps 12.5");
    sandbox
        .run_with_path(&format!("{flags} -o a.mp4"), &path)
        .succeeds();
    sandbox.run(&format!("{flags} -o f-##.png")).succeeds();
    assert_eq!(sandbox.bytes("a.mp4"), frame_codes(&sandbox, 3).concat());
    let said = String::from_utf8(sandbox.bytes("flags")).unwrap();
    for word in ["rawvideo", "rgb24", "24x20", "-framerate 12.5"] {
        assert!(said.contains(word), "{said}");
    }
    sandbox
        .run_with_path(&format!("{flags} --background none -o b.mp4"), &path)
        .fails(2, &["transparency", ".apng"]);
}

#[cfg(unix)]
#[test]
fn a_film_that_fails_says_why_and_leaves_nothing() {
    let sandbox = Sandbox::new();
    for script in [
        "for last; do :; done\ncat > \"$last\"\necho no such encoder >&2\nexit 7",
        "echo no such encoder >&2\nexit 7",
    ] {
        let path = ffmpeg(&sandbox, script);
        sandbox
            .run_with_path(&format!("{TINY} --frames 100 -o a.webm"), &path)
            .fails(5, &["ffmpeg failed", "7", "no such encoder"]);
        assert_eq!(sandbox.files(), ["bin"]);
    }
}
