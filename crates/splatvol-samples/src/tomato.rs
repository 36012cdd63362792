//! A tomato as magnetic resonance sees it (256 x 256 x 256, as the papers' tests of semi-transparent fruit): soft
//! flesh, gel in chambers between walls, seeds around the core. The original data are not published; this one is built
//! from implicit shapes, z along the stem.

use glam::{Vec2, Vec3};

use crate::fill::{unit_position, voxels};
use crate::noise;
use crate::rotation::direction;

/// Chambers around the core.
const CHAMBERS: usize = 6;
/// Seeds of a chamber.
const SEEDS: usize = 16;

/// Value of the gel.
pub(crate) const GEL: f32 = 80.0;
/// Value of flesh and walls.
pub(crate) const FLESH: f32 = 140.0;
/// Value of seeds.
pub(crate) const SEED: f32 = 230.0;

/// A seed: an ellipsoid that points away from the core.
#[derive(Debug, Clone, Copy, Default)]
struct Seed {
    centre: Vec3,
    /// Long axis; the other two are half and a third as long.
    along: Vec3,
    across: Vec3,
    length: f32,
}

impl Seed {
    fn new(chamber: usize, index: usize) -> Self {
        let random = |what: i32| noise::white((chamber * SEEDS + index) as i32, what, 0, 401);
        let middle = (chamber as f32 + 0.5) / CHAMBERS as f32;
        let angle = (middle + 0.27 / CHAMBERS as f32 * random(0)) * std::f32::consts::TAU;
        let radius = 0.42 + 0.11 * random(1);
        // From bottom to top, so that they stay apart.
        let height = -0.36 + 0.72 * (index as f32 + 0.5 + 0.3 * random(2)) / SEEDS as f32;
        let outwards = direction(angle);
        let along =
            (outwards.extend(0.5 * random(3)) + 0.3 * Vec3::new(random(4), random(5), 0.0)).normalize();
        let across = along.cross(Vec3::Z).normalize();
        Self {
            centre: (radius * outwards).extend(height),
            along,
            across,
            length: 0.075 + 0.01 * random(6),
        }
    }

    /// Below 1 inside.
    fn distance(&self, p: Vec3) -> f32 {
        let from = (p - self.centre) / self.length;
        let (a, b) = (from.dot(self.along), from.dot(self.across));
        let rest = (from.length_squared() - a * a - b * b).max(0.0);
        (a * a + 4.0 * b * b + 9.0 * rest).sqrt()
    }
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(a: f32, b: f32, share: f32) -> f32 {
    a + share * (b - a)
}

/// A tomato.
pub(crate) fn tomato(dims: [usize; 3]) -> Vec<u8> {
    let seeds: [[Seed; SEEDS]; CHAMBERS] =
        std::array::from_fn(|chamber| std::array::from_fn(|index| Seed::new(chamber, index)));
    let voxel = 2.0 / dims.into_iter().min().unwrap_or(1).max(2) as f32;
    voxels(dims, |[x, y, z]| {
        let p = Vec3::new(
            unit_position(x, dims[0]) as f32,
            unit_position(y, dims[1]) as f32,
            unit_position(z, dims[2]) as f32,
        );
        let grain = noise::triangular(x as i32, y as i32, z as i32, 402);
        (value(p, voxel, &seeds) + 3.0 + 3.0 * grain).clamp(0.0, 255.0) as u8
    })
}

/// Value at a point of [-1, 1]^3; edges are `voxel` wide and more.
fn value(p: Vec3, voxel: f32, seeds: &[[Seed; SEEDS]; CHAMBERS]) -> f32 {
    let around = p.truncate().length();
    let turn = libm::atan2f(p.y, p.x) / std::f32::consts::TAU + 0.5;
    // Flattened, ribbed, with a dent at the stem and a smaller one opposite.
    let ribs =
        0.018 * libm::cosf(std::f32::consts::TAU * CHAMBERS as f32 * turn) * smoothstep(0.1, 0.6, around);
    let dent = 0.20 * libm::expf(-(around / 0.22).powi(2)) * f32::from(u8::from(p.z > 0.0))
        + 0.05 * libm::expf(-(around / 0.15).powi(2)) * f32::from(u8::from(p.z < 0.0));
    let smooth_shape = Vec2::new(around / (0.90 - ribs), (p.z.abs() + dent) / 0.74).length();
    let edge = (1.5 * voxel).max(0.012);
    if smooth_shape > 1.02 + 2.0 * edge {
        return stem(p, around, edge);
    }
    let shape = smooth_shape + 0.012 * noise::smooth(2.5 * p, 403);
    // About the distance from the skin, positive inside.
    let depth = 0.8 * (1.0 - shape);
    if depth < -edge {
        return stem(p, around, edge);
    }
    let wobble = noise::smooth(6.0 * p, 404);
    let flesh = FLESH + 10.0 * wobble + 8.0 * noise::smooth(22.0 * p, 405);
    let inside = interior(p, (around, turn, depth + 0.015 * wobble), edge, seeds, flesh);
    mix(stem(p, around, edge), inside, smoothstep(-edge, edge, depth))
}

/// Flesh outside, walls between the chambers and the core; gel and seeds in the chambers.
fn interior(
    p: Vec3,
    (around, turn, depth): (f32, f32, f32),
    edge: f32,
    seeds: &[[Seed; SEEDS]; CHAMBERS],
    flesh: f32,
) -> f32 {
    let chambers = turn * CHAMBERS as f32;
    let from_wall = (chambers - chambers.round()).abs() * std::f32::consts::TAU / CHAMBERS as f32 * around;
    let core = 0.24 + 0.04 * libm::sinf(9.0 * p.z);
    // Distance into a chamber through its nearest side, smoothly where two meet.
    let sides = [depth - 0.13, from_wall - 0.035, around - core];
    let into = -0.03 * libm::logf(sides.iter().map(|side| libm::expf(-side / 0.03)).sum::<f32>());
    let gel = smoothstep(-edge, edge, into);
    // The core is paler and has a string of vessels.
    let pale = 25.0 * (1.0 - smoothstep(0.08, 0.16, around)) * smoothstep(0.1, 0.2, depth);
    let value = mix(flesh - pale, GEL, gel);
    if into < -0.03 {
        return value;
    }
    // Turn counts from -x, seeds from +x.
    let chamber = ((turn + 0.5).rem_euclid(1.0) * CHAMBERS as f32) as usize % CHAMBERS;
    let nearest = seeds[chamber]
        .iter()
        .map(|seed| seed.distance(p))
        .fold(f32::INFINITY, f32::min);
    let soft = edge / 0.03;
    mix(
        value,
        SEED,
        1.0 - smoothstep(1.0 - 0.5 * soft, 1.0 + 0.5 * soft, nearest),
    )
}

/// The stem's stub above the dent, and air.
fn stem(p: Vec3, around: f32, edge: f32) -> f32 {
    if p.z < 0.3 {
        return 0.0;
    }
    let bend = Vec2::new(0.25 * (p.z - 0.5).powi(2), 0.0);
    let side = if p.z < 0.55 {
        around
    } else {
        (p.truncate() - bend).length()
    };
    let inside = (0.055 - side).min(0.84 - p.z);
    FLESH * smoothstep(-edge, edge, inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_flesh_gel_seeds_and_air() {
        let n = 96usize;
        let values = tomato([n; 3]);
        let share = |low: u8, high: u8| {
            values.iter().filter(|v| (low..=high).contains(v)).count() as f64 / values.len() as f64
        };
        assert!((0.5..0.8).contains(&share(0, 10)), "air {}", share(0, 10));
        assert!((0.04..0.2).contains(&share(72, 92)), "gel {}", share(72, 92));
        assert!(
            (0.1..0.35).contains(&share(120, 165)),
            "flesh {}",
            share(120, 165)
        );
        assert!(
            (0.001..0.03).contains(&share(200, 255)),
            "seeds {}",
            share(200, 255)
        );
        let at = |x: usize, y: usize, z: usize| values[(z * n + y) * n + x];
        assert!(at(0, 0, 0) < 10 && at(48, 48, 48) > 100);
    }

    #[test]
    fn seeds_lie_in_gel() {
        // Centres of seeds, and the sphere around each that holds it, must be in a chamber.
        let seeds: [[Seed; SEEDS]; CHAMBERS] =
            std::array::from_fn(|chamber| std::array::from_fn(|index| Seed::new(chamber, index)));
        let nothing = [[Seed {
            length: 1e-6,
            along: Vec3::X,
            across: Vec3::Y,
            centre: Vec3::splat(9.0),
        }; SEEDS]; CHAMBERS];
        for seed in seeds.iter().flatten() {
            assert!(value(seed.centre, 0.01, &seeds) > 220.0, "{seed:?}");
            let around = value(seed.centre, 0.01, &nothing);
            assert!((60.0..110.0).contains(&around), "{seed:?}: {around}");
        }
    }
}
