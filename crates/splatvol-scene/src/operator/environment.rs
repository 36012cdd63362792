//! Environment mapping (Blinn and Newell 1976; on sheets, huang2000 section 4.3): surfaces mirror a picture of the
//! surroundings.
//!
//! The picture is equirectangular: `u = 1/2 + atan2(x, y) / 2 pi`, `v = acos(z) / pi` of the direction (world; its
//! middle is towards +y, its top +z). It is looked up in `r = 2 (n.v) n - v`, and replaces a share of the lit
//! colour: the given one times the surfaceness.

use glam::Vec3;

use super::picture::{Across, Picture};
use super::{Appearance, PixelOperator, SheetSample, WgslOperator, wgsl};
use crate::{Image, SceneError};

/// A mirrored picture of the surroundings.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    picture: Picture,
    share: f32,
}

impl EnvironmentMap {
    /// Mirror of an equirectangular picture, which replaces this share (0 to 1) of the light.
    ///
    /// # Errors
    /// A share outside 0 to 1.
    pub fn new(image: &Image, share: f64) -> Result<Self, SceneError> {
        if !(0.0..=1.0).contains(&share) {
            return Err(SceneError::invalid("environment share", share, "from 0 to 1"));
        }
        Ok(Self {
            picture: Picture::new(image, Across::Wrapped),
            share: share as f32,
        })
    }

    /// Light from a direction of length 1.
    pub fn light(&self, direction: Vec3) -> Vec3 {
        let u = 0.5 + libm::atan2f(direction.x, direction.y) / std::f32::consts::TAU;
        let v = libm::acosf(direction.z.clamp(-1.0, 1.0)) / std::f32::consts::PI;
        self.picture.at([u, v]).truncate()
    }
}

impl PixelOperator for EnvironmentMap {
    fn apply(&self, sample: &SheetSample, appearance: &mut Appearance) {
        let (normal, view) = (appearance.normal, sample.view);
        appearance.reflection = self.light(2.0 * normal.dot(view) * normal - view);
        appearance.reflectance = self.share * appearance.surfaceness;
    }

    fn wgsl(&self) -> Option<WgslOperator> {
        Some(WgslOperator {
            name: "environment_map",
            texts: vec![wgsl::PICTURE, wgsl::ENVIRONMENT_MAP],
            operands: std::iter::once([self.share, 0.0, 0.0, 0.0])
                .chain(self.picture.operands())
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ImageSize;

    #[test]
    fn a_mirror_shows_what_lies_in_the_reflected_direction() {
        // Columns tell the direction's quarter; the top row is white.
        let size = ImageSize::new(8, 16).unwrap();
        let pixels = (0..128)
            .map(|i| {
                if i < 8 {
                    [1.0; 4]
                } else {
                    [(i % 8) as f32, 0.0, 0.0, 1.0]
                }
            })
            .collect();
        let map = EnvironmentMap::new(&Image::from_pixels(size, pixels).unwrap(), 0.6).unwrap();
        assert_eq!(map.light(Vec3::Z), Vec3::ONE);
        assert_eq!(map.light(Vec3::Y).x, 3.5);
        assert_eq!(map.light(Vec3::X).x, 5.5);
        assert_eq!(map.light(-Vec3::X).x, 1.5);
        // Looking along -y at a mirror turned half way to x: x is seen.
        let sample = SheetSample {
            view: Vec3::Y,
            ..SheetSample::default()
        };
        for sign in [1.0, -1.0] {
            let mut appearance = Appearance {
                normal: sign * Vec3::new(1.0, 1.0, 0.0).normalize(),
                surfaceness: 0.5,
                ..Appearance::default()
            };
            map.apply(&sample, &mut appearance);
            assert!((appearance.reflection.x - 5.5).abs() < 1e-5);
            assert_eq!(appearance.reflectance, 0.3);
        }
    }
}
