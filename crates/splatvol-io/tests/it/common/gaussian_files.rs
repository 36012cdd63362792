//! Small files of every format, made here, and the clouds they are made of.

use std::io::{Cursor, Write};
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use splatvol_io::{IoError, LoadedGaussians, ReadOptions, read_gaussians, write_gaussians};
use splatvol_scene::{GaussianAttributes, Gaussians};

use super::Random;

/// RDF, the frame of `.ply` and `.splat`.
pub(crate) fn rdf() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y))
}

/// Seeded Gaussians in RDF with harmonics small enough to stay within -1..1 when turned.
pub(crate) fn cloud(count: usize, degree: u32) -> Gaussians {
    let mut random = Random(u64::from(degree) + 7);
    let mut signed = |scale: f64| (random.signed() * scale) as f32;
    let mut attributes = GaussianAttributes::default();
    for _ in 0..count {
        attributes.means.push(std::array::from_fn(|_| signed(5.0)));
        attributes.scales.push(std::array::from_fn(|_| signed(2.5).exp()));
        attributes.rotations.push(std::array::from_fn(|_| signed(1.0)));
        attributes.opacities.push(0.5 + signed(0.49));
        attributes.harmonics.push(std::array::from_fn(|_| signed(1.5)));
        for _ in 1..(degree + 1).pow(2) {
            attributes.harmonics.push(std::array::from_fn(|_| signed(0.35)));
        }
    }
    Gaussians::new(attributes, degree, rdf()).unwrap()
}

/// Reads bytes as a file of that name.
pub(crate) fn read_as(folder: &Path, name: &str, bytes: &[u8]) -> Result<LoadedGaussians, IoError> {
    let path = folder.join(name);
    let _ = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).unwrap();
    read_gaussians(&path, &ReadOptions::default())
}

/// The bytes that the writer makes.
pub(crate) fn written(folder: &Path, name: &str, gaussians: &Gaussians) -> Vec<u8> {
    let path = folder.join(name);
    write_gaussians(&path, gaussians).unwrap_or_else(|error| panic!("{error}"));
    std::fs::read(path).unwrap()
}

pub(crate) fn gunzip(bytes: &[u8]) -> Vec<u8> {
    let mut plain = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(bytes), &mut plain).unwrap();
    plain
}

/// SPZ of version 4 with the arrays of a plain file of version 3, and extensions.
pub(crate) fn spz_4(plain: &[u8], extensions: &[u8]) -> Vec<u8> {
    let count = u32::from_le_bytes(plain[8..12].try_into().unwrap()) as usize;
    let harmonics = 3 * ((usize::from(plain[12]) + 1).pow(2) - 1);
    let sizes = [9, 1, 3, 3, 4, harmonics].map(|size| size * count);
    let streams = if harmonics == 0 { 5 } else { 6 };
    let mut file = plain[..16].to_vec();
    file[4] = 4;
    file[14] |= if extensions.is_empty() { 0 } else { 2 };
    file[15] = streams as u8;
    file.extend((32 + extensions.len() as u32).to_le_bytes());
    file.extend([0; 12]);
    file.extend(extensions);
    let mut at = 16;
    let mut bodies = Vec::new();
    for size in &sizes[..streams] {
        let body = compress_to_vec(&plain[at..at + size], CompressionLevel::Fastest);
        file.extend((body.len() as u64).to_le_bytes());
        file.extend((*size as u64).to_le_bytes());
        bodies.extend(body);
        at += size;
    }
    file.extend(bodies);
    file
}

/// One record of an extension.
pub(crate) fn extension(kind: u32, payload: &[u8]) -> Vec<u8> {
    let length = payload.len() as u32;
    [&kind.to_le_bytes()[..], &length.to_le_bytes(), payload].concat()
}

fn webp(width: u32, height: u32, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut samples = pixels.as_flattened().to_vec();
    samples.resize((4 * width * height) as usize, 0);
    let mut bytes = Vec::new();
    let encoder = image_webp::WebPEncoder::new(Cursor::new(&mut bytes));
    encoder
        .encode(&samples, width, height, image_webp::ColorType::Rgba8)
        .unwrap();
    bytes
}

/// Files of a SOG with five Gaussians of degree 1, whose decoded values are easy to tell.
pub(crate) fn sog_files(version: u32) -> Vec<(String, Vec<u8>)> {
    let low: Vec<_> = (0..5u8).map(|i| [i, 0, 255, 255]).collect();
    let high: Vec<_> = (0..5u8).map(|i| [0, i, 255, 255]).collect();
    let quats: Vec<_> = (0..5u8).map(|i| [128, 255, 0, (252 + i.min(3))]).collect();
    let bytes: Vec<_> = (0..5u8).map(|i| [i, i + 1, i + 2, 51 * i]).collect();
    let labels: Vec<_> = (0..5u8).map(|i| [i % 3, u8::from(i == 4), 0, 255]).collect();
    let centroids: Vec<_> = (0..192u8).map(|i| [i, 255 - i, 7, 255]).collect();
    let book: Vec<String> = (0..256)
        .map(|i| format!("{}", -4.0 + f64::from(i) / 64.0))
        .collect();
    let book = format!("\"codebook\":[{}]", book.join(","));
    let numbers = |channels: usize| match version {
        2 => book.clone(),
        _ => format!(
            "\"mins\":{:?},\"maxs\":{:?}",
            vec![-4.0; channels],
            vec![-4.0 + 255.0 / 64.0; channels]
        ),
    };
    let head = match version {
        2 => "\"version\":2,\"count\":5,\"antialias\":true,",
        _ => "",
    };
    let harmonics = match version {
        2 => format!("\"count\":3,\"bands\":1,{book}"),
        _ => "\"mins\":-4.0,\"maxs\":-0.015625".to_owned(),
    };
    let meta = format!(
        "{{{head}\"means\":{{\"shape\":[5,3],\"mins\":[-1,-2,0],\"maxs\":[1,2,3],\"files\":[\"ml.webp\",\"mu.webp\"]}},\
         \"scales\":{{{},\"files\":[\"s.webp\"]}},\"quats\":{{\"files\":[\"q.webp\"]}},\
         \"sh0\":{{{},\"files\":[\"c.webp\"]}},\"shN\":{{{harmonics},\"files\":[\"n.webp\",\"l.webp\"]}}}}",
        numbers(3),
        numbers(4)
    );
    vec![
        ("meta.json".to_owned(), meta.into_bytes()),
        ("ml.webp".to_owned(), webp(3, 2, &low)),
        ("mu.webp".to_owned(), webp(3, 2, &high)),
        ("s.webp".to_owned(), webp(3, 2, &bytes)),
        ("q.webp".to_owned(), webp(3, 2, &quats)),
        ("c.webp".to_owned(), webp(3, 2, &bytes)),
        ("n.webp".to_owned(), webp(192, 1, &centroids)),
        ("l.webp".to_owned(), webp(3, 2, &labels)),
    ]
}

/// A zip of files.
pub(crate) fn zip(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        writer
            .start_file(name, zip::write::SimpleFileOptions::default())
            .unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// A document with the same cloud on two nodes: one at rest, and one turned by 90 degrees about x, doubled and moved.
pub(crate) fn gltf(cloud: &Gaussians, extra: &str) -> Vec<u8> {
    use base64::Engine;
    let (a, count) = (cloud.attributes(), cloud.len());
    let per_splat = (cloud.degree() as usize + 1).pow(2);
    let mut data = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut attributes = Vec::new();
    let mut add = |name: String, kind: &str, numbers: Vec<f32>| {
        let (offset, length) = (data.len(), 4 * numbers.len());
        data.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        let index = views.len();
        views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{length}}}"
        ));
        accessors.push(format!(
            "{{\"bufferView\":{index},\"componentType\":5126,\"count\":{count},\"type\":\"{kind}\"}}"
        ));
        attributes.push(format!("\"{name}\":{index}"));
    };
    let own = |name: &str| format!("KHR_gaussian_splatting:{name}");
    add("POSITION".to_owned(), "VEC3", a.means.as_flattened().to_vec());
    add(own("ROTATION"), "VEC4", a.rotations.as_flattened().to_vec());
    add(own("SCALE"), "VEC3", a.scales.as_flattened().to_vec());
    add(own("OPACITY"), "SCALAR", a.opacities.clone());
    for degree in 0..=cloud.degree() as usize {
        for m in 0..2 * degree + 1 {
            let values = a.harmonics.iter().skip(degree * degree + m).step_by(per_splat);
            let values: Vec<f32> = values.flatten().copied().collect();
            add(own(&format!("SH_DEGREE_{degree}_COEF_{m}")), "VEC3", values);
        }
    }
    let uri = base64::engine::general_purpose::STANDARD.encode(&data);
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"extensionsUsed\":[\"KHR_gaussian_splatting\"],\"scene\":0,\
         \"scenes\":[{{\"nodes\":[0,1]}}],\"nodes\":[{{\"mesh\":0}},{{\"children\":[2],\"translation\":[0,0,5]}},\
         {{\"mesh\":0,\"rotation\":[0.7071067811865476,0,0,0.7071067811865476],\"scale\":[2,2,2]{extra}}}],\
         \"meshes\":[{{\"primitives\":[{{\"mode\":0,\"attributes\":{{{}}},\"extensions\":{{\"KHR_gaussian_splatting\":\
         {{\"kernel\":\"ellipse\",\"colorSpace\":\"srgb_rec709_display\"}}}}}}]}}],\"accessors\":[{}],\
         \"bufferViews\":[{}],\"buffers\":[{{\"byteLength\":{},\"uri\":\"data:application/octet-stream;base64,{uri}\"}}]}}",
        attributes.join(","),
        accessors.join(","),
        views.join(","),
        data.len()
    )
    .into_bytes()
}

/// A compressed `.ply` of three Gaussians with harmonics of degree 1.
pub(crate) fn compressed_ply() -> Vec<u8> {
    let mut header = "ply\nformat binary_little_endian 1.0\nelement chunk 1\n".to_owned();
    for names in [
        ["x", "y", "z"],
        ["scale_x", "scale_y", "scale_z"],
        ["r", "g", "b"],
    ] {
        for end in ["min", "max"] {
            for name in names {
                header.push_str(&format!("property float {end}_{name}\n"));
            }
        }
    }
    header.push_str("element vertex 3\n");
    for name in ["position", "rotation", "scale", "color"] {
        header.push_str(&format!("property uint packed_{name}\n"));
    }
    header.push_str("element sh 3\n");
    for i in 0..9 {
        header.push_str(&format!("property uchar f_rest_{i}\n"));
    }
    header.push_str("end_header\n");
    let mut bytes = header.into_bytes();
    for (min, max) in [(-1.0f32, 3.0f32), (-2.0, 0.0), (0.25, 0.75)] {
        bytes.extend(
            [[min; 3], [max; 3]]
                .as_flattened()
                .iter()
                .flat_map(|n| n.to_le_bytes()),
        );
    }
    let middle = (512u32 << 20) | (512 << 10) | 512;
    for words in [
        [0, middle, 0, 0x0000_00ff],
        [u32::MAX, middle | (1 << 30), u32::MAX, 0xffff_ff00],
        [(2047 << 21) | 2047, middle | (3 << 30), 1023 << 11, 0xff00_0033],
    ] {
        bytes.extend(words.iter().flat_map(|word: &u32| word.to_le_bytes()));
    }
    bytes.extend((0..27u8).map(|i| i * 9));
    bytes
}
