//! Solid textures: material coloured as if cut from a block (Perlin 1985; on sheets, huang2000 section 4.3).
//!
//! Marble is `sin(2 pi (x + turbulence))` of a coordinate, wood the fraction of the distance from an axis, both bent by
//! gradient noise. The point is in world space, so the block turns with the volume.

use glam::{DVec3, Vec3};

use super::noise::{gradient_noise, octaves};
use super::{Appearance, PixelOperator, SheetSample, WgslOperator, wgsl};
use crate::{Bounds, SceneError};

/// Material of the block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stuff {
    /// White stone with dark veins.
    Marble,
    /// Rings around a leaning trunk, three times as close as marble's veins.
    Wood,
}

/// A solid texture.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidTexture {
    stuff: Stuff,
    centre: Vec3,
    per_length: f32,
}

impl SolidTexture {
    /// Texture for a box, with veins `scale` of its diagonal apart (0.08 shows a dozen).
    ///
    /// # Errors
    /// A scale that is not positive and finite.
    pub fn new(stuff: Stuff, bounds: &Bounds, scale: f64) -> Result<Self, SceneError> {
        if !(scale.is_finite() && scale > 0.0) {
            return Err(SceneError::invalid("texture scale", scale, "positive and finite"));
        }
        let length = (scale * bounds.diagonal()).max(f64::from(f32::MIN_POSITIVE));
        Ok(Self {
            stuff,
            // The axis of wood beside the centre: rings are then seen as arcs, not as a target.
            centre: (bounds.centre() + DVec3::new(0.11, -0.07, 0.0) * bounds.diagonal()).as_vec3(),
            per_length: (1.0 / length) as f32,
        })
    }

    /// Colour at a point, linear light.
    pub fn color(&self, position: Vec3) -> Vec3 {
        let p = (position - self.centre) * self.per_length;
        match self.stuff {
            Stuff::Marble => marble(p),
            Stuff::Wood => wood(p),
        }
    }
}

impl PixelOperator for SolidTexture {
    fn apply(&self, sample: &SheetSample, appearance: &mut Appearance) {
        appearance.color = self.color(sample.position);
    }

    fn wgsl(&self) -> Option<WgslOperator> {
        Some(WgslOperator {
            name: match self.stuff {
                Stuff::Marble => "marble",
                Stuff::Wood => "wood",
            },
            texts: vec![wgsl::NOISE, wgsl::SOLID_TEXTURE],
            operands: vec![self.centre.extend(self.per_length).to_array()],
        })
    }
}

fn marble(p: Vec3) -> Vec3 {
    const STONE: Vec3 = Vec3::new(0.83, 0.81, 0.76);
    const VEIN: Vec3 = Vec3::new(0.055, 0.065, 0.085);
    let turbulence = octaves(p * 0.6, 5, f32::abs);
    let across = p.dot(Vec3::new(0.62, 0.35, 0.70));
    let wave = 0.5 + 0.5 * libm::sinf(std::f32::consts::TAU * (across + 1.3 * turbulence));
    // Veins are thin: most of a period is stone.
    STONE.lerp(VEIN, wave.powi(4))
}

fn wood(p: Vec3) -> Vec3 {
    const EARLY: Vec3 = Vec3::new(0.58, 0.32, 0.12);
    const LATE: Vec3 = Vec3::new(0.13, 0.045, 0.014);
    // The trunk leans, so that no upright surface lies in a single ring.
    let p = 3.0 * Vec3::new(p.x + 0.33 * p.z, p.y - 0.21 * p.z, p.z);
    let bend = 0.45 * octaves(p * Vec3::new(0.35, 0.35, 0.12), 3, |n| n);
    let ring = (p.x * p.x + p.y * p.y).sqrt() + bend;
    let age = ring - ring.floor();
    // Late wood thickens slowly and ends abruptly.
    let late = age * age * (1.0 - smooth((age - 0.93) / 0.07));
    let grain = gradient_noise(p * Vec3::new(14.0, 14.0, 0.9), 9);
    EARLY.lerp(LATE, (late + 0.12 * grain).clamp(0.0, 1.0))
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_colours_that_vary_at_their_scale_and_stay_put() {
        let bounds = Bounds {
            min: DVec3::splat(-50.0),
            max: DVec3::splat(50.0),
        };
        for stuff in [Stuff::Marble, Stuff::Wood] {
            let texture = SolidTexture::new(stuff, &bounds, 0.1).unwrap();
            let colors: Vec<Vec3> = (0..400)
                .map(|i| texture.color(Vec3::new(i as f32 * 0.2 - 40.0, 7.0, 3.0)))
                .collect();
            assert!(
                colors
                    .iter()
                    .all(|c| c.min_element() >= 0.0 && c.max_element() <= 1.0)
            );
            let brightness: Vec<f32> = colors.iter().map(|c| c.y).collect();
            let (low, high) = brightness
                .iter()
                .fold((f32::MAX, 0.0f32), |(low, high), &v| (low.min(v), high.max(v)));
            assert!(high > 2.0 * low, "{stuff:?}: {low} to {high}");
            // A period is a tenth of the diagonal, 17: 80 units cross the middle several times, and not by every step.
            let middle = 0.5 * (low + high);
            let crossings = brightness
                .windows(2)
                .filter(|w| (w[0] < middle) != (w[1] < middle))
                .count();
            assert!((4..200).contains(&crossings), "{stuff:?}: {crossings}");
        }
        assert!(SolidTexture::new(Stuff::Wood, &bounds, f64::NAN).is_err());
    }
}
