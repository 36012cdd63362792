//! Scenes, cameras and settings that several of these experiments render.

use glam::DVec3;
use splatvol::{
    Camera, Classification, ColorPoint, Filter, FlatSettings, Grid, Image, ImageSize, Kernel, OpacityPoint,
    Projection, RenderSettings, Scene, TransferFunction,
};
use splatvol_testing::fields::Noise;
use splatvol_testing::sample;

use crate::LabError;

/// A Gaussian cut so late (at five standard deviations) that the cut is below anything measured. It is so wide that the
/// engines' unit integral and the reference's unit sum over the lattice are the same to 4e-7.
pub(super) const SMOOTH: Kernel = Kernel::Gaussian {
    sigma: 0.9,
    radius: 4.5,
};

/// Settings of a square picture of classified, unlit, unfiltered splats that are never left out.
pub(super) fn colors(pixels: u32, kernel: Kernel) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings::try_from(FlatSettings {
        size: ImageSize::new(pixels, pixels)?,
        classification: Classification::Pre,
        filter: Filter::None,
        kernel,
        prefilter: false,
        lighting: None,
        termination: 0.0,
        ..RenderSettings::best().into()
    })?)
}

/// An orthographic camera that looks at the origin from a direction, showing `height` world units.
pub(super) fn orthographic(from: DVec3, up: DVec3, height: f64) -> Result<Camera, LabError> {
    let position = 500.0 * from.normalize();
    let projection = Projection::Orthographic { height };
    Ok(Camera::new(position, DVec3::ZERO, up, projection)?)
}

/// A look of values from 0 to 1, from nothing below 0.4 to `opacity` per voxel from 0.65 on; colour runs with the
/// value.
pub(super) fn look(opacity: f64) -> Result<TransferFunction, LabError> {
    let colors = vec![
        ColorPoint::new(0.4, [0.15, 0.35, 0.8]),
        ColorPoint::new(0.6, [0.95, 0.55, 0.15]),
        ColorPoint::new(0.85, [1.0, 0.95, 0.8]),
    ];
    let opacities = vec![OpacityPoint::new(0.4, 0.0), OpacityPoint::new(0.65, opacity)];
    Ok(TransferFunction::new(colors, opacities, Some(1.0))?)
}

/// Seeded noise of waves longer than four voxels in a cube of `side` voxels of size 1, fading out towards a ball's rim,
/// in [`look`].
pub(super) fn noise_ball(side: usize, opacity: f64) -> Result<Scene, LabError> {
    let grid = Grid::centred([side; 3], DVec3::ONE)?;
    let field = NoiseBall {
        noise: Noise::new(45, 40, DVec3::splat(1.4)),
        radius: 0.5 * side as f64 - 2.0,
    };
    Ok(Scene::new(sample(&field, &grid), look(opacity)?))
}

struct NoiseBall {
    noise: Noise,
    radius: f64,
}

impl splatvol_testing::Field for NoiseBall {
    fn value(&self, world: DVec3) -> f64 {
        let inside = 1.0 - (world.length() / self.radius).powi(4);
        self.noise.value(world) * inside.max(0.0)
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        let [r4, slope] = [(world.length() / self.radius).powi(4), 4.0 / self.radius.powi(4)];
        let fade = -slope * world.length_squared() * world;
        match r4 < 1.0 {
            true => self.noise.gradient(world) * (1.0 - r4) + self.noise.value(world) * fade,
            false => DVec3::ZERO,
        }
    }
}

/// Root-mean-square difference of two pictures over all channels.
pub(super) fn rms(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let squares: f64 = pairs.map(|(p, q)| f64::from(p - q).powi(2)).sum();
    (squares / (4 * a.pixels.len()).max(1) as f64).sqrt()
}

/// The difference of two pictures' colours, `gain` times, around middle grey.
pub(super) fn difference(a: &Image, b: &Image, gain: f32) -> Image {
    let mut shown = a.clone();
    for (pixel, (p, q)) in shown.pixels.iter_mut().zip(a.pixels.iter().zip(&b.pixels)) {
        for c in 0..3 {
            pixel[c] = (0.2 + gain * (p[c] - q[c])).clamp(0.0, 1.0);
        }
        pixel[3] = 1.0;
    }
    shown
}

/// A picture over dark grey, for viewing.
pub(super) fn shown(image: &Image) -> Image {
    image.over([0.01, 0.01, 0.01, 1.0])
}

/// A picture of brightness, 0 to 1 linear.
pub(super) fn grey(values: impl IntoIterator<Item = f64>, side: u32) -> Result<Image, LabError> {
    let pixels = values.into_iter().map(|value| {
        let level = value.clamp(0.0, 1.0) as f32;
        [level, level, level, 1.0]
    });
    Ok(Image::from_pixels(ImageSize::new(side, side)?, pixels.collect())?)
}
