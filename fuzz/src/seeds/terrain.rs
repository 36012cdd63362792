//! Terrain, and frames of depth cameras.

use super::ending;
use crate::common::small_points;
use crate::input::Input;

pub(crate) fn heights() -> Vec<Input> {
    let mut seeds = ending(small_points::files(), &[".heights"]);
    seeds.push(Input::file("a.csv", "1,2,3\n4,5,6\n7,8,9.5\n"));
    seeds
}

/// A georeferenced TIFF, and one that is not.
pub(crate) fn geotiff() -> Vec<Input> {
    let mut seeds = ending(small_points::files(), &[".tif"]);
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder
        .new_image::<tiff::encoder::colortype::Gray32Float>(4, 3)
        .unwrap();
    let heights: Vec<f32> = (0..12u8).map(|i| f32::from(i * i % 17)).collect();
    let directory = image.encoder();
    let tag = tiff::tags::Tag::Unknown;
    directory
        .write_tag(tag(33550), &[10.0f64, 10.0, 0.0][..])
        .unwrap();
    directory
        .write_tag(tag(33922), &[0.0f64, 0.0, 0.0, 500.0, 900.0, 0.0][..])
        .unwrap();
    let keys = [1u16, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32632];
    directory.write_tag(tag(34735), &keys[..]).unwrap();
    directory.write_tag(tag(42113), "-9999").unwrap();
    image.write_data(&heights).unwrap();
    seeds.push(Input::file("geo.tif", bytes.into_inner()));
    seeds
}

/// Three profiles of three posts.
pub(crate) fn dem() -> Vec<Input> {
    let mut bytes = vec![b' '; 4 * 1024];
    let mut put = |block: usize, at: usize, width: usize, text: &str| {
        let field = format!("{text:>width$}");
        bytes[1024 * block + at..][..width].copy_from_slice(field.as_bytes());
    };
    for (at, width, text) in [
        (156, 6, "1"),
        (534, 6, "2"),
        (816, 12, "30.0"),
        (828, 12, "30.0"),
        (840, 12, "0.1D+01"),
        (852, 6, "1"),
        (858, 6, "3"),
    ] {
        put(0, at, width, text);
    }
    for column in 0..3usize {
        let block = 1 + column;
        let x = format!("{}", 500 + 30 * column);
        for (at, width, text) in [
            (0, 6, "1"),
            (6, 6, "1"),
            (12, 6, "3"),
            (18, 6, "1"),
            (24, 24, &x),
            (48, 24, "900.0"),
        ] {
            put(block, at, width, text);
        }
        put(block, 72, 24, "0.0");
        for post in 0..3 {
            put(block, 144 + 6 * post, 6, &format!("{}", 100 + 7 * column + post));
        }
    }
    vec![Input::file("a.dem", bytes)]
}

/// One frame in `.npy`, one in PNG with a colour picture.
pub(crate) fn depth_images() -> Vec<Input> {
    let depth = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }";
    let header = format!("{depth:<117}\n");
    let floats: Vec<u8> = (1..13u8).flat_map(|i| f32::from(i).to_le_bytes()).collect();
    let numpy = [b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes(), &floats].concat();
    let list = "{\"depth_unit\": 0.5, \"intrinsics\": {\"fx\": 2, \"fy\": 2, \"cx\": 1, \"cy\": 1},\n\
        \"frame\": [{\"depth\": \"depth.npy\", \"world_from_camera\": [[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]]}]}";
    let toml = "depth_unit = 0.001\nintrinsics = { fx = 2, fy = 2, cx = 1.5, cy = 1 }\n\n[[frame]]\n\
        depth = \"d.png\"\ncolor = \"c.png\"\n";
    let words: Vec<u8> = (0..12u16).flat_map(|i| (1000 + 100 * i).to_be_bytes()).collect();
    let file = |name: &str, bytes: &[u8]| (name.to_owned(), bytes.to_vec());
    let depth = picture(png::ColorType::Grayscale, png::BitDepth::Sixteen, &words);
    let color = picture(png::ColorType::Rgb, png::BitDepth::Eight, &[7; 36]);
    vec![
        Input::files(
            "frames.json",
            vec![file("depth.npy", &numpy), file("frames.json", list.as_bytes())],
        ),
        Input::files(
            "f.toml",
            vec![
                file("f.toml", toml.as_bytes()),
                file("d.png", &depth),
                file("c.png", &color),
            ],
        ),
    ]
}

/// A PNG of 4 x 3 pixels.
fn picture(color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 3);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}
