//! Scalar fields in world space whose values and gradients are known exactly.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use splatvol_scene::{Grid, LengthUnit, Rescale, Samples, Volume};

use crate::Random;

/// A scalar field over world space.
pub trait Field {
    /// Value at a point.
    fn value(&self, world: DVec3) -> f64;

    /// Gradient at a point, per world length.
    fn gradient(&self, world: DVec3) -> DVec3;
}

/// Samples a field at the voxel centres of a grid, as f32.
///
/// # Panics
/// If the field is finite nowhere on the grid.
pub fn sample(field: &impl Field, grid: &Grid) -> Volume {
    let [nx, ny, nz] = grid.dims();
    let mut samples = Vec::with_capacity(grid.sample_count());
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let voxel = DVec3::new(i as f64, j as f64, k as f64);
                samples.push(field.value(grid.world_from_voxel().transform_point3(voxel)) as f32);
            }
        }
    }
    Volume::new(
        grid.clone(),
        Samples::F32(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
    .expect("one sample per voxel was pushed, and analytic fields are finite")
}

/// The test signal of Marschner and Lobb (1994), for the cube [-1, 1]^3; values in 0..1.
///
/// `(1 - sin(pi z / 2) + alpha (1 + cos(2 pi f cos(pi r / 2)))) / (2 (1 + alpha))`, `r^2 = x^2 + y^2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarschnerLobb {
    /// Frequency f of the ripples; 6 in the paper.
    pub frequency: f64,
    /// Their strength alpha; 0.25 in the paper.
    pub alpha: f64,
}

impl Default for MarschnerLobb {
    fn default() -> Self {
        Self {
            frequency: 6.0,
            alpha: 0.25,
        }
    }
}

impl MarschnerLobb {
    /// The n^3 grid over [-1, 1]^3 (41 in the paper).
    ///
    /// # Panics
    /// If there are fewer than 2 samples per axis.
    pub fn grid(n: usize) -> Grid {
        Grid::centred([n; 3], DVec3::splat(2.0 / (n as f64 - 1.0))).expect("at least two samples per axis")
    }
}

impl Field for MarschnerLobb {
    fn value(&self, world: DVec3) -> f64 {
        let radius = world.truncate().length();
        let ripple = (TAU * self.frequency * (0.5 * PI * radius).cos()).cos();
        (1.0 - (0.5 * PI * world.z).sin() + self.alpha * (1.0 + ripple)) / (2.0 * (1.0 + self.alpha))
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        let radius = world.truncate().length();
        let phase = TAU * self.frequency * (0.5 * PI * radius).cos();
        let phase_slope = -TAU * self.frequency * 0.5 * PI * (0.5 * PI * radius).sin();
        let radial = -self.alpha * phase.sin() * phase_slope;
        let outwards = world.truncate().try_normalize().unwrap_or_default();
        (radial * outwards).extend(-0.5 * PI * (0.5 * PI * world.z).cos()) / (2.0 * (1.0 + self.alpha))
    }
}

/// A ball whose value falls quadratically: `1 - (r / radius)^2`, 0 outside.
///
/// A line at distance b from the centre integrates to `4/3 (R^2 - b^2)^(3/2) / R^2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Centre, world.
    pub centre: DVec3,
    /// Radius, world.
    pub radius: f64,
}

impl Ball {
    /// Integral of the value along a whole line that passes the centre at distance `offset`.
    pub fn line_integral(&self, offset: f64) -> f64 {
        let squared = (self.radius * self.radius - offset * offset).max(0.0);
        4.0 / 3.0 * squared.powf(1.5) / (self.radius * self.radius)
    }
}

impl Field for Ball {
    fn value(&self, world: DVec3) -> f64 {
        (1.0 - (world - self.centre).length_squared() / (self.radius * self.radius)).max(0.0)
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        if self.value(world) == 0.0 {
            return DVec3::ZERO;
        }
        -2.0 * (world - self.centre) / (self.radius * self.radius)
    }
}

/// A linear ramp, `offset + gradient . x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    /// Value at the world's origin.
    pub offset: f64,
    /// Gradient, per world length.
    pub gradient: DVec3,
}

impl Field for Ramp {
    fn value(&self, world: DVec3) -> f64 {
        self.offset + self.gradient.dot(world)
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        self.gradient
    }
}

/// A ramp clamped to 0..1: 0 before the plane `normal . x = start`, 1 from `thickness` behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Unit direction in which the value rises.
    pub normal: DVec3,
    /// Start of the ramp, world length along the normal.
    pub start: f64,
    /// World length over which it rises.
    pub thickness: f64,
}

impl Field for Slab {
    fn value(&self, world: DVec3) -> f64 {
        ((self.normal.dot(world) - self.start) / self.thickness).clamp(0.0, 1.0)
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        let t = (self.normal.dot(world) - self.start) / self.thickness;
        if (0.0..1.0).contains(&t) {
            self.normal / self.thickness
        } else {
            DVec3::ZERO
        }
    }
}

/// A constant field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant(pub f64);

impl Field for Constant {
    fn value(&self, _: DVec3) -> f64 {
        self.0
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }
}

/// A cosine wave, `amplitude cos(wave_vector . x + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWave {
    /// Radians per world length.
    pub wave_vector: DVec3,
    /// Radians at the world's origin.
    pub phase: f64,
    /// Half of peak to peak.
    pub amplitude: f64,
}

impl Field for PlaneWave {
    fn value(&self, world: DVec3) -> f64 {
        self.amplitude * (self.wave_vector.dot(world) + self.phase).cos()
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        -self.amplitude * (self.wave_vector.dot(world) + self.phase).sin() * self.wave_vector
    }
}

/// Band-limited noise: a seeded sum of plane waves, centred on 1/2, standard deviation about 1/5.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    waves: Vec<PlaneWave>,
}

impl Noise {
    /// Waves that turn by at most `max_radians` per world length along each axis (pi per voxel is the Nyquist
    /// frequency); different limits per axis make the noise anisotropic.
    pub fn new(seed: u64, waves: usize, max_radians: DVec3) -> Self {
        let mut random = Random::new(seed);
        let amplitude = 0.2 * (2.0 / waves as f64).sqrt();
        let mut wave = || PlaneWave {
            wave_vector: random.direction() * random.unit().cbrt() * max_radians,
            phase: random.range(0.0, TAU),
            amplitude,
        };
        Self {
            waves: (0..waves).map(|_| wave()).collect(),
        }
    }
}

impl Field for Noise {
    fn value(&self, world: DVec3) -> f64 {
        0.5 + self.waves.iter().map(|wave| wave.value(world)).sum::<f64>()
    }

    fn gradient(&self, world: DVec3) -> DVec3 {
        self.waves.iter().map(|wave| wave.gradient(world)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_gradient(name: &str, field: &impl Field) {
        const STEP: f64 = 1e-5;
        let mut random = Random::new(3);
        for _ in 0..200 {
            let at = random.point(DVec3::splat(-1.0), DVec3::splat(1.0));
            let slope =
                |axis: DVec3| (field.value(at + STEP * axis) - field.value(at - STEP * axis)) / (2.0 * STEP);
            let numeric = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            let difference = (numeric - field.gradient(at)).length();
            assert!(difference < 1e-6, "{name} at {at}: {difference}");
        }
    }

    #[test]
    fn gradients_are_those_of_the_values() {
        let normal = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        assert_gradient("marschner-lobb", &MarschnerLobb::default());
        assert_gradient(
            "ball",
            &Ball {
                centre: DVec3::X,
                radius: 4.0,
            },
        );
        assert_gradient(
            "ramp",
            &Ramp {
                offset: 1.0,
                gradient: normal,
            },
        );
        assert_gradient(
            "slab",
            &Slab {
                normal,
                start: -3.0,
                thickness: 6.0,
            },
        );
        assert_gradient("constant", &Constant(2.0));
        assert_gradient("noise", &Noise::new(5, 40, DVec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn marschner_lobb_samples_fill_its_range() {
        let volume = sample(&MarschnerLobb::default(), &MarschnerLobb::grid(41));
        let [low, high] = volume.value_range();
        assert!(
            (0.0..0.01).contains(&low) && (0.99..=1.0).contains(&high),
            "{low} {high}"
        );
    }

    #[test]
    fn the_ball_integrates_to_its_closed_form() {
        let ball = Ball {
            centre: DVec3::ZERO,
            radius: 2.0,
        };
        let steps = 20_000;
        let dl = 4.0 / f64::from(steps);
        let at = |i: i32| DVec3::new(0.7, 0.0, -2.0 + (f64::from(i) + 0.5) * dl);
        let sum: f64 = (0..steps).map(|i| ball.value(at(i)) * dl).sum();
        assert!((sum - ball.line_integral(0.7)).abs() < 1e-6);
    }

    #[test]
    fn noise_depends_on_the_seed_alone() {
        let value = |seed| Noise::new(seed, 30, DVec3::ONE).value(DVec3::ONE);
        assert!(value(1) == value(1) && value(1) != value(2));
    }
}
