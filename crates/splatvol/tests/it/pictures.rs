//! Pictures as they are today, against pictures as they were.

use crate::common::{PROJECTIONS, render, settings};
use splatvol::{Camera, Classification, Compositing, FlatSettings, RenderSettings, Scene, View};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Tolerance, assert_snapshot, checked};

fn assert_picture(name: &str, sample: Sample, settings: &RenderSettings) {
    let volume = sample.generate(Some(SampleSize::Longest(64))).unwrap();
    let scene = Scene::new(volume, sample.default_transfer_function().unwrap());
    let bounds = scene.bounds().unwrap();
    let view = sample.preferred_view().unwrap_or(View::Iso);
    let camera = Camera::framing(&bounds, view, PROJECTIONS[0], 1.0).unwrap();
    let frame = render(&scene, &camera, settings);
    // 16-bit sRGB snapshots resolve 80 dB; SIMD levels differ in the order of roundings only.
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/snapshots");
    assert_snapshot(folder, name, &frame.image, Tolerance::psnr(60.0).max_error(0.02));
}

#[test]
fn head_post_classified() {
    assert_picture("head", Sample::Head, &settings(160));
}

#[test]
fn head_pre_classified() {
    let settings = checked(FlatSettings {
        classification: Classification::Pre,
        ..settings(160).into()
    });
    assert_picture("head-pre", Sample::Head, &settings);
}

#[test]
fn head_x_ray() {
    let settings = checked(FlatSettings {
        compositing: Compositing::Xray,
        ..settings(160).into()
    });
    assert_picture("head-xray", Sample::Head, &settings);
}

#[test]
fn shells_maximum() {
    let settings = checked(FlatSettings {
        compositing: Compositing::Mip,
        ..settings(160).into()
    });
    assert_picture("shells-mip", Sample::Shells, &settings);
}

#[test]
fn marschner_lobb() {
    assert_picture("marschner-lobb", Sample::MarschnerLobb, &settings(160));
}

#[test]
fn tunnel() {
    assert_picture("tunnel", Sample::Tunnel, &settings(160));
}
