//! Look-alikes of the data of Fig. 10 that are not public, from implicit shapes.
//!
//! Places are in voxels of the paper's sizes, whatever size is generated; edges are soft over three voxels, as in
//! scanned data.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use splatvol::{
    ColorPoint, Grid, LengthUnit, OpacityPoint, Rescale, Samples, Scene, TransferFunction, Volume,
};

use crate::LabError;

/// Size of the engine.
pub(super) const ENGINE: [usize; 3] = [256, 256, 110];
/// Size of the foot.
pub(super) const FOOT: [usize; 3] = [152, 261, 220];

const METAL: f64 = 110.0;
const LINER: f64 = 220.0;
const TISSUE: f64 = 70.0;
const BONE: f64 = 200.0;

/// A machined block with two cylinders in liners, a water jacket's openings, bolts and a pipe.
pub(super) fn engine(shrink: usize) -> Result<Scene, LabError> {
    let volume = volume(ENGINE, shrink, &|at, edge| {
        let block = boxed(
            at - DVec3::new(128.0, 128.0, 52.0),
            DVec3::new(84.0, 104.0, 38.0),
            8.0,
        );
        let flange = boxed(
            at - DVec3::new(128.0, 128.0, 18.0),
            DVec3::new(104.0, 118.0, 8.0),
            4.0,
        );
        let pipe = tube(at.y - 100.0, DVec2::new(at.x - 50.0, at.z - 60.0), [26.0, 60.0]);
        let mut value = METAL * filled(block.min(flange).min(pipe), edge);
        let mut carve = |distance: f64, into: f64| value += filled(distance, edge) * (into - value);
        for y in [80.0, 176.0] {
            let from_axis = DVec2::new(at.x - 134.0, at.y - y);
            carve(tube(at.z - 56.0, from_axis, [38.0, 40.0]), LINER);
            carve(tube(at.z - 56.0, from_axis, [29.0, 60.0]), 0.0);
        }
        carve(
            tube(at.y - 100.0, DVec2::new(at.x - 50.0, at.z - 60.0), [16.0, 80.0]),
            0.0,
        );
        for corner in 0..4 {
            let side = |bit: i32, half: f64| if corner >> bit & 1 == 0 { -half } else { half };
            let from_axis = DVec2::new(at.x - 128.0 - side(0, 92.0), at.y - 128.0 - side(1, 104.0));
            carve(tube(at.z - 22.0, from_axis, [6.0, 20.0]), LINER);
        }
        value
    })?;
    let colors = [
        (40.0, [0.55, 0.62, 0.72]),
        (METAL, [0.62, 0.68, 0.78]),
        (170.0, [0.95, 0.62, 0.25]),
    ];
    let opacities = [
        (20.0, 0.0),
        (55.0, 0.09),
        (95.0, 0.012),
        (125.0, 0.012),
        (165.0, 0.35),
        (LINER, 0.6),
    ];
    Ok(Scene::new(volume, look(&colors, &opacities)?))
}

/// Bones of a foot and a stump of the leg, in soft tissue that follows them.
pub(super) fn foot(shrink: usize) -> Result<Scene, LabError> {
    let bones = bones();
    let volume = volume(FOOT, shrink, &|at, edge| {
        let (mut bone, mut tissue) = (f64::INFINITY, f64::INFINITY);
        for &(from, to, radius) in &bones {
            let distance = capsule(at, from, to) - radius;
            bone = bone.min(distance);
            tissue = smooth_min(tissue, distance - 9.0, 9.0);
        }
        let value = TISSUE * filled(tissue, edge);
        value + filled(bone, edge) * (BONE - value)
    })?;
    let colors = [
        (20.0, [0.90, 0.62, 0.48]),
        (TISSUE, [0.86, 0.50, 0.40]),
        (150.0, [0.96, 0.92, 0.82]),
    ];
    let opacities = [
        (12.0, 0.0),
        (35.0, 0.05),
        (60.0, 0.006),
        (90.0, 0.01),
        (130.0, 0.35),
        (BONE, 0.7),
    ];
    Ok(Scene::new(volume, look(&colors, &opacities)?))
}

/// Two ends and a radius each.
fn bones() -> Vec<(DVec3, DVec3, f64)> {
    let mut bones = vec![
        // Heel, ankle, instep, shin and calf bone.
        (DVec3::new(74.0, 200.0, 48.0), DVec3::new(72.0, 228.0, 40.0), 19.0),
        (DVec3::new(78.0, 172.0, 82.0), DVec3::new(76.0, 192.0, 86.0), 19.0),
        (DVec3::new(62.0, 138.0, 62.0), DVec3::new(92.0, 142.0, 58.0), 15.0),
        (
            DVec3::new(76.0, 184.0, 112.0),
            DVec3::new(76.0, 190.0, 240.0),
            14.0,
        ),
        (
            DVec3::new(104.0, 192.0, 90.0),
            DVec3::new(102.0, 196.0, 240.0),
            7.0,
        ),
    ];
    for (toe, length) in [0.0, 7.0, 6.0, 2.0, -6.0].into_iter().enumerate() {
        let x = 26.0 + 24.0 * toe as f64;
        let thick = if toe == 0 { 1.5 } else { 1.0 };
        let y = 40.0 - length + 1.5 * toe as f64;
        let joint = |forward: f64, z: f64| DVec3::new(x, y + forward, z);
        bones.push((
            DVec3::new(52.0 + 12.0 * toe as f64, 124.0, 56.0),
            joint(34.0, 26.0),
            5.0 * thick,
        ));
        bones.push((joint(24.0, 23.0), joint(10.0, 21.0), 4.5 * thick));
        bones.push((joint(2.0, 19.0), joint(-8.0, 18.0), 4.0 * thick));
    }
    bones
}

/// A volume of values at places in voxels of the paper's size; `value` takes the place and half the width of edges.
fn volume(
    [nx, ny, nz]: [usize; 3],
    shrink: usize,
    value: &(dyn Fn(DVec3, f64) -> f64 + Sync),
) -> Result<Volume, LabError> {
    let dims = [nx, ny, nz].map(|n| n / shrink);
    let spacing = shrink as f64;
    let samples: Vec<u8> = (0..dims[0] * dims[1] * dims[2])
        .into_par_iter()
        .map(|i| [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])])
        .map(|voxel| (DVec3::from_array(voxel.map(|at| at as f64)) + 0.5) * spacing)
        .map(|at| value(at, 1.5 * spacing).round() as u8)
        .collect();
    let grid = Grid::centred(dims, DVec3::splat(spacing))?;
    Ok(Volume::new(
        grid,
        Samples::U8(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )?)
}

/// Opacities are those of a voxel of the paper's size.
fn look(colors: &[(f64, [f64; 3])], opacities: &[(f64, f64)]) -> Result<TransferFunction, LabError> {
    Ok(TransferFunction::new(
        colors
            .iter()
            .map(|&(value, rgb)| ColorPoint::new(value, rgb))
            .collect(),
        opacities
            .iter()
            .map(|&(value, opacity)| OpacityPoint::new(value, opacity))
            .collect(),
        Some(1.0),
    )?)
}

/// Share of a voxel that is inside a surface at this signed distance.
fn filled(distance: f64, edge: f64) -> f64 {
    let t = (0.5 - 0.5 * distance / edge).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Distance to a box with round edges.
fn boxed(at: DVec3, half: DVec3, round: f64) -> f64 {
    let outside = at.abs() - half + round;
    outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0) - round
}

/// Distance to a cylinder of a radius and a half length: from its middle along and from its axis.
fn tube(along: f64, across: DVec2, [radius, half]: [f64; 2]) -> f64 {
    (across.length() - radius).max(along.abs() - half)
}

/// Distance to a line between two points.
fn capsule(at: DVec3, from: DVec3, to: DVec3) -> f64 {
    let (offset, line) = (at - from, to - from);
    let along = (offset.dot(line) / line.length_squared()).clamp(0.0, 1.0);
    (offset - line * along).length()
}

/// A minimum whose edge is round.
fn smooth_min(a: f64, b: f64, round: f64) -> f64 {
    if !a.is_finite() {
        return b;
    }
    let h = (0.5 + 0.5 * (b - a) / round).clamp(0.0, 1.0);
    b + (a - b) * h - round * h * (1.0 - h)
}
