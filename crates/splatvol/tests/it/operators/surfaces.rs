//! Isosurfaces of a ball against the closed form: depth, normal, opacity, and cut open.

use glam::DVec3;
use splatvol::{Clip, Frame, Isosurface, Scene};

use super::support::{NormalColors, ball, cameras, normal, unlit};
use crate::common::{render, world_ray};

const PIXELS: u32 = 96;

/// Tolerance of a depth against the sphere: a thousandth of the values' range, the error of the engine's field.
const OFF: f64 = 0.04;

/// Distance of the point at a pixel's depth from the sphere of radius 16.
fn off((frame, x, y): (&Frame, usize, usize), (origin, direction): (DVec3, DVec3)) -> f64 {
    let depth = f64::from(frame.depth[y * PIXELS as usize + x]);
    ((origin + depth * direction).length() - 16.0).abs()
}

fn surface(value: f64, opacity: f64) -> Isosurface {
    Isosurface {
        value,
        rgb: [1.0; 3],
        opacity,
    }
}

/// Ray parameters where a sphere about the origin is entered and left.
fn through_sphere(origin: DVec3, direction: DVec3, radius: f64) -> Option<[f64; 2]> {
    let (a, b) = (direction.length_squared(), origin.dot(direction));
    let square = b * b - a * (origin.length_squared() - radius * radius);
    // Not within a hair of the silhouette, where depth has no limit.
    let root = (square > 0.05 * a * radius * radius).then(|| square.sqrt())?;
    Some([(-b - root) / a, (-b + root) / a])
}

#[test]
fn a_sphere_has_its_own_depth_and_normals() {
    let scene = Scene::of_isosurfaces(ball(20.0), &[surface(4.0, 1.0)])
        .unwrap()
        .with_operator(NormalColors);
    let settings = unlit(PIXELS);
    for camera in cameras() {
        let frame = render(&scene, &camera, &settings);
        let (mut worst, mut worst_angle, mut count) = (0.0f64, 0.0f64, 0);
        for y in 0..PIXELS as usize {
            for x in 0..PIXELS as usize {
                let (origin, direction) = world_ray(&camera, &settings, x, y);
                let Some([t, _]) = through_sphere(origin, direction, 16.0) else {
                    continue;
                };
                count += 1;
                worst = worst.max(off((&frame, x, y), (origin, direction)));
                let expected = (origin + t * direction).normalize();
                let found = normal(frame.image.pixel(x, y)).normalize();
                worst_angle = worst_angle.max(found.dot(expected).min(1.0).acos().to_degrees());
                assert_eq!(frame.image.pixel(x, y)[3], 1.0);
            }
        }
        println!("{worst:.4} voxels off, normal {worst_angle:.3} degrees, {count} pixels");
        assert!(count > 1500, "{count}");
        assert!(worst < OFF, "{worst}");
        assert!(worst_angle < 3.0, "{worst_angle}");
    }
}

#[test]
fn glass_spheres_are_crossed_twice_each() {
    let scene = Scene::of_isosurfaces(ball(20.0), &[surface(4.0, 0.3), surface(10.0, 0.5)]).unwrap();
    let settings = unlit(PIXELS);
    let mut seen = [0; 2];
    for camera in cameras() {
        let frame = render(&scene, &camera, &settings);
        for y in 0..PIXELS as usize {
            for x in 0..PIXELS as usize {
                let (origin, direction) = world_ray(&camera, &settings, x, y);
                let outer = through_sphere(origin, direction, 16.0);
                let inner = through_sphere(origin, direction, 10.0);
                let beside = (origin.cross(direction).length() / direction.length()) > 10.2;
                let expected = match (outer, inner) {
                    (Some(_), Some(_)) => 1.0 - 0.7f32.powi(2) * 0.5f32.powi(2),
                    (Some(_), None) if beside => 1.0 - 0.7f32.powi(2),
                    _ => continue,
                };
                seen[usize::from(inner.is_some())] += 1;
                let alpha = frame.image.pixel(x, y)[3];
                assert!((alpha - expected).abs() < 1e-4, "{x} {y}: {alpha} {expected}");
            }
        }
    }
    assert!(seen.iter().all(|&n| n > 300), "{seen:?}");
}

#[test]
fn a_cut_sphere_shows_its_inside() {
    let camera = &cameras()[1];
    let towards = (camera.position() - camera.target()).normalize();
    let scene = Scene::of_isosurfaces(ball(20.0), &[surface(4.0, 1.0)])
        .unwrap()
        .with_clip(Clip::plane(DVec3::ZERO, -towards).unwrap());
    let settings = unlit(PIXELS);
    let frame = render(&scene, camera, &settings);
    let mut worst = 0.0f64;
    for y in 0..PIXELS as usize {
        for x in 0..PIXELS as usize {
            let (origin, direction) = world_ray(camera, &settings, x, y);
            if through_sphere(origin, direction, 16.0).is_some() {
                worst = worst.max(off((&frame, x, y), (origin, direction)));
                let depth = f64::from(frame.depth[y * PIXELS as usize + x]);
                assert!((origin + depth * direction).dot(towards) < 0.1, "the far side");
            }
        }
    }
    println!("far side {worst:.4} voxels off");
    assert!(worst < OFF, "{worst}");
}
