//! Terrain and frames of depth cameras: real files against known figures, generated ones against their equations.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use splatvol_io::{
    DepthImageOptions, Endian, HeightFieldOptions, ImageFormat, LoadedPoints, RawLayout, RowOrder,
    SampleType, read_depth_images, read_height_field, write_image,
};
use splatvol_recorded::recorded;
use splatvol_scene::{Image, ImageSize};

fn shared() -> Option<PathBuf> {
    recorded("terrain")
}

fn load(path: &Path, options: &HeightFieldOptions) -> LoadedPoints {
    let loaded = read_height_field(path, options).unwrap_or_else(|error| panic!("{error}"));
    println!(
        "{}: {} points, {:?}",
        path.display(),
        loaded.points.len(),
        loaded.description
    );
    loaded
}

fn world(loaded: &LoadedPoints) -> Vec<DVec3> {
    let frame = loaded.points.world_from_local();
    let place = |p: &[f32; 3]| frame.transform_point3(DVec3::from_array(p.map(f64::from)));
    loaded.points.positions().iter().map(place).collect()
}

/// Heights of points that lie on posts.
fn posts(loaded: &LoadedPoints, spacing: f64) -> Vec<f64> {
    let local = loaded.points.positions();
    let on = |c: f32| (f64::from(c) / spacing).fract().abs() < 1e-6;
    let pairs = world(loaded).into_iter().zip(local);
    pairs
        .filter(|(_, p)| on(p[0]) && on(p[1]))
        .map(|(w, _)| w.z)
        .collect()
}

#[test]
fn mount_saint_helens_has_its_heights() {
    let Some(folder) = shared() else { return };
    let loaded = load(&folder.join("SainteHelens.dem"), &HeightFieldOptions::default());
    assert!(
        loaded
            .description
            .stored_type
            .contains("327 x 466 posts, heights 682 to 2543")
    );
    assert!(loaded.description.warnings.is_empty());
    let bounds = loaded.points.bounds();
    assert!(
        (bounds.min - DVec3::new(557_820.0, 5_108_010.0, 682.0))
            .abs()
            .max_element()
            < 1e-3,
        "{bounds:?}"
    );
    assert!(
        (bounds.max - DVec3::new(567_600.0, 5_121_960.0, 2543.0))
            .abs()
            .max_element()
            < 1e-3,
        "{bounds:?}"
    );
    let heights = posts(&loaded, 30.0);
    let missing = (327 * 467 - heights.len()) as f64;
    // The table, VTK's, counts gaps as the smallest height, and one row more than the profiles reach.
    let mean = (heights.iter().sum::<f64>() + 682.0 * missing) / (327.0 * 467.0);
    assert!((mean - 1276.47).abs() < 0.006, "{mean}, {missing} missing");
}

#[test]
fn pictures_lie_on_their_terrain() {
    let Some(folder) = shared() else { return };
    let options = HeightFieldOptions {
        color_image: Some(folder.join("dem.jpg")),
        ..HeightFieldOptions::default()
    };
    let loaded = load(&folder.join("dem.csv"), &options);
    let heights = posts(&loaded, 1.0);
    assert_eq!(heights.len(), 256 * 256);
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    assert!((mean - 1.5481).abs() < 6e-5, "{mean}");
    let bounds = loaded.points.bounds();
    assert!(
        bounds.min.z.abs() < 1e-6 && (bounds.max.z - 4.78685).abs() < 6e-6,
        "{bounds:?}"
    );

    // The sun of the photograph shades slopes: with rows and picture the right way round brightness depends on the
    // slope, upside down it does not.
    let correlation = |rows| {
        let options = HeightFieldOptions {
            rows: Some(rows),
            ..options.clone()
        };
        let loaded = load(&folder.join("dem.csv"), &options);
        let attributes = loaded.points.attributes();
        let luma: Vec<f64> = attributes
            .colors
            .iter()
            .map(|c| f64::from(c[0]) + f64::from(c[1]) + f64::from(c[2]))
            .collect();
        best_direction(&attributes.normals, &luma)
    };
    let (right, wrong) = (
        correlation(RowOrder::SouthFirst),
        correlation(RowOrder::NorthFirst),
    );
    println!("shading: {right:.3} against {wrong:.3}");
    assert!(right > 0.15 && right > 2.0 * wrong, "{right} {wrong}");
}

/// Largest correlation of brightness with the normals' horizontal component in any direction.
fn best_direction(normals: &[[f32; 3]], luma: &[f64]) -> f64 {
    let count = luma.len() as f64;
    let mean = luma.iter().sum::<f64>() / count;
    (0..36)
        .map(|step| {
            let sun = DVec2::from_angle(f64::from(step) * 10f64.to_radians());
            let slope: Vec<f64> = normals
                .iter()
                .map(|n| DVec2::new(n[0].into(), n[1].into()).dot(sun))
                .collect();
            let middle = slope.iter().sum::<f64>() / count;
            let sums = slope.iter().zip(luma).fold([0.0; 3], |[ab, aa, bb], (s, l)| {
                let (a, b) = (s - middle, l - mean);
                [ab + a * b, aa + a * a, bb + b * b]
            });
            sums[0] / (sums[1] * sums[2]).sqrt()
        })
        .fold(0.0, f64::max)
}

#[test]
fn raw_heights_need_only_their_dims() {
    let Some(folder) = shared() else { return };
    let raw = RawLayout {
        dims: [512, 512, 1],
        sample_type: SampleType::U16,
        spacing: DVec3::ONE,
        endian: Endian::Little,
        offset: 0,
    };
    let options = HeightFieldOptions {
        raw: Some(raw),
        color_image: Some(folder.join("jotunheimen-texture.jpg")),
        ..HeightFieldOptions::default()
    };
    let loaded = load(&folder.join("jotunheimen512.bin"), &options);
    assert!(loaded.description.stored_type.contains("heights 58 to 65315"));
    assert_eq!(loaded.description.warnings.len(), 1);
    let bounds = loaded.points.bounds();
    assert!(
        ((bounds.max.z - bounds.min.z) - 0.15 * 512.0).abs() < 1e-3,
        "{bounds:?}"
    );
    let true_scale = HeightFieldOptions {
        spacing: Some([60_000.0 / 512.0; 2]),
        height_scale: Some(5_000.0 / 65_535.0),
        exaggeration: 2.0,
        ..options
    };
    let loaded = load(&folder.join("jotunheimen512.bin"), &true_scale);
    assert!(loaded.description.warnings.is_empty());
    let relief = loaded.points.bounds().max.z - loaded.points.bounds().min.z;
    assert!(
        (relief - 2.0 * 5_000.0 * f64::from(65_315 - 58) / 65_535.0).abs() < 0.01,
        "{relief}"
    );
}

#[test]
fn raw_heights_have_a_relief_of_their_own_or_a_scale_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let codes: Vec<u8> = (0..256u16).flat_map(|i| (100 + i).to_le_bytes()).collect();
    let path = write(folder.path(), "a.bin", codes);
    let raw = RawLayout {
        dims: [16, 16, 1],
        sample_type: SampleType::U16,
        spacing: DVec3::ONE,
        endian: Endian::Little,
        offset: 0,
    };
    let options = HeightFieldOptions {
        raw: Some(raw),
        ..HeightFieldOptions::default()
    };
    let relief = |options: &HeightFieldOptions| {
        let loaded = load(&path, options);
        let bounds = loaded.points.bounds();
        (bounds.max.z - bounds.min.z, loaded.description)
    };
    let (own, description) = relief(&options);
    assert!((own - 0.15 * 16.0).abs() < 1e-6, "{own}");
    assert!(description.stored_type.contains("heights 100 to 355"));
    assert_eq!(description.warnings.len(), 1);
    let asked = HeightFieldOptions {
        spacing: Some([2.0; 2]),
        height_scale: Some(0.5),
        exaggeration: 2.0,
        ..options
    };
    let (asked, description) = relief(&asked);
    assert!((asked - 255.0).abs() < 1e-4, "{asked}");
    assert!(description.warnings.is_empty());
}

/// Rows of four posts, each higher than the one before, under a picture whose rows are each greener than the one before.
#[test]
fn posts_have_the_colours_of_their_places_whichever_row_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..4)
        .map(|row| format!("0.{row} 0.{row} 0.{row} 0.{row}\n"))
        .collect();
    let heights = write(folder.path(), "a.heights", rows);
    let codes: Vec<u8> = (0..16u8).flat_map(|i| [40 * (i % 4), 40 * (i / 4), 0]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 4);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&codes).unwrap();
    let picture = write(folder.path(), "a.png", bytes);
    for order in [RowOrder::NorthFirst, RowOrder::SouthFirst] {
        let options = HeightFieldOptions {
            height_scale: Some(1.0),
            color_image: Some(picture.clone()),
            rows: Some(order),
            ..HeightFieldOptions::default()
        };
        let loaded = load(&heights, &options);
        assert_eq!(loaded.points.len(), 16);
        for (place, color) in world(&loaded).into_iter().zip(&loaded.points.attributes().colors) {
            // The picture's first row is the north, whatever the table's is.
            let row = (10.0 * place.z).round();
            let south = if order == RowOrder::NorthFirst {
                3.0 - row
            } else {
                row
            };
            let west = loaded.points.bounds().min;
            assert!((place.y - west.y - south).abs() < 1e-6, "{order:?}: {place}");
            let expected = [40.0 * (place.x - west.x), 40.0 * (3.0 - south)];
            let found = [color[0], color[1]].map(f64::from);
            assert_eq!(found, expected.map(f64::round), "{order:?}: {place}");
        }
    }
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn a_plane_has_its_normal_and_no_holes() {
    let folder = tempfile::tempdir().unwrap();
    let slope = DVec2::new(0.3, -4.0);
    let text: String = (0..20)
        .map(|y| {
            let row: Vec<String> = (0..30)
                .map(|x| (slope.x * f64::from(x) + slope.y * f64::from(y)).to_string())
                .collect();
            row.join(" ") + "\n"
        })
        .collect();
    let options = HeightFieldOptions {
        height_scale: Some(1.0),
        ..HeightFieldOptions::default()
    };
    let loaded = load(&write(folder.path(), "a.txt", text), &options);
    let normal = DVec3::new(-slope.x, -slope.y, 1.0).normalize();
    for n in &loaded.points.attributes().normals {
        assert!(DVec3::from_array(n.map(f64::from)).dot(normal) > 1.0 - 1e-6);
    }
    assert!(loaded.points.attributes().radii.iter().all(|r| *r == 1.0));
    // Every place of the plane lies inside the disc of a point: radius 1.
    let points = world(&loaded);
    for i in 0..500 {
        let (x, y) = (
            29.0 * f64::from(i % 25) / 24.0,
            19.0 * f64::from(i / 25) / 19.0 * 0.99,
        );
        let place = DVec3::new(x, y, slope.dot(DVec2::new(x, y)));
        let nearest = points
            .iter()
            .map(|p| p.distance(place))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.9, "{place}: {nearest}");
    }
    // Flat ground gets no more than its posts; gaps none.
    let flat = load(
        &write(folder.path(), "b.txt", "1 1 1\n1 nan 1\n1 1 1.2\n"),
        &options,
    );
    assert_eq!(flat.points.len(), 8);
}

#[test]
fn geotiff_lies_where_its_tags_say() {
    use tiff::encoder::{TiffEncoder, colortype};
    use tiff::tags::Tag;
    let mut bytes = std::io::Cursor::new(Vec::new());
    let heights: Vec<i16> = vec![5, 6, 7, -9999, 8, 9];
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder.new_image::<colortype::GrayI16>(3, 2).unwrap();
    image
        .encoder()
        .write_tag(Tag::ModelPixelScaleTag, &[10.0f64, 20.0, 0.0][..])
        .unwrap();
    image
        .encoder()
        .write_tag(
            Tag::ModelTiepointTag,
            &[0.0f64, 0.0, 0.0, 1000.0, 5000.0, 0.0][..],
        )
        .unwrap();
    image.encoder().write_tag(Tag::GdalNodata, "-9999").unwrap();
    image.write_data(&heights).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let loaded = load(
        &write(folder.path(), "a.tif", bytes.into_inner()),
        &HeightFieldOptions::default(),
    );
    let mut places = world(&loaded);
    places.sort_by(|a, b| f64::total_cmp(&a.z, &b.z));
    // Pixels are areas: centres half a pixel inside. Row 0 is the north; the gap is in the south-west.
    let expected = [
        (1005.0, 4990.0),
        (1015.0, 4990.0),
        (1025.0, 4990.0),
        (1015.0, 4970.0),
        (1025.0, 4970.0),
    ];
    let expected: Vec<DVec3> = expected
        .iter()
        .zip(5..)
        .map(|(&(x, y), z)| DVec3::new(x, y, f64::from(z)))
        .collect();
    assert!(
        places.iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-4),
        "{places:?}"
    );
    assert_eq!(places.len(), 5);
}

/// Two cameras look at a tilted plane from different places: all points lie on the plane.
#[test]
fn depth_frames_meet_in_the_world() {
    let folder = tempfile::tempdir().unwrap();
    let plane = DVec3::new(0.2, -0.3, 1.0).normalize();
    let (size, f, c) = ([64u32, 48], 60.0, [31.5, 23.5]);
    let poses = [
        (
            [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            [0.5, -0.25, 10.0],
        ),
        (
            [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
            [1.5, 0.75, 12.0],
        ),
    ];
    let mut frames = String::new();
    for (index, (rotation, place)) in poses.iter().enumerate() {
        let row = |r: usize| DVec3::from_array(rotation[r]);
        let camera = DVec3::from_array(*place);
        let mut codes = Vec::new();
        for pixel in 0..size[0] * size[1] {
            let (u, v) = (f64::from(pixel % size[0]), f64::from(pixel / size[0]));
            let direction = DVec3::new((u - c[0]) / f, (v - c[1]) / f, 1.0);
            let world = DVec3::new(
                row(0).dot(direction),
                row(1).dot(direction),
                row(2).dot(direction),
            );
            let depth = -plane.dot(camera) / plane.dot(world);
            codes.push((depth * 2000.0).round() as u16);
        }
        codes[0] = 0;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        let data: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        write(folder.path(), &format!("{index}.png"), &bytes);
        let rows: Vec<String> = (0..3)
            .map(|r| {
                let [a, b, c] = rotation[r];
                format!("[{a}, {b}, {c}, {}]", place[r])
            })
            .collect();
        let color = if index == 0 { "color = \"color.png\"\n" } else { "" };
        frames += &format!(
            "[[frame]]\ndepth = \"{index}.png\"\n{color}world_from_camera = [{}]\n",
            rows.join(", ")
        );
    }
    let image = Image::filled(ImageSize::new(size[0], size[1]).unwrap(), [1.0, 0.0, 0.0, 1.0]);
    write_image(
        folder.path().join("color.png"),
        &image,
        None,
        ImageFormat::Png8,
        &[],
    )
    .unwrap();
    let list = format!(
        "depth_unit = 0.0005\nintrinsics = {{ fx = {f}, fy = {f}, cx = {}, cy = {} }}\n{frames}",
        c[0], c[1]
    );
    let loaded = read_depth_images(
        write(folder.path(), "a.toml", &list),
        &DepthImageOptions::default(),
    )
    .unwrap_or_else(|error| panic!("{error}"));
    let count = 2 * (64 * 48 - 1);
    let attributes = loaded.points.attributes();
    assert_eq!(loaded.points.len(), count);
    for (index, place) in world(&loaded).into_iter().enumerate() {
        // Depths are rounded to half a millimetre: a quarter of one off, and normals over two pixels of 1/6 each.
        assert!(plane.dot(place).abs() < 3e-4, "{place}");
        let normal = DVec3::from_array(attributes.normals[index].map(f64::from));
        assert!(normal.dot(plane) > 1.0 - 1e-4, "{normal}");
        let camera = if index < count / 2 { 10.0 } else { 12.0 };
        let radius = f64::from(attributes.radii[index]);
        assert!((radius - (camera - place.z) / f).abs() < 1e-5, "{radius}");
    }
    assert_eq!(attributes.colors[0], [255, 0, 0, 255]);
    assert_eq!(attributes.colors[count - 1], [128, 128, 128, 255]);
    for (from, to, words) in [
        ("fx = 60", "fx = 0", "intrinsics.fx"),
        (
            "[[frame]]\ndepth = \"0.png\"",
            "[[frame]]\ndepth = \"../0.png\"",
            "inside",
        ),
        ("depth_unit", "depthunit", "depthunit"),
        ("\"1.png\"", "\"color.png\"", "grey"),
    ] {
        let bad = write(folder.path(), "bad.toml", list.replacen(from, to, 1));
        let text = read_depth_images(bad, &DepthImageOptions::default())
            .unwrap_err()
            .to_string();
        assert!(text.contains(words), "{text}");
    }
}
