//! Scenes and cameras of these tests, and a renderer that vouches for the engine it took.

use glam::{DMat3, DVec3, EulerRot};
use splatvol::{
    Camera, ColorPoint, EngineConfig, Frame, Grid, ImageSize, OpacityPoint, Projection, RenderSettings,
    RenderStatistics, Renderer, Scene, TransferFunction, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::fields::Noise;
use splatvol_testing::sample;

/// Fast settings of a picture of this size.
pub(crate) fn fast(width: u32, height: u32) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(width, height).unwrap(),
        ..RenderSettings::fast()
    }
}

/// A sample with its own transfer function.
pub(crate) fn generated(kind: Sample, longest: usize) -> Scene {
    let volume = kind.generate(Some(SampleSize::Longest(longest))).unwrap();
    Scene::new(volume, kind.default_transfer_function().unwrap())
}

/// A translucent look of values from 0 to 1.
pub(crate) fn translucent() -> TransferFunction {
    let colors = vec![
        ColorPoint::new(0.0, [0.2, 0.4, 0.8]),
        ColorPoint::new(0.5, [0.9, 0.5, 0.2]),
        ColorPoint::new(1.0, [1.0, 0.95, 0.8]),
    ];
    let opacities = vec![
        OpacityPoint::new(0.3, 0.0),
        OpacityPoint::new(0.5, 0.1),
        OpacityPoint::new(0.7, 0.6),
    ];
    TransferFunction::new(colors, opacities, None).unwrap()
}

/// The middle of the scene's values as an opaque surface.
pub(crate) fn opaque(scene: &Scene) -> Scene {
    let [low, high] = scene.single_volume().unwrap().volume.value_range();
    let at = |t: f64| low + t * (high - low);
    let opacities = vec![OpacityPoint::new(at(0.4), 0.0), OpacityPoint::new(at(0.6), 0.95)];
    let colors = vec![
        ColorPoint::new(at(0.4), [0.9, 0.7, 0.4]),
        ColorPoint::new(at(0.9), [0.3, 0.6, 0.9]),
    ];
    Scene::new(
        scene.single_volume().unwrap().volume.clone(),
        TransferFunction::new(colors, opacities, None).unwrap(),
    )
}

/// Band-limited noise on a rotated grid of three different spacings.
pub(crate) fn noise() -> Scene {
    let noise = Noise::new(7, 40, DVec3::new(1.2, 1.2, 0.6));
    let direction = DMat3::from_euler(EulerRot::XYZ, 0.3, 0.5, -0.2);
    let grid = Grid::new(
        [32, 40, 18],
        DVec3::new(-10.0, 3.0, 5.0),
        DVec3::new(1.0, 0.8, 2.1),
        direction,
    )
    .unwrap();
    Scene::new(sample(&noise, &grid), translucent())
}

/// A camera that frames the scene, `zoom` times closer.
pub(crate) fn framing(scene: &Scene, projection: Projection, aspect: f64, zoom: f64) -> Camera {
    let bounds = scene.bounds().unwrap();
    let camera = Camera::framing(&bounds, View::Iso, projection, aspect).unwrap();
    match camera.projection() {
        Projection::Orthographic { height } => Camera::new(
            camera.position(),
            camera.target(),
            camera.up(),
            Projection::Orthographic {
                height: height / zoom,
            },
        )
        .unwrap(),
        projection @ Projection::Perspective { .. } => {
            let away = (camera.position() - camera.target()) / zoom;
            Camera::new(camera.target() + away, camera.target(), camera.up(), projection).unwrap()
        }
    }
}

/// An engine of the default configuration.
pub(crate) fn renderer() -> Renderer {
    Renderer::new(EngineConfig::default()).unwrap()
}

/// A frame that the fast engine certainly rendered: only that engine takes sheets out of a ring.
pub(crate) fn rendered(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
) -> (Frame, RenderStatistics) {
    let frame = renderer.render(scene, camera, settings).unwrap();
    let statistics = renderer.statistics().clone();
    assert!(
        statistics.seconds.take > 0.0,
        "the fast engine left this frame to the other one: {camera:?}"
    );
    (frame, statistics)
}

/// A frame by a fast engine of its own.
pub(crate) fn render(scene: &Scene, camera: &Camera, settings: &RenderSettings) -> Frame {
    rendered(&mut renderer(), scene, camera, settings).0
}

/// Every number of a frame, to the bit.
pub(crate) fn bits(frame: &Frame) -> Vec<u32> {
    let colors = frame.image.pixels.iter().flatten();
    colors
        .chain(&frame.depth)
        .chain(&frame.optical_depth)
        .map(|value| value.to_bits())
        .collect()
}

/// Name of a projection, for figures.
pub(crate) fn name_of(projection: Projection) -> &'static str {
    match projection {
        Projection::Perspective { .. } => "perspective",
        Projection::Orthographic { .. } => "orthographic",
    }
}
