//! What tests of the GPU engine share.

use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, EngineConfig, Frame, Image, ImageSize, Projection, RenderSettings, Renderer, Scene, View,
};
use splatvol_gpu::{GpuConfig, GpuEngine, GpuError};
use splatvol_testing::{Tolerance, assert_images};

/// A renderer on a GPU; without a driver the calling test is skipped.
pub(crate) fn gpu_of(config: &GpuConfig) -> Option<Renderer> {
    match GpuEngine::new(config) {
        Ok(engine) => Some(Renderer::with_engine(engine)),
        Err(error @ GpuError::NoAdapter { .. }) => {
            splatvol_recorded::skip(&error.to_string());
            None
        }
        Err(error) => panic!("{error}"),
    }
}

pub(crate) fn gpu() -> Option<Renderer> {
    gpu_of(&GpuConfig::default())
}

/// Renderers on a GPU and on the processor.
pub(crate) fn both() -> Option<(Renderer, Renderer)> {
    Some((gpu()?, Renderer::new(EngineConfig::default()).unwrap()))
}

pub(crate) fn scene(sample: Sample, edge: usize) -> Scene {
    let volume = sample.generate(Some(SampleSize::Dims([edge; 3]))).unwrap();
    Scene::new(volume, sample.default_transfer_function().unwrap())
}

pub(crate) fn sized(settings: RenderSettings, pixels: u32) -> RenderSettings {
    settings.with_size(ImageSize::new(pixels, pixels).unwrap())
}

pub(crate) fn camera(scene: &Scene, projection: Projection) -> Camera {
    Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.0).unwrap()
}

pub(crate) const PROJECTIONS: [Projection; 2] = [
    Projection::Perspective { fov_degrees: 30.0 },
    Projection::Orthographic { height: 1.0 },
];

/// Share of pixels of which no channel differs by more than a level of eight bits.
pub(crate) fn share_within_a_level(a: &Image, b: &Image) -> f64 {
    let near = |(p, q): (&[f32; 4], &[f32; 4])| (0..4).all(|c| (p[c] - q[c]).abs() <= 1.0 / 255.0);
    let count = a.pixels.iter().zip(&b.pixels).filter(|&both| near(both)).count();
    count as f64 / a.pixels.len() as f64
}

pub(crate) fn compare(
    (gpu, cpu): (&mut Renderer, &mut Renderer),
    (scene, camera, settings): (&Scene, &Camera, &RenderSettings),
    what: &str,
    (decibels, share, depth): (f64, f64, f64),
) {
    let own = gpu.render(scene, camera, settings).unwrap();
    let wanted = cpu.render(scene, camera, settings).unwrap();
    assert_images(what, &own.image, &wanted.image, Tolerance::psnr(decibels));
    let found = share_within_a_level(&own.image, &wanted.image);
    assert!(found >= share, "{what}: {found:.4}");
    assert_depths(&own, &wanted, depth);
}

/// Depths of opaque pixels agree within so much in the median; at silhouettes of waves behind each other some do not.
pub(crate) fn assert_depths(own: &Frame, wanted: &Frame, most: f64) {
    let opaque = |frame: &Frame, at: usize| frame.image.pixels[at][3] > 0.95;
    let mut both: Vec<f64> = (0..own.depth.len())
        .filter(|&at| opaque(own, at) && opaque(wanted, at))
        .map(|at| f64::from((own.depth[at] - wanted.depth[at]).abs() / wanted.depth[at]))
        .collect();
    both.sort_by(f64::total_cmp);
    let median = both.get(both.len() / 2).copied().unwrap_or(0.0);
    assert!(median < most, "{median:e}");
}
