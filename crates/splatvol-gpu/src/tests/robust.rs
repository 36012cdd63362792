//! Devices that are lost, refuse memory or have the limits of a browser's.

use glam::{DAffine3, DVec3};
use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, ImageSize, Item, PointAttributes, PointLook, Points, Projection, RenderSettings, Renderer, Scene,
    View,
};

use super::device;
use crate::device::{GpuConfig, GpuDevice};
use crate::engine::GpuEngine;

fn shot(edge: usize, pixels: u32) -> (Scene, Camera, RenderSettings) {
    let volume = Sample::Head.generate(Some(SampleSize::Dims([edge; 3]))).unwrap();
    let scene = Scene::new(volume, Sample::Head.default_transfer_function().unwrap());
    let projection = Projection::Perspective { fov_degrees: 30.0 };
    let camera = Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.0).unwrap();
    let settings = RenderSettings::fast().with_size(ImageSize::new(pixels, pixels).unwrap());
    (scene, camera, settings)
}

/// The same, with points in front of it.
fn with_points(
    (mut scene, camera, settings): (Scene, Camera, RenderSettings),
) -> (Scene, Camera, RenderSettings) {
    let bounds = scene.bounds().unwrap();
    let (step, count) = (bounds.diagonal() / 60.0, 1000);
    let place = |i: usize| {
        let at = [i % 10, i / 10 % 10, i / 100].map(|n| step * n as f64);
        (bounds.min + DVec3::from_array(at)).as_vec3().to_array()
    };
    let attributes = PointAttributes {
        radii: vec![step as f32; count],
        ..PointAttributes::default()
    };
    let points = Points::new((0..count).map(place).collect(), attributes, DAffine3::IDENTITY);
    scene
        .items
        .push(Item::points(points.unwrap(), PointLook::default()));
    (scene, camera, settings)
}

#[test]
fn a_lost_device_is_an_error() {
    let Some(gpu) = device() else { return };
    let own = gpu.device.clone();
    let mut renderer = Renderer::with_engine(GpuEngine::on(gpu).unwrap());
    let (scene, camera, settings) = shot(24, 32);
    renderer.render(&scene, &camera, &settings).unwrap();
    own.destroy();
    for _ in 0..2 {
        let error = renderer.render(&scene, &camera, &settings).unwrap_err();
        assert!(error.to_string().contains("lost"), "{error}");
    }
    let (mixed, ..) = with_points(shot(24, 32));
    assert!(renderer.render(&mixed, &camera, &settings).is_err());
    // Shaders that are still to be compiled, and other sizes.
    let best = RenderSettings::best().with_size(ImageSize::new(20, 20).unwrap());
    assert!(renderer.render(&scene, &camera, &best).is_err());
}

/// Limits of WebGPU's defaults suffice; with less, pictures are the same or errors.
#[test]
fn small_limits_give_the_same_picture_or_an_error() {
    let Some(gpu) = device() else { return };
    let mut whole = Renderer::with_engine(GpuEngine::on(gpu).unwrap());
    for (scene, camera, settings) in [shot(64, 64), with_points(shot(32, 100))] {
        let wanted = whole.render(&scene, &camera, &settings).unwrap();
        let usual = wgpu::Limits::default();
        let [buffer, binding] = [usual.max_buffer_size, usual.max_storage_buffer_binding_size];
        for (share, must) in [(1, true), (10, true), (1000, false), (100_000, false)] {
            let limits = (buffer / share, binding / share);
            let gpu = pollster::block_on(GpuDevice::open_with(&GpuConfig::default(), |_| limits)).unwrap();
            let mut renderer = Renderer::with_engine(GpuEngine::on(gpu).unwrap());
            match renderer.render(&scene, &camera, &settings) {
                Ok(found) => assert!(found.image.pixels == wanted.image.pixels, "{share}"),
                Err(error) => assert!(!must, "{share}: {error}"),
            }
        }
    }
}
