//! Round trips of written files, and files made by hand according to the layouts' specifications.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use splatvol_io::{ReadOptions, is_gaussians, read_gaussians, write_gaussians};
use splatvol_scene::Gaussians;

use super::harmonics::{differences, in_world};
use crate::common::gaussian_files::{
    cloud, compressed_ply, extension, gltf, gunzip, read_as, sog_files, spz_4, written, zip,
};
use crate::common::gzip;

/// Largest differences that writing and reading may make: means, opacities, colours, covariances.
fn assert_round_trip(gaussians: &Gaussians, name: &str, tolerances: [f64; 4]) {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path(), name, gaussians);
    let loaded = read_as(folder.path(), name, &bytes).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.description.warnings, [""; 0]);
    assert_eq!(
        loaded.gaussians.antialiased(),
        gaussians.antialiased() && !name.ends_with("splat")
    );
    let found = differences(gaussians, &loaded.gaussians);
    for (found, tolerance) in found.into_iter().zip(tolerances) {
        assert!(
            found < tolerance,
            "{name}, degree {}: {found} of {tolerance}",
            gaussians.degree()
        );
    }
}

#[test]
fn what_is_written_comes_back_within_its_quantisation() {
    for degree in 0..=3 {
        let gaussians = cloud(300, degree);
        // Floats, with the roundings of a logit and of a logarithm.
        assert_round_trip(&gaussians, "a.ply", [1e-9, 1e-6, 1e-6, 1e-5]);
        // Half of 2^-12; half of 1/255; scales by e^(1/32). Colours: degree 0 by half of 1/(255 * 0.15); above that the
        // harmonics of a degree add up to (2 l + 1) / sqrt(4 pi) at most, times half of a step of 1/16 (l = 1) or 1/8.
        let steps = [0.0, 0.8463 / 32.0, 1.4105 / 16.0, 1.9747 / 16.0];
        let color = 0.2821 * 0.5 / 38.25 + steps[..=degree as usize].iter().sum::<f64>();
        let spz = [1.3e-4, 0.002, color, 0.08];
        assert_round_trip(&gaussians, "a.spz", spz);
        assert_round_trip(&gaussians.clone().with_antialiasing(true), "a.spz", spz);
        assert_round_trip(
            &gaussians.clone().with_antialiasing(true),
            "a.ply",
            [1e-9, 1e-6, 1e-6, 1e-5],
        );
        // Turned, mirrored, doubled and moved: what is written lies in the frame of the format.
        let turn = DMat3::from_quat(DQuat::from_xyzw(0.3, -0.2, 0.6, 0.4).normalize());
        let mirror = DMat3::from_diagonal(DVec3::new(2.0, -2.0, 2.0));
        let frame = DAffine3::from_mat3_translation(turn * mirror, DVec3::new(1.0, -2.0, 3.0));
        let moved = gaussians.placed(frame).unwrap();
        assert_round_trip(&moved, "a.ply", [3e-6, 1e-6, 1e-5, 1e-5]);
        assert_round_trip(&moved, "a.spz", [1.3e-4, 0.002, color, 0.08]);
    }
    let gaussians = cloud(300, 0);
    let mut attributes = gaussians.attributes().clone();
    for color in attributes.harmonics.as_flattened_mut() {
        *color = color.clamp(-1.7, 1.7);
    }
    let gaussians = Gaussians::new(attributes, 0, *gaussians.world_from_local()).unwrap();
    // Bytes of colours and opacities, rotations in steps of 1/128.
    assert_round_trip(&gaussians, "a.splat", [1e-9, 0.0021, 0.0021, 0.02]);
}

#[test]
fn what_cannot_be_written_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let gaussians = cloud(3, 0);
    let refused = |name: &str, gaussians: &Gaussians, words: &str| {
        let error = write_gaussians(folder.path().join(name), gaussians)
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    };
    refused("a.sog", &gaussians, "no writer");
    let stretched = DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0));
    refused(
        "a.ply",
        &gaussians.clone().placed(stretched).unwrap(),
        "one scale",
    );
    let far = DAffine3::from_translation(DVec3::splat(1e7));
    refused("a.spz", &gaussians.clone().placed(far).unwrap(), "24 bits");
    refused("absent/a.ply", &gaussians, "cannot write");
}

#[test]
fn all_versions_of_spz_agree() {
    let folder = tempfile::tempdir().unwrap();
    let gaussians = cloud(200, 3).with_antialiasing(true);
    let bytes = written(folder.path(), "a.spz", &gaussians);
    let three = read_as(folder.path(), "a.spz", &bytes).unwrap();
    let plain = gunzip(&bytes);
    let raw = read_as(folder.path(), "b.spz", &plain).unwrap();
    assert_eq!(raw.gaussians, three.gaussians);
    assert_eq!(raw.description.stored_type, "12 fractional bits, not compressed");
    let four = read_as(folder.path(), "c.spz", &spz_4(&plain, &[])).unwrap();
    assert_eq!(four.gaussians, three.gaussians);
    assert!(four.gaussians.antialiased() && four.description.tags == ["antialiased"]);

    // RDF (6) by an extension: the same numbers, another frame; an unknown extension; a range of harmonics.
    let range = [&[8u8, 8][..], &(-2.0f32).to_le_bytes(), &2.0f32.to_le_bytes()].concat();
    let records = [
        extension(0xADBE_0003, &6u32.to_le_bytes()),
        extension(0x1234_0001, &[1, 2, 3]),
        extension(0xADBE_0001, &range),
    ]
    .concat();
    let extended = read_as(folder.path(), "d.spz", &spz_4(&plain, &records)).unwrap();
    assert_eq!(
        extended.gaussians.world_from_local(),
        gaussians.world_from_local()
    );
    assert!(extended.description.warnings[0].contains("0x12340001"));
    let (old, new) = (three.gaussians.attributes(), extended.gaussians.attributes());
    assert_eq!(old.means, new.means);
    for (old, new) in old.harmonics[1..16].iter().zip(&new.harmonics[1..16]) {
        let expected = old.map(|c| -2.0 + 4.0 * (c * 128.0 + 128.0) / 255.0);
        assert!(
            (glam::Vec3::from(*new) - glam::Vec3::from(expected))
                .abs()
                .max_element()
                < 1e-5
        );
    }
    // Bytes behind the arrays.
    let longer = gzip(&[&plain[..], &[1, 2, 3]].concat());
    let warnings = read_as(folder.path(), "e.spz", &longer)
        .unwrap()
        .description
        .warnings;
    assert!(warnings[0].contains("3 or more bytes"), "{warnings:?}");
}

#[test]
fn half_floats_of_version_1_and_quaternions_of_version_2() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = b"NGSP\x01\0\0\0\x01\0\0\0\0\0\0\0".to_vec();
    for half in [0.5f32, -2.0, 1024.0] {
        file.extend(half::f16::from_f32(half).to_le_bytes());
    }
    file.extend([255, 0, 255, 128, 160, 176, 192, 128, 255, 128]);
    let loaded = read_as(folder.path(), "a.spz", &gzip(&file)).unwrap();
    let a = loaded.gaussians.attributes();
    assert_eq!((a.means[0], a.opacities[0]), ([0.5, -2.0, 1024.0], 1.0));
    assert_eq!(a.scales[0], [1.0, 1f32.exp(), 2f32.exp()]);
    assert!((a.harmonics[0][0] + 0.5 / 0.15).abs() < 1e-6 && (a.harmonics[0][1] - 0.5 / 0.15).abs() < 1e-6);
    let [x, y, z, w] = a.rotations[0];
    assert!(y > 0.9999 && x.abs() < 0.004 && z.abs() < 0.004 && w == 0.0);
}

#[test]
fn properties_of_a_trained_ply_come_in_any_order_with_others_between_them() {
    let folder = tempfile::tempdir().unwrap();
    let text = "ply\nformat ascii 1.0\ncomment SplatRenderMode: mip\nelement vertex 2\nproperty float opacity\n\
        property double z\nproperty uchar extra\nproperty float y\nproperty float x\nproperty float rot_3\n\
        property float rot_0\nproperty float rot_1\nproperty float rot_2\nproperty list uchar int more\n\
        property float f_rest_8\nproperty float f_rest_1\nproperty float f_rest_2\nproperty float f_rest_3\n\
        property float f_rest_4\nproperty float f_rest_5\nproperty float f_rest_6\nproperty float f_rest_7\n\
        property float f_rest_0\nproperty float f_dc_2\nproperty float f_dc_1\nproperty float f_dc_0\n\
        property float scale_1\nproperty float scale_0\nproperty float filter_3D\nend_header\n\
        0 3 9 2 1 0.6 0 0 0.8 2 7 7 8 1 2 3 4 5 6 7 0 .3 .2 .1 0 1 0.75\n\
        nan 3 9 2 1 0.6 0 0 0.8 0 8 1 2 3 4 5 6 7 0 .3 .2 .1 0 1 0.75\n";
    let loaded = read_as(folder.path(), "a.ply", text.as_bytes()).unwrap();
    let (a, e) = (loaded.gaussians.attributes(), 1f64.exp());
    assert_eq!((a.means[0], loaded.gaussians.degree()), ([1.0, 2.0, 3.0], 1));
    assert_eq!(a.rotations[0], [0.0, 0.8, 0.6, 0.0]);
    assert_eq!(
        a.harmonics,
        [[0.1, 0.2, 0.3], [0.0, 3.0, 6.0], [1.0, 4.0, 7.0], [2.0, 5.0, 8.0]]
    );
    // Flat, and widened by a filter of 0.75.
    let widened = [(e * e + 0.5625).sqrt(), 1.25, 0.75];
    for (found, expected) in a.scales[0].iter().zip(widened) {
        assert!((f64::from(*found) - expected).abs() < 1e-6, "{found} {expected}");
    }
    assert_eq!(
        a.opacities[0], 0.0,
        "no thickness, so nothing is left of it in a wider Gaussian"
    );
    assert!(loaded.gaussians.antialiased());
    assert_eq!(loaded.description.tags, ["flat", "mip", "antialiased"]);
    assert!(loaded.description.warnings[0].contains("1 of 2 Gaussians"));
}

#[test]
fn a_compressed_ply_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = read_as(folder.path(), "a.ply", &compressed_ply()).unwrap();
    let a = loaded.gaussians.attributes();
    assert_eq!((a.means.len(), loaded.gaussians.degree()), (3, 1));
    assert_eq!(a.means, [[-1.0; 3], [3.0; 3], [3.0, -1.0, 3.0]]);
    let two = (-2f32).exp();
    assert_eq!(a.scales, [[two; 3], [1.0; 3], [two, 1.0, two]]);
    assert_eq!(a.opacities, [1.0, 0.0, 0.2]);
    for (rotation, largest) in a.rotations.iter().zip([3, 0, 2]) {
        assert!((rotation[largest] - 1.0).abs() < 1e-5, "{rotation:?}");
    }
    let dc = |color: f64| ((color - 0.5) / 0.28209479177387814) as f32;
    assert_eq!(a.harmonics[8], [dc(0.75), dc(0.25), dc(0.25)]);
    assert_eq!(a.harmonics[4], [dc(0.75); 3]);
    // First of red, of green, of blue: bytes 0, 27, 54.
    let byte = |b: f32| ((b + 0.5) / 256.0 - 0.5) * 8.0;
    assert_eq!(a.harmonics[1], [-4.0, byte(27.0), byte(54.0)]);
}

#[test]
fn a_sog_by_hand_in_a_zip_and_in_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    for version in [1, 2] {
        let files = sog_files(version);
        let loaded = read_as(folder.path(), &format!("{version}.sog"), &zip(&files)).unwrap();
        assert_eq!(loaded.description.format, format!("SOG {version}"));
        assert_eq!(loaded.gaussians.antialiased(), version == 2);
        let a = loaded.gaussians.attributes();
        assert_eq!((a.means.len(), loaded.gaussians.degree()), (5, 1));
        for i in 0..5 {
            let place = |low: usize, high: usize, min: f64, max: f64| {
                let log = min + (max - min) * (low + 256 * high) as f64 / 65535.0;
                log.signum() * (log.abs().exp() - 1.0)
            };
            let mean = [
                place(i, 0, -1.0, 1.0),
                place(0, i, -2.0, 2.0),
                place(255, 255, 0.0, 3.0),
            ];
            for (found, expected) in a.means[i].iter().zip(mean) {
                assert!((f64::from(*found) - expected).abs() < 1e-5, "{found} {expected}");
            }
            let number = |byte: usize| -4.0 + byte as f64 / 64.0;
            for axis in 0..3 {
                let scale = f64::from(a.scales[i][axis]);
                assert!((scale - number(i + axis).exp()).abs() < 1e-6);
                let color = f64::from(a.harmonics[4 * i][axis]);
                assert!((color - number(i + axis)).abs() < 1e-5);
            }
            let logit = number(51 * i);
            let opacity = if version == 2 {
                i as f64 / 5.0
            } else {
                1.0 / (1.0 + (-logit).exp())
            };
            assert!((f64::from(a.opacities[i]) - opacity).abs() < 1e-6);
            // Labels 0, 1, 2, 0, and 257, which does not exist.
            let red = f64::from(a.harmonics[4 * i + 2][0]);
            let expected = if i == 4 { 0.0 } else { number(3 * (i % 3) + 1) };
            assert!((red - expected).abs() < 1e-5, "{i}: {red} {expected}");
            // 128 is 0.0028 above the middle; the largest is w, x, y, z, z; -1, 1 and 0 in the others.
            let half = std::f32::consts::FRAC_1_SQRT_2;
            let [x, y, z, w] = a.rotations[i];
            let quaternion = [w, x, y, z];
            let largest = i.min(3);
            let others: Vec<f32> = (0..4).filter(|c| *c != largest).map(|c| quaternion[c]).collect();
            assert!(
                others[0].abs() < 0.003
                    && (others[1] - half).abs() < 0.003
                    && (others[2] + half).abs() < 0.003
            );
            assert!(quaternion[largest].abs() < 0.01);
        }
        assert!(
            loaded.description.warnings[0].contains("1 of 5"),
            "{:?}",
            loaded.description
        );

        let inside = folder.path().join(format!("folder{version}"));
        std::fs::create_dir(&inside).unwrap();
        for (name, bytes) in &files {
            std::fs::write(inside.join(name), bytes).unwrap();
        }
        for path in [inside.clone(), inside.join("meta.json")] {
            assert!(is_gaussians(&path));
            let unpacked = read_gaussians(&path, &ReadOptions::default()).unwrap();
            assert_eq!(unpacked.gaussians, loaded.gaussians);
            assert_eq!(unpacked.description.files.len(), 9 - usize::from(path.is_file()));
        }
    }
}

#[test]
fn sparse_accessors_replace_elements_of_their_views_or_of_zeros() {
    use base64::Engine;
    let folder = tempfile::tempdir().unwrap();
    // Element 1 becomes 0.25.
    let data = [&[1, 0, 0, 0][..], &0.25f32.to_le_bytes()].concat();
    let uri = base64::engine::general_purpose::STANDARD.encode(&data);
    let document = |with_view: &str, index: u8| {
        let text = String::from_utf8(gltf(&cloud(2, 1), "")).unwrap();
        let own = "\"bufferView\":3,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"";
        assert!(text.contains(own));
        let sparse = format!(
            "{with_view}\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"sparse\":{{\"count\":1,\
             \"indices\":{{\"bufferView\":8,\"byteOffset\":{index},\"componentType\":5121}},\"values\":{{\"bufferView\":9}}}}"
        );
        let views = "{\"buffer\":1,\"byteLength\":8},{\"buffer\":1,\"byteOffset\":4,\"byteLength\":4}";
        let text = text.replace(own, &sparse);
        let text = text.replace("],\"buffers\":[", &format!(",{views}],\"buffers\":["));
        let end = text.strip_suffix("}]}").unwrap();
        format!("{end}}},{{\"byteLength\":8,\"uri\":\"data:application/octet-stream;base64,{uri}\"}}]}}")
    };
    let own = cloud(2, 1).attributes().opacities.clone();
    for (with_view, first) in [("\"bufferView\":3,", own[0]), ("", 0.0)] {
        let loaded = read_as(folder.path(), "a.gltf", document(with_view, 0).as_bytes()).unwrap();
        let opacities = &loaded.gaussians.attributes().opacities;
        assert_eq!(opacities[..2], [first, 0.25]);
    }
    // The number at the fourth byte is 0; at the eighth it is 62, of the value.
    let error = read_as(folder.path(), "a.gltf", document("", 7).as_bytes()).unwrap_err();
    assert!(error.to_string().contains("sparse.indices"), "{error}");
}

#[test]
fn nodes_of_a_gltf_are_joined_with_their_harmonics_turned() {
    let folder = tempfile::tempdir().unwrap();
    for degree in 0..=3 {
        let gaussians = cloud(40, degree);
        let loaded = read_as(folder.path(), "a.gltf", &gltf(&gaussians, "")).unwrap();
        assert_eq!(loaded.gaussians.len(), 80);
        let joined = in_world(&loaded.gaussians);
        let y_up = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y));
        let turn = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let node =
            DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::new(0.0, 0.0, 5.0));
        for (start, frame) in [(0, y_up), (40, y_up * node)] {
            let expected = in_world(&gaussians.clone().placed(frame).unwrap());
            for (found, expected) in joined[start..].iter().zip(&expected) {
                assert!((found.mean - expected.mean).length() < 1e-5);
                let trace: f64 = (0..3).map(|i| expected.covariance.col(i)[i]).sum();
                assert!(found.covariance.abs_diff_eq(expected.covariance, 1e-5 * trace));
                for (found, expected) in found.colors.iter().zip(&expected.colors) {
                    assert!((*found - *expected).length() < 1e-5, "{found} {expected}");
                }
            }
        }
    }
    let refused = |from: &str, to: &str, words: &str| {
        let text = String::from_utf8(gltf(&cloud(2, 1), "")).unwrap();
        assert!(text.contains(from));
        let error = read_as(folder.path(), "b.gltf", text.replacen(from, to, 1).as_bytes()).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    };
    refused("[2,2,2]", "[2,2,3]", "similarity");
    refused("\"children\":[2]", "\"children\":[1]", "tree");
    refused("\"children\":[2]", "\"children\":[9]", "index of a node");
    refused("\"count\":2", "\"count\":3", "buffer view");
    refused("\"count\":2", "\"count\":1e30", "whole number");
    refused("\"mesh\":0", "\"mesh\":7", "meshes[7]");
    refused("\"kernel\":\"ellipse\"", "\"kernel\":\"box\"", "kernel");
    refused("COEF_2", "COEF_3", "COEF_2");
    refused("\"type\":\"VEC4\"", "\"type\":\"VEC3\"", "VEC4");
    refused("5126", "5125", "componentType");
}

#[test]
fn spz_inside_a_gltf_is_in_the_frame_of_the_node() {
    use base64::Engine;
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path(), "a.spz", &cloud(20, 2).with_antialiasing(true));
    let alone = read_as(folder.path(), "a.spz", &bytes).unwrap().gaussians;
    let uri = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let document = format!(
        "{{\"extensionsUsed\":[\"KHR_gaussian_splatting\"],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{}},\
         \"extensions\":{{\"KHR_gaussian_splatting\":{{\"extensions\":{{\
         \"KHR_gaussian_splatting_compression_spz_2\":{{\"bufferView\":0}}}}}}}}}}]}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteOffset\":0,\"byteLength\":{0}}}],\
         \"buffers\":[{{\"byteLength\":{0},\"uri\":\"data:;base64,{uri}\"}}]}}",
        bytes.len()
    );
    let inside = read_as(folder.path(), "a.gltf", document.as_bytes())
        .unwrap()
        .gaussians;
    assert_eq!(inside, alone);
}
