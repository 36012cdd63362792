//! Light on labels at a level: the surfaces of labels among the finest samples that a voxel covers.
//!
//! ```text
//! b_j = sum_i w_ij e_i [g_i != 0] / sum_i w_ij e_i              share of surface, by weight and extinction
//! g_j = sum_i w_ij e_i g_i / sum_i w_ij e_i [g_i != 0]          mean gradient there
//! lit color_j = (1 - b_j) color_j + b_j phong(color_j, g_j)
//! ```
//!
//! `g_i` is the difference of `[f = f_i]` between the neighbours of sample i, and e its extinction. Samples within their label have
//! none, and the finest level does not light them. Mean labels have no gradient, since labels have no order.

use splatvol_scene::volume::widen;
use splatvol_scene::{SceneError, VoxelBox, with_samples};

use super::Means;
use crate::resample::Taps;
use crate::visibility::BRICK_VOXELS;

/// Mean gradient and share of surface of a brick's voxels, x fastest.
pub type Surfaces = [[f32; 4]; BRICK_VOXELS];
/// The same in steps of 1/32767, gradients as differences per finest voxel.
pub(super) type BrickSurfaces = Box<[[i16; 4]; BRICK_VOXELS]>;

const STEPS: f32 = 32_767.0;

/// Surfaces of labels in a level's visible bricks.
#[derive(Debug)]
pub(super) struct StoredSurfaces {
    bricks: Vec<BrickSurfaces>,
    /// Finest voxels per voxel of the level, along x, y, z, times a step; and a step.
    step: [f32; 4],
}

impl StoredSurfaces {
    pub(super) fn new(bricks: impl Iterator<Item = BrickSurfaces>, means: &Means<'_>) -> Self {
        let finest = means.source.grid().dims();
        let [x, y, z] = [0, 1, 2].map(|axis| finest[axis] as f32 / means.cover[axis].len() as f32);
        Self {
            bricks: bricks.collect(),
            step: [x, y, z, 1.0].map(|ratio| ratio / STEPS),
        }
    }

    pub(super) fn decode(&self, n: usize, out: &mut Surfaces) {
        for (out, stored) in out.iter_mut().zip(self.bricks[n].iter()) {
            *out = std::array::from_fn(|c| f32::from(stored[c]) * self.step[c]);
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.bricks.len() * size_of::<[[i16; 4]; BRICK_VOXELS]>()
    }
}

impl Means<'_> {
    /// Surfaces in a brick's voxels.
    pub(super) fn surfaces(&self, first: [u32; 3]) -> Result<BrickSurfaces, SceneError> {
        let mut surfaces = Box::new([[0; 4]; BRICK_VOXELS]);
        let Some(covered) = self.covered(first) else {
            return Ok(surfaces);
        };
        let dims = self.source.grid().dims();
        // With the neighbours of all samples.
        let ends: [[usize; 2]; 3] =
            std::array::from_fn(|a| [covered[a][0].saturating_sub(1), (covered[a][1] + 1).min(dims[a])]);
        let region = VoxelBox {
            first: ends.map(|[from, _]| from),
            size: ends.map(|[from, to]| to - from),
        };
        let mut memory = None;
        let block = self.source.read(region, &mut memory)?;
        with_samples!(block.samples, labels => {
            let block = LabelBlock { labels, of: block.of, dims };
            for (place, surface) in surfaces.iter_mut().enumerate() {
                if let Some(covers) = self.covers(first, place) {
                    let mean = self.surface(block, covers);
                    *surface = mean.map(|number| (number * STEPS).round() as i16);
                }
            }
        });
        Ok(surfaces)
    }

    /// Mean gradient, and share, of the surfaces among the samples that one voxel covers.
    fn surface<T: Copy + Into<f64> + PartialEq>(
        &self,
        block: LabelBlock<'_, T>,
        [xs, ys, zs]: [&Taps; 3],
    ) -> [f32; 4] {
        let (mut sum, mut all) = ([0.0f32; 4], 0.0f32);
        for (z, of_z) in zs.iter() {
            for (y, of_y) in ys.iter() {
                for (x, of_x) in xs.iter() {
                    let own = block.at([x, y, z]);
                    let Some([extinction, ..]) = self.class(widen(own)) else {
                        continue;
                    };
                    let weight = of_x * of_y * of_z * extinction;
                    all += weight;
                    let [dx, dy, dz] = block.difference([x, y, z], own);
                    if [dx, dy, dz] != [0.0; 3] {
                        let own = [dx, dy, dz, 1.0];
                        sum = std::array::from_fn(|c| sum[c] + weight * own[c]);
                    }
                }
            }
        }
        let [dx, dy, dz, surface] = sum;
        if surface <= 0.0 {
            return [0.0; 4];
        }
        [dx / surface, dy / surface, dz / surface, surface / all]
    }
}

/// Labels of a region, and the samples of the volume along x, y, z.
#[derive(Clone, Copy)]
struct LabelBlock<'a, T> {
    labels: &'a [T],
    of: VoxelBox,
    dims: [usize; 3],
}

impl<T: Copy + PartialEq> LabelBlock<'_, T> {
    #[inline(always)]
    fn at(&self, [x, y, z]: [usize; 3]) -> T {
        self.of.row(self.labels, [y, z])[x - self.of.first[0]]
    }

    /// Differences per voxel of the share of a label around its place: beyond the volume it goes on.
    #[inline(always)]
    fn difference(&self, at: [usize; 3], own: T) -> [f32; 3] {
        std::array::from_fn(|axis| {
            let share = |place: usize| {
                let mut beside = at;
                beside[axis] = place;
                f32::from(u8::from(self.at(beside) == own))
            };
            let (before, after) = (
                at[axis].saturating_sub(1),
                (at[axis] + 1).min(self.dims[axis] - 1),
            );
            match after - before {
                0 => 0.0,
                apart => (share(after) - share(before)) / apart as f32,
            }
        })
    }
}
