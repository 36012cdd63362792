//! Collects rows of any format into [`Points`]: local origin, scale of colours, omitted points.

use glam::{DAffine3, DVec3};
use splatvol_scene::{PointAttributes, Points};

use super::LoadedPoints;
use super::columns::{ALPHA, INTENSITY, NORMAL, RADIUS, RED, ROLES, Row, X};
use crate::error::Context;
use crate::{Description, IoError, ReadOptions};

/// Coordinates get an origin of their own if they are this many times as large as the cloud: otherwise 32 bits
/// would resolve less than a 10^6-th of it.
const FAR: f64 = 16.0;
/// Share of the intensities that are not brighter than white.
const WHITE: f64 = 0.995;

/// Whether colours were stored as integers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorKind {
    /// Integers: 0..255, or 0..65535 if larger ones occur.
    Integer,
    /// Floats: 0..1, or as integers if larger ones occur.
    Float,
}

/// The rows read so far.
pub(super) struct Gather {
    present: [bool; ROLES],
    positions: Vec<[f64; 3]>,
    normals: Vec<[f32; 3]>,
    /// Colours as stored, or intensities in the first component.
    colors: Vec<[f32; 4]>,
    radii: Vec<f32>,
    placeless: u64,
    max_bytes: u64,
}

impl Gather {
    /// A cloud whose rows have the roles `present`.
    pub(super) fn new(present: [bool; ROLES], options: &ReadOptions) -> Self {
        Self {
            present,
            positions: Vec::new(),
            normals: Vec::new(),
            colors: Vec::new(),
            radii: Vec::new(),
            placeless: 0,
            max_bytes: options.max_bytes,
        }
    }

    /// Refuses more points than the memory limit allows.
    pub(super) fn check_count(&self, count: u64, context: &Context<'_>) -> Result<(), IoError> {
        let bytes = count.saturating_mul(size_of::<[f64; 3]>() as u64 + 32);
        if bytes > self.max_bytes {
            return Err(context.limit(bytes, self.max_bytes));
        }
        Ok(())
    }

    /// Number of points so far.
    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// A point.
    pub(super) fn push(&mut self, row: &Row) {
        let position = [row[X], row[X + 1], row[X + 2]];
        if position.iter().any(|c| !c.is_finite()) {
            self.placeless += 1;
            return;
        }
        self.positions.push(position);
        if self.present[NORMAL] {
            let normal = [NORMAL, NORMAL + 1, NORMAL + 2].map(|role| row[role] as f32);
            let finite = normal.iter().all(|c| c.is_finite());
            self.normals.push(if finite { normal } else { [0.0; 3] });
        }
        if self.present[RED] {
            let color = [RED, RED + 1, RED + 2, ALPHA].map(|role| row[role] as f32);
            self.colors.push(color);
        } else if self.present[INTENSITY] {
            self.colors.push([row[INTENSITY] as f32, 0.0, 0.0, 0.0]);
        }
        if self.present[RADIUS] {
            self.radii.push(row[RADIUS] as f32);
        }
    }

    /// The points; `description` gets the warnings, and how the coordinates were changed.
    pub(super) fn finish(
        mut self,
        kind: ColorKind,
        mut description: Description,
        context: &Context<'_>,
    ) -> Result<LoadedPoints, IoError> {
        if self.positions.is_empty() {
            return Err(context.field("points", 0, None, "at least one point with finite coordinates"));
        }
        if self.placeless > 0 {
            let all = self.positions.len() as u64 + self.placeless;
            description.warnings.push(format!(
                "{} of {all} points have no place (their coordinates are not finite) and are left out",
                self.placeless
            ));
        }
        let colors = self.finish_colors(kind, &mut description);
        if self.radii.iter().any(|r| !(r.is_finite() && *r > 0.0)) {
            description
                .warnings
                .push("radii that are not above zero: none are used".to_owned());
            self.radii.clear();
        }
        let origin = local_origin(&self.positions);
        if origin != DVec3::ZERO {
            description.orientation = format!("{}local origin {origin}", separated(&description.orientation));
        }
        let (positions, world_from_local) = around(origin, &self.positions);
        let attributes = PointAttributes {
            colors,
            normals: self.normals,
            radii: self.radii,
        };
        let points =
            Points::new(positions, attributes, world_from_local).map_err(|error| context.scene(error))?;
        Ok(LoadedPoints {
            points,
            description,
            viewpoint: None,
        })
    }

    fn finish_colors(&mut self, kind: ColorKind, description: &mut Description) -> Vec<[u8; 4]> {
        let colors = std::mem::take(&mut self.colors);
        if !self.present[RED] {
            return greys(&colors, description);
        }
        let largest = colors.iter().flat_map(|c| &c[..3]).copied().fold(0.0, f32::max);
        let white = match kind {
            ColorKind::Float if largest <= 1.0 => 1.0,
            _ if largest <= 255.0 => 255.0,
            _ => 65_535.0,
        };
        if colors
            .iter()
            .flat_map(|c| &c[..3])
            .any(|c| !c.is_finite() || *c < 0.0 || *c > white)
        {
            description
                .warnings
                .push(format!("colours outside 0..{white} are cut off"));
        }
        description.stored_type = format!("{}colours 0..{white}", separated(&description.stored_type));
        // A conversion from float saturates, and NaN becomes 0.
        let byte = |c: f32| (c / white * 255.0).round() as u8;
        let invisible = self.present[ALPHA] && colors.iter().all(|c| c[3] == 0.0);
        if invisible {
            description
                .warnings
                .push("alpha is 0 everywhere: taken as opaque".to_owned());
        }
        let opaque = !self.present[ALPHA] || invisible;
        let alpha = |c: f32| if opaque { 255 } else { byte(c) };
        colors
            .iter()
            .map(|&[r, g, b, a]| [byte(r), byte(g), byte(b), alpha(a)])
            .collect()
    }
}

/// Grey for intensities that differ, brightest at the 99.5th percentile: scanners have no common unit.
fn greys(intensities: &[[f32; 4]], description: &mut Description) -> Vec<[u8; 4]> {
    let mut sorted: Vec<f32> = intensities
        .iter()
        .map(|c| c[0])
        .filter(|i| i.is_finite())
        .collect();
    if sorted.is_empty() {
        return Vec::new();
    }
    let rank = ((sorted.len() - 1) as f64 * WHITE).ceil() as usize;
    let (below, &mut white, above) = sorted.select_nth_unstable_by(rank, f32::total_cmp);
    let differ = below.iter().chain(&*above).any(|i| *i != white);
    if !differ || white <= 0.0 {
        return Vec::new();
    }
    description.stored_type = format!(
        "{}intensity as grey, white {white}",
        separated(&description.stored_type)
    );
    let grey = |i: f32| (i / white * 255.0).round() as u8;
    intensities
        .iter()
        .map(|c| [grey(c[0]), grey(c[0]), grey(c[0]), 255])
        .collect()
}

fn separated(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!("{text}; ")
    }
}

/// Positions in 32 bits around an origin of their own, where they lie far from zero, and the way back.
pub fn around_local_origin(positions: &[[f64; 3]]) -> (Vec<[f32; 3]>, DAffine3) {
    around(local_origin(positions), positions)
}

fn around(origin: DVec3, positions: &[[f64; 3]]) -> (Vec<[f32; 3]>, DAffine3) {
    let local = |p: &[f64; 3]| (DVec3::from_array(*p) - origin).as_vec3().to_array();
    let positions = positions.iter().map(local).collect();
    (positions, DAffine3::from_translation(origin))
}

/// The middle of coordinates that are large compared with the cloud, else zero.
fn local_origin(positions: &[[f64; 3]]) -> DVec3 {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = positions
        .iter()
        .map(|p| DVec3::from_array(*p))
        .fold(empty, |(min, max), p| (min.min(p), max.max(p)));
    let farthest = min.abs().max(max.abs()).max_element();
    if farthest > FAR * (max - min).max_element() {
        // Halved first, so that the sum cannot overflow.
        min / 2.0 + max / 2.0
    } else {
        DVec3::ZERO
    }
}
