//! Sheets: planes and slabs of constant camera depth that cut the volume.
//!
//! [`Planes`] are fixed: plane i lies at `i * spacing` of camera depth, whatever is rendered. The contents of the
//! picture decide only which of them exist. So a transfer function that hides half of the volume, or a worker that
//! has a part of it, moves no plane of the other half. [`SheetStack`] begins where its content begins.

use glam::DVec3;
use splatvol_scene::ScreenFromCamera;

/// Equally spaced depths. Sheet i is the plane at `first + i * spacing` or the slab behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetStack {
    /// Camera depth of sheet 0, world length.
    pub first: f64,
    /// Distance between sheets, world length.
    pub spacing: f64,
    /// Number of sheets.
    pub count: usize,
}

/// Largest number of sheets; where more would be needed, as for a very deep splat, their distance grows.
const MOST: f64 = 131_072.0;

impl SheetStack {
    /// Sheets that cover camera-space points grown by `reach` in depth, as far as they lie in front of the camera.
    /// A perspective camera sees nothing nearer than half a sheet. The distance is larger than `spacing` if there
    /// would be too many sheets otherwise.
    pub fn covering(corners: &[DVec3], reach: f64, spacing: f64, screen: &ScreenFromCamera) -> Self {
        let [first, last] = depths(corners, reach, 0.5 * spacing, screen);
        let spacing = spacing.max((last - first) / MOST);
        let count = if last < first {
            0
        } else {
            ((last - first) / spacing).ceil() as usize + 1
        };
        Self {
            first,
            spacing,
            count,
        }
    }

    /// Camera depth of a plane.
    pub fn plane(&self, index: usize) -> f64 {
        self.first + index as f64 * self.spacing
    }

    /// First and last depth of a slab.
    pub fn slab(&self, index: usize) -> [f64; 2] {
        [self.plane(index), self.plane(index + 1)]
    }

    /// The first sheet that something starting at `depth` can touch, as plane or as slab.
    pub fn first_touched(&self, depth: f64) -> usize {
        let position = ((depth - self.first) / self.spacing).floor().max(0.0);
        (position as usize).min(self.count)
    }
}

/// Planes at whole multiples of their spacing. Existing planes are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planes {
    /// Multiple of the spacing at which plane 0 lies.
    pub first: i64,
    /// Distance between planes, world length.
    pub spacing: f64,
    /// Number of intervals between planes, one less than the number of planes.
    pub count: usize,
}

impl Planes {
    /// Planes before, within and behind camera-space points grown by `reach` in depth, as far as they lie in front
    /// of the camera. For parallel rays they begin at the plane before depth 0, else at a depth of one spacing. The
    /// distance is larger than `spacing` if there would be too many planes otherwise.
    pub fn covering(corners: &[DVec3], reach: f64, spacing: f64, screen: &ScreenFromCamera) -> Self {
        let [low, high] = extent(corners, reach);
        let spacing = spacing.max((high - low) / MOST);
        let first = ((low / spacing).floor() as i64).max(if screen.perspective { 1 } else { -1 });
        let last = (high / spacing).ceil() as i64;
        Self {
            first,
            spacing,
            count: (last - first).max(0) as usize,
        }
    }

    /// Camera depth of a plane.
    pub fn plane(&self, index: usize) -> f64 {
        (self.first + index as i64) as f64 * self.spacing
    }

    /// The last plane at `depth` or in front of it: the first that something starting there can touch. Plane 0 if
    /// all lie behind.
    pub fn first_touched(&self, depth: f64) -> usize {
        let index = (depth / self.spacing).floor() as i64 - self.first;
        (index.max(0) as usize).min(self.count)
    }
}

/// First and last depth of points grown by `reach`, as far as they are visible from `near` on.
fn depths(corners: &[DVec3], reach: f64, near: f64, screen: &ScreenFromCamera) -> [f64; 2] {
    let [first, last] = extent(corners, reach);
    let nearest = if screen.perspective { near } else { 0.0 };
    [first.max(nearest), last]
}

/// First and last depth of points grown by `reach`.
fn extent(corners: &[DVec3], reach: f64) -> [f64; 2] {
    let z = |pick: fn(f64, f64) -> f64| corners.iter().map(|p| p.z).reduce(pick).unwrap_or(0.0);
    [z(f64::min) - reach, z(f64::max) + reach]
}
