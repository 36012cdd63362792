//! EXR: floats, depth and metadata come back bit for bit, and nothing malformed passes.

use std::path::Path;

use splatvol_io::image::metadata::SOFTWARE;
use splatvol_io::{ImageFormat, IoError, LoadedImage, decode_image, encode_image, read_image, write_image};
use splatvol_scene::{Image, ImageSize};

fn picture() -> (Image, Vec<f32>) {
    let size = ImageSize::new(37, 21).unwrap();
    let pixels: Vec<[f32; 4]> = (0..size.pixel_count())
        .map(|i| {
            let t = i as f32 / 777.0;
            [t * 1e-6, 3.0 * t, -t, (t * 50.0).fract()]
        })
        .collect();
    let depth = (0..size.pixel_count())
        .map(|i| if i % 3 == 0 { f32::INFINITY } else { i as f32 * 0.1 })
        .collect();
    (Image::from_pixels(size, pixels).unwrap(), depth)
}

fn decode(bytes: &[u8]) -> Result<LoadedImage, IoError> {
    decode_image(bytes, Path::new("test.exr"))
}

#[test]
fn pixels_depth_and_metadata_come_back_exactly() {
    let (image, depth) = picture();
    let metadata: Vec<(String, String)> = [
        (SOFTWARE, "splatvol 0.1.0"),
        ("splatvol.settings", "{\"a\": \"\u{4f53}\"}"),
        ("Comment", "x\ny"),
        ("Another", ""),
    ]
    .map(|(key, text)| (key.to_owned(), text.to_owned()))
    .to_vec();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_image(&path, &image, Some(&depth), ImageFormat::Exr, &metadata).unwrap();
    let loaded = read_image(&path).unwrap();
    assert_eq!(loaded.image, image);
    assert_eq!(loaded.depth, Some(depth.clone()));
    assert_eq!(loaded.metadata, metadata);
    let bytes = std::fs::read(&path).unwrap();
    for _ in 0..4 {
        let again = encode_image(&image, Some(&depth), ImageFormat::Exr, &metadata).unwrap();
        assert!(again == bytes, "the same picture gives the same file");
    }
}

#[test]
fn channels_are_what_other_programs_expect() {
    let (image, depth) = picture();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_image(&path, &image, Some(&depth), ImageFormat::Exr, &[]).unwrap();
    let file = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
    let names: Vec<String> = file
        .layer_data
        .channel_data
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    assert_eq!(names, ["A", "B", "G", "R", "Z"]);
    let green: Vec<f32> = file.layer_data.channel_data.list[2]
        .sample_data
        .values_as_f32()
        .collect();
    assert_eq!(green[5], image.pixels[5][1]);
    assert!(file.attributes.chromaticities.is_some());
}

#[test]
fn a_picture_without_depth_has_none() {
    let (image, depth) = picture();
    let bytes = encode_image(&image, None, ImageFormat::Exr, &[]).unwrap();
    let loaded = decode(&bytes).unwrap();
    assert_eq!(
        (loaded.image, loaded.depth, loaded.metadata),
        (image.clone(), None, vec![])
    );
    let error = encode_image(&image, Some(&depth[1..]), ImageFormat::Exr, &[]).unwrap_err();
    assert_eq!(error.to_string(), "cannot encode EXR: 776 depths for 777 pixels");
}

#[test]
fn malformed_files_give_errors() {
    let (image, depth) = picture();
    let good = encode_image(
        &image,
        Some(&depth),
        ImageFormat::Exr,
        &[("a".into(), "b".into())],
    )
    .unwrap();
    for length in (0..good.len()).step_by(7) {
        assert!(decode(&good[..length]).is_err(), "{length}");
    }
    for index in 0..good.len().min(1200) {
        for flip in [0x01, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[index] ^= flip;
            // A flipped bit may go unnoticed; it must not panic, hang or allocate without bound.
            let _ = decode(&bad);
        }
    }
}

#[test]
fn pictures_without_color_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("y.exr");
    let layer = exr::prelude::Layer::new(
        (2, 2),
        exr::prelude::LayerAttributes::default(),
        exr::prelude::Encoding::FAST_LOSSLESS,
        exr::prelude::AnyChannels::sort(
            [exr::prelude::AnyChannel::new(
                "Y",
                exr::prelude::FlatSamples::F32(vec![0.0; 4]),
            )]
            .into_iter()
            .collect(),
        ),
    );
    use exr::prelude::WritableImage;
    exr::prelude::Image::from_layer(layer)
        .write()
        .to_file(&path)
        .unwrap();
    let error = read_image(&path).unwrap_err().to_string();
    assert!(
        error.starts_with("EXR: the first layer has no full channels R, G and B"),
        "{error}"
    );
}
