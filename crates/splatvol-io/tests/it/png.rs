//! PNG: round trips are exact, and malformed files are refused.

use std::io::Cursor;
use std::path::Path;

use splatvol_io::image::metadata::{self, SETTINGS, SOFTWARE};
use splatvol_io::{ImageFormat, IoError, decode_image, encode_image, read_image, write_image};
use splatvol_scene::{Image, ImageSize};

fn image(width: u32, pixels: Vec<[f32; 4]>) -> Image {
    let height = pixels.len() as u32 / width;
    Image::from_pixels(ImageSize::new(width, height).unwrap(), pixels).unwrap()
}

fn decode(bytes: &[u8]) -> Result<splatvol_io::LoadedImage, IoError> {
    decode_image(bytes, Path::new("test.png"))
}

/// The codes in a PNG file, as an independent decoder has them.
fn codes(bytes: &[u8]) -> (png::ColorType, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    (info.color_type, data)
}

#[test]
fn codes_are_straight_srgb_rounded_to_nearest() {
    // Mid grey: linear 0.2140 is sRGB 0.5; premultiplied by 1/2 it must still show as 0.5.
    let linear = ((0.5f64 + 0.055) / 1.055).powf(2.4) as f32;
    let picture = image(
        4,
        vec![
            [linear, 1.0, 0.0, 1.0],
            [0.5 * linear, 0.5, 0.0, 0.5],
            [0.0, 0.0, 0.0, 0.0],
            [f32::NAN, 7.0, -1.0, 1.0],
        ],
    );
    let bytes = encode_image(&picture, None, ImageFormat::Png8, &[]).unwrap();
    let expected = [128, 255, 0, 255, 128, 255, 0, 128, 0, 0, 0, 0, 0, 255, 0, 255];
    assert_eq!(codes(&bytes), (png::ColorType::Rgba, expected.to_vec()));
    assert!(bytes.windows(4).any(|window| window == b"sRGB"));
}

#[test]
fn every_16_bit_code_survives_with_every_kind_of_alpha() {
    for alpha in [65_535u16, 40_000, 257] {
        let data: Vec<u8> = (0..=u16::MAX)
            .flat_map(|code| {
                [code, u16::MAX - code, code / 2, alpha]
                    .into_iter()
                    .flat_map(u16::to_be_bytes)
            })
            .collect();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 256, 256);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        let again = encode_image(&decode(&bytes).unwrap().image, None, ImageFormat::Png16, &[]).unwrap();
        let (color_type, codes) = codes(&again);
        let same = if color_type == png::ColorType::Rgb {
            let opaque: Vec<u8> = data.chunks(8).flat_map(|pixel| pixel[..6].to_vec()).collect();
            codes == opaque
        } else {
            codes == data
        };
        assert!(same, "alpha {alpha}");
    }
}

#[test]
fn eight_bits_round_trip_with_alpha() {
    let data: Vec<u8> = (0..64 * 64u32)
        .flat_map(|i| {
            let alpha = 1 + (i % 255) as u8;
            [(i * 7) as u8, (i * 31 / 5) as u8, (i / 16) as u8, alpha]
        })
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 64, 64);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    let again = encode_image(&decode(&bytes).unwrap().image, None, ImageFormat::Png8, &[]).unwrap();
    assert_eq!(codes(&again), (png::ColorType::Rgba, data));
}

#[test]
fn other_color_types_and_gamma_are_understood() {
    let make = |color, depth, gamma: Option<f32>, data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(png::ScaledFloat::new(gamma));
        }
        if color == ColorType::Indexed {
            encoder.set_palette(vec![255, 0, 0, 0, 0, 255]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        decode(&bytes).unwrap().image.pixels
    };
    use png::{BitDepth, ColorType};
    let gray = make(ColorType::Grayscale, BitDepth::One, None, &[0b0100_0000]);
    assert_eq!(gray, [[0.0, 0.0, 0.0, 1.0], [1.0; 4]]);
    let palette = make(ColorType::Indexed, BitDepth::Eight, None, &[0, 1]);
    assert_eq!(palette, [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
    let linear = make(ColorType::Grayscale, BitDepth::Eight, Some(1.0), &[51, 255]);
    assert!((linear[0][0] - 0.2).abs() < 1e-6);
    let with_alpha = make(ColorType::GrayscaleAlpha, BitDepth::Eight, None, &[255, 51, 0, 0]);
    assert!((with_alpha[0][0] - 0.2).abs() < 1e-6 && with_alpha[1] == [0.0; 4]);
}

#[test]
fn metadata_come_back_in_order_and_bad_ones_are_refused() {
    let pair = |key: &str, text: &str| (key.to_owned(), text.to_owned());
    let settings = format!("{{\"points\": [{}]}}", "0.125, ".repeat(20_000));
    let pairs = vec![
        pair(SOFTWARE, "splatvol 0.1.0"),
        pair("Comment", "two lines\nand a tab\t"),
        pair(SETTINGS, &settings),
        pair("Author", "Zo\u{eb} \u{4f53}\u{7a4d}"),
    ];
    let picture = image(1, vec![[0.5; 4]]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_image(&path, &picture, None, ImageFormat::Png8, &pairs).unwrap();
    let loaded = read_image(&path).unwrap();
    assert_eq!(loaded.metadata, pairs);
    assert_eq!(
        metadata::find(&loaded.metadata, SETTINGS),
        Some(settings.as_str())
    );
    assert!(
        std::fs::metadata(&path).unwrap().len() < 5_000,
        "long texts are compressed"
    );
    for key in ["", " a", "a  b", "\u{4f53}", &"k".repeat(80)] {
        let error = encode_image(&picture, None, ImageFormat::Png8, &[pair(key, "x")]).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("cannot encode PNG: metadata keyword"),
            "{error}"
        );
    }
    assert!(encode_image(&picture, None, ImageFormat::Png8, &[pair("a", "nul\0")]).is_err());
}

#[test]
fn malformed_files_are_refused() {
    let picture = image(16, vec![[0.25, 0.5, 0.75, 1.0]; 256]);
    let good = encode_image(&picture, None, ImageFormat::Png16, &[("a".into(), "b".into())]).unwrap();
    for length in 0..good.len() - 12 {
        assert!(decode(&good[..length]).is_err(), "{length}");
    }
    for index in 0..good.len() {
        let mut bad = good.clone();
        bad[index] ^= 0x41;
        // The point is that it returns: a flipped bit may be repaired by nobody, or not matter.
        let _ = decode(&bad);
    }
    let error = decode(b"GIF89a").unwrap_err().to_string();
    assert_eq!(error, "picture: neither PNG nor OpenEXR, in test.png");
    assert!(read_image("/nonexistent/x.png").is_err());
}

#[test]
fn sizes_that_the_bytes_do_not_justify_are_refused_before_allocation() {
    let mut header = Vec::new();
    let mut encoder = png::Encoder::new(&mut header, 16_000, 16_000);
    encoder.set_color(png::ColorType::Rgba);
    // A header alone: dropping the writer adds the end chunk.
    drop(encoder.write_header().unwrap());
    let error = decode(&header).unwrap_err().to_string();
    assert!(
        error.contains("pixels need 256000000 bytes, found at most"),
        "{error}"
    );
}
