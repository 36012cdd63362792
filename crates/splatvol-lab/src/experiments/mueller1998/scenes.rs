//! Scenes, settings and pictures that several experiments share.

use glam::DVec3;
use splatvol::{
    Camera, Filter, FlatSettings, Image, ImageSize, Motion, MotionBlur, Projection, RenderSettings, Scene,
};
use splatvol_samples::{Sample, SampleSize};

use crate::LabError;

/// A sample of some size with its own look.
pub(super) fn scene(sample: Sample, dims: [usize; 3]) -> Result<Scene, LabError> {
    let volume = sample.generate(Some(SampleSize::Dims(dims)))?;
    Ok(Scene::new(volume, sample.default_transfer_function()?))
}

/// The paper's method, without motion blur: Crawfis-Max splats one by one, each aligned by an error budget; unlit, as
/// its splats have the colours of the data.
pub(super) fn settings([width, height]: [u32; 2], filter: Filter) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings::try_from(FlatSettings {
        size: ImageSize::new(width, height)?,
        filter,
        motion_blur: MotionBlur::None,
        lighting: None,
        ..RenderSettings::mueller1998().into()
    })?)
}

/// The paper's four pictures: plain, anti-aliased, motion-blurred, both.
pub(super) const FOUR: [(&str, Filter, MotionBlur); 4] = [
    ("plain", Filter::None, MotionBlur::None),
    ("anti-aliased", Filter::SwanAlpha, MotionBlur::None),
    ("motion-blurred", Filter::None, MotionBlur::Capsule),
    ("both", Filter::SwanAlpha, MotionBlur::Capsule),
];

/// This scene made fainter by a factor, so that splats only add up.
pub(super) fn made_faint(scene: &Scene, factor: f64) -> Result<Scene, LabError> {
    let mut scene = scene.clone();
    let distance = factor * scene.single_volume()?.unit_distance();
    scene.transfer_function_mut()?.unit_distance = Some(distance);
    Ok(scene)
}

/// Vertical field of view of the pictures of things that spin, degrees.
const FOV: f64 = 30.0;

/// Looks down on a terrain of `side` voxels, whose ground fills the picture at any turn.
pub(super) fn above_terrain(scene: &Scene, side: f64) -> Result<Camera, LabError> {
    let target = scene.bounds()?.centre() - DVec3::Z * 0.05 * side;
    let elevation = 50_f64.to_radians();
    let towards = DVec3::new(0.0, -elevation.cos(), elevation.sin());
    let projection = Projection::Perspective { fov_degrees: FOV };
    Ok(Camera::new(
        target + 1.02 * side * towards,
        target,
        DVec3::Z,
        projection,
    )?)
}

/// Spins a scene about its vertical axis by this many degrees while the shutter is open.
pub(super) fn spinning(scene: Scene, degrees: f64) -> Result<Scene, LabError> {
    let motion = Motion::Spin {
        axis: DVec3::Z,
        centre: scene.bounds()?.centre(),
        angle: degrees.to_radians(),
    };
    Ok(scene.with_motion(&motion))
}

/// The mean of each block of `n` by `n` pixels, taken `down` pixels farther down; the border repeats.
pub(super) fn averaged(image: &Image, n: usize, down: isize) -> Result<Image, LabError> {
    let [width, height] = <[u32; 2]>::from(image.size()).map(|side| side as usize / n);
    let row = |y: usize| y.saturating_add_signed(down).min(n * height - 1);
    let mean = |index: usize| {
        let (x, y) = (index % width * n, index / width * n);
        let mut sum = [0.0; 4];
        for part in 0..n * n {
            let pixel = image.pixel(x + part % n, row(y + part / n));
            sum = std::array::from_fn(|c| sum[c] + f64::from(pixel[c]));
        }
        sum.map(|value| (value / (n * n) as f64) as f32)
    };
    let pixels = (0..width * height).map(mean).collect();
    Ok(Image::from_pixels(
        ImageSize::new(width as u32, height as u32)?,
        pixels,
    )?)
}

/// Each pixel as a block of `n` by `n`.
pub(super) fn enlarged(image: &Image, n: usize) -> Result<Image, LabError> {
    let [width, height] = <[u32; 2]>::from(image.size()).map(|side| side as usize * n);
    let pixels = (0..width * height).map(|index| image.pixel(index % width / n, index / width / n));
    Ok(Image::from_pixels(
        ImageSize::new(width as u32, height as u32)?,
        pixels.collect(),
    )?)
}

/// Unsteadiness in time: the squared difference of a value from the mean of those before and after it, times 2/3. Its
/// mean over noise is the noise's variance.
pub(super) fn unsteadiness([before, now, after]: [f64; 3]) -> f64 {
    (now - 0.5 * (before + after)).powi(2) / 1.5
}
