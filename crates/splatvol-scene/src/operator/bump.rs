//! Bump mapping (Blinn 1978; on sheets, huang2000 section 4.3, the word around the head): a picture bends normals.
//!
//! The picture is wound around the volume's vertical axis once. With H the height field `height * picture(u, v)` at
//! the place of a sample, a surface raised by H along its normal n has the normal `n - grad_s H`, `grad_s` the part
//! of the gradient along the surface. `u = 1/2 - atan2(x, y) / 2 pi`, so that the picture's middle is in front
//! (+y), and someone looking at the volume reads it from left to right; v runs from the box's top (+z) to its
//! bottom. Slopes are differences of a pixel's two neighbours, taken once, and bilinear between pixels.

use glam::{Vec2, Vec3, Vec4};

use super::picture::{Across, Picture};
use super::{Appearance, PixelOperator, SheetSample, WgslOperator, wgsl};
use crate::{Bounds, Image, SceneError};

/// A picture wound around the volume that bends its normals.
#[derive(Debug, Clone, PartialEq)]
pub struct BumpMap {
    /// Slopes of the picture's brightness along u and v.
    slopes: Picture,
    centre: Vec3,
    top: f32,
    per_length: f32,
    /// World length that white is raised.
    height: f32,
}

impl BumpMap {
    /// Heights from a picture (its brightness, linear; transparent is black), around the middle of a box; white is
    /// raised by `height` of the box's diagonal, or lowered where it is negative.
    ///
    /// # Errors
    /// A height that is not finite.
    pub fn new(image: &Image, bounds: &Bounds, height: f64) -> Result<Self, SceneError> {
        if !height.is_finite() {
            return Err(SceneError::invalid("bump height", height, "finite"));
        }
        let extent = (bounds.max.z - bounds.min.z).max(f64::from(f32::MIN_POSITIVE));
        Ok(Self {
            slopes: Picture::new(image, Across::Wrapped).slopes(brightness),
            centre: bounds.centre().as_vec3(),
            top: bounds.max.z as f32,
            per_length: (1.0 / extent) as f32,
            height: (height * bounds.diagonal()) as f32,
        })
    }

    /// Gradient of the height field at a point, world axes; none on the axis and beyond the box's top and bottom.
    pub fn slope(&self, position: Vec3) -> Vec3 {
        let out = (position - self.centre).truncate();
        let radius = out.length();
        let v = (self.top - position.z) * self.per_length;
        if radius <= 0.0 || !(0.0..=1.0).contains(&v) {
            return Vec3::ZERO;
        }
        let u = 0.5 - libm::atan2f(out.x, out.y) / std::f32::consts::TAU;
        let per = self.slopes.at([u, v]);
        // u grows against atan2(x, y), which grows towards (y, -x).
        let around = Vec2::new(-out.y, out.x) / (radius * radius * std::f32::consts::TAU);
        self.height * (per.x * around).extend(-per.y * self.per_length)
    }
}

/// Luminance of linear Rec. 709.
fn brightness(pixel: Vec4) -> f32 {
    0.2126 * pixel.x + 0.7152 * pixel.y + 0.0722 * pixel.z
}

impl PixelOperator for BumpMap {
    fn apply(&self, sample: &SheetSample, appearance: &mut Appearance) {
        let slope = self.slope(sample.position);
        let normal = appearance.normal;
        let along = slope - normal * slope.dot(normal);
        appearance.normal = (normal - along).try_normalize().unwrap_or(normal);
    }

    fn wgsl(&self) -> Option<WgslOperator> {
        let head = [
            self.centre.extend(self.top).to_array(),
            [self.per_length, self.height, 0.0, 0.0],
        ];
        Some(WgslOperator {
            name: "bump_map",
            texts: vec![wgsl::PICTURE, wgsl::BUMP_MAP],
            operands: head.into_iter().chain(self.slopes.operands()).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::ImageSize;

    /// The slope against differences of the height field itself, computed in f64.
    #[test]
    fn slopes_are_the_height_fields_gradient() {
        let size = ImageSize::new(64, 32).unwrap();
        let wave = |x: f64, y: f64| 0.5 + 0.3 * (std::f64::consts::TAU * x).sin() * (3.0 * y).cos();
        let pixels = (0..32 * 64)
            .map(|i| {
                let (x, y) = ((i % 64) as f64, (i / 64) as f64);
                let h = wave((x + 0.5) / 64.0, (y + 0.5) / 32.0) as f32;
                [h, h, h, 1.0]
            })
            .collect();
        let image = Image::from_pixels(size, pixels).unwrap();
        let bounds = Bounds {
            min: DVec3::new(-10.0, -20.0, -30.0),
            max: DVec3::new(20.0, 20.0, 30.0),
        };
        let map = BumpMap::new(&image, &bounds, 0.05).unwrap();
        let height = |p: DVec3| {
            let out = p - bounds.centre();
            let u = 0.5 - out.x.atan2(out.y) / std::f64::consts::TAU;
            0.05 * bounds.diagonal() * wave(u, (bounds.max.z - p.z) / 60.0)
        };
        for i in 0..50 {
            let angle = 0.4 * f64::from(i);
            let p = bounds.centre() + DVec3::new(8.0 * angle.cos(), 8.0 * angle.sin(), f64::from(i) - 25.0);
            let step = 1e-5;
            let expected = DVec3::from_array(std::array::from_fn(|a| {
                let step = DVec3::AXES[a] * step;
                (height(p + step) - height(p - step)) / 2e-5
            }));
            let found = map.slope(p.as_vec3()).as_dvec3();
            assert!(
                found.distance(expected) < 0.02 * (expected.length() + 0.05),
                "{p}: {found} {expected}"
            );
        }
        assert_eq!(map.slope(Vec3::new(5.0, 0.0, 31.0)), Vec3::ZERO);
    }
}
