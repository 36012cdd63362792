//! Solids as lists of smoothly joined shapes, evaluated for a brick of voxels at a time.
//!
//! Distances are signed (negative inside), in millimetres, exact for cones, walls and boxes and of first order for
//! ellipsoids. `smin(a, b) = min(a, b) - max(k - |a - b|, 0)^2 / 4k` joins two shapes over a blend k; cutting is
//! its mirror image. Only values near 0 matter, so a shape whose surface is farther from the brick than its blend
//! can reach is left out for that brick. This makes a head of hundreds of shapes affordable.

use glam::{Mat3, Vec3};

use crate::rotation;

/// Side of a brick, voxels.
pub(crate) const SIDE: usize = 8;
/// Voxels of a brick.
pub(crate) const COUNT: usize = SIDE * SIDE * SIDE;
/// One number per voxel of a brick, x fastest.
pub(crate) type Field = [f32; COUNT];

/// Distance that stands for "nothing near".
pub(crate) const FAR: f32 = 1e3;

/// Positions (mm) of a brick's voxels.
pub(crate) struct Brick {
    pub(crate) x: Field,
    pub(crate) y: Field,
    pub(crate) z: Field,
    pub(crate) centre: Vec3,
    /// Distance from the centre to the farthest voxel, mm.
    pub(crate) radius: f32,
}

impl Brick {
    /// Brick whose first voxel lies at `first`, voxels `spacing` apart.
    pub(crate) fn new(first: Vec3, spacing: Vec3) -> Self {
        let at = |start: f32, step: f32, i: usize| start + step * i as f32;
        let half = spacing * (0.5 * (SIDE as f32 - 1.0));
        Self {
            x: std::array::from_fn(|i| at(first.x, spacing.x, i % SIDE)),
            y: std::array::from_fn(|i| at(first.y, spacing.y, i / SIDE % SIDE)),
            z: std::array::from_fn(|i| at(first.z, spacing.z, i / (SIDE * SIDE))),
            centre: first + half,
            radius: half.length(),
        }
    }

    /// Position of voxel `i`.
    pub(crate) fn position(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    Ellipsoid {
        radii: Vec3,
    },
    /// Capsule from the frame's origin to `end`, its radius going from `from` to `to`.
    Cone {
        end: Vec3,
        from: f32,
        to: f32,
    },
    /// A cone whose section is drawn out along z by half heights `from_height` to `to_height`.
    Wall {
        end: Vec3,
        heights: [f32; 2],
        radius: f32,
    },
    Box {
        half: Vec3,
        rounding: f32,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Add,
    Cut,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mirror {
    None,
    Sharp,
    Soft,
}

impl Mirror {
    #[inline(always)]
    fn apply(self, x: f32) -> f32 {
        /// Width of the soft mirror's rounding, mm.
        const SOFTNESS: f32 = 4.0;
        match self {
            Self::None => x,
            Self::Sharp => x.abs(),
            Self::Soft => (x * x + SOFTNESS * SOFTNESS).sqrt(),
        }
    }
}

/// A shape in its own frame, and its blending with the shapes before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    shape: Shape,
    centre: Vec3,
    /// Rows: axes of the shape's frame.
    local_from_world: Mat3,
    mirror: Mirror,
    operation: Operation,
    blend: f32,
}

impl Part {
    fn new(shape: Shape, centre: [f32; 3]) -> Self {
        Self {
            shape,
            centre: Vec3::from_array(centre),
            local_from_world: Mat3::IDENTITY,
            mirror: Mirror::None,
            operation: Operation::Add,
            blend: 1.0,
        }
    }

    /// Turned by degrees about the x, y and z axes of its centre, in this order.
    pub(crate) fn turned(mut self, degrees: [f32; 3]) -> Self {
        let world_from_local = rotation::about_axes(degrees.map(f32::to_radians));
        self.local_from_world = world_from_local.transpose() * self.local_from_world;
        self
    }

    /// Present on both sides: evaluated at (|x|, y, z).
    pub(crate) fn mirrored(mut self) -> Self {
        self.mirror = Mirror::Sharp;
        self
    }

    /// Present on both sides, without a crease in the midplane.
    pub(crate) fn mirrored_softly(mut self) -> Self {
        self.mirror = Mirror::Soft;
        self
    }

    /// Joined smoothly over `blend` mm.
    pub(crate) fn blend(mut self, blend: f32) -> Self {
        self.blend = blend;
        self
    }

    /// Taken away, smoothly over `blend` mm.
    pub(crate) fn cut(mut self, blend: f32) -> Self {
        self.operation = Operation::Cut;
        self.blend = blend;
        self
    }

    #[inline(always)]
    fn distance(&self, x: f32, y: f32, z: f32) -> f32 {
        let x = self.mirror.apply(x);
        let p = Vec3::new(x - self.centre.x, y - self.centre.y, z - self.centre.z);
        match self.shape {
            Shape::Ellipsoid { radii } => distance::ellipsoid(self.local_from_world * p, radii),
            Shape::Cone { end, from, to } => distance::cone(p, end, from, to),
            Shape::Wall { end, heights, radius } => distance::wall(p, end, heights, radius),
            Shape::Box { half, rounding } => distance::rounded_box(self.local_from_world * p, half, rounding),
        }
    }

    fn combine(&self, brick: &Brick, distance: &mut Field) {
        // One loop per kind of shape, so that each can be vectorised.
        macro_rules! each {
            (|$p:ident| $shape:expr) => {
                for i in 0..COUNT {
                    let x = self.mirror.apply(brick.x[i]);
                    let $p = Vec3::new(
                        x - self.centre.x,
                        brick.y[i] - self.centre.y,
                        brick.z[i] - self.centre.z,
                    );
                    let here = $shape;
                    distance[i] = match self.operation {
                        Operation::Add => smooth_min(distance[i], here, self.blend),
                        Operation::Cut => -smooth_min(-distance[i], here, self.blend),
                    };
                }
            };
        }
        let frame = self.local_from_world;
        match self.shape {
            Shape::Ellipsoid { radii } => each!(|p| distance::ellipsoid(frame * p, radii)),
            Shape::Cone { end, from, to } => each!(|p| distance::cone(p, end, from, to)),
            Shape::Wall { end, heights, radius } => each!(|p| distance::wall(p, end, heights, radius)),
            Shape::Box { half, rounding } => each!(|p| distance::rounded_box(frame * p, half, rounding)),
        }
    }
}

/// An ellipsoid with half axes `radii`.
pub(crate) fn ellipsoid(centre: [f32; 3], radii: [f32; 3]) -> Part {
    Part::new(
        Shape::Ellipsoid {
            radii: Vec3::from_array(radii),
        },
        centre,
    )
}

/// A capsule from a to b with radii `[at a, at b]`.
pub(crate) fn cone(a: [f32; 3], b: [f32; 3], radii: [f32; 2]) -> Part {
    let end = Vec3::from_array(b) - Vec3::from_array(a);
    let [from, to] = radii;
    Part::new(Shape::Cone { end, from, to }, a)
}

/// An upright wall along a to b, `heights` above and below it at its ends, 2 `radius` thick.
pub(crate) fn wall(a: [f32; 3], b: [f32; 3], heights: [f32; 2], radius: f32) -> Part {
    let end = Vec3::from_array(b) - Vec3::from_array(a);
    Part::new(Shape::Wall { end, heights, radius }, a)
}

/// A box with half sides `half`, rounding included.
pub(crate) fn rounded_box(centre: [f32; 3], half: [f32; 3], rounding: f32) -> Part {
    let half = (Vec3::from_array(half) - rounding).max(Vec3::ZERO);
    Part::new(Shape::Box { half, rounding }, centre)
}

/// Capsules through all `points` (position, radius), each joined over `blend`.
pub(crate) fn tube(points: &[([f32; 3], f32)], blend: f32) -> impl Iterator<Item = Part> {
    points
        .windows(2)
        .map(move |pair| cone(pair[0].0, pair[1].0, [pair[0].1, pair[1].1]).blend(blend))
}

mod distance {
    //! The distance functions themselves (Quilez, <https://iquilezles.org/articles/distfunctions/>).
    use glam::Vec3;

    #[inline(always)]
    pub(super) fn ellipsoid(p: Vec3, radii: Vec3) -> f32 {
        let q = p / radii;
        let first = q.length();
        let second = (q / radii).length();
        first * (first - 1.0) / second.max(1e-6)
    }

    #[inline(always)]
    pub(super) fn cone(p: Vec3, end: Vec3, from: f32, to: f32) -> f32 {
        let t = (p.dot(end) / end.length_squared()).clamp(0.0, 1.0);
        (p - end * t).length() - (from + t * (to - from))
    }

    #[inline(always)]
    pub(super) fn wall(p: Vec3, end: Vec3, heights: [f32; 2], radius: f32) -> f32 {
        let flat = Vec3::new(end.x, end.y, 0.0);
        let t = (p.dot(flat) / flat.length_squared()).clamp(0.0, 1.0);
        let q = p - end * t;
        let height = heights[0] + t * (heights[1] - heights[0]);
        let above = (q.z.abs() - height).max(0.0);
        Vec3::new(q.x, q.y, above).length() - radius
    }

    #[inline(always)]
    pub(super) fn rounded_box(p: Vec3, half: Vec3, rounding: f32) -> f32 {
        let q = p.abs() - half;
        q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - rounding
    }

    #[inline(always)]
    pub(crate) fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
        let overlap = (k - (a - b).abs()).max(0.0);
        a.min(b) - overlap * overlap * (0.25 / k)
    }
}
pub(crate) use distance::smooth_min;

/// Parts in the order in which they are joined.
#[derive(Debug, Clone, Default)]
pub(crate) struct Solid {
    parts: Vec<Part>,
}

impl Solid {
    pub(crate) fn new(parts: impl IntoIterator<Item = Part>) -> Self {
        Self {
            parts: parts.into_iter().collect(),
        }
    }

    /// Distances at a brick's voxels, correct wherever they are below `reach`; elsewhere at least about
    /// `reach`.
    pub(crate) fn evaluate(&self, brick: &Brick, reach: f32) -> Option<Field> {
        // Ellipsoid distances grow faster than distance near their flat sides, and a value counts as long as
        // shapes joined later still blend with it.
        let widest = self.parts.iter().map(|part| part.blend).fold(0.0, f32::max);
        let slack = 1.75 * brick.radius + reach + 1.25 * widest;
        let mut field = None;
        for part in &self.parts {
            let near =
                part.distance(brick.centre.x, brick.centre.y, brick.centre.z) < slack + 1.25 * part.blend;
            if !near || (part.operation == Operation::Cut && field.is_none()) {
                continue;
            }
            part.combine(brick, field.get_or_insert([FAR; COUNT]));
        }
        field
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaving_parts_out_changes_nothing_near_the_surface() {
        let (reach, edge) = (3.0, 1.25);
        let mut near = 0;
        for solid in [
            super::super::skin::skin(),
            super::super::skull::skull(),
            super::super::jaw::mandible(),
        ] {
            for step in 0..9 * 9 * 9 {
                let [i, j, k] = [step % 9, step / 9 % 9, step / 81].map(|i| i as f32);
                let first = Vec3::new(-100.0 + 23.0 * i, -100.0 + 25.0 * j, -120.0 + 28.0 * k);
                let brick = Brick::new(first, Vec3::ONE);
                let all = solid.evaluate(&brick, 1e4).unwrap();
                let some = solid.evaluate(&brick, reach).unwrap_or([FAR; COUNT]);
                for (all, some) in all.iter().zip(&some).filter(|(all, _)| all.abs() < edge) {
                    near += 1;
                    assert!((all - some).abs() < 0.05, "{all} {some} in the brick at {first}");
                }
            }
        }
        assert!(near > 10_000, "{near}");
    }

    #[test]
    fn distances_are_those_of_the_shapes() {
        let at = |part: Part, p: [f32; 3]| part.distance(p[0], p[1], p[2]);
        assert_eq!(at(ellipsoid([0.0; 3], [2.0; 3]), [5.0, 0.0, 0.0]), 3.0);
        let capsule = cone([0.0; 3], [4.0, 0.0, 0.0], [1.0, 1.0]);
        assert_eq!(at(capsule, [6.0, 0.0, 0.0]), 1.0);
        assert_eq!(at(capsule, [2.0, 3.0, 0.0]), 2.0);
        let plank = wall([0.0; 3], [4.0, 0.0, 0.0], [5.0, 5.0], 1.0);
        assert_eq!(at(plank, [2.0, 3.0, 4.0]), 2.0);
        assert_eq!(
            at(rounded_box([0.0; 3], [2.0, 1.0, 1.0], 0.5), [5.0, 0.0, 0.0]),
            3.0
        );
        let turned = rounded_box([0.0; 3], [2.0, 1.0, 1.0], 0.0).turned([0.0, 0.0, 90.0]);
        assert!((at(turned, [0.0, 5.0, 0.0]) - 3.0).abs() < 1e-5);
        assert_eq!(smooth_min(1.0, 1.0, 2.0), 0.5);
        assert_eq!(smooth_min(1.0, 4.0, 2.0), 1.0);
    }
}
