//! Surfels: spheres of oriented points.

use glam::DVec3;
use splatvol::{Filter, FlatSettings, Lighting, PointLook, RenderSettings};
use splatvol_testing::checked;

use super::support::{item, picture, sphere, unlit};
use crate::common::{orthographic, perspective};

/// 20,000 points at 1024 x 1024 make a sphere without holes or seams, lit as a sphere is.
#[test]
fn a_sphere_of_points_has_no_hole_and_no_seam() {
    let direction = DVec3::new(0.3, 0.8, 0.5);
    let camera = orthographic(DVec3::ZERO, direction, 2.2);
    let settings = RenderSettings {
        lighting: Some(Lighting {
            specular: 0.0,
            ..Lighting::default()
        }),
        ..unlit(1024, 1024)
    };
    let look = PointLook {
        color: [1.0; 3],
        ..PointLook::default()
    };
    let frame = picture(vec![item(sphere(20_000), look, 1.0)], &camera, &settings);
    let radius = 1024.0 / 2.2;
    let (mut least_alpha, mut worst_light) = (1.0_f32, 0.0_f64);
    for y in 0..1024 {
        for x in 0..1024 {
            let [dx, dy] = [x, y].map(|at| (f64::from(at) + 0.5 - 512.0) / radius);
            let from_centre = (dx * dx + dy * dy).sqrt();
            let pixel = frame.image.pixel(x as usize, y as usize);
            if from_centre < 0.99 {
                least_alpha = least_alpha.min(pixel[3]);
            }
            if from_centre < 0.95 {
                let facing = (1.0 - from_centre * from_centre).sqrt();
                let light = 0.25 + 0.75 * facing;
                let found = f64::from(pixel[0] / pixel[3]);
                worst_light = worst_light.max((found - light).abs());
            }
            if from_centre > 1.06 {
                assert_eq!(pixel[3], 0.0, "{x} {y}");
            }
        }
    }
    println!(
        "sphere of 20000 points: alpha at least {least_alpha:.4}, light off by at most {worst_light:.4}"
    );
    assert!(least_alpha > 0.98, "{least_alpha}");
    assert!(worst_light < 0.03, "{worst_light}");
}

/// The opacity of a surface equals the requested one, for any number of points and from every side.
#[test]
fn surfaces_are_as_opaque_as_they_are_told() {
    for count in [2_000, 20_000] {
        for opacity in [0.25, 0.5, 0.9] {
            for direction in [DVec3::X, DVec3::new(0.2, -0.4, 1.0)] {
                let camera = perspective(DVec3::ZERO, direction, 8.0, 20.0);
                let look = PointLook {
                    opacity,
                    ..PointLook::default()
                };
                let frame = picture(
                    vec![item(sphere(count), look, 1.0)],
                    &camera,
                    &checked(FlatSettings {
                        filter: Filter::Ewa { pixel_sigma: 0.5 },
                        ..unlit(64, 64).into()
                    }),
                );
                // Both sides of the sphere, seen at right angles.
                let expected = 1.0 - (1.0 - opacity).powi(2);
                let found = f64::from(frame.image.pixel(32, 32)[3]);
                assert!(
                    (found - expected).abs() < 0.01,
                    "{count} {opacity}: {found} {expected}"
                );
            }
        }
    }
}
