//! Transfer functions, camera paths, scenes, and pictures that say how they were made.

use splatvol::{ColorMap, Image, ImageSize, OpacityCurve, TransferFunction};
use splatvol_document::{Document, Record};
use splatvol_io::{ImageFormat, write_image, write_transfer_function};

use super::written;
use crate::input::Input;

/// A document with a table of every kind; the rest of the keys are words of the dictionary.
const SCENE: &str = "version = 2\n[[item]]\nfile = \"sample:head:16\"\ncmap = \"viridis\"\nopacity = \"linear\"\n\
    [[item]]\nfile = \"sample:shells:16\"\n[camera]\nview = \"front\"\nfov = 30\n[settings]\n";

pub(crate) fn transfer_functions() -> Vec<Input> {
    let map = ColorMap::from_name("viridis").unwrap();
    let curve = OpacityCurve::from_name("linear").unwrap();
    let function = TransferFunction::from_map_and_opacity([-100.0, 300.0], map, curve, Some(3.25)).unwrap();
    let colors = function.colors().iter().step_by(64).cloned().collect();
    let short = TransferFunction::new(colors, function.opacities().to_vec(), Some(3.25)).unwrap();
    let of_writer = |name| written(name, |path| write_transfer_function(path, &short).unwrap());
    let preset = "[{\"ColorSpace\": \"Diverging\", \"Name\": \"A\", \"NanColor\": [1, 1, 0], \"RGBPoints\": [0, 0.2, \
        0.3, 0.7, 1, 0.7, 0.01, 0.1], \"Points\": [-50, 0, 0.5, 0, 200, 0.5, 0.5, 0]}]";
    let inviwo = "<?xml version=\"1.0\" ?>\n<InviwoWorkspace version=\"2\">\n<maskMin content=\"0.25\" />\
        <maskMax content=\"1\" /><type content=\"0\" />\n<Points>\n<Point><pos content=\"0.5\" />\
        <rgba x=\"1\" y=\"0.5\" z=\"0\" w=\"0.4\" /></Point>\n<Point><pos content=\"0\" />\
        <rgba x=\"0\" y=\"0\" z=\"0\" w=\"0\" /></Point>\n</Points></InviwoWorkspace>";
    let table: Vec<u8> = (0..768).map(|i| (i * 5) as u8).collect();
    let mut head = b"ICOL\x01\x00\x01\x00".to_vec();
    head.resize(32, 0);
    vec![
        of_writer("a.vp.json"),
        of_writer("a.json"),
        Input::file("preset.json", preset),
        Input::file("a.itf", inviwo),
        Input::file("plain.lut", table.clone()),
        Input::file("head.lut", [head, table].concat()),
        Input::file(
            "text.lut",
            "Index,Red,Green,Blue\n0,1,2,3\n1,50,60,70\n2,255,255,255\n",
        ),
    ]
}

pub(crate) fn two_dimensional() -> Vec<Input> {
    let regions = "{\"unit-distance\": 1.0, \"regions\": [{\"value\": [200, 900], \"gradient\": [80, 400], \
        \"rgb\": [0.9, 0.8, 0.7], \"opacity\": 0.5, \"softness\": 0.3}]}";
    let image = "{\"image\": \"a.png\", \"value\": [-1000, 2000], \"gradient\": [0, 500]}";
    let mut files = picture("a.png", &[]).files;
    files.push(("b.json".to_owned(), image.as_bytes().to_vec()));
    vec![Input::file("a.json", regions), Input::files("b.json", files)]
}

pub(crate) fn camera_paths() -> Vec<Input> {
    let toml = "[[key]]\ntime = 0.0\nposition = [0, 400, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov = 30\n\
        [[key]]\ntime = 1.5\nposition = [400, 0, 1e1]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov = 30\n";
    let json =
        "{\"key\": [{\"position\": [0, 400, 0], \"height\": 20}, {\"position\": [4, 0, 0], \"height\": 20}]}";
    vec![Input::file("a.toml", toml), Input::file("a.json", json)]
}

fn documents() -> Vec<Document> {
    let document = Document::from_toml(SCENE, "scene.toml".as_ref()).unwrap();
    let short = Document::from_toml("[[item]]\nfile = \"sample:head:16\"\n", "short.toml".as_ref()).unwrap();
    vec![document, short]
}

pub(crate) fn scenes() -> Vec<Input> {
    let mut seeds = vec![Input::file("a.toml", SCENE)];
    for (index, document) in documents().iter().enumerate() {
        seeds.push(Input::file(&format!("{index}.toml"), document.to_toml().unwrap()));
        seeds.push(Input::file(
            &format!("{index}.json"),
            document.to_json(true).unwrap(),
        ));
    }
    let old = "[[item]]\nfile = \"sample:head:16\"\n[settings]\nkernel = { gaussian = { sigma = 0.7 } }\n";
    seeds.extend(
        Document::from_toml(old, "old.toml".as_ref())
            .ok()
            .map(|_| Input::file("old.toml", old)),
    );
    seeds
}

/// A picture of 4 x 3 pixels.
fn picture(name: &str, texts: &[(String, String)]) -> Input {
    let size = ImageSize::new(4, 3).unwrap();
    let image = Image::filled(size, [0.5; 4]);
    written(name, |path| {
        let format = ImageFormat::from_path(path).unwrap();
        write_image(path, &image, None, format, texts).unwrap();
    })
}

pub(crate) fn pictures() -> Vec<Input> {
    let of = |document| Record {
        document,
        command: "splatvol render a.nrrd".to_owned(),
    };
    let mut seeds = Vec::new();
    for document in documents() {
        let texts = of(document).metadata().unwrap();
        seeds.push(picture("a.png", &texts));
        seeds.push(picture("a.exr", &texts));
    }
    seeds
}
