//! An instance against the engine that it is: the same bytes, whole or in shares; and what it refuses.

#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::Path;

use serde_json::{Value, json};
use splatvol::glam::DAffine3;
use splatvol::mesh::{Association, Mesh, MeshField, Topology};
use splatvol::{
    EngineConfig, Frame, GaussianAttributes, Gaussians, ImageSize, PointAttributes, Points, Renderer, Volume,
};
use splatvol_document::resolve::laid_over;
use splatvol_document::{CameraMotion, Document, Held, ReadRules, Reading, Resolving, Silent};
use splatvol_io::{Data, Description};
use splatvol_web::{ItemData, Precision, Session, Shown, held};

const SIZE: [u32; 2] = [150, 130];

fn volume(name: &str, longest: usize) -> Volume {
    splatvol::samples::sample(name, Some(splatvol_samples::SampleSize::Longest(longest))).unwrap()
}

/// Data of an item as a page has them.
struct Packed {
    data: ItemData,
    bytes: Vec<u8>,
}

impl Packed {
    fn new(data: Data) -> Self {
        const PRECISION: Precision = Precision { places: 20, rest: 12 };
        let (data, bytes) = ItemData::pack(&data.into(), PRECISION);
        Self { data, bytes }
    }

    fn unpacked(&self) -> Data {
        self.data.unpack(&mut &self.bytes[..]).unwrap()
    }
}

/// A sample, packed.
fn sample(name: &str, longest: usize) -> Packed {
    Packed::new(Data::Volume(volume(name, longest)))
}

/// Points on a ball, with normals, colours and radii.
fn points() -> Packed {
    let directions = (0..900).map(|i| {
        let (height, angle) = (1.0 - 2.0 * (i as f32 + 0.5) / 900.0, i as f32 * 2.4);
        let radius = (1.0 - height * height).sqrt();
        [radius * angle.cos(), radius * angle.sin(), height]
    });
    let directions: Vec<[f32; 3]> = directions.collect();
    let attributes = PointAttributes {
        colors: directions
            .iter()
            .map(|d| [(128.0 + 127.0 * d[0]) as u8, 160, 60, 255])
            .collect(),
        normals: directions.clone(),
        radii: vec![0.08; 900],
    };
    Packed::new(Data::Points(
        Points::new(directions, attributes, DAffine3::IDENTITY).unwrap(),
    ))
}

/// A few large Gaussians whose colour depends on the direction.
fn gaussians() -> Packed {
    let wave = |i: usize, rate: f32| (i as f32 * rate).sin();
    let attributes = GaussianAttributes {
        means: (0..150)
            .map(|i| [wave(i, 1.3), wave(i, 2.1), wave(i, 0.7)])
            .collect(),
        scales: (0..150).map(|i| [0.05 + 0.001 * i as f32, 0.1, 0.02]).collect(),
        rotations: (0..150).map(|i| [wave(i, 0.5), 0.3, 0.0, 1.0]).collect(),
        opacities: (0..150).map(|i| 0.3 + (i % 7) as f32 / 10.0).collect(),
        harmonics: (0..600).map(|i| [wave(i, 0.9), 0.4, wave(i, 0.4)]).collect(),
    };
    Packed::new(Data::Gaussians(
        Gaussians::new(attributes, 1, DAffine3::IDENTITY).unwrap(),
    ))
}

/// A bent block of values.
fn mesh() -> Packed {
    let places = (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|at| at as f32 / 9.0));
    let positions: Vec<[f32; 3]> = places.map(|[x, y, z]| [x + 0.3 * z * z, y, z]).collect();
    let field = MeshField {
        name: "heat".to_owned(),
        association: Association::Point,
        values: positions
            .iter()
            .map(|[x, y, z]| (3.0 * x).sin() + y * z)
            .collect(),
    };
    let blocks = Topology::Structured(vec![[10, 10, 10]]);
    Packed::new(Data::Mesh(
        Mesh::new(positions, blocks, Vec::new(), field, DAffine3::IDENTITY).unwrap(),
    ))
}

/// Documents of all kinds of data, by every way in which an engine draws volumes.
fn documents() -> Vec<(&'static str, Value, Vec<Packed>)> {
    let head = || vec![sample("head", 40)];
    let one = |keys: Value, rest: Value| {
        let mut document = json!({ "size": "150x130", "item": [{ "file": "head" }] });
        for (key, value) in keys.as_object().unwrap() {
            document["item"][0][key] = value.clone();
        }
        for (key, value) in rest.as_object().unwrap() {
            document[key] = value.clone();
        }
        document
    };
    vec![
        (
            "opaque",
            one(json!({}), json!({ "camera": { "view": "front" } })),
            head(),
        ),
        (
            "translucent",
            one(
                json!({ "cmap": "viridis", "opacity": "linear" }),
                json!({ "background": "white" }),
            ),
            head(),
        ),
        (
            "largest",
            one(json!({}), json!({ "settings": { "compositing": "mip" } })),
            head(),
        ),
        (
            "xray",
            one(
                json!({}),
                json!({ "settings": { "compositing": "xray" }, "background": "none" }),
            ),
            head(),
        ),
        (
            "pre",
            one(json!({}), json!({ "settings": { "classification": "pre" } })),
            head(),
        ),
        (
            "edges",
            one(
                json!({ "iso": 300.0 }),
                json!({ "settings": { "coverage": "adaptive" } }),
            ),
            head(),
        ),
        (
            "best",
            one(json!({}), json!({ "settings": { "preset": "best" } })),
            vec![sample("tomato", 32)],
        ),
        (
            "cut",
            one(
                json!({}),
                json!({ "camera": { "orthographic": true }, "effects": { "clip-box": [-200.0, 0.0, -200.0, 200.0, -200.0, 200.0] } }),
            ),
            head(),
        ),
        (
            "two",
            json!({
                "size": "150x130",
                "item": [
                    { "file": "head", "opacity": "linear", "cmap": "gray" },
                    { "file": "ball", "translate": [60.0, 0.0, 0.0], "scale": 30.0 },
                ],
            }),
            vec![sample("head", 32), sample("ball", 16)],
        ),
        (
            "points",
            json!({ "size": "150x130", "item": [{ "file": "points", "rotate": ["x", 20.0] }] }),
            vec![points()],
        ),
        (
            "gaussians",
            json!({ "size": "150x130", "item": [{ "file": "gaussians", "up": "y" }], "background": "none" }),
            vec![gaussians()],
        ),
        (
            "mesh",
            json!({ "size": "150x130", "item": [{ "file": "mesh", "opacity": "linear" }] }),
            vec![mesh()],
        ),
        (
            "all",
            json!({
                "size": "150x130",
                "item": [
                    { "file": "gaussians" },
                    { "file": "head", "scale": 0.005, "translate": [1.0, 0.0, 0.0] },
                    { "file": "points", "translate": [-1.0, 0.5, 0.0] },
                    { "file": "mesh", "translate": [0.0, 0.0, 1.0] },
                ],
            }),
            vec![gaussians(), sample("head", 32), points(), mesh()],
        ),
    ]
}

fn opened(document: &Value, items: &[Packed]) -> (Session, Value) {
    let data: Vec<&ItemData> = items.iter().map(|item| &item.data).collect();
    let bytes = items
        .iter()
        .map(|item| &item.bytes[..])
        .collect::<Vec<_>>()
        .concat();
    let mut session = Session::new().unwrap();
    let header = json!({ "do": "open", "document": document, "data": data });
    let answer = session.answer(&header.to_string(), &bytes);
    (session, serde_json::from_str(&answer.header).unwrap())
}

fn ask(session: &mut Session, header: &Value) -> (Value, Vec<u8>) {
    let answer = session.answer(&header.to_string(), &[]);
    (serde_json::from_str(&answer.header).unwrap(), answer.bytes)
}

/// The picture in shares, put together.
fn picture(document: &Value, items: &[Packed], shares: usize) -> Vec<u8> {
    let width = SIZE[0] as usize;
    let mut pixels = vec![0; 4 * width * SIZE[1] as usize];
    for index in 0..shares {
        // Each by an instance of its own.
        let (mut session, opened) = opened(document, items);
        assert!(opened.get("error").is_none(), "{opened}");
        let header = json!({ "do": "render", "size": SIZE, "share": [index, shares] });
        let (header, bytes) = ask(&mut session, &header);
        let mut rest = &bytes[..];
        for tile in header["tiles"].as_array().unwrap_or_else(|| panic!("{header}")) {
            let [x0, y0, x1, y1] = std::array::from_fn(|i| tile[i].as_u64().unwrap() as usize);
            for y in y0..y1 {
                let (row, others) = rest.split_at(4 * (x1 - x0));
                pixels[4 * (y * width + x0)..4 * (y * width + x1)].copy_from_slice(row);
                rest = others;
            }
        }
        assert!(rest.is_empty());
    }
    pixels
}

/// The picture as the command makes it.
fn command(document: &Value, items: &[Packed]) -> Vec<u8> {
    let document = Document::from_json(&document.to_string(), "document".as_ref()).unwrap();
    let held: Vec<_> = items
        .iter()
        .map(|item| Some(held(item.unpacked().into())))
        .collect();
    let reading = Reading {
        rules: ReadRules::default(),
        folder: None,
        listener: &Silent,
    };
    let resolving = Resolving {
        reading,
        held: &held,
        moves: CameraMotion::default(),
        keeps_alpha: false,
        in_windows: false,
    };
    let picture = document.resolve(resolving).unwrap();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let frame = renderer
        .render(&picture.scene, &picture.camera, &picture.settings)
        .unwrap();
    let image = match picture.background() {
        Some(color) => laid_over(&frame.image, color),
        None => frame.image,
    };
    splatvol_io::image::png::srgb8(&image).as_flattened().to_vec()
}

#[test]
fn all_shares_together_are_the_commands_picture_to_the_byte() {
    for (index, (name, document, items)) in documents().into_iter().enumerate() {
        let expected = command(&document, &items);
        assert!(
            expected.chunks(4).any(|pixel| pixel != &expected[..4]),
            "{name}: nothing to see"
        );
        for shares in [1, 2 + index % 4] {
            assert!(
                picture(&document, &items, shares) == expected,
                "{name} in {shares} shares"
            );
        }
    }
}

#[test]
fn two_shares_have_half_of_the_work_each() {
    let volume = volume("head", 32);
    for compositing in ["image-sheets", "mip", "xray"] {
        let text =
            json!({ "item": [{ "file": "head" }], "settings": { "compositing": compositing } }).to_string();
        let document = Document::from_json(&text, Path::new("document")).unwrap();
        let held = Held::new(Data::Volume(volume.clone()), Description::default());
        let shown = Shown::new(&document, vec![Some(held)]).unwrap();
        let voxels = |share: [usize; 2]| {
            let config = EngineConfig {
                tile_edge: Some(splatvol_web::BLOCK),
                ..EngineConfig::default()
            };
            let mut renderer = Renderer::new(config).unwrap();
            let mut frame = Frame::empty(ImageSize::new(1, 1).unwrap());
            let tiles = shown.tiles(Some([512, 512]), None, Some(share)).unwrap();
            tiles.draw((&mut renderer, &mut frame), None).unwrap();
            renderer.statistics().voxels as f64
        };
        let whole = voxels([0, 1]);
        for index in 0..2 {
            let share = voxels([index, 2]) / whole;
            assert!((0.35..0.65).contains(&share), "{compositing}, {index}: {share}");
        }
    }
}

#[test]
fn what_is_opened_says_what_it_is_and_leaves_nothing_open() {
    let (_, document, items) = documents().swap_remove(0);
    let (_, facts) = opened(&document, &items);
    let item = &facts["items"][0];
    assert_eq!(item["name"], "head");
    let Data::Volume(volume) = items[0].unpacked() else {
        panic!("no volume");
    };
    let [x, y, z] = volume.grid().dims();
    assert_eq!(item["size"], format!("{x} × {y} × {z} samples"));
    assert_eq!(item["unit"], "mm");
    let counts: u64 = item["values"]["histogram"]
        .as_array()
        .unwrap()
        .iter()
        .map(|count| count.as_u64().unwrap())
        .sum();
    assert_eq!(counts as usize, volume.samples().len());
    let document = &facts["document"];
    assert!(
        document["camera"]["position"].is_array() && document["item"][0]["transfer-function"].is_object()
    );
    assert!(facts["bounds"]["min"][0].as_f64() < facts["bounds"]["max"][0].as_f64());
    assert!(
        facts["color-maps"]
            .as_array()
            .unwrap()
            .contains(&json!("viridis"))
    );
}

#[test]
fn a_look_is_of_the_opened_one_and_what_is_taken_back_leaves_no_trace() {
    let (_, document, items) = documents().swap_remove(1);
    let (mut session, _) = opened(&document, &items);
    let render = json!({ "do": "render", "size": SIZE });
    let (_, first) = ask(&mut session, &render);
    let look = |look: Value| json!({ "do": "look", "item": 0, "look": look });
    let cut =
        |value: Value| json!({ "do": "edit", "edits": [{ "path": "effects.clip-box", "value": value }] });
    let mut seen = vec![first.clone()];
    for edit in [
        look(json!({ "range": [100.0, 900.0] })),
        look(json!({ "strength": 3.0 })),
        look(json!({ "cmap": "turbo", "opacity": "sigmoid" })),
        cut(json!([-500.0, 500.0, -500.0, 500.0, 0.0, 500.0])),
    ] {
        let (said, _) = ask(&mut session, &edit);
        assert!(said["document"].is_object(), "{said}");
        let (_, picture) = ask(&mut session, &render);
        assert!(!seen.contains(&picture), "{edit} changes nothing");
        seen.push(picture);
    }
    ask(&mut session, &look(json!({})));
    ask(&mut session, &cut(Value::Null));
    assert!(ask(&mut session, &render).1 == first);
}

#[test]
fn cameras_are_found_for_views_and_kept_for_pictures() {
    let (_, document, items) = documents().swap_remove(0);
    let (mut session, facts) = opened(&document, &items);
    let (front, _) = ask(
        &mut session,
        &json!({ "do": "camera", "camera": { "view": "front" }, "size": SIZE }),
    );
    assert_eq!(front["position"], facts["document"]["camera"]["position"]);
    let (top, _) = ask(
        &mut session,
        &json!({ "do": "camera", "camera": { "view": "top" }, "size": SIZE }),
    );
    let render = |camera: &Value| {
        let keys = json!({ "position": camera["position"], "target": camera["target"], "up": camera["up"],
            "fov": camera["projection"]["perspective"]["fov_degrees"] });
        json!({ "do": "render", "size": SIZE, "camera": keys })
    };
    let (header, from_top) = ask(&mut session, &render(&top));
    assert_eq!(header["camera"], top);
    let (_, from_front) = ask(&mut session, &json!({ "do": "render" }));
    assert!(from_front == ask(&mut session, &render(&front)).1 && from_front != from_top);
}

#[test]
fn what_cannot_be_answered_is_said_and_changes_nothing() {
    let (_, document, items) = documents().swap_remove(0);
    let mut empty = Session::new().unwrap();
    assert!(
        ask(&mut empty, &json!({ "do": "render" })).0["error"]
            .as_str()
            .unwrap()
            .contains("no document")
    );
    let (mut session, _) = opened(&document, &items);
    let render = json!({ "do": "render", "size": [32, 32] });
    let (_, before) = ask(&mut session, &render);
    let data = &items[0].data;
    for (refused, why) in [
        (json!({}), "not understood"),
        (json!({ "do": "dance" }), "not understood"),
        (json!({ "do": "render", "size": [0, 9] }), "size"),
        (
            json!({ "do": "render", "size": [9, 9], "share": [2, 2] }),
            "share",
        ),
        (
            json!({ "do": "render", "size": [9, 9], "camera": { "fov": -1.0 } }),
            "fov",
        ),
        (json!({ "do": "look", "item": 1, "look": {} }), "item 1"),
        (
            json!({ "do": "look", "item": 0, "look": { "cmap": "mauve" } }),
            "mauve",
        ),
        (
            json!({ "do": "edit", "edits": [{ "path": "effects.clip", "value": 1 }] }),
            "effects.clip",
        ),
        (
            json!({ "do": "edit", "edits": [{ "path": "item[0].visible", "value": false }] }),
            "visible",
        ),
        (
            json!({ "do": "edit", "edits": [{ "path": "background", "value": "white" }, { "path": "size", "value": "no" }] }),
            "size",
        ),
        (
            json!({ "do": "open", "document": document, "data": [] }),
            "0 items have data",
        ),
        (
            json!({ "do": "open", "document": document, "data": [data] }),
            "as many bytes",
        ),
        (
            json!({ "do": "open", "document": { "version": 99 }, "data": [] }),
            "version",
        ),
    ] {
        let (said, bytes) = ask(&mut session, &refused);
        let error = said["error"]
            .as_str()
            .unwrap_or_else(|| panic!("{refused} is answered: {said}"));
        assert!(error.contains(why) && bytes.is_empty(), "{refused}: {error}");
    }
    assert!(ask(&mut session, &render).1 == before);
}

#[test]
fn points_and_gaussians_have_no_transfer_function_and_meshes_have() {
    let of = |item: Packed| {
        let document = json!({ "item": [{ "file": "a" }] });
        let (mut session, facts) = opened(&document, &[item]);
        let look = json!({ "do": "look", "item": 0, "look": { "strength": 2.0 } });
        let (said, _) = ask(&mut session, &look);
        (facts["items"][0].clone(), said)
    };
    for (item, size) in [
        (points(), "900 points"),
        (gaussians(), "150 Gaussians, harmonics of degree 1"),
    ] {
        let (facts, said) = of(item);
        assert_eq!((&facts["size"], &facts["values"]), (&size.into(), &Value::Null));
        assert!(
            said["error"].as_str().unwrap().contains("no transfer function"),
            "{said}"
        );
    }
    let (facts, said) = of(mesh());
    assert_eq!(facts["size"], "729 cells, 1000 points");
    let counts = facts["values"]["histogram"].as_array().unwrap().iter();
    assert_eq!(counts.map(|count| count.as_u64().unwrap()).sum::<u64>(), 1000);
    assert!(said["document"].is_object(), "{said}");
}
