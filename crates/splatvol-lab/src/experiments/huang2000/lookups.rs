//! Cost of finding the table entries of a footprint's pixels alone: one loop per method of section 3, to separate the
//! method's share of the frame time.

use std::hint::black_box;
use std::time::Instant;

use splatvol_testing::Random;

/// Pixels along a footprint's edge, as in pictures of Table 1.
const EDGE: usize = 8;
const ENTRIES: usize = 128;
const FOOTPRINTS: usize = 4_000;
const ROUNDS: usize = 9;

/// Nanoseconds per pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lookups {
    pub linear: f64,
    pub square: f64,
    pub rlut: f64,
    pub copied: f64,
}

impl Lookups {
    /// Times all four in turns; medians.
    pub(super) fn measure() -> Self {
        let mut random = Random::new(31);
        let mut offset = || (-3.5 - random.unit()) as f32;
        let offsets: Vec<[f32; 2]> = (0..FOOTPRINTS).map(|_| [offset(), offset()]).collect();
        let table: Vec<u8> = (0..ENTRIES).map(|entry| (255 - 2 * entry) as u8).collect();
        let squares: Vec<f32> = (0..2 * EDGE).map(|at| (at as f32 - 7.5).powi(2)).collect();
        let drawn: Vec<f32> = (0..EDGE * EDGE).map(|at| (at * 2 % ENTRIES) as f32).collect();
        let mut weights = [0.0_f32; EDGE * EDGE];
        let mut nanoseconds: [Vec<f64>; 4] = Default::default();
        for _ in 0..ROUNDS {
            let times = [
                time(&offsets, |offset| linear(&table, offset, black_box(&mut weights))),
                time(&offsets, |offset| square(&table, offset, black_box(&mut weights))),
                time(&offsets, |offset| {
                    rlut(&table, &squares, offset, black_box(&mut weights));
                }),
                time(&offsets, |[scale, _]| {
                    copied(black_box(&drawn), scale, black_box(&mut weights));
                }),
            ];
            for (all, one) in nanoseconds.iter_mut().zip(times) {
                all.push(one);
            }
        }
        let [linear, square, rlut, copied] = nanoseconds.map(|mut all| {
            all.sort_by(f64::total_cmp);
            all[ROUNDS / 2]
        });
        Self {
            linear,
            square,
            rlut,
            copied,
        }
    }
}

/// Nanoseconds per pixel of a fill.
fn time(offsets: &[[f32; 2]], mut fill: impl FnMut([f32; 2])) -> f64 {
    let start = Instant::now();
    for &offset in offsets {
        fill(black_box(offset));
    }
    1e9 * start.elapsed().as_secs_f64() / (offsets.len() * EDGE * EDGE) as f64
}

#[inline(always)]
fn entry(table: &[u8], index: usize) -> f32 {
    let index = index.min(ENTRIES - 1);
    table.get(index).map_or(0.0, |&value| f32::from(value))
}

/// Squared pixels to entries; a footprint's corner lies beyond the last.
const SCALE: f32 = (ENTRIES - 1) as f32 / 16.0;

/// Section 3.1.1.
fn linear(table: &[u8], [left, top]: [f32; 2], weights: &mut [f32]) {
    for (y, row) in weights.chunks_exact_mut(EDGE).enumerate() {
        let dy = top + y as f32;
        for (x, weight) in row.iter_mut().enumerate() {
            let dx = left + x as f32;
            let position = (dx * dx + dy * dy).sqrt() * (0.25 * (ENTRIES - 1) as f32);
            *weight = entry(table, (position + 0.5) as usize);
        }
    }
}

/// Section 3.1.2: two additions in fixed point.
fn square(table: &[u8], [left, top]: [f32; 2], weights: &mut [f32]) {
    let fixed = |value: f32| (f64::from(value) * 4_294_967_296.0) as i64;
    let first_step = fixed(SCALE * (2.0 * left + 1.0));
    let step_of_step = fixed(2.0 * SCALE);
    for (y, row) in weights.chunks_exact_mut(EDGE).enumerate() {
        let dy = top + y as f32;
        let mut squared = fixed(SCALE * (left * left + dy * dy) + 0.5);
        let mut step = first_step;
        for weight in row {
            *weight = entry(table, (squared >> 32) as usize);
            squared = squared.wrapping_add(step);
            step = step.wrapping_add(step_of_step);
        }
    }
}

/// Section 3.3: squares from a table, and their sum.
fn rlut(table: &[u8], squares: &[f32], [left, top]: [f32; 2], weights: &mut [f32]) {
    let [from_x, from_y] = [left, top].map(|at| (8.5 + at) as usize);
    for (row, down) in weights.chunks_exact_mut(EDGE).zip(&squares[from_y..]) {
        for (weight, across) in row.iter_mut().zip(&squares[from_x..]) {
            *weight = entry(table, ((down + across) * SCALE + 0.5) as usize);
        }
    }
}

/// Section 3.2: values that were drawn beforehand, times the splat's height.
fn copied(drawn: &[f32], scale: f32, weights: &mut [f32]) {
    for (weight, value) in weights.iter_mut().zip(drawn) {
        *weight = value * scale;
    }
}
