//! Clipped balls: depth and normal on the cut, and the remaining X-rays.

use glam::DVec3;
use splatvol::{Bounds, Classification, Clip, Compositing, FlatSettings, Keep, Scene};
use splatvol_testing::checked;

use super::support::{NormalColors, ball, cameras, normal, solid, unlit};
use crate::common::{render, world_ray};

const RADIUS: f64 = 18.0;
const PIXELS: u32 = 96;

/// An opaque ball coloured by its normals, cut by a clip: pixels that look at the clip's face first, by the closed form
/// `face` (ray parameter and normal there), have the face's depth and normal. Returns their number.
fn demand_faces(clip: &Clip, face: impl Fn(DVec3, DVec3) -> Option<(f64, DVec3)>) -> usize {
    let settings = unlit(PIXELS);
    let opacity = 0.999_999;
    // Light comes from one mean free path behind the face.
    let path = 1.0 / -(1.0f64 - opacity).ln();
    let mut count = 0;
    for camera in cameras() {
        let scene = Scene::new(ball(RADIUS), solid(0.0, opacity))
            .with_operator(NormalColors)
            .with_clip(clip.clone());
        let frame = render(&scene, &camera, &settings);
        let (mut worst_depth, mut worst_angle) = (0.0f64, 0.0f64);
        for y in 0..PIXELS as usize {
            for x in 0..PIXELS as usize {
                let (origin, direction) = world_ray(&camera, &settings, x, y);
                let Some((t, expected)) = face(origin, direction) else {
                    continue;
                };
                // Well within the ball: its skin has a tenth of a voxel of thinner material.
                if (origin + t * direction).length() > RADIUS - 1.5 {
                    continue;
                }
                count += 1;
                let pixel = frame.image.pixel(x, y);
                assert!(pixel[3] > 0.99, "{x} {y}: {pixel:?}");
                let depth = f64::from(frame.depth[y * PIXELS as usize + x]);
                worst_depth = worst_depth.max((depth - t - path / direction.length()).abs());
                let cosine = normal(pixel).normalize().dot(expected).abs();
                worst_angle = worst_angle.max(cosine.min(1.0).acos().to_degrees());
            }
        }
        println!("depth {worst_depth:.4} voxels, normal {worst_angle:.3} degrees");
        assert!(worst_depth < 0.005, "{worst_depth}");
        assert!(worst_angle < 3.0, "{worst_angle}");
    }
    count
}

#[test]
fn a_plane_cuts_a_flat_face_at_its_own_depth() {
    // Both sides of the clip's normal are tried: one faces the cameras.
    let (point, axis) = (
        DVec3::new(1.3, -2.1, 0.7),
        DVec3::new(-0.3, 0.8, -0.4).normalize(),
    );
    let clip = Clip::plane(point, axis).unwrap();
    let count = demand_faces(&clip, |origin, direction| {
        let t = (point - origin).dot(axis) / direction.dot(axis);
        (direction.dot(axis) > 0.05).then_some((t, axis))
    });
    assert!(count > 1500, "{count}");
}

#[test]
fn a_box_cut_out_shows_its_far_faces() {
    let bounds = Bounds {
        min: DVec3::new(-2.3, -40.0, -3.1),
        max: DVec3::new(40.0, 1.7, 40.0),
    };
    let clip = Clip::of_box(&bounds, Keep::Outside).unwrap();
    let count = demand_faces(&clip, |origin, direction| {
        // The box reaches out of the ball towards the cameras: through it the ball is seen where rays leave
        // the box.
        let exits = [0, 1, 2].map(|a| {
            let end = if direction[a] > 0.0 {
                bounds.max[a]
            } else {
                bounds.min[a]
            };
            ((end - origin[a]) / direction[a], DVec3::AXES[a])
        });
        let mut sorted = exits;
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let leave = origin + sorted[0].0 * direction;
        let inside = bounds.min.cmple(leave + 1e-9).all() && bounds.max.cmpge(leave - 1e-9).all();
        // Not within half a pixel's width of an edge, where the ray in the middle sees one face and rounding another.
        let clear = sorted[1].0 - sorted[0].0 > 0.2;
        (inside && clear).then_some(sorted[0])
    });
    assert!(count > 500, "{count}");
}

#[test]
fn a_half_ball_has_half_the_energy() {
    let middle = Clip::plane(DVec3::ZERO, DVec3::new(0.2, -0.5, 0.4)).unwrap();
    let whole = Scene::new(ball(RADIUS), solid(0.0, 0.01));
    let half = whole.clone().with_clip(middle);
    let [_, camera] = cameras();
    let base = unlit(PIXELS);
    let settings = [
        ("post", base, 0.002),
        (
            "pre",
            checked(FlatSettings {
                classification: Classification::Pre,
                ..base.into()
            }),
            0.01,
        ),
        (
            "xray",
            checked(FlatSettings {
                compositing: Compositing::Xray,
                ..base.into()
            }),
            0.01,
        ),
    ];
    for (name, settings, tolerance) in settings {
        let energy = |scene: &Scene| {
            let frame = render(scene, &camera, &settings);
            frame.optical_depth.iter().map(|&d| f64::from(d)).sum::<f64>()
        };
        let share = energy(&half) / energy(&whole);
        println!("{name}: {share:.5}");
        assert!((share - 0.5).abs() < tolerance, "{name}: {share}");
    }
}
