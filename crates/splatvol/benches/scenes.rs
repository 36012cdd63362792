//! Frames of scenes, everything prepared: a volume alone, the same beside a cloud of points, and clouds alone.
//!
//! ```text
//! cargo bench -p splatvol --bench scenes
//! ```
//!
//! The extra cost of a layer is the difference between two of these lines.
#![allow(clippy::unwrap_used, reason = "a bench")]

use std::sync::Arc;

use divan::Bencher;
use glam::{DAffine3, DVec3};
use splatvol::{
    Camera, Content, EngineConfig, Frame, GaussianAttributes, GaussianMode, Gaussians, Grid, ImageSize, Item,
    LengthUnit, PointAttributes, PointLook, Points, Projection, RenderSettings, Renderer, Rescale, Samples,
    Scene, View, Volume,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::Random;

fn main() {
    divan::main();
}

fn head() -> Item {
    let volume = Sample::Head.generate(Some(SampleSize::Longest(128))).unwrap();
    Item::volume(volume, Sample::Head.default_transfer_function().unwrap())
}

/// Every eighth slice of the head: long voxels, which are refined.
fn slices() -> Item {
    const APART: usize = 8;
    let volume = Sample::Head.generate(Some(SampleSize::Longest(128))).unwrap();
    let [nx, ny, nz] = volume.grid().dims();
    let slices = (0..nz).step_by(APART);
    let dims = [nx, ny, slices.len()];
    let values = slices.flat_map(|z| (z * nx * ny..(z + 1) * nx * ny).map(|i| volume.value(i) as f32));
    let samples = Samples::F32(values.collect());
    let spacing = volume.grid().spacing() * DVec3::new(1.0, 1.0, APART as f64);
    let grid = Grid::centred(dims, spacing).unwrap();
    let thick = Volume::new(grid, samples, Rescale::default(), LengthUnit::Millimetre).unwrap();
    Item::volume(thick, Sample::Head.default_transfer_function().unwrap())
}

/// A sphere of this many surfels beside the head.
fn sphere(count: usize) -> Item {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let positions: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let radius = (1.0 - z * z).sqrt();
            let (sin, cos) = (golden * i as f64).sin_cos();
            [radius * cos, radius * sin, z].map(|v| v as f32)
        })
        .collect();
    let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt() as f32;
    let attributes = PointAttributes {
        normals: positions.clone(),
        radii: vec![spacing; count],
        ..PointAttributes::default()
    };
    let points = Points::new(positions, attributes, DAffine3::IDENTITY).unwrap();
    let content = Content::Points {
        points: Arc::new(points),
        look: PointLook::default(),
    };
    Item {
        world_from_item: DAffine3::from_translation(DVec3::new(160.0, 0.0, 0.0))
            * DAffine3::from_scale(DVec3::splat(60.0)),
        ..Item::new(content)
    }
}

/// Gaussians of all shapes in a cube.
fn gaussians(count: usize) -> Item {
    let mut random = Random::new(7);
    let mut attributes = GaussianAttributes::default();
    for _ in 0..count {
        let mean = random.point(DVec3::splat(-80.0), DVec3::splat(80.0));
        attributes.means.push(mean.as_vec3().to_array());
        let scales = std::array::from_fn(|_| random.range(0.3, 2.0) as f32);
        attributes.scales.push(scales);
        let [x, y, z] = random.direction().as_vec3().to_array();
        attributes
            .rotations
            .push([x, y, z, random.range(-1.0, 1.0) as f32]);
        attributes.opacities.push(random.range(0.2, 0.95) as f32);
        attributes.harmonics.push([random.range(-1.7, 1.7) as f32; 3]);
    }
    Item::new(Content::Gaussians(Arc::new(
        Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap(),
    )))
}

/// Frames of a scene, 512 x 512, from a camera that moves a little.
fn frames(bencher: Bencher<'_, '_>, items: Vec<Item>) {
    let scene = Scene::of_items(items).unwrap();
    let projection = Projection::Perspective { fov_degrees: 30.0 };
    let framed = Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.1).unwrap();
    let settings = RenderSettings {
        size: ImageSize::new(512, 512).unwrap(),
        gaussians: GaussianMode::Volumetric,
        ..RenderSettings::default()
    };
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let mut frame = Frame::empty(settings.size);
    renderer
        .render_into(&scene, &framed, &settings, &mut frame)
        .unwrap();
    bencher.bench_local(|| {
        renderer
            .render_into(&scene, &framed, &settings, &mut frame)
            .unwrap();
    });
}

#[divan::bench]
fn head_alone(bencher: Bencher<'_, '_>) {
    frames(bencher, vec![head()]);
}

#[divan::bench]
fn slices_alone(bencher: Bencher<'_, '_>) {
    frames(bencher, vec![slices()]);
}

#[divan::bench(args = [10_000, 100_000])]
fn surfels_alone(bencher: Bencher<'_, '_>, count: usize) {
    frames(bencher, vec![sphere(count)]);
}

#[divan::bench(args = [10_000, 100_000])]
fn head_beside_surfels(bencher: Bencher<'_, '_>, count: usize) {
    frames(bencher, vec![head(), sphere(count)]);
}

#[divan::bench]
fn volumetric_gaussians(bencher: Bencher<'_, '_>) {
    frames(bencher, vec![gaussians(100_000)]);
}
