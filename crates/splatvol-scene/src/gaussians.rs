//! Three-dimensional Gaussians with opacity and view-dependent colour, as trained from photographs (Kerbl, Kopanas,
//! Leimkuehler and Drettakis 2023, "3D Gaussian Splatting for Real-Time Radiance Field Rendering").
//!
//! ```text
//! G(x) = exp(-1/2 (x - mean)^T Sigma^-1 (x - mean)),   Sigma = R S S^T R^T          (their eq. 4, 6)
//! rgb(d) = max(0, 1/2 + sum_lm c_lm Y_lm(d)),          d from the camera to the mean, in the Gaussians' own frame
//! ```
//!
//! Everything is kept in the frame of the file, *local*; `world_from_local` turns it upright. Harmonics are
//! evaluated in local space, so that nothing has to be rotated.

use glam::DAffine3;

use crate::points::{bounds_of, check_finite, check_frame, is_unit};
use crate::{Bounds, SceneError};

/// Attributes of 3-D Gaussians; every field has one element per Gaussian.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GaussianAttributes {
    /// Means, local.
    pub means: Vec<[f32; 3]>,
    /// Standard deviations along the Gaussian's own axes, local lengths (not their logarithms).
    pub scales: Vec<[f32; 3]>,
    /// Rotations, local from own axes: quaternions x y z w.
    pub rotations: Vec<[f32; 4]>,
    /// Opacities at the mean, 0..1 (not their logits).
    pub opacities: Vec<f32>,
    /// Spherical harmonics: `(degree + 1)^2` red, green and blue coefficients of each Gaussian, in the order l = 0,
    /// 1, ..., m = -l..l and with the signs of the published implementation; sRGB as it is displayed.
    pub harmonics: Vec<[f32; 3]>,
}

/// A cloud of Gaussians.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussians {
    world_from_local: DAffine3,
    attributes: GaussianAttributes,
    degree: u32,
    antialiased: bool,
    bounds: Bounds,
}

impl Gaussians {
    /// Highest degree of the harmonics that is evaluated.
    pub const MAX_DEGREE: u32 = 3;

    /// Gaussians with harmonics up to a degree. Rotations are made unit quaternions.
    ///
    /// # Errors
    /// No Gaussians, fields of other lengths than the means', a degree above 3, numbers that are not finite, a negative
    /// scale, an opacity outside 0..1, a rotation of length zero, or a `world_from_local` that cannot be inverted.
    pub fn new(
        mut attributes: GaussianAttributes,
        degree: u32,
        world_from_local: DAffine3,
    ) -> Result<Self, SceneError> {
        check_frame(&world_from_local)?;
        if degree > Self::MAX_DEGREE {
            return Err(SceneError::invalid("degree of harmonics", degree, "0 to 3"));
        }
        attributes.check(degree)?;
        for rotation in &mut attributes.rotations {
            let length = rotation.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
            if length == 0.0 {
                return Err(SceneError::invalid(
                    "rotation",
                    rotation,
                    "a quaternion above zero",
                ));
            }
            if !is_unit(rotation) {
                *rotation = rotation.map(|c| (f64::from(c) / length) as f32);
            }
        }
        let bounds = bounds_of(&attributes.means, &world_from_local)?;
        Ok(Self {
            world_from_local,
            attributes,
            degree,
            antialiased: false,
            bounds,
        })
    }

    /// These Gaussians, marked as trained for a renderer that lowers the opacity of splats widened by its low-pass
    /// ("antialiased", "mip").
    #[must_use]
    pub fn with_antialiasing(mut self, antialiased: bool) -> Self {
        self.antialiased = antialiased;
        self
    }

    /// These Gaussians with another placement.
    ///
    /// # Errors
    /// A `world_from_local` that cannot be inverted.
    pub fn placed(self, world_from_local: DAffine3) -> Result<Self, SceneError> {
        let antialiased = self.antialiased;
        Ok(Self::new(self.attributes, self.degree, world_from_local)?.with_antialiasing(antialiased))
    }

    /// Local space to world.
    pub fn world_from_local(&self) -> &DAffine3 {
        &self.world_from_local
    }

    /// Attributes of the Gaussians.
    pub fn attributes(&self) -> &GaussianAttributes {
        &self.attributes
    }

    /// Degree of the harmonics, 0 to 3.
    pub fn degree(&self) -> u32 {
        self.degree
    }

    /// True where they were trained with a low-pass that keeps their energy.
    pub fn antialiased(&self) -> bool {
        self.antialiased
    }

    /// Number of Gaussians, at least one.
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        self.attributes.means.len()
    }

    /// Box of the means, world.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}

/// Coefficients per colour of harmonics up to a degree.
pub fn harmonics_count(degree: u32) -> usize {
    (degree as usize + 1).pow(2)
}

impl GaussianAttributes {
    fn check(&self, degree: u32) -> Result<(), SceneError> {
        let count = self.means.len();
        for (field, length, expected) in [
            ("scales", self.scales.len(), Some(count)),
            ("rotations", self.rotations.len(), Some(count)),
            ("opacities", self.opacities.len(), Some(count)),
            (
                "harmonics",
                self.harmonics.len(),
                count.checked_mul(harmonics_count(degree)),
            ),
        ] {
            if Some(length) != expected {
                return Err(SceneError::invalid(
                    field,
                    (length, count),
                    "one per mean (harmonics: (degree + 1)^2)",
                ));
            }
        }
        check_finite("mean", &self.means)?;
        check_finite("scale", &self.scales)?;
        check_finite("rotation", &self.rotations)?;
        check_finite("harmonics", &self.harmonics)?;
        if let Some(scale) = self.scales.iter().find(|s| s.iter().any(|c| *c < 0.0)) {
            return Err(SceneError::invalid("scale", scale, "zero or above"));
        }
        if let Some(opacity) = self.opacities.iter().find(|o| !(0.0..=1.0).contains(*o)) {
            return Err(SceneError::invalid("opacity", opacity, "0 to 1"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attributes() -> GaussianAttributes {
        GaussianAttributes {
            means: vec![[1.0, 2.0, 3.0]; 2],
            scales: vec![[0.1, 0.0, 2.0]; 2],
            rotations: vec![[0.0, 0.0, 3.0, 4.0]; 2],
            opacities: vec![0.0, 1.0],
            harmonics: vec![[0.5; 3]; 8],
        }
    }

    #[test]
    fn rotations_become_unit_quaternions() {
        let gaussians = Gaussians::new(attributes(), 1, DAffine3::IDENTITY).unwrap();
        assert_eq!(gaussians.attributes().rotations[1], [0.0, 0.0, 0.6, 0.8]);
        assert_eq!((gaussians.len(), gaussians.degree()), (2, 1));
        assert!(
            gaussians
                .with_antialiasing(true)
                .placed(DAffine3::IDENTITY)
                .unwrap()
                .antialiased()
        );
    }

    #[test]
    fn what_cannot_be_gaussians_is_refused_by_name() {
        let refused = |change: fn(&mut GaussianAttributes), degree, words: &str| {
            let mut changed = attributes();
            change(&mut changed);
            let text = Gaussians::new(changed, degree, DAffine3::IDENTITY)
                .unwrap_err()
                .to_string();
            assert!(text.contains(words), "{text}");
        };
        refused(|_| {}, 2, "harmonics");
        refused(|_| {}, 4, "degree");
        refused(|a| a.opacities[0] = 1.5, 1, "opacity");
        refused(|a| a.opacities[0] = f32::NAN, 1, "opacity");
        refused(|a| a.scales[1][0] = -1.0, 1, "scale");
        refused(|a| a.rotations[1] = [0.0; 4], 1, "rotation");
        refused(|a| a.means[0][2] = f32::NAN, 1, "mean");
        refused(|a| a.scales.truncate(1), 1, "scales");
        refused(|a| *a = GaussianAttributes::default(), 0, "positions");
    }
}
