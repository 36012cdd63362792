//! Cut: exact intervals of a pixel's ray that clips leave visible.
//!
//! Along a ray a plane's distance is linear in depth, so a convex body is one interval, from the last entered plane
//! to the first left one. Classified voxels have no intervals and are dropped by their centres.

use glam::{DAffine3, DVec3, Vec3};
use splatvol_core::brick::BRICK;
use splatvol_core::visibility::BRICK_VOXELS;
use splatvol_scene::{Clip, Keep};

/// `normal . p + offset` is positive inside.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vec3,
    offset: f32,
}

/// Clips in some space.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cut {
    bodies: Vec<(Vec<Plane>, Keep)>,
}

/// A visible part of an interval, 0 to 1 from plane to plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub from: f32,
    pub to: f32,
    /// Normal of the cut at which it begins, if any; it points out of the visible part.
    pub face: Option<Vec3>,
}

/// A ray between two planes: its start, and the step to its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RaySegment {
    pub from: Vec3,
    pub step: Vec3,
}

/// Where all points of a set lie among the clips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Visible,
    Hidden,
    /// Some of them may be visible, others hidden, or at a face.
    Between,
}

/// Largest distance that rounding may move a face in front of its interval's start.
const ROUNDING: f32 = 1e-3;

/// Entry and exit of a ray through a body, with the planes' normals; empty if it enters after it leaves.
struct Passage {
    enter: f32,
    leave: f32,
    normals: [Vec3; 2],
}

impl Cut {
    /// Clips, given in world space, for points of another.
    pub(crate) fn new(clips: &[Clip], world_from_own: DAffine3) -> Self {
        let body = |clip: &Clip| {
            let planes = clip.planes.iter().map(|plane| {
                let normal = world_from_own.matrix3.transpose() * plane.normal();
                let length = normal.length();
                Plane {
                    normal: (normal / length).as_vec3(),
                    offset: (plane.distance(world_from_own.translation) / length) as f32,
                }
            });
            (planes.collect(), clip.keep)
        };
        Self {
            bodies: clips.iter().map(body).collect(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Side of the convex hull of points. With twice the `slack` a set has no other side than its parts, unless between.
    pub(crate) fn side(&self, points: &[Vec3], slack: f32) -> Side {
        let mut side = Side::Visible;
        for (planes, keep) in &self.bodies {
            let of_body = side_of(planes, points, slack);
            match (of_body, keep) {
                (Side::Between, _) => side = Side::Between,
                (Side::Hidden, Keep::Inside) | (Side::Visible, Keep::Outside) => return Side::Hidden,
                (Side::Visible, Keep::Inside) | (Side::Hidden, Keep::Outside) => {}
            }
        }
        side
    }

    /// Visible ranges of a segment, from front to back.
    pub(crate) fn ranges(&self, segment: &RaySegment, ranges: &mut Vec<Range>) {
        ranges.clear();
        ranges.push(Range {
            from: 0.0,
            to: 1.0,
            face: None,
        });
        for (planes, keep) in &self.bodies {
            let passage = passage(planes, segment);
            match keep {
                Keep::Inside => ranges.retain_mut(|range| {
                    begin(range, passage.enter, -passage.normals[0]);
                    range.to = range.to.min(passage.leave);
                    range.from < range.to
                }),
                Keep::Outside if passage.enter < passage.leave => {
                    for i in 0..ranges.len() {
                        let mut behind = ranges[i];
                        begin(&mut behind, passage.leave, passage.normals[1]);
                        ranges[i].to = ranges[i].to.min(passage.enter);
                        ranges.push(behind);
                    }
                    ranges.retain(|range| range.from < range.to);
                    ranges.sort_by(|a, b| a.from.total_cmp(&b.from));
                }
                Keep::Outside => {}
            }
        }
    }

    /// Drops voxels of a brick with clipped centres: their values become NaN. `first`: the brick's first voxel.
    pub(crate) fn drop_voxels(&self, first: [u32; 3], values: &mut [f32; BRICK_VOXELS]) {
        for (i, value) in values.iter_mut().enumerate() {
            let place = [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)];
            let point = Vec3::from_array(std::array::from_fn(|a| first[a] as f32 + place[a] as f32));
            if !value.is_nan() && !self.keeps(point) {
                *value = f32::NAN;
            }
        }
    }

    /// Whether a point is left.
    #[inline]
    pub(crate) fn keeps(&self, point: Vec3) -> bool {
        self.bodies.iter().all(|(planes, keep)| {
            let inside = planes.iter().all(|p| p.normal.dot(point) + p.offset >= 0.0);
            inside == (*keep == Keep::Inside)
        })
    }
}

/// Moves the start of a range to a face, if that is later.
fn begin(range: &mut Range, at: f32, normal: Vec3) {
    if at >= range.from - ROUNDING {
        range.face = Some(normal);
        range.from = range.from.max(at);
    }
}

/// Side of points if the inside of the planes is visible: within `slack` of a plane they lie between.
fn side_of(planes: &[Plane], points: &[Vec3], slack: f32) -> Side {
    let mut side = Side::Visible;
    for plane in planes {
        let (mut low, mut high, mut size) = (f32::INFINITY, f32::NEG_INFINITY, plane.offset.abs());
        for point in points {
            let along = plane.normal.dot(*point);
            low = low.min(along + plane.offset);
            high = high.max(along + plane.offset);
            size = size.max(along.abs());
        }
        let slack = slack * (2.0 * ROUNDING * (high - low) + 8.0 * f32::EPSILON * size);
        if high < -slack {
            return Side::Hidden;
        }
        if low <= slack {
            side = Side::Between;
        }
    }
    side
}

fn passage(planes: &[Plane], segment: &RaySegment) -> Passage {
    let mut passage = Passage {
        enter: f32::NEG_INFINITY,
        leave: f32::INFINITY,
        normals: [Vec3::ZERO; 2],
    };
    for plane in planes {
        let start = plane.normal.dot(segment.from) + plane.offset;
        let slope = plane.normal.dot(segment.step);
        if slope > 0.0 && -start > passage.enter * slope {
            (passage.enter, passage.normals[0]) = (-start / slope, plane.normal);
        } else if slope < 0.0 && start < passage.leave * -slope {
            (passage.leave, passage.normals[1]) = (start / -slope, plane.normal);
        } else if slope == 0.0 && start < 0.0 {
            passage.leave = f32::NEG_INFINITY;
        }
    }
    passage
}

/// World from the points of a lattice that begins `margin` voxels before the first sample.
pub(crate) fn world_from_lattice(world_from_voxel: DAffine3, margin: [usize; 3]) -> DAffine3 {
    world_from_voxel * DAffine3::from_translation(-DVec3::from_array(margin.map(|m| m as f64)))
}

#[cfg(test)]
mod tests {
    use splatvol_scene::Bounds;

    use super::*;

    fn boxed(keep: Keep) -> Clip {
        let bounds = Bounds {
            min: DVec3::new(-1.0, -1.0, 2.25),
            max: DVec3::new(1.0, 1.0, 2.75),
        };
        Clip::of_box(&bounds, keep).unwrap()
    }

    /// Along z from 2 to 3.
    const AHEAD: RaySegment = RaySegment {
        from: Vec3::new(0.5, 0.0, 2.0),
        step: Vec3::Z,
    };

    fn ranges(clips: &[Clip], segment: &RaySegment) -> Vec<Range> {
        let mut ranges = Vec::new();
        Cut::new(clips, DAffine3::IDENTITY).ranges(segment, &mut ranges);
        ranges
    }

    #[test]
    fn boxes_leave_one_range_inside_and_two_outside() {
        let inside = ranges(&[boxed(Keep::Inside)], &AHEAD);
        assert_eq!(
            inside,
            [Range {
                from: 0.25,
                to: 0.75,
                face: Some(-Vec3::Z)
            }]
        );
        let outside = ranges(&[boxed(Keep::Outside)], &AHEAD);
        assert_eq!(outside.len(), 2);
        assert_eq!(
            (outside[0].from, outside[0].to, outside[0].face),
            (0.0, 0.25, None)
        );
        assert_eq!(
            (outside[1].from, outside[1].to, outside[1].face),
            (0.75, 1.0, Some(-Vec3::Z))
        );
        let beside = RaySegment {
            from: Vec3::new(1.5, 0.0, 2.0),
            ..AHEAD
        };
        assert!(ranges(&[boxed(Keep::Inside)], &beside).is_empty());
        assert_eq!(ranges(&[boxed(Keep::Outside)], &beside).len(), 1);
        assert!(ranges(&[boxed(Keep::Inside), boxed(Keep::Outside)], &AHEAD).is_empty());
    }

    /// Against the clips' own answer for points along rays, in f64.
    #[test]
    fn points_of_a_ray_are_left_where_clips_keep_them() {
        let slanted = Clip::plane(DVec3::new(0.0, 0.2, 2.4), DVec3::new(1.0, 2.0, -1.0)).unwrap();
        for clips in [
            vec![boxed(Keep::Inside), slanted.clone()],
            vec![slanted.clone(), boxed(Keep::Outside)],
        ] {
            for i in 0..200 {
                let angle = 0.7 * i as f32;
                let segment = RaySegment {
                    from: Vec3::new(angle.cos(), angle.sin() * 1.2, 2.0),
                    step: Vec3::new(0.6 * (3.0 * angle).sin(), 0.4 * angle.cos(), 1.0),
                };
                let ranges = ranges(&clips, &segment);
                for step in 0..100 {
                    let u = (step as f32 + 0.5) / 100.0;
                    let near_end = ranges
                        .iter()
                        .any(|r| (r.from - u).abs() < 1e-4 || (r.to - u).abs() < 1e-4);
                    let point = (segment.from + segment.step * u).as_dvec3();
                    let kept = clips.iter().all(|clip| clip.keeps(point));
                    let left = ranges.iter().any(|r| r.from <= u && u < r.to);
                    assert!(near_end || kept == left, "{i} {u} {ranges:?}");
                }
            }
        }
    }
}
