//! Transfer functions of other programs: supported features, warnings, and refusals.

use std::path::Path;

use splatvol_io::{IoError, read_transfer_function, write_transfer_function};
use splatvol_scene::{ColorMap, ColorPoint, OpacityCurve, OpacityPoint, TransferFunction};

const RANGE: [f64; 2] = [-100.0, 300.0];

fn read(name: &str, contents: impl AsRef<[u8]>) -> Result<(TransferFunction, Vec<String>), IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, contents).unwrap();
    read_transfer_function(&path, RANGE)
}

/// The error's text without the folder.
fn refusal(name: &str, contents: impl AsRef<[u8]>) -> String {
    let text = read(name, contents).unwrap_err().to_string();
    let cut = text.rfind(", in ").unwrap();
    text[..cut].to_owned()
}

fn awkward() -> TransferFunction {
    let mut colors = vec![
        ColorPoint::new(-99.5, [0.1, 0.2, 0.3]),
        ColorPoint::new(10.0, [1.0, 0.0, 0.5]),
        ColorPoint::new(1e-7, [0.0; 3]),
    ];
    colors[0].midpoint = 0.25;
    colors[0].sharpness = 0.5;
    let mut opacities = vec![
        OpacityPoint::new(0.0, 0.0),
        OpacityPoint::new(50.0, 0.1 + 0.2),
        OpacityPoint::new(50.0, 0.75),
        OpacityPoint::new(250.0, 1.0),
    ];
    opacities[2].midpoint = 0.9;
    TransferFunction::new(colors, opacities, Some(0.7)).unwrap()
}

fn write_and_read(name: &str, function: &TransferFunction) -> (TransferFunction, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write_transfer_function(&path, function).unwrap();
    read_transfer_function(&path, RANGE).unwrap()
}

#[test]
fn slicer_round_trips_exactly() {
    let (read, warnings) = write_and_read("a.vp.json", &awkward());
    assert!(read == awkward(), "{read:?}");
    assert_eq!(warnings, Vec::<String>::new());
    let map = ColorMap::from_name("Spectral").unwrap();
    let curve = OpacityCurve::from_name("sigmoid_7").unwrap();
    let function = TransferFunction::from_map_and_opacity(RANGE, map, curve, Some(3.25)).unwrap();
    assert!(write_and_read("a.vp.json", &function).0 == function);
}

#[test]
fn slicer_needs_a_unit_distance() {
    let mut function = awkward();
    function.unit_distance = None;
    let path = std::env::temp_dir().join("never-written.vp.json");
    let error = write_transfer_function(&path, &function).unwrap_err().to_string();
    assert!(error.contains("has no unit distance"), "{error}");
    assert!(!path.exists());
}

/// A file as Slicer writes it (with `type` and members that do not matter here).
const SLICER: &str = r#"{
    "@schema": "https://raw.githubusercontent.com/slicer/slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#",
    "volumeProperties": [{
        "effectiveRange": [-100.0, 300.0],
        "isoSurfaceValues": [0.0],
        "independentComponents": true,
        "interpolationType": "linear",
        "components": [{
            "componentWeight": 1.0,
            "shade": true,
            "lighting": {"diffuse": 0.9, "ambient": 0.1, "specular": 0.2, "specularPower": 10.0},
            "disableGradientOpacity": false,
            "rgbTransferFunction": {"type": "colorTransferFunction", "points": [
                {"x": 300, "color": [1.0, 1.0, 1.0], "midpoint": 0.5, "sharpness": 0.0},
                {"x": -100, "color": [0.25, 0.0, 0.0], "midpoint": 0.5, "sharpness": 0.0}]},
            "scalarOpacity": {"type": "piecewiseLinearFunction", "points": [
                {"x": 0.0, "y": 0.0, "midpoint": 0.5, "sharpness": 0.0},
                {"x": 100.0, "y": 0.5, "midpoint": 0.5, "sharpness": 0.0}]},
            "gradientOpacity": {"type": "piecewiseLinearFunction", "points": [
                {"x": 0.0, "y": 0.0, "midpoint": 0.5, "sharpness": 0.0},
                {"x": 9.0, "y": 1.0, "midpoint": 0.5, "sharpness": 0.0}]}
        }]
    }]
}"#;

#[test]
fn slicer_files_are_read_and_oddities_listed() {
    let (function, warnings) = read("a.vp.json", SLICER).unwrap();
    assert_eq!(function.unit_distance, Some(1.0), "the schema's default");
    assert_eq!(function.color(-100.0), [0.25, 0.0, 0.0]);
    assert_eq!([function.opacity(50.0), function.opacity(1e4)], [0.25, 0.5]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("gradientOpacity is no part of the transfer function"));
    assert!(warnings[1].starts_with("color point 1 (-100) lies before its predecessor (300)"));
    let outside = SLICER
        .replace("\"x\": 0.0, \"y\"", "\"x\": 900.0, \"y\"")
        .replace("100.0, \"y\"", "950.0, \"y\"");
    let (_, warnings) = read("a.vp.json", outside).unwrap();
    assert!(
        warnings
            .iter()
            .any(|w| w.starts_with("all opacity points (900 to 950) lie outside")),
        "{warnings:?}"
    );
}

#[test]
fn slicers_gradient_opacity_is_read_where_it_is_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vp.json");
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        splatvol_io::read_gradient_opacity(&path).unwrap()
    };
    let points = read(SLICER).unwrap();
    let points: Vec<_> = points.iter().map(|p| (p.gradient, p.factor)).collect();
    assert_eq!(points, [(0.0, 0.0), (9.0, 1.0)]);
    let off = SLICER.replace(
        "\"disableGradientOpacity\": false",
        "\"disableGradientOpacity\": true",
    );
    assert_eq!(read(&off), None);
    assert_eq!(read("[]"), None);
}

#[test]
fn malformed_slicer_fields_are_named() {
    let cases = [
        (
            "\"y\": 0.5",
            "\"y\": 1.5",
            "\"volumeProperties[0].components[0].scalarOpacity.points[1].y\" = \"1.5\": expected a number from 0 to 1",
        ),
        (
            "\"y\": 0.5",
            "\"y\": null",
            "points[1].y\" = \"(absent)\": expected a value",
        ),
        (
            "\"y\": 0.5",
            "\"y\": \"half\"",
            "points[1].y\" = \"\\\"half\\\"\": expected a number",
        ),
        ("\"y\": 0.5", "\"y\": NaN", "expected valid JSON"),
        ("\"y\": 0.5", "\"y\": 1e999", "expected valid JSON"),
        (
            "[0.25, 0.0, 0.0]",
            "[0.25, 0.0]",
            "rgbTransferFunction.points[1].color\" = \"[0.25,0.0]\": expected three numbers",
        ),
        (
            "\"scalarOpacity\"",
            "\"opacity\"",
            "components[0].scalarOpacity\" = \"(absent)\"",
        ),
        (
            "\"componentWeight\"",
            "\"scalarOpacityUnitDistance\": 0, \"w\"",
            "unit distance: 0.0 is not allowed",
        ),
        (
            "\"volumeProperties\"",
            "\"markups\"",
            "\"volumeProperties\" = \"(absent)\"",
        ),
    ];
    for (from, to, expected) in cases {
        let bad = SLICER.replacen(from, to, 1);
        assert_ne!(bad, SLICER);
        let error = refusal("a.vp.json", bad);
        assert!(error.contains(expected), "{error}\n{expected}");
    }
    for length in (0..SLICER.len()).step_by(13) {
        assert!(read("a.vp.json", &SLICER[..length]).is_err());
    }
    assert!(refusal("a.json", "[".repeat(100_000)).contains("recursion limit"));
}

#[test]
fn paraview_round_trips_as_the_same_curves() {
    let function = awkward();
    let (read, warnings) = write_and_read("a.json", &function);
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(read.opacities(), function.opacities());
    assert_eq!(read.unit_distance, None, "not part of the format");
    for i in 0..=500 {
        let value = -100.0 + 0.25 * f64::from(i);
        for (a, b) in read.color(value).into_iter().zip(function.color(value)) {
            assert!((a - b).abs() < 0.004, "{value}: {a} {b}");
        }
    }
}

#[test]
fn paraview_presets_are_read() {
    // A library preset: 0..1, no opacities, Moreland's interpolation.
    let preset = r#"[{"ColorSpace": "Diverging", "Name": "Cool to Warm", "NanColor": [1, 1, 0],
        "RGBPoints": [0, 0.23137254902, 0.298039215686, 0.752941176471, 1, 0.705882352941, 0.0156862745098, 0.149019607843]}]"#;
    let (function, warnings) = read("a.json", preset).unwrap();
    assert_eq!(
        [
            function.opacity(-100.0),
            function.opacity(100.0),
            function.opacity(300.0)
        ],
        [0.0, 0.5, 1.0]
    );
    let middle = function.color(100.0);
    assert!(middle.iter().all(|c| (c - 0.866).abs() < 0.01), "{middle:?}");
    assert!(
        warnings[0].contains("no opacities")
            && warnings[1].contains("stretched over the data's range -100 to 300")
    );
    // An exported one: data values, opacities, a second preset, an unknown space.
    let exported = r#"[{"Name": "IndexedOnly", "IndexedColors": [0, 0, 0]},
        {"Name": "A", "ColorSpace": "Step", "RGBPoints": [-50, 0, 0, 0, 200, 1, 1, 1], "Points": [-50, 0, 0.5, 0, 200, 0.5, 0.5, 0]},
        {"Name": "B", "RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1]}]"#;
    let (function, warnings) = read("a.json", exported).unwrap();
    assert_eq!([function.opacity(75.0), function.color(75.0)[0]], [0.25, 0.5]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].ends_with("first of 2 presets was read: A") && warnings[1].starts_with("ColorSpace Step")
    );
}

#[test]
fn malformed_paraview_fields_are_named() {
    let cases = [
        (
            r#"[{"RGBPoints": [0, 0, 0]}]"#,
            "\"[0].RGBPoints\" = \"[0,0,0]\": expected x, r, g, b for every point",
        ),
        (
            r#"[{"RGBPoints": [0, 0, 2, 0]}]"#,
            "\"[0].RGBPoints[2]\" = \"2\": expected a number from 0 to 1",
        ),
        (
            r#"[{"RGBPoints": [0, 0, 1, 0], "Points": [0, "a", 0.5, 0]}]"#,
            "\"[0].Points[1]\"",
        ),
        (r#"[{"Name": "x"}]"#, "no preset has RGBPoints"),
        ("[]", "no preset has RGBPoints"),
        ("[1, 2]", "no preset has RGBPoints"),
        ("[{", "expected valid JSON"),
    ];
    for (text, expected) in cases {
        let error = refusal("a.json", text);
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

const INVIWO: &str = r#"<?xml version="1.0" ?>
<InviwoWorkspace version="2">
    <maskMin content="0.25" />
    <maskMax content="1" />
    <type content="0" />
    <Points>
        <Point><pos content="0.5" /><rgba x="1" y="0.5" z="0" w="0.4" /></Point>
        <Point><pos content="0" /><rgba x="0" y="0" z="0" w="0" /></Point>
    </Points>
</InviwoWorkspace>"#;

#[test]
fn inviwo_positions_and_mask_span_the_data() {
    let (function, warnings) = read("a.itf", INVIWO).unwrap();
    for (value, opacity) in [(-1.0, 0.0), (0.0, 0.2), (50.0, 0.3), (300.0, 0.4)] {
        assert!((function.opacity(value) - opacity).abs() < 1e-12, "{value}");
    }
    assert_eq!(function.color(0.0), [0.5, 0.25, 0.0]);
    assert_eq!(warnings.len(), 1, "points were out of order: {warnings:?}");
    let absolute = INVIWO
        .replace("type content=\"0\"", "type content=\"1\"")
        .replace("content=\"0.5\"", "content=\"70\"");
    let absolute = absolute.replace("maskMax content=\"1\"", "maskMax content=\"1e308\"");
    let (function, _) = read("a.itf", absolute).unwrap();
    assert!((function.opacity(35.0) - 0.2).abs() < 1e-12);
    let old = "<InviwoTreeData><dataPoints><point><pos x=\"1\" y=\"0.3\"/><rgba x=\"0\" y=\"1\" z=\"0\" w=\"0.3\"/></point></dataPoints></InviwoTreeData>";
    assert_eq!(read("a.itf", old).unwrap().0.opacity(300.0), 0.3);
}

#[test]
fn malformed_inviwo_files_are_refused() {
    let cases = [
        (
            "w=\"0.4\"",
            "w=\"4\"",
            "\"Point 0: rgba w\" = \"4\": expected a number from 0 to 1",
        ),
        ("w=\"0.4\"", "", "\"Point 0: rgba\" = \"(absent)\""),
        (
            "content=\"0.5\"",
            "content=\"nan\"",
            "\"Point 0: pos\" = \"nan\": expected a finite number",
        ),
        (
            "content=\"0.5\"",
            "content=\"1.5\"",
            "\"Point 0: pos\" = \"1.5\": expected a position from 0 to 1",
        ),
        (
            "maskMin content=\"0.25\"",
            "maskMin content=\"x\"",
            "\"maskMin\" = \"x\": expected a number",
        ),
        ("</Points>", "", "expected well-formed XML"),
    ];
    for (from, to, expected) in cases {
        let error = refusal("a.itf", INVIWO.replacen(from, to, 1));
        assert!(error.contains(expected), "{error}\n{expected}");
    }
    assert!(refusal("a.itf", "<a/>").contains("no points"));
    let bomb = "<!DOCTYPE a [<!ENTITY b \"xxxxxxxx\"><!ENTITY c \"&b;&b;&b;&b;\">]><a>&c;</a>";
    assert!(read("a.itf", bomb).is_err());
}

#[test]
fn imagej_tables_of_all_four_forms_agree() {
    let table: Vec<[u8; 3]> = (0..=255u8).map(|i| [i, 255 - i, i / 2]).collect();
    let planes: Vec<u8> = (0..3).flat_map(|c| table.iter().map(move |rgb| rgb[c])).collect();
    let mut header = b"ICOL\x01\x00\x01\x00".to_vec();
    header.resize(32, 0);
    let text: String = table.iter().map(|[r, g, b]| format!("{r} {g} {b}\n")).collect();
    let indexed: String = table
        .iter()
        .enumerate()
        .map(|(i, [r, g, b])| format!("{i},{r},{g},{b}\n"))
        .collect();
    let forms = [
        planes.clone(),
        [header.clone(), planes.clone()].concat(),
        text.into_bytes(),
        format!("Index,Red,Green,Blue\n{indexed}").into_bytes(),
    ];
    let (first, warnings) = read("a.lut", &forms[0]).unwrap();
    assert_eq!(first.color(300.0), [1.0, 0.0, 127.0 / 255.0]);
    assert_eq!([first.opacity(-100.0), first.opacity(100.0)], [0.0, 0.5]);
    assert!(warnings[0].starts_with("lookup tables have no opacities"));
    for form in &forms[1..] {
        assert_eq!(read("a.LUT", form).unwrap().0, first);
    }
    assert!(refusal("a.lut", &forms[1][..500]).contains("colors need 768 bytes, found 468"));
    assert!(refusal("a.lut", b"ICOL").contains("header need 32 bytes, found 4"));
    assert!(refusal("a.lut", "1 2 3\n4 5 999\n").contains("\"line 2\" = \"4 5 999\""));
    assert!(refusal("a.lut", "").contains("2 to 256 colors"));
    header[6..8].copy_from_slice(&[0, 1]);
    assert!(refusal("a.lut", header).contains("\"number of colors\" = \"1\" (byte 6)"));
}

#[test]
fn other_files_are_refused() {
    assert!(refusal("a.txt", "hello").contains("neither Slicer's or ParaView's JSON"));
    assert!(read_transfer_function(Path::new("/nonexistent.json"), RANGE).is_err());
    let error = write_transfer_function("a.itf", &awkward())
        .unwrap_err()
        .to_string();
    assert!(error.contains("names end in .vp.json or .json"), "{error}");
}
