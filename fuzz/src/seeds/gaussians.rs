//! 3-D Gaussians, mostly by the generators of the readers' tests.

use splatvol_io::write_gaussians;

use super::written;
use crate::common::gaussian_files::{cloud, compressed_ply, extension, gltf, gunzip, sog_files, spz_4, zip};
use crate::input::Input;

fn of_writer(name: &str, degree: u32) -> Input {
    written(name, |path| write_gaussians(path, &cloud(6, degree)).unwrap())
}

pub(crate) fn ply() -> Vec<Input> {
    let text = "ply\nformat ascii 1.0\ncomment SplatRenderMode: mip\nelement vertex 1\nproperty float opacity\n\
        property float x\nproperty float y\nproperty float z\nproperty float rot_0\nproperty float rot_1\n\
        property float rot_2\nproperty float rot_3\nproperty list uchar int more\nproperty float f_dc_0\n\
        property float f_dc_1\nproperty float f_dc_2\nproperty float scale_0\nproperty float scale_1\n\
        property float filter_3D\nend_header\n0 3 9 2 1 0.6 0 0 2 7 7 .3 .2 .1 0 1 0.75\n";
    vec![
        of_writer("a.ply", 0),
        of_writer("b.ply", 1),
        Input::file("packed.ply", compressed_ply()),
        Input::file("text.ply", text),
    ]
}

pub(crate) fn splat() -> Vec<Input> {
    vec![of_writer("a.splat", 0)]
}

pub(crate) fn spz() -> Vec<Input> {
    let three = of_writer("a.spz", 1);
    let plain = gunzip(&three.files[0].1);
    let range = [&[8u8, 8][..], &(-2.0f32).to_le_bytes(), &2.0f32.to_le_bytes()].concat();
    let records = [
        extension(0xADBE_0003, &6u32.to_le_bytes()),
        extension(0xADBE_0001, &range),
    ]
    .concat();
    let mut one = b"NGSP\x01\0\0\0\x01\0\0\0\0\0\0\0".to_vec();
    for half in [0.5f32, -2.0, 1024.0] {
        one.extend(half::f16::from_f32(half).to_le_bytes());
    }
    one.extend([255, 0, 255, 128, 160, 176, 192, 128, 255, 128]);
    vec![
        three,
        Input::file("four.spz", spz_4(&plain, &[])),
        Input::file("records.spz", spz_4(&plain, &records)),
        Input::file("plain.spz", plain),
        Input::file("one.spz", crate::common::gzip(&one)),
    ]
}

pub(crate) fn sog() -> Vec<Input> {
    let folder = |version| Input::files("", sog_files(version));
    let packed = |version| Input::file("a.sog", zip(&sog_files(version)));
    vec![packed(1), packed(2), folder(1), folder(2)]
}

pub(crate) fn gltf_files() -> Vec<Input> {
    let text = gltf(&cloud(3, 1), "");
    let binary = glb(&text);
    vec![
        Input::file("a.gltf", gltf(&cloud(2, 0), "")),
        Input::file("b.gltf", text),
        Input::file("a.glb", binary),
    ]
}

/// The document in a binary container, its buffer still in the text.
fn glb(text: &[u8]) -> Vec<u8> {
    let mut text = text.to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = text.len() as u32;
    let mut bytes = b"glTF".to_vec();
    for number in [2, 20 + length, length] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"JSON");
    [bytes, text].concat()
}

/// Level 0: a header of 4096 bytes, one section of 1024, and 44 bytes per Gaussian.
pub(crate) fn ksplat() -> Vec<Input> {
    vec![ksplat_of_level(0), ksplat_of_level(1)]
}

fn ksplat_of_level(level: u16) -> Input {
    const COUNT: u32 = 3;
    let mut bytes = vec![0; 4096 + 1024];
    bytes[1] = 1;
    let mut word = |at: usize, value: u32| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    for (at, value) in [
        (4, 1),
        (8, 1),
        (12, COUNT),
        (16, COUNT),
        (4096, COUNT),
        (4100, COUNT),
    ] {
        word(at, value);
    }
    word(20, u32::from(level));
    word(36, (-1.5f32).to_bits());
    word(40, 1.5f32.to_bits());
    if level > 0 {
        // One bucket that is not full, of 12 bytes, its steps to either side.
        for (at, value) in [
            (4104, 256),
            (4108, 1),
            (4112, 5f32.to_bits()),
            (4116, 12),
            (4120, 32767),
            (4132, 1),
        ] {
            word(at, value);
        }
    }
    if level == 0 {
        for i in 0..COUNT {
            for value in [i as f32, 1.0, 2.0, 0.5, 0.25, 0.125, 1.0, 0.0, 0.0, 0.0] {
                bytes.extend(value.to_le_bytes());
            }
            bytes.extend([i as u8, 100, 200, 255]);
        }
    } else {
        bytes.extend(COUNT.to_le_bytes());
        for value in [0f32, 1.0, 2.0] {
            bytes.extend(value.to_le_bytes());
        }
        for i in 0..COUNT as u16 {
            bytes.extend([32767 + i, 32767, 32767].map(u16::to_le_bytes).as_flattened());
            let halves = [0.5f32, 0.25, 0.125, 1.0, 0.0, 0.0, 0.0].map(half::f16::from_f32);
            bytes.extend(halves.map(half::f16::to_le_bytes).as_flattened());
            bytes.extend([i as u8, 100, 200, 255]);
        }
    }
    Input::file("a.ksplat", bytes)
}
