//! Pixel updates per second of the splatting kernels, one thread, at every SIMD level of the machine.
//!
//! ```text
//! cargo bench -p splatvol-cpu --bench kernels
//! ```
//!
//! With `--features scalar` code without SIMD is measured as well; compiling it for release takes a quarter of an hour.
//!
//! An item is a pixel of a footprint's disc, `pi r^2` per splat, of all its channels; for the engine's own kernel, a pixel
//! of one of the four sheets that a voxel is splatted into at once, `4 pi r^2` per voxel. Centres are random in a tile of
//! 64 x 64 pixels; footprints are Gaussians cut at 3.4 standard deviations.

use std::fmt;

use divan::Bencher;
use divan::counter::ItemsCount;
use splatvol_cpu::kernels::{Footprint, FourSheets, Lattice, Scratch, Sheet, Splats, levels, splat};

const TILE: f32 = 64.0;
const SPLATS: usize = 512;
const CUT: f32 = 3.4;
const RADII: [f32; 6] = [2.0, 4.0, 8.0, 12.0, 16.0, 24.0];

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

fn cases_of(radii: &[f32]) -> Vec<Case> {
    let each = |level| radii.iter().map(move |&radius| Case { level, radius });
    (0..levels().len()).flat_map(each).collect()
}

fn cases() -> Vec<Case> {
    cases_of(&RADII)
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

fn items(radius: f32, sheets: f32) -> ItemsCount {
    ItemsCount::new((std::f32::consts::PI * radius * radius * sheets * SPLATS as f32) as u64)
}

/// Splats around which a sheet has room for whole footprints.
fn run<const CHANNELS: usize>(bencher: Bencher<'_, '_>, case: Case, footprint: &Footprint) {
    let apron = footprint.reach[0].ceil() + 1.0;
    let edge = (TILE + 2.0 * apron) as usize;
    let [x, y] = [1, 2].map(|seed| random(seed).iter().map(|v| v + apron).collect::<Vec<_>>());
    let splats = Splats {
        x: &x,
        y: &y,
        weights: &[[1e-3; CHANNELS]; SPLATS],
    };
    let level = levels()[case.level].1;
    let mut sheet = Sheet::<CHANNELS>::new([edge; 2]);
    let mut scratch = Scratch::default();
    bencher
        .counter(items(case.radius, 1.0))
        .bench_local(|| splat(level, &mut sheet, footprint, &splats, &mut scratch));
}

/// An ellipse that is no circle and fills the box of the radius.
fn ellipse(radius: f32) -> Footprint {
    let variance = (radius / CUT).powi(2);
    Footprint::of_covariance([variance, 0.4 * variance, variance], CUT)
}

/// Columns times rows.
#[divan::bench(args = cases(), consts = [1, 4])]
fn separable<const CHANNELS: usize>(bencher: Bencher<'_, '_>, case: Case) {
    run::<CHANNELS>(bencher, case, &Footprint::round(case.radius / CUT, case.radius));
}

/// Row recurrence of any conic's exponential; items are counted as for a disc.
#[divan::bench(args = cases(), consts = [1, 4])]
fn ellipses<const CHANNELS: usize>(bencher: Bencher<'_, '_>, case: Case) {
    run::<CHANNELS>(bencher, case, &ellipse(case.radius));
}

/// Blocks of 2 x 2 pixels along the edge of the engine's footprints.
fn blocks(radius: f32) -> usize {
    ((1.88 * radius) as usize + 2).div_ceil(2).clamp(2, 8)
}

/// The engine's footprints have eight blocks along an edge at most: a radius of 7.9 pixels.
fn engine_cases() -> Vec<Case> {
    cases_of(&[2.0, 3.4, 4.0, 6.0, 7.9])
}

/// The engine's kernel for post-classified views: a voxel into four interleaved sheets, radial.
#[divan::bench(args = engine_cases(), consts = [false, true])]
fn four_sheets<const ELLIPSES: bool>(bencher: Bencher<'_, '_>, case: Case) {
    let (x, y) = (random(1), random(2));
    let mut sheets = FourSheets::new(case.radius / CUT, (blocks(case.radius), ELLIPSES), &x, &y);
    let level = levels()[case.level].1;
    bencher
        .counter(items(case.radius, 4.0))
        .bench_local(|| sheets.splat(level));
}

/// Large footprints through a coarser lattice, interpolation of the tile included; a call splats 512.
#[divan::bench(args = cases_of(&[16.0, 24.0, 32.0, 48.0, 64.0]), consts = [1, 4])]
fn lattice<const CHANNELS: usize>(bencher: Bencher<'_, '_>, case: Case) {
    let footprint = Footprint::round(case.radius / CUT, case.radius);
    let level = levels()[case.level].1;
    let size = [TILE as usize; 2];
    let (x, y) = (random(1), random(2));
    let splats = Splats {
        x: &x,
        y: &y,
        weights: &[[1e-3; CHANNELS]; SPLATS],
    };
    let mut sheet = Sheet::<CHANNELS>::new(size);
    let mut lattice = Lattice::new(size, Lattice::<CHANNELS>::coarsest(&footprint));
    let mut scratch = Scratch::default();
    bencher.counter(items(case.radius, 1.0)).bench_local(|| {
        lattice.splat(level, &footprint, &splats, &mut scratch);
        lattice.resolve(level, &mut sheet);
    });
}
