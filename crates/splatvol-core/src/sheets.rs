//! Sheets: planes and slabs of constant camera depth that cut the volume.

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

impl SheetStack {
    /// Sheets that cover camera-space points grown by `reach` in depth. A perspective camera sees nothing nearer than
    /// half a sheet.
    pub fn covering(corners: &[DVec3], reach: f64, spacing: f64, screen: &ScreenFromCamera) -> Self {
        let (near, far) = corners
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(n, f), p| {
                (n.min(p.z), f.max(p.z))
            });
        let first = if screen.perspective {
            (near - reach).max(0.5 * spacing)
        } else {
            near - reach
        };
        let count = ((far + reach - first) / spacing).ceil().max(0.0) as usize + 1;
        Self {
            first,
            spacing,
            count: if far + reach < first { 0 } else { count },
        }
    }

    /// One slab over the whole depth of the points: X-ray.
    pub fn single(corners: &[DVec3], reach: f64, screen: &ScreenFromCamera) -> Self {
        let fine = Self::covering(corners, reach, 1e-6 * reach.max(f64::MIN_POSITIVE), screen);
        let far = corners.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max) + reach;
        Self {
            first: fine.first,
            spacing: far - fine.first,
            count: fine.count.min(1),
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
