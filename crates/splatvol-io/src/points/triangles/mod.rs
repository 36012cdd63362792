//! Surfels of triangle meshes: each triangle becomes discs of its own place, size and normal.
//!
//! A surfel of radius r stands for the area r^2 ([`splatvol_scene::PointAttributes::radii`]), so a triangle of area A is a disc of
//! radius sqrt(A) at its centroid. Discs follow a surface as well as triangles do only where these are small and compact: long
//! ones are halved across their longest edge (Rivara 1984), thin ones sliced, until all is short against the whole surface.
//! How many that may become is bounded by the number of triangles; small files get 262,144.
//!
//! | module | what |
//! |---|---|
//! | `split` | patches of a triangle |
//! | `winding` | one side for all triangles of a surface |

mod split;
mod winding;

use std::path::Path;

use glam::DVec3;
use splatvol_scene::{PointAttributes, Points};

use super::scalar_colors::Coloring;
use crate::error::Context;
use crate::{IoError, ReadOptions};
use split::{Limit, Patch, Piece};

/// Surfels that any file may become, and surfels for each triangle beyond.
const FREE: f64 = 262_144.0;
const EACH: f64 = 4.0;
/// Bytes of a surfel.
const BYTES: u64 = 32;

/// Triangles between points, by the points' indices.
#[derive(Debug, Clone, Default)]
pub(crate) struct Triangles {
    corners: Vec<[u32; 3]>,
    /// sRGB and opacity of each triangle; empty where they have none.
    colors: Vec<[u8; 4]>,
    /// Values of the points, and what colours they become.
    values: Option<(Vec<f64>, Coloring)>,
}

impl Triangles {
    /// Colours the surface by values of the points, which are interpolated.
    pub(crate) fn color_by(&mut self, values: Vec<f64>, coloring: Coloring) {
        self.values = Some((values, coloring));
    }

    /// A convex polygon, as a fan of triangles. Fewer than three corners are nothing.
    pub(crate) fn add_polygon(&mut self, corners: &[u32], color: Option<[u8; 4]>) {
        let Some((&first, rest)) = corners.split_first() else {
            return;
        };
        for pair in rest.windows(2) {
            self.push([first, pair[0], pair[1]], color);
        }
    }

    /// A strip: every corner after the second makes a triangle with the two before it.
    pub(crate) fn add_strip(&mut self, corners: &[u32], color: Option<[u8; 4]>) {
        for (index, window) in corners.windows(3).enumerate() {
            let [a, b, c] = [window[0], window[1], window[2]];
            self.push(if index % 2 == 0 { [a, b, c] } else { [b, a, c] }, color);
        }
    }

    fn push(&mut self, corners: [u32; 3], color: Option<[u8; 4]>) {
        self.corners.push(corners);
        self.colors.extend(color);
    }

    pub(crate) fn len(&self) -> usize {
        self.corners.len()
    }
}

/// The surface that triangles make of points in memory, as files of triangles become ([`super::read_points`]): discs of the
/// triangles' own places, sizes and normals, on one side of them. `corners` are indices of points.
///
/// # Errors
/// Corners that are no points, no triangle that has an area, or more discs than memory grants.
pub fn surfels_of_triangles(points: &Points, corners: Vec<[u32; 3]>) -> Result<Points, IoError> {
    let context = &Context::new("triangles", Path::new("array"));
    let missing = |corners: &&[u32; 3]| corners.iter().any(|&corner| corner as usize >= points.len());
    if let Some(found) = corners.iter().find(missing) {
        let expected = format!("indices of {} points", points.len());
        return Err(context.field("corners", format!("{found:?}"), None, expected));
    }
    let triangles = Triangles {
        corners,
        ..Triangles::default()
    };
    surfels(points, &triangles, &ReadOptions::default(), context)
}

/// The surface that `triangles` make of `points`, as discs. Normals and colours of the points are interpolated; without normals,
/// a disc has its triangle's, all on one side.
pub(crate) fn surfels(
    points: &Points,
    triangles: &Triangles,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Points, IoError> {
    let own = points.attributes();
    let places: Vec<DVec3> = points.positions().iter().map(|p| vector(*p)).collect();
    let flipped = match own.normals.is_empty() {
        true => winding::flipped(points.positions(), &triangles.corners),
        false => Vec::new(),
    };
    let limit = limit(&places, &triangles.corners);
    let mut surface = Surface::default();
    let mut patches = Vec::new();
    for (index, &corners) in triangles.corners.iter().enumerate() {
        let whole = Piece(corners.map(|corner| places[corner as usize]));
        let sign = if flipped.get(index) == Some(&true) {
            -1.0
        } else {
            1.0
        };
        let face = whole.normal() * sign;
        let smooth = Corners::of(&own.normals, corners);
        let colors = Corners::of(&own.colors, corners);
        split::split(whole, limit, &mut patches);
        for patch in &patches {
            let weights = whole.weights(patch.centroid);
            let normal = smooth.as_ref().map_or(face, |corners| {
                corners
                    .mix(weights, |normal| vector(*normal), DVec3::ZERO)
                    .normalize_or(face)
            });
            let color = triangles.colors.get(index).copied();
            let color = color.or_else(|| {
                let (values, coloring) = triangles.values.as_ref()?;
                let value = Corners::of(values, corners)?.mix(weights, |value| *value, 0.0);
                Some(coloring.color(value))
            });
            let color = color.or_else(|| {
                let mixed = colors.as_ref()?.mix(weights, color_vector, glam::DVec4::ZERO);
                Some(mixed.to_array().map(|part| part.round() as u8))
            });
            surface.push(*patch, normal, color);
        }
        if surface.positions.len() as u64 * BYTES > options.max_bytes {
            return Err(context.limit(surface.positions.len() as u64 * BYTES, options.max_bytes));
        }
    }
    if surface.positions.is_empty() {
        return Err(context.field(
            "triangles",
            triangles.len(),
            None,
            "at least one that has an area",
        ));
    }
    Points::new(surface.positions, surface.attributes, *points.world_from_local())
        .map_err(|error| context.scene(error))
}

/// Attributes of a triangle's corners.
struct Corners<'a, T>([&'a T; 3]);

impl<'a, T> Corners<'a, T> {
    fn of(all: &'a [T], corners: [u32; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| all.get(corner as usize));
        Some(Self([a?, b?, c?]))
    }

    fn mix<V>(&self, weights: DVec3, value: impl Fn(&T) -> V, zero: V) -> V
    where
        V: std::ops::Add<Output = V> + std::ops::Mul<f64, Output = V>,
    {
        let weighted = self.0.iter().zip(weights.to_array());
        weighted.fold(zero, |sum, (corner, weight)| sum + value(corner) * weight)
    }
}

/// Discs made so far.
#[derive(Default)]
struct Surface {
    positions: Vec<[f32; 3]>,
    attributes: PointAttributes,
}

impl Surface {
    fn push(&mut self, patch: Patch, normal: DVec3, color: Option<[u8; 4]>) {
        let radius = patch.area.sqrt() as f32;
        // A triangle without area shows nothing.
        if !(radius.is_finite() && radius > 0.0) {
            return;
        }
        self.positions.push(patch.centroid.as_vec3().to_array());
        self.attributes.radii.push(radius);
        self.attributes.normals.push(normal.as_vec3().to_array());
        self.attributes.colors.extend(color);
    }
}

/// How small pieces become: the finest that keeps within the number allowed.
fn limit(places: &[DVec3], triangles: &[[u32; 3]]) -> Limit {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let used = triangles.iter().flatten().map(|&corner| places[corner as usize]);
    let (min, max) = used.fold(nothing, |(min, max), p| (min.min(p), max.max(p)));
    let mut limit = Limit::of_surface((max - min).length());
    let most = FREE.max(EACH * triangles.len() as f64);
    let count = |limit: Limit| {
        let pieces = |corners: &[u32; 3]| limit.patches(Piece(corners.map(|c| places[c as usize])));
        triangles.iter().map(pieces).sum::<f64>()
    };
    // The number falls at least in proportion to the length, down to one per triangle.
    while count(limit) > most {
        limit = limit.coarser();
    }
    limit
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn color_vector(color: &[u8; 4]) -> glam::DVec4 {
    glam::DVec4::from_array(color.map(f64::from))
}

#[cfg(test)]
mod tests;
