//! The real files against their notes.

use std::path::{Path, PathBuf};

use glam::DVec3;
use splatvol_io::{LoadedGaussians, ReadOptions, is_gaussians, read_gaussians, write_gaussians};
use splatvol_recorded::recorded;
use splatvol_scene::Gaussians;

use super::harmonics::{differences, in_world};

fn folder() -> Option<PathBuf> {
    recorded("gaussians")
}

fn load(path: &Path) -> LoadedGaussians {
    assert!(is_gaussians(path));
    read_gaussians(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A local box.
type Box3 = [[f32; 3]; 2];

/// The box of the means.
fn bounds(loaded: &LoadedGaussians) -> Box3 {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for mean in &loaded.gaussians.attributes().means {
        for axis in 0..3 {
            bounds[0][axis] = bounds[0][axis].min(mean[axis]);
            bounds[1][axis] = bounds[1][axis].max(mean[axis]);
        }
    }
    bounds
}

#[test]
fn real_files_agree_with_their_table() {
    let Some(folder) = folder() else { return };
    let train = [[-2.74808, -1.01235, -1.39705], [2.00785, 0.0810489, 1.3285]];
    let file = [[-1.0, 0.0, -1.0], [0.0, 0.0, 0.0]];
    let turned = [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    // Name, format, Gaussians, degree of the harmonics, bounds.
    let table: [(&str, &str, usize, u32, Box3); 13] = [
        (
            "biker.spz",
            "SPZ 4",
            152_746,
            0,
            [[-0.621, 0.0, -0.613], [0.414, 3.18, 0.532]],
        ),
        (
            "biker.compressed.ply",
            "compressed PLY (3-D Gaussians)",
            152_746,
            0,
            [
                [-0.621256, -3.18008, -0.532257],
                [0.414404, -7.15256e-07, 0.613281],
            ],
        ),
        (
            "fruit_drops_minimal.ply",
            "PLY (3-D Gaussians)",
            4721,
            3,
            [[0.486115, -0.0115747, -2.24899], [1.0022, 0.249711, -2.01997]],
        ),
        (
            "pc_short.ply",
            "PLY (3-D Gaussians)",
            100,
            3,
            [[-0.932074, -0.472956, 0.332892], [0.0834385, 0.478113, 1.56834]],
        ),
        ("3-points-from-train.ply", "PLY (3-D Gaussians)", 3, 3, train),
        ("3-points-from-train.splat", ".splat", 3, 0, train),
        (
            "3-points-from-train.spz",
            "SPZ 3",
            3,
            3,
            [[-2.748, -0.081, -1.329], [2.008, 1.012, 1.397]],
        ),
        ("minimal.splat", ".splat", 4, 0, file),
        ("minimal.ksplat", ".ksplat 0.1", 4, 0, file),
        ("minimal-v2.spz", "SPZ 2", 4, 0, file),
        ("minimal-raw.spz", "SPZ 2", 4, 0, file),
        ("minimal-v3.spz", "SPZ 3", 4, 0, turned),
        ("minimal-v4.spz", "SPZ 4", 4, 0, turned),
    ];
    for (name, format, count, degree, expected) in table {
        let loaded = load(&folder.join(name));
        let description = &loaded.description;
        println!("{name}: {description:?}");
        assert_eq!(
            (description.format.as_str(), description.count),
            (format, count),
            "{name}"
        );
        assert_eq!(
            (loaded.gaussians.len(), loaded.gaussians.degree()),
            (count, degree),
            "{name}"
        );
        assert!(!loaded.gaussians.antialiased());
        for (found, expected) in bounds(&loaded).as_flattened().iter().zip(expected.as_flattened()) {
            // Bounds were noted with 6 digits, those of SPZ with 3 decimals.
            let tolerance = if format.starts_with("SPZ") {
                6e-4
            } else {
                2e-6 + 1e-5 * expected.abs()
            };
            assert!((found - expected).abs() < tolerance, "{name}: {found} {expected}");
        }
        let warnings = description.warnings.join("; ");
        if name == "pc_short.ply" {
            assert!(warnings.contains("14029 bytes"), "{warnings}");
        } else {
            assert_eq!(warnings, "", "{name}");
        }
    }
}

/// Correlation of the deviations of a Gaussian's colours from their mean over all directions.
fn correlation(a: &Gaussians, b: &Gaussians) -> f64 {
    let varying = |gaussians: &Gaussians| -> Vec<DVec3> {
        let each = in_world(gaussians).into_iter().flat_map(|g| {
            let mean = g.colors.iter().sum::<DVec3>() / g.colors.len() as f64;
            g.colors.into_iter().map(move |color| color - mean)
        });
        each.collect()
    };
    let (a, b) = (varying(a), varying(b));
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt()
}

#[test]
fn the_same_splats_lie_at_the_same_world_places_in_every_format() {
    let Some(folder) = folder() else { return };
    let ply = load(&folder.join("biker.compressed.ply"));
    let spz = load(&folder.join("biker.spz"));
    let [mean, opacity, color, covariance] = differences(&ply.gaussians, &spz.gaussians);
    println!("biker: mean {mean:.2e} opacity {opacity:.2e} colour {color:.2e} covariance {covariance:.2e}");
    assert!(mean < 1.3e-4, "{mean}");
    assert!(opacity < 1e-7, "{opacity}");
    // Colours: 8 bits of a range of 1.88 against 8 bits of the chunk's range.
    assert!(color < 0.012, "{color}");
    // Scales in steps of 1/16 of the logarithm, rotations of 10 bits, both quantised twice.
    assert!(covariance < 0.15, "{covariance}");
    // The motorcyclist stands on the ground.
    let [low, high] = [spz.gaussians.bounds().min, spz.gaussians.bounds().max];
    assert!(low.z.abs() < 1e-3 && (high.z - 3.18).abs() < 1e-3, "{low} {high}");

    let ply = load(&folder.join("3-points-from-train.ply")).gaussians;
    let spz = load(&folder.join("3-points-from-train.spz")).gaussians;
    let [mean, opacity, color, covariance] = differences(&ply, &spz);
    println!(
        "train, spz: mean {mean:.2e} opacity {opacity:.2e} colour {color:.2e} covariance {covariance:.2e}"
    );
    assert!(mean < 0.5 / 4096.0 + 1e-6, "{mean}");
    assert!(opacity < 0.5 / 255.0 + 1e-6, "{opacity}");
    // Harmonics in steps of 1/16 and 1/8, as in the tests of what is written.
    assert!(color < 0.242, "{color}");
    // The signs matter: the same coefficients in the other frame give other colours.
    let wrong = spz.clone().placed(*ply.world_from_local()).unwrap();
    let (right, wrong) = (correlation(&ply, &spz), correlation(&ply, &wrong));
    println!(
        "train, spz: correlation of what depends on the direction {right:.3}, in the other frame {wrong:.3}"
    );
    // Bytes of small harmonics are coarse: a correlation of 0.78 is left.
    assert!(right > 0.75 && wrong < 0.3, "{right} {wrong}");
    // Quantised here, the trained ones become the very bytes that another program wrote.
    let written = tempfile::tempdir().unwrap();
    let path = written.path().join("a.spz");
    write_gaussians(&path, &ply).unwrap();
    let ours = load(&path).gaussians;
    let difference = differences(&ours, &spz);
    let (ours, theirs) = (ours.attributes(), spz.attributes());
    assert_eq!(ours.harmonics, theirs.harmonics);
    assert_eq!(ours.means, theirs.means);
    assert_eq!(ours.scales, theirs.scales);
    assert_eq!(ours.opacities, theirs.opacities);
    // Rotations differ by half turns of a Gaussian's own axes, which change nothing.
    assert!(difference[3] < 1e-6, "{difference:?}");
    assert!(covariance < 0.07, "{covariance}");

    let splat = load(&folder.join("3-points-from-train.splat")).gaussians;
    let (a, b) = (in_world(&ply), in_world(&splat));
    for (index, (a, b)) in a.iter().zip(&b).enumerate() {
        assert_eq!(a.mean, b.mean);
        assert!((a.opacity - b.opacity).abs() < 1.01 / 255.0);
        let dc = |g: &Gaussians, per_splat: usize| g.attributes().harmonics[index * per_splat];
        for (a, b) in dc(&ply, 16).iter().zip(dc(&splat, 1)) {
            let shown = (0.5 + 0.28209479 * a).clamp(0.0, 1.0);
            assert!(
                (shown - (0.5 + 0.28209479 * b)).abs() < 1.01 / 255.0,
                "{index}: {a} {b}"
            );
        }
        let trace: f64 = (0..3).map(|i| a.covariance.col(i)[i]).sum();
        let difference = (a.covariance - b.covariance)
            .to_cols_array()
            .into_iter()
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        assert!(difference / trace < 0.03, "{index}: {}", difference / trace);
    }
}

#[test]
fn the_conformance_matrix_gives_fifteen_gaussians() {
    let Some(folder) = folder() else { return };
    let loaded = load(&folder.join("khr_conformance_matrix.glb"));
    println!("{:?}", loaded.description);
    let gaussians = loaded.gaussians;
    assert_eq!((gaussians.len(), gaussians.degree()), (15, 3));
    let a = gaussians.attributes();
    let close =
        |found: f32, expected: f64| assert!((f64::from(found) - expected).abs() < 1e-6, "{found} {expected}");
    let same = [0.0, 0.5, -0.5];
    let scales = [
        same,
        same,
        same,
        [0.2, -0.1, 0.7],
        [1.0, -2.0, 3.0],
        [1.0, 0.0, -1.0],
        [2.0, -3.0, 4.0],
        [1.0, 0.0, -1.0],
        same,
        same,
        same,
        same,
        same,
        same,
        same,
    ];
    for i in 0..15 {
        assert_eq!(a.means[i], [1.0, 2.0, 3.0]);
        assert_eq!(a.rotations[i], [1.0, 0.0, 0.0, 0.0]);
        for (scale, logarithm) in a.scales[i].iter().zip(scales[i]) {
            let expected = f64::exp(logarithm);
            assert!(
                (f64::from(*scale) / expected - 1.0).abs() < 1e-6,
                "{i}: {scale} {expected}"
            );
        }
        let opacity = [0.75, 64.0 / 255.0, 16384.0 / 65535.0]
            .get(i.wrapping_sub(8))
            .copied();
        close(a.opacities[i], opacity.unwrap_or(0.25));
        let known = [1, 4, 9, 16][i.saturating_sub(11)];
        for (k, harmonics) in a.harmonics[16 * i..16 * i + 16].iter().enumerate() {
            for (c, value) in harmonics.iter().enumerate() {
                let written = k as f64 + 0.1 * (c + 1) as f64;
                close(*value / 10.0, if k < known { written / 10.0 } else { 0.0 });
            }
        }
    }
    // y up becomes z up.
    assert!((in_world(&gaussians)[0].mean - DVec3::new(1.0, -3.0, 2.0)).length() < 1e-12);
    let warnings = loaded.description.warnings.join("; ");
    assert!(
        warnings.contains("logarithms") && warnings.contains("linear"),
        "{warnings}"
    );
    assert_eq!(loaded.description.tags, ["linear"]);
}

#[test]
fn points_are_not_gaussians() {
    let Some(folder) = folder() else { return };
    let data = folder.parent().unwrap();
    for name in ["points/bunny.ply", "points/horse.ply", "volumes/tooth.nrrd"] {
        assert!(!is_gaussians(data.join(name)), "{name}");
    }
    let error = read_gaussians(data.join("points/bunny.ply"), &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("f_dc_0"), "{error}");
    let strict = ReadOptions {
        strict: true,
        ..ReadOptions::default()
    };
    assert!(read_gaussians(folder.join("pc_short.ply"), &strict).is_err());
    assert!(read_gaussians(folder.join("biker.spz"), &strict).is_ok());
}
