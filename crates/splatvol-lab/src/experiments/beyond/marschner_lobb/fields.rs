//! Fields over Marschner-Lobb samples, and their distance from the signal.

use glam::DVec3;
use rayon::prelude::*;
use splatvol::{Kernel, Volume};
use splatvol_core::radial::RadialKernel;
use splatvol_reference::Reconstruction;
use splatvol_testing::fields::MarschnerLobb;
use splatvol_testing::{Field, Random};

use super::super::radial_field::RadialField;
use super::{SIDE, SPACING};
use crate::LabError;

/// A field over the samples; x in voxels.
pub(super) trait Interpolant: Sync {
    fn value(&self, x: DVec3) -> f64;
    /// Its gradient, up to a positive factor.
    fn gradient(&self, x: DVec3) -> DVec3;
}

impl Interpolant for RadialField {
    fn value(&self, x: DVec3) -> f64 {
        RadialField::value(self, x)
    }

    fn gradient(&self, x: DVec3) -> DVec3 {
        RadialField::gradient(self, x)
    }
}

impl Interpolant for Reconstruction {
    fn value(&self, x: DVec3) -> f64 {
        Reconstruction::value(self, x)
    }

    fn gradient(&self, x: DVec3) -> DVec3 {
        self.sums(x).grad_s
    }
}

pub(super) struct Trilinear(Vec<f64>);

impl Trilinear {
    pub(super) fn new(volume: &Volume) -> Self {
        Self((0..SIDE.pow(3)).map(|index| volume.value(index)).collect())
    }
}

impl Interpolant for Trilinear {
    fn value(&self, x: DVec3) -> f64 {
        let cell = x.floor().clamp(DVec3::ZERO, DVec3::splat(SIDE as f64 - 2.0));
        let t = x - cell;
        let [i, j, k] = cell.to_array().map(|c| c as usize);
        let corner = |corner: usize| {
            let [a, b, c] = [corner & 1, (corner >> 1) & 1, corner >> 2];
            let weight = |far: usize, t: f64| if far == 1 { t } else { 1.0 - t };
            let weights = weight(a, t.x) * weight(b, t.y) * weight(c, t.z);
            weights * self.0[((k + c) * SIDE + j + b) * SIDE + i + a]
        };
        (0..8).map(corner).sum()
    }

    /// Central differences over two voxels, as ray casters take them.
    fn gradient(&self, x: DVec3) -> DVec3 {
        let slope = |axis: DVec3| self.value(x + axis) - self.value(x - axis);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
    }
}

/// The field of a kernel: Gaussians as the reference has them, others as functions of the distance.
pub(super) fn interpolant(
    volume: &Volume,
    kernel: Kernel,
    prefilter: bool,
) -> Result<Box<dyn Interpolant>, LabError> {
    if kernel.gaussian().is_some() {
        let field = Reconstruction::new(volume, &kernel, prefilter);
        return Ok(Box::new(
            field.map_err(|error| LabError::Reference(error.to_string()))?,
        ));
    }
    let samples = Trilinear::new(volume).0;
    let kernel = RadialKernel::new(kernel);
    Ok(Box::new(RadialField::new(kernel, &samples, SIDE, prefilter)?))
}

/// Seeded points of the box, in voxels.
pub(super) fn points(count: usize) -> Vec<DVec3> {
    let mut random = Random::new(41);
    let last = DVec3::splat(SIDE as f64 - 1.0);
    (0..count).map(|_| random.point(DVec3::ZERO, last)).collect()
}

pub(super) fn world(x: DVec3) -> DVec3 {
    x * SPACING - 1.0
}

/// Errors of a field; values relative to the signal's range, which is 1.
pub(super) struct Errors {
    /// Signal-to-error ratio: the range over the root mean square error, decibels.
    pub(super) psnr: f64,
    pub(super) largest: f64,
    /// Mean angle between gradients, degrees.
    pub(super) angle: f64,
}

pub(super) fn measure(field: &dyn Interpolant, points: &[DVec3]) -> Errors {
    let signal = MarschnerLobb::default();
    let each: Vec<[f64; 2]> = points
        .par_iter()
        .map(|&x| {
            let error = field.value(x) - signal.value(world(x));
            let angle = field.gradient(x).angle_between(signal.gradient(world(x)));
            [error, angle.to_degrees()]
        })
        .collect();
    let count = points.len() as f64;
    let squares: f64 = each.iter().map(|[error, _]| error * error).sum();
    Errors {
        psnr: -10.0 * (squares / count).log10(),
        largest: each.iter().fold(0.0, |most, [error, _]| error.abs().max(most)),
        angle: each.iter().map(|[_, angle]| angle).sum::<f64>() / count,
    }
}
