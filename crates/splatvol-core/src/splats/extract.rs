//! The cloud of a volume: only voxels that can be seen are kept, as the papers' sparse splat lists do (mueller1998
//! section 3.5, huang2000 section 1).

use glam::{DMat3, Mat3, Vec3};
use rayon::prelude::*;
use splatvol_scene::{Extraction, Grid, Volume};

use super::cloud::{Chunk, KernelShape, SplatCloud};
use crate::brick::{ActiveBrick, BLOCK, BrickGrid};
use crate::classification::ClassificationTable;
use crate::coefficients::Coefficients;

/// Inputs from which a cloud is extracted.
#[derive(Debug, Clone, Copy)]
pub struct Extract<'a> {
    /// Grid of the samples.
    pub grid: &'a Grid,
    /// The samples, normalised; no margin.
    pub samples: &'a Coefficients,
    /// Their bricks.
    pub bricks: &'a BrickGrid,
    /// Classification; only visible voxels are extracted.
    pub table: &'a ClassificationTable,
    /// Covariances.
    pub shape: KernelShape,
    /// Whether splats need gradients, for lighting or for flattening.
    pub gradients: bool,
    /// Which voxels have splats at all; `None` for all.
    pub interest: Option<Interest>,
}

/// The range of interest: `t = F(gradient, density)` of mueller1998 section 3.5, F being 1 inside a box and 0 outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interest {
    /// Least and greatest normalised value.
    density: [f32; 2],
    /// Least squared gradient of the normalised value per mean spacing; zero or less for any.
    gradient_squared: f32,
    /// From gradients per voxel to gradients per mean spacing.
    steepness_from_local: Mat3,
}

impl Interest {
    /// The range of the settings, for a volume.
    pub fn new(extraction: &Extraction, volume: &Volume) -> Self {
        let [low, high] = volume.value_range();
        let width = if high > low { high - low } else { 1.0 };
        let density = extraction
            .density
            .map_or([f32::NEG_INFINITY, f32::INFINITY], |values| {
                values.map(|value| ((value - low) / width) as f32)
            });
        let grid = volume.grid();
        let linear: DMat3 = grid.world_from_voxel().matrix3;
        Self {
            density,
            gradient_squared: extraction.gradient.powi(2) as f32,
            steepness_from_local: (linear.inverse().transpose() * grid.mean_spacing()).as_mat3(),
        }
    }

    /// Whether a voxel of this value is in the range; `gradient`, per voxel, is computed only if needed.
    #[inline]
    fn holds(&self, value: f32, gradient: impl FnOnce() -> [f32; 3]) -> bool {
        let inside = (self.density[0]..=self.density[1]).contains(&value);
        inside
            && (self.gradient_squared <= 0.0
                || (self.steepness_from_local * Vec3::from_array(gradient())).length_squared()
                    >= self.gradient_squared)
    }
}

/// Splats of one brick.
#[derive(Debug, Default)]
struct Part {
    positions: Vec<[f32; 3]>,
    payloads: Vec<[f32; 4]>,
    gradients: Vec<[f32; 3]>,
}

/// Voxels of visible values, with extinction and emission.
pub fn classified(from: &Extract<'_>) -> SplatCloud {
    let payload = |value: f32| {
        let lit = from.table.at(value);
        (lit[0] > 0.0).then_some(lit)
    };
    from.collect(&from.bricks.visible(from.table), payload)
}

/// Voxels that can contribute to visible values, with their values. `reach`: a voxel's, in voxels per axis.
pub fn unclassified(from: &Extract<'_>, reach: [f64; 3]) -> SplatCloud {
    from.collect(&from.bricks.active(from.table, reach), |value| {
        Some([value, 1.0, 0.0, 0.0])
    })
}

impl Extract<'_> {
    fn collect(
        &self,
        bricks: &[ActiveBrick],
        payload: impl Fn(f32) -> Option<[f32; 4]> + Sync,
    ) -> SplatCloud {
        let parts: Vec<Part> = bricks
            .par_iter()
            .map(|&brick| self.part(brick, &payload))
            .collect();
        let count = parts.iter().map(|part| part.positions.len()).sum();
        let mut cloud = SplatCloud {
            world_from_local: self.grid.world_from_voxel(),
            positions: Vec::with_capacity(count),
            payloads: Vec::with_capacity(count),
            gradients: Vec::with_capacity(if self.gradients { count } else { 0 }),
            shape: self.shape,
            covariances: Vec::new(),
            peaks_from: usize::MAX,
            mass: self.grid.cell_volume(),
            spacing: self.grid.mean_spacing(),
            chunks: Vec::with_capacity(parts.len()),
        };
        for mut part in parts {
            let first = cloud.len() as u32;
            cloud.chunks.extend(part.chunk(first, self.shape.sigma() as f32));
            cloud.positions.append(&mut part.positions);
            cloud.payloads.append(&mut part.payloads);
            cloud.gradients.append(&mut part.gradients);
        }
        cloud
    }

    fn part(&self, active: ActiveBrick, payload: impl Fn(f32) -> Option<[f32; 4]>) -> Part {
        let ([x0, y0, z0], [x1, y1, z1]) = self.bricks.voxel_box(active.brick as usize);
        let [nx, ny, _] = self.samples.dims;
        let mut part = Part::default();
        for z in z0..z1 {
            for y in y0..y1 {
                let blocks = active.blocks >> ((y - y0) / BLOCK * 2 + (z - z0) / BLOCK * 4);
                for x in (x0..x1).filter(|x| blocks >> ((x - x0) / BLOCK) & 1 == 1) {
                    let index = (z * ny + y) * nx + x;
                    let value = self.samples.values[index];
                    // A missing sample, NaN, has no splat.
                    if value.is_nan() {
                        continue;
                    }
                    let gradient = || self.samples.difference(index, [x, y, z]);
                    if self
                        .interest
                        .is_some_and(|interest| !interest.holds(value, gradient))
                    {
                        continue;
                    }
                    let Some(payload) = payload(value) else { continue };
                    part.positions.push([x, y, z].map(|i| i as f32));
                    part.payloads.push(payload);
                    if self.gradients {
                        part.gradients.push(gradient());
                    }
                }
            }
        }
        part
    }
}

impl Part {
    fn chunk(&self, first: u32, sigma: f32) -> Option<Chunk> {
        Chunk::of(&self.positions, first, sigma)
    }
}

impl SplatCloud {
    /// Matrix from gradients per local unit to gradients per mean spacing, in any orientation, for thresholds.
    pub(crate) fn steepness_from_local(&self) -> DMat3 {
        self.gradient_from_local(DMat3::IDENTITY) * self.spacing
    }
}
