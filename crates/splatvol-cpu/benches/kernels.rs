//! Pixel updates per second of the engine's splatting kernel, one thread, at every SIMD level of the machine.
//!
//! ```text
//! cargo bench -p splatvol-cpu --bench kernels
//! ```
//!
//! With `--features scalar` code without SIMD is measured as well; compiling it for release takes a quarter of an hour.
//!
//! A voxel is splatted into four interleaved sheets at once. An item is a pixel of one of them: `4 pi r^2` per
//! voxel, r the radius of its footprint. Centres are random in a tile of 64 x 64 pixels; footprints are Gaussians
//! cut at 3.4 standard deviations. The engine splats none on more than 16 blocks of 2 x 2 pixels along an edge;
//! wider ones go on coarser rasters.

use std::fmt;

use divan::Bencher;
use divan::counter::ItemsCount;
use fearless_simd::dispatch;
use splatvol_cpu::microbench::{FourSheets, levels};

const TILE: f32 = 64.0;
const SPLATS: usize = 512;
const CUT: f32 = 3.4;
const RADII: [f32; 6] = [2.0, 3.4, 4.0, 6.0, 8.0, 16.0];
const SHEETS: f32 = 4.0;

fn main() {
    divan::main();
}

/// A SIMD level and a radius.
#[derive(Clone, Copy)]
struct Case {
    level: usize,
    radius: f32,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} r={}", levels()[self.level].0, self.radius)
    }
}

fn cases() -> Vec<Case> {
    let each = |level| RADII.iter().map(move |&radius| Case { level, radius });
    (0..levels().len()).flat_map(each).collect()
}

/// Random numbers from 0 to the tile's edge (PCG, O'Neill 2014).
fn random(seed: u64) -> Vec<f32> {
    let mut state = seed;
    let next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let word = (((state >> 18) ^ state) >> 27) as u32;
        word.rotate_right((state >> 59) as u32) as f32 / u32::MAX as f32 * TILE
    };
    std::iter::repeat_with(next).take(SPLATS).collect()
}

/// Round footprints, by the kernel for those and by that for any conic.
#[divan::bench(args = cases(), consts = [false, true])]
fn four_sheets<const ELLIPSES: bool>(bencher: Bencher<'_, '_>, case: Case) {
    let (x, y) = (random(1), random(2));
    let mut sheets = FourSheets::new([&x, &y], case.radius / CUT, case.radius, ELLIPSES);
    let level = levels()[case.level].1;
    let pixels = std::f32::consts::PI * case.radius * case.radius * SHEETS * SPLATS as f32;
    bencher
        .counter(ItemsCount::new(pixels as u64))
        .bench_local(|| dispatch!(level, simd => sheets.splat(simd)));
}
