//! Levels of detail: from a voxel per pixel to eight, nothing jumps, and what is small costs little.

use splatvol::{Camera, Frame, Projection, Scene};
use splatvol_samples::Sample;

use crate::common::PROJECTIONS;
use crate::support::{fast, generated, name_of, opaque, rendered, renderer};

const PIXELS: u32 = 192;
const STEPS_PER_OCTAVE: i32 = 8;

/// A camera that sees the middle of the volume with so many voxels to a pixel.
fn minified(scene: &Scene, projection: Projection, voxels_per_pixel: f64) -> Camera {
    let grid = scene.volume.grid();
    let height = f64::from(PIXELS) * grid.mean_spacing() * voxels_per_pixel;
    let target = grid.bounds().centre();
    let towards = glam::DVec3::new(-0.62, 0.70, 0.36).normalize();
    let (distance, projection) = match projection {
        Projection::Orthographic { .. } => (500.0, Projection::Orthographic { height }),
        Projection::Perspective { fov_degrees } => {
            (0.5 * height / (0.5 * fov_degrees).to_radians().tan(), projection)
        }
    };
    Camera::new(target + distance * towards, target, glam::DVec3::Z, projection).unwrap()
}

/// Sums of a frame's channels, as areas in voxels.
fn areas(frame: &Frame, voxels_per_pixel: f64) -> [f64; 4] {
    let sum = |c: usize| frame.image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
    std::array::from_fn(|c| sum(c) * voxels_per_pixel * voxels_per_pixel)
}

struct Shot {
    level: usize,
    voxels: u64,
    areas: [f64; 4],
}

fn sweep(scene: &Scene, projection: Projection) -> Vec<Shot> {
    let mut renderer = renderer();
    (0..=3 * STEPS_PER_OCTAVE)
        .map(|step| {
            let voxels_per_pixel = (f64::from(step) / f64::from(STEPS_PER_OCTAVE)).exp2();
            let camera = minified(scene, projection, voxels_per_pixel);
            let (frame, statistics) = rendered(&mut renderer, scene, &camera, &fast(PIXELS, PIXELS));
            Shot {
                level: statistics.level,
                voxels: statistics.voxels,
                areas: areas(&frame, voxels_per_pixel),
            }
        })
        .collect()
}

#[test]
fn a_sweep_through_the_levels_is_smooth_and_ever_cheaper() {
    let shells = generated(Sample::Shells, 96);
    for (look, scene) in [("opaque", opaque(&shells)), ("translucent", shells)] {
        for projection in PROJECTIONS {
            let shots = sweep(&scene, projection);
            let name = format!("{look} {}", name_of(projection));
            let mean = |c: usize| shots.iter().map(|s| s.areas[c]).sum::<f64>() / shots.len() as f64;
            let means: [f64; 4] = std::array::from_fn(mean);
            for (i, shot) in shots.iter().enumerate() {
                let relative: [f64; 4] = std::array::from_fn(|c| shot.areas[c] / means[c]);
                println!(
                    "{name} 2^({i}/8): level {} voxels {:7} areas {relative:.4?}",
                    shot.level, shot.voxels
                );
            }
        }
    }
}
