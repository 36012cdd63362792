//! The transfer function, ready for vectors.
//!
//! While the value v varies linearly from a to b, its mean extinction is `(K(b) - K(a)) / (b - a)`, K the integral
//! of the extinction. The mean of the values, weighted by extinction, is `(M(b) - M(a)) / (K(b) - K(a))`, M the
//! integral of v times the extinction (after Engel 2001, in one dimension). The colour is taken at that mean: it is
//! a visible colour even where a thin band lies between a and b and both ends are clear.

use crate::classification::ClassificationTable;
use crate::visibility::VisibleLevels;
use fearless_simd::{f32x4, f32x16, prelude::*, u32x16};

const PER_VALUE: f32 = ShadeTable::PER_VALUE;
const FIRST: f32 = ShadeTable::FIRST;
/// Cells, a power of two: indices are masked instead of checked.
const CELLS: usize = 2048;

/// Rise of the value below which the integrals' difference would lose its digits.
const FLAT: f32 = 2e-3;
/// Extinction along an interval below which its mean place would be rounding.
const NO_MATERIAL: f32 = 1e-20;
/// Optical depth below which the difference for the mean place of light would lose its digits.
const THIN: f32 = 0.1;
/// Largest position in the table: within the last cell.
const LAST_POSITION: f32 = CELLS as f32 - 0.01;
/// Largest numbers in the bits of red and green, and in those of blue.
const ELEVEN_BITS: f32 = 2047.0;
const TEN_BITS: f32 = 1023.0;

/// The transfer function, ready for vectors.
#[derive(Debug, Clone)]
pub struct ShadeTable {
    /// Per cell: K and M up to it, extinction, and the square roots of linear colour in 11, 11 and 10 bits.
    cells: Box<[[f32; 4]; CELLS]>,
    /// Values outside are invisible.
    pub hull: [f32; 2],
    /// Largest extinction.
    pub densest: f32,
    /// Whether pixels that no voxel touches are visible, all of them background.
    pub shows_background: bool,
}

/// A value's classification.
#[derive(Debug, Clone, Copy)]
pub struct ClassifiedLanes<S: Simd> {
    /// K and M, from the table's first value on.
    integrals: [f32x16<S>; 2],
    extinction: f32x16<S>,
}

/// Material between two values, the value varying linearly.
#[derive(Debug, Clone, Copy)]
pub struct Segment<S: Simd> {
    /// Mean extinction.
    pub extinction: f32x16<S>,
    /// Mean place of the material, 0 to 1.
    pub place: f32x16<S>,
    /// The value there.
    pub value: f32x16<S>,
}

impl<S: Simd> Segment<S> {
    /// Moves the place of homogeneous material to the mean place of its visible light. Material that fills the
    /// segment, of this optical depth t and transmittance, hides part of itself: its light comes on average from
    /// `1 / t - 1 / (e^t - 1)` behind its beginning. `ends`: values at both ends.
    #[inline(always)]
    pub fn move_forward(
        &mut self,
        simd: S,
        [from, to]: [f32x16<S>; 2],
        (optical_depth, through): (f32x16<S>, f32x16<S>),
    ) {
        let thin = optical_depth.simd_lt(splat(simd, THIN));
        let thick = thin.select(splat(simd, 1.0), optical_depth);
        let opacity = thin.select(splat(simd, 1.0), 1.0 - through);
        let mean = thin.select(
            0.5 - optical_depth * (1.0 / 12.0),
            1.0 / thick - through / opacity,
        );
        self.place *= mean * 2.0;
        self.value = (to - from) * self.place + from;
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

/// A value's classification, of one pixel.
#[derive(Debug, Clone, Copy)]
pub struct ClassifiedValue {
    /// K and M, from the table's first value on.
    integrals: [f32; 2],
    /// Extinction, per world length.
    pub extinction: f32,
}

/// Material between two values of one pixel; a scalar [`Segment`].
#[derive(Debug, Clone, Copy)]
pub struct PixelSegment {
    /// Mean extinction, per world length.
    pub extinction: f32,
    /// Mean place of the material, 0 to 1.
    pub place: f32,
}

impl PixelSegment {
    /// Material between two values, given their classification.
    pub fn between([from, to]: [f32; 2], [a, b]: [&ClassifiedValue; 2]) -> Self {
        let rise = to - from;
        let [material, moment] = [b.integrals[0] - a.integrals[0], b.integrals[1] - a.integrals[1]];
        let flat = rise.abs() < FLAT;
        let extinction = if flat {
            (a.extinction + b.extinction) * 0.5
        } else {
            material / rise
        };
        let place = if flat || material.abs() < NO_MATERIAL {
            0.5
        } else {
            ((moment / material - from) / rise).clamp(0.0, 1.0)
        };
        Self {
            extinction: extinction.max(0.0),
            place,
        }
    }
}

impl<S: Simd> Segment<S> {
    /// Material between sixteen pairs of values, given their classification.
    #[inline(always)]
    pub fn between(simd: S, [from, to]: [f32x16<S>; 2], [a, b]: [&ClassifiedLanes<S>; 2]) -> Self {
        let (zero, half, one) = (splat(simd, 0.0), splat(simd, 0.5), splat(simd, 1.0));
        let rise = to - from;
        let flat = rise.abs().simd_lt(splat(simd, FLAT));
        let per_rise = one / flat.select(one, rise);
        let [material, moment] = [b.integrals[0] - a.integrals[0], b.integrals[1] - a.integrals[1]];
        let extinction = flat.select((a.extinction + b.extinction) * 0.5, material * per_rise);
        let none = material.abs().simd_lt(splat(simd, NO_MATERIAL));
        let mean = moment / none.select(one, material);
        // The mean of little material is rounded: it stays between the ends.
        let place = ((mean - from) * per_rise).max(zero).min(one);
        let place = (flat | none).select(half, place);
        Self {
            extinction: extinction.max(zero),
            place,
            value: rise * place + from,
        }
    }
}

impl Default for ShadeTable {
    fn default() -> Self {
        Self {
            cells: Box::new([[0.0; 4]; CELLS]),
            hull: [f32::INFINITY; 2],
            densest: 0.0,
            shows_background: false,
        }
    }
}

/// A number from 0 to 1 as its square root in so many bits.
fn root(value: f32, bits: u32) -> u32 {
    (value.clamp(0.0, 1.0).sqrt() * ((1 << bits) - 1) as f32).round() as u32
}

impl ShadeTable {
    /// Cells per normalised value.
    pub const PER_VALUE: f32 = 1024.0;
    /// Value at which the first cell begins.
    pub const FIRST: f32 = -0.25;

    /// Sets another transfer function, with its visible levels and the field's background.
    pub fn update(&mut self, table: &ClassificationTable, visible: &VisibleLevels, background: f32) {
        let (mut material, mut moment) = (0.0f64, 0.0f64);
        let node = |i: usize| FIRST + i as f32 / PER_VALUE;
        for (i, cell) in self.cells.iter_mut().enumerate() {
            let [extinction, ..] = table.mean(node(i), node(i + 1));
            let middle = node(i) + 0.5 / PER_VALUE;
            let [r, g, b] = table.color(middle);
            let packed = root(r, 11) << 21 | root(g, 11) << 10 | root(b, 10);
            *cell = [material as f32, moment as f32, extinction, f32::from_bits(packed)];
            let own = f64::from(extinction / PER_VALUE);
            material += own;
            moment += own * f64::from(middle);
        }
        self.densest = self.cells.iter().fold(0.0, |most, cell| cell[2].max(most));
        self.hull = visible.hull().unwrap_or([f32::INFINITY; 2]);
        self.shows_background = visible.any(background, background);
    }

    /// Its cells: K and M up to each, extinction, and the square roots of linear colour in 11, 11 and 10 bits, in the
    /// bits of a float. Cell i begins at [`Self::FIRST`]` + i / `[`Self::PER_VALUE`].
    pub fn cells(&self) -> &[[f32; 4]] {
        &self.cells[..]
    }

    /// Positions of sixteen values in the table, in cells.
    #[inline(always)]
    fn position<S: Simd>(simd: S, value: f32x16<S>) -> f32x16<S> {
        ((value - FIRST) * PER_VALUE)
            .max(splat(simd, 0.0))
            .min(splat(simd, LAST_POSITION))
    }

    /// Columns of the cells at sixteen positions. Rows are assembled in registers: a vector load from memory just
    /// written in pieces would stall.
    #[inline(always)]
    fn columns<S: Simd>(&self, simd: S, position: f32x16<S>) -> [f32x16<S>; 4] {
        let cells: u32x16<S> = position.to_int();
        let cells = cells.as_slice();
        let a = self.four(simd, [cells[0], cells[1], cells[2], cells[3]]);
        let b = self.four(simd, [cells[4], cells[5], cells[6], cells[7]]);
        let c = self.four(simd, [cells[8], cells[9], cells[10], cells[11]]);
        let d = self.four(simd, [cells[12], cells[13], cells[14], cells[15]]);
        let (even, odd) = simd.deinterleave_f32x16(a, b);
        let (more_even, more_odd) = simd.deinterleave_f32x16(c, d);
        let (first, third) = simd.deinterleave_f32x16(even, more_even);
        let (second, fourth) = simd.deinterleave_f32x16(odd, more_odd);
        [first, second, third, fourth]
    }

    #[inline(always)]
    fn four<S: Simd>(&self, simd: S, [a, b, c, d]: [u32; 4]) -> f32x16<S> {
        let mask = CELLS - 1;
        let a = f32x4::from_slice(simd, &self.cells[a as usize & mask]);
        let b = f32x4::from_slice(simd, &self.cells[b as usize & mask]);
        let c = f32x4::from_slice(simd, &self.cells[c as usize & mask]);
        let d = f32x4::from_slice(simd, &self.cells[d as usize & mask]);
        a.combine(b).combine(c.combine(d))
    }

    /// Looks up sixteen values.
    #[inline(always)]
    pub fn classify<S: Simd>(&self, simd: S, value: f32x16<S>) -> ClassifiedLanes<S> {
        let position = Self::position(simd, value);
        let [material, moment, extinction, _] = self.columns(simd, position);
        let cell = position.floor();
        let own = (position - cell) * extinction * (1.0 / PER_VALUE);
        let middle = (cell + position) * (0.5 / PER_VALUE) + FIRST;
        ClassifiedLanes {
            integrals: [own + material, own * middle + moment],
            extinction,
        }
    }

    /// Linear colour of sixteen values.
    #[inline(always)]
    pub fn color<S: Simd>(&self, simd: S, value: f32x16<S>) -> [f32x16<S>; 3] {
        let [.., packed] = self.columns(simd, Self::position(simd, value));
        let packed: u32x16<S> = packed.bitcast();
        let (red, green, blue) = (packed >> 21, packed >> 10 & 0x7ff, packed & 0x3ff);
        let [r, g, b] = [
            red.to_float::<f32x16<S>>() * (1.0 / ELEVEN_BITS),
            green.to_float::<f32x16<S>>() * (1.0 / ELEVEN_BITS),
            blue.to_float::<f32x16<S>>() * (1.0 / TEN_BITS),
        ];
        [r * r, g * g, b * b]
    }

    /// The cell of one value, and where in the table the value is, in cells.
    #[expect(clippy::manual_clamp, reason = "not a number is in the first cell")]
    fn cell(&self, value: f32) -> (&[f32; 4], f32) {
        let position = ((value - FIRST) * PER_VALUE).max(0.0).min(LAST_POSITION);
        (&self.cells[position as usize & (CELLS - 1)], position)
    }

    /// Looks up one value.
    pub fn point(&self, value: f32) -> ClassifiedValue {
        let (&[material, moment, extinction, _], position) = self.cell(value);
        let cell = position.floor();
        let own = (position - cell) * extinction * (1.0 / PER_VALUE);
        let middle = (cell + position) * (0.5 / PER_VALUE) + FIRST;
        ClassifiedValue {
            integrals: [own + material, own * middle + moment],
            extinction,
        }
    }

    /// Linear colour of one value.
    pub fn color_of(&self, value: f32) -> [f32; 3] {
        let packed = self.cell(value).0[3].to_bits();
        let root = [
            (packed >> 21) as f32 * (1.0 / ELEVEN_BITS),
            (packed >> 10 & 0x7ff) as f32 * (1.0 / ELEVEN_BITS),
            (packed & 0x3ff) as f32 * (1.0 / TEN_BITS),
        ];
        root.map(|r| r * r)
    }
}
