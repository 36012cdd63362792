//! Points: samples of a surface, each with a place and, where it is known, a size, a normal and a colour.
//!
//! Coordinates are *local*, in 32 bits; `world_from_local` holds what 32 bits cannot, such as the millions of
//! metres of a map's projection. A reader subtracts an origin before it rounds.

use glam::{DAffine3, DVec3};

use crate::{Bounds, SceneError};

/// Attributes of points besides their positions; a field is empty if the attribute is unknown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointAttributes {
    /// sRGB and opacity, 0..255.
    pub colors: Vec<[u8; 4]>,
    /// Unit normals, local; zero where a point has none.
    pub normals: Vec<[f32; 3]>,
    /// Radii, local lengths, above zero.
    pub radii: Vec<f32>,
}

/// A cloud of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    world_from_local: DAffine3,
    positions: Vec<[f32; 3]>,
    attributes: PointAttributes,
    bounds: Bounds,
}

impl Points {
    /// Points at local positions. Normals are made unit vectors.
    ///
    /// # Errors
    /// No points, coordinates or radii that are not finite, radii not above zero, a normal that is not finite, an
    /// attribute of another length, or a `world_from_local` that cannot be inverted.
    pub fn new(
        positions: Vec<[f32; 3]>,
        mut attributes: PointAttributes,
        world_from_local: DAffine3,
    ) -> Result<Self, SceneError> {
        let count = positions.len();
        check_frame(&world_from_local)?;
        for (field, length) in [
            ("point colours", attributes.colors.len()),
            ("point normals", attributes.normals.len()),
            ("point radii", attributes.radii.len()),
        ] {
            check_length(field, length, count)?;
        }
        check_finite("point position", &positions)?;
        check_finite("point normal", &attributes.normals)?;
        if let Some(radius) = attributes.radii.iter().find(|r| !(r.is_finite() && **r > 0.0)) {
            return Err(SceneError::invalid(
                "point radius",
                radius,
                "finite and above zero",
            ));
        }
        for normal in &mut attributes.normals {
            if !is_unit(normal) {
                *normal = glam::Vec3::from_array(*normal).normalize_or_zero().to_array();
            }
        }
        let bounds = bounds_of(&positions, &world_from_local)?;
        Ok(Self {
            world_from_local,
            positions,
            attributes,
            bounds,
        })
    }

    /// Local space to world.
    pub fn world_from_local(&self) -> &DAffine3 {
        &self.world_from_local
    }

    /// Places, local.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Attributes besides the positions.
    pub fn attributes(&self) -> &PointAttributes {
        &self.attributes
    }

    /// Number of points, at least one.
    #[expect(clippy::len_without_is_empty, reason = "never empty")]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Box of the places, world.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// These points with other attributes.
    ///
    /// # Errors
    /// Same as [`Points::new`].
    pub fn with_attributes(self, attributes: PointAttributes) -> Result<Self, SceneError> {
        Self::new(self.positions, attributes, self.world_from_local)
    }

    /// These points with another placement.
    ///
    /// # Errors
    /// A `world_from_local` that cannot be inverted.
    pub fn placed(self, world_from_local: DAffine3) -> Result<Self, SceneError> {
        Self::new(self.positions, self.attributes, world_from_local)
    }
}

/// Whether a vector is a unit vector, as nearly as its numbers can say: it is not made one again, so that it stays what it is.
pub(crate) fn is_unit(vector: &[f32]) -> bool {
    let squared: f64 = vector.iter().map(|c| f64::from(*c).powi(2)).sum();
    (squared - 1.0).abs() < 4.0 * f64::from(f32::EPSILON)
}

/// A frame that takes no length to zero or infinity.
pub(crate) fn check_frame(world_from_local: &DAffine3) -> Result<(), SceneError> {
    let determinant = world_from_local.matrix3.determinant();
    if world_from_local.is_finite() && determinant.is_normal() {
        return Ok(());
    }
    Err(SceneError::invalid(
        "world_from_local",
        world_from_local,
        "finite and invertible",
    ))
}

/// A field as long as there are elements, or empty.
pub(crate) fn check_length(field: &'static str, length: usize, count: usize) -> Result<(), SceneError> {
    if length == 0 || length == count {
        return Ok(());
    }
    Err(SceneError::invalid(
        field,
        (length, count),
        "as many as there are positions, or none",
    ))
}

/// Vectors without NaN or infinity.
pub(crate) fn check_finite<const N: usize>(
    field: &'static str,
    vectors: &[[f32; N]],
) -> Result<(), SceneError> {
    match vectors.iter().find(|v| v.iter().any(|c| !c.is_finite())) {
        Some(vector) => Err(SceneError::invalid(field, vector, "finite")),
        None => Ok(()),
    }
}

/// World box of local positions; an error where there are none.
pub(crate) fn bounds_of(positions: &[[f32; 3]], world_from_local: &DAffine3) -> Result<Bounds, SceneError> {
    positions
        .iter()
        .map(|p| world_from_local.transform_point3(DVec3::from_array(p.map(f64::from))))
        .fold(None, |bounds: Option<Bounds>, p| {
            Some(bounds.map_or(Bounds { min: p, max: p }, |b| Bounds {
                min: b.min.min(p),
                max: b.max.max(p),
            }))
        })
        .ok_or_else(|| SceneError::invalid("positions", 0, "at least one"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(attributes: PointAttributes) -> Result<Points, SceneError> {
        Points::new(vec![[1.0, 2.0, 3.0]], attributes, DAffine3::IDENTITY)
    }

    #[test]
    fn points_lie_where_their_frame_puts_them() {
        let frame = DAffine3::from_translation(DVec3::new(6e6, 0.0, 0.0));
        let points = Points::new(
            vec![[0.25, 0.0, 0.0], [-1.0, 2.0, 5.0]],
            PointAttributes::default(),
            frame,
        )
        .unwrap();
        assert_eq!(points.bounds().min, DVec3::new(5_999_999.0, 0.0, 0.0));
        assert_eq!(points.bounds().max, DVec3::new(6_000_000.25, 2.0, 5.0));
        assert_eq!(points.len(), 2);
    }

    #[test]
    fn normals_become_unit_vectors() {
        let points = one(PointAttributes {
            normals: vec![[0.0, 8.0, 6.0]],
            ..Default::default()
        })
        .unwrap();
        assert_eq!(points.attributes().normals[0], [0.0, 0.8, 0.6]);
        // Once more changes nothing.
        let normals: Vec<[f32; 3]> = (0..500).map(|i| [0.3 + i as f32, 7.1, 0.01 * i as f32]).collect();
        let made = |normals| {
            let attributes = PointAttributes {
                normals,
                ..Default::default()
            };
            Points::new(vec![[0.0; 3]; 500], attributes, DAffine3::IDENTITY).unwrap()
        };
        let once = made(normals);
        assert_eq!(made(once.attributes().normals.clone()), once);
    }

    #[test]
    fn what_cannot_be_points_is_refused_by_name() {
        let refused = |attributes, words: &str| {
            let text = one(attributes).unwrap_err().to_string();
            assert!(text.contains(words), "{text}");
        };
        let radius = |radius| PointAttributes {
            radii: vec![radius],
            ..Default::default()
        };
        refused(radius(0.0), "point radius");
        refused(radius(f32::NAN), "point radius");
        let normals = PointAttributes {
            normals: vec![[f32::INFINITY, 0.0, 0.0]],
            ..Default::default()
        };
        refused(normals, "point normal");
        let colors = PointAttributes {
            colors: vec![[0; 4]; 2],
            ..Default::default()
        };
        refused(colors, "point colours");
        for (positions, scale) in [(vec![], 1.0), (vec![[f32::NAN; 3]], 1.0), (vec![[0.0; 3]], 0.0)] {
            let frame = DAffine3::from_scale(DVec3::splat(scale));
            assert!(Points::new(positions, PointAttributes::default(), frame).is_err());
        }
    }
}
