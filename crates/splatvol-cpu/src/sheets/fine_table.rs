//! The transfer function for analytic gradients: the nodes of [`ClassificationTable`], ready for vectors.
//!
//! While the value varies linearly from a to b, extinction and emission have the means `(K(b) - K(a)) / (b - a)`
//! and `(E(b) - E(a)) / (b - a)`, K and E their integrals. Where a and b are so close that the difference would
//! lose its digits, both vary linearly from end to end. Colour varies from one end to the other while the light is
//! attenuated, so the front counts more, by `half_step ((1 + exp(-tau)) - 2 (1 - exp(-tau)) / tau)`.

use fearless_simd::{f32x4, f32x16, mask32x16, prelude::*, u32x16};
use splatvol_core::classification::ClassificationTable;

/// Cells per normalised value, as in [`ClassificationTable`].
const PER_VALUE: f32 = ClassificationTable::CELLS_PER_VALUE as f32;
const FIRST: f32 = ClassificationTable::FIRST as f32;
/// A power of two: indices are masked instead of checked.
const CELLS: usize = ClassificationTable::CELLS;
/// Rise, in cells, below which the mean of both ends is used.
const FLAT: f32 = 2.0;
/// Optical depth below which the front's advantage is a series: the difference would cancel.
const THIN: f32 = 0.3;
/// Largest position in the table: within the last cell.
const LAST_POSITION: f32 = CELLS as f32 - 0.01;

/// At both ends of a cell: K and E; extinction and linear colour.
#[derive(Debug, Clone, Copy, Default)]
struct Cell([[[f32; 4]; 2]; 2]);

impl Cell {
    /// K and E, or extinction and colour, at a share of the way between the ends.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, part: usize, share: f32) -> f32x4<S> {
        let [a, b] = &self.0;
        let (a, b) = (
            f32x4::from_slice(simd, &a[part]),
            f32x4::from_slice(simd, &b[part]),
        );
        (b - a) * share + a
    }
}

/// The transfer function, ready for vectors.
#[derive(Debug)]
pub(crate) struct FineTable {
    cells: Box<[Cell; CELLS]>,
}

/// Values' classification.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point<S: Simd> {
    /// Position of the value in the table, cells.
    position: f32x16<S>,
    /// K and E.
    integrals: [f32x16<S>; 4],
    extinction: f32x16<S>,
    color: [f32x16<S>; 3],
}

/// Material between two values, the value varying linearly.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ColoredSegment<S: Simd> {
    /// Mean extinction.
    pub extinction: f32x16<S>,
    /// Mean place of the material, 0 to 1.
    pub place: f32x16<S>,
    /// Mean colour of the material.
    pub color: [f32x16<S>; 3],
    /// Half of the colour at the first value less that at the second.
    pub half_step: [f32x16<S>; 3],
}

/// Operands for the means between two points.
struct Mean<'a, S: Simd> {
    points: [&'a Point<S>; 2],
    is_flat: mask32x16<S>,
    per_rise: f32x16<S>,
}

impl<S: Simd> Mean<'_, S> {
    /// The mean of a channel, given the sum of its values at both ends.
    #[inline(always)]
    fn of(&self, ends: f32x16<S>, channel: usize) -> f32x16<S> {
        let [a, b] = self.points;
        let difference = b.integrals[channel] - a.integrals[channel];
        self.is_flat
            .select(ends * 0.5, difference * self.per_rise)
            .max(ends * 0.0)
    }
}

impl<S: Simd> ColoredSegment<S> {
    #[inline(always)]
    pub(crate) fn between(simd: S, [a, b]: [&Point<S>; 2]) -> Self {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let rise = b.position - a.position;
        let is_flat = rise.abs().simd_lt(f32x16::splat(simd, FLAT));
        let per_rise = PER_VALUE / is_flat.select(one, rise);
        let mean = Mean {
            points: [a, b],
            is_flat,
            per_rise,
        };
        let extinction = mean.of(a.extinction + b.extinction, 0);
        let none = extinction.simd_le(zero);
        let per_extinction = one / none.select(one, extinction);
        // Written out: closures would not be inlined here.
        let (mut color, mut half_step) = ([zero; 3], [zero; 3]);
        for c in 0..3 {
            let ends = a.extinction * a.color[c] + b.extinction * b.color[c];
            color[c] = mean.of(ends, c + 1) * per_extinction;
            half_step[c] = (a.color[c] - b.color[c]) * 0.5;
        }
        Self {
            extinction,
            place: centroid(simd, [a.extinction, b.extinction], extinction),
            color,
            half_step,
        }
    }
}

/// Centroid of the material between two ends, for an extinction that varies linearly; if that is zero at one end,
/// only the part from where it begins counts.
#[inline(always)]
fn centroid<S: Simd>(simd: S, [a, b]: [f32x16<S>; 2], mean: f32x16<S>) -> f32x16<S> {
    let (zero, half, one) = (
        f32x16::splat(simd, 0.0),
        f32x16::splat(simd, 0.5),
        f32x16::splat(simd, 1.0),
    );
    let (a_none, b_none) = (a.simd_le(zero), b.simd_le(zero));
    let sum = a + b;
    let per_sum = one / (a_none & b_none).select(one, sum);
    // With one end at zero, the sum is the other.
    let edge = (mean * 2.0 * per_sum).min(one) * (1.0 / 3.0);
    let both = (sum + b) * per_sum * (1.0 / 3.0);
    let from_zero = a_none.select(one - edge, b_none.select(edge, both));
    (a_none & b_none).select(half, from_zero)
}

/// Extra weight of the front over the back, since the front is attenuated less.
#[inline(always)]
pub(crate) fn advantage<S: Simd>(
    simd: S,
    optical_depth: f32x16<S>,
    through: f32x16<S>,
    opacity: f32x16<S>,
) -> f32x16<S> {
    let tau = optical_depth;
    let is_thin = tau.simd_lt(f32x16::splat(simd, THIN));
    let series = tau * tau * (1.0 / 6.0) * (1.0 - tau * (0.5 - tau * 0.15));
    let divisor = is_thin.select(f32x16::splat(simd, 1.0), tau);
    is_thin.select(series, 1.0 + through - opacity * 2.0 / divisor)
}

impl FineTable {
    pub(crate) fn new(table: &ClassificationTable) -> Self {
        let node = |i: usize| {
            let (integrals, [extinction, ..], [r, g, b]) = table.node(i);
            [integrals.map(|k| k as f32), [extinction, r, g, b]]
        };
        let mut cells = Box::new([Cell::default(); CELLS]);
        for (i, cell) in cells.iter_mut().enumerate() {
            *cell = Cell([node(i), node(i + 1)]);
        }
        Self { cells }
    }

    /// Looks up sixteen values.
    #[inline(always)]
    pub(crate) fn classify<S: Simd>(&self, simd: S, value: f32x16<S>) -> Point<S> {
        let (zero, last) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, LAST_POSITION));
        let position = ((value - FIRST) * PER_VALUE).max(zero).min(last);
        let share = position - position.floor();
        let cells: u32x16<S> = position.to_int();
        let (cells, share) = (cells.as_slice(), share.as_slice());
        let cell = |lane: usize| &self.cells[cells[lane] as usize & (CELLS - 1)];
        let integrals = columns(
            simd,
            #[inline(always)]
            |lane| cell(lane).at(simd, 0, share[lane]),
        );
        let [extinction, color @ ..] = columns(
            simd,
            #[inline(always)]
            |lane| cell(lane).at(simd, 1, share[lane]),
        );
        Point {
            position,
            integrals,
            extinction,
            color,
        }
    }
}

/// Four rows.
#[inline(always)]
fn four<S: Simd>(row: &impl Fn(usize) -> f32x4<S>, first: usize) -> f32x16<S> {
    let ab = row(first).combine(row(first + 1));
    ab.combine(row(first + 2).combine(row(first + 3)))
}

/// Columns of sixteen rows.
#[inline(always)]
fn columns<S: Simd>(simd: S, row: impl Fn(usize) -> f32x4<S>) -> [f32x16<S>; 4] {
    let (even, odd) = simd.deinterleave_f32x16(four(&row, 0), four(&row, 4));
    let (more_even, more_odd) = simd.deinterleave_f32x16(four(&row, 8), four(&row, 12));
    let (first, third) = simd.deinterleave_f32x16(even, more_even);
    let (second, fourth) = simd.deinterleave_f32x16(odd, more_odd);
    [first, second, third, fourth]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use splatvol_scene::{ColorPoint, OpacityPoint, TransferFunction};
    use splatvol_testing::random::Random;

    use super::*;

    /// Mean extinction and mean colours between two values.
    #[inline(always)]
    fn found<S: Simd>(simd: S, table: &FineTable, ends: [f32; 2]) -> [f32; 4] {
        let [a, b] = ends.map(|value| table.classify(simd, f32x16::splat(simd, value)));
        let segment = ColoredSegment::between(simd, [&a, &b]);
        let [r, g, b] = segment.color.map(|c| c[7]);
        [segment.extinction[7], r, g, b]
    }

    #[test]
    fn means_are_those_of_the_transfer_function() {
        let tf = TransferFunction::new(
            vec![
                ColorPoint::new(0.0, [1.0, 0.0, 0.2]),
                ColorPoint::new(1.0, [0.0, 1.0, 0.2]),
            ],
            vec![
                OpacityPoint::new(0.3, 0.0),
                OpacityPoint::new(0.4, 0.9),
                OpacityPoint::new(0.6, 0.2),
                OpacityPoint::new(0.8, 0.5),
            ],
            Some(2.0),
        )
        .unwrap();
        let table = FineTable::new(&ClassificationTable::new(&tf, [0.0, 1.0], 2.0));
        let mut random = Random::new(3);
        for _ in 0..500 {
            let from = random.range(0.0, 1.0);
            let to = from + random.range(-1.0, 1.0).powi(5) * 0.2;
            let steps = 4000;
            let (mut extinction, mut emission) = (0.0, [0.0; 3]);
            for step in 0..steps {
                let value = from + (to - from) * (f64::from(step) + 0.5) / f64::from(steps);
                let kappa = tf.extinction(value, 2.0) / f64::from(steps);
                extinction += kappa;
                let color = tf.linear_color(value);
                emission = [0, 1, 2].map(|c| emission[c] + kappa * color[c]);
            }
            let [kappa, color @ ..] =
                dispatch!(Level::new(), simd => found(simd, &table, [from as f32, to as f32]));
            assert!(
                (f64::from(kappa) - extinction).abs() < 1e-3,
                "{from} {to}: {kappa} {extinction}"
            );
            for c in 0..3 {
                let mean = if extinction > 1e-3 {
                    emission[c] / extinction
                } else {
                    continue;
                };
                assert!(
                    (f64::from(color[c]) - mean).abs() < 2e-3,
                    "{from} {to}: {color:?} {mean}"
                );
            }
        }
    }
}
