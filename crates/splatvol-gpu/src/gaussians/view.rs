//! View: Gaussians before a camera, and the keys of their depths.

use glam::DAffine3;
use splatvol_core::cloud_view::{CloudView, LowPass, PUBLISHED_LOW_PASS, PUBLISHED_NEAR, near_of_gaussians};
use splatvol_core::engine::Shot;
use splatvol_scene::Gaussians;

use crate::footprints::ViewData;

/// A cloud before the camera; page and count are left open.
pub(super) fn view(own: &Gaussians, world_from_item: &DAffine3, shot: &Shot<'_>) -> ViewData {
    let world_from_local = *world_from_item * *own.world_from_local();
    let near = near_of_gaussians(PUBLISHED_NEAR, &world_from_local);
    let camera = (shot.camera, shot.settings.size);
    let view = CloudView::new(
        &world_from_local,
        near,
        camera,
        LowPass::Added(PUBLISHED_LOW_PASS),
    );
    ViewData {
        low_pass: PUBLISHED_LOW_PASS,
        degree: own.degree(),
        is_antialiased: u32::from(own.antialiased()),
        ..ViewData::new(&view)
    }
}

/// Keys of depths: their bits, which ascend with them, less those of the smallest one that there may be. So few are left to
/// sort by: 23 where the farthest is less than twice as far as the nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct DepthKeys {
    pub first: u32,
    /// Larger than the key of any depth.
    pub unseen: u32,
}

/// Share by which depths on the device may differ from ours.
const ROUNDING: f32 = 1e-4;

impl DepthKeys {
    /// For clouds whose centres lie within these local bounds.
    pub(super) fn new<'a>(clouds: impl Iterator<Item = ([[f32; 3]; 2], &'a ViewData)>) -> Self {
        let mut nearest = f32::MAX;
        let mut farthest = 0.0_f32;
        for (bounds, view) in clouds {
            let depths = (0..8).map(|corner| {
                let along =
                    |axis: usize| bounds[corner >> axis & 1][axis] - view.eye[axis] - view.eye_rest[axis];
                (0..3).map(|axis| view.to_z[axis] * along(axis)).sum::<f32>()
            });
            let (mut low, mut high) = (f32::MAX, 0.0_f32);
            for depth in depths {
                // Whatever is no number could be anywhere.
                low = if depth.is_nan() { 0.0 } else { low.min(depth) };
                high = if depth.is_nan() { f32::MAX } else { high.max(depth) };
            }
            nearest = nearest.min((low - ROUNDING * high).max(view.near));
            farthest = farthest.max(high * (1.0 + ROUNDING));
        }
        let first = nearest.max(f32::MIN_POSITIVE).to_bits();
        let last = farthest.min(f32::MAX).to_bits();
        Self {
            first,
            unseen: last.saturating_sub(first) + 1,
        }
    }

    /// Bits that keys have at most.
    pub(super) fn bits(self) -> u32 {
        u32::BITS - self.unseen.leading_zeros()
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use splatvol_testing::Random;

    use super::{DepthKeys, ViewData};

    #[test]
    fn keys_of_depths_within_bounds_are_below_those_of_the_unseen() {
        let mut random = Random::new(11);
        for _ in 0..200 {
            let mut triple = |from, to| [0; 3].map(|_| random.range(from, to) as f32);
            let (corner, size, eye) = (triple(-9.0, 9.0), triple(0.0, 5.0), triple(-20.0, 20.0));
            let direction = triple(-1.0, 1.0);
            let bounds = [corner, std::array::from_fn(|axis| corner[axis] + size[axis])];
            let view = ViewData {
                near: 0.2,
                eye,
                to_z: direction,
                ..ViewData::zeroed()
            };
            let keys = DepthKeys::new([(bounds, &view)].into_iter());
            for _ in 0..100 {
                let depth: f32 = (0..3)
                    .map(|axis| {
                        let at = bounds[0][axis] + random.range(0.0, 1.0) as f32 * size[axis];
                        direction[axis] * (at - eye[axis])
                    })
                    .sum();
                if depth > view.near {
                    assert!(depth.to_bits() >= keys.first);
                    assert!(depth.to_bits() - keys.first < keys.unseen);
                }
            }
        }
    }

    #[test]
    fn places_that_are_no_numbers_take_all_bits() {
        let view = ViewData {
            near: 0.2,
            to_z: [0.0, 0.0, 1.0],
            ..ViewData::zeroed()
        };
        let bounds = [[f32::NEG_INFINITY; 3], [f32::INFINITY; 3]];
        assert!(DepthKeys::new([(bounds, &view)].into_iter()).bits() >= 30);
        assert_eq!(DepthKeys::new(std::iter::empty()).bits(), 1);
    }
}
