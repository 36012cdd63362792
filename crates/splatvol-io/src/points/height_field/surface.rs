//! Points of a height field: posts, and what fills the faces between them.
//!
//! A post is a point with the normal of central differences, `(-dh/dx, -dh/dy, 1)`, and the distance between posts as
//! radius. swan1997 (figure 7) notes that "extra splats are required to fill in the holes formed where adjacent splats
//! differ in height" and stacks them under the higher post. Here they lie on the edge down to each lower neighbour,
//! which is where the surface is, so that consecutive ones are no farther apart than posts are on flat ground.

use glam::{DAffine3, DVec2, DVec3};
use splatvol_scene::{PointAttributes, Points};

use super::HeightField;
use crate::IoError;
use crate::error::Context;

/// Most points per post on average.
const MOST_PER_POST: f64 = 100.0;
/// Bytes of a point.
const BYTES: u64 = 32;

struct Surface<'a> {
    field: &'a HeightField,
    colors: &'a [[u8; 4]],
    /// Distance between points that leaves no hole.
    step: f64,
    /// World height that is local zero.
    base: f64,
}

/// A point under construction.
#[derive(Clone, Copy)]
struct Sample {
    place: DVec3,
    normal: DVec3,
    color: [u8; 4],
}

/// The points of all posts that are not gaps, row by row, each followed by those of its edges to the east and north.
pub(super) fn points(
    field: &HeightField,
    colors: &[[u8; 4]],
    max_bytes: u64,
    context: &Context<'_>,
) -> Result<Points, IoError> {
    let step = field.spacing.max_element();
    let base = field.range().map_or(0.0, |[low, _]| low * field.height_scale);
    let surface = Surface {
        field,
        colors,
        step,
        base,
    };
    surface.check_count(max_bytes, context)?;
    let [width, height] = field.dims;
    let mut positions = Vec::new();
    let mut attributes = PointAttributes::default();
    let mut push = |sample: Sample| {
        positions.push(sample.place.as_vec3().to_array());
        attributes.normals.push(sample.normal.as_vec3().to_array());
        attributes.radii.push(step as f32);
        if !colors.is_empty() {
            attributes.colors.push(sample.color);
        }
    };
    for post in (0..width * height).filter(|&post| !field.heights[post].is_nan()) {
        let from = surface.sample(post);
        push(from);
        for to in surface.neighbors(post).into_iter().flatten() {
            let to = surface.sample(to);
            let pieces = surface.pieces(from.place, to.place) as usize;
            for piece in 1..pieces {
                push(between(from, to, piece as f64 / pieces as f64));
            }
        }
    }
    // The south-western post is the local origin.
    let world_from_local = DAffine3::from_translation(field.origin.extend(base));
    Points::new(positions, attributes, world_from_local).map_err(|error| context.scene(error))
}

impl Surface<'_> {
    fn check_count(&self, max_bytes: u64, context: &Context<'_>) -> Result<(), IoError> {
        let posts = self.field.heights.len();
        let edges = |post: usize| {
            let from = self.place(post);
            let pieces = self
                .neighbors(post)
                .into_iter()
                .flatten()
                .map(|to| self.pieces(from, self.place(to)) - 1.0);
            1.0 + pieces.sum::<f64>()
        };
        let count: f64 = (0..posts)
            .filter(|&post| !self.field.heights[post].is_nan())
            .map(edges)
            .sum();
        if count.is_nan() || count > MOST_PER_POST * posts as f64 {
            let expected = format!("at most {MOST_PER_POST} per post; heights need another scale");
            return Err(context.field(
                "points on steep faces",
                format!("{count:e} of {posts} posts"),
                None,
                expected,
            ));
        }
        let bytes = count as u64 * BYTES;
        if bytes > max_bytes {
            return Err(context.limit(bytes, max_bytes));
        }
        Ok(())
    }

    fn place(&self, post: usize) -> DVec3 {
        let width = self.field.dims[0];
        let ground = self.field.spacing * DVec2::new((post % width) as f64, (post / width) as f64);
        ground.extend(self.field.heights[post] * self.field.height_scale - self.base)
    }

    fn sample(&self, post: usize) -> Sample {
        Sample {
            place: self.place(post),
            normal: self.normal(post),
            color: self.colors.get(post).copied().unwrap_or([255; 4]),
        }
    }

    /// The neighbours to the east and to the north that are not gaps.
    fn neighbors(&self, post: usize) -> [Option<usize>; 2] {
        let [width, height] = self.field.dims;
        let there = |post: usize| !self.field.heights[post].is_nan();
        [
            (post % width + 1 < width)
                .then_some(post + 1)
                .filter(|&p| there(p)),
            (post / width + 1 < height)
                .then_some(post + width)
                .filter(|&p| there(p)),
        ]
    }

    /// The number of pieces that an edge is cut into.
    fn pieces(&self, from: DVec3, to: DVec3) -> f64 {
        // A little slack, so that rounding does not cut the edges of flat ground; heights may be 40 % of a step apart.
        (from.distance(to) / self.step * 0.93).ceil().max(1.0)
    }

    fn normal(&self, post: usize) -> DVec3 {
        let width = self.field.dims[0];
        let slope = |position: usize, size: usize, stride: usize, spacing: f64| {
            let height = |post: usize| Some(self.field.heights[post]).filter(|h| !h.is_nan());
            let before = (position > 0).then(|| height(post - stride)).flatten();
            let after = (position + 1 < size).then(|| height(post + stride)).flatten();
            let here = self.field.heights[post];
            let (rise, run) = match (before, after) {
                (Some(before), Some(after)) => (after - before, 2.0),
                (Some(before), None) => (here - before, 1.0),
                (None, Some(after)) => (after - here, 1.0),
                (None, None) => (0.0, 1.0),
            };
            rise * self.field.height_scale / (run * spacing)
        };
        let east = slope(post % width, width, 1, self.field.spacing.x);
        let north = slope(post / width, self.field.dims[1], width, self.field.spacing.y);
        DVec3::new(-east, -north, 1.0).normalize()
    }
}

/// A sample on an edge.
fn between(from: Sample, to: Sample, t: f64) -> Sample {
    let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * t).round() as u8;
    let mut color = from.color;
    for (a, b) in color.iter_mut().zip(to.color) {
        *a = mix(*a, b);
    }
    Sample {
        place: from.place.lerp(to.place, t),
        normal: from.normal.lerp(to.normal, t).normalize_or(from.normal),
        color,
    }
}
