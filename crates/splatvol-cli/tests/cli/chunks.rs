//! Volumes that are read in chunks, and pictures in parts, by the command.

use std::path::PathBuf;

use splatvol_io::read_image;

use crate::sandbox::Sandbox;

const VIEW: &str = "--view left --size 200x150 --no-metadata";

/// A head in chunks of 16 with levels, and the same in one piece.
fn converted() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.run("sample head --size 72 -o a.nrrd").succeeds();
    sandbox.run("convert a.nrrd a.ome.zarr --chunk 16").succeeds();
    sandbox
}

fn stats(sandbox: &Sandbox, name: &str) -> serde_json::Value {
    let json: serde_json::Value = serde_json::from_slice(&sandbox.bytes(name)).expect("statistics are JSON");
    json["chunks"].clone()
}

#[test]
fn pictures_of_chunks_are_those_of_memory() {
    let sandbox = converted();
    for (index, flags) in [
        "",
        "--compositing xray",
        "--compositing mip --orthographic",
        "--iso 300",
    ]
    .into_iter()
    .enumerate()
    {
        sandbox
            .run(&format!("render a.nrrd {VIEW} {flags} -o memory{index}.png"))
            .succeeds();
        for memory in ["64MiB", "1G"] {
            sandbox
                .run(&format!(
                    "render a.ome.zarr {VIEW} {flags} --memory {memory} --threads 2 --stats s.json -w -o chunks{index}.png"
                ))
                .succeeds();
            let [a, b] = ["memory", "chunks"].map(|name| sandbox.bytes(&format!("{name}{index}.png")));
            assert!(a == b, "{flags} {memory}");
            let chunks = stats(&sandbox, "s.json");
            let count = |key: &str| chunks[key].as_u64().unwrap();
            assert!(
                count("touched") > 0 && count("touched") <= count("all"),
                "{chunks}"
            );
            assert!(
                count("most_reads") >= 1 && count("planned_bytes") < 1 << 30,
                "{chunks}"
            );
        }
    }
    sandbox
        .run(&format!("render a.ome.zarr {VIEW} --memory 26M -o b.png"))
        .fails(4, &["memory", "it takes"]);
    // What needs all samples has them.
    for name in ["a.nrrd", "a.ome.zarr"] {
        sandbox
            .run(&format!(
                "render {name} {VIEW} --compositing per-splat --classification pre -w -o {name}.png"
            ))
            .succeeds();
    }
    assert!(sandbox.bytes("a.nrrd.png") == sandbox.bytes("a.ome.zarr.png"));
}

/// A label map of two balls.
fn balls(edge: usize) -> Vec<u8> {
    let header =
        format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {edge} {edge} {edge}\nencoding: raw\n\n");
    let mut bytes = header.into_bytes();
    let at = |n: usize| n as f64 / edge as f64;
    for index in 0..edge.pow(3) {
        let [x, y, z] = [index % edge, index / edge % edge, index / (edge * edge)].map(at);
        let within = |centre: f64| {
            let away = (x - centre).powi(2) + (y - 0.5).powi(2) + (z - centre).powi(2);
            away < 0.06
        };
        bytes.push(match (within(0.3), within(0.72)) {
            (true, _) => 3,
            (_, true) => 200,
            _ => 0,
        });
    }
    bytes
}

/// Label maps in chunks are drawn from levels that hold labels, and read whole where levels hold means.
#[test]
fn label_maps_in_chunks_have_levels_of_labels() {
    let sandbox = Sandbox::new();
    sandbox.write("a.nrrd", balls(96));
    sandbox
        .run("convert a.nrrd means.ome.zarr --chunk 16 --labels=false")
        .succeeds();
    let noted = sandbox
        .run("convert a.nrrd labels.ome.zarr --chunk 16")
        .succeeds();
    assert!(
        noted.stderr().contains("label map: levels have"),
        "{}",
        noted.stderr()
    );
    // What it is stays with it.
    sandbox
        .run("convert labels.ome.zarr again.ome.zarr --chunk 32 --ome-version 0.4")
        .succeeds();
    let view = "--labels --size 48 --view front --no-metadata --memory 256MiB";
    let picture = |name: &str| {
        sandbox
            .run(&format!("render {name} {view} --stats s.json -w -o {name}.png"))
            .succeeds();
        let json: serde_json::Value = serde_json::from_slice(&sandbox.bytes("s.json")).unwrap();
        let read = json["chunks"]["reads"].as_u64().unwrap();
        let image = read_image(sandbox.path(&format!("{name}.png"))).unwrap().image;
        (json["level"].as_u64().unwrap(), read, image)
    };
    let (_, _, whole) = picture("a.nrrd");
    let (_, reads, means) = picture("means.ome.zarr");
    assert!(reads == 0 && means.pixels == whole.pixels, "read whole");
    // The same where nobody said that they are labels, and for a picture like it.
    sandbox
        .run("render means.ome.zarr --size 48 --view front -o seen.png")
        .succeeds();
    sandbox.run("render --like seen.png -o again.png").succeeds();
    let seen = sandbox.bytes("seen.png");
    assert!(seen == sandbox.bytes("again.png"));
    let (level, reads, own) = picture("labels.ome.zarr");
    assert!(level > 0 && reads > 0, "level {level}, {reads} reads");
    let (_, _, again) = picture("again.ome.zarr");
    assert!(own.pixels == again.pixels);
    let squares = own.pixels.iter().flatten().zip(whole.pixels.iter().flatten());
    let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let decibels = -10.0 * (sum / (4 * own.pixels.len()) as f64).log10();
    assert!(decibels > 25.0, "{decibels}");
}

/// Lost chunks of images that are otherwise read whole are holes, too.
#[test]
fn small_images_of_one_level_have_holes() {
    let sandbox = Sandbox::new();
    sandbox
        .run("convert sample:head:64 a.ome.zarr --chunk 32 --levels 1 --ome-version 0.4")
        .succeeds();
    std::fs::remove_file(sandbox.path("a.ome.zarr/0/1/1/1")).unwrap();
    let picture = "render a.ome.zarr --size 32 -o a.png";
    sandbox.run(picture).fails(3, &["the chunk is gone"]);
    let run = sandbox
        .run(&format!("{picture} --missing-chunks background"))
        .succeeds();
    assert!(run.stderr().contains("chunks were lost"), "{}", run.stderr());
}

/// Flat files that are larger than the memory are read in pieces; levels that they lack are made as pictures need them.
#[test]
fn flat_files_larger_than_the_memory_look_as_they_do_in_memory() {
    let sandbox = Sandbox::new();
    sandbox.run("sample shells --size 352 -o a.npy").succeeds();
    let look = "--cmap viridis --opacity linear --clim 30,220 --size 200x150 --no-metadata";
    let camera = "--camera-pos=-300,-600,200 --camera-target=0,0,0";
    for (index, flags) in [
        "",
        "--compositing mip",
        "--camera-fov 100 --camera-pos=-60,-180,20",
    ]
    .into_iter()
    .enumerate()
    {
        let camera = if flags.contains("-pos") {
            "--camera-target=0,0,0"
        } else {
            camera
        };
        let picture = format!("render a.npy {look} {camera} {flags}");
        sandbox.run(&format!("{picture} -o memory{index}.png")).succeeds();
        let run = sandbox.run(&format!(
            "{picture} --memory 64MiB --stats s{index}.json -o pieces{index}.png"
        ));
        let run = run.succeeds();
        assert!(run.stderr().contains("43614208 bytes"), "{}", run.stderr());
        let chunks = stats(&sandbox, &format!("s{index}.json"));
        assert!(chunks["planned_bytes"].as_u64().unwrap() <= 64 << 20, "{chunks}");
        let [a, b] = ["memory", "pieces"].map(|name| sandbox.bytes(&format!("{name}{index}.png")));
        assert!(a == b, "{flags}");
    }
    sandbox
        .run("render a.npy --size 60 --memory 26MiB -o none.png")
        .fails(2, &["--memory", "at least 30M"]);
    // The overview is enough for everything that has not to be exact.
    sandbox
        .run("render a.npy --size 60 --memory 64MiB -o automatic.png")
        .succeeds();
}

#[cfg(feature = "remote")]
#[test]
fn pictures_of_addresses_are_those_of_their_files() {
    use splatvol_testing::server::{Fault, serve};

    let sandbox = converted();
    let server = serve(sandbox.path(""), Fault::Nothing);
    let address = format!("{}/a.ome.zarr", server.address);
    sandbox
        .run(&format!("render a.ome.zarr {VIEW} -o local.png"))
        .succeeds();
    sandbox
        .run(&format!("render {address} {VIEW} -o remote.png"))
        .succeeds();
    assert!(sandbox.bytes("local.png") == sandbox.bytes("remote.png"));
    assert!(server.requests() > 20);
    let info = sandbox.run(&format!("info {address}")).succeeds();
    assert!(info.stdout().contains("72"), "{}", info.stdout());
    // Recipes and pictures name the address; a picture does not make others ask for it unless they allow that.
    sandbox
        .run(&format!("render {address} --size 40 --recipe recipe.json"))
        .succeeds();
    sandbox.run("part recipe.json 0/2 -o 0.part").succeeds();
    sandbox.run("part recipe.json 1/2 -o 1.part").succeeds();
    sandbox.run("assemble 0.part 1.part -o a.png").succeeds();
    sandbox
        .run("render --like a.png -o b.png")
        .fails(3, &["--allow-outside", &address]);
    sandbox
        .run("render --like a.png --allow-outside -o b.png")
        .succeeds();
    // A scene may name one.
    sandbox.write("scene.toml", format!("[[item]]\nfile = \"{address}\"\n"));
    sandbox.run("render scene.toml --size 40 -o c.png").succeeds();
    for (wrong, expected) in [
        (
            format!("{}/nothing.zarr", server.address),
            "neither multiscales nor an array",
        ),
        (format!("{address}?token=secret"), "query"),
    ] {
        let run = sandbox.run(&format!("render {wrong} -o d.png"));
        let run = run.fails(3, &[expected]);
        assert!(!run.stderr().contains("secret"), "{}", run.stderr());
    }
}

#[cfg(not(feature = "remote"))]
#[test]
fn addresses_need_the_feature() {
    Sandbox::new()
        .run("render https://host/a.ome.zarr")
        .fails(3, &["https://host/a.ome.zarr", "without the feature remote"]);
}

/// The file of the shard that holds the finest level's first chunks.
fn shard(sandbox: &Sandbox) -> PathBuf {
    sandbox.path("a.ome.zarr/0/c/0/0/0")
}

#[test]
fn faults_are_named_and_holes_are_counted() {
    let sandbox = converted();
    let whole = std::fs::read(shard(&sandbox)).unwrap();
    let mut damaged = whole.clone();
    damaged[20] ^= 1;
    std::fs::write(shard(&sandbox), &damaged).unwrap();
    let render = format!("render a.ome.zarr {VIEW} --compositing mean -w -o b.png");
    sandbox
        .run(&render)
        .fails(3, &["level 0", "chunk 0,0,0", "c/0/0/0", "codec"]);
    sandbox
        .run(&format!("{render} --missing-chunks background"))
        .fails(3, &["chunk 0,0,0"]);
    std::fs::write(shard(&sandbox), &whole[..whole.len() / 2]).unwrap();
    sandbox.run(&render).fails(3, &["level 0", "c/0/0/0"]);
    std::fs::remove_file(shard(&sandbox)).unwrap();
    sandbox.run(&render).fails(3, &["level 0", "c/0/0/0", "gone"]);
    let run = sandbox
        .run(&format!("{render} --missing-chunks background --stats s.json"))
        .succeeds();
    assert!(run.stderr().contains("chunks were lost"), "{}", run.stderr());
    assert!(stats(&sandbox, "s.json")["holes"].as_u64().unwrap() > 0);
}

#[test]
fn parts_make_the_picture() {
    let sandbox = converted();
    let view = "--view left --size 200x150 --coverage adaptive";
    sandbox
        .run(&format!("render a.ome.zarr {view} -o whole.png"))
        .succeeds();
    sandbox
        .run(&format!("render a.ome.zarr {view} --recipe recipe.json"))
        .succeeds();
    std::fs::create_dir(sandbox.path("parts")).unwrap();
    for index in [3, 0, 2] {
        sandbox
            .run(&format!(
                "part recipe.json {index}/4 --memory 160M -o parts/{index}.part"
            ))
            .succeeds();
    }
    sandbox
        .run("assemble parts -o b.png")
        .fails(3, &["have no part", "column"]);
    sandbox
        .run("part recipe.json 0,0,200x75 --threads 1 -o parts/1.part")
        .succeeds();
    sandbox.run("assemble parts -o b.png").succeeds();
    let [whole, assembled] = ["whole.png", "b.png"].map(|name| read_image(sandbox.path(name)).unwrap().image);
    assert_eq!(whole.pixels, assembled.pixels);
    // In bands of rows, the same.
    sandbox.run("assemble parts --memory 2M -o rows.png").succeeds();
    let rows = read_image(sandbox.path("rows.png")).unwrap().image;
    assert_eq!(whole.pixels, rows.pixels);
    // The record is that of the picture.
    let run = sandbox.run("render --like b.png -w -o c.png").succeeds();
    assert!(run.stderr().contains("c.png"));
    assert_eq!(
        read_image(sandbox.path("c.png")).unwrap().image.pixels,
        whole.pixels
    );
    // Made again, a part stays; another one is not written over it.
    let before = sandbox.bytes("parts/0.part");
    sandbox.run("part recipe.json 0/4 -o parts/0.part").succeeds();
    assert!(before == sandbox.bytes("parts/0.part"));
    sandbox
        .run("part recipe.json 1/4 -o parts/0.part")
        .fails(5, &["already exists"]);
    sandbox
        .run("part recipe.json 5/4 -o parts/5.part")
        .fails(2, &["5/4", "expected"]);
    let mut damaged = before.clone();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    sandbox.write("parts/0.part", &damaged);
    sandbox
        .run("assemble parts -w -o b.png")
        .fails(3, &["0.part", "not those that were written"]);
}

#[test]
fn parts_of_files_that_have_changed_are_not_put_together() {
    let sandbox = Sandbox::new();
    sandbox.run("sample head --size 16 -o a.npy").succeeds();
    sandbox
        .run("render a.npy --size 32x32 --recipe recipe.json")
        .succeeds();
    sandbox.run("part recipe.json 0/2 -o 0.part").succeeds();
    let first = sandbox.bytes("a.npy");
    let mut changed = first.clone();
    let last = changed.len() - 1;
    changed[last] ^= 1;
    sandbox.write("a.npy", &changed);
    sandbox.run("part recipe.json 1/2 -o 1.part").succeeds();
    sandbox
        .run("assemble 0.part 1.part -o a.png")
        .fails(3, &["1.part", "state of files"]);
    // Nor does a part of what the file was count as made.
    sandbox
        .run("part recipe.json 0/2 -o 0.part")
        .fails(5, &["already exists"]);
    sandbox.write("a.npy", &first);
    sandbox.run("part recipe.json 1/2 -w -o 1.part").succeeds();
    sandbox.run("assemble 0.part 1.part -o a.png").succeeds();
}

#[test]
fn info_of_images_in_chunks_is_that_of_images_in_memory() {
    let sandbox = converted();
    let info = |name: &str| -> serde_json::Value {
        let text = sandbox.run(&format!("info {name} --json")).succeeds().stdout();
        serde_json::from_str(&text).unwrap()
    };
    let [memory, chunks] = ["a.nrrd", "a.ome.zarr"].map(info);
    for key in [
        "dims",
        "min",
        "max",
        "histogram",
        "sample-type",
        "memory-bytes",
        "transfer-function",
    ] {
        assert_eq!(memory[key], chunks[key], "{key}");
    }
}
