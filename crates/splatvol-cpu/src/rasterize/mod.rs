//! Rasterisers of Gaussian footprints for sheets of one value or of four interleaved channels per pixel.
//!
//! A splat adds `weight exp(-(xx dx^2 + 2 xy dx dy + yy dy^2) / 2)` to every pixel of its box, (dx, dy) from its centre to
//! the pixel's. All splats of a call share the conic `[xx, xy, yy]`, as all voxels of a grid do on a sheet
//! (`splatvol_core::footprint`).
//!
//! | module | footprints | per vector of pixels |
//! |---|---|---|
//! | `separable` | axes along rows and columns | one multiply-add |
//! | `small` | both, of one channel and up to 8 x 8 pixels | the same; a row is one vector wherever it begins |
//! | `ellipse` | any conic | one multiply-add and two multiplications: recurrence from row to row |
//! | `lattice` | large ones, through a coarser sheet that is interpolated by cubic B-splines | four multiply-adds per pixel and axis, whatever the number of splats |
//!
//! Splatting is bound by loads and stores of the sheet, not by arithmetic: vectors begin at multiples of their length, rows
//! lie an odd number of cache lines apart, and what a splat's rows and columns need is computed for sixteen splats before
//! any pixel is touched, since one splat's chain of dependent instructions is longer than a processor looks ahead.
//!
//! `sheets::splat` interleaves sheets instead of pixels and is faster for the footprints of volume views; these kernels have
//! no bound on the radius.

pub(crate) mod ellipse;
pub(crate) mod lattice;
mod place;
pub(crate) mod separable;
mod sheet;
mod small;

pub use place::{Footprint, Splats};
pub use sheet::Sheet;

use fearless_simd::{Level, dispatch};

/// Adds splats to a sheet, by the rasteriser that suits the footprint.
pub fn splat<const CHANNELS: usize>(
    level: Level,
    sheet: &mut Sheet<CHANNELS>,
    footprint: &Footprint,
    splats: &Splats<'_, CHANNELS>,
    scratch: &mut Scratch,
) {
    if footprint.conic[1] == 0.0 {
        dispatch!(level, simd => separable::splat(simd, sheet, footprint, splats, scratch));
    } else {
        dispatch!(level, simd => ellipse::splat(simd, sheet, footprint, splats, scratch));
    }
}

/// Memory that rasterisers use again from call to call.
#[derive(Debug, Default)]
pub struct Scratch {
    columns: sheet::Aligned,
    rows: sheet::Aligned,
}

#[cfg(test)]
mod tests;
