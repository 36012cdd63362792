//! A finished sheet: one value per pixel of a tile and of two pixels around it, rows of vectors.

use fearless_simd::{f32x16, f64x8, mask32x16, prelude::*};

use super::ring::{Area, BLOCK_EDGE, Block, LANES, SheetRing};

/// Width of the border of pixels that derivatives need around a tile; even, to hold whole blocks.
pub(crate) const HALO: usize = 2;
/// Number of values behind a row that vectors may read and write.
const PADDING: usize = 64;

/// A rectangle of pixels; empty where x0 >= x1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Span {
    pub x0: usize,
    pub y0: usize,
    pub x1: usize,
    pub y1: usize,
}

impl Span {
    pub(crate) const EMPTY: Self = Self {
        x0: usize::MAX,
        y0: usize::MAX,
        x1: 0,
        y1: 0,
    };

    pub(crate) fn is_empty(&self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }

    pub(crate) fn join(self, other: Self) -> Self {
        Self {
            x0: self.x0.min(other.x0),
            y0: self.y0.min(other.y0),
            x1: self.x1.max(other.x1),
            y1: self.y1.max(other.y1),
        }
    }
}

/// Values of a sheet; zero outside `filled`.
#[derive(Debug, Default)]
pub(crate) struct Plane {
    pub values: Vec<f32>,
    pub pitch: usize,
    pub filled: Option<Span>,
}

impl Plane {
    /// Resets to `width` x `height` pixels, all zero.
    pub(crate) fn reset(&mut self, [width, height]: [usize; 2]) {
        let pitch = width.next_multiple_of(16) + PADDING;
        if pitch == self.pitch && self.values.len() == pitch * (height + 2) {
            self.clear();
            return;
        }
        self.pitch = pitch;
        self.values.clear();
        self.values.resize(pitch * (height + 2), 0.0);
        self.filled = None;
    }

    /// Zeroes the filled part.
    pub(crate) fn clear(&mut self) {
        if let Some(span) = self.filled.take() {
            for y in span.y0..span.y1 {
                self.values[y * self.pitch + span.x0..y * self.pitch + span.x1].fill(0.0);
            }
        }
    }

    /// Takes sheet `slot` out of the ring and zeroes it there. `apron`: blocks before the plane's first pixel;
    /// `size`: the plane's pixels.
    #[inline(always)]
    pub(crate) fn take<S: Simd>(
        &mut self,
        simd: S,
        ring: &mut SheetRing,
        slot: usize,
        apron: usize,
        size: [usize; 2],
    ) {
        match slot % LANES {
            0 => self.take_lane::<S, 0>(simd, ring, slot, apron, size),
            1 => self.take_lane::<S, 1>(simd, ring, slot, apron, size),
            2 => self.take_lane::<S, 2>(simd, ring, slot, apron, size),
            _ => self.take_lane::<S, 3>(simd, ring, slot, apron, size),
        }
    }

    #[inline(always)]
    fn take_lane<S: Simd, const LANE: usize>(
        &mut self,
        simd: S,
        ring: &mut SheetRing,
        slot: usize,
        apron: usize,
        size: [usize; 2],
    ) {
        self.clear();
        let touched = std::mem::replace(&mut ring.touched[slot], Area::EMPTY);
        if touched.is_empty() {
            return;
        }
        let inside = [size[0].div_ceil(BLOCK_EDGE), size[1].div_ceil(BLOCK_EDGE)];
        let rows = ring.group(slot / LANES);
        let own = mask32x16::from_bitmask(simd, 0x1111 << LANE);
        let zero = f32x16::splat(simd, 0.0);
        // Eight blocks make a vector of each row of pixels.
        let first = touched.x0.saturating_sub(apron).min(inside[0]) / 8 * 8;
        let last = touched.x1.saturating_sub(apron).min(inside[0]);
        let (y0, y1) = (touched.y0.max(apron), touched.y1.min(apron + inside[1]));
        for y in y0..y1 {
            let top = (y - apron) * BLOCK_EDGE * self.pitch;
            let mut x = first;
            while x < last {
                let Some(blocks) = rows[y].0.get(apron + x..).and_then(|row| row.first_chunk::<8>()) else {
                    break;
                };
                let (upper, lower) = take_eight::<S, LANE>(simd, blocks);
                upper.store_slice(&mut self.values[top + BLOCK_EDGE * x..][..16]);
                lower.store_slice(&mut self.values[top + self.pitch + BLOCK_EDGE * x..][..16]);
                x += 8;
            }
        }
        for row in &mut rows[touched.y0..touched.y1] {
            for block in &mut row.0[touched.x0..touched.x1] {
                // Not by a product: infinite values must go, too.
                own.select(zero, f32x16::from_slice(simd, &block.0))
                    .store_slice(&mut block.0);
            }
        }
        if first < last && y0 < y1 {
            self.filled = Some(Span {
                x0: BLOCK_EDGE * first,
                y0: BLOCK_EDGE * (y0 - apron),
                x1: BLOCK_EDGE * last.next_multiple_of(8),
                y1: BLOCK_EDGE * (y1 - apron),
            });
        }
    }
}

/// One sheet of eight neighbouring blocks, as two rows of sixteen pixels.
#[inline(always)]
fn take_eight<S: Simd, const LANE: usize>(simd: S, blocks: &[Block; 8]) -> (f32x16<S>, f32x16<S>) {
    let low =
        take_four::<S, LANE>(simd, [&blocks[0], &blocks[1], &blocks[2], &blocks[3]]).bitcast::<f64x8<S>>();
    let high =
        take_four::<S, LANE>(simd, [&blocks[4], &blocks[5], &blocks[6], &blocks[7]]).bitcast::<f64x8<S>>();
    // Pairs of pixels alternate between the two rows.
    let (upper, lower) = simd.deinterleave_f64x8(low, high);
    (upper.bitcast(), lower.bitcast())
}

/// One sheet of four blocks, block by block.
#[inline(always)]
fn take_four<S: Simd, const LANE: usize>(simd: S, blocks: [&Block; 4]) -> f32x16<S> {
    let [a, b, c, d] = [
        f32x16::from_slice(simd, &blocks[0].0),
        f32x16::from_slice(simd, &blocks[1].0),
        f32x16::from_slice(simd, &blocks[2].0),
        f32x16::from_slice(simd, &blocks[3].0),
    ];
    let (low, high) = if LANE.is_multiple_of(2) {
        (simd.unzip_low_f32x16(a, b), simd.unzip_low_f32x16(c, d))
    } else {
        (simd.unzip_high_f32x16(a, b), simd.unzip_high_f32x16(c, d))
    };
    if LANE < 2 {
        simd.unzip_low_f32x16(low, high)
    } else {
        simd.unzip_high_f32x16(low, high)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::sheets::ring::Block;

    /// Whatever a sheet held, nothing of it is left.
    #[test]
    fn infinite_values_leave_the_ring_with_their_sheet() {
        let mut ring = SheetRing::default();
        ring.reset(16, 1);
        let area = Area {
            x0: 2,
            y0: 2,
            x1: 6,
            y1: 5,
        };
        for slot in 0..LANES {
            for (i, value) in [f32::NAN, f32::INFINITY, -2.0].into_iter().enumerate() {
                ring.rows[2 + i].0[3].0[slot] = value;
            }
            ring.touched[slot] = area;
        }
        let mut plane = Plane::default();
        plane.reset([32, 16]);
        for slot in 0..LANES {
            dispatch!(Level::new(), simd => plane.take(simd, &mut ring, slot, 0, [32, 16]));
            assert!(plane.values.iter().any(|value| value.is_nan()));
        }
        let left = |block: &Block| block.0.iter().any(|value| *value != 0.0);
        assert!(!ring.rows.iter().any(|row| row.0.iter().any(left)));
    }
}
