//! Turns: the order of splats.

use glam::{DVec3, Vec3};
use splatvol_core::sheets::SheetStack;
use splatvol_core::splats::{Bounds, CameraView, Chunk, SplatCloud};
use splatvol_scene::{RenderSettings, SplatCompositing, SplatSettings};

/// Meaning of a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Order {
    /// Sheets parallel to the picture; a splat's turn is the first one that its kernel reaches.
    Sheets {
        /// The sheets.
        sheets: SheetStack,
    },
    /// Ranges of depth, front to back or back to front; within one, splats are sorted.
    Depth {
        /// The ranges.
        ranges: SheetStack,
        /// Back to front.
        reversed: bool,
    },
    /// Slices of the grid, by their distance from the eye's own slice. Slices before the eye and slices behind it
    /// do not hide each other.
    Slices {
        /// The axis across the slices, 0 to 2.
        axis: usize,
        /// The eye's slice.
        eye: f32,
        /// Distance of the nearest slice from it.
        nearest: f32,
        /// Number of distances.
        count: usize,
    },
    /// All at once.
    Once,
}

impl Order {
    /// The order for a method. `corners`: of the cloud, camera space.
    pub(crate) fn new(
        settings: &RenderSettings<SplatSettings>,
        cloud: &SplatCloud,
        view: &CameraView,
        corners: &[DVec3; 8],
        reach: f32,
    ) -> Self {
        let spacing = settings.method.sheet_thickness * cloud.spacing;
        let stack = |reach: f64, spacing: f64| SheetStack::covering(corners, reach, spacing, &view.screen);
        let depth = |reversed| Self::Depth {
            ranges: stack(cloud.spacing, cloud.spacing),
            reversed,
        };
        match settings.method.compositing {
            SplatCompositing::FrontToBack => depth(false),
            SplatCompositing::BackToFront => depth(true),
            SplatCompositing::AxisSheets => Self::slices(cloud, view),
            SplatCompositing::Xray => Self::Once,
            SplatCompositing::ImageSheets(_) => Self::Sheets {
                sheets: stack(f64::from(reach), spacing),
            },
        }
    }

    /// Slices across the axis that the camera looks along most nearly.
    fn slices(cloud: &SplatCloud, view: &CameraView) -> Self {
        let local_from_camera = (view.camera_from_world * cloud.world_from_local).inverse();
        // The axis whose slices' normal is most nearly the viewing direction: the row of the inverse transpose,
        // which is what `local_from_camera` multiplies depth by, in the grid's own metric.
        let forward = view.camera_from_world.inverse().transform_vector3(DVec3::Z);
        let normals = cloud.world_from_local.matrix3.inverse().transpose();
        let facing =
            [normals.x_axis, normals.y_axis, normals.z_axis].map(|normal| normal.normalize().dot(forward));
        let axis = (0..3)
            .max_by(|&a, &b| facing[a].abs().total_cmp(&facing[b].abs()))
            .unwrap_or(2);
        let (low, high) = extent(cloud);
        let eye = if view.screen.perspective {
            local_from_camera.translation[axis].round() as f32
        } else if facing[axis] > 0.0 {
            low[axis] - 1.0
        } else {
            high[axis] + 1.0
        };
        let distances = [low[axis], high[axis]].map(|at| (at.round() - eye).abs());
        let inside = (low[axis]..=high[axis]).contains(&eye);
        let nearest = if inside {
            0.0
        } else {
            distances[0].min(distances[1])
        };
        Self::Slices {
            axis,
            eye,
            nearest,
            count: (distances[0].max(distances[1]) - nearest) as usize + 1,
        }
    }

    /// Number of turns.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Sheets { sheets, .. } => sheets.count,
            Self::Depth { ranges, .. } => ranges.count,
            Self::Slices { count, .. } => *count,
            Self::Once => 1,
        }
    }

    /// The turn of a splat at this place, in camera space and local space; `reach`: of its kernel, world length.
    #[inline(always)]
    pub(crate) fn turn(&self, camera: Vec3, local: [f32; 3], reach: f32) -> usize {
        match *self {
            Self::Sheets { sheets } => sheets
                .first_touched(f64::from(camera.z - reach))
                .min(sheets.count.saturating_sub(1)),
            Self::Depth { ranges, reversed } => range(&ranges, f64::from(camera.z), reversed),
            Self::Slices {
                axis,
                eye,
                nearest,
                count,
            } => (((local[axis].round() - eye).abs() - nearest).max(0.0) as usize).min(count - 1),
            Self::Once => 0,
        }
    }

    /// The first turn of any splat of a chunk.
    pub(crate) fn first_turn(&self, chunk: &Chunk, bounds: &Bounds) -> usize {
        let ([near, far], reach) = (bounds.depth, bounds.reach);
        match *self {
            // Computed as for the nearest splat, so that no splat's turn is before its chunk's.
            Self::Sheets { .. } => self.turn(Vec3::new(0.0, 0.0, near + reach), chunk.low, reach),
            Self::Depth { ranges, reversed } => {
                let depth = if reversed { far - reach } else { near + reach };
                // A range's end may be rounded to either side.
                range(&ranges, f64::from(depth), reversed).saturating_sub(1)
            }
            Self::Slices { axis, eye, .. } => {
                let mut nearest = chunk.low;
                nearest[axis] = eye.clamp(chunk.low[axis], chunk.high[axis]);
                self.turn(Vec3::ZERO, nearest, 0.0)
            }
            Self::Once => 0,
        }
    }
}

fn range(ranges: &SheetStack, depth: f64, reversed: bool) -> usize {
    let last = ranges.count.saturating_sub(1);
    let index = ranges.first_touched(depth).min(last);
    if reversed { last - index } else { index }
}

/// Least and greatest coordinates of a cloud, local.
pub(crate) fn extent(cloud: &SplatCloud) -> ([f32; 3], [f32; 3]) {
    let mut bounds = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for chunk in &cloud.chunks {
        for axis in 0..3 {
            bounds.0[axis] = bounds.0[axis].min(chunk.low[axis]);
            bounds.1[axis] = bounds.1[axis].max(chunk.high[axis]);
        }
    }
    if cloud.chunks.is_empty() {
        ([0.0; 3], [0.0; 3])
    } else {
        bounds
    }
}
