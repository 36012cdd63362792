//! The engine's splatting kernel in isolation, for micro-benchmarks. Not part of the public interface.

use fearless_simd::{Level, Simd};
use splatvol_core::plan::{SplatConstants, blocks_of};

use crate::sheets::needed::Footprints;
use crate::sheets::records::{CAPACITY, Records};
use crate::sheets::ring::{Block, PITCH, Row};
use crate::sheets::sheet::{GroupShape, Lanes16};
use crate::sheets::splat::{self, Coefficient, FootprintGroup, Powers, Stencil};

/// Every SIMD level of this machine, the best first, with its name. Scalar code exists only in builds with the
/// feature `scalar`, or where the processor has no SIMD.
pub fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx512().map(|simd| ("AVX-512", simd.level())));
        levels.extend(best.as_avx2().map(|simd| ("AVX2", simd.level())));
        levels.extend(best.as_sse4_2().map(|simd| ("SSE4.2", simd.level())));
        levels.extend(best.as_sse2().map(|simd| ("SSE2", simd.level())));
    }
    #[cfg(target_arch = "aarch64")]
    levels.extend(best.as_neon().map(|simd| ("NEON", simd.level())));
    #[cfg(feature = "scalar")]
    levels.push(("scalar", Level::fallback()));
    if levels.is_empty() {
        levels.push(("baseline", best));
    }
    levels
}

/// The engine's splatting of voxels into four interleaved sheets (`sheets::splat`), in isolation.
#[derive(Debug)]
pub struct FourSheets {
    records: Box<Records>,
    shape: GroupShape,
    stencil: Box<Stencil>,
    powers: Box<Powers>,
    rows: Vec<Row>,
    constants: SplatConstants,
    blocks: usize,
    ellipses: bool,
}

impl FourSheets {
    /// Voxels at `x`, `y` pixels of a tile, as many as the engine collects; round footprints of `sigma` pixels that
    /// reach `radius` pixels far; `ellipses`: by the kernel for any conic.
    pub fn new([x, y]: [&[f32]; 2], sigma: f32, radius: f32, ellipses: bool) -> Self {
        let blocks = blocks_of([radius; 2]);
        let exponent = -0.5 * std::f32::consts::LOG2_E / (sigma * sigma);
        let lanes = |value: f32| Lanes16([value; 16]);
        let shape = GroupShape {
            depth: Lanes16(std::array::from_fn(|lane| (lane % 4) as f32 - 1.5)),
            scale: lanes(1.0),
            xx: lanes(exponent),
            xy: lanes(0.0),
            yy: lanes(exponent),
            peak: lanes(1.0),
        };
        let mut records = Box::<Records>::default();
        let apron = 2 * blocks;
        records.len = x.len().min(y.len()).min(CAPACITY);
        for (n, (x, y)) in x.iter().zip(y).take(records.len).enumerate() {
            let first = |centre: f32| (centre.floor() as usize + apron) / 2 - blocks / 2;
            let origin = |centre: f32| (2 * first(centre)) as f32 + splat::origin_point(blocks, ellipses);
            records.column[n] = first(*x) as u32;
            records.row[n] = first(*y) as u32;
            records.origin_x[n] = x + apron as f32 - origin(*x);
            records.origin_y[n] = y + apron as f32 - origin(*y);
            records.value[n] = 1.0;
        }
        Self {
            records,
            shape,
            stencil: Box::default(),
            powers: Box::default(),
            rows: vec![Row([Block::ZERO; PITCH]); PITCH],
            constants: SplatConstants {
                slope: [0.0; 2],
                principal: [0.0; 2],
                depth_exponent: -0.6,
                depth_edge: 1e-3,
                per_depth: 0.0,
            },
            blocks,
            ellipses,
        }
    }

    /// Splats all voxels once. Generic, so that only who calls it compiles it.
    #[inline(always)]
    pub fn splat<S: Simd>(&mut self, simd: S) {
        let Self {
            records,
            shape,
            stencil,
            powers,
            rows,
            constants,
            blocks,
            ellipses,
        } = self;
        let square = Footprints {
            anchor: 0.0,
            scale: 1.0,
            slope: constants.slope,
            farthest: [0.0; 2],
            cut: f32::INFINITY,
            size: *blocks,
        };
        stencil.prepare(simd, shape, &square, *ellipses);
        let records = (&**records, Coefficient);
        let rings = &mut [rows.as_mut_slice()];
        let footprints = FootprintGroup {
            constants,
            shape,
            stencil,
            size: *blocks,
            ellipses: *ellipses,
        };
        splat::splat(simd, footprints, records, powers, rings);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::dispatch;

    /// A zone's first planes meet voxels far before them, whose profiles there are far below the smallest float.
    #[test]
    fn voxels_far_from_the_sheets_add_nothing() {
        for (name, level) in levels() {
            for ellipses in [false, true] {
                let mut sheets = FourSheets::new([&[20.3; 64], &[17.6; 64]], 1.2, 4.5, ellipses);
                for (n, z) in sheets.records.z.iter_mut().enumerate() {
                    *z = -8.0 - 0.5 * n as f32;
                }
                dispatch!(level, simd => sheets.splat(simd));
                let sums = sheets.rows.iter().flat_map(|row| &row.0);
                let none = sums.flat_map(|block| block.0).all(|sum| sum == 0.0);
                assert!(none, "{name}, ellipses: {ellipses}");
            }
        }
    }
}
