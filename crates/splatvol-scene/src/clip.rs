//! Clipping: the parts of the volume that are cut away, and the appearance of the cut.
//!
//! A clip is a convex body, the intersection of half-spaces, of which either the inside or the outside is kept. A ray's
//! part within a convex body is one interval, so engines cut rays exactly, whatever the sheets' distance.

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Bounds, SceneError};

/// Error of a squared length up to which a normal is kept as it is: a plane that was written and read again is the
/// same.
const UNIT: f64 = 1e-12;

/// A plane; the half-space that its normal points to is inside.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked", deny_unknown_fields)]
pub struct ClipPlane {
    point: DVec3,
    normal: DVec3,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    point: DVec3,
    normal: DVec3,
}

impl TryFrom<Unchecked> for ClipPlane {
    type Error = SceneError;

    fn try_from(raw: Unchecked) -> Result<Self, SceneError> {
        Self::new(raw.point, raw.normal)
    }
}

impl ClipPlane {
    /// Plane through a point (world) with a normal of any length.
    ///
    /// # Errors
    /// A point that is not finite, or a normal that is zero or not finite.
    pub fn new(point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Result<Self, SceneError> {
        let (point, normal) = (point.into(), normal.into());
        if !point.is_finite() {
            return Err(SceneError::invalid(
                "clip plane's point",
                point.to_array(),
                "finite numbers",
            ));
        }
        if (normal.length_squared() - 1.0).abs() < UNIT {
            return Ok(Self { point, normal });
        }
        let Some(unit) = normal.try_normalize() else {
            return Err(SceneError::invalid(
                "clip plane's normal",
                normal.to_array(),
                "a direction",
            ));
        };
        Ok(Self { point, normal: unit })
    }

    /// A point of it, world.
    pub fn point(&self) -> DVec3 {
        self.point
    }

    /// Its normal, length 1: towards the inside.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Distance of a point from it, positive inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.normal)
    }
}

/// The part that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// The part inside all planes.
    Inside,
    /// The part outside any of the planes.
    Outside,
}

/// A convex body, and which side of it is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clip {
    /// Planes that bound the body.
    pub planes: Vec<ClipPlane>,
    /// The part that is kept.
    pub keep: Keep,
}

impl Clip {
    /// Keeps the half-space that a plane's normal points to.
    ///
    /// # Errors
    /// Same as [`ClipPlane::new`].
    pub fn plane(point: impl Into<DVec3>, normal: impl Into<DVec3>) -> Result<Self, SceneError> {
        Ok(Self {
            planes: vec![ClipPlane::new(point, normal)?],
            keep: Keep::Inside,
        })
    }

    /// Keeps what lies inside a box, or outside it.
    ///
    /// # Errors
    /// Bounds that are not finite, or empty.
    pub fn of_box(bounds: &Bounds, keep: Keep) -> Result<Self, SceneError> {
        if !bounds.min.cmplt(bounds.max).all() {
            let corners = [bounds.min.to_array(), bounds.max.to_array()];
            return Err(SceneError::invalid(
                "clip box",
                corners,
                "each low bound below its high one",
            ));
        }
        let low = DVec3::AXES.map(|axis| ClipPlane::new(bounds.min, axis));
        let high = DVec3::AXES.map(|axis| ClipPlane::new(bounds.max, -axis));
        Ok(Self {
            planes: low.into_iter().chain(high).collect::<Result<_, _>>()?,
            keep,
        })
    }

    /// This body in another space, given the map `other_from_own`.
    #[must_use]
    pub fn transformed(&self, other_from_own: &DAffine3) -> Self {
        let normals = other_from_own.matrix3.inverse().transpose();
        let planes = self.planes.iter().map(|plane| ClipPlane {
            point: other_from_own.transform_point3(plane.point),
            normal: (normals * plane.normal).normalize_or(plane.normal),
        });
        Self {
            planes: planes.collect(),
            keep: self.keep,
        }
    }

    /// Whether a point is kept.
    pub fn keeps(&self, point: DVec3) -> bool {
        let inside = self.planes.iter().all(|plane| plane.distance(point) >= 0.0);
        inside == (self.keep == Keep::Inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_boxes_keep_their_side() {
        let plane = Clip::plane(DVec3::X, DVec3::new(0.0, 0.0, -3.0)).unwrap();
        assert!(plane.keeps(DVec3::new(5.0, 5.0, -0.1)) && !plane.keeps(DVec3::new(5.0, 5.0, 0.1)));
        let bounds = Bounds {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 2.0, 3.0),
        };
        let (inner, outer) = (DVec3::new(0.5, 1.5, 2.5), DVec3::new(0.5, 2.5, 2.5));
        for (keep, wanted) in [(Keep::Inside, true), (Keep::Outside, false)] {
            let clip = Clip::of_box(&bounds, keep).unwrap();
            assert_eq!(clip.keeps(inner), wanted);
            assert_eq!(clip.keeps(outer), !wanted);
        }
    }

    #[test]
    fn a_body_goes_where_its_points_go() {
        let bounds = Bounds {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 2.0, 3.0),
        };
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(2.0, -1.0, 0.5),
            glam::DQuat::from_rotation_x(0.7),
            DVec3::new(3.0, -4.0, 5.0),
        );
        for keep in [Keep::Inside, Keep::Outside] {
            let own = Clip::of_box(&bounds, keep).unwrap();
            let placed = own.transformed(&place);
            for point in [
                DVec3::new(0.5, 1.5, 2.5),
                DVec3::new(0.5, 2.1, 2.5),
                DVec3::splat(-0.1),
            ] {
                assert_eq!(
                    placed.keeps(place.transform_point3(point)),
                    own.keeps(point),
                    "{point}"
                );
            }
        }
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let error = Clip::plane(DVec3::ZERO, DVec3::ZERO).unwrap_err().to_string();
        assert!(error.starts_with("clip plane's normal"), "{error}");
        assert!(Clip::plane(DVec3::NAN, DVec3::X).is_err());
        let flat = Bounds {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 0.0, 1.0),
        };
        assert!(Clip::of_box(&flat, Keep::Inside).is_err());
    }
}
