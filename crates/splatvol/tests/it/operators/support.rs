//! Volumes, operators and cameras of these tests.

use glam::{DVec3, Vec3};
use splatvol::{
    Appearance, Camera, ColorPoint, Grid, ImageSize, OpacityPoint, PixelOperator, Projection, RenderSettings,
    Rescale, Samples, SheetSample, TransferFunction, Volume,
};

/// Samples along each axis.
pub(crate) const SIDE: usize = 48;

/// Unlit default settings of a square picture.
pub(crate) fn unlit(pixels: u32) -> RenderSettings {
    RenderSettings {
        size: ImageSize::new(pixels, pixels).unwrap(),
        lighting: None,
        ..RenderSettings::default()
    }
}

/// A cube of unit voxels about the origin that samples a field.
pub(crate) fn volume(field: impl Fn(DVec3) -> f64) -> Volume {
    let grid = Grid::centred([SIDE; 3], DVec3::ONE).unwrap();
    let middle = 0.5 * (SIDE as f64 - 1.0);
    let samples = (0..SIDE.pow(3))
        .map(|i| {
            let place = [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
            field(DVec3::from_array(place.map(|n| n as f64 - middle))) as f32
        })
        .collect();
    Volume::new(
        grid,
        Samples::F32(samples),
        Rescale::default(),
        Default::default(),
    )
    .unwrap()
}

/// Radius minus distance from the middle.
pub(crate) fn ball(radius: f64) -> Volume {
    volume(|p| radius - p.length())
}

/// A bump of height 1 and this standard deviation.
pub(crate) fn gaussian(sigma: f64) -> Volume {
    volume(|p| (-0.5 * p.length_squared() / (sigma * sigma)).exp())
}

/// A step: nothing below a value, and this opacity per voxel from a tenth of a data unit above it on.
pub(crate) fn solid(value: f64, opacity: f64) -> TransferFunction {
    let opacities = vec![
        OpacityPoint::new(value, 0.0),
        OpacityPoint::new(value + 0.1, opacity),
    ];
    TransferFunction::new(vec![ColorPoint::new(0.0, [1.0; 3])], opacities, Some(1.0)).unwrap()
}

/// Cameras from a slanted direction, in both projections.
pub(crate) fn cameras() -> [Camera; 2] {
    let towards = DVec3::new(0.48, -0.6, 0.64);
    let up = DVec3::new(0.1, 0.2, 0.9);
    [
        Camera::new(
            140.0 * towards,
            DVec3::ZERO,
            up,
            Projection::Perspective { fov_degrees: 25.0 },
        )
        .unwrap(),
        Camera::new(
            140.0 * towards,
            DVec3::ZERO,
            up,
            Projection::Orthographic { height: 56.0 },
        )
        .unwrap(),
    ]
}

/// Does nothing.
#[derive(Debug)]
pub(crate) struct Identity;

impl PixelOperator for Identity {
    fn apply(&self, _: &SheetSample, _: &mut Appearance) {}
}

/// Colours material by its normal, world axes.
#[derive(Debug)]
pub(crate) struct NormalColors;

impl PixelOperator for NormalColors {
    fn apply(&self, _: &SheetSample, appearance: &mut Appearance) {
        appearance.color = 0.5 * appearance.normal + Vec3::splat(0.5);
    }
}

/// The normal of a pixel that [`NormalColors`] has coloured.
pub(crate) fn normal(pixel: [f32; 4]) -> DVec3 {
    let [r, g, b, a] = pixel.map(f64::from);
    DVec3::new(r, g, b) / a * 2.0 - DVec3::ONE
}
