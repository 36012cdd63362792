//! `splatvol bench`, end to end.

use serde_json::Value;

use crate::sandbox::{Sandbox, png};

const ONE_FRAME: &str = "--frames 1 --warm-up 0";
const ONE_SCENE: &str =
    "bench --scenes shells:64 --looks opaque --classification pre --projection orthographic";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn the_small_scenes_look_as_recorded() {
    let sandbox = Sandbox::new();
    let run = sandbox
        .run(&format!("bench --quick --threads 0 {ONE_FRAME} --json a.json"))
        .succeeds();
    let report = json(&String::from_utf8(sandbox.bytes("a.json")).unwrap());
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 16);
    for case in cases {
        assert_eq!(case["verdict"], "agrees", "{case}");
        assert_eq!(case["settings"]["size"], serde_json::json!([128, 128]));
    }
    // A head and a line per case.
    assert_eq!(run.stdout().lines().count(), 17, "{}", run.stdout());
    assert_eq!(run.stdout().matches("as recorded").count(), 16);
    let names = cases.iter().map(|case| case["name"].as_str().unwrap());
    let names: std::collections::BTreeSet<_> = names.collect();
    assert_eq!(names.len(), 16);
    assert!(names.contains("head:64/translucent/pre/perspective"), "{names:?}");
}

#[test]
fn counts_do_not_depend_on_threads() {
    let sandbox = Sandbox::new();
    let run = sandbox
        .run(&format!(
            "bench sample:shells:32 --preset fast --size 64 --threads 1,2 --counts {ONE_FRAME}"
        ))
        .succeeds();
    let text = run.stdout();
    let counts: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
    assert_eq!(counts.len(), 8, "{text}");
    assert_eq!(counts[..4], counts[4..]);
    for (line, word) in counts[1..].iter().zip(["bricks", "voxels", "pixels"]) {
        let number = line
            .trim()
            .strip_prefix(word)
            .and_then(|rest| rest.split_whitespace().next());
        let number: u64 = number
            .unwrap_or_default()
            .parse()
            .unwrap_or_else(|_| panic!("{line}"));
        assert!(number > 0, "{line}");
    }
}

#[test]
fn every_frame_is_measured_and_threads_do_not_change_pictures() {
    let sandbox = Sandbox::new();
    let run = sandbox
        .run(&format!(
            "{ONE_SCENE} --threads 1,3 --frames 4 --warm-up 1 --json -"
        ))
        .succeeds();
    let report = json(&run.stdout());
    assert_eq!(report["threads"], serde_json::json!([1, 3]));
    assert_eq!(
        [&report["frames"], &report["warm_up"], &report["orbit_degrees"]].map(|n| n.as_f64().unwrap()),
        [4.0, 1.0, 1.0]
    );
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 2);
    for (case, threads) in cases.iter().zip([1, 3]) {
        assert_eq!(case["name"], "shells:64/opaque/pre/orthographic");
        assert_eq!(case["threads"], threads);
        assert_eq!(case["statistics"]["threads"], threads);
        let wall = case["wall_ms"].as_array().unwrap();
        assert_eq!(wall.len(), 4);
        assert!(wall.contains(&case["median_wall_ms"]));
        assert!(wall.iter().all(|time| time.as_f64().unwrap() > 0.0));
        assert!(case["statistics"]["seconds"]["prefilter"].as_f64().unwrap() >= 0.0);
        if cfg!(target_os = "linux") {
            assert_eq!(case["cpu_ms"].as_array().unwrap().len(), 4);
            assert!(case["peak_memory_bytes"].as_u64().unwrap() > 1 << 20);
        }
    }
    assert_eq!(cases[0]["picture"]["sha256"], cases[1]["picture"]["sha256"]);
    assert!(sandbox.files().is_empty());
}

#[test]
fn other_pictures_than_recorded_fail_by_name() {
    let sandbox = Sandbox::new();
    let run = format!("{ONE_SCENE} --threads 2 {ONE_FRAME} --expected e.json");
    sandbox.write("e.json", "{}");
    sandbox
        .run(&run)
        .fails(4, &["shells:64/opaque/pre/orthographic", "nothing is recorded"]);
    sandbox
        .run(&format!("{ONE_SCENE} --expected e.json --update-expected e.json"))
        .succeeds();
    sandbox.run(&run).succeeds();
    // A brighter cell in the middle: 3, 4.
    let mut recorded = json(&String::from_utf8(sandbox.bytes("e.json")).unwrap());
    let mean = &mut recorded["shells:64/opaque/pre/orthographic"][3 * (4 * 8 + 3)];
    *mean = Value::from(mean.as_f64().unwrap() - 0.25);
    sandbox.write("e.json", recorded.to_string());
    let failed = sandbox.run(&format!("{run} --json a.json"));
    let failed = failed.fails(
        4,
        &["shells:64/opaque/pre/orthographic", "0.2500", "column 3, row 4"],
    );
    assert!(failed.stdout().contains("DIFFERS"), "{}", failed.stdout());
    let case = &json(&String::from_utf8(sandbox.bytes("a.json")).unwrap())["cases"][0];
    assert_eq!(
        (&case["verdict"], &case["cell"]),
        (&"differs".into(), &serde_json::json!([3, 4]))
    );
    // Flags that change the picture: nothing is expected.
    sandbox.run(&format!("{run} --size 40")).succeeds();
    sandbox.run(&format!("{run} --no-shade")).succeeds();
}

#[test]
fn the_first_frame_is_the_picture_that_render_makes() {
    let sandbox = Sandbox::new();
    sandbox.run("sample shells --size 24 -o shells.nrrd").succeeds();
    sandbox.write(
        "tf.json",
        r#"[{"Name":"t","ColorSpace":"RGB","RGBPoints":[0,1,0,0,255,0,0,1],"Points":[0,0,0.5,0,255,0.8,0.5,0]}]"#,
    );
    for flags in [
        "--tf tf.json --camera-pos 30,40,50 --camera-target 0,1,0 --camera-up 0,1,0 --camera-fov 35 --ambient 0.2 --diffuse 0.7",
        "--view left --orthographic --preset fast --cmap magma --opacity linear",
        "--fit volume --classification pre --no-shade",
        "--up -y --view front --background white --bits 16",
        "--rotate z:30 --scale 2,1,1 --view iso --clip-box -5,5,-50,50,-50,50 --texture marble",
        "--spin 20 --classification pre --motion-blur exact --view left",
    ] {
        sandbox
            .run(&format!("render shells.nrrd --size 40x30 {flags} -o a.png -w"))
            .succeeds();
        let run = sandbox
            .run(&format!(
                "bench shells.nrrd --size 40x30 {flags} --threads 2 --frames 2 --json - --picture b.png -w"
            ))
            .succeeds();
        assert_eq!(
            png(&sandbox.path("a.png")),
            png(&sandbox.path("b.png")),
            "{flags}"
        );
        let report = json(&run.stdout());
        let cases = report["cases"].as_array().unwrap();
        assert_eq!(cases.len(), 1);
        assert_eq!(cases[0]["wall_ms"].as_array().unwrap().len(), 2);
        assert_eq!(cases[0]["verdict"], "unchecked");
    }
}

#[test]
fn looks_are_made_for_any_volume() {
    let sandbox = Sandbox::new();
    let run = sandbox
        .run(&format!(
            "bench sample:ball:20 sample:slab:20 --looks translucent,opaque --threads 1 --size 24 {ONE_FRAME} --json -"
        ))
        .succeeds();
    let report = json(&run.stdout());
    let cases = report["cases"].as_array().unwrap();
    let names: Vec<_> = cases.iter().map(|case| case["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "sample:ball:20/translucent/post/perspective",
            "sample:ball:20/opaque/post/perspective",
            "sample:slab:20/translucent/post/perspective",
            "sample:slab:20/opaque/post/perspective",
        ]
    );
    for case in cases {
        let means = case["picture"]["fingerprint"].as_array().unwrap();
        assert!(
            means.iter().any(|mean| *mean != means[0]),
            "an empty picture: {case}"
        );
    }
}

#[test]
fn mistakes_are_named_with_their_exit_code() {
    let sandbox = Sandbox::new();
    sandbox.write("a.json", "{}");
    sandbox.write("points.xyz", "0 0 0\n1 1 1\n");
    for (arguments, code, words) in [
        ("bench --scenes shell", 2, &["shell", "shells:256"][..]),
        ("bench sample:ball --quick", 2, &["--quick"]),
        ("bench --frames 0", 2, &["--frames"]),
        ("bench --orbit nan", 2, &["--orbit"]),
        ("bench --looks opaque --iso 3", 2, &["--looks", "--iso"]),
        (
            "bench --projection perspective --orthographic",
            2,
            &["--orthographic"],
        ),
        (
            "bench --size 30 --update-expected a.json",
            2,
            &["--update-expected"],
        ),
        ("bench sample:ball --picture a.gif", 2, &["a.gif", ".png or .exr"]),
        ("bench sample:ball --kernel-sigma 99", 2, &["kernel sigma", "99"]),
        ("bench absent.nrrd", 3, &["absent.nrrd"]),
        ("bench --up y --scenes ball", 2, &["--scenes", "ball"]),
        ("bench sample:ball --radius 3", 2, &["--radius"]),
        ("bench points.xyz --looks opaque", 2, &["--looks", "volumes"]),
        ("bench --like a.png --quick", 2, &["--like", "--quick"]),
        ("bench --quick --expected absent.json", 3, &["absent.json"]),
        ("bench sample:ball --json a.json", 5, &["a.json already exists"]),
    ] {
        sandbox.run(arguments).fails(code, words);
    }
    assert_eq!(sandbox.files(), ["a.json", "points.xyz"]);
}

#[test]
fn scenes_points_and_earlier_pictures_are_measured_as_render_shows_them() {
    let sandbox = Sandbox::new();
    sandbox.run("sample ball --size 16 -o ball.nrrd").succeeds();
    sandbox.write("points.xyz", "0 0 0\n4 0 0\n0 4 0\n0 0 4\n4 4 4\n");
    sandbox.write(
        "scene.toml",
        "size = \"40x30\"\n[[item]]\nfile = \"ball.nrrd\"\niso = 100\n[[item]]\nfile = \"points.xyz\"\nradius = 2\n\
         translate = [9, 0, 0]\n[camera]\nview = \"front\"\n",
    );
    for (what, flags) in [
        ("scene.toml", "--azimuth 20"),
        (
            "points.xyz",
            "--radius 0.7 --point-color 1,0,0 --view left --size 40",
        ),
    ] {
        let render = format!("render {what} {flags} -o a.png -w");
        sandbox.run(&render).succeeds();
        let bench = format!("bench {what} {flags} --threads 1 {ONE_FRAME} --picture b.png -w --json -");
        let run = sandbox.run(&bench).succeeds();
        let (rendered, measured) = (png(&sandbox.path("a.png")), png(&sandbox.path("b.png")));
        assert_eq!(rendered, measured, "{what}");
        let case = &json(&run.stdout())["cases"][0];
        assert_eq!(case["input"], what);
        assert!(case["document"]["item"].is_array(), "{case}");
    }
    sandbox
        .run(&format!(
            "bench --like a.png --point-color 0,1,0 --threads 1 {ONE_FRAME} --picture c.png"
        ))
        .succeeds();
    sandbox
        .run("render --like a.png --point-color 0,1,0 -o d.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("c.png")), png(&sandbox.path("d.png")));
    assert!(png(&sandbox.path("a.png")) != png(&sandbox.path("d.png")));
}

/// Of its second frame: a camera that moves leaves all as it was, an edit of the transfer function a part.
#[test]
fn frames_reuse_what_did_not_change() {
    let sandbox = Sandbox::new();
    let reused = |flags: &str| {
        let run = sandbox
            .run(&format!(
                "bench sample:shells:64 --looks opaque --preset fast --size 32 --threads 1 --frames 1 --warm-up 1 --json - {flags}"
            ))
            .succeeds();
        let report = json(&run.stdout());
        let statistics = &report["cases"][0]["statistics"];
        ["bricks", "searched_bricks", "active_bricks", "solved_bricks"]
            .map(|count| statistics[count].as_u64().unwrap_or_else(|| panic!("{count}")))
    };
    let [_, searched, _, solved] = reused("--orbit 1");
    assert_eq!([searched, solved], [0, 0]);
    let [bricks, searched, active, solved] = reused("--orbit 0 --slide 2");
    assert!(0 < searched && searched < bricks, "{searched} of {bricks}");
    assert!(solved < active, "{solved} of {active}");
}
