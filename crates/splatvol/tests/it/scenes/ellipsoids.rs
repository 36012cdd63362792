//! Clouds on sheets against the f64 integral of the same kernels.

use std::sync::Arc;

use glam::{DVec3, Mat3, Quat, Vec3};
use splatvol::{Camera, Content, Filter, FlatSettings, GaussianMode, Gaussians, Item, RenderSettings};
use splatvol_reference::ellipsoids::{self, Ellipsoid};
use splatvol_testing::{Comparison, Random, checked};

use super::support::{cloud, picture, unlit};
use crate::common::{orthographic, perspective};

/// sRGB to linear light (IEC 61966-2-1).
fn linear_light(level: f64) -> f64 {
    if level <= 0.040_45 {
        level.max(0.0) / 12.92
    } else {
        ((level + 0.055) / 1.055).powf(2.4)
    }
}

/// The kernels of Gaussians as a camera sees them: their opacities are those of their peaks in every
/// view.
fn kernels(gaussians: &Gaussians, camera: &Camera) -> Vec<Ellipsoid> {
    let attributes = gaussians.attributes();
    let camera_from_world = camera.camera_from_world();
    (0..gaussians.len())
        .map(|i| {
            let rotation = Mat3::from_quat(Quat::from_array(attributes.rotations[i]));
            let axes = (rotation * Mat3::from_diagonal(Vec3::from_array(attributes.scales[i]))).as_dmat3();
            let centre = DVec3::from_array(attributes.means[i].map(f64::from));
            let covariance = axes * axes.transpose();
            let towards = match camera.projection() {
                splatvol::Projection::Perspective { .. } => (centre - camera.position()).normalize(),
                splatvol::Projection::Orthographic { .. } => {
                    camera_from_world.inverse().transform_vector3(DVec3::Z)
                }
            };
            let depth = -(1.0 - f64::from(attributes.opacities[i])).ln();
            let own = &attributes.harmonics[i];
            Ellipsoid {
                centre,
                covariance,
                mass: Ellipsoid::mass_of_peak(covariance, towards, depth),
                color: splatvol::harmonics::color(0, &[*own], [0.0, 0.0, 1.0])
                    .map(|level| linear_light(f64::from(level))),
            }
        })
        .collect()
}

/// Wide kernels that cross each other, near and far, from inside the cloud, too, and at a wide angle.
#[test]
fn clouds_on_sheets_agree_with_the_integral() {
    let gaussians = cloud(60, [0.12, 0.4], 31);
    let settings = checked(FlatSettings {
        gaussians: GaussianMode::Volumetric,
        filter: Filter::None,
        sheet_thickness: 0.1,
        termination: 1e-4,
        ..unlit(48, 48).into()
    });
    let item = Item::new(Content::Gaussians(Arc::new(gaussians.clone())));
    for (name, camera, least) in [
        (
            "from afar",
            perspective(DVec3::ZERO, DVec3::new(1.0, -2.0, 0.5), 6.0, 30.0),
            50.0,
        ),
        (
            "parallel",
            orthographic(DVec3::ZERO, DVec3::new(-1.0, 0.3, 2.0), 3.0),
            50.0,
        ),
        (
            "wide",
            perspective(DVec3::ZERO, DVec3::new(0.2, 1.0, 0.1), 1.8, 100.0),
            45.0,
        ),
        (
            "inside",
            perspective(DVec3::ZERO, DVec3::new(0.2, 1.0, 0.1), 0.2, 90.0),
            40.0,
        ),
    ] {
        let found = picture(vec![item.clone()], &camera, &settings).image;
        let expected = ellipsoids::picture(&kernels(&gaussians, &camera), &camera, settings.size);
        let figures = Comparison::of(&found, &expected);
        assert!(figures.psnr > least, "{name}: {}", figures.psnr);
    }
}

/// The widening in depth preserves the optical depth of flat kernels, wherever planes lie.
#[test]
fn flat_kernels_keep_their_optical_depth_between_planes() {
    let mut random = Random::new(3);
    let (mut least, mut most) = (f32::INFINITY, 0.0f32);
    for _ in 0..40 {
        let attributes = splatvol::GaussianAttributes {
            means: vec![[0.0, 0.0, random.range(-0.5, 0.5) as f32]],
            scales: vec![[0.5, 0.5, 1e-4]],
            rotations: vec![[0.0, 0.0, 0.0, 1.0]],
            opacities: vec![0.6],
            harmonics: vec![[1.0; 3]],
        };
        let gaussians = Gaussians::new(attributes, 0, glam::DAffine3::IDENTITY).unwrap();
        let settings = RenderSettings {
            gaussians: GaussianMode::Volumetric,
            ..unlit(33, 33)
        };
        let item = Item::new(Content::Gaussians(Arc::new(gaussians)));
        let camera = orthographic(DVec3::ZERO, DVec3::Z, 4.0);
        let alpha = picture(vec![item], &camera, &settings).image.pixel(16, 16)[3];
        let depth = -(1.0 - alpha).ln();
        (least, most) = (least.min(depth), most.max(depth));
    }
    // The low-pass takes the same from all.
    assert!(most / least < 1.003, "{least} {most}");
    let whole = -(0.4f32).ln();
    assert!(
        most <= 1.002 * whole && least > 0.99 * whole,
        "{least} {most} {whole}"
    );
}
