//! TIFF files that the encoder of the same crate writes, and folders of slices.

use std::io::Cursor;
use std::path::Path;

use crate::common::slices::assert_opens;
use crate::common::{flips, load, truncations};
use glam::DVec3;
use splatvol_io::{IoError, Loaded, ReadOptions, open_volume, read_volume};
use splatvol_scene::{ChunkBuffer, LengthUnit, Samples};
use tiff::encoder::colortype::{Gray16, Gray32Float, RGB8};
use tiff::encoder::{Compression, Rational, TiffEncoder};
use tiff::tags::Tag;

/// Pages of 4 x 3 words, page p holding 100 p and up; the first with a description.
fn pages(count: u16, description: Option<&str>, compression: Compression) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = TiffEncoder::new(Cursor::new(&mut bytes))
        .unwrap()
        .with_compression(compression);
    for page in 0..count {
        let mut image = encoder.new_image::<Gray16>(4, 3).unwrap();
        if let Some(text) = description.filter(|_| page == 0) {
            image.encoder().write_tag(Tag::ImageDescription, text).unwrap();
            image.x_resolution(Rational { n: 4, d: 1 });
            image.y_resolution(Rational { n: 2, d: 1 });
        }
        let data: Vec<u16> = (0..12).map(|i| 100 * page + i).collect();
        image.write_data(&data).unwrap();
    }
    bytes
}

fn read_bytes(bytes: &[u8], change: impl Fn(&mut ReadOptions)) -> Result<Loaded, IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, bytes).unwrap();
    let mut options = ReadOptions::default();
    change(&mut options);
    let loaded = read_volume(&path, &options)?;
    assert_opens(&path, &options, &loaded);
    Ok(loaded)
}

/// The pages that make up a volume of `pages`, by their first samples.
fn found(loaded: &Loaded) -> Vec<u16> {
    let Samples::U16(samples) = loaded.volume.samples() else {
        panic!("words")
    };
    samples.chunks_exact(12).map(|page| page[0] / 100).collect()
}

#[test]
fn pages_are_slices_in_every_compression() {
    let mut codings = vec![
        pages(3, None, Compression::Uncompressed),
        pages(3, None, Compression::Lzw),
    ];
    codings.push(pages(3, None, Compression::Packbits));
    codings.push(pages(3, None, Compression::Deflate(Default::default())));
    for bytes in codings {
        let loaded = read_bytes(&bytes, |_| ()).unwrap();
        assert_eq!(loaded.volume.grid().dims(), [4, 3, 3]);
        assert_eq!(found(&loaded), [0, 1, 2]);
        assert_eq!(loaded.volume.grid().spacing(), DVec3::ONE);
    }
}

#[test]
fn hyperstacks_of_imagej_have_channels_slices_and_frames() {
    let text = "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\nunit=\\u00B5m\nspacing=2.5\n";
    let bytes = pages(12, Some(text), Compression::Uncompressed);
    let first = read_bytes(&bytes, |_| ()).unwrap();
    assert_eq!(found(&first), [0, 2, 4]);
    assert_eq!(first.volume.grid().spacing(), DVec3::new(0.25, 0.5, 2.5));
    assert_eq!(first.volume.unit(), LengthUnit::Micrometre);
    assert_eq!(
        (first.description.times, first.description.channels.len()),
        (2, 2)
    );
    let other = read_bytes(&bytes, |options| {
        (options.channel, options.time) = (Some(1), Some(1));
    })
    .unwrap();
    assert_eq!(found(&other), [7, 9, 11]);
    let error = read_bytes(&bytes, |options| options.channel = Some(2))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("channel 2 was asked for; to choose from: 0: channel 0, 1: channel 1"),
        "{error}"
    );
    let wrong = pages(11, Some(text), Compression::Uncompressed);
    assert!(
        read_bytes(&wrong, |_| ())
            .unwrap_err()
            .to_string()
            .contains("2 x 3 x 2")
    );
}

#[test]
fn one_page_may_be_followed_by_plain_samples() {
    let mut bytes = pages(
        1,
        Some("ImageJ=1.53t\nimages=3\nslices=3\n"),
        Compression::Uncompressed,
    );
    // The encoder writes the samples before the directory; move them behind it, as ImageJ has them.
    let offset = bytes.len() as u32;
    let tag = bytes
        .windows(4)
        .position(|entry| entry == [0x11, 0x01, 4, 0])
        .unwrap();
    bytes[tag + 8..tag + 12].copy_from_slice(&offset.to_le_bytes());
    for page in 0..3u16 {
        bytes.extend((0..12).flat_map(|i| (100 * page + i).to_le_bytes()));
    }
    assert_eq!(found(&read_bytes(&bytes, |_| ()).unwrap()), [0, 1, 2]);
    bytes.pop();
    assert!(read_bytes(&bytes, |_| ()).is_err());
}

#[test]
fn ome_says_which_page_is_which_plane() {
    let pixels = |order: &str, data: &str| {
        format!(
            "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\" \
             Name=\"cell\"><Pixels DimensionOrder=\"{order}\" SizeX=\"4\" SizeY=\"3\" SizeZ=\"2\" SizeC=\"2\" SizeT=\"1\" \
             Type=\"uint16\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.5\" PhysicalSizeZ=\"3\"><Channel Name=\"DAPI\"/>\
             <Channel Name=\"GFP\"/>{data}</Pixels></Image></OME>"
        )
    };
    let read = |order, data, channel| {
        let bytes = pages(4, Some(&pixels(order, data)), Compression::Uncompressed);
        read_bytes(&bytes, |options| options.channel = Some(channel))
    };
    let loaded = read("XYZCT", "<TiffData/>", 1).unwrap();
    assert_eq!(found(&loaded), [2, 3]);
    assert_eq!(loaded.description.channels, ["DAPI", "GFP"]);
    assert_eq!(loaded.volume.grid().spacing(), DVec3::new(0.5, 0.5, 3.0));
    assert_eq!(loaded.volume.unit(), LengthUnit::Micrometre);
    assert_eq!(found(&read("XYCZT", "", 1).unwrap()), [1, 3]);
    let planes = "<TiffData IFD=\"3\" FirstC=\"1\" FirstZ=\"0\"/><TiffData IFD=\"0\" FirstC=\"1\" FirstZ=\"1\"/>\
                  <TiffData IFD=\"1\"/><TiffData IFD=\"2\" FirstZ=\"1\"/>";
    assert_eq!(found(&read("XYZCT", planes, 1).unwrap()), [3, 0]);
    assert!(read("XYZCT", "<TiffData IFD=\"7\"/>", 0).is_err());
    assert!(read("XYZZT", "", 0).is_err());
}

#[test]
fn floats_big_files_and_colours() {
    let mut bytes = Vec::new();
    let mut encoder = TiffEncoder::new_big(Cursor::new(&mut bytes)).unwrap();
    encoder.write_image::<Gray32Float>(2, 1, &[-1.5, 2.5]).unwrap();
    let loaded = read_bytes(&bytes, |_| ()).unwrap();
    assert_eq!(loaded.volume.samples(), &Samples::F32(vec![-1.5, 2.5].into()));
    let mut bytes = Vec::new();
    let mut encoder = TiffEncoder::new(Cursor::new(&mut bytes)).unwrap();
    encoder.write_image::<RGB8>(2, 1, &[1, 2, 3, 4, 5, 6]).unwrap();
    let green = read_bytes(&bytes, |options| options.channel = Some(1)).unwrap();
    assert_eq!(green.volume.samples(), &Samples::U8(vec![2, 5].into()));
    assert_eq!(green.description.channels, ["red", "green", "blue"]);
}

fn png(path: &Path, size: [u32; 2], value: u16) {
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let data: Vec<u8> = (0..size[0] * size[1]).flat_map(|_| value.to_be_bytes()).collect();
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
}

#[test]
fn a_folder_of_slices_is_in_the_order_of_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    for number in [8u16, 9, 10, 11] {
        png(&folder.path().join(format!("s{number}.png")), [3, 2], number);
    }
    let loaded = load(folder.path());
    let Samples::U16(samples) = loaded.volume.samples() else {
        panic!("words")
    };
    let first: Vec<u16> = samples.chunks_exact(6).map(|slice| slice[0]).collect();
    assert_eq!(first, [8, 9, 10, 11]);
    assert!(loaded.description.warnings.is_empty());
    png(&folder.path().join("s13.png"), [3, 2], 13);
    let loaded = load(folder.path());
    assert!(loaded.description.warnings[0].contains("between 11 and 13"));
    assert_opens(folder.path(), &ReadOptions::default(), &loaded);
    png(&folder.path().join("s14.png"), [2, 2], 14);
    let error = read_volume(folder.path(), &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("s14.png") && error.contains("2 x 2"), "{error}");
    // Opened, it fails where that slice is read.
    let opened = open_volume(folder.path(), &ReadOptions::default())
        .unwrap()
        .unwrap();
    let read = |z: usize| opened.source.read(0, [0, 0, z], &mut ChunkBuffer::default());
    assert!(read(4).is_ok());
    let error = read(5).unwrap_err().to_string();
    for part in ["chunk 0,0,5", "slice 5", "s14.png", "2 x 2"] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn cut_files_are_refused() {
    let bytes = pages(2, None, Compression::Lzw);
    truncations("cut.tif", &bytes, 64);
    flips("changed.tif", &bytes, bytes.len());
}

/// A page of 3 x 2 words in one strip.
fn page(compression: u16, photometric: u16, predictor: u16, strip: &[u8]) -> Vec<u8> {
    let tags: [(u16, u16, u32); 10] = [
        (256, 3, 3),
        (257, 3, 2),
        (258, 3, 16),
        (259, 3, compression.into()),
        (262, 3, photometric.into()),
        (273, 4, 8 + 2 + 10 * 12 + 4),
        (277, 3, 1),
        (278, 3, 2),
        (279, 4, strip.len() as u32),
        (317, 3, predictor.into()),
    ];
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((tags.len() as u16).to_le_bytes());
    for (tag, kind, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    bytes.extend(strip);
    bytes
}

/// A frame of Zstandard that holds the bytes as they are (RFC 8878, section 3.1.1).
fn zstd(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len() as u8;
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x20, length, length << 3 | 1, 0, 0];
    frame.extend(bytes);
    frame
}

#[test]
fn zstd_and_palettes_are_read_with_their_predictors() {
    let words = |words: [u16; 6]| {
        words
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let samples = [7, 300, 299, 65_535, 0, 1];
    let differences = words([7, 293, 65_535, 65_535, 1, 1]);
    for (bytes, coding) in [
        (page(50_000, 1, 1, &zstd(&words(samples))), "zstd"),
        (page(50_000, 1, 2, &zstd(&differences)), "zstd"),
        (
            page(1, 3, 1, &words(samples)),
            "uncompressed, places in a palette",
        ),
    ] {
        let loaded = read_bytes(&bytes, |_| ()).unwrap();
        let Samples::U16(found) = loaded.volume.samples() else {
            panic!("words")
        };
        assert_eq!(found[..], samples, "{coding}");
        assert_eq!(
            loaded.description.stored_type,
            format!("u16, little-endian, {coding}")
        );
        // Cut in the strip, at every byte.
        for cut in bytes.len() - 12..bytes.len() {
            assert!(read_bytes(&bytes[..cut], |_| ()).is_err(), "{cut}");
        }
    }
}
