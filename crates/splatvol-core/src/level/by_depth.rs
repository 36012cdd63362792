//! Levels by depth: several levels of a volume behind each other in one picture.
//!
//! A voxel of width h is `h f / d` pixels wide at depth d, f the scale at depth 1. Close to a large volume no level
//! suits all of it: what is near needs fine voxels, and what is far would have too many of them. Level l, whose voxels
//! are `2^l h` wide, is then shown from where they are 1.6 pixels wide to where they are 0.8, which is at
//!
//! ```text
//! d_l = f h 2^(l - bias) / FINEST
//! ```
//!
//! Half an octave before, the next level begins beside it, so that no border shows
//! ([`behind_each_other`](crate::plan::behind_each_other)). Where the scale changes less than [`CHANGE`] times, one level
//! suits all ([`Detail`](super::Detail)).

use glam::DVec3;
use splatvol_scene::{Camera, Grid, ImageSize, RenderSettings, SceneError, SheetSettings, Volume};

use super::{FINEST, Pyramid, most_halves};
use crate::plan::{Sampling, Segment, behind_each_other};
use crate::refine::finest_grid;

/// Ratio of the largest to the smallest scale of a volume from which on its levels are chosen by depth.
const CHANGE: f64 = 3.0;

/// A level, and the depth at which the next begins; infinite for the last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelUntil {
    /// 0 is the volume itself, each further one half of it.
    pub level: usize,
    /// Camera depth, world length.
    pub end: f64,
}

/// The levels of a volume with this finest grid, nearest first, `bias` octaves coarser than the picture asks; none where one is enough.
pub fn by_depth(grid: &Grid, camera: &Camera, (size, bias): (ImageSize, f64)) -> Vec<LevelUntil> {
    let screen = camera.screen_from_camera(size);
    let [near, far] = depths(grid, camera);
    if !screen.perspective || far <= CHANGE * near.max(0.0) {
        return Vec::new();
    }
    let width = screen.scale_at(1.0) * grid.mean_spacing();
    let most = most_halves(grid) as f64;
    let level_at = |depth: f64| {
        let octaves = bias + libm::log2(FINEST * depth / width);
        octaves.ceil().clamp(0.0, most) as usize
    };
    let levels = level_at(near.max(f64::MIN_POSITIVE))..=level_at(far);
    if !width.is_finite() || levels.start() == levels.end() {
        return Vec::new();
    }
    let last = *levels.end();
    let until = |level: usize| LevelUntil {
        level,
        end: match level == last {
            true => f64::INFINITY,
            false => width * libm::exp2(level as f64 - bias) / FINEST,
        },
    };
    levels.map(until).collect()
}

impl Pyramid {
    /// The parts of the rays that levels show, behind each other; none where one level is enough.
    ///
    /// # Errors
    /// Samples that cannot be read.
    pub fn segments(
        &mut self,
        volume: &Volume,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        sampling: Sampling,
    ) -> Result<Vec<Segment>, SceneError> {
        let grid = finest_grid(volume, settings);
        let levels = by_depth(&grid, camera, (settings.size, settings.method.level_bias));
        let grids = levels.iter().map(|own| self.grid(own.level));
        let grids: Vec<_> = grids.collect::<Result<_, _>>()?;
        let ends: Vec<f64> = levels.iter().map(|own| own.end).collect();
        let segments = behind_each_other(&grids, &ends, (camera, settings), sampling);
        let numbered = |segment: Segment| Segment {
            level: levels[segment.level].level,
            ..segment
        };
        Ok(segments.into_iter().flatten().map(numbered).collect())
    }
}

/// Smallest and largest depth of a grid's box.
fn depths(grid: &Grid, camera: &Camera) -> [f64; 2] {
    let camera_from_voxel = camera.camera_from_world() * grid.world_from_voxel();
    let corner = |i: usize| {
        let at = |axis: usize| (i >> axis & 1) as f64 * grid.dims()[axis] as f64 - 0.5;
        let point = DVec3::from_array(std::array::from_fn(at));
        camera_from_voxel.transform_point3(point).z
    };
    (0..8)
        .map(corner)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], depth| {
            [low.min(depth), high.max(depth)]
        })
}

#[cfg(test)]
mod tests {
    use splatvol_scene::{ImageSize, Projection};

    use super::*;

    fn levels(distance: f64, bias: f64) -> Vec<LevelUntil> {
        let grid = Grid::centred([64; 3], DVec3::ONE).unwrap();
        let camera = Camera::new(
            DVec3::new(0.0, 0.0, -distance),
            DVec3::ZERO,
            DVec3::Y,
            Projection::Perspective { fov_degrees: 60.0 },
        )
        .unwrap();
        by_depth(&grid, &camera, (ImageSize::new(16, 16).unwrap(), bias))
    }

    #[test]
    fn a_voxel_is_eight_tenths_of_a_pixel_wide_where_its_level_ends() {
        let found = levels(33.0, 0.0);
        assert!(found.len() > 2, "{found:?}");
        let scale = 8.0 / (30f64.to_radians()).tan();
        for LevelUntil { level, end } in &found[..found.len() - 1] {
            let pixels = scale * 2f64.powi(*level as i32) / end;
            assert!((pixels - FINEST).abs() < 1e-9, "{level}: {pixels}");
        }
        // An octave coarser: each level ends at half the depth.
        let coarser = levels(33.0, 1.0);
        let of = |all: &[LevelUntil], level: usize| all.iter().find(|own| own.level == level).unwrap().end;
        assert!((of(&coarser, 1) / of(&found, 1) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn far_away_one_level_is_enough() {
        assert_eq!(levels(70.0, 0.0), []);
        assert!(!levels(1.0, 0.0).is_empty(), "the eye is inside");
    }
}
