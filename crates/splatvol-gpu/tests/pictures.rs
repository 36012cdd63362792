//! Pictures of the GPU engine against those of the CPU engine, and requests that it refuses.
#![allow(clippy::unwrap_used, reason = "tests")]

use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, Clip, Compositing, EngineConfig, FlatSettings, Frame, Image, ImageSize, Projection,
    RenderSettings, Renderer, Scene, View,
};
use splatvol_gpu::{GpuConfig, GpuEngine};
use splatvol_testing::{Tolerance, assert_images, checked};

/// A renderer on a GPU; without a driver the calling test is skipped.
fn gpu() -> Option<Renderer> {
    match GpuEngine::new(&GpuConfig::default()) {
        Ok(engine) => Some(Renderer::with_engine(engine)),
        Err(error) => {
            splatvol_recorded::skip(&error.to_string());
            None
        }
    }
}

fn scene(sample: Sample, edge: usize) -> Scene {
    let volume = sample.generate(Some(SampleSize::Dims([edge; 3]))).unwrap();
    Scene::new(volume, sample.default_transfer_function().unwrap())
}

fn sized(settings: RenderSettings, pixels: u32) -> RenderSettings {
    settings.with_size(ImageSize::new(pixels, pixels).unwrap())
}

fn camera(scene: &Scene, projection: Projection) -> Camera {
    Camera::framing(&scene.bounds().unwrap(), View::Iso, projection, 1.0).unwrap()
}

const PROJECTIONS: [Projection; 2] = [
    Projection::Perspective { fov_degrees: 30.0 },
    Projection::Orthographic { height: 1.0 },
];

/// Share of pixels of which no channel differs by more than a level of eight bits.
fn share_within_a_level(a: &Image, b: &Image) -> f64 {
    let near = |(p, q): (&[f32; 4], &[f32; 4])| (0..4).all(|c| (p[c] - q[c]).abs() <= 1.0 / 255.0);
    let count = a.pixels.iter().zip(&b.pixels).filter(|&both| near(both)).count();
    count as f64 / a.pixels.len() as f64
}

/// Law 3, as far as the CPU's narrower kernels along the ray allow: docs/numerics.md, "The GPU's planes", has what is measured.
#[test]
fn pictures_are_the_cpu_s() {
    let Some(mut gpu) = gpu() else { return };
    let mut cpu = Renderer::new(EngineConfig::default()).unwrap();
    for (sample, decibels, share) in [
        (Sample::Head, 49.0, 0.92),
        (Sample::Ball, 61.0, 0.94),
        (Sample::MarschnerLobb, 37.5, 0.55),
    ] {
        let scene = scene(sample, 32);
        for projection in PROJECTIONS {
            let camera = camera(&scene, projection);
            for (name, settings) in [
                ("fast", RenderSettings::fast()),
                ("balanced", RenderSettings::balanced()),
                ("draft", RenderSettings::draft()),
            ] {
                if name == "draft" && sample == Sample::MarschnerLobb {
                    // Half of its resolution does not hold its waves.
                    continue;
                }
                let settings = sized(settings, 64);
                let own = gpu.render(&scene, &camera, &settings).unwrap();
                let wanted = cpu.render(&scene, &camera, &settings).unwrap();
                let what = format!("gpu-{}-{name}", sample.name());
                // At half of the resolution edges are as steep, and twice as long.
                let (decibels, share) = match name {
                    "draft" => (decibels - 10.0, share - 0.25),
                    _ => (decibels, share),
                };
                assert_images(&what, &own.image, &wanted.image, Tolerance::psnr(decibels));
                let found = share_within_a_level(&own.image, &wanted.image);
                assert!(found >= share, "{what} {projection:?}: {found:.3}");
                assert_depths(&own, &wanted);
            }
        }
    }
}

/// Depths of opaque pixels agree within a thousandth in the median; at silhouettes of waves behind each other some do not.
fn assert_depths(own: &Frame, wanted: &Frame) {
    let opaque = |frame: &Frame, at: usize| frame.image.pixels[at][3] > 0.95;
    let mut both: Vec<f64> = (0..own.depth.len())
        .filter(|&at| opaque(own, at) && opaque(wanted, at))
        .map(|at| f64::from((own.depth[at] - wanted.depth[at]).abs() / wanted.depth[at]))
        .collect();
    both.sort_by(f64::total_cmp);
    let median = both.get(both.len() / 2).copied().unwrap_or(0.0);
    assert!(median < 1e-3, "{median:e}");
}

#[test]
fn pictures_are_repeated_to_the_bit_after_an_edit_and_back() {
    let Some(mut gpu) = gpu() else { return };
    let scene = scene(Sample::Head, 32);
    let camera = camera(&scene, PROJECTIONS[0]);
    let settings = sized(RenderSettings::fast(), 48);
    let first = gpu.render(&scene, &camera, &settings).unwrap();
    let mut other = scene.clone();
    *other.transfer_function_mut().unwrap() = splatvol_testing::transfer::constant_extinction(0.02, [0.4; 3]);
    let between = gpu.render(&other, &camera, &settings).unwrap();
    assert_ne!(first.image.pixels, between.image.pixels);
    // A renderer of another size between them.
    gpu.render(&scene, &camera, &sized(settings, 20)).unwrap();
    let again = gpu.render(&scene, &camera, &settings).unwrap();
    assert_eq!(first.image.pixels, again.image.pixels);
    assert_eq!(first.depth, again.depth);
    assert_eq!(gpu.statistics().engine, "gpu");
}

#[test]
fn what_is_not_drawn_is_refused_by_name() {
    let Some(mut gpu) = gpu() else { return };
    let scene = scene(Sample::Ball, 16);
    let outside = camera(&scene, PROJECTIONS[0]);
    let fast = sized(RenderSettings::fast(), 16);
    let mut refused = |scene: &Scene, camera: &Camera, settings: &RenderSettings, word: &str| {
        let error = gpu.render(scene, camera, settings).unwrap_err().to_string();
        assert!(error.contains(word), "{word}: {error}");
    };
    refused(
        &scene,
        &outside,
        &sized(RenderSettings::best(), 16),
        "analytic gradient",
    );
    let mip = checked(FlatSettings {
        compositing: Compositing::Mip,
        ..fast.into()
    });
    refused(&scene, &outside, &mip, "post-classified");
    refused(&scene, &outside, &sized(RenderSettings::swan1997(), 16), "sheets");
    let mut clipped = scene.clone();
    clipped
        .clips
        .push(Clip::plane([0.0; 3], [1.0, 0.0, 0.0]).unwrap());
    refused(&clipped, &outside, &fast, "clips");
    let within = Camera::new([0.1, 0.2, 0.3], [9.0; 3], [0.0, 0.0, 1.0], PROJECTIONS[0]).unwrap();
    refused(&scene, &within, &fast, "within the volume");
    let small = GpuConfig {
        budget: Some(1000),
        ..GpuConfig::default()
    };
    let mut small = Renderer::with_engine(GpuEngine::new(&small).unwrap());
    let error = small.render(&scene, &outside, &fast).unwrap_err().to_string();
    assert!(error.contains("budget"), "{error}");
    let none = GpuConfig {
        adapter: Some("no such adapter".to_owned()),
        ..GpuConfig::default()
    };
    let error = GpuEngine::new(&none).unwrap_err().to_string();
    assert!(error.contains("no such adapter"), "{error}");
}
