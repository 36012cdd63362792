//! Points and Gaussians by themselves, end to end.

use crate::sandbox::{Sandbox, png};

/// Points of a unit sphere around a place, by the golden angle, as a table.
pub(crate) fn sphere(count: u32, centre: [f64; 3], color: Option<[u8; 3]>) -> String {
    let row = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        let [x, y, z] = [cos * radius + centre[0], sin * radius + centre[1], z + centre[2]];
        let color = color.map_or_else(String::new, |[r, g, b]| format!(" {r} {g} {b}"));
        format!("{x} {y} {z}{color}\n")
    };
    (0..count).map(row).collect()
}

/// One Gaussian as trained: variance 0.04, a colour, opacity 0.95.
pub(crate) fn gaussian([r, g, b]: [f64; 3]) -> Vec<u8> {
    let names = [
        "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
        "rot_1", "rot_2", "rot_3",
    ];
    let properties: String = names.map(|name| format!("property float {name}\n")).concat();
    let dc = |color: f64| (color - 0.5) / 0.282_094_79;
    let scale = 0.2f64.ln();
    let values = [
        0.0,
        0.0,
        0.0,
        dc(r),
        dc(g),
        dc(b),
        3.0,
        scale,
        scale,
        scale,
        1.0,
        0.0,
        0.0,
        0.0,
    ];
    let mut file =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex 1\n{properties}end_header\n")
            .into_bytes();
    file.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
    file
}

/// Pixels of an 8-bit picture that satisfy a condition: their number, and width and height of their box.
pub(crate) fn pixels(sandbox: &Sandbox, name: &str, is: impl Fn([u8; 3]) -> bool) -> (usize, [u32; 2]) {
    let (width, height, codes) = png(&sandbox.path(name));
    let channels = codes.len() / (width * height) as usize;
    let (mut count, mut low, mut high) = (0, [u32::MAX; 2], [0; 2]);
    for (index, code) in (0u32..).zip(codes.chunks_exact(channels)) {
        if is([code[0], code[1], code[2]]) {
            let place = [index % width, index / width];
            count += 1;
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis] + 1);
            }
        }
    }
    (
        count,
        std::array::from_fn(|axis| high[axis].saturating_sub(low[axis])),
    )
}

const RED: fn([u8; 3]) -> bool = |[r, g, b]| r > 60 && u16::from(r) > 2 * u16::from(g.max(b));

#[test]
fn points_fill_the_picture_in_their_colour() {
    let sandbox = Sandbox::new();
    sandbox.write("red.txt", sphere(4000, [500_000.0, 0.0, 0.0], Some([255, 0, 0])));
    sandbox
        .run("render red.txt --size 96 --background black")
        .succeeds();
    let (count, [width, height]) = pixels(&sandbox, "red.png", RED);
    // A disc of 96 / 1.06 pixels, and its points' radii.
    assert!(
        (86..=95).contains(&width) && (86..=95).contains(&height),
        "{width} x {height}"
    );
    assert!((5900..7100).contains(&count), "{count}");

    sandbox.write("bare.txt", sphere(4000, [0.0; 3], None));
    sandbox
        .run("render bare.txt --size 96 --background black --point-color 1,0,0")
        .succeeds();
    assert!(pixels(&sandbox, "bare.png", RED).0 > 5500);
    sandbox
        .run("render bare.txt --size 96 --background black --radius 0.004 -o sparse.png")
        .succeeds();
    let lit = |[r, g, b]: [u8; 3]| r.max(g).max(b) > 60;
    assert!(pixels(&sandbox, "sparse.png", lit).0 < pixels(&sandbox, "bare.png", lit).0 / 2);
}

#[test]
fn the_axis_that_is_up_is_up() {
    let sandbox = Sandbox::new();
    let column: String = (0u8..200)
        .map(|i| format!("0 {} 0\n", f64::from(i) / 100.0))
        .collect();
    sandbox.write("column.txt", column);
    let lit = |[r, g, b]: [u8; 3]| r.max(g).max(b) > 20;
    for (flags, stands) in [
        ("--up y", true),
        ("--up -y", true),
        ("--up x", false),
        ("", false),
    ] {
        let arguments = format!("render column.txt --view left --size 64 --background black -w {flags}");
        sandbox.run(&arguments).succeeds();
        let (_, [width, height]) = pixels(&sandbox, "column.png", lit);
        assert_eq!(height > width, stands, "{flags}: {width} x {height}");
    }
}

/// A headerless volume of 24 samples along each axis, and the flags that describe it.
fn raw(sandbox: &Sandbox, value: impl Fn([usize; 3]) -> u8) -> &'static str {
    let places = (0..24 * 24 * 24).map(|i| [i % 24, i / 24 % 24, i / 576]);
    sandbox.write("a.raw", places.map(value).collect::<Vec<_>>());
    "a.raw --dims 24x24x24 --type u8"
}

/// A thin stem, along this axis, on a thick plate.
fn plant(up: usize) -> impl Fn([usize; 3]) -> u8 {
    move |place| {
        let across = [(up + 1) % 3, (up + 2) % 3].map(|axis| place[axis]);
        let is_plate = (1..4).contains(&place[up]) && across.iter().all(|i| (2..22).contains(i));
        let is_stem = (4..23).contains(&place[up]) && across.iter().all(|i| (11..13).contains(i));
        if is_plate || is_stem { 200 } else { 0 }
    }
}

#[test]
fn the_axis_of_a_volume_that_is_up_is_up() {
    let sandbox = Sandbox::new();
    let column = |[x, y, z]: [usize; 3]| {
        let inside = (10..14).contains(&x) && (2..22).contains(&y) && (10..14).contains(&z);
        if inside { 200 } else { 0 }
    };
    let file = raw(&sandbox, column);
    let stands = |arguments: &str| {
        let view = "--view left --size 64 --background black -w -o a.png";
        sandbox.run(&format!("render {arguments} {view}")).succeeds();
        let (_, [width, height]) = pixels(&sandbox, "a.png", |code| code.iter().any(|c| *c > 20));
        assert!(width.max(height) > 40, "{arguments}: {width} x {height}");
        height > 2 * width
    };
    for (up, expected) in [("y", true), ("-y", true), ("x", false), ("z", false)] {
        assert_eq!(stands(&format!("{file} --up {up}")), expected, "{up}");
    }
    assert!(!stands(file));
    // A file that gives its orientation is turned as well, and so is an item of a scene.
    sandbox.run(&format!("convert {file} a.nrrd")).succeeds();
    assert!(!stands("a.nrrd") && stands("a.nrrd --up -y"));
    let item = "[[item]]\nfile = 'a.nrrd'\n";
    sandbox.write("lies.toml", item);
    sandbox.write("stands.toml", format!("{item}up = 'y'\n"));
    assert!(!stands("lies.toml") && stands("stands.toml"));
}

#[test]
fn a_volume_that_stands_on_y_is_turned_and_stays_so() {
    let sandbox = Sandbox::new();
    let file = raw(&sandbox, plant(1));
    let picture = |flags: &str, name: &str| {
        sandbox
            .run(&format!("render {file} --size 48 {flags} -o {name}.png"))
            .succeeds();
        png(&sandbox.path(&format!("{name}.png")))
    };
    let own = picture("", "own");
    assert_eq!(own, picture("--up y", "turned"));
    assert_ne!(own, picture("--up z", "lying"));
    // Whether it was decided or given, the picture records it.
    for name in ["own", "turned", "lying"] {
        sandbox
            .run(&format!("render --like {name}.png -w -o again.png"))
            .succeeds();
        assert_eq!(
            sandbox.bytes(&format!("{name}.png")),
            sandbox.bytes("again.png"),
            "{name}"
        );
    }
    // A different look does not turn it.
    let [own, turned] = ["", "--up y"].map(|up| picture(&format!("--iso 100 -w {up}"), "iso"));
    assert_eq!(own, turned);

    let text = sandbox.run(&format!("info {file}")).succeeds().stdout();
    assert!(
        text.contains("up                 y (the file does not say"),
        "{text}"
    );
    let axis = |arguments: &str| {
        let text = sandbox
            .run(&format!("info {arguments} --json"))
            .succeeds()
            .stdout();
        let report: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
        report["up"]["axis"].as_str().map(str::to_owned)
    };
    assert_eq!(axis(file).as_deref(), Some("y"));
    sandbox.run(&format!("convert {file} a.nrrd")).succeeds();
    assert_eq!(axis("a.nrrd").as_deref(), Some("z"), "the file says RAS");
    for up in [0, 2] {
        assert_eq!(axis(raw(&sandbox, plant(up))).as_deref(), Some("z"), "{up}");
    }
}

#[test]
fn gaussians_are_rendered_in_both_ways() {
    let sandbox = Sandbox::new();
    sandbox.write("red.ply", gaussian([1.0, 0.0, 0.0]));
    for mode in ["auto", "3dgs", "volumetric"] {
        sandbox
            .run(&format!(
                "render red.ply --gaussians {mode} --size 64 --background black -o {mode}.png"
            ))
            .succeeds();
        let (count, _) = pixels(&sandbox, &format!("{mode}.png"), RED);
        assert!(count > 300, "{mode}: {count}");
    }
    assert_eq!(png(&sandbox.path("auto.png")), png(&sandbox.path("3dgs.png")));
    assert_ne!(
        png(&sandbox.path("auto.png")),
        png(&sandbox.path("volumetric.png"))
    );
    sandbox
        .run("render red.ply --sheet-thickness 0.5 -o no.png")
        .fails(2, &["published", "--gaussians volumetric"]);
}

#[test]
fn a_picture_is_made_again_from_its_settings() {
    let sandbox = Sandbox::new();
    sandbox.write("red.txt", sphere(500, [0.0; 3], Some([255, 0, 0])));
    sandbox
        .run("render red.txt --size 48 --radius 0.1 --azimuth 20")
        .succeeds();
    sandbox.run("render --like red.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("red.png"), sandbox.bytes("again.png"));
    sandbox
        .run("render --like red.png --size 32 -o small.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("small.png")).0, 32);
    // Another file, shown in the same way.
    sandbox.write("green.txt", sphere(500, [0.0; 3], Some([0, 255, 0])));
    sandbox
        .run("render green.txt --like red.png -o green.png")
        .succeeds();
    assert_eq!(png(&sandbox.path("green.png")).0, 48);
    sandbox
        .run("render green.txt --like red.png --cmap gray -o no.png")
        .fails(2, &["--cmap has no meaning", "points"]);
    sandbox
        .run("animate --like red.png --frames 2 --size 16 -o turn.gif")
        .succeeds();
}

/// Pairs of columns in turn black and white, as PNG.
fn stripes(side: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    let codes: Vec<u8> = (0..side * side)
        .map(|i| if i % 4 < 2 { 0 } else { 255 })
        .collect();
    let mut writer = encoder.write_header().expect("the header is right");
    writer
        .write_image_data(&codes)
        .expect("the codes are as many as pixels");
    drop(writer);
    bytes
}

#[test]
fn finer_posts_keep_a_finer_picture() {
    let sandbox = Sandbox::new();
    sandbox.write("flat.csv", "1,1,1,1\n".repeat(4));
    sandbox.write("stripes.png", stripes(16));
    let render = "render flat.csv --kind terrain --drape stripes.png --view top --size 64 --background none";
    sandbox.run(&format!("{render} -o coarse.png")).succeeds();
    sandbox
        .run(&format!("{render} --posts 16x16 -o fine.png"))
        .succeeds();
    let spread = |name: &str| {
        let (_, _, codes) = png(&sandbox.path(name));
        let opaque = codes.chunks_exact(4).filter(|code| code[3] > 250);
        let red: Vec<u8> = opaque.map(|code| code[0]).collect();
        red.iter()
            .max()
            .zip(red.iter().min())
            .map_or(0, |(max, min)| max - min)
    };
    // Four columns to a post are grey; each of 16 posts has its own.
    assert!(
        spread("coarse.png") < 10 && spread("fine.png") > 100,
        "{} {}",
        spread("coarse.png"),
        spread("fine.png")
    );
    sandbox.run("render --like fine.png -o again.png").succeeds();
    assert_eq!(sandbox.bytes("fine.png"), sandbox.bytes("again.png"));
    sandbox
        .run("render flat.csv --kind terrain --posts 1x16 -o no.png")
        .fails(2, &["--posts", "at least 2"]);
    sandbox
        .run("render sample:ball --posts 16x16 -o no.png")
        .fails(2, &["--posts", "volume"]);
}

#[test]
fn flags_that_cannot_apply_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("a.txt", sphere(50, [0.0; 3], None));
    sandbox.write("g.ply", gaussian([1.0; 3]));
    for (arguments, words) in [
        ("render a.txt --cmap viridis", vec!["--cmap", "points"]),
        ("render a.txt --iso 3", vec!["--iso", "points"]),
        ("render a.txt --level 1", vec!["--level", "points"]),
        ("render a.txt --gaussians 3dgs", vec!["--gaussians"]),
        ("render a.txt --texture marble", vec!["effects"]),
        ("render a.txt --radius 0", vec!["--radius", "0"]),
        ("render a.txt --point-opacity 2", vec!["--point-opacity", "2"]),
        ("render a.txt --point-color 2,0,0", vec!["--point-color"]),
        ("render a.txt --up w", vec!["--up", "w"]),
        ("render a.txt --kind clouds", vec!["--kind", "depth-images"]),
        ("render g.ply --radius 1", vec!["--radius", "gaussians"]),
        (
            "render g.ply --point-color 1,0,0",
            vec!["--point-color", "gaussians"],
        ),
        ("render sample:head:16 --radius 1", vec!["--radius", "volume"]),
        ("render sample:head:16 --up w", vec!["--up", "w"]),
        (
            "render sample:head:16 --gaussians auto",
            vec!["--gaussians", "volume"],
        ),
        ("info a.txt --level 1", vec!["--level", "points"]),
    ] {
        sandbox.run(arguments).fails(2, &words);
    }
    // The format decides whether there is a choice.
    sandbox
        .run("render a.txt --array density")
        .fails(3, &["array", "density", "VTK"]);
    sandbox.run("render missing.ply").fails(3, &["missing.ply"]);
    sandbox.write(
        "bad.ply",
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nend_header\n0\n",
    );
    sandbox.run("render bad.ply").fails(3, &["bad.ply"]);
}

#[test]
fn info_says_what_points_and_gaussians_are() {
    let sandbox = Sandbox::new();
    sandbox.write("red.txt", sphere(50, [3.0, 0.0, 0.0], Some([255, 0, 0])));
    sandbox.write("g.ply", gaussian([1.0; 3]));
    let text = sandbox.run("info red.txt").succeeds().stdout();
    for words in [
        "points",
        "50",
        "colours            yes",
        "normals            none",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
    let json = |arguments: &str| -> serde_json::Value {
        let text = sandbox.run(arguments).succeeds().stdout();
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
    };
    let points = json("info red.txt --json");
    assert_eq!(
        (&points["kind"], &points["count"]),
        (&"points".into(), &50.into())
    );
    assert!(
        points["min"][0].as_f64().is_some_and(|x| (2.0..2.1).contains(&x)),
        "{points}"
    );
    let gaussians = json("info g.ply --json");
    assert_eq!(gaussians["kind"], "gaussians");
    assert_eq!(
        (&gaussians["count"], &gaussians["degree"]),
        (&1.into(), &0.into())
    );
    assert_eq!(json("info sample:head:16 --json")["kind"], "volume");
}
